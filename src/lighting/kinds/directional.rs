//! Parallel light, as the sun's.

use super::Kind;
use super::alleles::{AZIMUTH, DIFFUSE, ELEVATION, SPECULAR};

pub(super) static DIRECTIONAL: Kind = Kind {
    name: "directional",
    meaning: "Parallel light without falloff",
    parallel: true,
    cone: false,
    alleles: &[ELEVATION, AZIMUTH, DIFFUSE, SPECULAR],
};
