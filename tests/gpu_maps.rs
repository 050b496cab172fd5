//! The device's maps of a view against the native evaluator's, for scenes built here and those of
//! `scenes/`.

use figures::{
    camera, flat, grid, instances, masked, normal_mapped, perspective, plain, quads, scene,
    textured,
};
use glam::{DMat4, DVec3};
use klieg::cpu;
use klieg::evaluate::Evaluator;
use klieg::gpu::{Context, GpuEvaluator};
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg::objective::maps::{Maps, Surface};
use klieg::scene::view::{Camera, Projection, View};
use klieg::scene::{Scene, Wrap};
use klieg_support::figures;
use klieg_support::gpu::context;
use std::sync::Arc;

/// Share of the object pixels that must show the same polygon.
const SAME_CODE: f64 = 0.999;
/// Share of those whose other values must lie within the tolerances: at a polygon's very border the
/// device extends it beyond its corners, the reference does not.
const CLOSE: f64 = 0.999;
/// The same where there are textures: at a polygon's border the two choose other mip levels, and
/// where a normal texture turns the surface edge-on it may be turned back to the viewer or not.
const CLOSE_TEXTURED: f64 = 0.995;
/// Devices interpolate between corners that are snapped to a grid of 1/256 pixel, the reference between
/// the true ones: tolerance of what is interpolated, in pixels. A pixel's step is that to its neighbours,
/// or a picture's height in pixels, as a picture is about as high as the values' range.
const SNAPPED: f32 = 6.0 / 256.0;
/// Filtered texels, and what a normal texture makes of them: devices filter 8-bit textures with
/// weights of 8 bits.
const TEXEL: f32 = 0.02;

/// The polygon's normal, which devices make of the positions' steps from pixel to pixel.
const FACE: f32 = 0.01;

fn drawn(context: &Arc<Context>, scene: &Scene, view: &View) -> Maps {
    let (objective, shading) = (Objective::default(), Shading::default());
    let mut evaluator = GpuEvaluator::new(context, scene, view, objective, shading).unwrap();
    evaluator.maps().unwrap().clone()
}

/// The largest difference of a pixel to the object pixels beside it.
fn step(surface: &Surface, i: usize, difference: impl Fn(usize, usize) -> f32) -> f32 {
    let (width, x) = (surface.width as usize, i % surface.width as usize);
    let beside = [
        (x > 0).then(|| i - 1),
        (x + 1 < width).then_some(i + 1),
        i.checked_sub(width),
        Some(i + width).filter(|&j| j < surface.code.len()),
    ];
    let objects = beside.into_iter().flatten().filter(|&j| surface.code[j] != 0);
    objects.map(|j| difference(i, j)).fold(0.0, f32::max)
}

/// How far two surfaces agree.
#[derive(Debug)]
struct Agreement {
    object_pixels: usize,
    /// Share of the pixels that are object in either where both show the same polygon.
    same_code: f64,
    /// Shares of those within the tolerance: length, normal, material, and the polygon's own normal.
    close: [f64; 4],
    /// What the shares must be.
    needed: f64,
}

impl Agreement {
    fn new(scene: &Scene, a: &Surface, b: &Surface) -> Self {
        let object = |i: &usize| a.code[*i] != 0 || b.code[*i] != 0;
        let pixels: Vec<usize> = (0..a.code.len()).filter(object).collect();
        let same: Vec<usize> = pixels.iter().copied().filter(|&i| a.code[i] == b.code[i]).collect();
        let scalar = |x: f32, y: f32| Some((x - y).abs()).filter(|d| !d.is_nan()).unwrap_or(1e9);
        let vector =
            |x: [f32; 3], y: [f32; 3]| (0..3).map(|k| scalar(x[k], y[k])).fold(0.0, f32::max);
        let differences = |i: usize| {
            let factors =
                scalar(a.metallic[i], b.metallic[i]).max(scalar(a.roughness[i], b.roughness[i]));
            let colors =
                vector(a.base_color[i], b.base_color[i]).max(vector(a.emissive[i], b.emissive[i]));
            [
                scalar(a.depth[i], b.depth[i]).max(vector(a.position[i], b.position[i])),
                vector(a.normal[i], b.normal[i]),
                colors.max(factors),
                vector(a.face[i], b.face[i]),
            ]
        };
        let least = 1.0 / a.height as f32;
        let snapped = |step: f32| 1e-5 + SNAPPED * step.max(least);
        let length = |i: usize, j: usize| {
            vector(b.position[i], b.position[j]).max(scalar(b.depth[i], b.depth[j]))
        };
        let normal = |i: usize, j: usize| vector(b.normal[i], b.normal[j]);
        let texel = TEXEL + snapped(least);
        let normal_mapped = scene.materials.iter().any(|m| m.normal_texture.is_some());
        let mut close = [0; 4];
        for &i in &same {
            let normal = if normal_mapped { texel } else { snapped(step(b, i, normal)) };
            let tolerances = [snapped(step(b, i, length)), normal, texel, FACE];
            let differences = differences(i);
            for k in 0..4 {
                close[k] += usize::from(differences[k] <= tolerances[k]);
            }
        }
        let share = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
        Self {
            object_pixels: pixels.len(),
            same_code: share(same.len(), pixels.len()),
            close: close.map(|close| share(close, same.len())),
            needed: if scene.textures.is_empty() { CLOSE } else { CLOSE_TEXTURED },
        }
    }

    fn holds(&self) -> bool {
        self.object_pixels > 0
            && self.same_code >= SAME_CODE
            && self.close.iter().all(|&share| share >= self.needed)
    }
}

/// Draws the scene on both sides and compares them.
fn compare(context: &Arc<Context>, name: &str, scene: &Scene, view: &View) -> (Maps, Surface) {
    let ours = drawn(context, scene, view);
    let reference = cpu::visibility::draw(scene, view);
    let agreement = Agreement::new(scene, &ours.surface, &reference);
    println!("{name} {}x{}: {agreement:?}", view.width, view.height);
    assert!(agreement.holds(), "{name} {}x{}: {agreement:?}", view.width, view.height);
    let messages = context.validation_messages();
    assert!(messages.is_empty(), "{name}: {}", messages.join("\n\n"));
    (ours, reference)
}

#[test]
fn scenes_built_here_look_the_same() {
    let context = context();
    let scenes = [
        ("quads", quads()),
        ("instances", instances()),
        ("repeated", textured([Wrap::Repeat, Wrap::Repeat])),
        ("mirrored", textured([Wrap::Mirror, Wrap::Clamp])),
        ("clamped", textured([Wrap::Clamp, Wrap::Mirror])),
        ("normal mapped", normal_mapped()),
        ("masked", masked()),
    ];
    for (name, scene) in &scenes {
        compare(&context, name, scene, &perspective(scene, 311, 203));
    }
}

#[test]
fn scene_files_look_the_same() {
    let context = context();
    for name in ["elephant", "pair", "still-life"] {
        let path = klieg_support::root().join(format!("scenes/{name}.glb"));
        let scene = klieg::scene::load::load(&path).unwrap();
        let view = View::new(&scene, scene.cameras[0].clone(), 320, 240).unwrap();
        compare(&context, name, &scene, &view);
    }
}

#[test]
fn odd_sizes_look_the_same() {
    let context = context();
    let scene = quads();
    for (width, height) in [(1, 1), (4096, 31), (17, 600)] {
        compare(&context, "quads", &scene, &perspective(&scene, width, height));
    }
}

#[test]
fn other_cameras_look_the_same() {
    let context = context();
    let scene = quads();
    let eye = DVec3::new(-2.0, 1.5, 3.0);
    let parallel = Projection::Orthographic { ymag: 1.4 };
    let view = |camera| View::new(&scene, camera, 257, 129).unwrap();
    let orthographic = view(camera(eye, DVec3::ZERO, parallel, 0.1));
    compare(&context, "orthographic", &scene, &orthographic);
    // From inside, so that polygons cross the near plane and lie behind the viewer.
    let wide = Projection::Perspective { yfov: 1.6 };
    let inside = camera(DVec3::new(0.4, 0.1, 0.6), DVec3::new(-0.3, 0.0, -0.2), wide, 0.3);
    compare(&context, "near plane", &scene, &view(inside.clone()));
    let far = Camera { far: Some(1.1), ..inside };
    compare(&context, "far plane", &scene, &view(far));
}

#[test]
fn the_first_of_two_equal_polygons_is_seen() {
    let context = context();
    let scene = scene(vec![grid(1, 0, flat)], vec![plain()], &[(0, DMat4::IDENTITY); 2]);
    let (maps, _) = compare(&context, "twice", &scene, &perspective(&scene, 64, 64));
    assert_eq!(maps.visible, [1, 2]);
}

#[test]
fn a_pixel_or_a_polygon_is_enough_to_differ() {
    let context = context();
    let scene = quads();
    let view = perspective(&scene, 64, 48);
    let (maps, reference) = compare(&context, "quads", &scene, &view);
    let object: Vec<usize> = (0..64 * 48).filter(|&i| reference.code[i] != 0).collect();
    assert!(object.len() < 1000, "one pixel is less than the share that may differ");
    let at = object[object.len() / 2];
    for spoil in [
        (|s: &mut Surface, at| s.code[at] += 1) as fn(&mut Surface, usize),
        |s, at| s.depth[at] += 0.01,
        |s, at| s.normal[at][0] += 0.01,
        |s, at| s.position[at][1] -= 0.01,
        |s, at| s.base_color[at][1] += 0.03,
        |s, at| s.roughness[at] = f32::NAN,
    ] {
        let mut planted = reference.clone();
        spoil(&mut planted, at);
        assert!(!Agreement::new(&scene, &maps.surface, &planted).holds());
    }
    let mut moved = scene.clone();
    moved.meshes[0].vertices[0].position[0] -= 0.2;
    let moved = cpu::visibility::draw(&moved, &view);
    assert!(!Agreement::new(&scene, &maps.surface, &moved).holds());
}

#[test]
fn the_maps_follow_from_the_surface() {
    let context = context();
    let scene = normal_mapped();
    let (ours, _) = compare(&context, "normal mapped", &scene, &perspective(&scene, 200, 150));
    let references = cpu::maps(ours.surface.clone(), &Objective::default());
    assert!(references.counts.edge > 0 && references.visible.len() > 50);
    assert_eq!((&ours.types, ours.counts), (&references.types, references.counts));
    assert_eq!(ours.visible, references.visible);
    assert!((ours.normal_detail - references.normal_detail).abs() <= 1e-5);
}

#[test]
fn scenes_that_do_not_fit_are_refused() {
    let context = context();
    let scene = quads();
    let view = perspective(&scene, 16, 16);
    let refused = |scene: &Scene, part: &str| {
        let (objective, shading) = (Objective::default(), Shading::default());
        let drawn = GpuEvaluator::new(&context, scene, &view, objective, shading).map(drop);
        let viewed = View::new(scene, view.camera.clone(), 16, 16).map(drop);
        for error in [drawn, viewed] {
            let error = error.expect_err(part);
            assert!(error.is_input() && error.to_string().contains(part), "{error}");
        }
    };
    let mut far = scene.clone();
    far.meshes[0].indices[2] = 1 << 30;
    refused(&far, "there is no vertex 1073741824");
    let mut other = scene.clone();
    other.meshes[0].material = 77;
    refused(&other, "there is no material 77");
    assert_eq!(context.validation_messages(), [""; 0]);
}
