//! Real-coded chromosomes of rigs: one allele for each value of each light (Ha and Olivier 2006,
//! section 4), in the light's own units.

mod boxes;

use super::kinds::alleles::{AZIMUTH, ELEVATION};
use super::kinds::{Allele, Relation};
use super::{Light, LightKind, MAX_LIGHTS, Rig, Role, check_number};
use crate::math::frame::Frame;
use crate::math::range::Range;
use crate::{Error, Result};
pub use boxes::{Boxes, RoleBox};
use boxes::{check, no_range};

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
    /// What no gene says.
    light: Light,
    /// What the search may change, in the chromosome's order.
    genes: Vec<Gene>,
}

/// A value of a light that is searched.
#[derive(Debug, Clone, Copy)]
struct Gene {
    allele: &'static Allele,
    range: Range,
    relation: Option<Relation>,
}

impl Gene {
    /// The nearest value of its range to that of a light.
    fn encode(&self, light: &Light, key: &Light) -> f32 {
        let value = |light| (self.allele.get)(light);
        let value = match self.relation {
            Some(relation) => relation.relative(value(light), value(key)),
            None => value(light),
        };
        let range = &self.range;
        if self.allele.turns { nearest_turn(value, range) } else { range.nearest(value) }
    }

    fn decode(&self, value: f32, light: &mut Light, key: &Light) {
        let value = match self.relation {
            Some(relation) => relation.absolute(value, (self.allele.get)(key)),
            None => value,
        };
        (self.allele.set)(light, value);
    }
}

impl Searched {
    /// A light of one of `roles`. Without a key among them nothing is relative to it.
    fn new(role: Role, roles: &[Role], kind: LightKind, boxes: &Boxes) -> Result<Self> {
        let space = boxes.of(role)?;
        check(role, space)?;
        let keyed = roles.contains(&Role::Key);
        let gene = |allele: &'static Allele| {
            let relation = (allele.relation)(space).filter(|_| keyed);
            Some(Gene { allele, range: (allele.range)(space)?, relation })
        };
        let genes: Vec<Gene> = kind.alleles().iter().filter_map(gene).collect();
        for Gene { allele, range, .. } in &genes {
            if !range.is_valid() {
                return Err(no_range(role, allele.name, range));
            }
        }
        let light = Light { role, kind, color: space.color, ..Light::default() };
        Ok(Self { light, genes })
    }

    fn decode(&self, values: &[f32], key: &Light) -> Light {
        let mut light = self.light;
        for (gene, &value) in std::iter::zip(&self.genes, values) {
            gene.decode(value, &mut light, key);
        }
        light
    }

    fn encode(&self, light: &Light, key: &Light) -> Vec<f32> {
        self.genes.iter().map(|gene| gene.encode(light, key)).collect()
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
        let searched = roles.iter().map(|&role| Searched::new(role, roles, kind, boxes));
        let searched: Vec<_> = searched.collect::<Result<_>>()?;
        let bounds =
            searched.iter().flat_map(|light| &light.genes).map(|gene| gene.range).collect();
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
    pub fn alleles(&self, light: usize) -> impl Iterator<Item = &'static Allele> {
        self.searched[light].genes.iter().map(|gene| gene.allele)
    }

    /// The rig of a chromosome.
    pub fn decode(&self, chromosome: &[f32]) -> Rig {
        let absolute = Light::default();
        let key = self.parts(chromosome).find(|(light, _)| light.light.role == Role::Key);
        let key = key.map_or(absolute, |(light, values)| light.decode(values, &absolute));
        let searched = self.parts(chromosome).map(|(light, values)| light.decode(values, &key));
        searched.chain(self.fixed.iter().copied()).collect()
    }

    /// Each light with its part of a chromosome.
    fn parts<'a>(
        &'a self,
        mut chromosome: &'a [f32],
    ) -> impl Iterator<Item = (&'a Searched, &'a [f32])> {
        self.searched.iter().map(move |light| {
            (light, chromosome.split_off(..light.genes.len()).unwrap_or_default())
        })
    }

    /// The chromosome of a rig's searched lights, which come first, each allele moved to the nearest value
    /// of its box; azimuths are turned by full circles first. What is relative to the key is so to the key as
    /// its box has it.
    pub fn encode(&self, rig: &[Light]) -> Vec<f32> {
        let absolute = Light::default();
        let lights = || std::iter::zip(&self.searched, rig);
        let key = lights().find(|(searched, _)| searched.light.role == Role::Key);
        let key = key.map_or(absolute, |(searched, light)| {
            searched.decode(&searched.encode(light, &absolute), &absolute)
        });
        lights().flat_map(|(searched, light)| searched.encode(light, &key)).collect()
    }

    /// # Errors
    /// [`Error::Argument`] unless the first values of each light are its elevation and its azimuth.
    pub(crate) fn check_angles(&self) -> Result<()> {
        let named = |light: &Searched| {
            let names: Vec<_> = light.genes.iter().map(|gene| gene.allele.name).collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::Color;
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

    /// Fill and rim relative to the key, of one intensity.
    fn relative() -> Boxes {
        let mut boxes = Boxes::default();
        boxes.all_mut().into_iter().for_each(|space| space.specular = None);
        for space in [&mut boxes.fill, &mut boxes.rim] {
            (space.azimuth_from_key, space.share_of_key) = (true, true);
        }
        boxes.fill.azimuth = Range::new(20.0, 110.0);
        boxes
    }

    fn near(a: &[f32], b: &[f32]) -> bool {
        std::iter::zip(a, b).all(|(a, b)| (a - b).abs() < 1e-4 * a.abs().max(1.0))
    }

    proptest! {
        #[test]
        fn what_is_relative_to_the_key_is_decoded_and_encoded_too(
            shares in prop::collection::vec(0.01f32..=1.0, 24), kind in 0..KINDS.len(),
            order in Just([Role::Key, Role::Fill, Role::Rim, Role::Key]).prop_shuffle(), two: bool,
        ) {
            let mut boxes = relative();
            if two {
                boxes.all_mut().into_iter().for_each(|space| space.specular = Some(space.diffuse));
            }
            let genome = Genome::new(&order, KINDS[kind], &boxes).unwrap();
            let place = |(r, t): (&Range, &f32)| r.at(*t);
            let chromosome: Vec<f32> = genome.bounds().iter().zip(&shares).map(place).collect();
            let rig = genome.decode(&chromosome);
            let again = genome.encode(&rig);
            prop_assert!(near(&again, &chromosome), "{again:?} {chromosome:?}");
            for (light, role) in rig.iter().zip(order) {
                prop_assert_eq!(light.role, role);
            }
        }
    }

    /// Azimuths in degrees and intensities, of alleles by which a genome decodes to directional lights.
    fn placed(roles: &[Role], alleles: &[[f32; 2]]) -> (Genome, Vec<[f32; 2]>) {
        let genome = Genome::new(roles, LightKind::DIRECTIONAL, &relative()).unwrap();
        let gene = |&[azimuth, intensity]: &[f32; 2]| [0.5, azimuth.to_radians(), intensity];
        let rig = genome.decode(&alleles.iter().flat_map(gene).collect::<Vec<_>>());
        let place = |light: &Light| [light.azimuth.to_degrees().round(), light.diffuse];
        (genome, rig.iter().map(place).collect())
    }

    #[test]
    fn a_fill_stands_across_from_its_key_with_a_share_of_its_intensity() {
        use Role::{Fill, Key, Rim};
        let (_, right) = placed(&[Key, Fill], &[[30.0, 1.5], [50.0, 0.5]]);
        assert_eq!(right, [[30.0, 1.5], [-20.0, 0.75]]);
        let (_, left) = placed(&[Key, Fill], &[[-30.0, 1.5], [50.0, 0.5]]);
        assert_eq!(left, [[-30.0, 1.5], [20.0, 0.75]]);
        // The first key counts, wherever it stands.
        let (_, many) = placed(
            &[Fill, Key, Rim, Key, Fill],
            &[[100.0, 0.5], [40.0, 2.0], [140.0, 0.25], [-80.0, 1.0], [30.0, 1.0]],
        );
        let expected = [[-60.0, 1.0], [40.0, 2.0], [-100.0, 0.5], [-80.0, 1.0], [10.0, 2.0]];
        assert_eq!(many, expected);
        // Without a key, values stand for themselves.
        let (_, alone) = placed(&[Fill, Rim], &[[50.0, 0.5], [120.0, 0.25]]);
        assert_eq!(alone, [[50.0, 0.5], [120.0, 0.25]]);
    }

    #[test]
    fn given_rigs_move_to_the_nearest_values_relative_to_the_key() {
        let (genome, _) = placed(&[Role::Key, Role::Fill], &[[0.0, 1.0], [20.0, 0.5]]);
        let encode = |key: [f32; 2], fill: [f32; 2]| {
            let light = |[azimuth, diffuse]: [f32; 2]| Light {
                azimuth: azimuth.to_radians(),
                diffuse,
                ..Light::default()
            };
            let values = genome.encode(&[light(key), light(fill)]);
            [values[4].to_degrees().round(), values[5]]
        };
        assert_eq!(encode([45.0, 1.0], [-45.0, 0.5]), [90.0, 0.5]);
        assert_eq!(encode([45.0, 1.0], [315.0, 0.5]), [90.0, 0.5], "after a full turn");
        assert_eq!(encode([45.0, 1.0], [60.0, 3.0]), [20.0, 1.0], "beside the key and too bright");
        // The key itself is moved into its box first: to 90 degrees and the intensity 2.
        assert_eq!(encode([120.0, 4.0], [40.0, 1.0]), [50.0, 0.5]);
        assert_eq!(encode([45.0, 0.0], [-45.0, 0.5]), [90.0, 0.0], "a share of nothing");
    }

    #[test]
    fn fixed_lights_are_relative_to_nothing() {
        let (genome, _) = placed(&[Role::Key, Role::Fill], &[[0.0, 1.0], [20.0, 0.5]]);
        let sun = Light { role: Role::Scene, azimuth: 1.0, diffuse: 3.0, ..Light::default() };
        let chromosome = [0.5, 0.25, 1.5, 0.25, 1.0, 0.5];
        let rig = genome.clone().with_fixed(&[sun]).unwrap().decode(&chromosome);
        assert_eq!(rig, [&genome.decode(&chromosome)[..], &[sun]].concat());
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
            genome.alleles(0).map(|allele| allele.name).collect::<Vec<_>>()
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
        let mut boxes = relative();
        boxes.key.share_of_key = true;
        let fault = Genome::new(&[Role::Key], LightKind::POINT, &boxes).unwrap_err().to_string();
        assert!(fault.contains("relative to the key"), "{fault}");
        let mut boxes = Boxes::default();
        boxes.key.cone = Range::new(10.0, 91.0);
        assert!(Genome::new(&[Role::Key], LightKind::SPOT, &boxes).is_err());
        assert!(Genome::new(&[], LightKind::POINT, &Boxes::default()).is_err());
        assert!(Genome::new(&[Role::Key; 17], LightKind::POINT, &Boxes::default()).is_err());
    }
}
