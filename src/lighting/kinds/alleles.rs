//! The values of lights of which kinds make their lists.

use super::{Allele, Relation};
use crate::lighting::Cone;
use crate::lighting::genome::RoleBox;

fn share(space: &RoleBox) -> Option<Relation> {
    space.share_of_key.then_some(Relation::Share)
}

/// Elevation θ, radians.
pub const ELEVATION: Allele = Allele {
    name: "elevation",
    range: |space| Some(space.elevation.to_radians()),
    get: |light| light.elevation,
    set: |light, value| light.elevation = value,
    turns: false,
    relation: |_| None,
};

/// Azimuth φ, radians.
pub const AZIMUTH: Allele = Allele {
    name: "azimuth",
    range: |space| Some(space.azimuth.to_radians()),
    get: |light| light.azimuth,
    set: |light, value| light.azimuth = value,
    turns: true,
    relation: |space| space.azimuth_from_key.then_some(Relation::Azimuth),
};

/// Diffuse intensity `Id`. It sets the specular one too, so that a light without the allele
/// [`SPECULAR`] has one intensity.
pub const DIFFUSE: Allele = Allele {
    name: "diffuse",
    range: |space| Some(space.diffuse),
    get: |light| light.diffuse,
    set: |light, value| (light.diffuse, light.specular) = (value, value),
    turns: false,
    relation: share,
};

/// Specular intensity `Is`, where the box gives it a range of its own.
pub const SPECULAR: Allele = Allele {
    name: "specular",
    range: |space| space.specular,
    get: |light| light.specular,
    set: |light, value| light.specular = value,
    turns: false,
    relation: share,
};

/// Distance `R` from the scene's centre, scene radii.
pub const DISTANCE: Allele = Allele {
    name: "distance",
    range: |space| Some(space.distance),
    get: |light| light.distance,
    set: |light, value| light.distance = value,
    turns: false,
    relation: |_| None,
};

/// Half angle of the whole cone, radians; that of its bright inner part is half of it.
pub const CONE: Allele = Allele {
    name: "cone",
    range: |space| Some(space.cone.to_radians()),
    get: |light| light.cone.outer,
    set: |light, value| light.cone = Cone { inner: 0.5 * value, outer: value },
    turns: false,
    relation: |_| None,
};
