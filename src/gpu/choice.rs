//! Which pipeline measures populations on a device.

use ash::vk;
use serde::Serialize;
use std::fmt;

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

/// What a device's compute shaders can do together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Subgroups {
    /// Invocations.
    pub size: u32,
    /// What they can do.
    pub operations: vk::SubgroupFeatureFlags,
}

impl ComputeShape {
    /// The faster on a device: whether it is `software`, its subgroups, and the most invocations of
    /// a work group. With the reason.
    pub fn best(software: bool, subgroups: Subgroups, invocations: u32) -> (Self, &'static str) {
        if software {
            return (Self::Runs, "object pixels alone, without the barriers that a CPU is slow at");
        }
        match Self::tiles_possible(subgroups, invocations) {
            true => (Self::Tiles, "object tiles alone, in shared memory and summed by subgroup"),
            false => (Self::Runs, "object pixels alone, as the subgroups cannot add and vote"),
        }
    }

    /// Whether [`ComputeShape::Tiles`] can run.
    pub fn tiles_possible(subgroups: Subgroups, invocations: u32) -> bool {
        let needed = vk::SubgroupFeatureFlags::BASIC
            | vk::SubgroupFeatureFlags::ARITHMETIC
            | vk::SubgroupFeatureFlags::BALLOT;
        subgroups.operations.contains(needed)
            && subgroups.size.is_power_of_two()
            && (4..=64).contains(&subgroups.size)
            && invocations >= super::tiles::GROUP
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shape_follows_from_what_the_device_can_do() {
        let all = Subgroups { size: 32, operations: vk::SubgroupFeatureFlags::from_raw(0xff) };
        let basic = Subgroups { operations: vk::SubgroupFeatureFlags::BASIC, ..all };
        let best = |software, subgroups, most| ComputeShape::best(software, subgroups, most).0;
        assert_eq!(best(false, all, 1024), ComputeShape::Tiles);
        assert_eq!(best(true, all, 1024), ComputeShape::Runs);
        assert_eq!(best(false, basic, 1024), ComputeShape::Runs);
        assert_eq!(best(false, Subgroups { size: 128, ..all }, 1024), ComputeShape::Runs);
        assert_eq!(best(false, all, 128), ComputeShape::Runs);
    }
}
