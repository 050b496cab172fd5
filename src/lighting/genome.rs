//! Real-coded chromosomes of rigs: one allele for each value of each light (Ha and Olivier 2006,
//! section 4), in the light's own units.

use super::kinds::Allele;
use super::kinds::alleles::{AZIMUTH, ELEVATION};
use super::{Color, Light, LightKind, MAX_LIGHTS, Rig, Role, check_number};
use crate::math::frame::Frame;
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
    /// Colour of the lights.
    #[serde(default)]
    pub color: Color,
}

/// Half angles of cones: the lower end of theatre's spotlights to a flood.
const fn cone() -> Range {
    Range::new(10.0, 60.0)
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
            specular: Some(Range::new(0.0, 2.0)),
            distance,
            cone: cone(),
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

    /// All of them.
    pub fn all_mut(&mut self) -> [&mut RoleBox; 3] {
        [&mut self.key, &mut self.fill, &mut self.rim]
    }
}

fn not_searched() -> Error {
    Error::Argument("the scene's own lights are not searched: roles are key, fill and rim".into())
}

/// The codec between rigs and chromosomes. A light's alleles are those of its kind
/// ([`Kind::alleles`](super::kinds::Kind::alleles)) that its role's box gives a range.
#[derive(Debug, Clone)]
pub struct Genome {
    roles: Vec<Role>,
    searched: Vec<Searched>,
    bounds: Vec<Range>,
    fixed: Rig,
}

/// A light that is searched.
#[derive(Debug, Clone)]
struct Searched {
    /// What no allele says.
    light: Light,
    /// What the search may change, in the chromosome's order.
    alleles: Vec<&'static Allele>,
}

impl Searched {
    /// A light of a role and its ranges.
    fn new(role: Role, kind: LightKind, boxes: &Boxes) -> Result<(Self, Vec<Range>)> {
        let space = boxes.of(role)?;
        check(role, space)?;
        let known = kind.alleles().iter();
        let (alleles, bounds): (Vec<&Allele>, Vec<Range>) =
            known.filter_map(|allele| Some((allele, (allele.range)(space)?))).unzip();
        for (allele, range) in std::iter::zip(&alleles, &bounds) {
            if !range.is_valid() {
                return Err(no_range(role, allele.name, range));
            }
        }
        let light = Light { role, kind, color: space.color, ..Light::default() };
        Ok((Self { light, alleles }, bounds))
    }

    fn decode(&self, values: &[f32]) -> Light {
        let mut light = self.light;
        for (allele, &value) in std::iter::zip(&self.alleles, values) {
            (allele.set)(&mut light, value);
        }
        light
    }
}

impl Genome {
    /// A codec for rigs with one light for each of `roles`.
    ///
    /// # Errors
    /// [`Error::Argument`] for no or too many lights, a role that is not searched, or a box that is empty,
    /// not finite or has negative intensities or distances.
    pub fn new(roles: &[Role], kind: LightKind, boxes: &Boxes) -> Result<Self> {
        check_number(roles.len())?;
        let (mut searched, mut bounds) = (Vec::new(), Vec::new());
        for &role in roles {
            let (light, ranges) = Searched::new(role, kind, boxes)?;
            searched.push(light);
            bounds.extend(ranges);
        }
        Ok(Self { roles: roles.to_vec(), searched, bounds, fixed: Rig::new() })
    }

    /// The same with lights that stand fast: they follow the searched ones in every rig.
    ///
    /// # Errors
    /// [`Error::Argument`] when a rig has more than [`MAX_LIGHTS`] then.
    pub fn with_fixed(mut self, fixed: &[Light]) -> Result<Self> {
        let (searched, fixed_lights) = (self.searched.len(), fixed.len());
        if searched + fixed_lights > MAX_LIGHTS {
            return Err(Error::Argument(format!(
                "{searched} lights to search and {fixed_lights} of the scene's own: a rig has at most \
                 {MAX_LIGHTS}"
            )));
        }
        self.fixed = fixed.to_vec();
        Ok(self)
    }

    /// The box: lowest and highest value of each allele.
    pub fn bounds(&self) -> &[Range] {
        &self.bounds
    }

    /// The searched lights' roles.
    pub fn roles(&self) -> &[Role] {
        &self.roles
    }

    /// Number of lights that are searched.
    pub fn lights(&self) -> usize {
        self.roles.len()
    }

    /// Number of lights of a rig: the searched and the fixed ones.
    pub fn rig_lights(&self) -> usize {
        self.roles.len() + self.fixed.len()
    }

    /// The alleles of a searched light, in the order of the chromosome.
    pub fn alleles(&self, light: usize) -> &[&'static Allele] {
        &self.searched[light].alleles
    }

    /// The rig of a chromosome.
    pub fn decode(&self, mut chromosome: &[f32]) -> Rig {
        let mut decode = |searched: &Searched| {
            let values = chromosome.split_off(..searched.alleles.len()).unwrap_or_default();
            searched.decode(values)
        };
        let lights: Rig = self.searched.iter().map(&mut decode).collect();
        lights.into_iter().chain(self.fixed.iter().copied()).collect()
    }

    /// The chromosome of a rig's searched lights, which come first, each allele moved to the nearest value
    /// of its box; azimuths are turned by full circles first.
    pub fn encode(&self, rig: &[Light]) -> Vec<f32> {
        let values = std::iter::zip(&self.searched, rig).flat_map(|(searched, light)| {
            searched.alleles.iter().map(move |a| (a, (a.get)(light)))
        });
        std::iter::zip(values, &self.bounds)
            .map(
                |((allele, value), range)| {
                    if allele.turns { nearest_turn(value, range) } else { range.nearest(value) }
                },
            )
            .collect()
    }

    /// # Errors
    /// [`Error::Argument`] unless the first values of each light are its elevation and its azimuth.
    pub(crate) fn check_angles(&self) -> Result<()> {
        let named = |light: &Searched| {
            let names: Vec<_> = light.alleles.iter().map(|allele| allele.name).collect();
            names.starts_with(&[ELEVATION.name, AZIMUTH.name])
        };
        match self.searched.iter().find(|light| !named(light)) {
            Some(Searched { light, .. }) => Err(Error::Argument(format!(
                "lights of kind {} are not placed by elevation and azimuth",
                light.kind
            ))),
            None => Ok(()),
        }
    }

    /// Goes on in the light frame `to`, where the fixed lights keep their places.
    pub(crate) fn follow(&mut self, from: &Frame, to: &Frame) {
        self.fixed.iter_mut().for_each(|light| *light = light.moved(from, to));
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
    let RoleBox { elevation, azimuth, diffuse, specular, distance, cone, color: _ } = space;
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

fn no_range(role: Role, name: &str, &Range { low, high }: &Range) -> Error {
    Error::Argument(format!("the {role:?} box's {name} {low}..{high} is not a range of values"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::kinds::KINDS;
    use proptest::prelude::*;

    const ROLES: [Role; 3] = [Role::Key, Role::Fill, Role::Rim];

    proptest! {
        #[test]
        fn decoding_and_encoding_invert_each_other(
            shares in prop::collection::vec(0f32..=1.0, 18), kind in 0..KINDS.len(), one: bool,
        ) {
            let kind = KINDS[kind];
            let mut boxes = Boxes::default();
            if one {
                boxes.fill.specular = None;
            }
            let genome = Genome::new(&ROLES, kind, &boxes).unwrap();
            let place = |(r, t): (&Range, &f32)| r.at(*t);
            let chromosome: Vec<f32> = genome.bounds().iter().zip(&shares).map(place).collect();
            prop_assert_eq!(genome.encode(&genome.decode(&chromosome)), chromosome);
        }
    }

    #[test]
    fn a_rim_light_in_front_goes_to_the_nearest_side() {
        let genome = Genome::new(&[Role::Rim], LightKind::DIRECTIONAL, &Boxes::default()).unwrap();
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
    fn the_paper_s_chromosome_has_its_order() {
        let names = |kind| {
            let genome = Genome::new(&[Role::Key], kind, &Boxes::default()).unwrap();
            genome.alleles(0).iter().map(|allele| allele.name).collect::<Vec<_>>()
        };
        let point = ["elevation", "azimuth", "diffuse", "specular", "distance"];
        assert_eq!(names(LightKind::POINT), point);
        assert_eq!(names(LightKind::DIRECTIONAL), point[..4]);
        assert_eq!(names(LightKind::SPOT), [&point[..], &["cone"]].concat());
    }

    #[test]
    fn a_box_without_specular_gives_lights_of_one_intensity() {
        let mut boxes = Boxes::default();
        boxes.key.specular = None;
        boxes.key.color = "3200K".parse().unwrap();
        let genome = Genome::new(&[Role::Key, Role::Fill], LightKind::POINT, &boxes).unwrap();
        assert_eq!(genome.bounds().len(), 4 + 5);
        let rig = genome.decode(&[0.5, 0.25, 1.5, 3.0, 0.1, -0.2, 0.5, 0.75, 2.0]);
        assert_eq!((rig[0].diffuse, rig[0].specular, rig[0].distance), (1.5, 1.5, 3.0));
        assert_eq!((rig[1].diffuse, rig[1].specular, rig[1].distance), (0.5, 0.75, 2.0));
        assert_eq!((rig[0].color, rig[1].color), (boxes.key.color, Color::WHITE));
        assert_eq!(genome.encode(&rig), [0.5, 0.25, 1.5, 3.0, 0.1, -0.2, 0.5, 0.75, 2.0]);
    }

    #[test]
    fn fixed_lights_follow_the_searched_ones_and_have_no_alleles() {
        let genome = Genome::new(&[Role::Key], LightKind::DIRECTIONAL, &Boxes::default()).unwrap();
        let sun = Light { role: Role::Scene, diffuse: 3.0, ..Light::default() };
        let with_sun = genome.clone().with_fixed(&[sun]).unwrap();
        assert_eq!((with_sun.lights(), with_sun.rig_lights()), (1, 2));
        assert_eq!(with_sun.bounds(), genome.bounds());
        let chromosome = [0.5, 0.25, 1.5, 0.5];
        let rig = with_sun.decode(&chromosome);
        assert_eq!(rig, [&genome.decode(&chromosome)[..], &[sun]].concat());
        assert_eq!(with_sun.encode(&rig), chromosome);
        assert!(genome.clone().with_fixed(&[sun; 15]).is_ok());
        let fault = genome.with_fixed(&[sun; 16]).unwrap_err().to_string();
        assert!(fault.contains("1 lights to search and 16"), "{fault}");
        let scene = Genome::new(&[Role::Scene], LightKind::POINT, &Boxes::default());
        assert!(scene.unwrap_err().is_input());
    }

    #[test]
    fn bad_boxes_are_refused() {
        for range in [Range::new(1.0, 0.0), Range::new(f32::NAN, 1.0), Range::new(-1.0, 1.0)] {
            let mut boxes = Boxes::default();
            boxes.fill.diffuse = range;
            assert!(Genome::new(&[Role::Fill], LightKind::POINT, &boxes).is_err(), "{range:?}");
            assert!(Genome::new(&[Role::Key], LightKind::POINT, &boxes).is_ok());
        }
        let mut boxes = Boxes::default();
        boxes.key.cone = Range::new(10.0, 91.0);
        assert!(Genome::new(&[Role::Key], LightKind::SPOT, &boxes).is_err());
        assert!(Genome::new(&[], LightKind::POINT, &Boxes::default()).is_err());
        assert!(Genome::new(&[Role::Key; 17], LightKind::POINT, &Boxes::default()).is_err());
    }
}
