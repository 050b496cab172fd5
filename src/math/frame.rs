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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two frames that share nothing: other axes, centres and radii.
    fn frames() -> [Frame; 2] {
        [(0.4, DVec3::new(1.0, 2.0, -3.0), 2.0), (-1.9, DVec3::new(-4.0, 0.5, 1.0), 0.25)].map(
            |(turn, center, radius): (f64, _, _)| {
                let (sin, cos) = turn.sin_cos();
                let (right, back) = (DVec3::new(cos, 0.0, -sin), DVec3::new(sin, 0.0, cos));
                Frame { center, radius, right, up: DVec3::Y, back }
            },
        )
    }

    #[test]
    fn a_place_and_a_direction_of_the_world_are_told_in_every_frame() {
        let [first, second] = frames();
        let p = DVec3::new(0.3, -0.7, 0.2);
        for frame in [first, second] {
            let world = frame.center
                + frame.radius * (0.3 * frame.right - 0.7 * frame.up + 0.2 * frame.back);
            assert!(frame.point_to_world(p).abs_diff_eq(world, 1e-12));
            assert!(frame.from_world().transform_point3(world).abs_diff_eq(p, 1e-12));
            let direction = (world - frame.center) / frame.radius;
            assert!(frame.direction_to_world(p).abs_diff_eq(direction, 1e-12));
        }
        let there = second.from_world().transform_point3(first.point_to_world(p));
        let change = first.change_to(&second);
        assert!(change.point(p).abs_diff_eq(there, 1e-12));
        assert_eq!(change.scale, 8.0);
        assert_eq!(first.change_to(&first), Change::NONE);
        assert_eq!(Change::NONE.point(p), p);
    }

    #[test]
    fn frames_have_finite_axes_a_finite_centre_and_a_radius() {
        let [sound, _] = frames();
        sound.check().unwrap();
        for radius in [0.0, -1.0, 1e-16, 1e16, f64::NAN] {
            assert!(Frame { radius, ..sound }.check().is_err(), "{radius}");
        }
        let none = DVec3::new(0.0, f64::INFINITY, 0.0);
        assert!(Frame { center: none, ..sound }.check().is_err());
        assert!(Frame { up: none, ..sound }.check().is_err());
    }
}
