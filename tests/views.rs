//! One rig for many views: what it is judged by, on every device, and what it is better at.

use klieg::design::{Over, Views};
use klieg::evaluate::Evaluator;
use klieg::gpu::GpuEvaluator;
use klieg::lighting::presets::Preset;
use klieg::lighting::{Light, Population, Rig, Stand};
use klieg::objective::Quality;
use klieg::session::config::{Cameras, Settings};
use klieg::session::values::{Device, Size};
use klieg::session::{Loaded, Session, designer};
use klieg_support::gpu::{assert_valid, context};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

fn scene(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

/// A small turntable on the CPU.
fn settings(views: usize, over: Over) -> Settings {
    let mut settings = Settings { device: Device::Cpu, ..Settings::default() };
    settings.view.size = Some(Size([36, 36]));
    settings.view.azimuth = Some(20.0);
    settings.views.cameras = Some(Cameras::Turntable(views));
    settings.views.over = over;
    settings.search.generations = 30;
    settings.shadows.side = 7;
    settings
}

fn open(name: &str, settings: &Settings) -> Session {
    Session::open(&scene(name), settings.steered().unwrap()).unwrap()
}

fn designed(session: &mut Session) -> Rig {
    let genome = session.settings.genome().unwrap();
    let mut observe = |_: &_| ControlFlow::Continue(());
    designer::search(session, &genome, None, &mut observe).unwrap().rig
}

fn scores(qualities: &[Quality]) -> Vec<f32> {
    qualities.iter().map(|quality| quality.score).collect()
}

/// The session of one of the views alone.
fn alone(session: &Session, number: usize) -> Session {
    let seen = &session.views[number];
    let mut settings = Settings { views: Default::default(), ..session.settings.clone() };
    settings.lights = Settings::default().lights;
    let loaded = Loaded { scene: seen.scene.clone(), load: 0.0 };
    Session::of_view(&session.device, (loaded, seen.view.clone()), settings, Instant::now())
        .unwrap()
}

#[test]
fn the_rig_of_all_views_beats_each_view_s_own_in_the_worst_one() {
    for name in ["elephant.glb", "still-life.glb"] {
        let mut session = open(name, &settings(4, Over::Worst));
        let together = designed(&mut session);
        let (worst, _) = session.evaluator.judge(&together, Stand::World).unwrap();
        for number in 0..session.views.len() {
            let mut single = alone(&session, number);
            let own = designed(&mut single);
            let to = session.view.frame;
            let turned: Rig =
                own.iter().map(|light| light.moved(&single.view.frame, &to)).collect();
            let (of_own, each) = session.evaluator.judge(&turned, Stand::World).unwrap();
            let at_home = single.evaluator.inspect(&own).unwrap().score;
            assert!((each[number].score - at_home).abs() < 1e-3, "{each:?} {at_home}");
            assert!(
                worst.score < of_own.score,
                "{name} {number}: {} {}",
                worst.score,
                of_own.score
            );
        }
    }
}

#[test]
fn lights_of_the_world_stand_still() {
    let mut session = open("elephant.glb", &settings(3, Over::Mean));
    let rig = Preset::ThreePoint.rig();
    let near: Rig = rig
        .iter()
        .map(|light| Light { kind: klieg::lighting::LightKind::POINT, distance: 1.6, ..*light })
        .collect();
    for rig in [rig, near] {
        let (combined, each) = session.evaluator.judge(&rig, Stand::World).unwrap();
        let mut by_hand = Vec::new();
        for number in 0..session.views.len() {
            let mut single = alone(&session, number);
            let turned: Rig = rig
                .iter()
                .map(|light| light.moved(&session.view.frame, &single.view.frame))
                .collect();
            by_hand.push(single.evaluator.inspect(&turned).unwrap().score);
        }
        for (found, expected) in scores(&each).iter().zip(&by_hand) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
        let spread = by_hand.iter().fold(0f32, |most, score| most.max((score - by_hand[0]).abs()));
        assert!(spread > 0.02, "views differ: {by_hand:?}");
        let mean = each.iter().map(|quality| quality.score).sum::<f32>() / 3.0;
        assert!((combined.score - mean).abs() < 1e-6);
        // Its terms are what its F is made of.
        let weights = session.settings.objective.weights;
        let sum: f32 =
            combined.terms.iter().map(|(term, x)| weights.get(term.name).unwrap_or(0.0) * x).sum();
        assert!((sum - combined.score).abs() < 1e-5);
        // What goes with the camera is the same rig in each view's own frame.
        let (_, each) = session.evaluator.judge(&rig, Stand::Camera).unwrap();
        let own = alone(&session, 1).evaluator.inspect(&rig).unwrap().score;
        assert!((each[1].score - own).abs() < 1e-3);
    }
}

/// Some rigs of the settings' genome, and their scores over all views.
fn population(session: &Session) -> Population {
    let genome = session.settings.genome().unwrap();
    let rig = |step: usize| {
        let share = |at: usize| ((step * 7 + at * 5) % 11) as f32 / 10.0;
        let values: Vec<f32> =
            genome.bounds().iter().enumerate().map(|(at, range)| range.at(share(at))).collect();
        genome.decode(&values)
    };
    let rigs: Vec<Rig> = (0..9).map(rig).collect();
    Population::of(rigs.iter().map(Vec::as_slice)).unwrap()
}

#[test]
fn cpu_and_gpu_agree_on_many_views() {
    for (over, stand) in [(Over::Mean, Stand::World), (Over::Worst, Stand::Camera)] {
        let mut settings = settings(3, over);
        settings.views.rig = stand;
        let mut session = open("pair.glb", &settings);
        let population = population(&session);
        let mut expected = vec![0.0; population.len()];
        session.evaluator.evaluate(&population, &mut expected).unwrap();

        let context = context();
        context.share_picture_memory(3);
        let Settings { objective, shading, shadows, .. } = session.settings.clone();
        let gpu = |seen: &klieg::session::views::Seen| {
            let (scene, view) = (&seen.scene, &seen.view);
            let evaluator =
                GpuEvaluator::with_shadows(&context, scene, view, (objective, shading), &shadows);
            (Box::new(evaluator.unwrap()) as Box<dyn Evaluator>, view.frame)
        };
        let views = session.views.iter().map(gpu).collect();
        let mut views = Views::new(views, stand, over, 0).unwrap();
        let mut found = vec![0.0; population.len()];
        views.evaluate(&population, &mut found).unwrap();
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
        let qualities = views.qualities(&population).unwrap();
        assert_eq!(scores(&qualities), found);
        drop(views);
        assert_valid(&context);
    }
}

#[test]
fn designs_of_many_views_are_the_same_bits_on_any_number_of_threads() {
    let design = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut settings = settings(3, Over::Mean);
            settings.view.size = Some(Size([72, 64]));
            settings.coarse.side = 24;
            settings.search.generations = 6;
            let mut session = open("pair.glb", &settings);
            let rig = designed(&mut session);
            (session.evaluator.judge(&rig, Stand::World).unwrap(), rig)
        })
    };
    assert_eq!(design(1), design(3));
}
