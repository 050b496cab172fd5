//! What a page is told when it begins.

use super::answers::{Answer, Defaults, Opened, TermInfo, Titled};
use super::hall::{Hall, Studio};
use super::messages::{Light, Open, Targets};
use super::stage::{everything, small};
use super::worker::Worker;
use crate::cpu;
use crate::design::{intent, start};
use crate::lighting::Rig;
use crate::lighting::presets::Preset;
use crate::objective::shadows::ShadowSettings;
use crate::optimize::OPTIMIZERS;
use crate::session::view;
use crate::{Error, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// Longest side of the picture in which the first lights are found, pixels.
const SEEN: u32 = 128;

/// Name of the preset that the last search has found.
pub const DESIGN: &str = "design";

impl Worker {
    /// Opens a scene, or says what there is without one.
    pub(super) fn open(&mut self, open: &Open) -> Result<()> {
        let studio = Arc::clone(self.studio());
        let held = match &open.scene {
            Some(id) => Some(studio.scenes.find(id).ok_or_else(|| {
                Error::Argument("the scene is here no more: post it again".into())
            })?),
            None => studio.scenes.first(),
        };
        let hall = held.map(|held| Hall { studio: Arc::clone(&studio), held });
        let lights = match &hall {
            Some(hall) => Light::all(&first(hall)?),
            None => Vec::new(),
        };
        let scene = hall.as_ref().map(|hall| hall.held.info.clone());
        self.enter(hall);
        let objective = &studio.settings.objective;
        self.send(Answer::Opened(Box::new(Opened {
            id: open.id,
            scene,
            defaults: Defaults {
                lights,
                weights: objective.weights,
                targets: Targets::of(objective),
                optimizer: studio.settings.optimizer.0.name.into(),
                seed: studio.settings.seed,
            },
            presets: presets(),
            terms: terms(&studio),
            optimizers: OPTIMIZERS.iter().map(|one| titled(one.name, one.title)).collect(),
            device: (&studio.device_info()).into(),
            version: env!("CARGO_PKG_VERSION").into(),
        })))
    }
}

/// The lights that a search of the settings begins with.
fn first(hall: &Hall) -> Result<Rig> {
    let settings = hall.settings();
    let scene = &hall.held.scene;
    let view = small(hall, &view(scene, &settings.view)?, SEEN)?;
    let none = ShadowSettings { on: false, ..settings.shadows };
    let maps = cpu::draw(scene, &view, &settings.objective, (&none, None))?;
    let mut genome = settings.genome()?;
    if !settings.intent.below {
        genome = genome.above_horizon(intent::up(&view))?;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
    Ok(genome.decode(&start::first(scene, &view, &maps, &genome, &mut rng)))
}

fn titled(name: &str, title: &str) -> Titled {
    Titled { name: name.into(), title: title.into() }
}

fn presets() -> Vec<Titled> {
    let presets = Preset::ALL.map(|preset| titled(preset.name(), preset.title()));
    presets.into_iter().chain([titled(DESIGN, "Design")]).collect()
}

fn terms(studio: &Studio) -> Vec<TermInfo> {
    let weights = studio.settings.objective.weights;
    let info = |(term, _): (&crate::objective::Term, f32)| TermInfo {
        name: term.name.into(),
        title: term.title.into(),
        meaning: term.meaning.into(),
        weight: weights.get(term.name).unwrap_or(0.0),
    };
    everything(&studio.settings.objective).weights.iter().map(info).collect()
}
