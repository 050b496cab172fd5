//! What is measured: an evaluator on a device, in one of the ways that it can work.

use super::super::config::{Pipeline, Settings};
use super::super::device::{self, Chosen, Opened};
use super::super::session::{self, Engine};
use super::super::values::Device;
use crate::Result;
use crate::evaluate::{DeviceInfo, Evaluator};
use crate::gpu::{Context, ReadbackEvaluator};
use crate::lighting::Population;
use crate::scene::Scene;
use crate::scene::view::View;
use anyhow::Context as _;
use clap::ValueEnum;
use rayon::ThreadPool;
use std::sync::Arc;

/// What the pipelines are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Baseline {
    /// On Vulkan devices: one draw of the scene and one full read-back for each individual, its
    /// terms computed by the CPU
    Readback,
    /// The native evaluator, on one core and on all
    Cpu,
}

/// How a device measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum How {
    Pipeline(Pipeline),
    Readback,
    /// On one core alone, or on all.
    Native {
        alone: bool,
    },
}

/// A way of measuring on a device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Method {
    device: Device,
    how: How,
}

/// All ways that are asked for, in order, each once.
///
/// # Errors
/// [`crate::Error::Argument`] for a device that is not there.
pub fn methods(
    devices: &[Device],
    pipelines: &[Pipeline],
    baselines: &[Baseline],
) -> Result<Vec<Method>> {
    let (reports, fault) = device::list();
    let mut methods = Vec::new();
    let mut add = |device: &Device, how| {
        let method = Method { device: device.clone(), how };
        if !methods.contains(&method) {
            methods.push(method);
        }
    };
    let default = [Device::Cpu, Device::Vulkan];
    let able = device::choose(&Device::Vulkan, &reports).is_ok();
    let devices = match devices {
        [] => &default[..1 + usize::from(able)],
        given => given,
    };
    if baselines.contains(&Baseline::Cpu) {
        add(&Device::Cpu, How::Native { alone: true });
        add(&Device::Cpu, How::Native { alone: false });
    }
    for device in devices {
        match device::choose(device, &reports) {
            Ok(Chosen::Cpu) => add(&Device::Cpu, How::Native { alone: false }),
            Ok(Chosen::Vulkan(_)) => {
                if baselines.contains(&Baseline::Readback) {
                    add(device, How::Readback);
                }
                pipelines.iter().for_each(|&pipeline| add(device, How::Pipeline(pipeline)));
            }
            Err(wrong) => return Err(fault.unwrap_or(wrong)),
        }
    }
    Ok(methods)
}

/// A method, ready for one view.
pub enum Machine {
    /// An evaluator, native or on Vulkan.
    Whole(Engine),
    /// The native evaluator in a pool of its own.
    Alone(Engine, ThreadPool),
    /// The baseline of the paper.
    Readback(Box<ReadbackEvaluator>),
}

impl Machine {
    /// Sets the device up and makes the view's maps.
    ///
    /// # Errors
    /// What choosing and setting up the device reports.
    pub fn new(
        method: &Method,
        scene: &Scene,
        view: &View,
        settings: &Settings,
    ) -> anyhow::Result<Self> {
        let mut settings = settings.clone();
        let Method { device, how } = method;
        if let How::Pipeline(pipeline) = how {
            settings.pipeline = *pipeline;
        }
        let engine = || session::evaluator(scene, view, &settings, device);
        Ok(match how {
            How::Pipeline(_) | How::Native { alone: false } => Self::Whole(engine()?),
            How::Native { alone: true } => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
                let pool = pool.context("cannot start a thread")?;
                Self::Alone(pool.install(engine)?, pool)
            }
            How::Readback => {
                let Opened::Vulkan(stored) = device::open(device, &settings)? else {
                    unreachable!("methods read back from Vulkan devices only");
                };
                let (objective, shading) = (settings.objective, settings.shading);
                let evaluator =
                    ReadbackEvaluator::new(&stored.context, scene, view, objective, shading)?;
                Self::Readback(Box::new(evaluator))
            }
        })
    }

    /// What `work` finds on the threads that the native evaluator has.
    pub fn within<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match self {
            Self::Alone(_, pool) => pool.install(work),
            _ => work(),
        }
    }

    /// # Errors
    /// What the device reports.
    pub fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        match self {
            Self::Whole(engine) => engine.evaluate(population, scores),
            Self::Alone(engine, pool) => pool.install(|| engine.evaluate(population, scores)),
            Self::Readback(evaluator) => evaluator.evaluate(population, scores),
        }
    }

    /// What computes.
    pub fn device(&self) -> &DeviceInfo {
        match self {
            Self::Whole(engine) | Self::Alone(engine, _) => engine.device(),
            Self::Readback(evaluator) => evaluator.device(),
        }
    }

    /// The pipeline's name; `native` or `readback` for the baselines.
    pub fn pipeline(&self) -> String {
        match self {
            Self::Whole(engine) | Self::Alone(engine, _) => {
                engine.pipeline().map_or("native".into(), |pipeline| pipeline.to_string())
            }
            Self::Readback(_) => "readback".into(),
        }
    }

    /// Threads of the native evaluator.
    pub fn threads(&self) -> Option<usize> {
        match self {
            Self::Whole(Engine::Cpu(_)) => Some(rayon::current_num_threads()),
            Self::Alone(_, pool) => Some(pool.current_num_threads()),
            _ => None,
        }
    }

    /// Object pixels of the view.
    ///
    /// # Errors
    /// What the device reports.
    pub fn objects(&mut self) -> Result<u32> {
        Ok(match self {
            Self::Whole(Engine::Vulkan { gpu, .. }) => gpu.objects(),
            Self::Whole(engine) | Self::Alone(engine, _) => engine.maps()?.counts.object(),
            Self::Readback(evaluator) => evaluator.maps()?.counts.object(),
        })
    }

    /// The GPU's time for each stage of the last population, milliseconds; none for the CPU.
    pub fn stage_times(&self) -> &[(&'static str, f64)] {
        match self {
            Self::Whole(engine) | Self::Alone(engine, _) => engine.stage_times(),
            Self::Readback(evaluator) => evaluator.timings(),
        }
    }

    /// The time of the view's shadow table, milliseconds; none without shadows, and for the native evaluator.
    pub fn shadows_ms(&self) -> Option<f64> {
        let Self::Whole(Engine::Vulkan { gpu, .. }) = self else { return None };
        let row = gpu.view_timings().iter().find(|(stage, _)| *stage == "shadows");
        row.map(|&(_, time)| time)
    }

    /// Device memory that is taken, bytes.
    pub fn device_memory(&self) -> Option<u64> {
        self.vulkan().map(|context| context.memory_taken())
    }

    fn vulkan(&self) -> Option<&Arc<Context>> {
        match self {
            Self::Whole(Engine::Vulkan { gpu, .. }) => Some(gpu.context()),
            Self::Readback(evaluator) => Some(evaluator.context()),
            _ => None,
        }
    }
}
