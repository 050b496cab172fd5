//! The values that lights of each role may have.

use crate::lighting::{Color, Role};
use crate::math::range::Range;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// The values that lights of one role may have.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoleBox {
    /// Elevation, degrees.
    pub elevation: Range,
    /// Azimuth, degrees; a box does not wrap, so 100..260 is the half circle behind.
    pub azimuth: Range,
    /// Whether azimuths are measured from the first key light's, positive across the viewer's direction: to
    /// the left of a key on the right, and to the right of any other.
    #[serde(default)]
    pub azimuth_from_key: bool,
    /// Whether intensities are shares of the first key light's.
    #[serde(default)]
    pub share_of_key: bool,
    /// Diffuse intensity; the only one where there is no `specular`.
    pub diffuse: Range,
    /// Specular intensity, where it is free of the diffuse one; `None` for lights of one intensity, as
    /// lamps are.
    pub specular: Option<Range>,
    /// Distance from the scene's centre, scene radii.
    pub distance: Range,
    /// Half angle of the cone of kinds that have one, degrees.
    #[serde(default = "cone")]
    pub cone: Range,
    /// Size of the lights, as the angle that they cover seen from the scene's centre, degrees, 0 to 60: how
    /// soft their shadows are in final pictures.
    #[serde(default)]
    pub softness: f32,
    /// Colour of the lights.
    #[serde(default)]
    pub color: Color,
}

/// Half angles of cones: the lower end of theatre's spotlights to a flood.
const fn cone() -> Range {
    Range::new(10.0, 60.0)
}

impl RoleBox {
    /// Radius of a light that covers [`softness`](Self::softness), at the distance 1.
    pub fn size(&self) -> f32 {
        (0.5 * self.softness.to_radians()).tan()
    }
}

/// The box of each role. By default they are the paper's: the numbers are our reconstruction, save the key's
/// quarter sphere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Boxes {
    /// Key lights.
    pub key: RoleBox,
    /// Fill lights.
    pub fill: RoleBox,
    /// Rim lights.
    pub rim: RoleBox,
}

impl Default for Boxes {
    fn default() -> Self {
        let distance = Range::new(1.5, 5.0);
        let weak = Range::new(0.0, 1.0);
        let key = RoleBox {
            elevation: Range::new(0.0, 90.0),
            azimuth: Range::new(-90.0, 90.0),
            azimuth_from_key: false,
            share_of_key: false,
            diffuse: Range::new(0.0, 2.0),
            specular: Some(Range::new(0.0, 2.0)),
            distance,
            cone: cone(),
            softness: 0.0,
            color: Color::WHITE,
        };
        let elevation = Range::new(-30.0, 90.0);
        let fill = RoleBox { elevation, diffuse: weak, specular: Some(weak), ..key };
        let rim = RoleBox { azimuth: Range::new(100.0, 260.0), ..fill };
        Self { key, fill, rim }
    }
}

impl Boxes {
    /// The box of a role.
    ///
    /// # Errors
    /// [`Error::Argument`] for [`Role::Scene`], whose lights are not searched.
    pub fn of(&self, role: Role) -> Result<&RoleBox> {
        match role {
            Role::Key => Ok(&self.key),
            Role::Fill => Ok(&self.fill),
            Role::Rim => Ok(&self.rim),
            Role::Scene => Err(not_searched()),
        }
    }

    /// As [`Boxes::of`], to be changed.
    ///
    /// # Errors
    /// The same.
    pub fn of_mut(&mut self, role: Role) -> Result<&mut RoleBox> {
        match role {
            Role::Key => Ok(&mut self.key),
            Role::Fill => Ok(&mut self.fill),
            Role::Rim => Ok(&mut self.rim),
            Role::Scene => Err(not_searched()),
        }
    }

    /// Lets lights stand on all sides: azimuths that are those of the boxes `usual` go all the way round, but keep what
    /// separates a light from its key.
    pub fn go_round(&mut self, usual: &Self) {
        let usual = [usual.key, usual.fill, usual.rim];
        for (space, usual) in self.all_mut().into_iter().zip(usual) {
            let Range { low, high } = space.azimuth;
            if space.azimuth == usual.azimuth {
                let middle = 0.5 * (low + high);
                space.azimuth = match space.azimuth_from_key {
                    true => Range::new(low, 360.0 - low),
                    false => Range::new(middle - 180.0, middle + 180.0),
                };
            }
        }
    }

    /// All of them.
    pub fn all_mut(&mut self) -> [&mut RoleBox; 3] {
        [&mut self.key, &mut self.fill, &mut self.rim]
    }
}

fn not_searched() -> Error {
    Error::Argument("the scene's own lights are not searched: roles are key, fill and rim".into())
}

pub(super) fn check(role: Role, space: &RoleBox) -> Result<()> {
    let RoleBox { elevation, azimuth, diffuse, specular, distance, cone, .. } = space;
    if role == Role::Key && (space.azimuth_from_key || space.share_of_key) {
        let fault = "the key's box is relative to the key: azimuth_from_key and share_of_key are for fill and rim";
        return Err(Error::Argument(fault.into()));
    }
    if !(0.0..=60.0).contains(&space.softness) {
        let fault =
            format!("the {role:?} box's softness is {}: it must be 0 to 60", space.softness);
        return Err(Error::Argument(fault));
    }
    for (name, range, least, most) in [
        ("elevation", elevation, -90.0, f32::MAX),
        ("azimuth", azimuth, -360.0, f32::MAX),
        ("diffuse", diffuse, 0.0, f32::MAX),
        ("specular", specular.as_ref().unwrap_or(diffuse), 0.0, f32::MAX),
        ("distance", distance, f32::MIN_POSITIVE, f32::MAX),
        ("cone", cone, 0.1, 90.0),
    ] {
        if !range.is_valid() || range.low < least || range.high > most {
            return Err(no_range(role, name, range));
        }
    }
    Ok(())
}

pub(super) fn no_range(role: Role, name: &str, &Range { low, high }: &Range) -> Error {
    Error::Argument(format!(
        "the {} box's {name} is {low} to {high}: it must be a range, the lowest value first",
        role.name()
    ))
}
