//! The scene's textures, and a descriptor set of four for each material.

use super::geometry::texture_slots;
use crate::Result;
use crate::gpu::Context;
use crate::gpu::layout::MATERIAL_TEXTURES;
use crate::gpu::vulkan::Call;
use crate::gpu::vulkan::commands::{COPY_WRITE, Commands, NOTHING};
use crate::gpu::vulkan::memory::{Image, ImageDesc};
use crate::gpu::vulkan::pipeline::{Binding, set_layout};
use crate::gpu::vulkan::staging::Uploader;
use crate::scene::{Material, Scene, Texture, TextureLevel, Wrap};
use ash::vk;
use std::sync::Arc;

const KIND: vk::DescriptorType = vk::DescriptorType::COMBINED_IMAGE_SAMPLER;

/// Every texture of a scene, and behind them a white texel for what a material does not have.
pub struct Textures {
    images: Vec<Image>,
    samplers: Vec<([Wrap; 2], vk::Sampler)>,
    layout: vk::DescriptorSetLayout,
    pool: vk::DescriptorPool,
    sets: Vec<vk::DescriptorSet>,
    context: Arc<Context>,
}

impl Textures {
    /// Uploads the textures.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] when a texture is larger than the device can take, and
    /// [device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, scene: &Scene) -> Result<Self> {
        let white = Texture {
            name: "white".into(),
            srgb: false,
            wrap: [Wrap::Clamp; 2],
            levels: vec![TextureLevel { width: 1, height: 1, texels: vec![[255; 4]] }],
        };
        let all = || scene.textures.iter().chain([&white]);
        let mut textures = Self {
            images: all().map(|texture| image(context, texture)).collect::<Result<_>>()?,
            samplers: Vec::new(),
            layout: layout(context)?,
            pool: vk::DescriptorPool::null(),
            sets: Vec::new(),
            context: Arc::clone(context),
        };
        textures.upload(all())?;
        textures.create_sets(scene.materials.len() as u32)?;
        for (i, material) in scene.materials.iter().enumerate() {
            textures.write_set(textures.sets[i], material, scene)?;
        }
        Ok(textures)
    }

    /// Layout of a material's set.
    pub fn layout(&self) -> vk::DescriptorSetLayout {
        self.layout
    }

    /// A material's set: its textures, at the bindings of their slots.
    pub fn set(&self, material: u32) -> vk::DescriptorSet {
        self.sets[material as usize]
    }

    fn upload<'t>(&self, textures: impl Iterator<Item = &'t Texture>) -> Result<()> {
        Commands::once(&self.context, |cmd| {
            let layouts = (vk::ImageLayout::UNDEFINED, vk::ImageLayout::GENERAL);
            for image in &self.images {
                self.context.transition(cmd, image, layouts, NOTHING, COPY_WRITE);
            }
            Ok(())
        })?;
        let mut uploader = Uploader::new(&self.context)?;
        for (image, texture) in self.images.iter().zip(textures) {
            for (mip, level) in texture.levels.iter().enumerate() {
                uploader.level(image, mip as u32, level)?;
            }
        }
        uploader.finish()
    }

    fn create_sets(&mut self, count: u32) -> Result<()> {
        let sizes =
            [vk::DescriptorPoolSize { ty: KIND, descriptor_count: MATERIAL_TEXTURES * count }];
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes);
        let device = self.context.device()?;
        // SAFETY: the device is alive and every info complete; what is made belongs to `self`.
        unsafe {
            self.pool =
                device.create_descriptor_pool(&pool, None).call("vkCreateDescriptorPool")?;
            let layouts = vec![self.layout; count as usize];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(self.pool)
                .set_layouts(&layouts);
            self.sets = device.allocate_descriptor_sets(&info).call("vkAllocateDescriptorSets")?;
        }
        Ok(())
    }

    fn write_set(
        &mut self,
        set: vk::DescriptorSet,
        material: &Material,
        scene: &Scene,
    ) -> Result<()> {
        let white = self.images.len() - 1;
        for (slot, texture) in texture_slots(material).into_iter().enumerate() {
            let index = texture.map_or(white, |texture| texture.texture as usize);
            let wrap = scene.textures.get(index).map_or([Wrap::Clamp; 2], |texture| texture.wrap);
            let info = [vk::DescriptorImageInfo::default()
                .sampler(self.sampler(wrap)?)
                .image_view(self.images[index].view())
                .image_layout(vk::ImageLayout::GENERAL)];
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(slot as u32)
                .descriptor_type(KIND)
                .image_info(&info);
            // SAFETY: set, view and sampler belong to `self` and are alive; the set is not in use.
            unsafe { self.context.write_descriptor(write) };
        }
        Ok(())
    }

    /// The trilinear sampler with this wrap.
    fn sampler(&mut self, wrap: [Wrap; 2]) -> Result<vk::Sampler> {
        if let Some((_, sampler)) = self.samplers.iter().find(|(other, _)| *other == wrap) {
            return Ok(*sampler);
        }
        let mode = |wrap| match wrap {
            Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
            Wrap::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
            Wrap::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
        };
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(vk::Filter::LINEAR)
            .min_filter(vk::Filter::LINEAR)
            .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
            .address_mode_u(mode(wrap[0]))
            .address_mode_v(mode(wrap[1]))
            .max_lod(vk::LOD_CLAMP_NONE);
        let device = self.context.device()?;
        // SAFETY: the device is alive; `info` is complete.
        let sampler = unsafe { device.create_sampler(&info, None) }.call("vkCreateSampler")?;
        self.samplers.push((wrap, sampler));
        Ok(sampler)
    }
}

impl Drop for Textures {
    fn drop(&mut self) {
        // SAFETY: owners wait for the work that uses the textures; null handles are allowed.
        self.context.unless_gone(|device| unsafe {
            device.destroy_descriptor_pool(self.pool, None);
            for (_, sampler) in &self.samplers {
                device.destroy_sampler(*sampler, None);
            }
        });
    }
}

/// The layout of a material's set: each texture at the binding of its slot.
fn layout(context: &Context) -> Result<vk::DescriptorSetLayout> {
    let binding = |slot| (slot, KIND, vk::ShaderStageFlags::FRAGMENT);
    let bindings: Vec<Binding> = (0..MATERIAL_TEXTURES).map(binding).collect();
    set_layout(context, &bindings)
}

/// An image for the texture and its mip levels.
fn image(context: &Arc<Context>, texture: &Texture) -> Result<Image> {
    let TextureLevel { width, height, .. } = texture.levels[0];
    let largest = context.limits().max_image_dimension2_d;
    if width.max(height) > largest {
        return Err(context.unsupported(format!(
            "texture '{}' has {width}x{height} texels (at most {largest}x{largest})",
            texture.name
        )));
    }
    let format = if texture.srgb { vk::Format::R8G8B8A8_SRGB } else { vk::Format::R8G8B8A8_UNORM };
    let desc = ImageDesc {
        name: &texture.name,
        format,
        width,
        height,
        layers: None,
        mips: texture.levels.len() as u32,
        usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST,
    };
    Image::new(context, &desc)
}
