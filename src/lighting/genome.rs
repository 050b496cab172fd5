//! Real-coded chromosomes of rigs: one allele for each value of each light (Ha and Olivier 2006,
//! section 4), in the light's own units.

use super::{Light, LightKind, Rig, Role, check_number};
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
    /// Diffuse intensity.
    pub diffuse: Range,
    /// Specular intensity.
    pub specular: Range,
    /// Distance from the scene's centre, scene radii.
    pub distance: Range,
}

/// The box of each role. The numbers are our reconstruction, save the key's quarter sphere.
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
            diffuse: Range::new(0.0, 2.0),
            specular: Range::new(0.0, 2.0),
            distance,
        };
        let elevation = Range::new(-30.0, 90.0);
        let fill = RoleBox { elevation, diffuse: weak, specular: weak, ..key };
        let rim = RoleBox { azimuth: Range::new(100.0, 260.0), ..fill };
        Self { key, fill, rim }
    }
}

impl Boxes {
    /// The box of a role.
    pub fn of(&self, role: Role) -> &RoleBox {
        match role {
            Role::Key => &self.key,
            Role::Fill => &self.fill,
            Role::Rim => &self.rim,
        }
    }
}

/// The codec between rigs and chromosomes. A light's alleles are elevation and azimuth (radians),
/// diffuse and specular intensity and, for point lights, the distance.
#[derive(Debug, Clone)]
pub struct Genome {
    roles: Vec<Role>,
    kind: LightKind,
    bounds: Vec<Range>,
}

impl Genome {
    /// A codec for rigs with one light for each of `roles`.
    ///
    /// # Errors
    /// [`Error::Argument`] for no or too many lights, or a box that is empty, not finite or has
    /// negative intensities or distances.
    pub fn new(roles: &[Role], kind: LightKind, boxes: &Boxes) -> Result<Self> {
        check_number(roles.len())?;
        let mut bounds = Vec::new();
        for &role in roles {
            let space = boxes.of(role);
            check(role, space)?;
            bounds.extend([space.elevation.to_radians(), space.azimuth.to_radians()]);
            bounds.extend([space.diffuse, space.specular]);
            if kind == LightKind::Point {
                bounds.push(space.distance);
            }
        }
        Ok(Self { roles: roles.to_vec(), kind, bounds })
    }

    /// The box: lowest and highest value of each allele.
    pub fn bounds(&self) -> &[Range] {
        &self.bounds
    }

    /// The lights' roles.
    pub fn roles(&self) -> &[Role] {
        &self.roles
    }

    /// Number of lights.
    pub fn lights(&self) -> usize {
        self.roles.len()
    }

    /// The alleles of each light.
    pub fn alleles_per_light(&self) -> usize {
        self.bounds.len() / self.roles.len()
    }

    /// The rig of a chromosome.
    pub fn decode(&self, chromosome: &[f32]) -> Rig {
        let lights = chromosome.chunks_exact(self.alleles_per_light());
        let decode = |(&role, alleles): (&Role, &[f32])| Light {
            role,
            kind: self.kind,
            elevation: alleles[0],
            azimuth: alleles[1],
            diffuse: alleles[2],
            specular: alleles[3],
            distance: alleles.get(4).copied().unwrap_or(1.0),
        };
        self.roles.iter().zip(lights).map(decode).collect()
    }

    /// The chromosome of a rig, each allele moved to the nearest value of its box; azimuths are
    /// turned by full circles first.
    pub fn encode(&self, rig: &[Light]) -> Vec<f32> {
        let alleles = |light: &Light| {
            [light.elevation, light.azimuth, light.diffuse, light.specular, light.distance]
        };
        let step = self.alleles_per_light();
        let values = rig.iter().flat_map(|light| alleles(light).into_iter().take(step));
        let place = |(i, (value, range)): (usize, (f32, &Range))| {
            if i % step == 1 { nearest_turn(value, range) } else { range.nearest(value) }
        };
        values.zip(&self.bounds).enumerate().map(place).collect()
    }
}

/// The value of `range` that is nearest to `angle` or to one of its full turns, radians.
fn nearest_turn(angle: f32, range: &Range) -> f32 {
    let turns = [0.0, std::f32::consts::TAU, -std::f32::consts::TAU].map(|turn| angle + turn);
    let distance = |&a: &f32| (a - range.nearest(a)).abs();
    let nearest = turns.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    range.nearest(nearest.unwrap_or(angle))
}

fn check(role: Role, space: &RoleBox) -> Result<()> {
    let RoleBox { elevation, azimuth, diffuse, specular, distance } = space;
    for (name, range, least) in [
        ("elevation", elevation, -90.0),
        ("azimuth", azimuth, -360.0),
        ("diffuse", diffuse, 0.0),
        ("specular", specular, 0.0),
        ("distance", distance, f32::MIN_POSITIVE),
    ] {
        if !range.is_valid() || range.low < least {
            let Range { low, high } = range;
            let fault = format!("the {role:?} box's {name} {low}..{high} is not a range of values");
            return Err(Error::Argument(fault));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const ROLES: [Role; 3] = [Role::Key, Role::Fill, Role::Rim];

    proptest! {
        #[test]
        fn decoding_and_encoding_invert_each_other(
            shares in prop::collection::vec(0f32..=1.0, 15), point: bool,
        ) {
            let kind = if point { LightKind::Point } else { LightKind::Directional };
            let genome = Genome::new(&ROLES, kind, &Boxes::default()).unwrap();
            let place = |(r, t): (&Range, &f32)| r.at(*t);
            let chromosome: Vec<f32> = genome.bounds().iter().zip(&shares).map(place).collect();
            prop_assert_eq!(genome.encode(&genome.decode(&chromosome)), chromosome);
        }
    }

    #[test]
    fn a_rim_light_in_front_goes_to_the_nearest_side() {
        let genome = Genome::new(&[Role::Rim], LightKind::Directional, &Boxes::default()).unwrap();
        let rig = |azimuth: f32| {
            let mut rig = genome.decode(&[0.0, azimuth.to_radians(), 0.5, 0.5]);
            rig[0].elevation = 2.0;
            genome.encode(&rig).iter().map(|a| a.to_degrees().round()).collect::<Vec<_>>()
        };
        assert_eq!(rig(30.0)[..2], [90.0, 100.0]);
        assert_eq!(rig(-30.0)[..2], [90.0, 260.0]);
        assert_eq!(rig(-170.0)[..2], [90.0, 190.0]);
    }

    #[test]
    fn bad_boxes_are_refused() {
        for range in [Range::new(1.0, 0.0), Range::new(f32::NAN, 1.0), Range::new(-1.0, 1.0)] {
            let mut boxes = Boxes::default();
            boxes.fill.diffuse = range;
            assert!(Genome::new(&[Role::Fill], LightKind::Point, &boxes).is_err(), "{range:?}");
            assert!(Genome::new(&[Role::Key], LightKind::Point, &boxes).is_ok());
        }
        assert!(Genome::new(&[], LightKind::Point, &Boxes::default()).is_err());
        assert!(Genome::new(&[Role::Key; 17], LightKind::Point, &Boxes::default()).is_err());
    }
}
