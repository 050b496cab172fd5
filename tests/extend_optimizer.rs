//! An optimiser from outside the crate, as `docs/EXTENDING.md` shows it.

use klieg::Error;
use klieg::cpu::{self, CpuEvaluator};
use klieg::design::{self, Designer, Progress, start};
use klieg::evaluate::Evaluator;
use klieg::lighting::genome::{Boxes, Genome};
use klieg::lighting::shading::Shading;
use klieg::lighting::{LightKind, Role};
use klieg::math::range::Range;
use klieg::objective::Objective;
use klieg::optimize::{Best, Optimizer, Settings, Setup};
use klieg::scene::Scene;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::view::View;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

/// Tries a step to both sides of each allele, takes the best, and halves the step where none is better.
#[derive(Debug, Clone)]
struct Compass {
    bounds: Vec<Range>,
    /// Step, as a share of each allele's range.
    step: f32,
    /// Where it stands.
    at: Vec<f32>,
    asked: Vec<Vec<f32>>,
    scores: Vec<f32>,
    best: Best,
}

impl Compass {
    const STEP: f32 = 0.25;

    fn new(bounds: &[Range], first: Vec<f32>) -> Self {
        let (bounds, asked) = (bounds.to_vec(), vec![first.clone()]);
        let (scores, best) = (Vec::new(), Best::default());
        Self { bounds, step: Self::STEP, at: first, asked, scores, best }
    }

    fn around(&self) -> Vec<Vec<f32>> {
        let step = |(allele, side): (usize, f32)| {
            let range = self.bounds[allele];
            let mut place = self.at.clone();
            place[allele] = range.nearest(place[allele] + side * self.step * range.width());
            place
        };
        (0..self.at.len()).flat_map(|allele| [(allele, -1.0), (allele, 1.0)]).map(step).collect()
    }
}

impl Optimizer for Compass {
    fn name(&self) -> &'static str {
        "compass"
    }

    fn ask(&self) -> &[Vec<f32>] {
        &self.asked
    }

    fn tell(&mut self, scores: &[f32]) {
        self.scores = scores.to_vec();
        let mut better = false;
        for (chromosome, &score) in self.asked.iter().zip(scores) {
            better |= self.best.offer(chromosome, score);
        }
        match self.best.get() {
            Some((best, _)) if better => self.at = best.to_vec(),
            _ => self.step /= 2.0,
        }
        self.asked = if self.step < 0.01 { Vec::new() } else { self.around() };
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.best.get()
    }

    fn scores(&self) -> &[f32] {
        &self.scores
    }

    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        *self = Self::new(&self.bounds, change(&self.at));
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }
}

/// The project's scene of two objects, seen small, and what measures it.
fn measured() -> (Scene, View, CpuEvaluator) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pair.glb");
    let scene = klieg::scene::load::load(&path).unwrap();
    let camera = frame(&scene, &Framing::default(), 1.0).unwrap();
    let view = View::new(&scene, camera, 48, 48).unwrap();
    let (objective, shading) = (Objective::default(), Shading::default());
    let maps = cpu::maps(cpu::visibility::draw(&scene, &view), &objective);
    let evaluator = CpuEvaluator::new(maps, &view, objective, shading).expect("maps of a view");
    (scene, view, evaluator)
}

fn evaluator() -> CpuEvaluator {
    measured().2
}

fn genome(roles: &[Role]) -> Genome {
    Genome::new(roles, LightKind::POINT, &Boxes::default()).unwrap()
}

fn compass(genome: &Genome) -> Compass {
    let first = genome.bounds().iter().map(Range::middle).collect();
    Compass::new(genome.bounds(), first)
}

#[test]
fn a_search_of_ones_own_finds_lights_in_a_run_and_in_a_designer() {
    let genome = genome(&[Role::Key, Role::Fill]);
    let mut evaluator = evaluator();
    let observe = &mut |_: &Progress| ControlFlow::Continue(());
    let mut search = compass(&genome);
    let outcome = design::run(&mut search, &genome, &mut evaluator, observe).unwrap();
    let first = outcome.history[0].best;
    assert!(outcome.score < first - 0.01, "{} {first}", outcome.score);
    assert_eq!(outcome.history.last().unwrap().best, outcome.score);

    let search = Box::new(compass(&genome));
    let mut designer = Designer::of(genome.clone(), search).unwrap();
    assert_eq!(designer.optimizer().name(), "compass");
    let last = designer.advance(&mut evaluator, usize::MAX).unwrap();
    assert_eq!(Some(&last), outcome.history.last());
    assert_eq!(designer.best(), Some((outcome.rig, outcome.score)));
    assert!(designer.ask().is_empty());

    // The scene has changed, or so it says: the search goes on from where it stands.
    designer.renew().unwrap();
    let again = designer.advance(&mut evaluator, usize::MAX).unwrap();
    assert!(again.best <= last.best && again.generation > last.generation);
}

#[test]
fn a_search_for_other_lights_or_without_questions_is_refused() {
    let (two, three) = (genome(&[Role::Key, Role::Fill]), genome(&[Role::Key; 3]));
    let observe = &mut |_: &Progress| ControlFlow::Continue(());
    let fault = design::run(&mut compass(&three), &two, &mut evaluator(), observe).unwrap_err();
    assert_eq!(fault.to_string(), "the search 'compass' asks for 15 alleles: the genome has 10");
    let fault = Designer::of(two.clone(), Box::new(compass(&three))).unwrap_err();
    assert!(matches!(fault, Error::Argument(_)));

    let mut idle = compass(&two);
    idle.asked.clear();
    let fault = design::run(&mut idle, &two, &mut evaluator(), observe).unwrap_err();
    assert!(fault.to_string().contains("'compass' has ended without a score"), "{fault}");
}

/// As the page has it.
mod in_the_crate {
    use super::Compass;
    use klieg::optimize::{Entry, Setup};

    pub const NAME: &str = "compass";

    pub(super) const ENTRY: Entry = Entry {
        name: NAME,
        title: "compass search",
        description: "Steps along the axes, halved where none is better",
        new: |Setup { bounds, first, .. }| Ok(Box::new(Compass::new(bounds, first))),
        generations: |_| None,
        words: |_| "compass search".into(),
    };
}

/// As the page has it; the best score of each way to search.
fn from_outside() -> Result<[f32; 2], Error> {
    let (scene, view, mut evaluator) = measured();
    let mut rng = ChaCha8Rng::seed_from_u64(1);

    let genome = Genome::new(&[Role::Key, Role::Fill], LightKind::POINT, &Boxes::default())?;
    let first = start::first(&scene, &view, evaluator.maps()?, &genome, &mut rng);
    let mut search = Compass::new(genome.bounds(), first.clone());
    let mut observe = |_: &Progress| ControlFlow::Continue(());
    let outcome = design::run(&mut search, &genome, &mut evaluator, &mut observe)?;

    let search = Compass::new(genome.bounds(), first);
    let mut designer = Designer::of(genome, Box::new(search))?;
    designer.advance_for(&mut evaluator, Duration::from_millis(4))?; // each frame

    Ok([outcome.score, designer.best().expect("a generation").1])
}

#[test]
fn the_page_s_search_runs_and_its_entry_makes_one() {
    let [whole, begun] = from_outside().unwrap();
    assert!(whole <= begun && begun < 1.0, "{whole} {begun}");
    let genome = genome(&[Role::Key]);
    let first = genome.bounds().iter().map(Range::middle).collect();
    let settings = &Settings::default();
    let rng = ChaCha8Rng::seed_from_u64(1);
    let entry = in_the_crate::ENTRY;
    let made = (entry.new)(Setup { bounds: genome.bounds(), first, settings, rng }).unwrap();
    assert_eq!((made.name(), made.ask().len()), (entry.name, 1));
}
