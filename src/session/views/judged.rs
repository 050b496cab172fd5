//! Evaluators of several views, which share a device and, of one scene, what casts shadows.

use super::{Seen, ViewsSettings};
use crate::Result;
use crate::cpu::subsample;
use crate::design::{Views, coarse};
use crate::gpu::PipelineKind;
use crate::math::frame::Frame;
use crate::objective::shadows::ShadowSettings;
use crate::scene::Scene;
use crate::scene::occluders::Occluders;
use crate::session::config::Settings;
use crate::session::device::Opened;
use crate::session::engine::evaluator_of;
use crate::session::{Engine, Session, evaluator_on, focus, note_coarse_shadows, sees, strokes};
use std::sync::Arc;

/// Occluders of one view, to be turned for others of the same scene.
#[derive(Default)]
pub(super) struct Casting(Option<(Arc<Scene>, Frame, Arc<Occluders>)>);

impl Casting {
    /// Those of another view, where this is of the same scene.
    pub fn turned(&self, seen: &Seen) -> Option<Arc<Occluders>> {
        let (scene, frame, occluders) = self.0.as_ref()?;
        let to = &seen.view.frame;
        Arc::ptr_eq(scene, &seen.scene).then(|| match frame == to {
            true => Arc::clone(occluders),
            false => Arc::new(occluders.turned(frame.change_to(to).turn)),
        })
    }

    /// Keeps those of a view, unless there are some of the same scene.
    pub fn keep(&mut self, seen: &Seen, occluders: Option<Arc<Occluders>>) {
        if self.0.as_ref().is_none_or(|(scene, ..)| !Arc::ptr_eq(scene, &seen.scene)) {
            let Seen { scene, view, .. } = seen;
            self.0 = occluders.map(|occluders| (Arc::clone(scene), view.frame, occluders));
        }
    }
}

/// What judges the views together, the last `fixed` lights of a rig standing in the world in any case: the one view's
/// evaluator where there is no other.
///
/// # Errors
/// [`Error::Input`] for a view that shows nothing, and what the device reports.
pub(in crate::session) fn evaluator(
    device: &Opened,
    views: &[Seen],
    settings: &Settings,
    fixed: usize,
) -> Result<Engine> {
    if let Opened::Vulkan(stored) = device {
        stored.context.share_picture_memory(views.len() as u32);
    }
    let settings = &with_shared_shadows(settings, views.len());
    let mut casting = Casting::default();
    let mut made = Vec::with_capacity(views.len());
    for seen in views {
        let Seen { scene, view, .. } = seen;
        let mut engine = evaluator_on(device, (scene, view), settings, casting.turned(seen))?;
        sees(&mut engine, scene, view)?;
        note_coarse_shadows(&mut engine, &settings.shadows)?;
        casting.keep(seen, occluders(&mut engine)?);
        let engine = focus::wished(engine, device, (scene, view), settings)?
            .ok_or_else(|| focus::out_of_view(scene, view, settings))?;
        made.push(engine);
    }
    joined(made, views, settings, fixed)
}

/// The settings, with so many views sharing the memory of shadow tables.
fn with_shared_shadows(settings: &Settings, views: usize) -> Settings {
    let memory = (settings.shadows.memory / views as u32).max(1);
    let shadows = ShadowSettings { memory, ..settings.shadows };
    Settings { shadows, ..settings.clone() }
}

/// What judges on a device pictures of every `step`-th pixel of a session's views; none where nothing of the scene is seen
/// in one.
///
/// # Errors
/// What the device reports.
pub(in crate::session) fn small_evaluator(
    session: &mut Session,
    device: &Opened,
    step: u32,
) -> Result<Option<Engine>> {
    let Session { evaluator, views, settings, strokes, kept, .. } = session;
    let mut made = Vec::with_capacity(views.len());
    for (seen, whole) in views.iter().zip(evaluator.of_views()) {
        let small = seen.view.subsampled(step);
        let objective = coarse::objective(&settings.objective, &seen.view, &small);
        let settings = Settings { objective, ..settings.clone() };
        let unmarked = strokes::unmarked(strokes.as_ref(), &settings)?;
        let mut engine = subsampled(device, whole, (seen, step), &unmarked)?;
        // What is a few pixels wide may be none there.
        if engine.maps()?.counts.object() == 0 {
            return Ok(None);
        }
        if let Some(drawn) = &strokes {
            // Nor may strokes be.
            let Ok(strokes) = drawn.on(engine.maps()?) else { return Ok(None) };
            let both = (device, &small);
            engine = strokes::marked(&mut engine, &strokes, both, &settings)?.unwrap_or(engine);
        }
        match focus::wished(engine, device, (&seen.scene, &small), &settings)? {
            Some(engine) => made.push(engine),
            None => return Ok(None),
        }
    }
    joined(made, views, settings, kept.len()).map(Some)
}

/// What measures on a device every `step`-th pixel of what `whole` does, whose objects all count alike.
fn subsampled(
    device: &Opened,
    whole: &mut Engine,
    (Seen { scene, view, .. }, step): (&Seen, u32),
    settings: &Settings,
) -> Result<Engine> {
    let small = view.subsampled(step);
    // Of maps that pipeline makes no pictures.
    if matches!(device, Opened::Vulkan(_)) && whole.pipeline() == Some(PipelineKind::Forward) {
        let occluders = occluders(whole)?;
        return evaluator_on(device, (scene, &small), settings, occluders);
    }
    let maps = subsample::subsampled(whole.maps()?, view, step, &settings.objective);
    evaluator_of(device, (maps, &small), settings)
}

/// What casts shadows in an evaluator's view, in its light frame; nothing where there are none.
///
/// # Errors
/// What the device reports.
pub(in crate::session) fn occluders(engine: &mut Engine) -> Result<Option<Arc<Occluders>>> {
    let shadows = engine.maps()?.shadows.as_ref();
    Ok(shadows.map(|shadows| Arc::clone(shadows.occluders())))
}

/// One evaluator of those of all views.
fn joined(
    mut made: Vec<Engine>,
    views: &[Seen],
    settings: &Settings,
    fixed: usize,
) -> Result<Engine> {
    if made.len() == 1 {
        return Ok(made.swap_remove(0));
    }
    let ViewsSettings { rig, over, .. } = settings.views;
    let framed = made.into_iter().zip(views.iter().map(|seen| seen.view.frame)).collect();
    Ok(Engine::Views(Box::new(Views::new(framed, rig, over, fixed)?)))
}
