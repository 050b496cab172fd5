//! The designer against whole runs, clocks and frames.

use super::*;
use crate::design::testing::{Hills, genome, height};
use crate::design::{self, Outcome};
use crate::lighting::genome::Boxes;
use crate::lighting::{Light, LightKind, LightRecord, Role};
use crate::optimize::start::population;
use crate::optimize::{Genetic, GeneticSettings, Heats, OPTIMIZERS, StartSettings};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::ops::ControlFlow;

fn designer(genetic: GeneticSettings, seed: u64) -> Designer {
    named("ga", genetic, seed)
}

fn named(optimizer: &str, genetic: GeneticSettings, seed: u64) -> Designer {
    let settings = Settings { genetic, ..Settings::endless() };
    Designer::new(genome(), optimizer, &settings, None, seed).unwrap()
}

/// The search of a designer with the default settings, put together by hand.
fn genetic(genome: &Genome, settings: GeneticSettings, seed: u64) -> Genetic {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let first = genome.bounds().iter().map(Range::middle).collect();
    let spread = StartSettings::default();
    let start = population(genome.bounds(), first, settings.population, &spread, &mut rng);
    Genetic::new(genome.bounds(), start, settings, rng).unwrap()
}

/// The same search in one run.
fn run(generations: usize, seed: u64) -> Outcome {
    let genome = genome();
    let settings = GeneticSettings { generations, ..Default::default() };
    let mut search = genetic(&genome, settings, seed);
    let observe = &mut |_: &Progress| ControlFlow::Continue(());
    design::run(&mut search, &genome, &mut Hills::default(), observe).unwrap()
}

/// A designer after some generations, and all that its search then holds: elites and children.
fn halfway(genome: &Genome, generations: usize, seed: u64) -> (Designer, Vec<Vec<f32>>) {
    let mut search = genetic(genome, GeneticSettings::endless(), seed);
    for _ in 0..generations {
        let rigs = Population::of(
            search
                .ask()
                .iter()
                .map(|x| genome.decode(x))
                .collect::<Vec<_>>()
                .iter()
                .map(Vec::as_slice),
        )
        .unwrap();
        search.tell(&rigs.rigs().map(height).collect::<Vec<_>>());
    }
    let all = [&search.population()[..3], search.ask()].concat();
    (Designer::of(genome.clone(), Box::new(search)).unwrap(), all)
}

/// A generation with scores that come from elsewhere.
fn answer(designer: &mut Designer) -> Progress {
    let scores: Vec<f32> = designer.ask().rigs().map(height).collect();
    designer.tell(&scores).unwrap()
}

proptest! {
    #[test]
    fn steps_make_no_difference(
        seed: u64, steps in prop::collection::vec((0usize..4, 0u8..3), 1..8),
    ) {
        let mut designer = designer(GeneticSettings::endless(), seed);
        let hills = &mut Hills::default();
        let mut history = Vec::new();
        for (generations, way) in steps {
            match way {
                0 => history.push(designer.advance(hills, generations).unwrap()),
                1 => {
                    let tick = &|| Duration::from_nanos(1);
                    history.push(designer.advance_until(hills, Duration::ZERO, tick).unwrap());
                }
                _ => history.extend((0..generations).map(|_| answer(&mut designer))),
            }
        }
        let generations = designer.progress().generation;
        prop_assume!(generations > 0);
        let whole = run(generations, seed);
        prop_assert_eq!(designer.best(), Some((whole.rig.clone(), whole.score)));
        prop_assert_eq!(whole.history.last(), Some(&designer.progress()));
        for progress in history.iter().filter(|progress| progress.generation > 0) {
            prop_assert_eq!(progress, &whole.history[progress.generation - 1]);
        }
        prop_assert_ne!(run(generations, seed ^ 1).rig, whole.rig);
    }
}

#[test]
fn a_budget_is_kept_to_within_a_generation() {
    let generations = |budget: u64, cost: fn(usize) -> Duration| {
        let mut hills = Hills { cost, ..Default::default() };
        let mut designer = designer(GeneticSettings::endless(), 0);
        let clock = hills.clock.clone();
        let budget = Duration::from_millis(budget);
        let progress = designer.advance_until(&mut hills, budget, &|| clock.get()).unwrap();
        assert_eq!(progress.generation, hills.calls);
        hills.calls
    };
    let even = |_| Duration::from_millis(10);
    let counts = [0, 5, 10, 19, 20, 45, 50].map(|budget| generations(budget, even));
    assert_eq!(counts, [1, 1, 1, 1, 2, 4, 5]);
    // One that warms up says nothing of those after it once they have been tried.
    let warming = |call| Duration::from_millis(if call == 0 { 30 } else { 5 });
    assert_eq!([59, 60].map(|budget| generations(budget, warming)), [1, 7]);
    let slowing = |call| Duration::from_millis(10u64 << call);
    let counts = [19, 20, 49, 50, 109, 110].map(|budget| generations(budget, slowing));
    assert_eq!(counts, [1, 2, 2, 3, 3, 4]);
}

#[test]
fn a_budget_is_one_of_real_time() {
    // However fast or slow the machine is, the clock has moved when a generation ends.
    let cost = |_| {
        let start = Instant::now();
        while start.elapsed().is_zero() {}
        Duration::ZERO
    };
    let mut hills = Hills { cost, ..Default::default() };
    let settings = GeneticSettings { generations: 12, ..Default::default() };
    let mut designer = designer(settings, 0);
    let short = designer.advance_for(&mut hills, Duration::ZERO).unwrap();
    assert_eq!(short.generation, 1);
    let long = designer.advance_for(&mut hills, Duration::MAX).unwrap();
    assert_eq!(long.generation, 12);
}

#[test]
fn settings_alone_end_a_search_and_it_can_be_woken() {
    let hills = &mut Hills::default();
    let settings = GeneticSettings { generations: 5, ..Default::default() };
    let mut designer = designer(settings, 2);
    assert_eq!(designer.advance(hills, 100).unwrap().generation, 5);
    assert!(designer.ask().is_empty());
    let rest = designer.progress();
    assert_eq!(designer.tell(&[]).unwrap(), rest);
    assert_eq!(designer.advance_for(hills, Duration::MAX).unwrap(), rest);
    let best = designer.best();
    designer.renew().unwrap();
    assert_eq!((designer.ask().len(), designer.best()), (30, best.clone()));
    let first = designer.advance(hills, 1).unwrap();
    assert_eq!((first.evaluations, designer.best()), (rest.evaluations + 30, best));
    assert_eq!(designer.advance(hills, 100).unwrap().generation, 10);

    let endless = GeneticSettings { population: 2, ..GeneticSettings::endless() };
    let mut designer = self::designer(endless, 2);
    assert_eq!(designer.advance(hills, 500).unwrap().generation, 500);
    let mut designer = self::designer(GeneticSettings { patience: 3, ..endless }, 2);
    let tired = designer.advance(hills, 500).unwrap().generation;
    assert!(tired < 500 && designer.ask().is_empty());
    designer.renew().unwrap();
    assert!(designer.advance(hills, 500).unwrap().generation >= tired + 3);
}

#[test]
fn a_refined_search_goes_on_with_the_best_of_several() {
    let heat = |seed| genetic(&genome(), GeneticSettings::endless(), seed).boxed();
    let mut designer =
        Designer::of(genome(), Box::new(Heats::new(vec![heat(1), heat(2)], 0.0))).unwrap();
    designer.advance(&mut Hills::default(), 3).unwrap();
    let (both, best) = (designer.ask().len(), designer.best());
    // Of searches side by side the best goes on, with all that it holds.
    designer.refine().unwrap();
    assert!(designer.ask().len() < both && designer.progress().generation == 3);
    answer(&mut designer);
    assert!(designer.best().unwrap().1 <= best.unwrap().1);
}

#[test]
fn no_score_outlives_a_change_of_the_scene() {
    let later = |renewed: bool| {
        let (mut designer, whole) = halfway(&genome(), 8, 5);
        let mut hills = Hills { base: 100.0, ..Default::default() };
        if renewed {
            designer.renew().unwrap();
            assert_eq!(designer.search.ask(), whole);
        }
        designer.advance(&mut hills, 1).unwrap().best
    };
    assert!(later(true) > 90.0);
    assert!(later(false) < 10.0);
}

/// A frame of a camera that is turned by `degrees`, with another centre and radius.
fn frame(degrees: f64, center: DVec3, radius: f64) -> Frame {
    let turn = DQuat::from_axis_angle(DVec3::new(0.2, 1.0, -0.1).normalize(), degrees.to_radians());
    let [right, up, back] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn * axis);
    Frame { center, radius, right, up, back }
}

/// Where a light stands in the world, or the direction that it shines from.
fn in_world(record: &LightRecord, frame: &Frame) -> DVec3 {
    let [x, y, z] = record.position.map(f64::from);
    let turned = frame.right * x + frame.up * y + frame.back * z;
    match record.radius2 {
        0.0 => turned,
        _ => frame.center + turned * frame.radius,
    }
}

#[test]
fn lights_stay_in_the_world_where_their_boxes_allow() {
    let from = frame(10.0, DVec3::new(1.0, 2.0, 3.0), 2.0);
    for (kind, to) in [
        (LightKind::POINT, frame(35.0, from.center, 2.0)),
        (LightKind::POINT, frame(10.0, from.center + 0.4, 2.5)),
        (LightKind::DIRECTIONAL, frame(-20.0, from.center + 0.4, 2.5)),
    ] {
        let roles = [Role::Key, Role::Fill, Role::Rim];
        let genome = Genome::new(&roles, kind, &Boxes::default()).unwrap();
        let (mut designer, before) = halfway(&genome, 3, 3);
        designer.best = designer.search.best().map(|(best, score)| (best.to_vec(), score));
        let best = designer.best().unwrap();
        designer.follow(&from, &to).unwrap();
        assert_eq!((designer.ask().len(), designer.best().unwrap().1), (30, best.1));

        let (mut kept, mut moved, mut told_apart) = (0, 0, 0);
        for (before, after) in before.iter().zip(designer.ask().rigs()) {
            for (light, now) in genome.decode(before).iter().zip(after) {
                let was = in_world(&light.record(), &from);
                let free = light.moved(&from, &to);
                let boxed = genome.encode(&[free; 3]);
                let at = roles.iter().position(|&role| role == light.role).unwrap();
                let boxed = genome.decode(&boxed)[at];
                let near = |frame: &Frame| in_world(now, frame).distance(was) < 1e-5;
                let inside = (boxed.direction() - free.direction()).length() < 1e-6
                    && (boxed.distance - free.distance).abs() < 1e-6;
                assert_eq!(near(&to), inside, "{light:?}");
                assert_eq!((now.diffuse, now.specular), (light.diffuse, light.specular));
                if inside {
                    kept += 1
                } else {
                    moved += 1
                }
                told_apart += usize::from(!near(&from));
            }
        }
        assert!(kept > 30 && moved > 2 && told_apart > 80, "{kept} {moved} {told_apart}");
        let bounds = genome.bounds();
        for individual in designer.search.ask() {
            assert!(bounds.iter().zip(individual).all(|(range, &x)| range.contains(x)));
        }
    }
}

#[test]
fn lights_that_are_not_searched_stay_in_the_world() {
    let (from, to) = (frame(10.0, DVec3::ONE, 2.0), frame(35.0, DVec3::splat(1.4), 2.5));
    let lamp = Light { role: Role::Scene, azimuth: 0.5, distance: 3.0, ..Light::default() };
    let genome = Genome::new(&[Role::Key], LightKind::POINT, &Boxes::default()).unwrap();
    let genome = genome.with_fixed(&[lamp]).unwrap();
    let mut designer = Designer::new(genome, "ga", &Settings::endless(), None, 3).unwrap();
    let place = in_world(&lamp.record(), &from);
    assert!(designer.ask().rigs().all(|rig| in_world(&rig[1], &from) == place));
    designer.follow(&from, &to).unwrap();
    assert!(designer.ask().rigs().all(|rig| in_world(&rig[1], &to).distance(place) < 1e-5));
    assert!(designer.ask().rigs().all(|rig| in_world(&rig[1], &from).distance(place) > 0.1));
}

#[test]
fn a_camera_that_stands_still_changes_nothing() {
    let frame = |degrees| frame(degrees, DVec3::ONE, 2.0);
    let follow = |to: &Frame| {
        let mut designer = designer(GeneticSettings::endless(), 4);
        let hills = &mut Hills::default();
        for _ in 0..6 {
            designer.advance(hills, 1).unwrap();
            designer.follow(&frame(5.0), to).unwrap();
        }
        (designer.best(), designer.progress())
    };
    let whole = run(6, 4);
    assert_eq!(follow(&frame(5.0)), (Some((whole.rig, whole.score)), whole.history[5]));
    let (turned, progress) = follow(&frame(6.0));
    assert_ne!(turned.unwrap().1, whole.score);
    assert_eq!(progress.evaluations, 6 * 30);
}

#[test]
fn faults_of_the_caller_are_named() {
    let mut designer = designer(GeneticSettings::endless(), 0);
    let refused = |result: Result<()>, words: &str| {
        let fault = result.unwrap_err();
        assert!(matches!(fault, Error::Argument(_)) && fault.to_string().contains(words));
    };
    refused(designer.tell(&[0.5; 29]).map(|_| ()), "29 scores for a population of 30");
    let mut scores = [0.5; 30];
    scores[7] = f32::NAN;
    refused(designer.tell(&scores).map(|_| ()), "score 7");
    let good = frame(0.0, DVec3::ZERO, 1.0);
    for bad in [
        Frame { radius: 0.0, ..good },
        Frame { center: DVec3::NAN, ..good },
        Frame { up: DVec3::INFINITY, ..good },
    ] {
        refused(designer.follow(&good, &bad), "frame");
        refused(designer.follow(&bad, &good), "frame");
    }
    assert_eq!((designer.progress().generation, designer.ask().len()), (0, 30));

    let settings = Settings::endless();
    let new =
        |first: Vec<f32>| Designer::new(genome(), "ga", &settings, Some(first), 0).map(|_| ());
    let middle: Vec<f32> = genome().bounds().iter().map(Range::middle).collect();
    new(middle.clone()).unwrap();
    refused(new(middle[1..].to_vec()), "9 alleles");
    for value in [f32::NAN, -1.0] {
        let mut first = middle.clone();
        first[4] = value;
        refused(new(first), "allele 4");
    }
    let start = StartSettings { spread: 2.0, ..Default::default() };
    let spread = Settings { start, ..settings };
    refused(Designer::new(genome(), "ga", &spread, None, 0).map(|_| ()), "start.spread");
    let unknown = Designer::new(genome(), "annealing", &settings, None, 0).map(|_| ());
    refused(unknown, "'annealing': there are ga, shade");
    // A search of another number of alleles.
    let roles = [Role::Key, Role::Fill, Role::Rim];
    let larger = Genome::new(&roles, LightKind::POINT, &Boxes::default()).unwrap();
    let search = genetic(&larger, GeneticSettings::endless(), 0);
    refused(Designer::of(genome(), Box::new(search)).map(|_| ()), "15 alleles: the genome has 10");
}

#[test]
fn any_optimizer_is_advanced_followed_and_renewed() {
    let hills = &mut Hills::default();
    let to = frame(20.0, DVec3::ONE, 2.0);
    for entry in OPTIMIZERS {
        let mut designer = named(entry.name, GeneticSettings::endless(), 3);
        assert_eq!(designer.optimizer().name(), entry.name);
        hills.base = 0.0;
        let first = designer.advance(hills, 1).unwrap();
        let last = designer.advance(hills, 300).unwrap();
        let name = entry.name;
        // A greedy descent ends on level ground; all others go on.
        assert!(last.generation == 301 || name == "greedy" && designer.ask().is_empty(), "{name}");
        assert!(last.best < first.best, "{name}");
        let (_, score) = designer.best().unwrap();
        assert_eq!(score, last.best, "{name}");

        hills.base = 100.0;
        designer.follow(&frame(5.0, DVec3::ONE, 2.0), &to).unwrap();
        assert!(!designer.ask().is_empty() && designer.best().unwrap().1 == score, "{name}");
        assert!(designer.advance(hills, 1).unwrap().best > 90.0, "{name}");
        let mut copy = designer.clone();
        assert_eq!(copy.advance(hills, 5).unwrap(), designer.advance(hills, 5).unwrap());
        designer.renew().unwrap();
        hills.base = 200.0;
        assert!(designer.advance(hills, 1).unwrap().best > 190.0, "{name}");
    }
}
