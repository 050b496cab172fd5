//! The frame that lights and surfaces are told in.

use crate::{Error, Result};
use glam::{DMat3, DMat4, DVec3};

/// Radii of scenes, world units, whose lights' intensities can be written in single precision.
pub const RADII: std::ops::RangeInclusive<f64> = 1e-15..=1e15;

/// The light frame: the camera's axes at the scene's centre, in scene radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// `c`, centre of the world-space bounding box of everything drawn.
    pub center: DVec3,
    /// `ρ`, the largest distance of a vertex from `c`, world units.
    pub radius: f64,
    /// The camera's unit axes.
    pub right: DVec3,
    /// See `right`.
    pub up: DVec3,
    /// See `right`: from the scene to the viewer.
    pub back: DVec3,
}

impl Frame {
    /// # Errors
    /// [`Error::Argument`] unless the axes and the centre are finite and the radius is in [`RADII`].
    pub(crate) fn check(&self) -> Result<()> {
        let Self { center, radius, right, up, back } = self;
        if !(RADII.contains(radius) && [center, right, up, back].iter().all(|v| v.is_finite())) {
            let fault = "a light frame needs finite axes, a finite centre and a radius";
            let (least, most) = (RADII.start(), RADII.end());
            return Err(Error::Argument(format!("{fault} in {least:e}..{most:e}: {self:?}")));
        }
        Ok(())
    }

    /// Light frame from world space.
    pub fn from_world(&self) -> DMat4 {
        let rows = DMat4::from_cols(
            self.right.extend(0.0),
            self.up.extend(0.0),
            self.back.extend(0.0),
            glam::DVec4::W,
        );
        DMat4::from_scale(DVec3::splat(1.0 / self.radius))
            * rows.transpose()
            * DMat4::from_translation(-self.center)
    }

    /// World direction of a direction in the light frame.
    pub fn direction_to_world(&self, v: DVec3) -> DVec3 {
        self.right * v.x + self.up * v.y + self.back * v.z
    }

    /// World position of a point in the light frame.
    pub fn point_to_world(&self, p: DVec3) -> DVec3 {
        self.center + self.direction_to_world(p) * self.radius
    }

    /// What leads from this light frame into another one.
    pub fn change_to(&self, to: &Self) -> Change {
        if self == to {
            return Change::NONE;
        }
        let axes = |frame: &Self| DMat3::from_cols(frame.right, frame.up, frame.back);
        let turn = axes(to).transpose() * axes(self);
        let shift = axes(to).transpose() * (self.center - to.center) / to.radius;
        Change { turn, scale: self.radius / to.radius, shift }
    }
}

/// From one light frame into another: a point `p` of the first is `turn·p·scale + shift` in the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Rotation.
    pub turn: DMat3,
    /// Radii of the second frame that a radius of the first has.
    pub scale: f64,
    /// The first frame's centre in the second one.
    pub shift: DVec3,
}

impl Change {
    /// From a frame into itself.
    pub const NONE: Self = Self { turn: DMat3::IDENTITY, scale: 1.0, shift: DVec3::ZERO };

    /// The place of a point.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.turn * p * self.scale + self.shift
    }
}
