//! A view that the device itself has drawn and measured.

use super::maps::MapStages;
use super::memory::{GBuffer, ViewMemory};
use super::records::Records;
use super::visibility::Visibility;
use crate::Result;
use crate::cpu;
use crate::gpu::Context;
use crate::gpu::scene::drawable::Drawable;
use crate::gpu::vulkan::choice::Lights;
use crate::gpu::vulkan::commands::{
    COMPUTE_WRITE, COPY_READ, COPY_WRITE, Commands, HOST_READ, StageTimer,
};
use crate::gpu::vulkan::memory::{Access, Buffer, Image};
use crate::gpu::vulkan::staging;
use crate::lighting::shading::Shading;
use crate::objective::Objective;
use crate::objective::maps::{Maps, PixelCounts, PixelType, Surface};
use crate::scene::Scene;
use crate::scene::view::View;
use ash::vk;
use bytemuck::Pod;
use std::sync::Arc;

/// Stages that run once for each view.
const STAGES: u32 = 8;

/// What is known of a view whose maps the device has made, beside its [`ViewMemory`].
pub struct Drawn {
    /// A bit for each colour code, set where it occurs; none where codes may have any value.
    visible: Option<Buffer>,
    /// Milliseconds of each stage; empty where the device cannot tell.
    pub timings: Vec<(&'static str, f64)>,
    context: Arc<Context>,
}

/// Draws the scene and makes the maps, ready for a generation. The scene itself need not stay on the
/// device.
///
/// # Errors
/// [`crate::Error::Argument`] for a picture larger than the device can draw and as [`View::check`],
/// [`crate::Error::Unsupported`] when something of the scene is more than the device can take,
/// [`crate::Error::Input`] for a scene with more vertices than Vulkan can address and as
/// [`Scene::check`], and [device errors](crate::Error::is_device).
pub fn draw(
    context: &Arc<Context>,
    scene: &Scene,
    view: &View,
    objective: &Objective,
    shading: &Shading,
    lights: Lights,
) -> Result<(ViewMemory, Drawn, Drawable)> {
    context.check_present()?;
    context.check_needs(context.needs().scene, "drawing scenes")?;
    let mut memory = ViewMemory::new(context, view, objective, shading, lights)?;
    let g_buffer = memory.add_g_buffer(vk::ImageUsageFlags::COLOR_ATTACHMENT)?;
    let drawable = Drawable::new(context, scene, view, shading)?;
    let visibility = Visibility::new(context, &drawable, g_buffer)?;
    let drawn =
        Drawn::new(context, &memory, scene.polygons(), |cmd| visibility.record(cmd, &drawable))?;
    Ok((memory, drawn, drawable))
}

impl Drawn {
    /// Makes the maps of what `draw` leaves in the G-buffer, whose colour codes are at most
    /// `polygons`.
    fn new(
        context: &Arc<Context>,
        memory: &ViewMemory,
        polygons: u32,
        draw: impl FnOnce(vk::CommandBuffer),
    ) -> Result<Self> {
        let stages = MapStages::new(context, memory, Some(polygons))?;
        let records = Records::new(context, memory)?;
        let mut timer = StageTimer::new(context, STAGES)?;
        Commands::once(context, |cmd| {
            timer.reset(cmd);
            timer.stage(cmd, "visibility", || draw(cmd));
            stages.record(cmd, memory, &mut timer);
            timer.stage(cmd, "reflectance", || records.record(cmd, context, memory));
            context.barrier(cmd, COMPUTE_WRITE, COPY_READ);
            Ok(())
        })?;
        timer.read()?;
        let timings = timer.rows().to_vec();
        Ok(Self { visible: Some(stages.visible), timings, context: Arc::clone(context) })
    }

    /// Of a view whose maps an engine's commands make.
    pub fn by_engine(context: &Arc<Context>) -> Self {
        Self { visible: None, timings: Vec::new(), context: Arc::clone(context) }
    }

    /// Object pixels of the view.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn objects(&self, memory: &ViewMemory) -> Result<u32> {
        Ok(memory.read_statistics()?.objects())
    }

    /// Reads the maps back from the view's memory.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn read(&self, memory: &ViewMemory) -> Result<Maps> {
        let g_buffer = memory.g_buffer.as_ref().expect("the view was drawn into it");
        let reader = Reader::new(&self.context, memory.size)?;
        let (surface, sobel, laplace) = reader.surface(g_buffer, memory.size)?;
        let kind = |number| match number {
            0 => PixelType::Background,
            1 => PixelType::Surface,
            _ => PixelType::Edge,
        };
        let types: Vec<_> = reader.image::<u32>(&memory.types)?.into_iter().map(kind).collect();
        let statistics = memory.read_statistics()?;
        let counts = PixelCounts { surface: statistics.surface, edge: statistics.edge };
        let visible = match &self.visible {
            Some(bits) => {
                let words = bits.size() as usize / size_of::<u32>();
                set_bits(&staging::read_buffer(&self.context, bits, words)?)
            }
            None => cpu::visible::visible(&surface.code),
        };
        let normal_detail = statistics.normal_detail;
        let (normal_gradient, _) = cpu::normal_detail::normal_detail(&surface, &types);
        let shape = cpu::shape::shape(&surface, &types, &normal_gradient);
        let (target, shadows) = (Vec::new(), None);
        Ok(Maps {
            surface,
            sobel,
            laplace,
            types,
            counts,
            visible,
            normal_gradient,
            normal_detail,
            shape,
            target,
            shadows,
        })
    }
}

/// Positions of the bits that are set, ascending.
fn set_bits(words: &[u32]) -> Vec<u32> {
    let bits = |(i, &word): (usize, &u32)| {
        (0..32).filter(move |bit| word >> bit & 1 != 0).map(move |bit| 32 * i as u32 + bit)
    };
    words.iter().enumerate().flat_map(bits).collect()
}

/// Reads images of one size through one buffer.
struct Reader {
    buffer: Buffer,
    pixels: usize,
    context: Arc<Context>,
}

impl Reader {
    fn new(context: &Arc<Context>, [width, height]: [u32; 2]) -> Result<Self> {
        let pixels = width as usize * height as usize;
        let size = (pixels * size_of::<[f32; 4]>()) as u64;
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let buffer = Buffer::new(context, "readback", size, usage, Access::Readback)?;
        Ok(Self { buffer, pixels, context: Arc::clone(context) })
    }

    /// One entry a pixel of an image in layout `GENERAL`.
    fn image<T: Pod>(&self, image: &Image) -> Result<Vec<T>> {
        Commands::once(&self.context, |cmd| {
            let from = (image, vk::ImageLayout::GENERAL, 0);
            self.context.download(cmd, from, &self.buffer);
            self.context.barrier(cmd, COPY_WRITE, HOST_READ);
            Ok(())
        })?;
        let mut out = vec![T::zeroed(); self.pixels];
        self.buffer.read(&mut out)?;
        Ok(out)
    }

    /// The first three components and the last.
    fn split(&self, image: &Image) -> Result<(Vec<[f32; 3]>, Vec<f32>)> {
        let texels: Vec<[f32; 4]> = self.image(image)?;
        Ok(texels.into_iter().map(|[x, y, z, w]| ([x, y, z], w)).unzip())
    }

    /// The surface, and the depth's Sobel length and Laplacian.
    fn surface(
        &self,
        g_buffer: &GBuffer,
        [width, height]: [u32; 2],
    ) -> Result<(Surface, Vec<f32>, Vec<f32>)> {
        let (position, roughness) = self.split(&g_buffer.position_roughness)?;
        let (normal, metallic) = self.split(&g_buffer.normal_metallic)?;
        let surface = Surface {
            width,
            height,
            code: self.image(&g_buffer.code)?,
            depth: self.image(&g_buffer.depth)?,
            position,
            face: normal.clone(),
            normal,
            base_color: self.split(&g_buffer.base_color)?.0,
            metallic,
            roughness,
            emissive: self.split(&g_buffer.emissive)?.0,
        };
        Ok((surface, self.image(&g_buffer.sobel)?, self.image(&g_buffer.laplace)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::testing;

    /// A bumpy sphere with steps of depth and 97 polygons.
    fn surface(width: u32, height: u32) -> (Surface, View) {
        let (maps, view) = testing::maps(width, height);
        let mut surface = maps.surface;
        for (i, code) in surface.code.iter_mut().enumerate() {
            *code *= 31 + (i as u32 * 7) % 97;
            let position = &mut surface.position[i];
            position[2] -= 0.05 * (4.0 * position[0]).floor();
            surface.depth[i] = view.eye.z - position[2];
        }
        (surface, view)
    }

    fn measured(context: &Arc<Context>, surface: &Surface, view: &View) -> Maps {
        let (objective, shading) = (Objective::default(), Shading::default());
        let mut memory =
            ViewMemory::new(context, view, &objective, &shading, Lights::Plain).unwrap();
        testing::upload_surface(
            context,
            surface,
            memory.add_g_buffer(vk::ImageUsageFlags::COLOR_ATTACHMENT).unwrap(),
        );
        let polygons = surface.code.iter().copied().max().unwrap_or(0);
        let drawn = Drawn::new(context, &memory, polygons, |_| ()).unwrap();
        drawn.read(&memory).unwrap()
    }

    /// What of the stages' results differs from the references'.
    fn differences(ours: &Maps, references: &Maps) -> Vec<&'static str> {
        let close = |a: &[f32], b: &[f32]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5)
        };
        let same = [
            ("surface", ours.surface == references.surface),
            ("sobel", close(&ours.sobel, &references.sobel)),
            ("laplace", close(&ours.laplace, &references.laplace)),
            ("types", ours.types == references.types),
            ("counts", ours.counts == references.counts),
            ("visible", ours.visible == references.visible),
            ("normal detail", close(&[ours.normal_detail], &[references.normal_detail])),
        ];
        same.into_iter().filter(|&(_, same)| !same).map(|(name, _)| name).collect()
    }

    #[test]
    fn every_stage_agrees_with_its_reference() {
        let context = testing::context();
        for (width, height) in [(37, 19), (1, 1), (4096, 3), (129, 65), (3, 200), (64, 16)] {
            let (surface, view) = surface(width, height);
            let ours = measured(&context, &surface, &view);
            let references = cpu::maps(surface, &Objective::default());
            assert_eq!(differences(&ours, &references), [""; 0], "{width}x{height}");
        }
        testing::assert_valid(&context);
    }

    #[test]
    fn an_empty_picture_has_a_background_and_nothing_else() {
        let context = testing::context();
        let (mut surface, view) = surface(20, 10);
        surface.code.fill(0);
        surface.depth.fill(0.0);
        let ours = measured(&context, &surface, &view);
        assert_eq!(differences(&ours, &cpu::maps(surface, &Objective::default())), [""; 0]);
        assert_eq!((ours.counts.object(), ours.surface.depth[7]), (0, 1.0));
        testing::assert_valid(&context);
    }

    #[test]
    fn one_pixel_is_enough_to_differ() {
        let context = testing::context();
        let (surface, view) = surface(37, 19);
        let references = cpu::maps(surface.clone(), &Objective::default());
        let at = 9 * 37 + 18;
        assert_ne!(surface.code[at], 0);

        let mut nearer = surface.clone();
        nearer.position[at][2] += 0.3;
        let found = differences(&measured(&context, &nearer, &view), &references);
        assert_eq!(found, ["surface", "sobel", "laplace", "types", "counts", "normal detail"]);

        let mut renumbered = surface.clone();
        renumbered.code[at] = 500;
        let found = differences(&measured(&context, &renumbered, &view), &references);
        assert_eq!(found, ["surface", "visible"]);

        let mut turned = surface.clone();
        turned.normal[at] = [1.0, 0.0, 0.0];
        let found = differences(&measured(&context, &turned, &view), &references);
        assert_eq!(found, ["surface", "normal detail"]);
        testing::assert_valid(&context);
    }

    #[test]
    fn bits_become_ascending_numbers() {
        assert_eq!(set_bits(&[0x8000_0002, 0, 1]), [1, 31, 64]);
    }
}
