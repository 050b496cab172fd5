//! Many designs in one process: no memory, handles or time may be lost on the way. `make soak` runs it.

#![cfg(target_os = "linux")]

use klieg::cpu::{self, CpuEvaluator};
use klieg::design::{profile::NATURAL, run, start};
use klieg::evaluate::Evaluator;
use klieg::gpu::{Context, ContextOptions, GpuEvaluator};
use klieg::lighting::Population;
use klieg::objective::shadows::ShadowSettings;
use klieg::optimize::{self, Settings, Setup};
use klieg::scene::Scene;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::load::load;
use klieg::scene::view::View;
use klieg_support::common::ball;
use klieg_support::swiftshader::on_swiftshader;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Kilobytes that the heap may grow by its own ways of keeping memory.
const SLACK: i64 = 4096;

/// Kilobytes of the process in memory, and its open files.
fn taken() -> (i64, usize) {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    let kilobytes = line.trim().trim_end_matches(" kB").parse().unwrap();
    (kilobytes, std::fs::read_dir("/proc/self/fd").unwrap().count())
}

fn shadows() -> ShadowSettings {
    ShadowSettings { on: true, side: 17, ..ShadowSettings::default() }
}

fn native(scene: &Scene, view: &View) -> CpuEvaluator {
    let (objective, shading) = ((NATURAL.objective)(), (NATURAL.shading)());
    let maps = cpu::draw(scene, view, &objective, (&shadows(), None)).unwrap();
    CpuEvaluator::new(maps, view, objective, shading).unwrap()
}

fn on_device(context: &Arc<Context>, scene: &Scene, view: &View) -> GpuEvaluator {
    let both = ((NATURAL.objective)(), (NATURAL.shading)());
    GpuEvaluator::with_shadows(context, scene, view, both, &shadows()).unwrap()
}

/// A small design, from the file on.
fn design(
    path: &std::path::Path,
    seed: u64,
    make: &mut dyn FnMut(&Scene, &View) -> Box<dyn Evaluator>,
) -> f32 {
    let scene = load(path).unwrap();
    let view = View::new(&scene, frame(&scene, &Framing::default(), 1.0).unwrap(), 24, 24).unwrap();
    let mut evaluator = make(&scene, &view);
    let genome = NATURAL.genome().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let first = start::first(&scene, &view, evaluator.maps().unwrap(), &genome, &mut rng);
    let mut settings = Settings::default();
    (settings.genetic.population, settings.genetic.generations) = (6, 3);
    let setup = Setup { bounds: genome.bounds(), first, settings: &settings, rng };
    let mut search = optimize::create(NATURAL.optimizer.name, setup).unwrap();
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    run(&mut *search, &genome, &mut *evaluator, go_on).unwrap().score
}

/// Makes so many designs; all with one seed have one score.
fn soak(name: &str, designs: usize, mut make: impl FnMut(&Scene, &View) -> Box<dyn Evaluator>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.gltf");
    std::fs::write(&path, ball().to_string()).unwrap();
    let mut scores = [None; 5];
    let (mut warm, mut times) = ((0, 0), Vec::new());
    for number in 0..designs {
        if number == designs / 5 {
            warm = taken();
        }
        let begin = Instant::now();
        let score = design(&path, (number % 5) as u64, &mut |scene, view| make(scene, view));
        times.push(begin.elapsed());
        assert_eq!(*scores[number % 5].get_or_insert(score), score, "design {number}");
    }
    let (kilobytes, handles) = taken();
    // The quickest of a fifth: other processes make the machine slow at times.
    let quickest = |part: &[Duration]| part.iter().min().copied().unwrap_or_default();
    let fifth = (designs / 5).max(1);
    let (early, late) = (quickest(&times[..fifth]), quickest(&times[designs - fifth..]));
    println!(
        "{name}: {designs} designs of {early:.2?} to {late:.2?}, {:+} kB, {:+} handles",
        kilobytes - warm.0,
        handles as i64 - warm.1 as i64
    );
    assert!(kilobytes - warm.0 < SLACK && handles <= warm.1);
    // In a short run a busy machine says more than klieg does.
    assert!(designs < 1000 || late < early * 3 / 2 + Duration::from_millis(1));
}

fn designs(usual: usize) -> usize {
    std::env::var("KLIEG_SOAK").map_or(usual, |number| number.parse().expect("a number of designs"))
}

#[test]
fn designs_on_the_cpu_leave_nothing_behind() {
    soak("CPU", designs(100), |scene, view| Box::new(native(scene, view)));
}

/// On SwiftShader: lavapipe itself keeps something of each view.
#[test]
fn designs_on_a_device_leave_nothing_behind() {
    if !on_swiftshader("designs_on_a_device_leave_nothing_behind") {
        return;
    }
    let context = Context::new(&ContextOptions::default()).unwrap();
    soak("device", designs(60), |scene, view| Box::new(on_device(&context, scene, view)));
}

/// Drivers may compile a shader anew for numbers that it branches on, and keep all that they have compiled.
#[test]
fn generations_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.gltf");
    std::fs::write(&path, ball().to_string()).unwrap();
    let scene = load(&path).unwrap();
    let view = View::new(&scene, frame(&scene, &Framing::default(), 1.0).unwrap(), 64, 64).unwrap();
    let context = Context::new(&ContextOptions::default()).unwrap();
    let mut evaluator = on_device(&context, &scene, &view);
    let genome = NATURAL.genome().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut random = || {
        let chromosome: Vec<_> =
            genome.bounds().iter().map(|range| range.uniform(&mut rng)).collect();
        genome.decode(&chromosome)
    };
    let mut generation = || {
        let rigs: Vec<_> = (0..32).map(|_| random()).collect();
        let population = Population::of(rigs.iter().map(Vec::as_slice)).unwrap();
        evaluator.evaluate(&population, &mut [0.0; 32]).unwrap();
    };
    (0..10).for_each(|_| generation());
    let (warm, _) = taken();
    (0..40).for_each(|_| generation());
    let grown = taken().0 - warm;
    println!("40 generations: {grown:+} kB");
    assert!(grown < SLACK);
}
