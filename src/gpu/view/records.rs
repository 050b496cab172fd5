//! The surface as the stages of a generation read it: made by the stages `reflectance` and, where
//! something is shaded in colour or more than the brightness is measured, `colors`, or by the host.

use super::memory::{PIXEL_GROUP, ViewMemory, Written};
use crate::Result;
use crate::constants::NO_TARGET;
use crate::gpu::Context;
use crate::gpu::layout::Chunk;
use crate::gpu::shaders;
use crate::gpu::vulkan::commands::{COMPUTE_READ, COMPUTE_WRITE};
use crate::gpu::vulkan::pipeline::Pipeline;
use crate::lighting::shading::{Brdf, Coefficients, Shading};
use crate::math::color::luminance;
use crate::objective::maps::Maps;
use crate::scene::view::View;
use ash::vk;
use glam::Vec3;
use std::sync::Arc;

/// The stages that make the records from the G-buffer and the types.
pub struct Records {
    reflectance: Pipeline,
    colors: Option<Pipeline>,
    /// Set 1 of `shaders/include/records.glsl`.
    written: Written,
}

impl Records {
    /// For a view and views like it.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory) -> Result<Self> {
        let [x, y] = PIXEL_GROUP;
        let [a, b, c] = &view.records;
        let written = Written::new(context, view, ("records", &[a, b, c, &view.colors]))?;
        let stage = |stem, spirv, constants: &[u32]| {
            Pipeline::compute(context, stem, spirv, &written.layout, constants)
        };
        let colors = |color: Coloring| {
            let constants = [x, y, color.brdf.number(), color.shadow_side];
            stage("colors", shaders::COLORS_COMP, &constants)
        };
        Ok(Self {
            reflectance: stage("reflectance", shaders::REFLECTANCE_COMP, &PIXEL_GROUP)?,
            colors: view.color.map(colors).transpose()?,
            written,
        })
    }

    /// Records the stages. G-buffer, types and shadow table must be visible to compute shaders; the records
    /// are then.
    pub fn record(&self, cmd: vk::CommandBuffer, context: &Context, view: &ViewMemory) {
        for stage in [Some(&self.reflectance), self.colors.as_ref()].into_iter().flatten() {
            view.dispatch_with(cmd, (stage, &self.written), view.pixel_groups(), &Chunk::default());
        }
        context.barrier(cmd, COMPUTE_WRITE, COMPUTE_READ);
    }
}

/// Layer of the records for shading in colour that has the polygon's normal and the ambient occlusion.
pub const OPENNESS_LAYER: u32 = 3;

/// How pictures are shaded in colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coloring {
    /// How surfaces reflect.
    pub brdf: Brdf,
    /// Directions along a side of the shadow table; 0 without shadows.
    pub shadow_side: u32,
}

impl Coloring {
    /// The specialisation constants `GLTF`, `SHADOW_SIDE` and `NEAR_LIGHTS` of shaders.
    pub fn constants(self, near: bool) -> [u32; 3] {
        [self.brdf.is_gltf().into(), self.shadow_side, near.into()]
    }
}

/// A texel of each record.
type Texels<const N: usize> = [Vec<[f32; 4]>; N];

/// The surface's records, as the stage `reflectance` makes them.
pub fn records(maps: &Maps, shading: &Shading) -> Texels<3> {
    let mut records = [const { Vec::new() }; 3];
    for at in 0..maps.types.len() {
        let looks = maps.surface.reflectance(shading, at);
        let position = Vec3::from(maps.surface.position[at]).extend(looks.shininess);
        let normal = Vec3::from(maps.surface.normal[at]).extend(luminance(looks.diffuse));
        let kind = maps.types[at] as u32 as f32;
        records[0].push(position.to_array());
        records[1].push(normal.to_array());
        records[2].push([luminance(looks.specular), luminance(looks.unlit), kind, 0.0]);
    }
    records
}

/// The records for shading in colour, as the stage `colors` makes them, with the target picture: three, and
/// with shadows four.
pub fn colors(maps: &Maps, view: &View, shading: &Shading) -> Vec<Vec<[f32; 4]>> {
    let mut records = vec![Vec::new(); if maps.shadows.is_some() { 4 } else { 3 }];
    for at in 0..maps.types.len() {
        if let Some(shadows) = &maps.shadows {
            let open = shadows.number(at).map_or(0.0, |number| shadows.openness()[number]);
            let [x, y, z] = maps.surface.face[at];
            records[3].push([x, y, z, open]);
        }
        let looks = maps.reflectance(shading, at);
        let (p, n) = (Vec3::from(maps.surface.position[at]), Vec3::from(maps.surface.normal[at]));
        let n_v = n.dot(view.towards_viewer(p));
        let Coefficients { diffuse, specular, lobe } = looks.coefficients(shading.brdf, n_v);
        let target = maps.target.get(at).copied().unwrap_or(NO_TARGET);
        records[0].push(diffuse.extend(lobe).to_array());
        records[1].push(specular.extend(maps.normal_gradient[at]).to_array());
        records[2].push(looks.unlit.extend(target).to_array());
    }
    records
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::testing;
    use crate::gpu::vulkan::choice::Lights;
    use crate::gpu::vulkan::commands::Commands;
    use crate::objective::{Needs, Objective, Terms};

    #[test]
    fn the_device_makes_the_records_that_the_host_makes() {
        let context = testing::context();
        let (maps, view) = testing::maps(37, 19);
        let weights = Terms::named([("burnt", 1.0)]).unwrap();
        let objective = Objective { weights, ..Objective::default() };
        assert_eq!(objective.needs(), Needs::CHANNELS);
        for brdf in [Brdf::BlinnPhong, Brdf::Gltf, Brdf::GltfScattering] {
            let shading = Shading { brdf, ..Shading::default() };
            let uploaded =
                ViewMemory::with_maps(&context, &maps, &view, &objective, &shading, Lights::Plain)
                    .unwrap();
            let mut drawn =
                ViewMemory::with_maps(&context, &maps, &view, &objective, &shading, Lights::Plain)
                    .unwrap();
            drawn.add_g_buffer(vk::ImageUsageFlags::COLOR_ATTACHMENT).unwrap();
            testing::upload_surface(&context, &maps.surface, drawn.g_buffer.as_ref().unwrap());
            let stages = Records::new(&context, &drawn).unwrap();
            Commands::once(&context, |cmd| {
                stages.record(cmd, &context, &drawn);
                Ok(())
            })
            .unwrap();
            let layers = |memory: &ViewMemory| -> Vec<Vec<[f32; 4]>> {
                let records = memory.records.iter().map(|image| testing::download(&context, image));
                let colors =
                    (0..3).map(|layer| testing::download_layer(&context, &memory.colors, layer));
                records.chain(colors).collect()
            };
            for (made, expected) in layers(&drawn).iter().zip(layers(&uploaded)) {
                assert!(expected.iter().flatten().any(|&x| x != 0.0));
                for (a, b) in made.as_flattened().iter().zip(expected.as_flattened()) {
                    assert!((a - b).abs() <= 1e-5 * b.abs().max(1.0), "{a} {b}");
                }
            }
        }
        testing::assert_valid(&context);
    }
}
