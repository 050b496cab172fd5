//! Standard functions that searches are tested with, in [`D`] dimensions, lowest at places that are no box's middle.

/// Number of dimensions.
pub const D: usize = 10;

/// A function to be searched.
pub type Function = fn(&[f32]) -> f32;

/// Distance from the lowest point.
fn offset(x: &[f32]) -> [f64; D] {
    std::array::from_fn(|i| f64::from(x[i]) - (-2.0 + 0.4 * i as f64))
}

pub fn sphere(x: &[f32]) -> f32 {
    offset(x).iter().map(|z| z * z).sum::<f64>() as f32
}

pub fn rosenbrock(x: &[f32]) -> f32 {
    let z = offset(x).map(|z| z + 1.0);
    let term = |z: &[f64]| 100.0 * (z[1] - z[0] * z[0]).powi(2) + (1.0 - z[0]).powi(2);
    z.windows(2).map(term).sum::<f64>() as f32
}

/// Axes of 1 to 1000, turned by Givens rotations in the planes of each two that follow each other.
pub fn ellipsoid(x: &[f32]) -> f32 {
    let mut z = offset(x);
    for i in 0..D - 1 {
        let (sin, cos) = (0.3 * (i + 1) as f64).sin_cos();
        (z[i], z[i + 1]) = (cos * z[i] - sin * z[i + 1], sin * z[i] + cos * z[i + 1]);
    }
    let scale = |i: usize| 10f64.powf(6.0 * i as f64 / (D - 1) as f64);
    z.iter().enumerate().map(|(i, z)| scale(i) * z * z).sum::<f64>() as f32
}

pub fn rastrigin(x: &[f32]) -> f32 {
    let term = |z: &f64| z * z + 10.0 - 10.0 * (std::f64::consts::TAU * z).cos();
    offset(x).iter().map(term).sum::<f64>() as f32
}
