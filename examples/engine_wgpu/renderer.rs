//! The engine's renderer: a G-buffer of the world, and pictures of it under many rigs of lights.

use crate::gpu::Gpu;
use crate::world::{Camera, Vertex, World};
use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt;
use wgpu::{TextureFormat, TextureUses};

/// Lights of a rig; `LIGHTS` of `scene.wgsl`.
pub const LIGHTS: usize = 3;

/// A point light, as `scene.wgsl` reads it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct Light {
    /// World position, and the square of the distance at which the falloff is 1.
    pub position: [f32; 4],
    /// Diffuse and specular intensity, and padding.
    pub intensity: [f32; 4],
}

/// `Frame` of `scene.wgsl`, padded to the distance of dynamic offsets.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Uniforms {
    clip_from_world: [[f32; 4]; 4],
    eye: [f32; 4],
    lights: [Light; LIGHTS],
    padding: [f32; 20],
}

/// A texture and the view of all of it.
pub struct Target {
    pub texture: wgpu::Texture,
    pub view: wgpu::TextureView,
}

impl Target {
    fn new(gpu: &Gpu, label: &str, format: TextureFormat, [width, height]: [u32; 2]) -> Self {
        let texture = texture(gpu, label, format, [width, height, 1], &[]);
        let view = texture.create_view(&Default::default());
        Self { texture, view }
    }
}

fn texture(
    gpu: &Gpu,
    label: &str,
    format: TextureFormat,
    [width, height, layers]: [u32; 3],
    view_formats: &[TextureFormat],
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats,
    })
}

/// What the engine knows of every pixel's surface.
pub struct GBuffer {
    /// `Depth32Float`; 0 where nothing is drawn.
    pub depth: Target,
    /// `Rgba16Float`, world space.
    pub normal: Target,
    /// `Rgba8UnormSrgb`.
    pub base_color: Target,
    /// `Rgba8Unorm`: roughness in green, metallic in blue.
    pub roughness_metallic: Target,
    /// `R32Uint`: the object's number, 0 where nothing is drawn.
    pub objects: Target,
}

impl GBuffer {
    fn colors(&self) -> [&Target; 4] {
        [&self.normal, &self.base_color, &self.roughness_metallic, &self.objects]
    }
}

/// Draws the world; one submission at a time.
pub struct Renderer {
    pub gbuffer: GBuffer,
    /// `Rgba8UnormSrgb`, a layer for each rig.
    pub pictures: wgpu::Texture,
    /// All layers as `Rgba8Unorm`, for shaders that want the codes as they are stored.
    pub codes: wgpu::TextureView,
    depth: Target,
    layers: Vec<wgpu::TextureView>,
    store: wgpu::RenderPipeline,
    light: wgpu::RenderPipeline,
    /// What the G-buffer is drawn with, then each layer.
    uniforms: wgpu::Buffer,
    group: wgpu::BindGroup,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
}

impl Renderer {
    /// For pictures of `width` by `height` pixels, `layers` of them at once.
    pub fn new(gpu: &Gpu, world: &World, [width, height]: [u32; 2], layers: u32) -> Self {
        let target = |label, format| Target::new(gpu, label, format, [width, height]);
        let gbuffer = GBuffer {
            depth: target("depth", TextureFormat::Depth32Float),
            normal: target("normal", TextureFormat::Rgba16Float),
            base_color: target("base colour", TextureFormat::Rgba8UnormSrgb),
            roughness_metallic: target("roughness, metallic", TextureFormat::Rgba8Unorm),
            objects: target("objects", TextureFormat::R32Uint),
        };
        let size = [width, height, layers];
        let (format, code) = (TextureFormat::Rgba8UnormSrgb, TextureFormat::Rgba8Unorm);
        let pictures = texture(gpu, "pictures", format, size, &[code]);
        let codes = pictures.create_view(&wgpu::TextureViewDescriptor {
            format: Some(code),
            usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
            ..Default::default()
        });
        let layer = |base_array_layer| {
            pictures.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer,
                array_layer_count: Some(1),
                ..Default::default()
            })
        };
        let bindings = bindings(gpu);
        let uniforms = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frames"),
            size: size_of::<Uniforms>() as u64 * u64::from(layers + 1),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let buffer = |label, contents, usage| {
            let info = wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage };
            gpu.device.create_buffer_init(&info)
        };
        Self {
            layers: (0..layers).map(layer).collect(),
            depth: target("depth of pictures", TextureFormat::Depth32Float),
            store: pipeline(
                gpu,
                &bindings,
                "store",
                &gbuffer.colors().map(|target| &target.texture),
            ),
            light: pipeline(gpu, &bindings, "light", &[&pictures]),
            group: group(gpu, &bindings, &uniforms),
            vertices: buffer(
                "vertices",
                bytemuck::cast_slice(&world.vertices),
                wgpu::BufferUsages::VERTEX,
            ),
            indices: buffer(
                "indices",
                bytemuck::cast_slice(&world.indices),
                wgpu::BufferUsages::INDEX,
            ),
            gbuffer,
            pictures,
            codes,
            uniforms,
        }
    }

    /// Draws the G-buffer and leaves it as a shader's resource.
    pub fn draw_gbuffer(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, camera: &Camera) {
        self.write(gpu, 0, camera, &[Light::zeroed(); LIGHTS]);
        let gbuffer = &self.gbuffer;
        let colors = gbuffer.colors().map(|target| &target.view);
        self.draw(encoder, &self.store, 0, &colors, &gbuffer.depth.view);
        let [a, b, c, d] = gbuffer.colors().map(|target| &target.texture);
        share(encoder, &[a, b, c, d, &gbuffer.depth.texture]);
    }

    /// Draws a picture under each of the rigs, in the first layers, and leaves all layers as a
    /// shader's resource.
    pub fn draw_pictures(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        camera: &Camera,
        rigs: &[[Light; LIGHTS]],
    ) {
        for (layer, (rig, view)) in rigs.iter().zip(&self.layers).enumerate() {
            self.write(gpu, layer + 1, camera, rig);
            self.draw(encoder, &self.light, layer + 1, &[view], &self.depth.view);
        }
        share(encoder, &[&self.pictures]);
    }

    fn write(&self, gpu: &Gpu, place: usize, camera: &Camera, lights: &[Light; LIGHTS]) {
        let uniforms = Uniforms {
            clip_from_world: camera.clip_from_world().as_mat4().to_cols_array_2d(),
            eye: camera.eye.as_vec3().extend(1.0).to_array(),
            lights: *lights,
            padding: [0.0; 20],
        };
        let offset = place * size_of::<Uniforms>();
        gpu.queue.write_buffer(&self.uniforms, offset as u64, bytemuck::bytes_of(&uniforms));
    }

    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        place: usize,
        colors: &[&wgpu::TextureView],
        depth: &wgpu::TextureView,
    ) {
        let attachment = |view| {
            let load = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
            let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops,
            })
        };
        let color_attachments: Vec<_> = colors.iter().copied().map(attachment).collect();
        let load = wgpu::LoadOp::Clear(0.0);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &color_attachments,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.group, &[(place * size_of::<Uniforms>()) as u32]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..(self.indices.size() / 4) as u32, 0, 0..1);
    }
}

/// Records the barriers after which shaders may read the textures: wgpu's layouts are then
/// `SHADER_READ_ONLY_OPTIMAL`, of depth `DEPTH_STENCIL_READ_ONLY_OPTIMAL`.
fn share(encoder: &mut wgpu::CommandEncoder, textures: &[&wgpu::Texture]) {
    let state = TextureUses::RESOURCE;
    let transition = |&texture| wgpu::TextureTransition { texture, selector: None, state };
    encoder.transition_resources(std::iter::empty(), textures.iter().map(transition));
}

fn bindings(gpu: &Gpu) -> wgpu::BindGroupLayout {
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: true,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

fn group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, buffer: &wgpu::Buffer) -> wgpu::BindGroup {
    let size = std::num::NonZero::new(size_of::<Uniforms>() as u64);
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: 0,
                size,
            }),
        }],
    })
}

/// The pipeline of a fragment shader that writes the targets.
fn pipeline(
    gpu: &Gpu,
    bindings: &wgpu::BindGroupLayout,
    entry: &str,
    targets: &[&wgpu::Texture],
) -> wgpu::RenderPipeline {
    let module = gpu.device.create_shader_module(wgpu::include_wgsl!("scene.wgsl"));
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        bind_group_layouts: &[Some(bindings)],
        ..Default::default()
    });
    let attributes = wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x2, 4 => Uint32
    ];
    let targets: Vec<_> = targets.iter().map(|t| Some(t.format().into())).collect();
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("project"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
