//! Elementary functions for the inner loops: branch-free and without calls, so that compilers turn
//! loops over them into vector code, and from IEEE basic operations alone, so that they give the same
//! bits on every machine. The minimax polynomials are N. Juffa's, in the public domain.

use std::f32::consts::LN_2;
use std::hint::select_unpredictable;

/// `1/√x` for normal `x > 0`, within 3e-7 of it; finite for 0.
#[inline(always)]
pub fn reciprocal_sqrt(x: f32) -> f32 {
    let half = 0.5 * x;
    let mut y = f32::from_bits(0x5f37_5a86_u32.wrapping_sub(x.to_bits() >> 1));
    for _ in 0..3 {
        y *= 1.5 - half * y * y;
    }
    y
}

/// `ln x` for normal `x > 0`, within 2e-7 of it relatively around 1; below -87 for 0.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    let bits = x.to_bits() as i32;
    // x = m·2^e with m in 2/3..4/3.
    let e = bits.wrapping_sub(0x3f2a_aaab) >> 23;
    let m = f32::from_bits(bits.wrapping_sub(e << 23) as u32) - 1.0;
    let s = m * m;
    let even = ((-0.130_310_06 * s - 0.121_483_51) * s - 0.166_846_13) * s - 0.249_996_2;
    let odd = (0.140_869_14 * s + 0.139_814_85) * s + 0.200_120_35;
    let tail = ((odd * m + even) * m + 0.333_331_97) * m - 0.5;
    e as f32 * LN_2 + (tail * s + m)
}

/// `2^y` for `-64 < y < 128`, within 3e-7 of it relatively; `2^-64` for all smaller `y`, so that
/// products of it stay clear of subnormal numbers, which are slow.
#[inline(always)]
pub fn exp2(y: f32) -> f32 {
    /// Adding it leaves the nearest integer in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let y = if y > -64.0 { y } else { -64.0 };
    let rounded = y + ROUND;
    let f = y - (rounded - ROUND);
    let high = ((1.537_203_8e-4 * f + 1.339_038_7e-3) * f + 9.618_178e-3) * f + 5.550_366e-2;
    let power = ((high * f + 0.240_226_63) * f + LN_2) * f + 1.0;
    f32::from_bits(power.to_bits().wrapping_add(rounded.to_bits() << 23))
}

/// The sRGB encoding of a linear value, clamped to 0..=1; see
/// [`crate::lighting::shading::srgb_encode`].
#[inline(always)]
pub fn srgb_encode(linear: f32) -> f32 {
    let x = if linear > 0.0 { linear } else { 0.0 };
    let x = if x < 1.0 { x } else { 1.0 };
    let power = exp2(ln(x) * (std::f32::consts::LOG2_E / 2.4));
    // A plain `if` becomes a branch, which keeps the loop from being vectorised.
    select_unpredictable(x <= 0.003_130_8, 12.92 * x, 1.055 * power - 0.055)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lighting::shading;

    /// Every 64th float of a range.
    fn floats(from: f32, to: f32) -> impl Iterator<Item = f32> {
        (from.to_bits()..=to.to_bits()).step_by(64).map(f32::from_bits)
    }

    /// Largest relative error against the exact function.
    fn worst(range: impl Iterator<Item = f32>, f: fn(f32) -> f32, exact: fn(f64) -> f64) -> f64 {
        range.map(|x| (f64::from(f(x)) / exact(x.into()) - 1.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn reciprocal_square_roots() {
        let error = worst(floats(1e-12, 1e6), reciprocal_sqrt, |x| 1.0 / x.sqrt());
        assert!(error < 3e-7, "{error}");
        assert!(reciprocal_sqrt(0.0).is_finite());
    }

    #[test]
    fn logarithms_keep_their_relative_precision_around_1() {
        let error = worst(floats(0.5, 0.999_999_9), ln, f64::ln);
        assert!(error < 3e-7, "{error}");
        let small = floats(1e-30, 0.5).map(|x| (f64::from(ln(x)) - f64::from(x).ln()).abs());
        assert!(small.fold(0.0, f64::max) < 8e-6);
        assert_eq!(ln(1.0), 0.0);
        assert!(ln(0.0) < -87.0);
    }

    #[test]
    fn powers_of_two() {
        let error = worst(floats(1e-9, 64.0).map(|y| -y), exp2, f64::exp2);
        assert!(error < 3e-7, "{error}");
        assert_eq!((exp2(0.0), exp2(-3.0)), (1.0, 0.125));
        assert_eq!(exp2(-1e9), 2f32.powi(-64));
    }

    #[test]
    fn highlights_stay_accurate_for_the_largest_exponent() {
        for s in [1.0f32, 10.0, 100.0, 1000.0, 4096.0] {
            let error = floats(0.5, 1.0)
                .map(|q| {
                    let fast = exp2(s * std::f32::consts::LOG2_E * ln(q));
                    (f64::from(fast) - f64::from(q).powf(s.into())).abs()
                })
                .fold(0.0, f64::max);
            assert!(error < 4e-7, "{s}: {error}");
        }
    }

    #[test]
    fn the_srgb_encoding_is_that_of_the_plain_one() {
        let error = floats(1e-9, 1.0).map(|x| (srgb_encode(x) - shading::srgb_encode(x)).abs());
        assert!(error.fold(0.0, f32::max) < 5e-7);
        for x in [0.0, -1.0, 1.0, 7.0, f32::INFINITY] {
            assert_eq!(srgb_encode(x), shading::srgb_encode(x));
        }
        assert_eq!(srgb_encode(f32::NAN), 0.0);
    }
}
