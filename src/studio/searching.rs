//! A search that goes on while people watch: a few rigs at a time, so that whoever drags a light never waits for it.

use super::answers::{Answer, Fineness, Progress};
use super::convert::rig;
use super::hall::Hall;
use super::messages::{Action, Camera, Light, Look, Search as Asked};
use super::stage::Sight;
use super::worker::Worker;
use crate::cpu::CpuEvaluator;
use crate::design::{Designer, coarse, start};
use crate::lighting::genome::Genome;
use crate::lighting::{self, Population, Rig, Role};
use crate::optimize::{self, Optimizer, Setup};
use crate::scene::view::View;
use crate::session::config::Settings;
use crate::session::device::Opened;
use crate::session::{Engine, evaluator_on, focus};
use crate::{Error, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::time::{Duration, Instant};

/// Work between two looks at what is asked for.
const SLICE: Duration = Duration::from_millis(8);

/// Least time between two messages of progress.
const TELL: Duration = Duration::from_millis(100);

/// Longest side of the small pictures where the settings have none, pixels.
const SMALL: u32 = 128;

/// A search on its way.
pub struct Search {
    asked: Asked,
    designer: Designer,
    /// The place in the page's list of each light of the designer's rigs.
    order: Vec<usize>,
    engine: Engine,
    /// Whether `engine` measures small pictures.
    small: bool,
    /// Generations in all, where they are counted, and of these on small pictures.
    generations: Option<[usize; 2]>,
    /// Scores of the first rigs of the generation at work.
    scores: Vec<f32>,
    /// Rigs that are measured at once.
    portion: usize,
    running: bool,
    /// Whether small pictures tell it no more, and whole ones are not there yet.
    waiting: bool,
    /// Whether it pauses after this generation.
    step: bool,
    finished: bool,
    told: Option<Instant>,
}

impl Search {
    fn new(hall: &Hall, asked: Asked) -> Result<Self> {
        let whole = sight(&asked).view(&hall.held)?;
        let wanted = hall.wanted(&asked.look)?;
        let (genome, order, first) = genome(hall, &asked.look, &whole)?;
        let (search, generations) = optimizer(hall, &asked, &genome, first)?;
        let coarse = hall.settings().coarse;
        let longest = if coarse.side == 0 { SMALL } else { coarse.side };
        let view = whole.shrunk(&hall.held.scene, longest)?;
        let objective = coarse::objective(&wanted.objective, &whole, &view);
        let settings = Settings { objective, ..wanted };
        let engine = measuring(hall, (&asked.look.camera, &view), &settings)?;
        let first = |all: usize| (all as f64 * f64::from(coarse.share)) as usize;
        Ok(Self {
            asked,
            designer: Designer::of(genome, search)?,
            order,
            engine,
            small: true,
            generations: generations.map(|all| [all, first(all)]),
            scores: Vec::new(),
            portion: 1,
            running: false,
            waiting: false,
            step: false,
            finished: false,
            told: None,
        })
    }

    /// Number of the last request of it.
    pub fn id(&self) -> u32 {
        self.asked.id
    }

    /// The best lights in the page's order, and their score.
    fn best(&self) -> Option<(Vec<Light>, f32)> {
        let (rig, score) = self.designer.best()?;
        let mut lights = self.asked.look.lights.clone();
        for (light, &at) in rig.iter().zip(&self.order) {
            let locked = lights[at].locked;
            if !locked && light.role != Role::Scene {
                lights[at] = Light { locked, ..Light::of(light) };
            }
        }
        Some((lights, score))
    }

    /// Whether it is for what is `asked`, with its lights as they were or as the search has them by now.
    fn is_for(&self, asked: &Asked) -> bool {
        let before = &self.asked;
        let with = |lights: &Vec<Light>| Look { lights: lights.clone(), ..before.look.clone() };
        let same = asked.look == before.look
            || self.best().is_some_and(|(lights, _)| asked.look == with(&lights));
        let manner = |asked: &Asked| (asked.size, asked.optimizer.clone(), asked.seed);
        same && manner(before) == manner(asked)
    }

    /// Measures a few rigs; whether a generation is complete with them.
    fn measure(&mut self) -> Result<bool> {
        let population = self.designer.ask();
        let (lights, from) = (population.lights(), self.scores.len());
        let to = (from + self.portion).min(population.len());
        let records = population.records()[from * lights..to * lights].to_vec();
        let part = Population::of_records(lights, records)?;
        let all = population.len();
        let start = Instant::now();
        self.scores.resize(to, 0.0);
        self.engine.evaluate(&part, &mut self.scores[from..])?;
        self.portion = match start.elapsed() {
            short if short < SLICE / 2 => 2 * self.portion,
            long if long > SLICE => (self.portion / 2).max(1),
            _ => self.portion,
        };
        if to < all {
            return Ok(false);
        }
        self.designer.tell(&self.scores)?;
        self.scores.clear();
        Ok(true)
    }

    /// Whether small pictures tell no more: the search's share of them is over, or its scores differ too little.
    fn is_settled(&self, settled: f32) -> bool {
        let progress = self.designer.progress();
        let spread = progress.worst - progress.best;
        self.designer.ask().is_empty()
            || self.generations.is_none_or(|[_, first]| progress.generation >= first)
            || spread <= settled * progress.best.abs()
    }

    /// Goes on with whole pictures.
    fn refine(&mut self, engine: Engine) -> Result<()> {
        (self.engine, self.small, self.portion) = (engine, false, 1);
        self.designer.refine()
    }

    fn is_over(&self) -> bool {
        let generation = self.designer.progress().generation;
        self.designer.ask().is_empty() || self.generations.is_some_and(|[all, _]| generation >= all)
    }

    fn progress(&self) -> Progress {
        let progress = self.designer.progress();
        let (lights, best) = self.best().unwrap_or((self.asked.look.lights.clone(), f32::MAX));
        Progress {
            id: self.asked.id,
            generation: progress.generation as u32,
            evaluations: progress.evaluations as u32,
            best,
            lights,
            small: self.small,
            running: self.running,
            finished: self.finished,
        }
    }
}

fn sight(asked: &Asked) -> Sight {
    Sight { camera: asked.look.camera.clone(), size: asked.size }
}

/// The genome of the lights that are not the scene's own, the place in the page's list of each light of its rigs, and the
/// chromosome of the lights as they stand.
pub fn genome(hall: &Hall, look: &Look, view: &View) -> Result<(Genome, Vec<usize>, Vec<f32>)> {
    let lights = rig(&look.lights)?;
    let (own, searched): (Vec<usize>, Vec<usize>) =
        (0..lights.len()).partition(|&at| lights[at].role == Role::Scene);
    let of = |places: &[usize]| -> Rig { places.iter().map(|&at| lights[at]).collect() };
    let settings = hall.studio.steered(look.intent)?;
    let first = of(&searched);
    let mut genome = Genome::like(&first, &settings.lights.boxes)?;
    for (number, &at) in searched.iter().enumerate() {
        if look.lights[at].locked {
            genome = genome.hold(number, &lights[at], None)?;
        }
    }
    let genome = settings.intent.bound(genome, view)?.with_fixed(&of(&own))?;
    let first: Vec<lighting::Light> = start::matched(&genome, &first)?;
    let chromosome = genome.encode(&first);
    Ok((genome, [searched, own].concat(), chromosome))
}

/// The search, and how many generations it has, where they are counted.
fn optimizer(
    hall: &Hall,
    asked: &Asked,
    genome: &Genome,
    first: Vec<f32>,
) -> Result<(Box<dyn Optimizer>, Option<usize>)> {
    let settings = hall.settings();
    let entry = match &asked.optimizer {
        Some(name) => optimize::find(name)?,
        None => settings.optimizer.0,
    };
    let optimizers = &settings.optimizers();
    let seed = asked.seed.map_or(settings.seed, u64::from);
    let rng = ChaCha8Rng::seed_from_u64(seed);
    let setup = Setup { bounds: genome.bounds(), first, settings: optimizers, rng };
    let generations = (entry.generations)(optimizers);
    let count = generations.map_or(1, |_| settings.coarse.searches);
    let settled = settings.coarse.settled;
    Ok((optimize::side_by_side(entry.name, &setup, count, settled)?, generations))
}

/// What measures a small view as the settings have it.
fn measuring(hall: &Hall, (camera, view): (&Camera, &View), settings: &Settings) -> Result<Engine> {
    let seen = (&*hall.held.scene, view);
    let engine = evaluator_on(&Opened::Cpu, seen, settings, hall.occluders(camera, view)?)?;
    focus::wished_in_view(engine, &Opened::Cpu, seen, settings)
}

impl Worker {
    /// Does what is asked with the search.
    pub(super) fn search(&mut self, asked: Asked) -> Result<()> {
        let action = asked.action;
        let known = self.searching.take().filter(|search| match action {
            Action::Start | Action::Step => search.is_for(&asked) && !search.finished,
            Action::Pause | Action::Stop => true,
        });
        let mut search = match known {
            Some(search) => search,
            None => Search::new(&self.hall()?, asked.clone())?,
        };
        search.asked.id = asked.id;
        search.running = matches!(action, Action::Start | Action::Step);
        search.step = action == Action::Step;
        search.finished |= action == Action::Stop;
        self.report(search)
    }

    /// Whether a search wants to go on.
    pub(super) fn is_searching(&self) -> bool {
        self.searching.as_ref().is_some_and(|search| {
            search.running && !(search.waiting && self.is_coming(&sight(&search.asked)))
        })
    }

    /// Goes on with the search for a little while.
    pub(super) fn advance(&mut self) -> Result<()> {
        let Some(mut search) = self.searching.take() else { return Ok(()) };
        let start = Instant::now();
        let mut complete = false;
        while search.running && !complete && start.elapsed() < SLICE {
            complete = search.measure()?;
        }
        if !complete {
            self.searching = Some(search);
            return Ok(());
        }
        let settled = self.studio().settings.coarse.settled;
        search.waiting = false;
        if search.small && search.is_settled(settled) {
            match self.whole_engine(&search)? {
                Some(engine) => search.refine(engine)?,
                None => search.waiting = self.is_coming(&sight(&search.asked)),
            }
        }
        if search.is_over() && !search.waiting {
            search.finished = true;
        }
        if search.finished || search.step {
            search.running = false;
        }
        let early = search.told.is_some_and(|told| told.elapsed() < TELL);
        if search.running && early {
            self.searching = Some(search);
            return Ok(());
        }
        self.report(search)
    }

    /// Tells how the search stands, and keeps it.
    fn report(&mut self, mut search: Search) -> Result<()> {
        search.told = Some(Instant::now());
        let progress = search.progress();
        if let Some((lights, _)) = search.best() {
            self.design = Some(lights);
        }
        self.searching = Some(search);
        self.send(Answer::Progress(progress))
    }

    /// What measures whole pictures for a search; none while their stage is not there.
    fn whole_engine(&mut self, search: &Search) -> Result<Option<Engine>> {
        let hall = self.hall()?;
        let sight = sight(&search.asked);
        let Some(stage) = self.whole_of(&sight).filter(|stage| stage.fineness == Fineness::Full)
        else {
            return Ok(None);
        };
        let settings = hall.wanted(&search.asked.look)?;
        let (device, view) = (&hall.studio.device, stage.view.clone());
        let seen = (&*hall.held.scene, &view);
        let engine = match device {
            Opened::Vulkan(_) => evaluator_on(device, seen, &settings, None)?,
            Opened::Cpu => {
                let maps = stage.maps()?.clone();
                let evaluator =
                    CpuEvaluator::new(maps, &view, settings.objective, settings.shading)?;
                Engine::Cpu(Box::new(evaluator))
            }
        };
        focus::wished_in_view(engine, device, seen, &settings).map(Some)
    }

    /// What the last search has found.
    ///
    /// # Errors
    /// [`Error::Argument`] where there was none.
    pub(super) fn found(&self) -> Result<Vec<Light>> {
        self.design.clone().ok_or_else(|| {
            Error::Argument("no search has found anything yet: start one first".into())
        })
    }
}
