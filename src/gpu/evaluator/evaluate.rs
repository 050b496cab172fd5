//! Lights in, scores out.

use super::{GpuEvaluator, Source, Views, measure, no_color};
use crate::evaluate::{DeviceInfo, Evaluator, Inspection, Pending, check_places, check_scores};
use crate::gpu::layout::Detail;
use crate::gpu::measure::generation::{GenerationMemory, Measure};
use crate::gpu::view::memory::ViewMemory;
use crate::gpu::vulkan::choice::Lights;
use crate::gpu::vulkan::commands::Commands;
use crate::lighting::{Light, Population};
use crate::objective::Quality;
use crate::objective::maps::Maps;
use crate::{Error, Result};

impl GpuEvaluator {
    /// The evaluator for these lights: this one or, where they are in colour and this one's pictures are
    /// not, one beside it, made now.
    fn for_lights(&mut self, population: &Population) -> Result<&mut Self> {
        self.context.check_present()?;
        if population.is_plain() || self.view.color.is_some() {
            return Ok(self);
        }
        if self.in_color.is_none() {
            let maps = self.maps()?.clone();
            let source = self.source.as_ref().ok_or_else(no_color)?;
            let (context, objective) = (&self.context, self.view.objective);
            let Source { view, shading, scene } = source;
            let memory =
                ViewMemory::with_maps(context, &maps, view, &objective, shading, Lights::Any)?;
            let views = scene.as_ref().map_or(Views::Known, Views::Scene);
            let objects = maps.counts.object();
            let measure = measure(context, &memory, objects, views)?;
            let made = Self::of(context, memory, objects, measure, (None, Some(maps)))?;
            self.in_color = Some(Box::new(made));
        }
        self.in_color.as_deref_mut().ok_or_else(no_color)
    }

    /// Lets the device measure every rig, by this evaluator itself.
    fn start(&mut self, population: &Population) -> Result<()> {
        let individuals = u32::try_from(population.len())
            .map_err(|_| Error::Argument(format!("{} individuals", population.len())))?;
        let plan = (individuals, self.rig_kind(population));
        self.prepare(individuals, plan.1)?;
        let generation = self.generation.as_mut().expect("made by `prepare`");
        if self.recorded != Some(plan) {
            self.recorded = None;
            let stages = (&self.view, &*self.measure as &dyn Measure, &self.fitness);
            generation.record_submissions(&mut self.commands, &self.context, stages, plan)?;
            self.recorded = Some(plan);
        }
        generation.lights.write(population.records())?;
        self.commands.iter_mut().try_for_each(Commands::start)
    }

    /// `F` of every rig of the population that was started.
    fn finish(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        self.commands.iter_mut().try_for_each(Commands::finish)?;
        let generation = self.generation.as_mut().expect("made by `start`");
        generation.scores.read(scores)?;
        generation.timer.read()?;
        if !self.view.objective.is_own() {
            let details = self.details(scores.len())?;
            let qualities = self.view.qualities(scores, &details)?;
            scores.iter_mut().zip(qualities).for_each(|(score, judged)| *score = judged.score);
        }
        check_scores(population, scores)
    }

    /// `F` of every rig, by this evaluator itself.
    fn evaluate_here(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        self.start(population)?;
        self.finish(population, scores)
    }

    /// Statistics of the first `count` individuals of the last evaluation.
    fn details(&self, count: usize) -> Result<Vec<Detail>> {
        let generation = self.generation.as_ref();
        let read = |generation: &GenerationMemory| generation.read_details(&self.context, count);
        generation.map_or(Ok(Vec::new()), read)
    }
}

impl Evaluator for GpuEvaluator {
    fn device(&self) -> &DeviceInfo {
        &self.context.report().info
    }

    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        self.context.check_present()?;
        check_places(population, scores)?;
        self.begin(population)?(scores)
    }

    fn begin<'a>(&'a mut self, population: &'a Population) -> Result<Pending<'a>> {
        self.context.check_present()?;
        if population.is_empty() {
            return Ok(Box::new(|scores| check_places(population, scores)));
        }
        let evaluator = self.for_lights(population)?;
        evaluator.start(population)?;
        Ok(Box::new(|scores| {
            check_places(population, scores)?;
            evaluator.finish(population, scores)
        }))
    }

    fn qualities(&mut self, population: &Population) -> Result<Vec<Quality>> {
        self.context.check_present()?;
        if population.is_empty() {
            return Ok(Vec::new());
        }
        let mut scores = vec![0.0; population.len()];
        let evaluator = self.for_lights(population)?;
        evaluator.evaluate_here(population, &mut scores)?;
        evaluator.view.qualities(&scores, &evaluator.details(scores.len())?)
    }

    fn inspect(&mut self, rig: &[Light]) -> Result<Inspection> {
        let (population, mut score) = (Population::of([rig])?, [0.0]);
        let evaluator = self.for_lights(&population)?;
        evaluator.evaluate_here(&population, &mut score)?;
        let details = evaluator.details(1)?;
        let Quality { score, terms } = evaluator.view.qualities(&score, &details)?[0];
        let picture = evaluator.measure.first_picture(&evaluator.view)?;
        Ok(Inspection { score, terms, statistics: details[0].statistics(), picture })
    }

    fn maps(&mut self) -> Result<&Maps> {
        if self.maps.is_none()
            && let Some(drawn) = &self.drawn
        {
            self.maps = Some(drawn.read(&self.view)?);
        }
        Ok(self.maps.as_ref().expect("maps are known or drawn"))
    }
}
