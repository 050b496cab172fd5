use super::*;
use crate::lighting::Color;
use crate::lighting::kinds::KINDS;
use proptest::prelude::*;

const ROLES: [Role; 3] = [Role::Key, Role::Fill, Role::Rim];

proptest! {
    #[test]
    fn decoding_and_encoding_invert_each_other(
        shares in prop::collection::vec(0f32..=1.0, 18), kind in 0..KINDS.len(), one: bool,
    ) {
        let kind = KINDS[kind];
        let mut boxes = Boxes::default();
        if one {
            boxes.fill.specular = None;
        }
        let genome = Genome::new(&ROLES, kind, &boxes).unwrap();
        let place = |(r, t): (&Range, &f32)| r.at(*t);
        let chromosome: Vec<f32> = genome.bounds().iter().zip(&shares).map(place).collect();
        prop_assert_eq!(genome.encode(&genome.decode(&chromosome)), chromosome);
    }
}

/// Fill and rim relative to the key, of one intensity.
fn relative() -> Boxes {
    let mut boxes = Boxes::default();
    boxes.all_mut().into_iter().for_each(|space| space.specular = None);
    for space in [&mut boxes.fill, &mut boxes.rim] {
        (space.azimuth_from_key, space.share_of_key) = (true, true);
    }
    boxes.fill.azimuth = Range::new(20.0, 110.0);
    boxes
}

fn near(a: &[f32], b: &[f32]) -> bool {
    std::iter::zip(a, b).all(|(a, b)| (a - b).abs() < 1e-4 * a.abs().max(1.0))
}

proptest! {
    #[test]
    fn what_is_relative_to_the_key_is_decoded_and_encoded_too(
        shares in prop::collection::vec(0.01f32..=1.0, 24), kind in 0..KINDS.len(),
        order in Just([Role::Key, Role::Fill, Role::Rim, Role::Key]).prop_shuffle(), two: bool,
    ) {
        let mut boxes = relative();
        if two {
            boxes.all_mut().into_iter().for_each(|space| space.specular = Some(space.diffuse));
        }
        let genome = Genome::new(&order, KINDS[kind], &boxes).unwrap();
        let place = |(r, t): (&Range, &f32)| r.at(*t);
        let chromosome: Vec<f32> = genome.bounds().iter().zip(&shares).map(place).collect();
        let rig = genome.decode(&chromosome);
        let again = genome.encode(&rig);
        prop_assert!(near(&again, &chromosome), "{again:?} {chromosome:?}");
        for (light, role) in rig.iter().zip(order) {
            prop_assert_eq!(light.role, role);
        }
    }
}

/// Azimuths in degrees and intensities, of alleles by which a genome decodes to directional lights.
fn placed(roles: &[Role], alleles: &[[f32; 2]]) -> (Genome, Vec<[f32; 2]>) {
    let genome = Genome::new(roles, LightKind::DIRECTIONAL, &relative()).unwrap();
    let gene = |&[azimuth, intensity]: &[f32; 2]| [0.5, azimuth.to_radians(), intensity];
    let rig = genome.decode(&alleles.iter().flat_map(gene).collect::<Vec<_>>());
    let place = |light: &Light| [light.azimuth.to_degrees().round(), light.diffuse];
    (genome, rig.iter().map(place).collect())
}

#[test]
fn a_fill_stands_across_from_its_key_with_a_share_of_its_intensity() {
    use Role::{Fill, Key, Rim};
    let (_, right) = placed(&[Key, Fill], &[[30.0, 1.5], [50.0, 0.5]]);
    assert_eq!(right, [[30.0, 1.5], [-20.0, 0.75]]);
    let (_, left) = placed(&[Key, Fill], &[[-30.0, 1.5], [50.0, 0.5]]);
    assert_eq!(left, [[-30.0, 1.5], [20.0, 0.75]]);
    // The first key counts, wherever it stands.
    let (_, many) = placed(
        &[Fill, Key, Rim, Key, Fill],
        &[[100.0, 0.5], [40.0, 2.0], [140.0, 0.25], [-80.0, 1.0], [30.0, 1.0]],
    );
    let expected = [[-60.0, 1.0], [40.0, 2.0], [-100.0, 0.5], [-80.0, 1.0], [10.0, 2.0]];
    assert_eq!(many, expected);
    // Without a key, values stand for themselves.
    let (_, alone) = placed(&[Fill, Rim], &[[50.0, 0.5], [120.0, 0.25]]);
    assert_eq!(alone, [[50.0, 0.5], [120.0, 0.25]]);
}

#[test]
fn given_rigs_move_to_the_nearest_values_relative_to_the_key() {
    let (genome, _) = placed(&[Role::Key, Role::Fill], &[[0.0, 1.0], [20.0, 0.5]]);
    let encode = |key: [f32; 2], fill: [f32; 2]| {
        let light = |[azimuth, diffuse]: [f32; 2]| Light {
            azimuth: azimuth.to_radians(),
            diffuse,
            ..Light::default()
        };
        let values = genome.encode(&[light(key), light(fill)]);
        [values[4].to_degrees().round(), values[5]]
    };
    assert_eq!(encode([45.0, 1.0], [-45.0, 0.5]), [90.0, 0.5]);
    assert_eq!(encode([45.0, 1.0], [315.0, 0.5]), [90.0, 0.5], "after a full turn");
    assert_eq!(encode([45.0, 1.0], [60.0, 3.0]), [20.0, 1.0], "beside the key and too bright");
    // The key itself is moved into its box first: to 90 degrees and the intensity 2.
    assert_eq!(encode([120.0, 4.0], [40.0, 1.0]), [50.0, 0.5]);
    assert_eq!(encode([45.0, 0.0], [-45.0, 0.5]), [90.0, 0.0], "a share of nothing");
}

#[test]
fn fixed_lights_are_relative_to_nothing() {
    let (genome, _) = placed(&[Role::Key, Role::Fill], &[[0.0, 1.0], [20.0, 0.5]]);
    let sun = Light { role: Role::Scene, azimuth: 1.0, diffuse: 3.0, ..Light::default() };
    let chromosome = [0.5, 0.25, 1.5, 0.25, 1.0, 0.5];
    let rig = genome.clone().with_fixed(&[sun]).unwrap().decode(&chromosome);
    assert_eq!(rig, [&genome.decode(&chromosome)[..], &[sun]].concat());
}

#[test]
fn a_rim_light_in_front_goes_to_the_nearest_side() {
    let genome = Genome::new(&[Role::Rim], LightKind::DIRECTIONAL, &Boxes::default()).unwrap();
    let rig = |azimuth: f32| {
        let mut rig = genome.decode(&[0.0, azimuth.to_radians(), 0.5, 0.5]);
        rig[0].elevation = 2.0;
        genome.encode(&rig).iter().map(|a| a.to_degrees().round()).collect::<Vec<_>>()
    };
    assert_eq!(rig(30.0)[..2], [90.0, 100.0]);
    assert_eq!(rig(-30.0)[..2], [90.0, 260.0]);
    assert_eq!(rig(-170.0)[..2], [90.0, 190.0]);
}

#[test]
fn the_paper_s_chromosome_has_its_order() {
    let names = |kind| {
        let genome = Genome::new(&[Role::Key], kind, &Boxes::default()).unwrap();
        genome.alleles(0).map(|allele| allele.name).collect::<Vec<_>>()
    };
    let point = ["elevation", "azimuth", "diffuse", "specular", "distance"];
    assert_eq!(names(LightKind::POINT), point);
    assert_eq!(names(LightKind::DIRECTIONAL), point[..4]);
    assert_eq!(names(LightKind::SPOT), [&point[..], &["cone"]].concat());
}

#[test]
fn a_box_without_specular_gives_lights_of_one_intensity() {
    let mut boxes = Boxes::default();
    boxes.key.specular = None;
    boxes.key.color = "3200K".parse().unwrap();
    let genome = Genome::new(&[Role::Key, Role::Fill], LightKind::POINT, &boxes).unwrap();
    assert_eq!(genome.bounds().len(), 4 + 5);
    let rig = genome.decode(&[0.5, 0.25, 1.5, 3.0, 0.1, -0.2, 0.5, 0.75, 2.0]);
    assert_eq!((rig[0].diffuse, rig[0].specular, rig[0].distance), (1.5, 1.5, 3.0));
    assert_eq!((rig[1].diffuse, rig[1].specular, rig[1].distance), (0.5, 0.75, 2.0));
    assert_eq!((rig[0].color, rig[1].color), (boxes.key.color, Color::WHITE));
    assert_eq!(genome.encode(&rig), [0.5, 0.25, 1.5, 3.0, 0.1, -0.2, 0.5, 0.75, 2.0]);
}

#[test]
fn fixed_lights_follow_the_searched_ones_and_have_no_alleles() {
    let genome = Genome::new(&[Role::Key], LightKind::DIRECTIONAL, &Boxes::default()).unwrap();
    let sun = Light { role: Role::Scene, diffuse: 3.0, ..Light::default() };
    let with_sun = genome.clone().with_fixed(&[sun]).unwrap();
    assert_eq!((with_sun.lights(), with_sun.rig_lights()), (1, 2));
    assert_eq!(with_sun.bounds(), genome.bounds());
    let chromosome = [0.5, 0.25, 1.5, 0.5];
    let rig = with_sun.decode(&chromosome);
    assert_eq!(rig, [&genome.decode(&chromosome)[..], &[sun]].concat());
    assert_eq!(with_sun.encode(&rig), chromosome);
    assert!(genome.clone().with_fixed(&[sun; 15]).is_ok());
    let fault = genome.with_fixed(&[sun; 16]).unwrap_err().to_string();
    assert!(fault.contains("1 lights to search and 16"), "{fault}");
    let scene = Genome::new(&[Role::Scene], LightKind::POINT, &Boxes::default());
    assert!(scene.unwrap_err().is_input());
}

#[test]
fn bad_boxes_are_refused() {
    for range in [Range::new(1.0, 0.0), Range::new(f32::NAN, 1.0), Range::new(-1.0, 1.0)] {
        let mut boxes = Boxes::default();
        boxes.fill.diffuse = range;
        assert!(Genome::new(&[Role::Fill], LightKind::POINT, &boxes).is_err(), "{range:?}");
        assert!(Genome::new(&[Role::Key], LightKind::POINT, &boxes).is_ok());
    }
    let mut boxes = relative();
    boxes.key.share_of_key = true;
    let fault = Genome::new(&[Role::Key], LightKind::POINT, &boxes).unwrap_err().to_string();
    assert!(fault.contains("relative to the key"), "{fault}");
    let mut boxes = Boxes::default();
    boxes.key.cone = Range::new(10.0, 91.0);
    assert!(Genome::new(&[Role::Key], LightKind::SPOT, &boxes).is_err());
    assert!(Genome::new(&[], LightKind::POINT, &Boxes::default()).is_err());
    assert!(Genome::new(&[Role::Key; 17], LightKind::POINT, &Boxes::default()).is_err());
}

/// The light frame's upwards of a camera that looks down by so many degrees.
fn looking_down(degrees: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new(0.0, cos, sin)
}

proptest! {
    #[test]
    fn no_light_stands_below_the_horizon_and_those_above_stay(
        shares in prop::collection::vec(0f32..=1.0, 18), down in -90f32..=90.0,
    ) {
        let mut boxes = Boxes::default();
        boxes.all_mut().into_iter().for_each(|space| space.elevation = Range::new(-90.0, 90.0));
        let free = Genome::new(&ROLES, LightKind::POINT, &boxes).unwrap();
        let up = looking_down(down);
        let bound = free.clone().above_horizon(up).unwrap();
        let place = |(r, t): (&Range, &f32)| r.at(*t);
        let chromosome: Vec<f32> = free.bounds().iter().zip(&shares).map(place).collect();
        for (light, before) in bound.decode(&chromosome).iter().zip(free.decode(&chromosome)) {
            prop_assert!(light.direction().dot(up) > -1e-5, "{light:?}");
            prop_assert_eq!((light.azimuth, light.diffuse), (before.azimuth, before.diffuse));
            if before.direction().dot(up) >= 0.0 {
                prop_assert_eq!(*light, before);
            }
        }
    }
}

#[test]
fn the_horizon_turns_with_the_camera() {
    let frame = |down: f32| {
        let up = looking_down(down).as_dvec3();
        let (right, up, back) =
            (glam::DVec3::X, glam::DVec3::new(0.0, up.y, -up.z), glam::DVec3::new(0.0, up.z, up.y));
        Frame { center: glam::DVec3::ZERO, radius: 1.0, right, up, back }
    };
    let mut genome = Genome::new(&[Role::Rim], LightKind::POINT, &Boxes::default())
        .unwrap()
        .above_horizon(looking_down(10.0))
        .unwrap();
    genome.follow(&frame(10.0), &frame(40.0));
    let lowest: Vec<f32> = genome.bounds().iter().map(|range| range.low).collect();
    let light = genome.decode(&lowest)[0];
    assert!(light.direction().dot(looking_down(40.0)).abs() < 1e-5, "{light:?}");
    let fault = genome.above_horizon(Vec3::new(0.0, 2.0, 0.0)).unwrap_err();
    assert!(fault.is_input(), "{fault}");
}

#[test]
fn what_is_held_is_not_searched() {
    let boxes = relative();
    let genome = Genome::new(&ROLES, LightKind::POINT, &boxes).unwrap();
    // Outside its box, of another kind and colour.
    let key = Light {
        kind: LightKind::DIRECTIONAL,
        elevation: -0.5,
        azimuth: 2.0,
        diffuse: 9.0,
        color: Color::of_kelvin(3000.0).unwrap(),
        ..Light::default()
    };
    let kept = genome.clone().hold(0, &key, None).unwrap();
    assert_eq!(kept.bounds().len(), genome.bounds().len() - 4);
    let middle: Vec<f32> = kept.bounds().iter().map(Range::middle).collect();
    let rig = kept.decode(&middle);
    assert_eq!((rig[0], rig.len()), (key, 3));
    // What is relative to the key is so to the one that is held.
    assert!((rig[1].azimuth - (2.0 - 65f32.to_radians())).abs() < 1e-5, "{:?}", rig[1]);
    assert!(near(&kept.encode(&rig), &middle));

    let part = genome.clone().hold(2, &key, Some("elevation")).unwrap();
    assert_eq!(part.bounds().len(), genome.bounds().len() - 1);
    let middle: Vec<f32> = part.bounds().iter().map(Range::middle).collect();
    let rim = part.decode(&middle)[2];
    assert_eq!((rim.elevation, rim.role, rim.kind), (-0.5, Role::Rim, LightKind::POINT));

    for (at, value, said) in
        [(3, None, "no light 3"), (1, Some("size"), "no 'size' to keep: it has elevation")]
    {
        let fault = genome.clone().hold(at, &key, value).unwrap_err();
        assert!(fault.is_input() && fault.to_string().contains(said), "{fault}");
    }
    let one = Genome::new(&[Role::Key], LightKind::POINT, &boxes).unwrap();
    assert!(one.hold(0, &key, None).unwrap_err().to_string().contains("nothing is left"));
}

#[test]
fn a_genome_like_a_rig_keeps_what_nothing_searches() {
    let color = Color::of_linear([1.0, 0.5, 0.2]).unwrap();
    let key = Light { distance: 2.0, size: 0.1, color, ..Light::default() };
    let kind = LightKind::DIRECTIONAL;
    let rim = Light { role: Role::Rim, kind, azimuth: 3.0, diffuse: 0.5, ..Light::default() };
    let genome = Genome::like(&[key, rim], &Boxes::default()).unwrap();
    let mut chromosome = genome.encode(&[key, rim]);
    let rig = genome.decode(&chromosome);
    assert_eq!((rig[0].color, rig[0].kind, rig[1].kind), (color, key.kind, kind));
    assert!((rig[0].size - 0.1).abs() < 1e-6 && rig[1].size == 0.0);
    let distance = genome.alleles(0).position(|allele| allele.name == "distance").unwrap();
    chromosome[distance] = 4.0;
    // The angle that it covers stays.
    assert!((genome.decode(&chromosome)[0].size - 0.2).abs() < 1e-6);
    assert!(Genome::like(&[], &Boxes::default()).is_err());
    let own = Light { role: Role::Scene, ..key };
    assert!(Genome::like(&[own], &Boxes::default()).is_err());
}
