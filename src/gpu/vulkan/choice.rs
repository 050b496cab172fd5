//! Which pipeline measures populations on a device.

use crate::constants::TILES_GROUP;
use ash::vk;
use serde::Serialize;
use std::fmt;

/// Bytes of shared memory that `tiles` takes at most: with the fewest invocations a subgroup may
/// have, and the most lights.
pub const TILES_SHARED_BYTES: u32 = 30 << 10;
/// How the pictures of a population are made. All of them give the same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PipelineKind {
    /// One batched draw of N layers that shades the stored surface.
    Layered,
    /// One batched draw of N layers of the scene's own geometry; only where there is a scene.
    Forward,
    /// Compute shaders that visit object pixels alone and make no picture.
    Compute,
}

impl fmt::Display for PipelineKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Layered => "layered",
            Self::Forward => "forward",
            Self::Compute => "compute",
        })
    }
}

/// The two shapes of [`PipelineKind::Compute`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ComputeShape {
    /// Two stages over runs of object pixels, without shared memory or barriers inside.
    Runs,
    /// One stage over tiles of the picture: brightness in shared memory, sums by subgroup.
    Tiles,
}

/// What the invocations of a device's compute shaders can do together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Together {
    /// Invocations of a subgroup.
    pub subgroup: u32,
    /// What a subgroup can do.
    pub operations: vk::SubgroupFeatureFlags,
    /// Most invocations of a work group.
    pub group: u32,
    /// Bytes of shared memory.
    pub shared: u32,
}

impl ComputeShape {
    /// The faster on a device, `software` or not, and why.
    pub fn best(software: bool, together: Together) -> (Self, &'static str) {
        if software {
            return (Self::Runs, "object pixels alone, without the barriers that a CPU is slow at");
        }
        match Self::tiles_possible(together) {
            true => (Self::Tiles, "object tiles alone, in shared memory and summed by subgroup"),
            false => (Self::Runs, "object pixels alone; too little shared memory or subgroups"),
        }
    }

    /// Whether [`ComputeShape::Tiles`] can run.
    pub fn tiles_possible(together: Together) -> bool {
        let needed = vk::SubgroupFeatureFlags::BASIC
            | vk::SubgroupFeatureFlags::ARITHMETIC
            | vk::SubgroupFeatureFlags::BALLOT;
        together.operations.contains(needed)
            && [8, 16, 32, 64].contains(&together.subgroup)
            && together.group >= TILES_GROUP
            && together.shared >= TILES_SHARED_BYTES
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shape_follows_from_what_the_device_can_do() {
        let operations = vk::SubgroupFeatureFlags::from_raw(0xff);
        let all = Together { subgroup: 32, operations, group: 1024, shared: 48 << 10 };
        let best = |software, together| ComputeShape::best(software, together).0;
        assert_eq!(best(false, all), ComputeShape::Tiles);
        assert_eq!(best(true, all), ComputeShape::Runs);
        let basic = vk::SubgroupFeatureFlags::BASIC;
        for short in [
            Together { operations: basic, ..all },
            Together { subgroup: 128, ..all },
            Together { group: 128, ..all },
            Together { shared: 16 << 10, ..all },
        ] {
            assert_eq!(best(false, short), ComputeShape::Runs, "{short:?}");
        }
    }
}
