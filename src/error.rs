//! What can go wrong in the library.

use std::path::PathBuf;

/// The library's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// The words of a panic, where it has any.
#[cfg(any(feature = "c", feature = "cli"))]
pub(crate) fn panic_words(panic: &(dyn std::any::Any + Send)) -> Option<&str> {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
}

/// What can go wrong in the library; [`Error::is_input`] tells the caller's faults from the rest.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file that the caller named cannot be used.
    #[error("{}: {fault}", path.display())]
    Input {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: String,
    },
    /// A value that the caller gave is out of its range or names nothing.
    #[error("{0}")]
    Argument(String),
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A device lacks something that klieg needs.
    #[error("device '{device}' cannot run klieg: {lacks}")]
    Unsupported {
        /// The device's name.
        device: String,
        /// All that it lacks.
        lacks: String,
    },
    /// No Vulkan, or no layer or extension of the instance that is needed.
    #[error("Vulkan is not usable here: {0}")]
    NoVulkan(String),
    /// A Vulkan call failed.
    #[error("Vulkan: {call} failed: {result}")]
    Vulkan {
        /// The call.
        call: &'static str,
        /// Its result code.
        result: ash::vk::Result,
    },
    /// The device was given up by [`Context::forget_device`](crate::gpu::Context::forget_device).
    #[error("the device is gone")]
    Forgotten,
    /// A score is not a number.
    #[error("the score of a rig is not a number, a fault of the device or of klieg's own: {rig}")]
    NotANumber {
        /// Its lights in words.
        rig: String,
    },
    /// The caller broke the work off.
    #[error("interrupted")]
    Interrupted,
    /// Device memory could not be had.
    #[error("device memory for {what}: {source}")]
    DeviceMemory {
        /// What it was for.
        what: String,
        /// The allocator's reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl Error {
    /// A fault of the file at `path`.
    pub fn input(path: impl Into<PathBuf>, fault: impl std::fmt::Display) -> Self {
        Self::Input { path: path.into(), fault: fault.to_string() }
    }

    /// Whether it is a device error: what any function that reaches a device may return, besides the errors
    /// that it names itself. The device lacks something ([`Error::Unsupported`]), a call fails
    /// ([`Error::Vulkan`], where the device may be lost: [`Error::is_device_lost`]), there is no memory
    /// ([`Error::DeviceMemory`]), or the device was given up ([`Error::Forgotten`]). The native evaluator
    /// has none of them.
    pub fn is_device(&self) -> bool {
        matches!(
            self,
            Self::Unsupported { .. }
                | Self::Vulkan { .. }
                | Self::DeviceMemory { .. }
                | Self::Forgotten
        )
    }

    /// Whether the device is lost: then nothing works on it any more, and what was made on it may
    /// be dropped.
    pub fn is_device_lost(&self) -> bool {
        matches!(self, Self::Vulkan { result: ash::vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// Whether what the caller gave is at fault, rather than the machine.
    pub fn is_input(&self) -> bool {
        matches!(self, Self::Input { .. } | Self::Argument(_))
    }
}

/// # Errors
/// [`Error::Argument`] with the setting's name unless `value` is in `low..=high`.
pub(crate) fn within(name: &str, value: f32, low: f32, high: f32) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let range = match (low, high) {
        (0.0, f32::MAX) => "finite, 0 or more".into(),
        (f32::MIN_POSITIVE, f32::MAX) => "more than 0".into(),
        (low, f32::MAX) => format!("{low} or more"),
        (low, high) => format!("{low} to {high}"),
    };
    Err(Error::Argument(format!("{name} is {value}: it must be {range}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn device_errors_are_no_faults_of_input() {
        let lost =
            Error::Vulkan { call: "vkQueueSubmit", result: ash::vk::Result::ERROR_DEVICE_LOST };
        assert!(lost.is_device_lost());
        let memory = Error::DeviceMemory { what: "lights".into(), source: "none left".into() };
        let short = Error::Unsupported { device: "GPU".into(), lacks: "a queue".into() };
        for error in [lost, memory, short, Error::Forgotten] {
            assert!(error.is_device() && !error.is_input(), "{error}");
        }
        for error in [Error::input("scene.glb", "is empty"), Error::Argument("size".into())] {
            assert!(!error.is_device() && error.is_input(), "{error}");
        }
        assert!(!Error::Interrupted.is_device());
    }
}
