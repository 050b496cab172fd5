//! Which pipeline measures populations on a device.

use crate::constants::TILES_GROUP;
use ash::vk;
use serde::Serialize;
use std::fmt;

/// Bytes of shared memory that `tiles` takes at most: with the fewest invocations a subgroup may
/// have, and the most lights.
pub const TILES_SHARED_BYTES: u32 = 12 << 10;
/// Invocations of a subgroup that `tiles` can be made for, ascending.
const TILES_SUBGROUPS: [u32; 4] = [8, 16, 32, 64];

/// Under which lights pictures of a view will be shaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lights {
    /// White ones without a cone ([`crate::lighting::LightRecord::is_plain`]).
    Plain,
    /// Any.
    Any,
}

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

/// Who makes the shadow table of a view that a device has drawn. Both give the same bits, up to rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ShadowMaker {
    /// The host, whose table is uploaded.
    Host,
    /// The device, by the stage `shadows`.
    Device,
}

impl ShadowMaker {
    /// The faster on a device, `software` or not, and why.
    pub fn best(software: bool) -> (Self, &'static str) {
        match software {
            true => (Self::Host, "the device is a CPU too, and its rays go one by one"),
            false => (Self::Device, "rays of all pixels side by side"),
        }
    }
}

/// What the invocations of a device's compute shaders can do together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Together {
    /// Invocations of a subgroup, as the device reports them.
    pub subgroup: u32,
    /// Fewest and most that a pipeline's subgroups may have; `None` where the device does not tell.
    pub subgroup_range: Option<[u32; 2]>,
    /// Most subgroups of a work group of a pipeline that requires their size; 0 where none can require it.
    pub required_subgroups: u32,
    /// What a subgroup can do.
    pub operations: vk::SubgroupFeatureFlags,
    /// Most invocations of a work group.
    pub group: u32,
    /// Bytes of shared memory.
    pub shared: u32,
}

/// The subgroups of a pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Subgroups {
    /// Invocations of each.
    pub size: u32,
    /// Whether the pipeline has to require the size, and that no subgroup has fewer.
    pub required: bool,
}

impl Together {
    /// The subgroups of the stage `tiles`, whose shared memory and whose histogram depend on their size;
    /// `None` where the device does not warrant one.
    ///
    /// A device of several sizes chooses one for each pipeline as it likes, whatever size it reports, so the
    /// pipeline requires one: the smallest, as `tiles` keeps much in registers. On Intel's GPUs, with sizes
    /// of 8 to 32, an invocation has the fewer registers the larger its subgroup is, and spills them at
    /// 32; AMD's, with 32 and 64, count one bin an invocation at 32.
    fn subgroups(&self) -> Option<Subgroups> {
        let [least, most] = self.subgroup_range?;
        if least == most && most == self.subgroup {
            return TILES_SUBGROUPS
                .contains(&most)
                .then_some(Subgroups { size: most, required: false });
        }
        let possible = |size: &u32| {
            (least..=most).contains(size) && TILES_GROUP.div_ceil(*size) <= self.required_subgroups
        };
        let size = TILES_SUBGROUPS.into_iter().find(possible)?;
        Some(Subgroups { size, required: true })
    }
}

impl ComputeShape {
    /// The faster on a device, `software` or not, and why.
    pub fn best(software: bool, together: Together) -> (Self, &'static str) {
        if software {
            return (Self::Runs, "object pixels alone, without the barriers that a CPU is slow at");
        }
        match Self::tiles(together) {
            Ok(_) => (Self::Tiles, "object tiles alone, in shared memory and summed by subgroup"),
            Err(lacks) => (Self::Runs, lacks),
        }
    }

    /// The subgroups of [`ComputeShape::Tiles`], or why it cannot run.
    pub fn tiles(together: Together) -> Result<Subgroups, &'static str> {
        let needed = vk::SubgroupFeatureFlags::BASIC
            | vk::SubgroupFeatureFlags::ARITHMETIC
            | vk::SubgroupFeatureFlags::BALLOT;
        if !together.operations.contains(needed)
            || together.group < TILES_GROUP
            || together.shared < TILES_SHARED_BYTES
        {
            return Err("object pixels alone; too little shared memory or subgroup operations");
        }
        together.subgroups().ok_or("object pixels alone; subgroups of no certain size")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shape_follows_from_what_the_device_can_do() {
        let operations = vk::SubgroupFeatureFlags::from_raw(0xff);
        let all = Together {
            subgroup: 32,
            subgroup_range: Some([32; 2]),
            required_subgroups: 0,
            operations,
            group: 1024,
            shared: 48 << 10,
        };
        let best = |software, together| ComputeShape::best(software, together).0;
        assert_eq!(best(false, all), ComputeShape::Tiles);
        assert_eq!(best(true, all), ComputeShape::Runs);
        let basic = vk::SubgroupFeatureFlags::BASIC;
        for short in [
            Together { operations: basic, ..all },
            Together { subgroup: 128, subgroup_range: Some([128; 2]), ..all },
            Together { subgroup_range: None, ..all },
            Together { group: 128, ..all },
            Together { shared: 8 << 10, ..all },
        ] {
            assert_eq!(best(false, short), ComputeShape::Runs, "{short:?}");
        }
    }

    #[test]
    fn gpus_trace_their_own_rays() {
        assert_eq!(ShadowMaker::best(true).0, ShadowMaker::Host);
        assert_eq!(ShadowMaker::best(false).0, ShadowMaker::Device);
    }

    #[test]
    fn subgroups_have_a_size_that_the_device_warrants() {
        let subgroups = |reported, range, required_subgroups| {
            let subgroup_range = Some(range);
            let facts = Together {
                subgroup: reported,
                subgroup_range,
                required_subgroups,
                ..Together::default()
            };
            facts.subgroups().map(|Subgroups { size, required }| (size, required))
        };
        for (device, reported, range, required_subgroups, expected) in [
            ("Intel", 32, [8, 32], 64, Some((8, true))),
            ("Intel of 16 or 32", 32, [16, 32], 64, Some((16, true))),
            ("Intel with few subgroups", 32, [8, 32], 16, Some((16, true))),
            ("Intel, not enabled", 32, [8, 32], 0, None),
            ("NVIDIA", 32, [32, 32], 64, Some((32, false))),
            ("NVIDIA, not enabled", 32, [32, 32], 0, Some((32, false))),
            ("AMD", 64, [32, 64], 64, Some((32, true))),
            ("AMD, not enabled", 64, [32, 64], 0, None),
            ("AMD of 64", 64, [64, 64], 64, Some((64, false))),
            ("Adreno", 128, [64, 128], 16, Some((64, true))),
            ("lavapipe", 8, [8, 8], 32, Some((8, false))),
            ("lavapipe with wide vectors", 16, [16, 16], 32, Some((16, false))),
            ("one invocation", 1, [1, 1], 256, None),
            ("128 alone", 128, [128, 128], 64, None),
        ] {
            assert_eq!(subgroups(reported, range, required_subgroups), expected, "{device}");
        }
        let silent = Together { subgroup: 32, required_subgroups: 64, ..Together::default() };
        assert_eq!(silent.subgroups(), None, "a device that does not tell its sizes");
    }
}
