//! The maps of a view in smaller pictures, of the pixels that are there: nothing is drawn and no shadow is looked for.

use super::maps;
use crate::objective::Objective;
use crate::objective::maps::{Maps, Surface};
use crate::scene::view::View;

/// The maps of [`View::subsampled`]: the middle one of `step` pixels along both sides, with the thresholds of `objective`.
/// A target picture is left out.
///
/// # Panics
/// For a step of 0, and unless the maps are of the view's size.
pub fn subsampled(whole: &Maps, view: &View, step: u32, objective: &Objective) -> Maps {
    let surface = &whole.surface;
    let View { width, height, .. } = view.subsampled(step);
    let along = |at: u32, side: u32| (at * step + step / 2).min(side - 1);
    let place = |[x, y]: [u32; 2]| {
        let (x, y) = (along(x, surface.width), along(y, surface.height));
        y as usize * surface.width as usize + x as usize
    };
    let places: Vec<usize> =
        (0..height).flat_map(|y| (0..width).map(move |x| place([x, y]))).collect();
    let mut small = maps(
        Surface {
            width,
            height,
            code: taken(&surface.code, &places),
            depth: taken(&surface.depth, &places),
            position: taken(&surface.position, &places),
            normal: taken(&surface.normal, &places),
            face: taken(&surface.face, &places),
            base_color: taken(&surface.base_color, &places),
            metallic: taken(&surface.metallic, &places),
            roughness: taken(&surface.roughness, &places),
            emissive: taken(&surface.emissive, &places),
        },
        objective,
    );
    let pixels: Vec<_> = places.into_iter().map(Some).collect();
    small.shadows = whole.shadows.as_ref().map(|shadows| shadows.of_pixels(&pixels));
    small
}

fn taken<T: Copy>(map: &[T], places: &[usize]) -> Vec<T> {
    places.iter().map(|&at| map[at]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu;
    use crate::objective::shadows::ShadowSettings;
    use crate::scene::load;
    use std::path::Path;

    #[test]
    fn pixels_are_those_of_the_whole_picture() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/still-life.glb");
        let scene = load::load(&path).unwrap();
        let view = View::new(&scene, scene.cameras[0].clone(), 92, 61).unwrap();
        let shadows = ShadowSettings { on: true, side: 7, ..ShadowSettings::default() };
        let objective = Objective::default();
        let whole = cpu::draw(&scene, &view, &objective, (&shadows, None)).unwrap();
        let small = subsampled(&whole, &view, 3, &objective);
        small.check().unwrap();
        assert_eq!([small.surface.width, small.surface.height], [30, 20]);
        let (old, new) = (whole.shadows.as_ref().unwrap(), small.shadows.as_ref().unwrap());
        let mut objects = 0;
        for at in 0..small.types.len() {
            let from = (at / 30 * 3 + 1) * 92 + at % 30 * 3 + 1;
            assert_eq!(small.surface.code[at], whole.surface.code[from]);
            assert_eq!(small.surface.normal[at], whole.surface.normal[from]);
            assert_eq!(small.surface.base_color[at], whole.surface.base_color[from]);
            assert_eq!(new.number(at).is_some(), old.number(from).is_some());
            if let (Some(number), Some(before)) = (new.number(at), old.number(from)) {
                objects += 1;
                assert_eq!(new.word(number, 3), old.word(before, 3));
                assert_eq!(new.openness()[number], old.openness()[before]);
            }
        }
        assert!(objects > 100, "{objects}");
        let plain = Maps { shadows: None, ..whole.clone() };
        assert_eq!(subsampled(&plain, &view, 3, &objective).shadows, None);
    }

    #[test]
    fn a_step_of_one_is_the_whole_picture_and_a_long_one_leaves_a_pixel() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/still-life.glb");
        let scene = load::load(&path).unwrap();
        let view = View::new(&scene, scene.cameras[0].clone(), 60, 40).unwrap();
        let objective = Objective::default();
        let whole =
            cpu::draw(&scene, &view, &objective, (&ShadowSettings::default(), None)).unwrap();
        assert_eq!(subsampled(&whole, &view, 1, &objective), whole);
        let one = subsampled(&whole, &view, 100, &objective);
        assert_eq!((one.types.len(), one.surface.code[0]), (1, whole.surface.code[39 * 60 + 50]));
    }
}
