//! Light from a point at a distance, within a cone around the scene's centre.

use super::Kind;
use super::alleles::{AZIMUTH, CONE, DIFFUSE, DISTANCE, ELEVATION, SPECULAR};

pub(super) static SPOT: Kind = Kind {
    name: "spot",
    meaning: "Lights at a distance that shine in a cone",
    parallel: false,
    cone: true,
    alleles: &[ELEVATION, AZIMUTH, DIFFUSE, SPECULAR, DISTANCE, CONE],
};
