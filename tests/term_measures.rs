//! The CPU references of what terms need, on surfaces whose measures are known.

use glam::{DMat4, DVec3, Vec3};
use klieg::cpu::{self, appearance, fitness, gradient, normal_detail, visibility};
use klieg::lighting::shading::Shading;
use klieg::lighting::{Light, LightKind, Role, direction};
use klieg::math::color::srgb_encode;
use klieg::objective::maps::{Maps, PixelCounts, PixelType, Surface};
use klieg::objective::{Objective, Statistics, Terms, UNLIT};
use klieg::scene::{Material, Mesh};
use klieg_support::shapes::{matt, orthographic, rectangle, scene, sphere};
use std::f32::consts::FRAC_1_SQRT_2;

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance, "{a} is not {b}");
}

/// An objective of one term.
fn only(name: &str) -> Objective {
    let weights = Terms::named([(name, 1.0)]).expect("a term");
    Objective { weights, ..Objective::default() }
}

/// A directional light in a direction of degrees.
fn light(elevation: f32, azimuth: f32, diffuse: f32) -> Light {
    Light {
        role: Role::Key,
        kind: LightKind::DIRECTIONAL,
        elevation: elevation.to_radians(),
        azimuth: azimuth.to_radians(),
        distance: 1.0,
        diffuse,
        specular: 0.0,
        ..Light::default()
    }
}

/// What the references measure of parts under one light, for one term.
fn measure(
    parts: Vec<(Mesh, Material, DMat4)>,
    (half_height, side): (f64, u32),
    light: Light,
    name: &str,
) -> (Statistics, Maps, f32) {
    let objective = only(name);
    let scene = scene(parts);
    let view = orthographic(&scene, half_height, side, side);
    let maps = cpu::maps(visibility::draw(&scene, &view), &objective);
    let records = [light.record()];
    let made = fitness::fitness(&maps, &view, &objective, &Shading::default(), &records);
    (made.statistics, maps, made.score)
}

fn ball(light: Light, name: &str) -> (Statistics, Maps, f32) {
    measure(vec![(sphere(96), matt(0.8), DMat4::IDENTITY)], (1.1, 301), light, name)
}

/// The mean over the disc that a sphere shows, all places alike, where the normal is (x, y, √(1−x²−y²)).
fn disc_mean(value: impl Fn(Vec3) -> f64) -> f64 {
    let steps = 500;
    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(steps);
    let (mut sum, mut count) = (0.0, 0.0);
    for (j, i) in (-steps..steps).flat_map(|j| (-steps..steps).map(move |i| (j, i))) {
        let (x, y) = (at(i), at(j));
        let z2 = 1.0 - x * x - y * y;
        if z2 > 0.0 {
            sum += value(DVec3::new(x, y, z2.sqrt()).as_vec3());
            count += 1.0;
        }
    }
    sum / count
}

/// Mean, variance and covariance with `n_x` of the encoded irradiance of a sphere under light from `l`.
fn integrals(l: Vec3) -> [f64; 3] {
    let e = |n: Vec3| f64::from(srgb_encode(n.dot(l).max(0.0)));
    let mean = disc_mean(e);
    let variance = disc_mean(|n| (e(n) - mean).powi(2));
    [mean, variance, disc_mean(|n| (e(n) - mean) * f64::from(n.x))]
}

fn determination(statistics: &Statistics, maps: &Maps) -> f64 {
    let [xx, xy, yy] = maps.shape.normal_precision().expect("a shape").map(f64::from);
    let [x, y] = statistics.irradiance.covariance.map(f64::from);
    let explained = xx * x * x + 2.0 * xy * x * y + yy * y * y;
    explained / f64::from(statistics.irradiance.variance)
}

/// Over the disc, `n_x` and `n_y` have mean 0, variance 1/4 and covariance 0.
#[test]
fn a_ball_has_the_shape_of_its_integral() {
    let (_, maps, _) = ball(light(0.0, 0.0, 1.0), "relief");
    let shape = maps.shape;
    for (found, expected) in [
        (shape.normal_mean[0], 0.0),
        (shape.normal_mean[1], 0.0),
        (shape.normal_covariance[0], 0.25),
        (shape.normal_covariance[1], 0.0),
        (shape.normal_covariance[2], 0.25),
        (shape.base_luminance, 0.8),
    ] {
        close(found.into(), expected, 2e-3);
    }
    let mut half = maps.surface.clone();
    half.code.iter_mut().enumerate().for_each(|(at, code)| *code *= u32::from(at % 301 < 150));
    let half = cpu::maps(half, &Objective::default()).shape;
    assert!(half.normal_mean[0] < -0.3 && half.normal_covariance[0] < 0.1, "{half:?}");
}

#[test]
fn a_headlight_tells_no_relief_and_a_side_light_what_its_integral_says() {
    for azimuth in [0f32, 20.0, 60.0, 90.0] {
        let (found, maps, score) = ball(light(0.0, azimuth, 1.0), "relief");
        let [mean, variance, covariance] = integrals(direction(0.0, azimuth.to_radians()));
        close(found.irradiance.mean.into(), mean, 2e-3);
        close(found.irradiance.variance.into(), variance, 2e-3);
        close(found.irradiance.covariance[0].into(), covariance, 2e-3);
        close(found.irradiance.covariance[1].into(), 0.0, 1e-3);
        let expected = covariance * covariance / 0.25 / variance;
        let r2 = determination(&found, &maps);
        close(r2, expected, 1e-2);
        close(score.into(), 1.0 - (r2 / 0.6).min(1.0), 1e-3);
        // Planted: the same light from another side.
        let [_, other, less] = integrals(direction(0.0, (azimuth + 10.0).to_radians()));
        assert!((less * less / 0.25 / other - r2).abs() > 1e-2, "{azimuth}");
        if azimuth == 0.0 {
            assert!(r2 < 1e-3 && score > 0.99, "{r2}");
        }
        if azimuth == 90.0 {
            assert!(r2 > 0.6 && score == 0.0, "{r2}");
        }
    }
    // From above it is the other axis that tells.
    let (above, maps, _) = ball(light(60.0, 0.0, 1.0), "relief");
    let (beside, _, _) = ball(light(0.0, 60.0, 1.0), "relief");
    close(above.irradiance.covariance[1].into(), beside.irradiance.covariance[0].into(), 1e-3);
    assert!(determination(&above, &maps) > 0.1);
}

/// Light from the side leaves half of the disc and a strip without light: `n_x < 0.05`.
#[test]
fn a_ball_under_a_side_light_is_half_unlit() {
    let (found, maps, score) = ball(light(0.0, 90.0, 1.0), "unlit");
    let u = f64::from(UNLIT);
    let strip = (u * (1.0 - u * u).sqrt() + u.asin()) / std::f64::consts::PI;
    close(found.unlit.into(), 0.5 + strip, 3e-3);
    assert_eq!(score, 1.0);
    let (found, _, score) = ball(light(0.0, 0.0, 1.0), "unlit");
    close(found.unlit.into(), u * u, 2e-3); // n_z < 0.05 outside the radius √(1 − 0.05²)
    close(score.into(), u * u / 0.25, 2e-2);
    let dim = ball(light(0.0, 0.0, 0.049), "unlit").0.unlit;
    assert_eq!(dim, 1.0);
    let mut irradiance = vec![1.0; maps.types.len()];
    irradiance[0] = 0.0; // the background does not count
    assert_eq!(appearance::unlit(&maps, &irradiance), 0.0);
    irradiance[maps.types.len() / 2] = 0.0;
    assert!(appearance::unlit(&maps, &irradiance) > 0.0);
}

/// A red strip of two of 64 columns, whose red burns out and whose luminance is far from it.
#[test]
fn one_channel_burns_a_plate() {
    let strip = |base: [f32; 4]| {
        let red = Material { base_color: base, ..matt(0.0) };
        let at = |x, z| DMat4::from_translation(DVec3::new(x, 0.0, z));
        let plate = (rectangle(1.0, 1.0), matt(0.5), DMat4::IDENTITY);
        let parts = vec![plate, (rectangle(1.0 / 32.0, 1.0), red, at(-31.0 / 32.0, 0.1))];
        measure(parts, (1.0, 64), light(0.0, 0.0, 1.2), "burnt")
    };
    let (found, maps, score) = strip([0.9, 0.1, 0.1, 1.0]);
    assert_eq!(maps.counts.object(), 64 * 64);
    close(found.burnt.into(), 2.0 / 64.0, 1e-6);
    close(score.into(), (2.0 / 64.0 - 0.005) / 0.1, 1e-5);
    assert!(found.histogram[28..].iter().all(|&count| count == 0), "the luminance is not white");
    // Planted: a red that the light just does not burn out.
    let (found, _, score) = strip([0.77, 0.1, 0.1, 1.0]);
    assert_eq!((found.burnt, score), (0.0, 0.0));
}

/// A map of `width`·`height` SURFACE pixels.
fn plain(width: u32, height: u32, normal: impl Fn(u32) -> Vec3) -> Maps {
    let n = width as usize * height as usize;
    let column = |at: usize| at as u32 % width;
    let normal = (0..n).map(|at| normal(column(at)).to_array()).collect();
    let surface = Surface { width, height, code: vec![1; n], normal, ..Surface::default() };
    let types = vec![PixelType::Surface; n];
    let (normal_gradient, normal_detail) = normal_detail::normal_detail(&surface, &types);
    let counts = PixelCounts { surface: n as u32, edge: 0 };
    Maps { surface, types, counts, normal_gradient, normal_detail, ..Maps::default() }
}

/// Sobel/8 of anything that changes by `s` a column is `s`, half of it in the first and the last column,
/// three quarters in the first and the last row and `(3, ±1)/8` in the corners.
const WEIGHT_OF_A_SLOPE: f64 = 62.0 * 8.0 + 8.0 + 62.0 * 2.0 * 0.75 + 4.0 * 3.162_277_66 / 8.0;

/// Sobel/8 of normals that turn by δ a column is `sin δ` long, whatever their direction.
#[test]
fn a_cylinder_has_the_detail_of_its_turn() {
    let turn = 0.04f32;
    let maps = plain(64, 10, |x| direction(0.0, turn * (x as f32 - 31.5)));
    for at in (0..640).filter(|at| (1..63).contains(&(at % 64)) && (1..9).contains(&(at / 64))) {
        close(maps.normal_gradient[at].into(), turn.sin().into(), 1e-6);
    }
    assert!(maps.normal_gradient[0] < 0.5 * turn.sin() && maps.normal_gradient[0] > 0.0);
    let still = plain(64, 10, |_| Vec3::Z);
    assert_eq!((still.normal_gradient, still.normal_detail), (vec![0.0; 640], 0.0));
}

#[test]
fn a_ramp_shows_the_share_of_the_detail_that_is_its_slope() {
    let mut maps = plain(64, 10, |_| Vec3::Z);
    let ramp = |slope: f32| (0..640).map(|at| slope * (at % 64) as f32).collect::<Vec<_>>();
    // All of the relief is 0.1 steep: 0.035 shows it.
    maps.normal_gradient = vec![0.1; 640];
    let half = gradient::detail(&maps, &ramp(0.0175));
    // Half of what is enough, times the weight of each pixel's taps.
    close(half.into(), 0.5 * WEIGHT_OF_A_SLOPE / 640.0, 1e-5);
    assert_eq!(gradient::detail(&maps, &ramp(1.0)), 1.0);
    // Flat places have no weight, steep ones 0.5 at most: 0.35 is enough where the relief is 1 steep.
    let slope = 0.007;
    maps.normal_gradient = (0..640).map(|at| if at % 64 < 32 { 0.0 } else { 1.0 }).collect();
    let steep = gradient::detail(&maps, &ramp(slope));
    close(steep.into(), f64::from(slope) / 0.35 * WEIGHT_OF_A_SLOPE / 640.0, 1e-5);
    let mut planted = ramp(slope);
    planted.iter_mut().skip(40).step_by(64).for_each(|i| *i += 0.1);
    assert!(gradient::detail(&maps, &planted) > 1.1 * steep);
    // Shallow relief is seen from 0.004 on.
    maps.normal_gradient = vec![1e-4; 640];
    close(gradient::detail(&maps, &ramp(0.002)).into(), 0.5 * WEIGHT_OF_A_SLOPE / 640.0, 1e-5);
    maps.normal_gradient = vec![0.0; 640];
    assert_eq!(gradient::detail(&maps, &ramp(0.5)), 0.0);
}

/// Half of the columns curve four times as much as the mean of one half: of them alone, a quarter is in each of four bins.
#[test]
fn the_entropy_is_that_of_the_places_that_curve() {
    let mut maps = plain(64, 10, |_| Vec3::Z);
    let curved = |at: usize| at % 64 >= 32;
    maps.normal_gradient = (0..640).map(|at| if curved(at) { 0.3 } else { 0.0 }).collect();
    maps.normal_detail = 0.15;
    let bin = |at: usize| if curved(at) { at % 4 } else { 4 + at % 28 };
    let mut picture: Vec<f32> = (0..640).map(|at| (bin(at) as f32 + 0.5) / 32.0).collect();
    let measured = |maps: &Maps, picture: &[f32]| {
        let statistics = fitness::statistics(maps, picture, &only("entropy"));
        f64::from(statistics.entropy)
    };
    close(measured(&maps, &picture), 4f64.ln(), 1e-6);
    let score = only("entropy")
        .quality(&fitness::statistics(&maps, &picture, &only("entropy")), &maps.statistics());
    close(score.score.into(), 0.6, 1e-6);
    // What does not curve counts for nothing, and what curves little counts little: 0.15 is a quarter of four times the
    // mean, 63 levels.
    picture[0] = 0.99;
    close(measured(&maps, &picture), 4f64.ln(), 1e-6);
    maps.normal_gradient.iter_mut().step_by(2).for_each(|gradient| *gradient /= 2.0);
    let (heavy, light) = (32.0 / 96.0, 16.0 / 96.0);
    let expected = -2.0 * (heavy * f64::ln(heavy) + light * f64::ln(light));
    close(measured(&maps, &picture), expected, 1e-6);
    assert!((expected - 4f64.ln()).abs() > 1e-2);
    assert_eq!(fitness::statistics(&maps, &picture, &only("hist")).entropy, 0.0);
    maps.normal_gradient = vec![0.0; 640];
    assert_eq!(measured(&maps, &picture), 0.0);
}

#[test]
fn the_residual_is_the_mean_square_of_what_the_target_tells() {
    let mut maps = plain(4, 1, |_| Vec3::Z);
    maps.types[3] = PixelType::Background;
    let picture = [0.5, 0.25, 1.0, 0.0];
    maps.set_target(vec![0.0, 0.75, -1.0, 0.9]).expect("a target");
    assert_eq!(maps.told(), 2);
    assert_eq!(appearance::residual(&maps, &picture), 0.25);
    let statistics = fitness::statistics(&maps, &picture, &only("target"));
    assert_eq!(only("target").quality(&statistics, &maps.statistics()).score, 0.625 / 0.75);
    // What the target does not tell, and the background, do not count; the others do.
    assert_eq!(appearance::residual(&maps, &[0.5, 0.25, 0.0, 1.0]), 0.25);
    assert_eq!(appearance::residual(&maps, &[0.0, 0.25, 1.0, 0.0]), 0.125);
    maps.target.clear();
    assert_eq!(appearance::residual(&maps, &picture), 0.0);
}

#[test]
fn the_outline_is_what_touches_the_background_within_the_picture() {
    // . b b b .   The object's rows meet the background at both ends; the picture's border is none.
    let mut maps = plain(5, 3, |_| Vec3::Z);
    for row in [0, 5, 10] {
        maps.types[row] = PixelType::Background;
        maps.types[row + 4] = PixelType::Background;
    }
    let outline: Vec<_> = (0..15).filter(|at| appearance::is_outline(&maps, *at)).collect();
    let touches = |at: &usize| [0, 1, 3, 4].contains(&(at % 5));
    assert!(outline.iter().copied().eq((0..15).filter(touches)), "{outline:?}");
    let mut picture = vec![0.9; 15];
    (picture[1], picture[6], picture[11]) = (0.5, 0.6, 0.4);
    // Distances 0, 0.1 and 0.1 on the left, 0.4 on the right: shares 1, 0.5, 0.5 and three times 0.
    close(appearance::outline(&maps, &picture, 0.5).into(), 2.0 / 6.0, 1e-6);
    // The middle column does not count.
    (picture[2], picture[7]) = (0.5, 0.5);
    close(appearance::outline(&maps, &picture, 0.5).into(), 2.0 / 6.0, 1e-6);
    picture[8] = 0.5;
    close(appearance::outline(&maps, &picture, 0.5).into(), 3.0 / 6.0, 1e-6);
    maps.types.fill(PixelType::Surface);
    assert_eq!(appearance::outline(&maps, &picture, 0.5), 0.0);
}

#[test]
fn the_first_key_light_has_a_direction() {
    let record = |role, kind, azimuth| Light { role, kind, ..light(45.0, azimuth, 1.0) }.record();
    let fill = record(Role::Fill, LightKind::DIRECTIONAL, 0.0);
    let point = record(Role::Key, LightKind::POINT, 180.0);
    let late = record(Role::Key, LightKind::DIRECTIONAL, 90.0);
    let found = Vec3::from(fitness::key(&[fill, point, late]));
    assert!(found.abs_diff_eq(Vec3::new(0.0, FRAC_1_SQRT_2, -FRAC_1_SQRT_2), 1e-6), "{found}");
    assert_eq!(fitness::key(&[fill]), [0.0; 3]);
}
