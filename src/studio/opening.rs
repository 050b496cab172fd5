//! What a page is told when it begins.

use super::answers::{Answer, Defaults, Opened, TermInfo, Titled};
use super::hall::Hall;
use super::messages::{Light, Open, Targets};
use super::stage::everything;
use super::worker::Worker;
use crate::Result;
use crate::cpu::{self, CpuEvaluator};
use crate::design::{coarse, start};
use crate::lighting::presets::Preset;
use crate::lighting::{self, Population, Rig};
use crate::objective::Objective;
use crate::objective::shadows::ShadowSettings;
use crate::optimize::OPTIMIZERS;
use crate::scene::Scene;
use crate::session::config::Settings;
use crate::session::device;
use crate::session::{Engine, focus, view};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// Longest side of the picture in which the first lights are found, pixels.
const SEEN: u32 = 128;

/// What the intensities of the first lights may be multiplied with: half stops.
const STRENGTHS: [f32; 9] = [1.0, 0.707, 0.5, 0.354, 0.25, 0.177, 0.125, 0.088, 0.0625];

/// Name of the preset that the last search has found.
pub const DESIGN: &str = "design";

impl Worker {
    /// Opens a scene, or says what there is without one.
    pub(super) fn open(&mut self, open: &Open) -> Result<()> {
        let studio = Arc::clone(self.studio());
        let held = studio.scenes.find(open.scene.as_deref())?;
        let hall = held.map(|held| Hall::new(Arc::clone(&studio), held));
        let mut settings = studio.steered(studio.settings.intent)?;
        for names in [&mut settings.focus, &mut settings.dim] {
            let scene = hall.as_ref().map(|hall| &*hall.held.scene);
            *names = scene.map_or_else(Vec::new, |scene| in_scene(scene, names));
        }
        let lights = match &hall {
            Some(hall) => Light::all(&first(hall, &settings)?),
            None => Vec::new(),
        };
        let scene = hall.as_ref().map(|hall| hall.held.info.clone());
        self.enter(hall);
        let objective = &settings.objective;
        self.send(Answer::Opened(Box::new(Opened {
            id: open.id,
            scene,
            defaults: Defaults {
                lights,
                weights: objective.weights,
                targets: Targets::of(objective),
                intent: settings.intent,
                focus: settings.focus,
                dim: settings.dim,
                optimizer: settings.optimizer.0.name.into(),
                seed: settings.seed,
            },
            presets: presets(),
            terms: terms(objective),
            optimizers: OPTIMIZERS.iter().map(|one| titled(one.name, one.title)).collect(),
            device: (&studio.device_info()).into(),
            version: env!("CARGO_PKG_VERSION").into(),
        })))
    }
}

/// The names of the objects of a scene that some names are of; others are of another scene.
fn in_scene(scene: &Scene, names: &[String]) -> Vec<String> {
    let known = |name: &String| focus::objects(scene, std::slice::from_ref(name)).ok();
    names.iter().filter_map(known).flatten().collect()
}

/// The lights that a search of the settings begins with, at the strength at which they are best.
fn first(hall: &Hall, settings: &Settings) -> Result<Rig> {
    let scene = &hall.held.scene;
    let whole = view(scene, &settings.view)?;
    let view = whole.shrunk(&hall.held.scene, SEEN)?;
    let objective = coarse::objective(&settings.objective, &whole, &view);
    let none = ShadowSettings { on: false, ..settings.shadows };
    let maps = cpu::draw(scene, &view, &objective, (&none, None))?;
    let genome = settings.intent.bound(settings.genome()?, &view)?;
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
    let rig = genome.decode(&start::first(scene, &view, &maps, &genome, &mut rng));
    let rigs: Vec<Rig> = STRENGTHS.map(|strength| scaled(&rig, strength)).to_vec();
    let population = Population::of(rigs.iter().map(Vec::as_slice))?;
    let evaluator = CpuEvaluator::new(maps, &view, objective, settings.shading)?;
    let small = Settings { objective, ..settings.clone() };
    let (whole, seen) = (Engine::Cpu(Box::new(evaluator)), (&**scene, &view));
    let mut engine = focus::wished_in_view(whole, &device::Opened::Cpu, seen, &small)?;
    let mut scores = vec![0.0; rigs.len()];
    engine.evaluate(&population, &mut scores)?;
    let best = rigs.into_iter().zip(scores).min_by(|a, b| a.1.total_cmp(&b.1));
    Ok(best.map_or(rig, |(rig, _)| rig))
}

/// The rig with all intensities multiplied.
fn scaled(rig: &[lighting::Light], strength: f32) -> Rig {
    let light = |light: &lighting::Light| lighting::Light {
        diffuse: strength * light.diffuse,
        specular: strength * light.specular,
        ..*light
    };
    rig.iter().map(light).collect()
}

fn titled(name: &str, title: &str) -> Titled {
    Titled { name: name.into(), title: title.into() }
}

fn presets() -> Vec<Titled> {
    let presets = Preset::ALL.map(|preset| titled(preset.name(), preset.title()));
    presets.into_iter().chain([titled(DESIGN, "Design")]).collect()
}

fn terms(objective: &Objective) -> Vec<TermInfo> {
    let weights = objective.weights;
    let info = |(term, _): (&crate::objective::Term, f32)| TermInfo {
        name: term.name.into(),
        title: term.title.into(),
        meaning: term.meaning.into(),
        weight: weights.get(term.name).unwrap_or(0.0),
    };
    everything(objective).weights.iter().map(info).collect()
}
