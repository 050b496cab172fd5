//! klieg's BRDF of glTF against a viewer's: the picture of a lit scene in three.js, in headless Chromium.

#[path = "../examples/scenes/generator/mod.rs"]
#[allow(dead_code, reason = "the generator makes more than this scene")]
mod generator;

use generator::glb::{self, Glb};
use generator::mesh::sheet;
use glam::{DVec2, DVec3};
use image::{DynamicImage, RgbImage, RgbaImage};
use klieg::cpu;
use klieg::lighting::shading::{Brdf, Shading};
use klieg::lighting::{Color, Cone, Light, LightKind, Role};
use klieg::objective::Objective;
use klieg::objective::maps::{Maps, PixelType};
use klieg::scene::load::FileAccess;
use klieg::scene::view::View;
use klieg_support::three;
use serde_json::json;

const SIZE: u32 = 512;
/// Mean difference of an encoded channel from the specification that counts as agreement, of 0..1: half a
/// step of the eight bits.
const AGREEMENT: f64 = 0.5 / 255.0;

/// A point light, a directional one, and a coloured spot.
fn rig() -> Vec<Light> {
    let light = |elevation: f32, azimuth: f32, intensity: f32| Light {
        elevation: elevation.to_radians(),
        azimuth: azimuth.to_radians(),
        distance: 2.5,
        diffuse: intensity,
        specular: intensity,
        ..Light::default()
    };
    // three.js softens a cone's edge in its own way: here it is a few pixels wide.
    let cone = Cone { inner: 0.290, outer: 0.294 };
    let color = Color::of_linear([1.0, 0.6, 0.25]).unwrap();
    vec![
        light(35.0, -40.0, 0.8),
        Light { role: Role::Fill, kind: LightKind::DIRECTIONAL, ..light(10.0, 55.0, 0.3) },
        Light { role: Role::Rim, kind: LightKind::SPOT, cone, color, ..light(50.0, 20.0, 0.5) },
    ]
}

/// Spheres: from dielectrics below to metals above, rougher from left to right.
fn spheres() -> Vec<u8> {
    const METALLIC: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
    const ROUGHNESS: [f64; 5] = [0.05, 0.2875, 0.525, 0.7625, 1.0];
    let mut ball = sheet(64, 48, &|uv: DVec2| {
        let (around, polar) = (uv.x * std::f64::consts::TAU, uv.y * std::f64::consts::PI);
        let ring = polar.sin();
        DVec3::new(ring * around.sin(), -polar.cos(), ring * around.cos())
    });
    ball.uvs.clear();
    ball.tangents.clear();
    let mut glb = Glb::default();
    let (mut roots, mut points) = (Vec::new(), Vec::new());
    let places = (0..METALLIC.len()).flat_map(|row| (0..ROUGHNESS.len()).map(move |x| (row, x)));
    for (row, column) in places {
        let material = glb.add_material(json!({ "pbrMetallicRoughness": {
            "baseColorFactor": [0.9, 0.35, 0.08, 1.0],
            "metallicFactor": METALLIC[row], "roughnessFactor": ROUGHNESS[column] } }));
        let mesh = glb.add_mesh("sphere", &[(&ball, material)]);
        let place = DVec3::new(column as f64, row as f64, 0.0) * 2.2;
        points.extend(ball.points().map(|point| point + place));
        roots.push(glb.add_node(json!({ "mesh": mesh, "translation": place.to_array() })));
    }
    let view = glb::View { azimuth: 0.0, elevation: 0.0, yfov: 0.5, fill: 0.95 };
    roots.push(glb.add_camera("front", view, &points));
    glb.finish("spheres", &roots)
}

/// A scene's pictures by three.js, and what klieg's own takes.
struct Compared {
    maps: Maps,
    view: View,
    shipped: RgbaImage,
    specification: RgbaImage,
}

impl Compared {
    fn new(scene: &[u8]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (plain, lit) = (folder.path().join("plain.glb"), folder.path().join("lit.glb"));
        std::fs::write(&plain, scene).unwrap();
        let scene = klieg::scene::load::load(&plain).unwrap();
        let view = View::new(&scene, scene.cameras[0].clone(), SIZE, SIZE).unwrap();
        let maps = cpu::maps(cpu::visibility::draw(&scene, &view), &Objective::default());
        klieg::scene::lit::write(&plain, FileAccess::default(), &view, &rig(), &lit).unwrap();
        let pictures = three::render(&lit, SIZE, SIZE);
        let image = |png: &[u8]| image::load_from_memory(png).unwrap().into_rgba8();
        let (shipped, specification) = (image(&pictures.shipped), image(&pictures.specification));
        Self { maps, view, shipped, specification }
    }

    /// klieg's picture, without what no light gives.
    fn picture(&self, brdf: Brdf) -> RgbImage {
        let shading = Shading { brdf, ambient: 0.0, ..Shading::default() };
        let records: Vec<_> = rig().iter().map(Light::record).collect();
        cpu::population::color_picture(&self.maps, &self.view, &shading, &records, [0; 3])
    }

    /// Mean difference of the encoded channels, 0..1, over the object inside its outlines.
    fn difference(&self, picture: &RgbImage, other: &RgbaImage) -> f64 {
        let is_inside = |kind: &PixelType| *kind == PixelType::Surface;
        let pixels = picture.pixels().zip(other.pixels()).zip(&self.maps.types);
        let (mut sum, mut count) = (0, 0);
        for ((picture, other), _) in pixels.filter(|(_, kind)| is_inside(kind)) {
            let [rgb @ .., alpha] = other.0;
            if alpha == u8::MAX {
                let channels = picture.0.into_iter().zip(rgb);
                sum += channels.map(|(a, b)| u64::from(a.abs_diff(b))).sum::<u64>();
                count += 1;
            }
        }
        let inside = self.maps.types.iter().filter(|kind| is_inside(kind)).count();
        assert!(count > inside * 99 / 100, "three.js draws {count} of {inside} pixels");
        sum as f64 / (count * 3 * 255) as f64
    }

    /// Compares, and leaves the pictures in the tests' temporary folder: klieg's, that of the specification, and
    /// three.js' own.
    fn check(&self, name: &str, most: f64) {
        let gltf = self.picture(Brdf::Gltf);
        let mut all = RgbImage::new(3 * SIZE, SIZE);
        let rgb = |image: &RgbaImage| DynamicImage::from(image.clone()).into_rgb8();
        let pictures = [gltf.clone(), rgb(&self.specification), rgb(&self.shipped)];
        for (picture, x) in pictures.iter().zip((0..).step_by(SIZE as usize)) {
            image::imageops::replace(&mut all, picture, x, 0);
        }
        all.save(klieg_support::temporary().join(format!("three/{name}.png"))).unwrap();

        let specification = self.difference(&gltf, &self.specification);
        let shipped = self.difference(&gltf, &self.shipped);
        let scattering = self.difference(&self.picture(Brdf::GltfScattering), &self.shipped);
        let planted = self.difference(&self.picture(Brdf::BlinnPhong), &self.specification);
        println!(
            "{name}: {specification:.5} from the specification, {shipped:.5} from three.js; with multiple \
             scattering {scattering:.5} from three.js; Blinn-Phong: {planted:.5}"
        );
        assert!(scattering < shipped, "{name}: {scattering} {shipped}");
        assert!(specification < AGREEMENT && shipped < most, "{name}: {specification} {shipped}");
        assert!(planted > 10.0 * AGREEMENT, "{name}: Blinn-Phong passes with {planted}");
    }
}

#[test]
fn the_still_life_looks_as_in_three_js() {
    let scene = klieg_support::root().join("scenes/still-life.glb");
    Compared::new(&std::fs::read(scene).unwrap()).check("still-life", 0.01);
}

/// Rough metals are brighter in three.js, which adds what the specification leaves out.
#[test]
fn spheres_look_as_in_the_specification() {
    Compared::new(&spheres()).check("spheres", 0.02);
}
