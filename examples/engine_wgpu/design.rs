//! klieg in the engine: what both ways of measuring share.

use crate::Result;
use crate::gpu::Gpu;
use crate::renderer::{LIGHTS, Light, Renderer};
use crate::world::Camera;
use bytemuck::Zeroable;
use glam::DVec3;
use klieg::design::Designer;
use klieg::design::profile::{PAPER, Profile};
use klieg::lighting::genome::Genome;
use klieg::lighting::{LightRecord, Role};
use klieg::math::frame::Frame;
use klieg::optimize::{GeneticSettings, Settings};
use klieg::scene::engine::EngineCamera;
use std::path::Path;

/// The engine shades with Blinn-Phong and has no shadows, as this profile has it.
pub const PROFILE: &Profile = &PAPER;
/// Width and height of all pictures, pixels.
pub const SIZE: [u32; 2] = [254, 190];
/// Rigs of a generation.
pub const RIGS: u32 = 24;
/// Frames that the engine draws.
pub const FRAMES: usize = 10;

/// What klieg works with: the engine, and where its world is.
pub struct Stage<'a> {
    pub gpu: &'a Gpu,
    pub renderer: &'a Renderer,
    /// Centre and radius of the world.
    pub bounds: (DVec3, f64),
    /// Where pictures go.
    pub folder: &'a Path,
}

/// One rig's score by klieg in the engine, and natively.
pub type Scored = [f32; 2];

impl Stage<'_> {
    /// The engine's camera of a frame, which moves a little with every one, and what klieg is told.
    pub fn camera(&self, frame: usize) -> (Camera, EngineCamera) {
        let [width, height] = SIZE.map(f64::from);
        let camera = Camera::orbit(0.3 + 0.02 * frame as f64, width / height);
        let (center, radius) = self.bounds;
        let told =
            EngineCamera { view: camera.view, projection: camera.projection, center, radius };
        (camera, told)
    }

    /// Saves the engine's own pictures of the world under two rigs of klieg's.
    pub fn save(
        &self,
        level: &str,
        camera: &Camera,
        frame: &Frame,
        rigs: [&[LightRecord]; 2],
    ) -> Result<()> {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let rigs = rigs.map(|rig| lights(rig, frame));
        self.renderer.draw_pictures(self.gpu, &mut encoder, camera, &rigs);
        self.gpu.queue.submit([encoder.finish()]);
        for (layer, when) in ["before", "after"].into_iter().enumerate() {
            let file = self.folder.join(format!("{level}-{when}.png"));
            crate::picture::save(self.gpu, &self.renderer.pictures, layer as u32, &file)?;
        }
        Ok(())
    }
}

/// A search from lights in the middle of their ranges.
pub fn designer() -> Result<Designer> {
    let roles: [Role; LIGHTS] = [Role::Key, Role::Fill, Role::Rim];
    let genome = Genome::new(&roles, PROFILE.kind, &(PROFILE.boxes)())?;
    let genetic = GeneticSettings { population: RIGS as usize, ..GeneticSettings::endless() };
    let settings = Settings { genetic, ..Settings::default() };
    Ok(Designer::new(genome, "ga", &settings, None, 1)?)
}

/// The engine's lights for a rig of klieg's, which stands in the camera's axes around the world's
/// centre, in radii of the world.
pub fn lights(rig: &[LightRecord], frame: &Frame) -> [Light; LIGHTS] {
    let mut lights = [Light::zeroed(); LIGHTS];
    for (light, record) in lights.iter_mut().zip(rig) {
        let position = frame.point_to_world(glam::Vec3::from(record.position).as_dvec3());
        let reach2 = record.radius2 * (frame.radius * frame.radius) as f32;
        light.position = position.as_vec3().extend(reach2).to_array();
        light.intensity = [record.diffuse, record.specular, 0.0, 0.0];
    }
    lights
}
