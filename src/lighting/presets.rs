//! Rigs that people use without looking at the scene: what a design is compared with.

use super::{Light, LightKind, Rig, Role};
use crate::{Error, Result};

/// A rig that does not depend on the scene. All its lights are directional.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preset {
    /// One light from the viewer.
    Headlight,
    /// VTK's `vtkLightKit` with its default angles and ratios: key 50°/10° at 0.75, fill −75°/−10° at
    /// a third of the key, two backs 0°/±110° at 1/3.5, a headlight at a third. Its warm and cool
    /// colours are left out: all presets are white.
    LightKit,
    /// The photographer's key, fill and back light.
    ThreePoint,
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Headlight, Self::LightKit, Self::ThreePoint];

    /// The preset of that name.
    ///
    /// # Errors
    /// [`Error::Argument`] that lists them.
    pub fn named(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::Argument(format!("there is no preset '{name}': the presets are {names}"))
        })
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Headlight => "headlight",
            Self::LightKit => "light-kit",
            Self::ThreePoint => "three-point",
        }
    }

    /// The name for people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Headlight => "Headlight",
            Self::LightKit => "Light kit",
            Self::ThreePoint => "Three-point",
        }
    }

    /// The lights.
    pub fn rig(self) -> Rig {
        const KEY: f32 = 0.75;
        match self {
            Self::Headlight => vec![light(Role::Key, 0.0, 0.0, 1.0)],
            Self::LightKit => vec![
                light(Role::Key, 50.0, 10.0, KEY),
                light(Role::Fill, -75.0, -10.0, KEY / 3.0),
                light(Role::Rim, 0.0, 110.0, KEY / 3.5),
                light(Role::Rim, 0.0, -110.0, KEY / 3.5),
                light(Role::Fill, 0.0, 0.0, KEY / 3.0),
            ],
            Self::ThreePoint => vec![
                light(Role::Key, 40.0, 45.0, 1.0),
                light(Role::Fill, 15.0, -45.0, 0.5),
                light(Role::Rim, 45.0, 165.0, 0.75),
            ],
        }
    }
}

/// A directional light; angles in degrees, the intensity both diffuse and specular.
fn light(role: Role, elevation: f32, azimuth: f32, intensity: f32) -> Light {
    Light {
        role,
        kind: LightKind::DIRECTIONAL,
        elevation: elevation.to_radians(),
        azimuth: azimuth.to_radians(),
        diffuse: intensity,
        specular: intensity,
        ..Light::default()
    }
}
