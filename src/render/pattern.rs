//! Where samples of lights and of the sky lie: the same in every run.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// A point of the unit square that belongs to a pixel: pixels beside each other have values far apart.
/// Interleaved gradient noise (Jimenez, *Next Generation Post Processing in Call of Duty*, 2014); `dimension`
/// tells independent ones apart.
pub fn shift([x, y]: [u32; 2], dimension: u32) -> Vec2 {
    let noise =
        |x: f32, y: f32| (52.982_92 * (0.067_110_56 * x + 0.005_837_15 * y).fract()).fract();
    let (x, y, other) = (x as f32, y as f32, dimension as f32);
    Vec2::new(noise(x + 5.588 * other, y), noise(x + 47.0, y + 17.0 + 5.588 * other))
}

/// Point `index` of a sequence that fills the unit square evenly however many of its points are taken,
/// moved round by `shift` (Roberts, *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018).
pub fn even(index: u32, shift: Vec2) -> Vec2 {
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    let along = |step: f64, shift: f32| (f64::from(index) * step + f64::from(shift)).fract() as f32;
    Vec2::new(along(STEP[0], shift.x), along(STEP[1], shift.y))
}

/// The unit disc of the unit square, areas kept (Shirley and Chiu 1997).
pub fn disc(square: Vec2) -> Vec2 {
    let p = 2.0 * square - 1.0;
    if p == Vec2::ZERO {
        return p;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    radius * Vec2::from_angle(angle)
}

/// A direction around the unit vector `normal`, as dense as the cosine between them (Malley's method).
pub fn cosine(square: Vec2, normal: Vec3) -> Vec3 {
    let (radius, angle) = (square.x.sqrt(), TAU * square.y);
    let (x, y) = normal.any_orthonormal_pair();
    let height = (1.0 - square.x).max(0.0).sqrt();
    x * (radius * angle.cos()) + y * (radius * angle.sin()) + normal * height
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_the_disc_has_its_share_of_the_points() {
        let points: Vec<_> = (0..128).map(|i| disc(even(i, shift([17, 5], 2)))).collect();
        assert!(points.iter().all(|p| p.length() <= 1.0 + 1e-6));
        let share = |inside: &dyn Fn(&Vec2) -> bool| {
            points.iter().filter(|p| inside(p)).count() as f32 / points.len() as f32
        };
        assert!((share(&|p| p.length_squared() < 0.5) - 0.5).abs() < 0.05);
        assert!((share(&|p| p.x > 0.0) - 0.5).abs() < 0.05);
        assert!((share(&|p| p.y > p.x) - 0.5).abs() < 0.05);
    }

    #[test]
    fn directions_are_as_dense_as_the_cosine() {
        let normal = Vec3::new(0.6, -0.48, 0.64);
        let all = (0..256).map(|i| cosine(even(i, Vec2::ZERO), normal));
        let mean =
            all.inspect(|d| assert!(d.is_normalized() && d.dot(normal) >= 0.0)).sum::<Vec3>();
        // The mean of the cosine, weighed by the cosine, is 2/3.
        assert!((mean / 256.0).abs_diff_eq(normal * (2.0 / 3.0), 0.01), "{mean}");
    }

    #[test]
    fn neighbours_have_shifts_far_apart() {
        for (a, b) in [([8, 8], [9, 8]), ([8, 8], [8, 9]), ([300, 7], [301, 7])] {
            assert!((shift(a, 0) - shift(b, 0)).abs().max_element() > 0.05, "{a:?} {b:?}");
        }
        assert_ne!(shift([3, 4], 0), shift([3, 4], 1));
    }
}
