//! A view that the device itself has drawn and measured.

use super::maps::MapStages;
use super::memory::ViewMemory;
use super::reader::Reader;
use super::records::{OPENNESS_LAYER, Records};
use super::shadows::{self, Casting, ShadowStage};
use super::visibility::Visibility;
use crate::Result;
use crate::cpu;
use crate::gpu::Context;
use crate::gpu::scene::drawable::Drawable;
use crate::gpu::vulkan::choice::{Lights, ShadowMaker};
use crate::gpu::vulkan::commands::{COMPUTE_WRITE, COPY_READ, Commands};
use crate::gpu::vulkan::memory::Buffer;
use crate::gpu::vulkan::staging;
use crate::gpu::vulkan::timer::StageTimer;
use crate::lighting::shading::Shading;
use crate::objective::Objective;
use crate::objective::maps::{Maps, PixelCounts, PixelType, Surface};
use crate::objective::shadows::{ShadowSettings, Shadows};
use crate::scene::Scene;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use ash::vk;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Stages that run once for each view.
const STAGES: u32 = 8;

/// What is known of a view whose maps the device has made, beside its [`ViewMemory`].
pub struct Drawn {
    /// A bit for each colour code, set where it occurs; none where codes may have any value.
    visible: Option<Buffer>,
    /// Milliseconds of each stage; empty where the device cannot tell.
    pub timings: Vec<(&'static str, f64)>,
    /// What casts shadows.
    occluders: Option<Arc<Occluders>>,
    context: Arc<Context>,
}

/// Draws the scene and makes the maps, ready for a generation; with `shadows` that are on, the shadow table
/// too, of the occluders in the view's light frame, which are found here where none are given. The scene itself need not stay on the device.
///
/// # Errors
/// [`crate::Error::Argument`] for a picture larger than the device can draw, as [`View::check`] and as
/// [`ShadowSettings::check`],
/// [`crate::Error::Unsupported`] when something of the scene is more than the device can take,
/// [`crate::Error::Input`] for a scene with more vertices than Vulkan can address, as
/// [`Scene::check`] and as [`Occluders::new`], and [device errors](crate::Error::is_device).
pub fn draw(
    context: &Arc<Context>,
    scene: &Scene,
    view: &View,
    (objective, shading): (&Objective, &Shading),
    lights: Lights,
    shadows: Option<(&ShadowSettings, Option<Arc<Occluders>>)>,
) -> Result<(ViewMemory, Drawn, Drawable)> {
    context.check_present()?;
    context.check_needs(context.needs().scene, "drawing scenes")?;
    let occluders = match shadows.filter(|(settings, _)| settings.on) {
        Some((settings, known)) => {
            let side = shadows::side(context, [view.width, view.height], settings)?;
            let made = || Occluders::new(scene, view).map(Arc::new);
            Some((known.map_or_else(made, Ok)?, side))
        }
        None => None,
    };
    let casting = occluders.as_ref().map(|&(ref occluders, side)| Casting { occluders, side });
    let mut memory = ViewMemory::new(context, view, (objective, shading), lights, casting)?;
    let g_buffer = memory.add_g_buffer(vk::ImageUsageFlags::COLOR_ATTACHMENT)?;
    let drawable = Drawable::new(context, scene, view, shading)?;
    let visibility = Visibility::new(context, &drawable, g_buffer)?;
    let occluders = occluders.map(|(occluders, _)| occluders);
    let drawn = Drawn::new(context, &memory, (scene.polygons(), occluders), |cmd| {
        visibility.record(cmd, &drawable)
    })?;
    Ok((memory, drawn, drawable))
}

impl Drawn {
    /// Makes the maps of what `draw` leaves in the G-buffer, whose colour codes are at most
    /// `polygons`, with the shadows of the occluders.
    fn new(
        context: &Arc<Context>,
        memory: &ViewMemory,
        (polygons, occluders): (u32, Option<Arc<Occluders>>),
        draw: impl FnOnce(vk::CommandBuffer),
    ) -> Result<Self> {
        let stages = MapStages::new(context, memory, Some(polygons))?;
        let records = Records::new(context, memory)?;
        let parts = ShadowStage::submissions(memory);
        let mut timer = StageTimer::new(context, STAGES + parts.len() as u32)?;
        Commands::once(context, |cmd| {
            timer.reset(cmd);
            timer.stage(cmd, "visibility", || draw(cmd));
            stages.record(cmd, memory, &mut timer);
            context.barrier(cmd, COMPUTE_WRITE, COPY_READ);
            Ok(())
        })?;
        let mut drawn = Self {
            visible: Some(stages.visible),
            timings: Vec::new(),
            occluders,
            context: Arc::clone(context),
        };
        let by_host = drawn.make_shadows(memory, &mut timer)?;
        Commands::once(context, |cmd| {
            timer.stage(cmd, "reflectance", || records.record(cmd, context, memory));
            context.barrier(cmd, COMPUTE_WRITE, COPY_READ);
            Ok(())
        })?;
        timer.read()?;
        drawn.timings.extend(timer.rows());
        if let (Some(time), false) = (by_host, drawn.timings.is_empty()) {
            drawn.timings.push(("shadows", time.as_secs_f64() * 1e3));
        }
        Ok(drawn)
    }

    /// Makes the shadow table, where there are shadows; the time that it took where the host made it.
    fn make_shadows(
        &self,
        memory: &ViewMemory,
        timer: &mut StageTimer,
    ) -> Result<Option<Duration>> {
        let Some(occluders) = &self.occluders else { return Ok(None) };
        let context = &self.context;
        if context.shadow_maker() == ShadowMaker::Device && memory.shadows.is_traceable() {
            let stage = ShadowStage::new(context, memory)?;
            for rows in ShadowStage::submissions(memory) {
                Commands::once(context, |cmd| {
                    timer.stage(cmd, "shadows", || stage.record(cmd, context, memory, rows));
                    Ok(())
                })?;
            }
            return Ok(None);
        }
        let start = Instant::now();
        let settings = ShadowSettings { on: true, side: memory.shadows.side, memory: u32::MAX };
        let surface = self.surface(memory)?.0;
        let shadows = cpu::shadows::table(&surface, Arc::clone(occluders), &settings);
        memory.shadows.upload(context, &shadows)?;
        Ok(Some(start.elapsed()))
    }

    /// Of a view whose maps an engine's commands make. What is read of it has no shadow table, as its
    /// occluders are not in the light frame.
    pub fn by_engine(context: &Arc<Context>) -> Self {
        Self { visible: None, timings: Vec::new(), occluders: None, context: Arc::clone(context) }
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
        let (surface, sobel, laplace) = self.surface(memory)?;
        let reader = Reader::new(&self.context, memory.size)?;
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
        let shadows = self.shadows(memory, &surface)?;
        let target = Vec::new();
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

    /// The surface, and the depth's Sobel length and Laplacian.
    fn surface(&self, memory: &ViewMemory) -> Result<(Surface, Vec<f32>, Vec<f32>)> {
        let g_buffer = memory.g_buffer.as_ref().expect("the view was drawn into it");
        Reader::new(&self.context, memory.size)?.surface(g_buffer, memory.size)
    }

    /// The shadow table with the ambient occlusion, where there are shadows.
    fn shadows(&self, memory: &ViewMemory, surface: &Surface) -> Result<Option<Shadows>> {
        let Some(occluders) = &self.occluders else { return Ok(None) };
        let object = surface.code.iter().map(|&code| code != 0);
        let mut shadows = Shadows::new(memory.shadows.side, object.clone(), Arc::clone(occluders));
        memory.shadows.read(&self.context, &mut shadows)?;
        let reader = Reader::new(&self.context, memory.size)?;
        let texels: Vec<[f32; 4]> = reader.layer(&memory.colors, OPENNESS_LAYER)?;
        let open = texels.iter().zip(object).filter(|&(_, object)| object).map(|(t, _)| t[3]);
        shadows.set_openness(open.collect());
        Ok(Some(shadows))
    }
}

/// Positions of the bits that are set, ascending.
fn set_bits(words: &[u32]) -> Vec<u32> {
    let bits = |(i, &word): (usize, &u32)| {
        (0..32).filter(move |bit| word >> bit & 1 != 0).map(move |bit| 32 * i as u32 + bit)
    };
    words.iter().enumerate().flat_map(bits).collect()
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
            ViewMemory::new(context, view, (&objective, &shading), Lights::Plain, None).unwrap();
        testing::upload_surface(
            context,
            surface,
            memory.add_g_buffer(vk::ImageUsageFlags::COLOR_ATTACHMENT).unwrap(),
        );
        let polygons = surface.code.iter().copied().max().unwrap_or(0);
        let drawn = Drawn::new(context, &memory, (polygons, None), |_| ()).unwrap();
        drawn.read(&memory).unwrap()
    }

    /// What of the stages' results differs from the references'.
    fn differences(ours: &Maps, references: &Maps) -> Vec<&'static str> {
        let close = |a: &[f32], b: &[f32]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5)
        };
        let object = |face: &[f32; 3], at: usize| match references.surface.code[at] {
            0 => [0.0; 3],
            _ => *face,
        };
        let faces = |maps: &Maps| -> Vec<f32> {
            let faces = maps.surface.face.iter().zip(0..).map(|(face, at)| object(face, at));
            faces.flatten().collect()
        };
        // The polygon's normal has gone through a code.
        let surface = Surface { face: references.surface.face.clone(), ..ours.surface.clone() };
        let same = [
            ("surface", surface == references.surface),
            ("face", close(&faces(ours), &faces(references))),
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
