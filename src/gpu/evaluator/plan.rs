//! What an evaluator would take of a device's memory, found out by making one that takes none.

use super::GpuEvaluator;
use crate::Result;
use crate::cpu;
use crate::gpu::vulkan::choice::PipelineKind;
use crate::gpu::vulkan::usage::MemoryUse;
use crate::gpu::{Context, ContextOptions};
use crate::lighting::shading::Shading;
use crate::objective::Objective;
use crate::objective::shadows::ShadowSettings;
use crate::scene::Scene;
use crate::scene::view::View;
use serde::Serialize;
use std::sync::Arc;

/// What an evaluator of a scene takes of a device's memory, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct MemoryPlan {
    /// How it makes the pictures.
    pub pipeline: PipelineKind,
    /// What stays for the view, without its shadows.
    pub view: u64,
    /// The shadow table and what casts shadows.
    pub shadows: u64,
    /// Lights, pictures, partial results and scores of the population.
    pub population: u64,
    /// Individuals that are measured at once; a larger population goes in parts.
    pub at_once: u32,
    /// The most at any time, while the view is made included.
    pub most: MemoryUse,
    /// What the device has.
    pub memory: u64,
    /// Whether that is enough for the most.
    pub fits: bool,
}

impl GpuEvaluator {
    /// What [`GpuEvaluator::with_shadows`] takes for populations of so many individuals of so many lights on the
    /// device of `options`, before it takes it: an evaluator is made as there, with the device's own sizes of
    /// all buffers and images, but they get no memory, and nothing runs. The object pixels are counted on the
    /// CPU; pipeline `compute` in tiles is told for a picture that the object fills.
    ///
    /// # Errors
    /// As [`Context::new`], [`GpuEvaluator::with_shadows`] and [`GpuEvaluator::reserve`].
    pub fn plan(
        options: &ContextOptions,
        (scene, view): (&Scene, &View),
        settings: (Objective, Shading),
        shadows: &ShadowSettings,
        population: (u32, usize),
    ) -> Result<MemoryPlan> {
        plan(&Context::dry(options)?, (scene, view), settings, shadows, population)
    }
}

fn plan(
    context: &Arc<Context>,
    (scene, view): (&Scene, &View),
    settings: (Objective, Shading),
    shadows: &ShadowSettings,
    (individuals, lights): (u32, usize),
) -> Result<MemoryPlan> {
    let of_scene = ((shadows, None), Some(cpu::objects(scene, view)?));
    let mut evaluator = GpuEvaluator::of_scene(context, scene, view, settings, of_scene)?;
    let before = context.memory_use().total();
    evaluator.reserve(individuals, lights)?;
    let shadows = evaluator.view.shadows.bytes();
    let (most, memory) = (context.most_memory_use(), context.report().memory);
    Ok(MemoryPlan {
        pipeline: evaluator.pipeline,
        view: before - shadows,
        shadows,
        population: context.memory_use().total() - before,
        at_once: evaluator.generation.as_ref().map_or(0, |generation| generation.at_once()),
        most,
        memory,
        fits: most.total() <= memory,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{ComputeShape, Tuning, testing};

    const INDIVIDUALS: u32 = 20;
    const LIGHTS: usize = 3;

    /// What is planned, and what is then taken: in all, and at most.
    fn both(tuning: Tuning, on: bool) -> (MemoryPlan, [MemoryUse; 2]) {
        let (scene, view) = testing::tetrahedron([160, 120]);
        let settings = (Objective::default(), Shading::default());
        let shadows = ShadowSettings { on, side: 15, ..ShadowSettings::default() };
        let dry = testing::dry(&tuning);
        let plan = plan(&dry, (&scene, &view), settings, &shadows, (INDIVIDUALS, LIGHTS)).unwrap();
        assert_eq!((dry.memory_taken(), dry.counters().pipelines), (0, 0));
        testing::assert_valid(&dry);
        let context = testing::with_tuning(tuning);
        let mut evaluator =
            GpuEvaluator::with_shadows(&context, &scene, &view, settings, &shadows).unwrap();
        evaluator.reserve(INDIVIDUALS, LIGHTS).unwrap();
        let taken = [context.memory_use(), context.most_memory_use()];
        assert!(context.memory_taken() >= taken[0].total());
        testing::assert_valid(&context);
        (plan, taken)
    }

    /// Whether the plan is no more than a hundredth away from what is taken.
    fn is_close(plan: u64, taken: u64) -> bool {
        plan.abs_diff(taken) * 100 <= taken
    }

    #[test]
    fn what_is_planned_is_taken() {
        use PipelineKind::{Compute, Forward, Layered};
        for (pipeline, shape) in
            [(Layered, None), (Forward, None), (Compute, Some(ComputeShape::Runs))]
        {
            for on in [false, true] {
                let tuning = Tuning { pipeline: Some(pipeline), shape, ..Tuning::default() };
                let (plan, [taken, most]) = both(tuning, on);
                let said = format!("{pipeline} {on}: {plan:?}, {taken:?}, {most:?}");
                let all = plan.view + plan.shadows + plan.population;
                assert!(is_close(all, taken.total()), "{said}");
                assert!(is_close(plan.most.total(), most.total()), "{said}");
                // A table of 15 words of 4 bytes for each pixel.
                assert_eq!(plan.shadows >= 160 * 120 * 15 * 4, on, "{said}");
                assert!((plan.pipeline, plan.at_once) == (pipeline, INDIVIDUALS), "{said}");
                assert!(plan.fits && plan.memory > 0, "{said}");
            }
        }
    }

    #[test]
    fn tiles_are_planned_for_all_of_the_picture() {
        let shape = Some(ComputeShape::Tiles);
        let tuning = Tuning { pipeline: Some(PipelineKind::Compute), shape, ..Tuning::default() };
        let (plan, [taken, _]) = both(tuning, false);
        let all = plan.view + plan.shadows + plan.population;
        assert!((taken.total()..2 * taken.total()).contains(&all), "{plan:?} {taken:?}");
    }

    #[test]
    fn populations_in_parts_are_planned_so() {
        let pipeline = Some(PipelineKind::Layered);
        let picture_memory = Some(3 * 160 * 120 * 4 + 100_000);
        let (plan, [taken, _]) =
            both(Tuning { pipeline, picture_memory, ..Tuning::default() }, false);
        assert!(plan.at_once < INDIVIDUALS, "{plan:?}");
        let all = plan.view + plan.shadows + plan.population;
        assert!(is_close(all, taken.total()), "{plan:?} {taken:?}");
    }
}
