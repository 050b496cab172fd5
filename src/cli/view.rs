//! From settings and a scene to the view.

use super::config::ViewSettings;
use super::session::warn;
use super::values::Size;
use crate::scene::framing::{Framing, frame};
use crate::scene::view::{Camera, View};
use crate::scene::{self, Scene};
use anyhow::Result;

/// Picture size without any other word on it.
pub(super) const SIZE: Size = Size([512, 512]);

/// The view that the settings ask for.
///
/// # Errors
/// Faults of the settings and of the scene.
pub(super) fn view(scene: &Scene, settings: &ViewSettings) -> Result<View> {
    let chosen = match &settings.camera {
        Some(key) => Some(scene::camera::choose(scene, &key.text())?),
        None if settings.framed() => None,
        None => written_or_first(scene).cloned(),
    };
    let stored = || chosen.as_ref().and_then(|camera| camera.designed).map(|view| view.size);
    let size = settings.size.or_else(|| stored().map(bounded));
    let Size([width, height]) = size.unwrap_or(SIZE);
    let camera = match chosen {
        Some(camera) => camera,
        None => frame(scene, &framing(settings), f64::from(width) / f64::from(height))?,
    };
    Ok(View::new(scene, camera, width, height)?)
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

fn framing(settings: &ViewSettings) -> Framing {
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
