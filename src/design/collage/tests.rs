use super::*;
use crate::cpu;
use crate::math::color::srgb_decode;
use crate::objective::Objective;
use crate::objective::maps::{PixelCounts, Surface};
use crate::objective::shadows::ShadowSettings;
use crate::scene::framing::{Framing, frame};
use crate::scene::load::load;
use std::path::Path;

/// The elephant, so many pixels wide.
fn elephant(side: u32) -> (Maps, View) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/elephant.glb");
    let scene = load(&path).unwrap();
    let view =
        View::new(&scene, frame(&scene, &Framing::default(), 1.0).unwrap(), side, side).unwrap();
    let off = ShadowSettings { on: false, ..ShadowSettings::default() };
    (cpu::draw(&scene, &view, &Objective::default(), (&off, None)).unwrap(), view)
}

/// Maps of `width`·`height` SURFACE pixels that all look to the viewer.
fn plate(width: u32, height: u32) -> Maps {
    let n = (width * height) as usize;
    let surface = Surface {
        width,
        height,
        code: vec![1; n],
        depth: vec![1.0; n],
        position: vec![[0.0; 3]; n],
        normal: vec![[0.0, 0.0, 1.0]; n],
        face: vec![[0.0, 0.0, 1.0]; n],
        base_color: vec![[0.5; 3]; n],
        metallic: vec![0.0; n],
        roughness: vec![0.5; n],
        emissive: vec![[0.0; 3]; n],
    };
    let types = vec![PixelType::Surface; n];
    let counts = PixelCounts { surface: n as u32, edge: 0 };
    Maps {
        surface,
        types,
        counts,
        normal_detail: 0.1,
        normal_gradient: vec![0.0; n],
        ..Maps::default()
    }
}

#[test]
fn patches_end_at_creases_and_shallow_ones_do_not() {
    let (width, height) = (40, 20);
    let mut maps = plate(width, height);
    let of = |curvature: &dyn Fn(u32) -> f32, maps: &Maps| {
        let curvature: Vec<f32> = (0..width * height).map(|at| curvature(at % width)).collect();
        patches(maps, &curvature)
    };
    let crease = |x: u32| if x == 20 { 0.9 } else { 0.01 * (x % 3) as f32 };
    let (labels, count) = of(&crease, &maps);
    assert_eq!(count, 2);
    let at = |x: u32, y: u32| labels[(y * width + x) as usize];
    assert!((0..20).all(|y| at(0, y) == at(19, y) && at(21, y) == at(39, y)));
    assert_ne!(at(0, 5), at(39, 5));
    assert_eq!(of(&|x| 0.05 * crease(x), &maps).1, 1);
    // The background parts what it lies between, and belongs to nobody.
    (0..20).for_each(|y| maps.types[y * 40 + 20] = PixelType::Background);
    let (labels, count) = of(&|_| 0.1, &maps);
    assert_eq!((count, labels[20]), (2, NONE));
    assert_ne!(labels[0], labels[39]);
}

#[test]
fn a_patch_is_lit_where_it_curves() {
    let (mut maps, (_, view)) = (plate(20, 20), elephant(20));
    // The right half curves, and looks up.
    let up = Vec3::new(0.0, 0.8, 0.6).to_array();
    let right = |at: &usize| at % 20 >= 10;
    (0..400).filter(right).for_each(|at| maps.surface.normal[at] = up);
    let curvature: Vec<f32> = (0..400).map(|at| if right(&at) { 0.8 } else { 0.1 }).collect();
    let light = |curvature: &[f32]| lights(&maps, &view, (&[0; 400], 1), curvature)[0];
    assert!(light(&curvature).dot(up.into()) > 0.8, "{}", light(&curvature));
    let turned: Vec<f32> = curvature.iter().map(|curved| 0.9 - curved).collect();
    assert!(light(&turned).dot(Vec3::Z) > light(&curvature).dot(Vec3::Z));
}

#[test]
fn the_collage_has_the_brightness_that_is_wanted() {
    let (maps, view) = elephant(96);
    let shading = Shading::default();
    for wanted in [0.3, 0.5] {
        let made = Collage::new((&maps, &view, &shading), wanted);
        assert_eq!((made.picture.width, made.picture.texels.len()), (48, 48 * 48));
        let covered = made.picture.texels.iter().filter(|texel| texel[3] == u8::MAX);
        let bright = |[r, g, b, _]: &[u8; 4]| {
            let linear = [*r, *g, *b].map(|byte| srgb_decode(f32::from(byte) / 255.0));
            srgb_encode(luminance(linear.into()))
        };
        let values: Vec<f32> = covered.map(bright).collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        assert!((mean - wanted).abs() < 0.05, "{mean} {wanted}");
        assert!(made.patches > 10 && made.picture.texels[0][3] == 0, "{}", made.patches);
    }
}
