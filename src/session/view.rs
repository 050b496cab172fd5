//! From settings and a scene to the view.

use super::values::Size;
use super::warn;
use crate::error::within;
use crate::scene::framing::{Framing, frame};
use crate::scene::view::{Camera, View};
use crate::scene::{self, Scene};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Picture size without any other word on it.
pub const SIZE: Size = Size([512, 512]);

/// Picture and camera. Angles in degrees; where any of the four of the framing is given, it takes the
/// place of the file's cameras.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ViewSettings {
    /// Picture size; 512x512, or the size that a lit scene names, where absent.
    pub size: Option<Size>,
    /// Name or index of one of the file's cameras.
    pub camera: Option<CameraKey>,
    /// Azimuth of the framing's camera, 0 on the +Z axis, positive to +X.
    pub azimuth: Option<f64>,
    /// Elevation of the framing's camera.
    pub elevation: Option<f64>,
    /// Vertical field of view of the framing.
    pub fov: Option<f64>,
    /// Share of the picture's height or width that the framing fills, 0..1.
    pub fill: Option<f64>,
}

impl ViewSettings {
    /// Whether the framing is asked for.
    pub fn framed(&self) -> bool {
        [self.azimuth, self.elevation, self.fov, self.fill].iter().any(Option::is_some)
    }

    /// Puts what `over` names in the place of these. A camera of the file and the framing displace
    /// each other.
    pub fn overlay(&mut self, over: &Self) {
        if over.camera.is_some() {
            (self.azimuth, self.elevation, self.fov, self.fill) = (None, None, None, None);
        }
        if over.framed() {
            self.camera = None;
        }
        self.size = over.size.or(self.size);
        self.camera = over.camera.clone().or(self.camera.take());
        self.azimuth = over.azimuth.or(self.azimuth);
        self.elevation = over.elevation.or(self.elevation);
        self.fov = over.fov.or(self.fov);
        self.fill = over.fill.or(self.fill);
    }

    /// # Errors
    /// [`Error::Argument`] for a camera beside a framing, and angles out of their ranges.
    pub fn check(&self) -> Result<()> {
        if self.camera.is_some() && self.framed() {
            let fault = "a camera of the file and the angles of a framing exclude each other";
            return Err(Error::Argument(fault.into()));
        }
        let value = |x: Option<f64>, fallback: f64| x.unwrap_or(fallback) as f32;
        within("azimuth", value(self.azimuth, 0.0), -360.0, 360.0)?;
        within("elevation", value(self.elevation, 0.0), -90.0, 90.0)?;
        within("fov", value(self.fov, 35.0), 1.0, 170.0)?;
        within("fill", value(self.fill, 0.85), 0.01, 1.0)
    }
}

/// How a file names a camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CameraKey {
    /// By its place in the file.
    Index(usize),
    /// By its name.
    Name(String),
}

impl CameraKey {
    /// The text that stands for it on the command line.
    pub fn text(&self) -> String {
        match self {
            Self::Index(index) => index.to_string(),
            Self::Name(name) => name.clone(),
        }
    }
}

/// The view that the settings ask for.
///
/// # Errors
/// Faults of the settings and of the scene.
pub fn view(scene: &Scene, settings: &ViewSettings) -> Result<View> {
    let chosen = chosen(scene, settings)?;
    let Size([width, height]) = size(settings, chosen.as_ref());
    let camera = match chosen {
        Some(camera) => camera,
        None => frame(scene, &framing(settings), f64::from(width) / f64::from(height))?,
    };
    View::new(scene, camera, width, height)
}

/// The camera of the file that the settings ask for; none where they ask for the framing, or there is none.
///
/// # Errors
/// As [`scene::camera::choose`].
pub(super) fn chosen(scene: &Scene, settings: &ViewSettings) -> Result<Option<Camera>> {
    Ok(match &settings.camera {
        Some(key) => Some(scene::camera::choose(scene, &key.text())?),
        None if settings.framed() => None,
        None => written_or_first(scene).cloned(),
    })
}

/// The size of a picture through `camera`.
pub(super) fn size(settings: &ViewSettings, camera: Option<&Camera>) -> Size {
    let stored = || camera.and_then(|camera| camera.designed).map(|view| view.size);
    let size = settings.size.or_else(|| stored().map(bounded));
    size.unwrap_or(SIZE)
}

/// Most pixels of a size that a scene asks for itself.
const MAX_STORED: f64 = (1 << 22) as f64;

/// The size that a scene's camera was designed for, or a smaller one of its shape, with a warning.
fn bounded([width, height]: [u32; 2]) -> Size {
    let scale = (MAX_STORED / (f64::from(width) * f64::from(height))).sqrt();
    if scale >= 1.0 {
        return Size([width, height]);
    }
    let side = |side: u32| ((f64::from(side) * scale) as u32).max(1);
    let size = Size([side(width), side(height)]);
    let asked = Size([width, height]);
    warn(&[format!(
        "its camera is for {asked} pixels: {size} in place of them; --size {asked} asks for all"
    )]);
    size
}

/// The camera that klieg wrote, else the first.
fn written_or_first(scene: &Scene) -> Option<&Camera> {
    let written = scene.cameras.iter().rev().find(|camera| camera.designed.is_some());
    written.or(scene.cameras.first())
}

/// The framing that the settings ask for.
pub(super) fn framing(settings: &ViewSettings) -> Framing {
    let default = Framing::default();
    let radians = |degrees: Option<f64>, other: f64| degrees.map_or(other, f64::to_radians);
    Framing {
        azimuth: radians(settings.azimuth, default.azimuth),
        elevation: radians(settings.elevation, default.elevation),
        fov: radians(settings.fov, default.fov),
        fill: settings.fill.unwrap_or(default.fill),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_that_a_file_asks_for_is_bounded_in_its_shape() {
        assert_eq!(bounded([2048, 2048]), Size([2048, 2048]));
        assert_eq!(bounded([16384, 16384]), Size([2048, 2048]));
        assert_eq!(bounded([8192, 2048]), Size([4096, 1024]));
        assert_eq!(bounded([1 << 24, 1]), Size([8_388_608, 1]));
    }
}
