//! Evaluators on the devices that settings name.

use super::config::Settings;
use super::device::{self, Opened};
use super::pipelines::Stored;
use super::values::Device;
use crate::cpu::{self, CpuEvaluator};
use crate::design::{Dimmed, Focused, Views, dim, focus};
use crate::evaluate::Evaluator;
use crate::gpu::{GpuEvaluator, PipelineKind};
use crate::lighting::{Light, Stand};
use crate::objective::maps::{Maps, ViewStatistics};
use crate::objective::{Objective, Quality, Statistics};
use crate::scene::Scene;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// An evaluator of either kind.
pub enum Engine {
    /// Native.
    Cpu(Box<CpuEvaluator>),
    /// On a Vulkan device.
    Vulkan {
        /// The evaluator.
        gpu: Box<GpuEvaluator>,
        /// What stores its pipelines at the end.
        _stored: Arc<Stored>,
    },
    /// Two of them, for a focus.
    Focused(Box<Focused<Engine>>),
    /// Three of them, for objects that are to stay dim.
    Dimmed(Box<Dimmed<Engine>>),
    /// One for each of several views.
    Views(Box<Views<Engine>>),
}

impl Engine {
    /// On the Vulkan device of `stored`.
    pub fn vulkan(gpu: GpuEvaluator, stored: &Arc<Stored>) -> Self {
        Self::Vulkan { gpu: Box::new(gpu), _stored: Arc::clone(stored) }
    }

    /// The evaluator alone.
    pub fn boxed(self) -> Box<dyn Evaluator> {
        match self {
            Self::Cpu(evaluator) => evaluator,
            Self::Vulkan { gpu, .. } => gpu,
            Self::Focused(both) => both,
            Self::Dimmed(all) => all,
            Self::Views(views) => views,
        }
    }

    /// The quality of a rig that stands in the world or goes with the camera, and where there are several views that in
    /// each of them.
    ///
    /// # Errors
    /// As [`Evaluator::inspect`].
    pub fn judge(&mut self, rig: &[Light], stand: Stand) -> crate::Result<(Quality, Vec<Quality>)> {
        match self {
            Self::Views(views) => views.judge(rig, stand),
            only => Ok((only.inspect(rig)?.quality(), Vec::new())),
        }
    }

    /// That of each view, itself where there is one.
    pub fn of_views(&mut self) -> Box<dyn Iterator<Item = &mut Self> + '_> {
        match self {
            Self::Views(views) => Box::new(views.evaluators()),
            only => Box::new(std::iter::once(only)),
        }
    }

    /// The evaluator of the whole view, without any wishes for objects.
    pub fn into_whole(self) -> Self {
        match self {
            Self::Focused(both) => both.into_whole().into_whole(),
            Self::Dimmed(all) => all.into_whole().into_whole(),
            plain => plain,
        }
    }

    /// Measures the picture of a rig, to be judged afterwards.
    ///
    /// # Errors
    /// As [`Evaluator::inspect`].
    pub fn measure(&mut self, rig: &[Light]) -> crate::Result<Measured> {
        Ok(match self {
            Self::Focused(both) => {
                let [whole, part] = both.parts_mut();
                Measured::Focused(Box::new([whole.measure(rig)?, part.measure(rig)?]))
            }
            Self::Dimmed(all) => {
                let [whole, lit, dim] = all.parts_mut();
                let parts = [whole.measure(rig)?, lit.measure(rig)?, dim.measure(rig)?];
                Measured::Dimmed(Box::new(parts))
            }
            plain => {
                let statistics = plain.inspect(rig)?.statistics;
                Measured::Plain(Box::new((statistics, plain.maps()?.statistics())))
            }
        })
    }

    /// How the pictures are made; none natively.
    pub fn pipeline(&self) -> Option<PipelineKind> {
        match self {
            Self::Cpu(_) => None,
            Self::Vulkan { gpu, .. } => Some(gpu.pipeline()),
            Self::Focused(both) => both.whole().pipeline(),
            Self::Dimmed(all) => all.whole().pipeline(),
            Self::Views(views) => views.first().pipeline(),
        }
    }

    /// The GPU's time for each stage of the last population, milliseconds; none for the CPU.
    pub fn stage_times(&self) -> &[(&'static str, f64)] {
        match self {
            Self::Cpu(_) => &[],
            Self::Vulkan { gpu, .. } => gpu.timings(),
            Self::Focused(both) => both.whole().stage_times(),
            Self::Dimmed(all) => all.whole().stage_times(),
            Self::Views(views) => views.first().stage_times(),
        }
    }
}

/// What was measured of a picture, to be judged by any objective whose terms were all measured.
pub enum Measured {
    /// Of a view whose objects all count alike.
    Plain(Box<(Statistics, ViewStatistics)>),
    /// Of the whole view and of the objects in focus.
    Focused(Box<[Measured; 2]>),
    /// Of the whole view, of the objects that are to be lit and of those that are to stay dim.
    Dimmed(Box<[Measured; 3]>),
}

impl Measured {
    /// What was measured of the whole view.
    pub fn whole(&self) -> &(Statistics, ViewStatistics) {
        match self {
            Self::Plain(whole) => whole,
            Self::Focused(both) => both[0].whole(),
            Self::Dimmed(all) => all[0].whole(),
        }
    }

    /// How good the picture is: as [`Focused`] and [`Dimmed`] have it.
    ///
    /// # Errors
    /// None in practice: the term of objects that are to stay dim is klieg's own.
    pub fn quality(&self, objective: &Objective) -> crate::Result<Quality> {
        match self {
            Self::Plain(whole) => Ok(objective.quality(&whole.0, &whole.1)),
            Self::Focused(both) => {
                let [whole, part] = [both[0].quality(objective)?, both[1].quality(objective)?];
                Ok(focus::mean_quality(whole, part))
            }
            Self::Dimmed(all) => {
                let dim = all[2].quality(&dim::objective(objective)?)?;
                dim::sum(all[1].quality(objective)?, dim)
            }
        }
    }
}

impl Deref for Engine {
    type Target = dyn Evaluator;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Cpu(evaluator) => &**evaluator,
            Self::Vulkan { gpu, .. } => &**gpu,
            Self::Focused(both) => &**both,
            Self::Dimmed(all) => &**all,
            Self::Views(views) => &**views,
        }
    }
}

impl DerefMut for Engine {
    fn deref_mut(&mut self) -> &mut Self::Target {
        match self {
            Self::Cpu(evaluator) => &mut **evaluator,
            Self::Vulkan { gpu, .. } => &mut **gpu,
            Self::Focused(both) => &mut **both,
            Self::Dimmed(all) => &mut **all,
            Self::Views(views) => &mut **views,
        }
    }
}

/// An evaluator on the named device.
///
/// # Errors
/// What choosing and setting up the device reports.
pub fn evaluator(
    scene: &Scene,
    view: &View,
    settings: &Settings,
    device: &Device,
) -> crate::Result<Engine> {
    evaluator_on(&device::open(device, settings)?, (scene, view), settings, None)
}

/// An evaluator on an open device, with the `occluders` in the light frame of `view`, where they are known.
///
/// # Errors
/// What setting it up reports.
pub fn evaluator_on(
    device: &Opened,
    (scene, view): (&Scene, &View),
    settings: &Settings,
    occluders: Option<Arc<Occluders>>,
) -> crate::Result<Engine> {
    let (objective, shading) = (settings.objective, settings.shading);
    Ok(match device {
        Opened::Cpu => {
            let shadows = (&settings.shadows, occluders);
            let maps = cpu::draw(scene, view, &objective, shadows)?;
            Engine::Cpu(Box::new(CpuEvaluator::new(maps, view, objective, shading)?))
        }
        Opened::Vulkan(stored) => {
            let (context, shadows) = (&stored.context, &settings.shadows);
            let both = (objective, shading);
            let casting = (shadows, occluders);
            let gpu = GpuEvaluator::with_occluders(context, scene, view, both, casting)?;
            Engine::vulkan(gpu, stored)
        }
    })
}

/// An evaluator of maps that are there, on an open device.
///
/// # Errors
/// What setting it up reports.
pub fn evaluator_of(
    device: &Opened,
    (maps, view): (Maps, &View),
    settings: &Settings,
) -> crate::Result<Engine> {
    let (objective, shading) = (settings.objective, settings.shading);
    Ok(match device {
        Opened::Cpu => Engine::Cpu(Box::new(CpuEvaluator::new(maps, view, objective, shading)?)),
        Opened::Vulkan(stored) => {
            let gpu = GpuEvaluator::with_maps(&stored.context, &maps, view, objective, shading)?;
            Engine::vulkan(gpu, stored)
        }
    })
}

/// Says what computes.
pub fn announce(evaluator: &Engine) {
    let device = evaluator.device();
    let pipeline = evaluator.pipeline();
    let pipeline = pipeline.map_or(String::new(), |pipeline| format!(", pipeline {pipeline}"));
    let (name, kind, driver) = (&device.name, device.kind, &device.driver);
    tracing::info!("device: {name} ({kind}, {driver}){pipeline}");
}
