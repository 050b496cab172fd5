//! What all pipelines together ask of a device.

use super::testing::{self, assert_valid};
use super::vulkan::pipeline::Binding;
use super::{
    ComputeShape, Context, GpuEvaluator, Limit, Needs, PictureEvaluator, PipelineKind,
    SurfaceEvaluator, Tuning,
};
use crate::lighting::shading::Shading;
use crate::objective::Objective;
use crate::objective::shadows::ShadowSettings;
use ash::vk;
use std::sync::Arc;

const SIZE: [u32; 2] = [16, 12];

/// The bindings of every pipeline layout of klieg's: those of each pipeline with shadows, and of an engine's
/// surface and pictures.
fn pipeline_layouts() -> Vec<Vec<Binding>> {
    use PipelineKind::{Compute, Forward, Layered};
    let (scene, view) = testing::tetrahedron(SIZE);
    let (objective, shading) = (Objective::default(), Shading::default());
    let shadows = ShadowSettings { on: true, side: 3, ..ShadowSettings::default() };
    let of = |(pipeline, shape)| {
        let tuning = Tuning { pipeline: Some(pipeline), shape, ..Tuning::default() };
        let context: Arc<Context> = testing::with_tuning(tuning);
        let settings = (objective, shading);
        let mut drawn =
            GpuEvaluator::with_shadows(&context, &scene, &view, settings, &shadows).unwrap();
        drawn.reserve(3, 2).unwrap();
        if pipeline == Compute {
            SurfaceEvaluator::with_shadows(&context, SIZE, settings, &scene, &shadows).unwrap();
        }
        if pipeline == Layered {
            PictureEvaluator::new(&context, SIZE, objective).unwrap();
        }
        assert_valid(&context);
        context.cache().bound()
    };
    let shapes = [ComputeShape::Runs, ComputeShape::Tiles].map(|shape| (Compute, Some(shape)));
    [(Layered, None), (Forward, None)].into_iter().chain(shapes).flat_map(of).collect()
}

/// How many descriptors of these kinds a stage has in each layout, at most.
fn most(
    layouts: &[Vec<Binding>],
    stage: vk::ShaderStageFlags,
    kinds: &[vk::DescriptorType],
) -> u64 {
    let counts = |&&(_, kind, stages): &&Binding| {
        stages.contains(stage) && (kinds.is_empty() || kinds.contains(&kind))
    };
    let count = |bindings: &Vec<Binding>| bindings.iter().filter(counts).count() as u64;
    layouts.iter().map(count).max().unwrap_or(0)
}

#[test]
fn devices_are_asked_for_what_the_pipelines_bind_and_no_more() {
    use vk::DescriptorType as Kind;
    use vk::ShaderStageFlags as Stage;
    let layouts = pipeline_layouts();
    let limits = Needs::COMPUTE.requirements().limits;
    let read = [Kind::SAMPLED_IMAGE, Kind::UNIFORM_TEXEL_BUFFER, Kind::COMBINED_IMAGE_SAMPLER];
    for (name, kinds) in [
        (
            "maxPerStageDescriptorStorageImages",
            &[Kind::STORAGE_IMAGE, Kind::STORAGE_TEXEL_BUFFER][..],
        ),
        ("maxPerStageDescriptorSampledImages", &read),
        ("maxPerStageDescriptorStorageBuffers", &[Kind::STORAGE_BUFFER]),
        ("maxPerStageResources", &[]),
    ] {
        let Limit { least, .. } = limits.iter().find(|limit| limit.name == name).unwrap();
        let stages = [Stage::VERTEX, Stage::FRAGMENT, Stage::COMPUTE];
        let bound = stages.map(|stage| most(&layouts, stage, kinds));
        assert_eq!(bound.into_iter().max(), Some(*least), "{name}: {bound:?}");
    }
}

#[test]
fn few_storage_images_are_asked_for() {
    // The least that Vulkan lets a device have; Apple's M1 has 8.
    let limits = Needs::ALL.requirements().limits;
    let images = limits.iter().find(|l| l.name == "maxPerStageDescriptorStorageImages").unwrap();
    assert_eq!(images.least, 4);
}
