//! An engine's own surface: the stage `surface` against its reference, and the scores that follow.

use ash::vk;
use engine::{ALL, Engine, Frame, HostBuffer, Texture, tunings};
use glam::dcamera::rh::{proj, view as looking};
use glam::{DVec3, Vec3};
use klieg::cpu::surface::EngineImages;
use klieg::cpu::{self};
use klieg::evaluate::Evaluator;
use klieg::gpu::{
    Context, EngineImage, ImportedSurface, ScoreTarget, SurfaceEvaluator, SurfaceImages,
};
use klieg::lighting::LightKind;
use klieg::lighting::shading::Shading;
use klieg::objective::Objective;
use klieg::objective::maps::{Maps, PixelType, Surface};
use klieg::objective::shadows::ShadowSettings;
use klieg::scene::engine::{EngineCamera, NormalCode, NormalSpace, SurfaceFormat};
use klieg::scene::occluders::Occluders;
use klieg_support::{engine, figures, gpu as support, reference};
use reference::{difference, reference};
use std::sync::Arc;
use support::{population, rigs};

const SIZE: [u32; 2] = [67, 45];

fn evaluator(context: &Arc<Context>) -> SurfaceEvaluator {
    let (objective, shading) = (Objective::default(), Shading::default());
    SurfaceEvaluator::new(context, SIZE, objective, shading).unwrap()
}

fn camera(eye: DVec3) -> EngineCamera {
    EngineCamera {
        view: looking::look_at_mat4(eye, DVec3::ZERO, DVec3::Y),
        projection: proj::vulkan::perspective_infinite_reverse(0.7, 67.0 / 45.0, 0.05),
        center: DVec3::new(0.1, 0.0, -0.1),
        radius: 1.7,
    }
}

/// What an engine draws of a scene: the surface that klieg itself would draw, in the engine's codes.
fn drawn(camera: &EngineCamera) -> (EngineImages, SurfaceFormat, Surface) {
    let view = camera.view(SIZE[0], SIZE[1]).unwrap();
    let surface = cpu::visibility::draw(&figures::instances(), &view);
    let frame = view.frame;
    let world = |n: &[f32; 3]| {
        let n = Vec3::from(*n).as_dvec3();
        (frame.right * n.x + frame.up * n.y + frame.back * n.z).as_vec3().extend(0.0).to_array()
    };
    let clip = camera.frame_from_clip(&frame).inverse();
    let depth = surface.position.iter().zip(&surface.code).map(|(p, &code)| {
        let clip = clip * Vec3::from(*p).as_dvec3().extend(1.0);
        if code == 0 { 0.0 } else { (clip.z / clip.w) as f32 }
    });
    let rm = surface.roughness.iter().zip(&surface.metallic);
    let four = |v: &[f32; 3]| [v[0], v[1], v[2], 0.5];
    let images = EngineImages {
        depth: depth.collect(),
        normal: Some(surface.normal.iter().map(world).collect()),
        base_color: Some(surface.base_color.iter().map(four).collect()),
        roughness_metallic: Some(rm.map(|(&r, &m)| [0.0, r, m, 0.0]).collect()),
        emissive: Some(surface.emissive.iter().map(four).collect()),
        ids: Some(surface.code.clone()),
    };
    (images, SurfaceFormat { cleared_depth: 0.0, ..SurfaceFormat::default() }, surface)
}

/// The images on the engine's device.
struct Uploaded<'a> {
    textures: Vec<Texture<'a>>,
    images: SurfaceImages,
}

fn upload<'a>(engine: &'a Engine, images: &EngineImages) -> Uploaded<'a> {
    let mut textures = Vec::new();
    let mut add = |format, texels: &[u8]| {
        let texture = Texture::new(engine, SIZE, (1, false), format, texels);
        let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
        let image = EngineImage { view: texture.view, layout };
        textures.push(texture);
        image
    };
    let float = vk::Format::R32G32B32A32_SFLOAT;
    let mut vec4 = |image: &Option<Vec<[f32; 4]>>| {
        image.as_ref().map(|texels| add(float, bytemuck::cast_slice(texels)))
    };
    let normal = vec4(&images.normal);
    let base_color = vec4(&images.base_color);
    let roughness_metallic = vec4(&images.roughness_metallic);
    let emissive = vec4(&images.emissive);
    let depth = add(vk::Format::D32_SFLOAT, bytemuck::cast_slice(&images.depth));
    let ids = images.ids.as_ref().map(|ids| add(vk::Format::R32_UINT, bytemuck::cast_slice(ids)));
    let images = SurfaceImages { depth, normal, base_color, roughness_metallic, emissive, ids };
    Uploaded { textures, images }
}

fn import(
    evaluator: &SurfaceEvaluator,
    uploaded: &Uploaded<'_>,
    format: &SurfaceFormat,
) -> ImportedSurface {
    assert!(!uploaded.textures.is_empty());
    // SAFETY: the tests keep the images and wait for the device.
    unsafe { evaluator.import(&uploaded.images, format) }.unwrap()
}

fn look(evaluator: &mut SurfaceEvaluator, surface: &ImportedSurface, camera: &EngineCamera) {
    // SAFETY: as above, and nothing else runs.
    unsafe { evaluator.look(surface, camera) }.unwrap();
}

/// The largest difference of the surfaces, position by position, and pixels whose types differ.
fn far(a: &Maps, b: &Maps) -> (f32, usize) {
    assert_eq!(a.surface.code, b.surface.code);
    let of = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        let pairs = a.as_flattened().iter().zip(b.as_flattened());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let one =
        |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let (s, t) = (&a.surface, &b.surface);
    let distance = [
        of(&s.position, &t.position),
        of(&s.normal, &t.normal),
        of(&s.base_color, &t.base_color),
        of(&s.emissive, &t.emissive),
        one(&s.roughness, &t.roughness),
        one(&s.metallic, &t.metallic),
        one(&s.depth, &t.depth),
    ];
    let types = a.types.iter().zip(&b.types).filter(|(a, b)| a != b).count();
    (distance.into_iter().fold(0.0, f32::max), types)
}

/// Share of the object pixels whose polygons look the same way, up to an angle of that cosine.
fn same_faces(a: &Surface, b: &Surface, cosine: f32) -> f32 {
    let object = (0..a.code.len()).filter(|&at| a.code[at] != 0 && b.code[at] != 0);
    let same = |&at: &usize| Vec3::from(a.face[at]).dot(b.face[at].into()) > cosine;
    object.clone().filter(same).count() as f32 / object.count() as f32
}

/// The maps that the device makes of the images, and those of the reference.
fn both(
    engine: &Engine,
    images: &EngineImages,
    format: &SurfaceFormat,
    camera: &EngineCamera,
) -> (Maps, Maps) {
    let context = engine.context(&tunings()[1]);
    let mut evaluator = evaluator(&context);
    let uploaded = upload(engine, images);
    let surface = import(&evaluator, &uploaded, format);
    look(&mut evaluator, &surface, camera);
    let made = evaluator.evaluator().maps().unwrap().clone();
    let reference = cpu::surface::surface(images, format, camera, SIZE).unwrap();
    (made, cpu::maps(reference, &Objective::default()))
}

#[test]
fn the_surface_is_the_one_that_klieg_would_draw() {
    let engine = Engine::new(ALL);
    for eye in [DVec3::new(1.0, 1.2, 4.0), DVec3::new(-2.5, 0.4, 2.0)] {
        let camera = camera(eye);
        let (images, format, surface) = drawn(&camera);
        let (made, reference) = both(&engine, &images, &format, &camera);
        assert!(made.counts.object() > 300 && made.counts.edge > 20, "{:?}", made.counts);
        let (distance, types) = far(&made, &reference);
        assert!(distance < 2e-4 && types <= 2, "{distance} {types}");
        let (distance, types) = far(&made, &cpu::maps(surface.clone(), &Objective::default()));
        assert!(distance < 1e-3 && types <= 2, "{distance} {types}");
        assert_eq!(made.visible, reference.visible);
        assert!(same_faces(&made.surface, &reference.surface, 0.995) > 0.99);
        // A pixel's neighbours show other polygons.
        assert!(same_faces(&made.surface, &surface, 0.9) > 0.8);
    }
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn every_code_of_an_engine_is_read() {
    let engine = Engine::new(ALL);
    let camera = camera(DVec3::new(1.0, 1.2, 4.0));
    let (images, format, _) = drawn(&camera);
    let map = |f: &dyn Fn([f32; 4]) -> [f32; 4]| {
        Some(images.normal.as_ref().unwrap().iter().map(|&n| f(n)).collect::<Vec<_>>())
    };
    let octahedral = |[x, y, z, _]: [f32; 4]| {
        let sum = x.abs() + y.abs() + z.abs();
        let (x, y) = if sum > 0.0 { (x / sum, y / sum) } else { (0.0, 0.0) };
        let sign = |v: f32| if v >= 0.0 { 1.0 } else { -1.0 };
        let [x, y] = match z >= 0.0 {
            true => [x, y],
            false => [(1.0 - y.abs()) * sign(x), (1.0 - x.abs()) * sign(y)],
        };
        [x, y, 0.0, 0.0]
    };
    let half = |[x, y, z, w]: [f32; 4]| [x, y, z, w].map(|v| 0.5 * v + 0.5);
    let of_eye = {
        let view = camera.view.as_mat4();
        map(&|[x, y, z, _]| view.transform_vector3(Vec3::new(x, y, z)).extend(0.0).to_array())
    };
    let (expected, _) = both(&engine, &images, &format, &camera);
    let with = |normal, normal_code| {
        (EngineImages { normal, ..images.clone() }, SurfaceFormat { normal_code, ..format })
    };
    for (images, format) in [
        with(map(&|n| n.map(|v| 3.0 * v)), NormalCode::Signed),
        with(map(&half), NormalCode::Unsigned),
        with(map(&octahedral), NormalCode::Octahedral),
        with(map(&|n| half(octahedral(n))), NormalCode::OctahedralUnsigned),
        (
            EngineImages { normal: of_eye, ..images.clone() },
            SurfaceFormat { normal_space: NormalSpace::Eye, ..format },
        ),
    ] {
        let (made, reference) = both(&engine, &images, &format, &camera);
        let (distance, types) = far(&made, &expected);
        assert!(distance < 2e-5 && types == 0, "{format:?}: {distance} {types}");
        assert!(far(&made, &reference).0 < 2e-4, "{format:?}");
    }
    // A code that is read as another is noticed.
    let (wrong, format) = with(map(&half), NormalCode::Signed);
    assert!(far(&both(&engine, &wrong, &format, &camera).0, &expected).0 > 0.1);
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn images_that_are_not_there_are_made_up_for() {
    let engine = Engine::new(ALL);
    let camera = camera(DVec3::new(1.0, 1.2, 4.0));
    let (images, format, surface) = drawn(&camera);
    let format =
        SurfaceFormat { base_color: [0.2, 0.5, 0.7], roughness: 0.4, metallic: 0.25, ..format };
    let bare = EngineImages { depth: images.depth.clone(), ..EngineImages::default() };
    let (made, reference) = both(&engine, &bare, &format, &camera);
    let (distance, types) = far(&made, &reference);
    assert!(distance < 5e-3 && types <= 2, "{distance} {types}");
    let object = surface.code.iter().filter(|&&code| code != 0).count() as u32;
    assert_eq!(made.counts.object(), object);
    assert_eq!(made.visible, [1]);
    // Away from the edges normals of the depth are those of the flat faces.
    let same =
        made.types.iter().zip(&made.surface.normal).zip(&surface.normal).filter(|((t, a), b)| {
            **t == PixelType::Surface && Vec3::from(**a).dot(Vec3::from(**b)) > 0.99
        });
    assert!(same.count() as u32 > made.counts.surface * 8 / 10);
    let i = made.types.iter().position(|&t| t == PixelType::Surface).unwrap();
    assert_eq!(made.surface.base_color[i], format.base_color);
    assert_eq!((made.surface.roughness[i], made.surface.metallic[i]), (0.4, 0.25));

    // Rows from the bottom, with a camera whose y goes up, show the same.
    let mirrored = glam::DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0)) * camera.projection;
    let up = EngineCamera { projection: mirrored, ..camera };
    let (flipped, reference) =
        both(&engine, &bare, &SurfaceFormat { flipped: true, ..format }, &up);
    assert_eq!(far(&flipped, &made).0, 0.0);
    assert!(far(&flipped, &reference).0 < 5e-3);
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn scores_are_those_of_the_references_for_a_moving_camera() {
    let engine = Engine::new(ALL);
    let all = rigs(7, 9, 3, LightKind::POINT);
    for tuning in tunings() {
        let context = engine.context(&tuning);
        let mut evaluator = evaluator(&context);
        evaluator.evaluator().reserve(9, 3).unwrap();
        let cameras = [DVec3::new(1.0, 1.2, 4.0), DVec3::new(3.0, 0.2, 9.0), DVec3::Z * -3.0];
        for (i, camera) in cameras.map(camera).into_iter().enumerate() {
            let (mut images, format, _) = drawn(&camera);
            if i == 2 {
                // Nothing but one pixel.
                images.ids = Some(vec![0; images.depth.len()]);
                images.ids.as_mut().unwrap()[700] = 5;
            }
            let uploaded = upload(&engine, &images);
            let surface = import(&evaluator, &uploaded, &format);
            let buffer = HostBuffer::new(&engine, 9);
            let before = context.counters();
            let frame = Frame::record(&engine, |cmd| {
                let target = ScoreTarget::Buffer { buffer: buffer.raw, offset: 0 };
                // SAFETY: the frame is waited for before anything is dropped.
                unsafe {
                    evaluator.record_view(cmd, &surface, &camera).unwrap();
                    evaluator.evaluator().record(cmd, &population(&all), target).unwrap();
                }
            });
            assert_eq!(context.counters(), before, "a recording makes nothing");
            frame.submit();
            frame.wait();
            let view = evaluator.view().unwrap().clone();
            let maps = evaluator.evaluator().maps().unwrap().clone();
            let scores = buffer.read(0, 9);
            for (score, rig) in scores.iter().zip(&all) {
                let expected = reference(&maps, &view, rig);
                assert!((score - expected.score).abs() < 1e-4, "view {i}: {score}");
                let quality = evaluator.evaluator().inspect(rig).unwrap();
                let far = difference(quality.quality(), expected.quality());
                assert!(far < 1e-4, "{tuning:?} view {i}: {far}");
                let picture = quality.picture.iter().zip(&expected.picture);
                assert!(picture.clone().all(|(a, b)| (a - b).abs() < 1e-3), "view {i}");
            }
        }
    }
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn a_scene_casts_shadows_on_what_an_engine_draws() {
    let engine = Engine::new(ALL);
    let scene = figures::instances();
    let settings = ShadowSettings { on: true, side: 15, ..ShadowSettings::default() };
    let mut all = rigs(11, 4, 2, LightKind::POINT);
    all[3][0].distance = 0.7;
    for tuning in tunings() {
        let context = engine.context(&tuning);
        let both = (Objective::default(), Shading::default());
        let mut evaluator =
            SurfaceEvaluator::with_shadows(&context, SIZE, both, &scene, &settings).unwrap();
        evaluator.evaluator().reserve(4, 2).unwrap();
        for eye in [DVec3::new(1.0, 1.2, 4.0), DVec3::new(-2.5, 2.4, 2.0)] {
            let camera = camera(eye);
            let (images, format, _) = drawn(&camera);
            let uploaded = upload(&engine, &images);
            let surface = import(&evaluator, &uploaded, &format);
            let before = context.counters();
            let frame = Frame::record(&engine, |cmd| {
                // SAFETY: the frame is waited for before anything is dropped.
                unsafe {
                    evaluator.record_view(cmd, &surface, &camera).unwrap();
                    let target = ScoreTarget::Mapped;
                    evaluator.evaluator().record(cmd, &population(&all), target).unwrap();
                }
            });
            assert_eq!(context.counters(), before, "a recording makes nothing");
            frame.submit();
            frame.wait();
            let mut scores = [0.0; 4];
            evaluator.evaluator().read_scores(&mut scores).unwrap();
            let view = evaluator.view().unwrap().clone();
            let mut maps = evaluator.evaluator().maps().unwrap().clone();
            let plain = all.iter().map(|rig| reference(&maps, &view, rig).score);
            let plain: Vec<_> = plain.collect();
            let occluders = Arc::new(Occluders::new(&scene, &view).unwrap());
            maps.shadows = Some(cpu::shadows::table(&maps.surface, occluders, &settings));
            for ((score, rig), plain) in scores.iter().zip(&all).zip(plain) {
                let expected = reference(&maps, &view, rig).score;
                assert!((score - expected).abs() < 2e-4, "{tuning:?}: {score} {expected}");
                assert!((score - plain).abs() > 1e-3, "{tuning:?}: {score} {plain}");
            }
        }
    }
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn one_pixel_of_the_engines_is_noticed() {
    let engine = Engine::new(ALL);
    let camera = camera(DVec3::new(1.0, 1.2, 4.0));
    let (images, format, surface) = drawn(&camera);
    let at = (0..images.depth.len()).find(|&i| i > 1500 && surface.code[i] != 0).unwrap();
    let (expected, _) = both(&engine, &images, &format, &camera);
    let mut changed = images.clone();
    changed.base_color.as_mut().unwrap()[at] = [0.9, 0.0, 0.1, 1.0];
    let (made, _) = both(&engine, &changed, &format, &camera);
    let differ = |f: fn(&Surface) -> &Vec<[f32; 3]>| {
        f(&made.surface).iter().zip(f(&expected.surface)).filter(|(a, b)| a != b).count()
    };
    assert_eq!((differ(|s| &s.base_color), differ(|s| &s.position)), (1, 0));
    changed.depth[at] *= 1.2;
    let (made, _) = both(&engine, &changed, &format, &camera);
    assert!(made.surface.position[at] != expected.surface.position[at]);
    // A depth that is no number is background.
    changed.depth[at] = f32::NAN;
    let (made, _) = both(&engine, &changed, &format, &camera);
    assert_eq!((made.surface.code[at], made.types[at]), (0, PixelType::Background));
    assert_eq!(engine.end(), [""; 0]);
}

#[test]
fn before_the_first_view_the_picture_is_empty() {
    let engine = Engine::new(ALL);
    for tuning in tunings() {
        let context = engine.context(&tuning);
        let mut evaluator = evaluator(&context);
        assert!(evaluator.view().is_none());
        assert_eq!(evaluator.evaluator().maps().unwrap().counts.object(), 0);
        let mut scores = [0.0; 2];
        let two = population(&rigs(1, 2, 1, LightKind::POINT));
        evaluator.evaluator().evaluate(&two, &mut scores).unwrap();
        assert!(scores[0] == scores[1] && scores[0].is_finite());
    }
    assert_eq!(engine.end(), [""; 0]);
}
