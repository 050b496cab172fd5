//! Scenes with every kind of surface: bent, mirrored, textured, bumpy, full of holes.

use glam::{DMat4, DVec3, Vec3};
use klieg::scene::view::{Camera, Projection, View};
use klieg::scene::{
    Instance, Material, Mesh, Scene, Texture, TextureLevel, TextureRef, Vertex, Wrap,
};

/// A camera at `eye` that looks at `target`.
pub fn camera(eye: DVec3, target: DVec3, projection: Projection, near: f64) -> Camera {
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let name = "test".into();
    Camera { name, eye, right, up, back, projection, near, far: None, designed: None }
}

/// The scene seen from its upper right front.
pub fn perspective(scene: &Scene, width: u32, height: u32) -> View {
    let lens = Projection::Perspective { yfov: 0.7 };
    let camera = camera(DVec3::new(1.7, 1.1, 3.9), DVec3::ZERO, lens, 0.05);
    View::new(scene, camera, width, height).unwrap()
}

/// A grid over [-1, 1]², bent by `bend`.
pub fn grid(cells: u32, material: u32, bend: impl Fn(f32, f32) -> Vec3) -> Mesh {
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

/// Bends a grid not at all.
pub fn flat(x: f32, y: f32) -> Vec3 {
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
pub fn scene(meshes: Vec<Mesh>, materials: Vec<Material>, placed: &[(u32, DMat4)]) -> Scene {
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
pub fn plain() -> Material {
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
pub fn quads() -> Scene {
    let meshes = vec![grid(1, 0, flat), grid(24, 0, ball)];
    let placed = [
        (0, turned(0.3, 0.2, -0.4, 0.7)),
        (1, DMat4::from_scale(DVec3::splat(0.6))),
        (0, turned(-0.5, -0.1, 0.2, -1.1) * DMat4::from_rotation_x(0.9)),
    ];
    scene(meshes, vec![plain()], &placed)
}

/// Single-sided spheres drawn with one call, some mirrored, one sheared, one flat.
pub fn instances() -> Scene {
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
pub fn textured(wrap: [Wrap; 2]) -> Scene {
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
pub fn normal_mapped() -> Scene {
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

/// Balls that are instances of one mesh, behind a card full of holes and over a sheet with two sides.
pub fn shadowed() -> Scene {
    let holes = Material { base_color_texture: uses(0, 1), alpha_cutoff: 0.5, ..plain() };
    let single = Material { double_sided: false, ..plain() };
    let meshes = vec![grid(6, 0, ball), grid(2, 1, flat), grid(1, 2, flat)];
    let at = |x: f64, y: f64, z: f64, scale: f64| {
        DMat4::from_translation(DVec3::new(x, y, z)) * DMat4::from_scale(DVec3::splat(scale))
    };
    let lying = DMat4::from_rotation_x(-1.4) * at(0.0, 0.0, -0.6, 1.0);
    let placed = [
        (0, at(-0.5, 0.0, 0.0, 0.35)),
        (0, at(0.4, -0.2, -0.3, -0.3)),
        (1, at(0.2, 0.5, 0.5, 0.4)),
        (2, lying),
    ];
    let mut scene = scene(meshes, vec![single, holes, plain()], &placed);
    scene.textures = vec![texture([Wrap::Mirror, Wrap::Clamp], true, true, [64, 64])];
    scene
}

/// A quad full of holes before another quad.
pub fn masked() -> Scene {
    let holes = Material { base_color_texture: uses(0, 1), alpha_cutoff: 0.5, ..plain() };
    let meshes = vec![grid(1, 0, flat), grid(4, 1, flat)];
    let placed = [(0, turned(0.0, 0.0, 0.3, 0.2)), (1, turned(0.1, 0.0, -0.4, -0.3))];
    let mut scene = scene(meshes, vec![holes, plain()], &placed);
    scene.textures = vec![texture([Wrap::Mirror, Wrap::Clamp], true, true, [64, 64])];
    scene
}
