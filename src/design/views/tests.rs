use super::*;
use crate::design::focus::FOCUS_SHARE;
use crate::design::testing::{Hills, genome, height};
use crate::design::{Dimmed, Focused};
use crate::evaluate::Pending;
use crate::lighting::LightKind;
use crate::math::range::Range;
use glam::DVec3;
use std::cell::RefCell;
use std::rc::Rc;

/// A frame that looks from an azimuth, at a place.
fn frame(azimuth: f64, center: DVec3, radius: f64) -> Frame {
    let (sin, cos) = azimuth.sin_cos();
    let (right, back) = (DVec3::new(cos, 0.0, -sin), DVec3::new(sin, 0.0, cos));
    Frame { center, radius, right, up: DVec3::Y, back }
}

fn views(stand: Stand, over: Over, fixed: usize) -> (Views<Box<dyn Evaluator>>, Vec<Frame>) {
    let frames = [0.0, 1.0, 2.5].map(|azimuth| frame(azimuth, DVec3::ONE, 2.0));
    let one = |frame: Frame| (Box::new(Hills::default()) as Box<dyn Evaluator>, frame);
    let views = Views::new(frames.map(one).into(), stand, over, fixed).unwrap();
    (views, frames.to_vec())
}

/// Two rigs of two lights.
fn rigs() -> Vec<Vec<Light>> {
    let genome = genome();
    let at = |share: f32| genome.bounds().iter().map(|range: &Range| range.at(share)).collect();
    [0.3, 0.8].map(|share| genome.decode(&Vec::from_iter::<Vec<f32>>(at(share)))).into()
}

fn scores(views: &mut Views<Box<dyn Evaluator>>) -> Vec<f32> {
    let rigs = rigs();
    let mut scores = vec![0.0; rigs.len()];
    let population = Population::of(rigs.iter().map(Vec::as_slice)).unwrap();
    views.evaluate(&population, &mut scores).unwrap();
    scores
}

/// The heights of each rig in each view, its lights turned by hand; the last `still` lights stay as they are told.
fn by_hand(frames: &[Frame], turned: impl Fn(usize) -> bool) -> Vec<Vec<f32>> {
    let in_view = |rig: &Vec<Light>, frame: &Frame| {
        let light = |(at, light): (usize, &Light)| match turned(at) {
            true => light.moved(&frames[0], frame).record(),
            false => light.record(),
        };
        height(&rig.iter().enumerate().map(light).collect::<Vec<_>>())
    };
    let of_rig = |rig| frames.iter().map(|frame| in_view(rig, frame)).collect();
    rigs().iter().map(of_rig).collect()
}

fn assert_near(found: &[f32], expected: impl Iterator<Item = f32>) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    }
}

#[test]
fn scores_of_the_world_s_rig_are_those_of_the_rig_turned_into_each_view() {
    let (mut views, frames) = views(Stand::World, Over::Mean, 0);
    let all = by_hand(&frames, |_| true);
    assert!((all[0][0] - all[0][1]).abs() > 0.01, "turning matters: {all:?}");
    assert_near(&scores(&mut views), all.iter().map(|rig| rig.iter().sum::<f32>() / 3.0));
    let (mut views, _) = self::views(Stand::World, Over::Worst, 0);
    let worst = |rig: &Vec<f32>| rig.iter().copied().fold(f32::MIN, f32::max);
    assert_near(&scores(&mut views), all.iter().map(worst));
}

#[test]
fn the_camera_s_rig_goes_with_it_and_the_scene_s_own_lights_do_not() {
    let (mut views, frames) = views(Stand::Camera, Over::Mean, 1);
    let all = by_hand(&frames, |at| at == 1);
    assert_near(&scores(&mut views), all.iter().map(|rig| rig.iter().sum::<f32>() / 3.0));
    let (mut views, _) = self::views(Stand::Camera, Over::Mean, 0);
    assert_near(&scores(&mut views), by_hand(&frames, |_| false).iter().map(|rig| rig[0]));
}

#[test]
fn lights_keep_what_they_send_out_where_the_frame_grows() {
    let (small, large) = (frame(0.0, DVec3::ZERO, 1.0), frame(0.7, DVec3::X, 2.0));
    let light = Light { distance: 3.0, azimuth: 0.4, size: 0.5, ..Light::default() };
    let moved = &in_view(&[light], Stand::World, &small, &large)[0];
    let expected = light.moved(&small, &large);
    let place = |record: &LightRecord| DVec3::from(record.position.map(f64::from));
    assert!(place(moved).abs_diff_eq(place(&expected.record()), 1e-6));
    // Half as far in radii of twice the length: a point of the world has the same light.
    let at = DVec3::new(0.3, -0.2, 0.5);
    let arriving = |record: &LightRecord, at: DVec3| {
        f64::from(record.radius2) / place(record).distance_squared(at)
    };
    let before = arriving(&light.record(), at);
    let after = arriving(moved, small.change_to(&large).point(at));
    assert!((before - after).abs() < 1e-6, "{before} {after}");
    assert_eq!((moved.size, moved.diffuse), (0.25, light.diffuse));
    let sun = Light { kind: LightKind::DIRECTIONAL, size: 0.1, ..light };
    let moved = &in_view(&[sun], Stand::World, &small, &large)[0];
    let expected = sun.moved(&small, &large).record();
    assert!(place(moved).abs_diff_eq(place(&expected), 1e-6));
    assert_eq!((moved.radius2, moved.size), (0.0, 0.1));
}

#[test]
fn scene_lights_stand_in_the_world_for_pictures_too() {
    let (from, to) = (frame(0.0, DVec3::ZERO, 1.0), frame(1.2, DVec3::ZERO, 1.0));
    let rig = [Light::default(), Light { role: Role::Scene, ..Light::default() }];
    let records = in_view(&rig, Stand::Camera, &from, &to);
    assert_eq!(records[0], rig[0].record());
    assert!(records[1].position != rig[1].record().position);
    let still = in_view(&rig, Stand::World, &from, &from);
    assert_eq!(still, rig.map(|light| light.record()));
}

/// Tells when it begins and when it ends.
struct Told {
    name: char,
    story: Rc<RefCell<String>>,
}

impl Evaluator for Told {
    fn device(&self) -> &DeviceInfo {
        unreachable!("scores alone are asked for")
    }
    fn evaluate(&mut self, population: &Population, scores: &mut [f32]) -> Result<()> {
        self.begin(population)?(scores)
    }
    fn begin<'a>(&'a mut self, _: &'a Population) -> Result<Pending<'a>> {
        self.story.borrow_mut().push(self.name);
        Ok(Box::new(|scores| {
            self.story.borrow_mut().push(self.name.to_ascii_uppercase());
            scores.fill(f32::from(self.name as u8 - b'a'));
            Ok(())
        }))
    }
    fn qualities(&mut self, _: &Population) -> Result<Vec<Quality>> {
        unreachable!("scores alone are asked for")
    }
    fn inspect(&mut self, _: &[Light]) -> Result<Inspection> {
        unreachable!("scores alone are asked for")
    }
    fn maps(&mut self) -> Result<&Maps> {
        unreachable!("scores alone are asked for")
    }
}

#[test]
fn all_views_begin_before_the_first_is_waited_for() {
    let story = Rc::new(RefCell::new(String::new()));
    let one =
        |name: char| -> Box<dyn Evaluator> { Box::new(Told { name, story: Rc::clone(&story) }) };
    let view = |name| (one(name), frame(0.0, DVec3::ZERO, 1.0));
    let views = ['a', 'b', 'c'].map(view).into();
    let mut views = Views::new(views, Stand::World, Over::Mean, 0).unwrap();
    assert_eq!(scores(&mut views), [1.0, 1.0]);
    assert_eq!(story.take(), "abcABC");
    let rigs = rigs();
    let population = Population::of(rigs.iter().map(Vec::as_slice)).unwrap();
    let mut found = [0.0; 2];
    Focused::new(one('a'), one('b')).evaluate(&population, &mut found).unwrap();
    assert_eq!(found, [FOCUS_SHARE; 2]);
    Dimmed::new(one('c'), one('a'), one('b')).evaluate(&population, &mut found).unwrap();
    assert_eq!(found, [1.0; 2]);
    assert_eq!(story.take(), "abABabAB");
}

#[test]
fn no_views_and_frames_without_extent_are_refused() {
    let none: Vec<(Box<dyn Evaluator>, Frame)> = Vec::new();
    assert!(Views::new(none, Stand::World, Over::Mean, 0).is_err());
    let flat = frame(0.0, DVec3::ZERO, 0.0);
    let one: Box<dyn Evaluator> = Box::new(Hills::default());
    assert!(Views::new(vec![(one, flat)], Stand::World, Over::Mean, 0).is_err());
}
