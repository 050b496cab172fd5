//! The maps of some of a view's objects.

use super::{normal_detail, set_background_depth, shape, visible};
use crate::objective::maps::{Maps, PixelCounts, PixelType};

/// The maps of the objects whose colour codes are to be kept: all else is background, but casts its shadows, and
/// edges are where they were in the whole view.
pub fn of_objects(maps: &Maps, keep: impl Fn(u32) -> bool) -> Maps {
    let mut part = maps.clone();
    let surface = &mut part.surface;
    let kept: Vec<bool> = surface.code.iter().map(|&code| code != 0 && keep(code)).collect();
    for at in (0..kept.len()).filter(|&at| !kept[at]) {
        surface.code[at] = 0;
        surface.position[at] = [0.0; 3];
        surface.normal[at] = [0.0; 3];
        surface.face[at] = [0.0; 3];
        surface.base_color[at] = [0.0; 3];
        surface.emissive[at] = [0.0; 3];
        surface.metallic[at] = 0.0;
        surface.roughness[at] = 0.0;
        part.types[at] = PixelType::Background;
    }
    set_background_depth(surface);
    part.counts = PixelCounts::of(&part.types);
    part.visible = visible::visible(&part.surface.code);
    (part.normal_gradient, part.normal_detail) =
        normal_detail::normal_detail(&part.surface, &part.types);
    part.shape = shape::shape(&part.surface, &part.types, &part.normal_gradient);
    let kept: Vec<_> = kept.iter().enumerate().map(|(at, &kept)| kept.then_some(at)).collect();
    part.shadows = maps.shadows.as_ref().map(|shadows| shadows.of_pixels(&kept));
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cpu;
    use crate::objective::Objective;
    use crate::objective::shadows::ShadowSettings;
    use crate::scene::{load, view::View};
    use std::path::Path;

    #[test]
    fn what_is_left_out_is_background_and_all_else_stays() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/still-life.glb");
        let scene = load::load(&path).unwrap();
        let view = View::new(&scene, scene.cameras[0].clone(), 60, 40).unwrap();
        let shadows = ShadowSettings { on: true, side: 7, ..ShadowSettings::default() };
        let whole = cpu::draw(&scene, &view, &Objective::default(), (&shadows, None)).unwrap();
        let range = scene.polygon_range(&scene.instances[1]);
        let part = of_objects(&whole, |code| range.contains(&code));
        part.check().unwrap();
        assert!(part.counts.object() > 20 && part.counts.object() < whole.counts.object() / 2);
        let (old, new) = (whole.shadows.as_ref().unwrap(), part.shadows.as_ref().unwrap());
        for at in 0..part.types.len() {
            let kept = range.contains(&whole.surface.code[at]);
            assert_eq!(part.types[at], if kept { whole.types[at] } else { PixelType::Background });
            assert_eq!(new.number(at).is_some(), kept);
            if let (true, Some(number), Some(before)) = (kept, new.number(at), old.number(at)) {
                assert_eq!(new.word(number, 1), old.word(before, 1));
                assert_eq!(new.openness()[number], old.openness()[before]);
                assert_eq!(part.surface.position[at], whole.surface.position[at]);
            }
        }
        assert_eq!(of_objects(&whole, |_| true), whole);
        assert_eq!(of_objects(&whole, |_| false).counts.object(), 0);
    }
}
