//! The engine's renderer: a G-buffer pass, a shading pass, and two frames in flight.

use crate::Result;
use crate::passes::{self, Pass, STAGES};
use crate::vulkan::{Buffer, Gpu, Image};
use crate::world::{Thing, World};
use ash::vk;
use bytemuck::{Pod, Zeroable};
use image::RgbImage;
use klieg::scene::engine::EngineCamera;

const MAX_LIGHTS: usize = 4;
/// Scores of a frame at most.
const MAX_SCORES: usize = 64;
/// How the passes leave the G-buffer and the picture.
pub const SAMPLED: vk::ImageLayout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
const COPIED: vk::ImageLayout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;

/// A light as the shaders read it: see `Light` in frame.glsl.
#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
pub struct LightUniform {
    pub place: [f32; 4],
    pub diffuse: f32,
    pub specular: f32,
    pub reach2: f32,
    pub padding: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Default, Pod, Zeroable)]
struct Uniforms {
    clip_from_world: [[f32; 4]; 4],
    world_from_clip: [[f32; 4]; 4],
    eye: [f32; 4],
    lights: [LightUniform; MAX_LIGHTS],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Draw {
    world_from_mesh: [[f32; 4]; 4],
    base_color: [f32; 4],
    roughness: f32,
    metallic: f32,
    id: u32,
    padding: u32,
}

/// A thing of the world: where its mesh is in the buffers, and what it looks like.
struct Item {
    indices: std::ops::Range<u32>,
    first_vertex: i32,
    draw: Draw,
}

/// What a frame in flight has for itself. The images are shared: the passes' barriers order the frames.
struct Slot {
    cmd: vk::CommandBuffer,
    done: vk::Fence,
    set: vk::DescriptorSet,
    uniforms: Buffer,
    scores: Buffer,
    texels: Buffer,
}

/// A frame that is being recorded.
pub struct Frame {
    pub slot: usize,
    pub cmd: vk::CommandBuffer,
    /// Where klieg may leave scores, visible to the host when the frame has run.
    pub scores: vk::Buffer,
    uniforms: Uniforms,
}

pub struct Renderer<'a> {
    gpu: &'a Gpu,
    size: [u32; 2],
    /// Depth, normals, base colours, roughness and metallic factor, ids.
    pub g_buffer: [Image; 5],
    /// The base colours as they are stored, sRGB-encoded.
    pub encoded_colors: vk::ImageView,
    picture: Image,
    geometry: Pass,
    shading: Pass,
    layout: vk::PipelineLayout,
    vertices: [Buffer; 3],
    items: Vec<Item>,
    slots: [Slot; 2],
    frames: usize,
}

impl<'a> Renderer<'a> {
    pub fn new(gpu: &'a Gpu, world: &World, size: [u32; 2]) -> Result<Self> {
        use vk::{Format, ImageUsageFlags as Usage};
        let color = |format| gpu.image(size, format, Usage::COLOR_ATTACHMENT | Usage::SAMPLED);
        let depth = Usage::DEPTH_STENCIL_ATTACHMENT | Usage::SAMPLED;
        let g_buffer = [
            gpu.image(size, Format::D32_SFLOAT, depth)?,
            color(Format::R16G16B16A16_SFLOAT)?,
            color(Format::R8G8B8A8_SRGB)?,
            color(Format::R8G8_UNORM)?,
            color(Format::R32_UINT)?,
        ];
        let encoded_colors = gpu.view(g_buffer[2].raw, Format::R8G8B8A8_UNORM)?;
        let copied = Usage::COLOR_ATTACHMENT | Usage::TRANSFER_SRC;
        let picture = gpu.image(size, Format::R8G8B8A8_SRGB, copied)?;
        let (set_layout, layout) = passes::layouts(gpu)?;
        let world_shaders =
            [include_str!("shaders/world.vert"), include_str!("shaders/world.frag")];
        let shade_shaders =
            [include_str!("shaders/screen.vert"), include_str!("shaders/shade.frag")];
        let geometry = Pass::new(gpu, &g_buffer, SAMPLED, size, layout, world_shaders)?;
        let shading = Pass::new(gpu, &[picture], COPIED, size, layout, shade_shaders)?;
        let (vertices, items) = upload(gpu, world)?;
        let slot = || Slot::new(gpu, set_layout, &g_buffer, size);
        let slots = [slot()?, slot()?];
        let frames = 0;
        Ok(Self {
            gpu,
            size,
            g_buffer,
            encoded_colors,
            picture,
            geometry,
            shading,
            layout,
            vertices,
            items,
            slots,
            frames,
        })
    }

    /// Waits for the frame before the last, and draws the G-buffer. When this returns it is visible to
    /// compute and fragment shaders, for what is recorded into the frame until [`Renderer::end`].
    pub fn begin(&mut self, camera: &EngineCamera) -> Result<Frame> {
        let (slot, device) = (self.frames % self.slots.len(), &self.gpu.device);
        self.frames += 1;
        let Slot { cmd, done, set, ref scores, .. } = self.slots[slot];
        let clip = camera.projection * camera.view;
        let eye = camera.view.inverse().w_axis.as_vec4();
        let uniforms = Uniforms {
            clip_from_world: clip.as_mat4().to_cols_array_2d(),
            world_from_clip: clip.inverse().as_mat4().to_cols_array_2d(),
            eye: eye.to_array(),
            ..Uniforms::default()
        };
        // SAFETY: the slot's last frame has run; all that is bound outlives this one.
        unsafe {
            device.wait_for_fences(&[done], true, u64::MAX)?;
            device.begin_command_buffer(cmd, &vk::CommandBufferBeginInfo::default())?;
            self.geometry.begin(device, cmd);
            let (graphics, layout) = (vk::PipelineBindPoint::GRAPHICS, self.layout);
            device.cmd_bind_descriptor_sets(cmd, graphics, layout, 0, &[set], &[]);
            let [positions, normals, indices] = &self.vertices;
            device.cmd_bind_vertex_buffers(cmd, 0, &[positions.raw, normals.raw], &[0, 0]);
            device.cmd_bind_index_buffer(cmd, indices.raw, 0, vk::IndexType::UINT32);
            for Item { indices, first_vertex, draw } in &self.items {
                let (stages, count) = (STAGES, indices.len() as u32);
                device.cmd_push_constants(cmd, layout, stages, 0, bytemuck::bytes_of(draw));
                device.cmd_draw_indexed(cmd, count, 1, indices.start, *first_vertex, 0);
            }
            device.cmd_end_render_pass(cmd);
        }
        Ok(Frame { slot, cmd, scores: scores.raw, uniforms })
    }

    /// Shades the picture under `lights`, and submits the frame.
    pub fn end(&mut self, frame: Frame, lights: &[LightUniform]) -> Result<()> {
        let Frame { slot, cmd, mut uniforms, .. } = frame;
        let (device, slot) = (&self.gpu.device, &self.slots[slot]);
        uniforms.lights[..lights.len()].copy_from_slice(lights);
        uniforms.eye[3] = lights.len() as f32;
        slot.uniforms.write(&[uniforms]);
        let (graphics, none) = (vk::PipelineBindPoint::GRAPHICS, vk::DependencyFlags::empty());
        let [width, height] = self.size;
        let layers = vk::ImageSubresourceLayers::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .layer_count(1);
        let region = vk::BufferImageCopy::default()
            .image_subresource(layers)
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        // The picture's and the scores' copies become visible to the host.
        let copied = vk::MemoryBarrier::default()
            .src_access_mask(vk::AccessFlags::TRANSFER_WRITE)
            .dst_access_mask(vk::AccessFlags::HOST_READ);
        let (transfer, host) = (vk::PipelineStageFlags::TRANSFER, vk::PipelineStageFlags::HOST);
        let cmds = [cmd];
        let info = vk::SubmitInfo::default().command_buffers(&cmds);
        // SAFETY: as in `begin`. What klieg has bound is bound anew.
        unsafe {
            self.shading.begin(device, cmd);
            device.cmd_bind_descriptor_sets(cmd, graphics, self.layout, 0, &[slot.set], &[]);
            device.cmd_draw(cmd, 3, 1, 0, 0);
            device.cmd_end_render_pass(cmd);
            let (from, to) = (self.picture.raw, slot.texels.raw);
            device.cmd_copy_image_to_buffer(cmd, from, COPIED, to, &[region]);
            device.cmd_pipeline_barrier(cmd, transfer, host, none, &[copied], &[], &[]);
            device.end_command_buffer(cmd)?;
            device.reset_fences(&[slot.done])?;
            Ok(device.queue_submit(self.gpu.queue, &[info], slot.done)?)
        }
    }

    /// What klieg has left in a frame that has run.
    pub fn scores(&self, slot: usize, count: usize) -> Vec<f32> {
        let mut scores = vec![0.0; count];
        self.slots[slot].scores.read(&mut scores);
        scores
    }

    /// Waits for all frames.
    pub fn finish(&self) -> Result<()> {
        let fences = [self.slots[0].done, self.slots[1].done];
        // SAFETY: the fences are alive, and signalled or submitted.
        unsafe { self.gpu.device.wait_for_fences(&fences, true, u64::MAX)? };
        Ok(())
    }

    /// The picture of a frame, when all have run.
    pub fn picture(&self, slot: usize) -> Result<RgbImage> {
        self.finish()?;
        let [width, height] = self.size;
        let mut texels = vec![[0_u8; 4]; (width * height) as usize];
        self.slots[slot].texels.read(&mut texels);
        let rgb = texels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        RgbImage::from_raw(width, height, rgb).ok_or_else(|| "no picture".into())
    }
}

impl Drop for Renderer<'_> {
    fn drop(&mut self) {
        // SAFETY: the device is alive; one that is lost has nothing to wait for.
        let _ = unsafe { self.gpu.device.device_wait_idle() };
    }
}

impl Slot {
    fn new(
        gpu: &Gpu,
        layout: vk::DescriptorSetLayout,
        g_buffer: &[Image],
        [width, height]: [u32; 2],
    ) -> Result<Self> {
        let uniforms = gpu.buffer(size_of::<Uniforms>(), vk::BufferUsageFlags::UNIFORM_BUFFER)?;
        let copied = |bytes| gpu.buffer(bytes, vk::BufferUsageFlags::TRANSFER_DST);
        let scores = copied(4 * MAX_SCORES)?;
        let texels = copied(4 * (width * height) as usize)?;
        let set = passes::set(gpu, layout, &uniforms, g_buffer)?;
        let (device, reset) = (&gpu.device, vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(gpu.family).flags(reset);
        let signaled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
        // SAFETY: the device is alive; pool and fence go when nothing runs any more.
        unsafe {
            let pool = device.create_command_pool(&pool, None)?;
            gpu.finally(move |device| device.destroy_command_pool(pool, None));
            let info =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let cmd = device.allocate_command_buffers(&info)?[0];
            let done = device.create_fence(&signaled, None)?;
            gpu.finally(move |device| device.destroy_fence(done, None));
            Ok(Self { cmd, done, set, uniforms, scores, texels })
        }
    }
}

/// All meshes in three buffers: positions, normals, indices.
fn upload(gpu: &Gpu, world: &World) -> Result<([Buffer; 3], Vec<Item>)> {
    let (mut positions, mut normals, mut indices, mut places) = (vec![], vec![], vec![], vec![]);
    for mesh in &world.meshes {
        let first = indices.len() as u32;
        places.push((first..first + mesh.indices.len() as u32, positions.len() as i32));
        positions.extend_from_slice(&mesh.positions);
        normals.extend_from_slice(&mesh.normals);
        indices.extend_from_slice(&mesh.indices);
    }
    let item = |(i, thing): (usize, &Thing)| {
        let (indices, first_vertex) = places[thing.mesh].clone();
        let ([r, g, b], roughness, metallic) = thing.material();
        let draw = Draw {
            world_from_mesh: thing.world_from_mesh.as_mat4().to_cols_array_2d(),
            base_color: [r, g, b, 1.0],
            roughness,
            metallic,
            id: i as u32 + 1,
            padding: 0,
        };
        Item { indices, first_vertex, draw }
    };
    let items = world.things.iter().enumerate().map(item).collect();
    let (vertex, index) = (vk::BufferUsageFlags::VERTEX_BUFFER, vk::BufferUsageFlags::INDEX_BUFFER);
    let buffers = [
        gpu.filled(&positions, vertex)?,
        gpu.filled(&normals, vertex)?,
        gpu.filled(&indices, index)?,
    ];
    Ok((buffers, items))
}
