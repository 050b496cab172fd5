//! How Ha and Olivier (2006) measured a population, as a baseline: the scene is drawn for one individual
//! after another, each picture is read back whole, and the CPU computes its terms.

use super::Context;
use super::layout::Chunk;
use super::measure::forward::ForwardDraw;
use super::measure::population::PictureStage;
use super::view::drawn;
use super::view::memory::ViewMemory;
use super::vulkan::choice::Lights;
use super::vulkan::commands::{COPY_READ, COPY_WRITE, Commands, HOST_READ};
use super::vulkan::memory::{Access, Buffer};
use super::vulkan::pipeline::RigKind;
use super::vulkan::timer::StageTimer;
use crate::cpu::fitness;
use crate::evaluate::{DeviceInfo, Evaluator, Inspection, check_places};
use crate::lighting::shading::{Brdf, Shading};
use crate::lighting::{Light, LightRecord, MAX_LIGHTS, Population};
use crate::objective::maps::Maps;
use crate::objective::{Needs, Objective, Quality, Statistics};
use crate::scene::Scene;
use crate::scene::view::View;
use crate::{Error, Result};
use ash::vk;
use std::sync::Arc;

/// Stages of an individual.
const STAGES: u32 = 2;

/// Draws the scene's geometry once for each individual into one picture, copies it to mapped memory
/// and measures it there with the plain stages of [`crate::cpu`], on one core. Its commands are
/// recorded once and its memory is made once, so that the baseline pays for its method alone.
pub struct ReadbackEvaluator {
    commands: Commands,
    recorded: Option<usize>,
    timer: StageTimer,
    timings: Vec<(&'static str, f64)>,
    lights: Buffer,
    copy: Buffer,
    picture: Vec<f32>,
    draw: ForwardDraw,
    view: ViewMemory,
    maps: Maps,
    objective: Objective,
    context: Arc<Context>,
}

impl ReadbackEvaluator {
    /// An evaluator that draws the scene and makes the view's maps on the device.
    ///
    /// # Errors
    /// As [`super::GpuEvaluator::new`].
    pub fn new(
        context: &Arc<Context>,
        scene: &Scene,
        view: &View,
        objective: Objective,
        shading: Shading,
    ) -> Result<Self> {
        if objective.needs() != Needs::NONE || shading.brdf != Brdf::BlinnPhong {
            let fault = "the read-back baseline measures the paper's terms, under its own shading";
            return Err(Error::Argument(fault.into()));
        }
        let (view, drawn, scene) =
            drawn::draw(context, scene, view, (&objective, &shading), Lights::Plain, None)?;
        let maps = drawn.read(&view)?;
        let mut draw = ForwardDraw::new(context, &view, Arc::new(scene))?;
        let bytes = (MAX_LIGHTS * size_of::<LightRecord>()) as u64;
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let lights = Buffer::new(context, "lights", bytes, usage, Access::Upload)?;
        draw.allocate(view.size, 1, &lights)?;
        let pixels = maps.types.len();
        let (bytes, usage) = (4 * pixels as u64, vk::BufferUsageFlags::TRANSFER_DST);
        Ok(Self {
            commands: Commands::new(context)?,
            recorded: None,
            timer: StageTimer::new(context, STAGES)?,
            timings: Vec::new(),
            lights,
            copy: Buffer::new(context, "picture", bytes, usage, Access::Readback)?,
            picture: vec![0.0; pixels],
            draw,
            view,
            maps,
            objective,
            context: Arc::clone(context),
        })
    }

    /// The device and what was made and read on it.
    pub fn context(&self) -> &Arc<Context> {
        &self.context
    }

    /// GPU milliseconds of each stage, summed over the individuals of the last population; empty
    /// where the device has no timestamps.
    pub fn timings(&self) -> &[(&'static str, f64)] {
        &self.timings
    }

    /// Draws one rig and reads its picture back.
    fn draw_one(&mut self, rig: &[LightRecord]) -> Result<()> {
        if self.recorded != Some(rig.len()) {
            self.recorded = None;
            self.draw.prepare(&self.view, of_lights(rig.len()))?;
            self.record(rig.len())?;
            self.recorded = Some(rig.len());
        }
        self.lights.write(rig)?;
        self.commands.run()?;
        self.copy.read(&mut self.picture)?;
        self.timer.read()?;
        for &(stage, time) in self.timer.rows() {
            match self.timings.iter_mut().find(|row| row.0 == stage) {
                Some(row) => row.1 += time,
                None => self.timings.push((stage, time)),
            }
        }
        Ok(())
    }

    /// Records the draw and the copy of a rig of `lights` lights.
    fn record(&mut self, lights: usize) -> Result<()> {
        let Self { commands, timer, draw, view, copy, context, .. } = self;
        commands.record(|cmd| {
            timer.reset(cmd);
            timer.stage(cmd, draw.stem(), || {
                draw.record(cmd, view, (&Chunk::default(), 1), of_lights(lights));
            });
            timer.stage(cmd, "readback", || {
                let image = draw.pictures();
                // The draw leaves the picture to shaders.
                let from = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
                let to = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
                context.transition(cmd, image, (from, to), COPY_READ, COPY_READ);
                context.download(cmd, (image, to, 0), copy);
                context.barrier(cmd, COPY_WRITE, HOST_READ);
            });
            Ok(())
        })
    }

    /// Draws and measures one rig.
    fn measure(&mut self, rig: &[LightRecord]) -> Result<(Quality, Statistics)> {
        self.draw_one(rig)?;
        let statistics = fitness::statistics(&self.maps, &self.picture, &self.objective);
        Ok((self.objective.quality(&statistics, &self.maps.statistics()), statistics))
    }
}

/// Rigs of `lights` lights, that cast no shadows.
fn of_lights(lights: usize) -> RigKind {
    RigKind { lights, near: false }
}

/// # Errors
/// [`Error::Argument`] for coloured lights and spots.
fn check_plain(population: &Population) -> Result<()> {
    if population.is_plain() {
        return Ok(());
    }
    Err(Error::Argument("the read-back baseline shades under white lights without cones".into()))
}

impl Evaluator for ReadbackEvaluator {
    fn device(&self) -> &DeviceInfo {
        &self.context.report().info
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        self.context.check_present()?;
        check_places(population, scores)?;
        self.timings.clear();
        check_plain(population)?;
        for (rig, score) in population.rigs().zip(scores) {
            *score = self.measure(rig)?.0.score;
        }
        Ok(())
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        self.context.check_present()?;
        self.timings.clear();
        population.rigs().map(|rig| Ok(self.measure(rig)?.0)).collect()
    }

    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        self.timings.clear();
        let (Quality { score, terms }, statistics) =
            self.measure(Population::of([rig])?.records())?;
        // The device marks the background by a negative value.
        let picture = self.picture.iter().map(|i| i.max(0.0)).collect();
        Ok(Inspection { score, terms, statistics, picture })
    }

    fn maps(&mut self) -> Result<&Maps> {
        Ok(&self.maps)
    }
}
