//! Implicit surfaces: signed distances (negative inside) and the ways to combine them.
//!
//! Distances are exact for spheres and first-order elsewhere, which is all that polygonisation
//! needs. The formulas are those of Inigo Quilez's collection, <https://iquilezles.org/articles/>.
//! Everything is `+ - * / sqrt` and `libm`, so that every machine computes the same bits.

use glam::{DVec2, DVec3};

/// Union with a fillet of width `k` (cubic, so that normals stay smooth across it).
pub fn union(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * h * k / 6.0
}

/// Intersection with an edge rounded over the width `k`.
pub fn intersection(a: f64, b: f64, k: f64) -> f64 {
    -union(-a, -b, k)
}

/// `a` without `b`, the edge rounded over the width `k`.
pub fn difference(a: f64, b: f64, k: f64) -> f64 {
    intersection(a, -b, k)
}

pub fn sphere(p: DVec3, centre: DVec3, radius: f64) -> f64 {
    (p - centre).length() - radius
}

/// Axis-aligned ellipsoid, first-order distance.
pub fn ellipsoid(p: DVec3, centre: DVec3, radii: DVec3) -> f64 {
    let q = (p - centre) / radii;
    let gradient = (q / radii).length();
    if gradient < 1e-9 {
        return -radii.min_element();
    }
    let k = q.length();
    k * (k - 1.0) / gradient
}

/// A flat shape with outline distance `outline`, at height `w` above its middle sheet, inflated
/// by `radius` to a plate with a rounded rim.
pub fn plate(outline: f64, w: f64, radius: f64) -> f64 {
    let inset = DVec2::new(outline + radius, w.abs());
    inset.max_element().min(0.0) + inset.max(DVec2::ZERO).length() - radius
}

/// Hermite step from 0 below `a` to 1 above `b`.
pub fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Rotation of `p` about the vertical axis through `pivot`, `angle` in radians.
pub fn turn_y(p: DVec3, pivot: DVec3, angle: f64) -> DVec3 {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let q = p - pivot;
    pivot + DVec3::new(cos * q.x + sin * q.z, q.y, cos * q.z - sin * q.x)
}

/// Gradient by central differences over `±step`.
pub fn gradient(field: &impl Fn(DVec3) -> f64, p: DVec3, step: f64) -> DVec3 {
    let along = |axis: DVec3| (field(p + axis * step) - field(p - axis * step)) / (2.0 * step);
    DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
}
