//! The device's maps of a view against the native evaluator's, for scenes built here and those of
//! `scenes/`.

use glam::{DMat4, DVec3, Vec3};
use klieg::cpu;
use klieg::evaluate::Evaluator;
use klieg::gpu::{Context, ContextOptions, GpuEvaluator};
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg::objective::maps::{Maps, Surface};
use klieg::scene::view::{Camera, Projection, View};
use klieg::scene::{
    Instance, Material, Mesh, Scene, Texture, TextureLevel, TextureRef, Vertex, Wrap,
};
use std::path::Path;
use std::sync::Arc;

/// Share of the object pixels that must show the same polygon.
const SAME_CODE: f64 = 0.999;
/// Share of those whose other values must lie within the tolerances: at a polygon's very border the
/// device extends it beyond its corners, the twin does not.
const CLOSE: f64 = 0.999;
/// The same where there are textures: at a polygon's border the two choose other mip levels, and
/// where a normal texture turns the surface edge-on it may be turned back to the viewer or not.
const CLOSE_TEXTURED: f64 = 0.995;
/// Devices interpolate between corners that are snapped to a grid of 1/256 pixel, the twin between
/// the true ones: tolerance of what is interpolated, in picture heights, as a picture is about as
/// high as the values' range.
const SNAPPED: f32 = 6.0 / 256.0;
/// Filtered texels, and what a normal texture makes of them: devices filter 8-bit textures with
/// weights of 8 bits.
const TEXEL: f32 = 0.02;

fn context() -> Arc<Context> {
    let options = ContextOptions { validation: true, ..Default::default() };
    Context::new(&options).expect("a Vulkan device and the validation layer")
}

fn drawn(context: &Arc<Context>, scene: &Scene, view: &View) -> Maps {
    let (objective, shading) = (Objective::default(), Shading::default());
    let mut evaluator = GpuEvaluator::new(context, scene, view, objective, shading).unwrap();
    evaluator.maps().unwrap().clone()
}

/// How far two surfaces agree.
#[derive(Debug)]
struct Agreement {
    object_pixels: usize,
    /// Share of the pixels that are object in either where both show the same polygon.
    same_code: f64,
    /// Shares of those within the tolerance: length, normal, material.
    close: [f64; 3],
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
            ]
        };
        let snapped = 1e-5 + SNAPPED / a.height as f32;
        let texel = TEXEL + snapped;
        let normal_mapped = scene.materials.iter().any(|m| m.normal_texture.is_some());
        let tolerances = [snapped, if normal_mapped { texel } else { snapped }, texel];
        let mut close = [0; 3];
        for differences in same.iter().map(|&i| differences(i)) {
            for k in 0..3 {
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
    let twin = cpu::visibility::draw(scene, view);
    let agreement = Agreement::new(scene, &ours.surface, &twin);
    println!("{name} {}x{}: {agreement:?}", view.width, view.height);
    assert!(agreement.holds(), "{name} {}x{}: {agreement:?}", view.width, view.height);
    let messages = context.validation_messages();
    assert!(messages.is_empty(), "{name}: {}", messages.join("\n\n"));
    (ours, twin)
}

/// A camera at `eye` that looks at `target`.
fn camera(eye: DVec3, target: DVec3, projection: Projection, near: f64) -> Camera {
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let name = "test".into();
    Camera { name, eye, right, up, back, projection, near, far: None, designed: None }
}

fn perspective(scene: &Scene, width: u32, height: u32) -> View {
    let lens = Projection::Perspective { yfov: 0.7 };
    let camera = camera(DVec3::new(1.7, 1.1, 3.9), DVec3::ZERO, lens, 0.05);
    View::new(scene, camera, width, height).unwrap()
}

/// A grid over [-1, 1]², bent by `bend`.
fn grid(cells: u32, material: u32, bend: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let mut mesh = Mesh { name: "grid".into(), material, ..Mesh::default() };
    let side = cells + 1;
    let at = |k: u32| 2.0 * k as f32 / cells as f32 - 1.0;
    for k in 0..side * side {
        let (x, y) = (at(k % side), at(k / side));
        let (p, d) = (bend(x, y), 1e-3);
        let along_x = (bend(x + d, y) - bend(x - d, y)).normalize_or_zero();
        let along_y = (bend(x, y + d) - bend(x, y - d)).normalize_or_zero();
        let tangent = along_x.extend(1.0).to_array();
        mesh.vertices.push(Vertex {
            position: p.to_array(),
            normal: along_x.cross(along_y).normalize_or(Vec3::Z).to_array(),
            tangent,
            uv: [[1.5 * x, 1.5 * y], [0.5 * x + 0.5, 0.5 * y + 0.5]],
            color: [255, (k * 37 % 256) as u8, 200, 255],
        });
    }
    for y in 0..cells {
        for x in 0..cells {
            let a = y * side + x;
            mesh.indices.extend([a, a + 1, a + side, a + side, a + 1, a + side + 1]);
        }
    }
    mesh
}

fn flat(x: f32, y: f32) -> Vec3 {
    Vec3::new(x, y, 0.0)
}

fn ball(x: f32, y: f32) -> Vec3 {
    let (azimuth, elevation) = (3.0 * x, 1.5 * y);
    0.9 * Vec3::new(
        azimuth.sin() * elevation.cos(),
        elevation.sin(),
        azimuth.cos() * elevation.cos(),
    )
}

/// Places meshes; each entry of `placed` is a mesh and its transform.
fn scene(meshes: Vec<Mesh>, materials: Vec<Material>, placed: &[(u32, DMat4)]) -> Scene {
    let mut scene = Scene { meshes, materials, ..Scene::default() };
    for &(mesh, world) in placed {
        let first_polygon = scene.polygons() + 1;
        scene.instances.push(Instance { name: String::new(), mesh, world, first_polygon });
    }
    scene
}

/// A picture of coloured waves with its mip levels; alpha is a checkerboard where `holes`.
fn texture(wrap: [Wrap; 2], srgb: bool, holes: bool, size: [u32; 2]) -> Texture {
    let [mut width, mut height] = size;
    let wave = |k: u32, step: u32, n: u32| {
        (127.5 + 127.0 * (6.3 * (k * step) as f32 / n as f32).sin()) as u8
    };
    let texel = |i: u32| {
        let (x, y) = (i % width, i / width);
        let hole = holes && (x / 8 + y / 8) % 2 == 0;
        [wave(x, 1, width), wave(y, 2, height), wave(x + y, 1, width), if hole { 0 } else { 255 }]
    };
    let mut texels: Vec<[u8; 4]> = (0..width * height).map(texel).collect();
    let mut levels = Vec::new();
    loop {
        levels.push(TextureLevel { width, height, texels: texels.clone() });
        if (width, height) == (1, 1) {
            break;
        }
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let tap = |x: u32, y: u32| texels[(y.min(height - 1) * width + x.min(width - 1)) as usize];
        texels = (0..w * h)
            .map(|i| {
                let (x, y) = (2 * (i % w), 2 * (i / w));
                let taps = [tap(x, y), tap(x + 1, y), tap(x, y + 1), tap(x + 1, y + 1)];
                std::array::from_fn(|c| {
                    (taps.iter().map(|t| u32::from(t[c])).sum::<u32>() / 4) as u8
                })
            })
            .collect();
        (width, height) = (w, h);
    }
    Texture { name: "waves".into(), srgb, wrap, levels }
}

fn uses(texture: u32, uv_set: u32) -> Option<TextureRef> {
    let transform = [[0.9, 0.2, 0.1], [-0.2, 0.9, 0.3]];
    Some(TextureRef { texture, uv_set, transform })
}

/// Matt and unpolished, seen from both sides.
fn plain() -> Material {
    Material {
        base_color: [0.8, 0.5, 0.3, 1.0],
        metallic: 0.25,
        roughness: 0.6,
        double_sided: true,
        ..Material::default()
    }
}

fn turned(x: f64, y: f64, z: f64, angle: f64) -> DMat4 {
    DMat4::from_translation(DVec3::new(x, y, z)) * DMat4::from_rotation_y(angle)
}

/// Overlapping quads at odd angles round a sphere.
fn quads() -> Scene {
    let meshes = vec![grid(1, 0, flat), grid(24, 0, ball)];
    let placed = [
        (0, turned(0.3, 0.2, -0.4, 0.7)),
        (1, DMat4::from_scale(DVec3::splat(0.6))),
        (0, turned(-0.5, -0.1, 0.2, -1.1) * DMat4::from_rotation_x(0.9)),
    ];
    scene(meshes, vec![plain()], &placed)
}

/// Single-sided spheres drawn with one call, some mirrored, one sheared, one flat.
fn instances() -> Scene {
    let material = Material { double_sided: false, ..plain() };
    let ball = grid(20, 0, ball);
    let at = |x: f64, y: f64, scale: DVec3| {
        (0, DMat4::from_translation(DVec3::new(x, y, 0.0)) * DMat4::from_scale(0.4 * scale))
    };
    let mut placed = vec![
        at(-0.8, 0.5, DVec3::ONE),
        at(0.0, 0.5, DVec3::new(-1.0, 1.0, 1.0)),
        at(0.8, 0.5, DVec3::new(1.0, 2.0, 0.5)),
        at(-0.8, -0.5, DVec3::splat(-1.0)),
        at(0.0, -0.5, DVec3::new(1.0, 1.0, 0.0)),
    ];
    let shear = DMat4::from_cols_array_2d(&[
        [0.3, 0.2, 0.0, 0.0],
        [0.0, 0.4, 0.1, 0.0],
        [0.2, 0.0, 0.3, 0.0],
        [0.8, -0.5, 0.0, 1.0],
    ]);
    placed.push((0, shear));
    scene(vec![ball], vec![material], &placed)
}

/// A sphere and a quad with every kind of texture, and with this wrap.
fn textured(wrap: [Wrap; 2]) -> Scene {
    let material = Material {
        base_color_texture: uses(0, 0),
        metallic_roughness_texture: uses(1, 1),
        emissive_texture: uses(0, 1),
        emissive: [0.5, 0.2, 0.1],
        ..plain()
    };
    let meshes = vec![grid(16, 0, ball), grid(1, 0, flat)];
    let mut scene = scene(
        meshes,
        vec![material],
        &[(0, DMat4::from_scale(DVec3::splat(0.7))), (1, turned(0.0, 0.0, -0.5, 0.5))],
    );
    scene.textures = vec![
        texture(wrap, true, false, [64, 48]),
        texture([wrap[1], wrap[0]], false, false, [33, 17]),
    ];
    scene
}

/// The same with a normal texture of shallow waves.
fn normal_mapped() -> Scene {
    let mut scene = textured([Wrap::Repeat; 2]);
    let mut waves = texture([Wrap::Repeat; 2], false, false, [48, 48]);
    for [x, y, z, _] in waves.levels.iter_mut().flat_map(|level| &mut level.texels) {
        (*x, *y, *z) = (64 + *x / 2, 64 + *y / 2, 220);
    }
    scene.textures.push(waves);
    scene.materials[0].normal_texture = uses(2, 0);
    scene.materials[0].normal_scale = 0.7;
    scene
}

/// A quad full of holes before another quad.
fn masked() -> Scene {
    let holes = Material { base_color_texture: uses(0, 1), alpha_cutoff: 0.5, ..plain() };
    let meshes = vec![grid(1, 0, flat), grid(4, 1, flat)];
    let placed = [(0, turned(0.0, 0.0, 0.3, 0.2)), (1, turned(0.1, 0.0, -0.4, -0.3))];
    let mut scene = scene(meshes, vec![holes, plain()], &placed);
    scene.textures = vec![texture([Wrap::Mirror, Wrap::Clamp], true, true, [64, 64])];
    scene
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
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.glb"));
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
    let (maps, twin) = compare(&context, "quads", &scene, &view);
    let object: Vec<usize> = (0..64 * 48).filter(|&i| twin.code[i] != 0).collect();
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
        let mut planted = twin.clone();
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
    let twins = cpu::maps(ours.surface.clone(), &Objective::default());
    assert!(twins.counts.edge > 0 && twins.visible.len() > 50);
    assert_eq!((&ours.types, ours.counts), (&twins.types, twins.counts));
    assert_eq!(ours.visible, twins.visible);
    assert!((ours.normal_detail - twins.normal_detail).abs() <= 1e-5);
}
