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
use glam::Vec3;

/// The codec between rigs and chromosomes. A light's alleles are those of its kind
/// ([`Kind::alleles`](super::kinds::Kind::alleles)) that its role's box gives a range.
#[derive(Debug, Clone)]
pub struct Genome {
    roles: Vec<Role>,
    searched: Vec<Searched>,
    bounds: Vec<Range>,
    fixed: Rig,
    /// Unit vector upwards in the light frame, where no searched light may stand below the horizon.
    up: Option<Vec3>,
}

/// A light that is searched.
#[derive(Debug, Clone)]
struct Searched {
    /// What no gene says.
    light: Light,
    /// What the search may change, in the chromosome's order.
    genes: Vec<Gene>,
    /// What has one value for good.
    held: Vec<(&'static Allele, f32)>,
    /// Radius of the light at the distance 1; `None` for the light's own.
    size: Option<f32>,
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
        let size = Some(space.size());
        Ok(Self { light, genes, held: Vec::new(), size })
    }

    fn decode(&self, values: &[f32], key: &Light) -> Light {
        let mut light = self.light;
        for (gene, &value) in std::iter::zip(&self.genes, values) {
            gene.decode(value, &mut light, key);
        }
        self.held.iter().for_each(|&(allele, value)| (allele.set)(&mut light, value));
        if let Some(size) = self.size {
            light.size = size * light.reach().unwrap_or(1.0);
        }
        light
    }

    /// Leaves the search one value less, or none at all.
    fn hold(&mut self, light: &Light, value: Option<&str>) -> Result<()> {
        let Some(name) = value else {
            *self = Self { light: *light, genes: Vec::new(), held: Vec::new(), size: None };
            return Ok(());
        };
        let Some(at) = self.genes.iter().position(|gene| gene.allele.name == name) else {
            let known: Vec<_> = self.genes.iter().map(|gene| gene.allele.name).collect();
            return Err(Error::Argument(format!(
                "the {} light has no '{name}' to keep: it has {}",
                self.light.role.name(),
                known.join(", ")
            )));
        };
        let allele = self.genes.remove(at).allele;
        self.held.push((allele, (allele.get)(light)));
        Ok(())
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
        Ok(Self::of(roles.to_vec(), searched.collect::<Result<_>>()?))
    }

    /// A codec for rigs like this one: each light keeps what its kind has no allele for, such as its colour, and the angle
    /// that it covers seen from the scene's centre.
    ///
    /// # Errors
    /// As [`Genome::new`].
    pub fn like(rig: &[Light], boxes: &Boxes) -> Result<Self> {
        check_number(rig.len())?;
        let roles: Vec<Role> = rig.iter().map(|light| light.role).collect();
        let like = |light: &Light| {
            let searched = Searched::new(light.role, &roles, light.kind, boxes)?;
            let size = Some(light.size / light.reach().unwrap_or(1.0));
            Ok(Searched { light: *light, size, ..searched })
        };
        let searched = rig.iter().map(like).collect::<Result<_>>()?;
        Ok(Self::of(roles, searched))
    }

    fn of(roles: Vec<Role>, searched: Vec<Searched>) -> Self {
        let genes = searched.iter().flat_map(|light: &Searched| &light.genes);
        let bounds = genes.map(|gene| gene.range).collect();
        Self { roles, searched, bounds, fixed: Rig::new(), up: None }
    }

    /// The same with no searched light below the horizon: one that its box would put there is raised onto it.
    /// `up` is the unit vector upwards in the light frame.
    ///
    /// # Errors
    /// [`Error::Argument`] for a vector that is not of length 1.
    pub fn above_horizon(mut self, up: Vec3) -> Result<Self> {
        if !up.is_normalized() {
            let fault = format!("{up} is no direction upwards: it must be of length 1");
            return Err(Error::Argument(fault));
        }
        self.up = Some(up);
        Ok(self)
    }

    /// The same with a searched light held as it is in `light`, or one of its values, by its
    /// [`Allele::name`]: what is held has no part in the chromosome, and a light that
    /// is held as a whole is moved by neither box nor horizon.
    ///
    /// # Errors
    /// [`Error::Argument`] for a light or a value that is not searched, and where nothing is left to search.
    pub fn hold(mut self, at: usize, light: &Light, value: Option<&str>) -> Result<Self> {
        let count = self.lights();
        let searched = self.searched.get_mut(at).ok_or_else(|| {
            Error::Argument(format!("there is no light {at} to keep among {count} lights"))
        })?;
        searched.hold(light, value)?;
        let genes = self.searched.iter().flat_map(|light| &light.genes);
        self.bounds = genes.map(|gene| gene.range).collect();
        if self.bounds.is_empty() {
            return Err(Error::Argument("all lights are kept: nothing is left to search".into()));
        }
        Ok(self)
    }

    /// The same with its first searched lights alone, at least one.
    pub fn of_first(&self, lights: usize) -> Self {
        let lights = lights.clamp(1, self.lights());
        let (roles, searched) = (self.roles[..lights].to_vec(), self.searched[..lights].to_vec());
        Self { fixed: self.fixed.clone(), up: self.up, ..Self::of(roles, searched) }
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
        let searched = self.parts(chromosome).map(|(light, values)| {
            let decoded = light.decode(values, &key);
            match self.up.filter(|_| light.size.is_some()) {
                Some(up) => raised(decoded, up),
                None => decoded,
            }
        });
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
        for searched in &mut self.searched {
            if searched.size.is_none() {
                searched.light = searched.light.moved(from, to);
            }
        }
        self.up = self.up.map(|up| {
            let up = from.direction_to_world(up.as_dvec3());
            to.from_world().transform_vector3(up).normalize_or(glam::DVec3::Y).as_vec3()
        });
    }
}

/// The light, raised onto the horizon where it stands below: `up` is upwards.
fn raised(light: Light, up: Vec3) -> Light {
    if light.direction().dot(up) >= 0.0 {
        return light;
    }
    // On the horizon sin θ·u_y + cos θ·a = 0, with a the part of `up` along the azimuth.
    let along = up.x * light.azimuth.sin() + up.z * light.azimuth.cos();
    Light { elevation: (-along / up.y).atan(), ..light }
}

/// The value of `range` that is nearest to `angle` or to one of its full turns, radians.
fn nearest_turn(angle: f32, range: &Range) -> f32 {
    let turns = [0.0, std::f32::consts::TAU, -std::f32::consts::TAU].map(|turn| angle + turn);
    let distance = |&a: &f32| (a - range.nearest(a)).abs();
    let nearest = turns.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    range.nearest(nearest.unwrap_or(angle))
}

#[cfg(test)]
mod tests;
