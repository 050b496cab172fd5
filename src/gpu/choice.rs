//! Which pipeline measures populations on a device.

use super::devices::DeviceReport;
use serde::{Deserialize, Serialize};
use std::fmt;

/// How the pictures of a population are made. All of them give the same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum PipelineKind {
    /// One batched draw of N layers that shades the stored surface
    Layered,
    /// Compute shaders that visit object pixels alone and make no picture
    Compute,
}

impl PipelineKind {
    /// The fastest on a device, and why.
    pub fn best(_device: &DeviceReport) -> (Self, &'static str) {
        (Self::Compute, "it visits object pixels alone and reads each once for several individuals")
    }
}

impl fmt::Display for PipelineKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Layered => "layered",
            Self::Compute => "compute",
        })
    }
}
