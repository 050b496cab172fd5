//! The pipeline `compute` for devices with fast shared memory: one stage, `tiles`, shades and
//! measures the tiles of the picture that have an object pixel.

use super::generation::{self, Measure, part_bytes};
use crate::Result;
use crate::constants::{TILE_SIDE as SIDE, TILES_BLOCK, TILES_COLOR_BLOCK, TILES_GROUP};
use crate::gpu::Context;
use crate::gpu::layout::{Chunk, Tile};
use crate::gpu::shaders;
use crate::gpu::view::memory::{PUSH_BYTES, PUSH_STAGES, ViewMemory, push_constants};
use crate::gpu::vulkan::choice::Subgroups;
use crate::gpu::vulkan::commands::{
    COMPUTE_READ, COMPUTE_WRITE, COPY_READ, COPY_WRITE, Commands, HOST_READ,
};
use crate::gpu::vulkan::dispatch::Dispatch;
use crate::gpu::vulkan::memory::{Access, Buffer};
use crate::gpu::vulkan::pipeline::{ByRigs, DescriptorSet, Pipeline, PipelineLayout, RigKind};
use crate::gpu::vulkan::staging;
use crate::gpu::vulkan::timer::StageTimer;
use ash::vk;
use std::sync::Arc;

/// The list of tiles, the stage, and the first picture.
pub struct Tiles {
    stages: ByRigs,
    /// Where the views change.
    list_stage: Option<Pipeline>,
    count: u32,
    /// Individuals that share a pass over the surface.
    block: u32,
    subgroups: Subgroups,
    picture: Buffer,
    layout: PipelineLayout,
    set: DescriptorSet,
    _list: Buffer,
    context: Arc<Context>,
}

impl Tiles {
    /// For a view whose records and types are there and stay.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn new(context: &Arc<Context>, view: &ViewMemory) -> Result<Self> {
        // What a dry context draws is not known: it might be in all tiles.
        let unknown = || vec![1; view.size[0] as usize * view.size[1] as usize];
        let types = if context.is_dry() { unknown() } else { types(context, view)? };
        let tiles = tiles(&types, view.size);
        let list = Buffer::of(context, "tiles", &tiles, vk::BufferUsageFlags::STORAGE_BUFFER)?;
        Self::of(context, view, list, tiles.len() as u32)
    }

    /// For views that the stage `tile_list` looks through, all of the same size.
    ///
    /// # Errors
    /// [Device errors](crate::Error::is_device).
    pub fn of_any_view(context: &Arc<Context>, view: &ViewMemory) -> Result<Self> {
        let [columns, rows] = view.size.map(|side| side.div_ceil(SIDE));
        let count = columns * rows;
        let bytes = u64::from(count) * size_of::<Tile>() as u64;
        let list = Buffer::storage(context, "tiles", bytes)?;
        let mut tiles = Self::of(context, view, list, count)?;
        let (spirv, constants) = (shaders::TILE_LIST_COMP, [TILES_GROUP, SIDE]);
        let stage = Pipeline::compute(context, "tile_list", spirv, &tiles.layout, &constants)?;
        tiles.list_stage = Some(stage);
        Ok(tiles)
    }

    fn of(context: &Arc<Context>, view: &ViewMemory, list: Buffer, count: u32) -> Result<Self> {
        let subgroups =
            context.tiles().ok_or_else(|| context.unsupported("pipeline tiles".into()))?;
        let picture = picture(context, view)?;
        let kind = (vk::DescriptorType::STORAGE_BUFFER, vk::ShaderStageFlags::COMPUTE);
        let bindings = [(0, kind.0, kind.1), (1, kind.0, kind.1)];
        let mut set = DescriptorSet::new(context, "tiles", &bindings)?;
        set.write_buffer(0, &list);
        set.write_buffer(1, &picture);
        let sets = [view.set.layout(), set.layout()];
        let layout = PipelineLayout::new(context, &sets, PUSH_STAGES, PUSH_BYTES)?;
        Ok(Self {
            stages: ByRigs::default(),
            list_stage: None,
            count,
            block: if view.color.is_some() { TILES_COLOR_BLOCK } else { TILES_BLOCK },
            subgroups,
            picture,
            layout,
            set,
            _list: list,
            context: Arc::clone(context),
        })
    }
}

impl Tiles {
    /// Records a stage over the tiles.
    fn dispatch(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        pipeline: &Pipeline,
        (groups, push): ([u32; 3], Option<&Chunk>),
    ) {
        let run = Dispatch {
            pipeline,
            layout: self.layout,
            sets: &[view.set.raw(), self.set.raw()],
            offsets: &[],
            push: push.and_then(push_constants),
            groups,
        };
        self.context.dispatch(cmd, &run);
    }
}

impl Measure for Tiles {
    fn entries(&self) -> [u32; 2] {
        [self.count; 2]
    }

    fn bin_bits(&self) -> u32 {
        16 // a tile has more than 255 pixels
    }

    fn block(&self) -> u32 {
        self.block
    }

    /// There are no pictures: the memory is for the partial results.
    fn largest_chunk(&self, view: &ViewMemory) -> Result<u32> {
        let each = part_bytes(view, self).iter().sum::<u64>().max(1) * u64::from(self.block);
        let groups = self.context.limits().max_compute_work_group_count[1];
        let blocks = (self.context.picture_memory() / each).max(1).min(groups.into());
        Ok(u32::try_from(blocks * u64::from(self.block)).unwrap_or(u32::MAX - self.block))
    }

    fn prepare(&mut self, view: &ViewMemory, rigs: RigKind) -> Result<()> {
        let (context, spirv, layout) = (&self.context, shaders::TILES_COMP, &self.layout);
        let Subgroups { size, required } = self.subgroups;
        let mut constants = vec![TILES_GROUP, rigs.lights as u32, size, SIDE, self.block];
        let [gltf, side, near] = view.color.map_or([0; 3], |color| color.constants(rigs.near));
        constants.extend([view.color.is_some().into(), gltf]);
        constants.extend(generation::measured(view.objective.needs()));
        constants.extend([side, near]);
        let required = required.then_some(size);
        self.stages.prepare(rigs, || {
            Pipeline::compute_in_subgroups(context, "tiles", spirv, layout, &constants, required)
        })
    }

    fn prepared(&self, rigs: RigKind) -> bool {
        self.stages.has(rigs)
    }

    fn allocate(&mut self, _view: &mut ViewMemory, _chunk: u32, _lights: &Buffer) -> Result<()> {
        Ok(())
    }

    fn record_view(&self, cmd: vk::CommandBuffer, view: &ViewMemory) {
        let Some(list_stage) = &self.list_stage else { return };
        let (device, picture) = (self.context.recorder(), self.picture.raw());
        // SAFETY: `cmd` is being recorded on this device, and the picture, of whole words, may be filled.
        unsafe { device.cmd_fill_buffer(cmd, picture, 0, vk::WHOLE_SIZE, 0) };
        // The list has room for every tile.
        let [columns, rows] = view.size.map(|side| side.div_ceil(SIDE));
        self.dispatch(cmd, view, list_stage, ([columns, rows, 1], None));
        let written = (COMPUTE_WRITE.0 | COPY_WRITE.0, COMPUTE_WRITE.1 | COPY_WRITE.1);
        let used = (COMPUTE_READ.0, COMPUTE_READ.1 | COMPUTE_WRITE.1);
        self.context.barrier(cmd, written, used);
    }

    fn record(
        &self,
        cmd: vk::CommandBuffer,
        view: &ViewMemory,
        timer: &mut StageTimer,
        (chunk, count): (&Chunk, u32),
        rigs: RigKind,
    ) {
        timer.stage(cmd, "tiles", || {
            let groups = [self.count, count.div_ceil(self.block), 1];
            self.dispatch(cmd, view, self.stages.of(rigs), (groups, Some(chunk)));
        });
    }

    fn first_picture(&self, _view: &ViewMemory) -> Result<Vec<f32>> {
        let pixels = self.picture.size() as usize / size_of::<f32>();
        staging::read_buffer(&self.context, &self.picture, pixels)
    }
}

/// The first individual's picture, black for now, as it stays in the background.
fn picture(context: &Arc<Context>, view: &ViewMemory) -> Result<Buffer> {
    let size = 4 * u64::from(view.size[0]) * u64::from(view.size[1]);
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER
        | vk::BufferUsageFlags::TRANSFER_SRC
        | vk::BufferUsageFlags::TRANSFER_DST;
    let picture = Buffer::new(context, "picture", size, usage, Access::Device)?;
    Commands::once(context, |cmd| {
        // SAFETY: the buffer, of whole words, is alive and may be filled.
        unsafe { context.recorder().cmd_fill_buffer(cmd, picture.raw(), 0, vk::WHOLE_SIZE, 0) };
        Ok(())
    })?;
    Ok(picture)
}

/// The view's pixel types as numbers.
fn types(context: &Arc<Context>, view: &ViewMemory) -> Result<Vec<u32>> {
    let mut types = vec![0u32; view.size[0] as usize * view.size[1] as usize];
    let (size, usage) = (size_of_val(&types[..]) as u64, vk::BufferUsageFlags::TRANSFER_DST);
    let out = Buffer::new(context, "types", size, usage, Access::Readback)?;
    Commands::once(context, |cmd| {
        context.barrier(cmd, COMPUTE_WRITE, COPY_READ);
        context.download(cmd, (&view.types, vk::ImageLayout::GENERAL, 0), &out);
        context.barrier(cmd, COPY_WRITE, HOST_READ);
        Ok(())
    })?;
    out.read(&mut types)?;
    Ok(types)
}

/// The tiles that have an object pixel, row after row.
fn tiles(types: &[u32], [width, height]: [u32; 2]) -> Vec<Tile> {
    let mut tiles = Vec::new();
    for (row, top) in (0..height).step_by(SIDE as usize).enumerate() {
        for (column, left) in (0..width).step_by(SIDE as usize).enumerate() {
            let inside = |k: &u32| left + k % SIDE < width && top + k / SIDE < height;
            let object =
                |k: &u32| types[((top + k / SIDE) * width + left + k % SIDE) as usize] != 0;
            if let Some(k) = (0..SIDE * SIDE).filter(inside).find(object) {
                let origin = (k / SIDE + 1) * (SIDE + 2) + k % SIDE + 1;
                tiles.push(Tile { column: column as u32, row: row as u32, origin });
            }
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::testing;
    use crate::gpu::vulkan::choice::Lights;
    use crate::lighting::shading::Shading;
    use crate::objective::Objective;

    #[test]
    fn only_tiles_with_an_object_pixel_are_listed() {
        let mut types = vec![0; 70 * 40];
        types[69] = 1;
        types[33 * 70 + 5] = 2;
        types[33 * 70 + 6] = 1;
        let expected = [
            Tile { column: 2, row: 0, origin: 34 + 6 },
            Tile { column: 0, row: 1, origin: 2 * 34 + 6 },
        ];
        assert_eq!(tiles(&types, [70, 40]), expected);
        assert_eq!(tiles(&[0; 12], [4, 3]), []);
    }

    #[test]
    fn required_subgroups_give_the_same_bits() {
        const INDIVIDUALS: u32 = 6;
        let (maps, view) = testing::maps(70, 41);
        let lights = testing::lights(INDIVIDUALS as usize * 2);
        let scores = |required: bool| {
            let context = testing::context();
            let (objective, shading) = (Objective::default(), Shading::default());
            let mut memory =
                ViewMemory::with_maps(&context, &maps, &view, &objective, &shading, Lights::Plain)
                    .unwrap();
            let mut tiles = Tiles::new(&context, &memory).unwrap();
            tiles.subgroups.required = required;
            let measured = (&mut memory, &mut tiles as &mut dyn Measure);
            let scores = testing::scores(&context, measured, (INDIVIDUALS, &lights));
            testing::assert_valid(&context);
            scores
        };
        let [left, required] = [false, true].map(scores);
        assert_eq!(left, required);
        assert!(required.iter().all(|score| score.is_finite()) && required[0] != required[5]);
    }
}
