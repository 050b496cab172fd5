//! Light from a point at a distance, in all directions.

use super::Kind;
use super::alleles::{AZIMUTH, DIFFUSE, DISTANCE, ELEVATION, SPECULAR};

pub(super) static POINT: Kind = Kind {
    name: "point",
    meaning: "Lights at a distance, with falloff",
    parallel: false,
    cone: false,
    alleles: &[ELEVATION, AZIMUTH, DIFFUSE, SPECULAR, DISTANCE],
};
