//! Colours of a surface under lights that profile `natural` finds: data that is painted on it can be read.

use glam::{DMat3, DMat4, DVec3, Vec3};
use klieg::cpu::{self, CpuEvaluator, population, visibility};
use klieg::design::profile::NATURAL;
use klieg::design::{self, start};
use klieg::lighting::{LightRecord, Population};
use klieg::math::color::{luminance, srgb_decode, srgb_encode};
use klieg::objective::maps::Maps;
use klieg::objective::shadows::ShadowSettings;
use klieg::objective::{Objective, Term, UNLIT};
use klieg::optimize::{self, GeneticSettings, Settings, Setup, genetic};
use klieg::scene::occluders::Occluders;
use klieg::scene::view::View;
use klieg::scene::{Material, Mesh};
use klieg_support::shapes::{orthographic, scene, vertex};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Mean CIEDE2000 that colours may be off; side by side, about 2 is the least that people see at a glance.
const MOST: f64 = 3.0;

/// Colour difference of two CIELAB colours: CIEDE2000 by the formulas (2) to (22) of Sharma, Wu and Dalal
/// (2005), *The CIEDE2000 color-difference formula: implementation notes, supplementary test data, and
/// mathematical observations*.
fn ciede2000(one: DVec3, other: DVec3) -> f64 {
    let power = |c: f64| (c.powi(7) / (c.powi(7) + 25f64.powi(7))).sqrt();
    let mean_c = 0.5 * (one.y.hypot(one.z) + other.y.hypot(other.z));
    let g = 0.5 * (1.0 - power(mean_c));
    // Lightness, chroma and hue in degrees.
    let lch = |lab: DVec3| {
        let a = (1.0 + g) * lab.y;
        (lab.x, a.hypot(lab.z), lab.z.atan2(a).to_degrees().rem_euclid(360.0))
    };
    let ((l1, c1, h1), (l2, c2, h2)) = (lch(one), lch(other));
    let grey = c1 * c2 == 0.0;
    let turn = match h2 - h1 {
        _ if grey => 0.0,
        turn if turn > 180.0 => turn - 360.0,
        turn if turn < -180.0 => turn + 360.0,
        turn => turn,
    };
    let hue = match 0.5 * (h1 + h2) {
        _ if grey => h1 + h2,
        hue if (h1 - h2).abs() <= 180.0 => hue,
        hue if hue < 180.0 => hue + 180.0,
        hue => hue - 180.0,
    };
    let (l, c) = (0.5 * (l1 + l2), 0.5 * (c1 + c2));
    let cos = |degrees: f64| degrees.to_radians().cos();
    let t = 1.0 - 0.17 * cos(hue - 30.0) + 0.24 * cos(2.0 * hue) + 0.32 * cos(3.0 * hue + 6.0)
        - 0.2 * cos(4.0 * hue - 63.0);
    let off = (l - 50.0).powi(2);
    let s_l = 1.0 + 0.015 * off / (20.0 + off).sqrt();
    let (s_c, s_h) = (1.0 + 0.045 * c, 1.0 + 0.015 * c * t);
    let angle = 30.0 * (-((hue - 275.0) / 25.0).powi(2)).exp();
    let r_t = -2.0 * power(c) * (2.0 * angle).to_radians().sin();
    let (dl, dc) = ((l2 - l1) / s_l, (c2 - c1) / s_c);
    let dh = 2.0 * (c1 * c2).sqrt() * (0.5 * turn).to_radians().sin() / s_h;
    (dl * dl + dc * dc + dh * dh + r_t * dc * dh).sqrt()
}

/// CIELAB under D65 of linear sRGB (IEC 61966-2-1).
fn lab(linear: Vec3) -> DVec3 {
    let xyz_from_rgb = DMat3::from_cols_array(&[
        0.4124564, 0.2126729, 0.0193339, 0.3575761, 0.7151522, 0.1191920, 0.1804375, 0.0721750,
        0.9503041,
    ]);
    let relative = (xyz_from_rgb * linear.as_dvec3()) / (xyz_from_rgb * DVec3::ONE);
    let [x, y, z] = relative.to_array().map(|t| match t > (6.0f64 / 29.0).powi(3) {
        true => t.cbrt(),
        false => t / (3.0 * (6.0f64 / 29.0).powi(2)) + 4.0 / 29.0,
    });
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Linear colour of viridis (Smith and van der Walt 2015) at 0..1, between nine of its colours.
fn viridis(at: f32) -> Vec3 {
    const COLORS: [u32; 9] =
        [0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725];
    let place = at.clamp(0.0, 1.0) * 8.0;
    let first = (place as usize).min(7);
    let color =
        |code: u32| Vec3::from([16, 8, 0].map(|shift| (code >> shift & 255) as f32 / 255.0));
    let encoded = color(COLORS[first]).lerp(color(COLORS[first + 1]), place - first as f32);
    Vec3::from(encoded.to_array().map(srgb_decode))
}

/// Waves over -1..1, whose heights are told by colour.
fn surface() -> Mesh {
    const SIDE: u32 = 96;
    let height = |x: f32, y: f32| 0.25 * (4.0 * x + 1.0).sin() * (3.0 * y).cos();
    let mut mesh = Mesh::default();
    for at in 0..SIDE * SIDE {
        let [x, y] = [at % SIDE, at / SIDE].map(|c| 2.0 * c as f32 / (SIDE - 1) as f32 - 1.0);
        let slope_x = 4.0 * 0.25 * (4.0 * x + 1.0).cos() * (3.0 * y).cos();
        let slope_y = -3.0 * 0.25 * (4.0 * x + 1.0).sin() * (3.0 * y).sin();
        let normal = Vec3::new(-slope_x, -slope_y, 1.0).normalize();
        let mut corner = vertex(Vec3::new(x, y, height(x, y)), normal, [0.0; 2]);
        let color = viridis(0.5 + 2.0 * height(x, y));
        corner.color =
            (255.0 * color).round().extend(255.0).to_array().map(|channel| channel as u8);
        mesh.vertices.push(corner);
        if at % SIDE > 0 && at / SIDE > 0 {
            let [a, b, c, d] = [at - SIDE - 1, at - SIDE, at, at - 1];
            mesh.indices.extend([a, b, c, a, c, d]);
        }
    }
    mesh
}

/// The surface as it is judged, with shadows.
fn seen() -> (Maps, View) {
    let material = Material { metallic: 0.0, roughness: 0.5, ..Material::default() };
    let scene = scene([(surface(), material, DMat4::IDENTITY)]);
    let view = orthographic(&scene, 1.1, 96, 96);
    let mut maps = cpu::maps(visibility::draw(&scene, &view), &(NATURAL.objective)());
    let occluders = Arc::new(Occluders::new(&scene, &view).expect("triangles"));
    let settings = ShadowSettings { on: true, side: 15, ..ShadowSettings::default() };
    maps.shadows = Some(cpu::shadows::table(&maps.surface, occluders, &settings));
    (maps, view)
}

/// The lights that a short search finds.
fn designed(maps: &Maps, view: &View, objective: Objective) -> Population {
    let genome = NATURAL.genome().expect("the profile's lights");
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let first = start::first_of_surface(maps, &genome, &mut rng);
    let genetic = GeneticSettings { population: 24, generations: 12, ..GeneticSettings::default() };
    let settings = Settings { genetic, ..Settings::default() };
    let setup = Setup { bounds: genome.bounds(), first, settings: &settings, rng };
    let mut search = optimize::create(genetic::NAME, setup).expect("settings in range");
    let mut evaluator = CpuEvaluator::new(maps.clone(), view, objective, (NATURAL.shading)())
        .expect("maps that fit");
    let observe = &mut |_: &_| ControlFlow::Continue(());
    let found = design::run(&mut *search, &genome, &mut evaluator, observe).expect("lights");
    Population::of([&found.rig[..]]).expect("a rig")
}

/// Mean CIEDE2000 over what is lit between the picture's colours and the surface's own at their luminances.
fn difference(maps: &Maps, view: &View, rig: &[LightRecord]) -> f64 {
    let shading = (NATURAL.shading)();
    let picture = population::color_picture(maps, view, &shading, rig, [0; 3]);
    let irradiance = population::irradiance(maps, view, &shading, rig);
    let lit = (0..maps.types.len())
        .filter(|&at| maps.surface.code[at] != 0 && irradiance[at] >= srgb_encode(UNLIT));
    let pixels: Vec<_> = picture.pixels().collect();
    let differences: Vec<f64> = lit
        .map(|at| {
            let shown = Vec3::from(pixels[at].0.map(|c| srgb_decode(f32::from(c) / 255.0)));
            let own = Vec3::from(maps.surface.base_color[at]);
            ciede2000(lab(shown), lab(own * (luminance(shown) / luminance(own))))
        })
        .collect();
    assert!(differences.len() * 2 > maps.counts.object() as usize, "most of the surface is lit");
    differences.iter().sum::<f64>() / differences.len() as f64
}

#[test]
fn colours_survive_the_lights_that_natural_finds() {
    let (maps, view) = seen();
    let objective = (NATURAL.objective)();
    let found = difference(&maps, &view, designed(&maps, &view, objective).records());
    // Planted: nothing is said against burnt-out places, and every light is two stops too bright.
    let mut careless = objective;
    careless.weights.set(Term::named("burnt").expect("a term"), 0.0).expect("room");
    let planted = designed(&maps, &view, careless);
    let brighter = planted.records().iter().map(|light| LightRecord {
        diffuse: 4.0 * light.diffuse,
        specular: 4.0 * light.specular,
        ..*light
    });
    let brighter: Vec<_> = brighter.collect();
    let burnt = difference(&maps, &view, &brighter);
    println!("mean CIEDE2000 at equal luminance: {found:.2}, without care {burnt:.2}");
    assert!(found < MOST, "{found}");
    assert!(burnt > MOST, "the planted fault passes: {burnt}");
}

/// Of the supplementary test data of Sharma, Wu and Dalal (2005), by their numbers there.
#[test]
fn differences_are_the_published_ones() {
    for (number, one, other, expected) in [
        (1, [50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        (4, [50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0),
        (7, [50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
        (9, [50.0, 2.49, -0.001], [50.0, -2.49, 0.0009], 7.1792),
        (11, [50.0, 2.49, -0.001], [50.0, -2.49, 0.0011], 7.2195),
        (13, [50.0, -0.001, 2.49], [50.0, 0.0009, -2.49], 4.8045),
        (17, [50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        (18, [50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
        (25, [60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
        (34, [2.0776, 0.0795, -1.135], [0.9033, -0.0636, -0.5514], 0.9082),
    ] {
        let (one, other) = (DVec3::from(one), DVec3::from(other));
        for found in [ciede2000(one, other), ciede2000(other, one)] {
            assert!((found - expected).abs() < 1e-4, "pair {number}: {found}, not {expected}");
        }
    }
}
