//! What the unit tests of the stages share: a watched device, small maps, and reading images back.

use super::measure::generation::{Fitness, GenerationMemory, Measure};
use super::view::g_buffer::{BASE_COLOR_LAYER, EMISSIVE_LAYER, GBuffer};
use super::view::memory::ViewMemory;
use super::vulkan::commands::{COPY_WRITE, Commands, HOST_READ};
use super::vulkan::memory::{Access, Buffer, Image};
use super::vulkan::pipeline::RigKind;
use super::{Context, ContextOptions, Tuning};
use crate::cpu;
use crate::lighting::LightRecord;
use crate::math::frame::Frame;
use crate::objective::maps::{Maps, PixelCounts, PixelType, Surface};
use crate::objective::shadows::place;
use crate::scene::Scene;
use crate::scene::build::{MeshData, SceneBuilder};
use crate::scene::view::{Camera, Projection, View};
use ash::vk;
use bytemuck::Pod;
use glam::{DMat4, DVec3, Mat4, Vec3};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A software or hardware device with the validation layer on: a machine without fails the test.
pub fn context() -> Arc<Context> {
    with_tuning(Tuning::default())
}

/// The same with other tuning.
pub fn with_tuning(tuning: Tuning) -> Arc<Context> {
    alone();
    let options = ContextOptions { validation: true, tuning, ..Default::default() };
    Context::new(&options).expect("a Vulkan device and the validation layer")
}

/// The same that is dry.
pub fn dry(tuning: &Tuning) -> Arc<Context> {
    alone();
    let options = ContextOptions { validation: true, tuning: tuning.clone(), ..Default::default() };
    Context::dry(&options).expect("a Vulkan device and the validation layer")
}

/// From here to its thread's end, keeps other tests from validation layers, some of which (1.3.239) crash where two
/// threads make devices at once (KhronosGroup/Vulkan-ValidationLayers#4391). The packaged crate has no other crate of
/// tests to take this from.
fn alone() {
    static LAYER: Mutex<()> = Mutex::new(());
    thread_local! {
        static HELD: MutexGuard<'static, ()> = LAYER.lock().unwrap_or_else(PoisonError::into_inner);
    }
    HELD.with(|_| ());
}

/// Fails when the validation layer has said anything.
pub fn assert_valid(context: &Context) {
    let messages = context.validation_messages();
    assert!(messages.is_empty(), "{}", messages.join("\n\n"));
}

/// A view from +z, four scene radii away.
pub fn view(width: u32, height: u32) -> View {
    let camera = Camera {
        name: "test".into(),
        eye: DVec3::Z * 4.0,
        right: DVec3::X,
        up: DVec3::Y,
        back: DVec3::Z,
        projection: Projection::Perspective { yfov: 0.6 },
        near: 0.1,
        far: None,
        designed: None,
    };
    let frame =
        Frame { center: DVec3::ZERO, radius: 1.0, right: DVec3::X, up: DVec3::Y, back: DVec3::Z };
    let eye = Vec3::Z * 4.0;
    View { width, height, camera, frame, eye, clip_from_frame: Mat4::IDENTITY }
}

/// A scene with a tetrahedron, from the front.
pub fn tetrahedron([width, height]: [u32; 2]) -> (Scene, View) {
    let positions = [[1., 1., 1.], [-1., -1., 1.], [-1., 1., -1.], [1., -1., -1.]];
    let indices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let mut builder = SceneBuilder::default();
    let mesh = MeshData { positions: &positions, indices: Some(&indices), ..MeshData::default() };
    let mesh = builder.add_mesh(&mesh).unwrap();
    builder.add_instance("tetrahedron", mesh, DMat4::IDENTITY).unwrap();
    let scene = builder.finish("test").unwrap();
    let lens = Projection::Perspective { yfov: 0.7 };
    let eye = DVec3::new(1.0, 2.0, 6.0);
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, lens).unwrap();
    let view = View::new(&scene, camera, width, height).unwrap();
    (scene, view)
}

/// Maps of a bumpy sphere with many materials; every seventh object pixel is EDGE.
pub fn maps(width: u32, height: u32) -> (Maps, View) {
    let n = (width * height) as usize;
    let mut maps = Maps {
        surface: Surface { width, height, ..Default::default() },
        normal_detail: 0.1,
        ..Default::default()
    };
    let surface = &mut maps.surface;
    for i in 0..n {
        let x = 2.2 * ((i % width as usize) as f32 + 0.5) / width as f32 - 1.1;
        let y = 1.1 - 2.2 * ((i / width as usize) as f32 + 0.5) / height as f32;
        let r2 = x * x + y * y;
        let wave = |k: usize| (((i * k) % 101) as f32) / 100.0;
        let inside = r2 < 1.0;
        let z = (1.0 - r2).max(0.0).sqrt();
        let keep = |v: [f32; 3]| if inside { v } else { [0.0; 3] };
        let normal = Vec3::new(x, y, z + 0.2 * wave(3)).normalize();
        let kind = match (inside, i % 7) {
            (false, _) => PixelType::Background,
            (true, 0) => PixelType::Edge,
            (true, _) => PixelType::Surface,
        };
        surface.code.push(inside.into());
        surface.depth.push(4.0 - z);
        surface.position.push(keep([x, y, z]));
        surface.normal.push(keep(normal.to_array()));
        surface.face.push(keep(Vec3::new(x, y, z).normalize().to_array()));
        surface.base_color.push(keep([wave(5), wave(7), wave(11)]));
        surface.metallic.push(keep([wave(13); 3])[0]);
        surface.roughness.push(keep([wave(17); 3])[0]);
        surface.emissive.push(keep([0.1 * wave(19), 0.0, 0.0]));
        maps.types.push(kind);
    }
    (maps.sobel, maps.laplace) = (vec![0.0; n], vec![0.0; n]);
    maps.normal_gradient = cpu::normal_detail::normal_detail(&maps.surface, &maps.types).0;
    maps.counts = PixelCounts::of(&maps.types);
    (maps, view(width, height))
}

/// So many lights of all kinds.
pub fn lights(count: usize) -> Vec<LightRecord> {
    let light = |i: usize| LightRecord {
        position: [(i % 5) as f32 - 2.0, (i % 7) as f32 - 3.0, 3.0],
        radius2: [0.0, 9.0, 4.0][i % 3],
        diffuse: 0.1 * (i % 9) as f32,
        specular: 0.5,
        ..LightRecord::DARK
    };
    (0..count).map(light).collect()
}

/// The scores of `individuals` rigs whose lights stand one after the other, measured in this way.
pub fn scores(
    context: &Arc<Context>,
    (memory, measure): (&mut ViewMemory, &mut dyn Measure),
    (individuals, lights): (u32, &[LightRecord]),
) -> Vec<f32> {
    let rigs = RigKind { lights: lights.len() / individuals as usize, near: false };
    measure.prepare(memory, rigs).unwrap();
    let fitness = Fitness::new(context, memory, measure).unwrap();
    let size = (individuals, lights.len());
    let mut generation = GenerationMemory::new(context, memory, measure, size).unwrap();
    generation.lights.write(lights).unwrap();
    Commands::once(context, |cmd| {
        let stages = (&*memory, &*measure, &fitness);
        generation.record(cmd, context, stages, (individuals, rigs));
        Ok(())
    })
    .unwrap();
    let mut scores = vec![0.0f32; individuals as usize];
    generation.scores.read(&mut scores).unwrap();
    scores
}

/// Puts the surface where the visibility draw would put it.
pub fn upload_surface(context: &Arc<Context>, surface: &Surface, to: &GBuffer) {
    let join = |a: &[[f32; 3]], b: &[f32]| -> Vec<[f32; 4]> {
        a.iter().zip(b).map(|(a, &b)| [a[0], a[1], a[2], b]).collect()
    };
    let face = |k: usize| -> Vec<f32> {
        surface.face.iter().map(|&face| place(face.into())[k] * 2.0 - 1.0).collect()
    };
    let source = vk::BufferUsageFlags::TRANSFER_SRC;
    let vec4 = [
        (join(&surface.position, &surface.roughness), (&to.position_roughness, 0)),
        (join(&surface.normal, &surface.metallic), (&to.normal_metallic, 0)),
        (join(&surface.base_color, &face(0)), (&to.material, BASE_COLOR_LAYER)),
        (join(&surface.emissive, &face(1)), (&to.material, EMISSIVE_LAYER)),
    ]
    .map(|(data, image)| (Buffer::of(context, "upload", &data, source).unwrap(), image));
    let code = Buffer::of(context, "upload", &surface.code, source).unwrap();
    Commands::once(context, |cmd| {
        context.upload(cmd, &code, (&to.code, 0));
        for &(ref buffer, layer) in &vec4 {
            context.upload(cmd, buffer, layer);
        }
        Ok(())
    })
    .unwrap();
}

/// Reads a whole image in layout `GENERAL`.
pub fn download<T: Pod>(context: &Arc<Context>, image: &Image) -> Vec<T> {
    download_layer(context, image, 0)
}

/// Reads a layer of an image in layout `GENERAL`.
pub fn download_layer<T: Pod>(context: &Arc<Context>, image: &Image, layer: u32) -> Vec<T> {
    let extent = image.extent();
    let mut out = vec![T::zeroed(); (extent.width * extent.height) as usize];
    let usage = vk::BufferUsageFlags::TRANSFER_DST;
    let size = size_of_val(out.as_slice()) as u64;
    let buffer = Buffer::new(context, "download", size, usage, Access::Readback).unwrap();
    Commands::once(context, |cmd| {
        context.download(cmd, (image, vk::ImageLayout::GENERAL, layer), &buffer);
        context.barrier(cmd, COPY_WRITE, HOST_READ);
        Ok(())
    })
    .unwrap();
    buffer.read(&mut out).unwrap();
    out
}
