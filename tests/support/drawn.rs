//! An engine's view of known maps, on its device, and the pictures that it renders of it.

use crate::engine::{Engine, Texture};
use crate::gpu::view;
use ash::vk;
use glam::{DMat4, DVec3};
use klieg::cpu;
use klieg::gpu::{
    Context, EnabledFeatures, EngineImage, ImportedPictures, ImportedSurface, Needs,
    PictureEvaluator, SurfaceImages, Tuning,
};
use klieg::lighting::Light;
use klieg::lighting::shading::Shading;
use klieg::objective::maps::Maps;
use klieg::objective::{Objective, Quality};
use klieg::scene::engine::{EngineCamera, PictureFormat, SurfaceFormat};
use std::sync::Arc;

/// The layout that the engine's images are in.
pub const SAMPLED: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;

/// An engine without any feature that klieg could use; its validation layer has nothing to say.
pub fn on_an_engine(body: impl FnOnce(&Engine)) {
    let engine = Engine::new(EnabledFeatures::default());
    body(&engine);
    assert_eq!(engine.end(), [""; 0]);
}

pub fn borrow(engine: &Engine, picture_memory: Option<u64>) -> Arc<Context> {
    engine.context_for(Needs::COMPUTE, &Tuning { picture_memory, ..Tuning::default() })
}

/// An engine's view of an object, on its device.
pub struct Drawn<'a> {
    pub engine: &'a Engine,
    pub maps: Maps,
    pub images: SurfaceImages,
    _textures: [Texture<'a>; 3],
}

impl<'a> Drawn<'a> {
    /// Of known maps.
    pub fn new(engine: &'a Engine, maps: Maps) -> Self {
        let surface = &maps.surface;
        let depth: Vec<f32> = surface.depth.iter().map(|d| (d - 1.0) / 7.0).collect();
        let normals: Vec<_> = surface.normal.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        let size = [surface.width, surface.height];
        let texture = |format, texels| Texture::new(engine, size, (1, false), format, texels);
        let textures = [
            texture(vk::Format::R32_SFLOAT, bytemuck::cast_slice(&depth)),
            texture(vk::Format::R32G32B32A32_SFLOAT, bytemuck::cast_slice(&normals)),
            texture(vk::Format::R32_UINT, bytemuck::cast_slice(&surface.code)),
        ];
        let [depth, normal, ids] =
            [0, 1, 2].map(|i| EngineImage { view: textures[i].view, layout: SAMPLED });
        let images = SurfaceImages {
            depth,
            normal: Some(normal),
            base_color: None,
            roughness_metallic: None,
            emissive: None,
            ids: Some(ids),
        };
        Self { engine, maps, images, _textures: textures }
    }

    pub fn size(&self) -> [u32; 2] {
        [self.maps.surface.width, self.maps.surface.height]
    }

    /// As `support::view` looks at `support::maps`, with parallel rays.
    pub fn camera() -> EngineCamera {
        let projection = DMat4::from_translation(DVec3::Z / -7.0)
            * DMat4::from_scale(DVec3::new(1.0 / 1.1, -1.0 / 1.1, -1.0 / 7.0));
        let view = DMat4::from_translation(DVec3::Z * -4.0);
        EngineCamera { view, projection, center: DVec3::ZERO, radius: 1.0 }
    }

    pub fn surface(&self, evaluator: &PictureEvaluator) -> ImportedSurface {
        let format = SurfaceFormat::default();
        // SAFETY: the tests keep the images and wait for the device.
        unsafe { evaluator.import_surface(&self.images, &format) }.unwrap()
    }

    /// An evaluator that has seen the view.
    pub fn evaluator(&self, context: &Arc<Context>) -> PictureEvaluator {
        let objective = Objective::default();
        let mut evaluator = PictureEvaluator::new(context, self.size(), objective).unwrap();
        let surface = self.surface(&evaluator);
        // SAFETY: the images are readable, and nothing else runs.
        unsafe { evaluator.look(&surface, &Self::camera()) }.unwrap();
        assert_eq!(evaluator.maps().unwrap().types, self.maps.types);
        evaluator
    }

    /// What an engine renders under the lights: klieg's own pictures, from the native reference.
    pub fn render(&self, rigs: &[Vec<Light>]) -> Vec<Vec<f32>> {
        let [width, height] = self.size();
        let view = view(width, height, true);
        let picture = |rig: &Vec<Light>| {
            let records: Vec<_> = rig.iter().map(Light::record).collect();
            cpu::population::picture(&self.maps, &view, &Shading::default(), &records)
        };
        rigs.iter().map(picture).collect()
    }

    /// What the CPU references say of a picture.
    pub fn quality(&self, picture: &[f32]) -> Quality {
        let objective = Objective::default();
        let statistics = cpu::fitness::statistics(&self.maps, picture, &objective);
        objective.quality(&statistics, &self.maps.statistics())
    }

    /// And of what a texel fetch gives.
    pub fn fetched(&self, texels: &[[f32; 4]], format: PictureFormat) -> Quality {
        self.quality(&cpu::pictures::picture(&self.maps, texels, format))
    }

    /// Layers on the engine's device.
    pub fn layers(&self, format: vk::Format, layers: u32, texels: &[u8]) -> Texture<'a> {
        Texture::new(self.engine, self.size(), (layers, true), format, texels)
    }

    /// Pictures as floats in one component, encoded.
    pub fn floats(&self, pictures: &[Vec<f32>]) -> Texture<'a> {
        let texels = pictures.concat();
        let texels = bytemuck::cast_slice(&texels);
        self.layers(vk::Format::R32_SFLOAT, pictures.len() as u32, texels)
    }
}

pub fn import(
    evaluator: &PictureEvaluator,
    texture: &Texture<'_>,
    layers: u32,
    format: PictureFormat,
) -> ImportedPictures {
    let image = EngineImage { view: texture.view, layout: SAMPLED };
    // SAFETY: the tests keep the textures, which have so many layers, and wait for the device.
    unsafe { evaluator.import_pictures(image, layers, format) }.unwrap()
}
