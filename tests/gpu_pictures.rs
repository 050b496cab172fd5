//! Pictures that an engine renders itself: the stage `pictures` against its reference, and the scores that
//! follow.

use ash::vk;
use drawn::{Drawn, SAMPLED, borrow, import, on_an_engine};
use engine::{Frame, HostBuffer, Texture};
use klieg::cpu;
use klieg::gpu::{EngineImage, ImportedPictures, ImportedSurface, PictureEvaluator, ScoreTarget};
use klieg::lighting::LightKind;
use klieg::math::color::srgb_decode;
use klieg::objective::Objective;
use klieg::objective::maps::PixelType;
use klieg::scene::engine::{PictureChannels, PictureEncoding, PictureFormat};
use klieg_support::{drawn, engine, gpu as support, reference};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use reference::difference;
use support::{ball, maps, rigs};

const LINEAR: PictureFormat =
    PictureFormat { encoding: PictureEncoding::Linear, channels: PictureChannels::Rgb };
const ENCODED: PictureFormat = PictureFormat { encoding: PictureEncoding::Encoded, ..LINEAR };
const fn red(format: PictureFormat) -> PictureFormat {
    PictureFormat { channels: PictureChannels::Red, ..format }
}

fn scores(evaluator: &mut PictureEvaluator, pictures: &ImportedPictures, count: u32) -> Vec<f32> {
    let mut scores = vec![f32::NAN; count as usize];
    evaluator.evaluate(pictures, count, &mut scores).unwrap();
    scores
}

/// The nearest half-precision number to a positive float.
fn half(x: f32) -> u16 {
    let bits = (x * 2f32.powi(-112)).to_bits();
    ((bits + 0xfff + (bits >> 13 & 1)) >> 13) as u16
}

fn from_half(bits: u16) -> f32 {
    f32::from_bits(u32::from(bits) << 13) * 2f32.powi(112)
}

/// How an engine stores a brightness `I`, and what a fetch of that gives.
struct Code {
    format: vk::Format,
    picture: PictureFormat,
    encode: fn(f32) -> Vec<u8>,
    fetch: fn(f32) -> f32,
    /// Largest difference of score and terms to those of what was fetched.
    exact: f32,
    /// Largest difference of the score to that of the picture before it was stored.
    tolerance: f32,
}

fn byte(i: f32) -> u8 {
    (255.0 * i).round() as u8
}

const CODES: [Code; 6] = [
    Code {
        format: vk::Format::R32_SFLOAT,
        picture: red(ENCODED),
        encode: |i| i.to_le_bytes().to_vec(),
        fetch: |i| i,
        exact: 1e-5,
        tolerance: 1e-5,
    },
    Code {
        format: vk::Format::R32_SFLOAT,
        picture: red(LINEAR),
        encode: |i| srgb_decode(i).to_le_bytes().to_vec(),
        fetch: srgb_decode,
        exact: 1e-5,
        tolerance: 1e-5,
    },
    Code {
        format: vk::Format::R16G16B16A16_SFLOAT,
        picture: LINEAR,
        encode: |i| [half(srgb_decode(i)); 4].map(u16::to_le_bytes).concat(),
        fetch: |i| from_half(half(srgb_decode(i))),
        exact: 1e-5,
        tolerance: 1e-4,
    },
    Code {
        format: vk::Format::R8_UNORM,
        picture: red(ENCODED),
        encode: |i| vec![byte(i)],
        fetch: |i| f32::from(byte(i)) / 255.0,
        exact: 1e-5,
        tolerance: 4e-3,
    },
    Code {
        format: vk::Format::R8G8B8A8_UNORM,
        picture: ENCODED,
        encode: |i| vec![byte(i); 4],
        fetch: |i| f32::from(byte(i)) / 255.0,
        exact: 1e-5,
        tolerance: 4e-3,
    },
    Code {
        format: vk::Format::R8G8B8A8_SRGB,
        picture: LINEAR,
        encode: |i| vec![byte(i); 4],
        fetch: |i| srgb_decode(f32::from(byte(i)) / 255.0),
        // The device decodes with a precision of its own: a brightness near a bin's border may change bins.
        exact: 1e-2,
        tolerance: 4e-3,
    },
];

#[test]
fn pictures_of_every_format_get_the_scores_of_the_references() {
    on_an_engine(|engine| {
        for [width, height] in [[45, 38], [67, 129], [130, 3]] {
            let drawn = Drawn::new(engine, ball(width, height));
            let context = borrow(engine, None);
            let mut evaluator = drawn.evaluator(&context);
            let pictures = drawn.render(&rigs(3, 5, 2, LightKind::POINT));
            for Code { format, picture, encode, fetch, exact, tolerance } in CODES {
                let texels: Vec<u8> = pictures.concat().into_iter().flat_map(encode).collect();
                let texture = drawn.layers(format, 5, &texels);
                let imported = import(&evaluator, &texture, 5, picture);
                let found = evaluator.qualities(&imported, 5).unwrap();
                for (found, rendered) in found.iter().zip(&pictures) {
                    let texels: Vec<_> = rendered.iter().map(|&i| [fetch(i); 4]).collect();
                    let far = difference(*found, drawn.fetched(&texels, picture));
                    assert!(far < exact, "{format:?} {width}x{height}: {far}");
                    let far = (found.score - drawn.quality(rendered).score).abs();
                    assert!(far < tolerance, "{format:?} {width}x{height}: {far}");
                }
                let found: Vec<f32> = found.iter().map(|quality| quality.score).collect();
                assert_eq!(scores(&mut evaluator, &imported, 5), found);
                // Another layer's score is farther off.
                let other = drawn.quality(&pictures[4]).score;
                assert!((found[0] - other).abs() > tolerance, "{} {other}", found[0]);
            }
        }
    });
}

/// Colours of all kinds, impossible ones among them.
fn colors(count: usize) -> Vec<[f32; 4]> {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let odd = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.5, -0.0, 1e30, 1e-40];
    let mut channel = || match random.random_range(0..40) {
        k @ 0..8 => odd[k],
        8..12 => random.random_range(0.9..20.0),
        _ => random.random_range(0.0..1.0),
    };
    (0..count).map(|_| [channel(), channel(), channel(), channel()]).collect()
}

#[test]
fn colors_and_impossible_texels_become_the_pictures_of_the_reference() {
    on_an_engine(|engine| {
        let drawn = Drawn::new(engine, ball(45, 38));
        let context = borrow(engine, None);
        let mut evaluator = drawn.evaluator(&context);
        let texels = colors(45 * 38);
        let bytes = bytemuck::cast_slice(&texels);
        let texture = drawn.layers(vk::Format::R32G32B32A32_SFLOAT, 1, bytes);
        let mut all = Vec::new();
        for format in [LINEAR, ENCODED, red(LINEAR), red(ENCODED)] {
            let imported = import(&evaluator, &texture, 1, format);
            let found = evaluator.inspect(&imported, 0).unwrap();
            let reference = cpu::pictures::picture(&drawn.maps, &texels, format);
            let far = found.picture.iter().zip(&reference).map(|(a, b)| (a - b).abs());
            assert!(far.clone().all(|far| far < 1e-5), "{format:?} {:?}", far.reduce(f32::max));
            assert!(
                found.score.is_finite()
                    && difference(found.quality(), drawn.quality(&reference)) < 1e-3
            );
            all.push(found.picture);
        }
        // Each format read as another is noticed.
        let differ = |a: &[f32], b: &[f32]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.1);
        assert!((0..4).all(|i| (0..i).all(|k| differ(&all[i], &all[k]))));
    });
}

#[test]
fn any_number_of_layers_in_any_number_of_chunks_has_the_same_bits() {
    on_an_engine(|engine| {
        let drawn = Drawn::new(engine, ball(45, 38));
        let pictures = drawn.render(&rigs(5, 40, 1, LightKind::DIRECTIONAL));
        let texture = drawn.floats(&pictures);
        let expected: Vec<f32> = pictures.iter().map(|p| drawn.quality(p).score).collect();
        let mut whole = Vec::new();
        for chunk in [None, Some(1), Some(7)] {
            let context = borrow(engine, chunk.map(|pictures| pictures * 4 * 45 * 38));
            let mut evaluator = drawn.evaluator(&context);
            let imported = import(&evaluator, &texture, 40, red(ENCODED));
            for count in [1, 2, 3, 7, 8, 39, 40, 5] {
                let found = scores(&mut evaluator, &imported, count);
                let pairs = found.iter().zip(&expected);
                assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-4), "{chunk:?} {count}");
                if whole.len() < found.len() {
                    assert!(chunk.is_none());
                    whole = found.clone();
                }
                assert_eq!(found, whole[..found.len()], "{chunk:?} {count}");
            }
        }
        assert!(whole.windows(2).all(|pair| pair[0] != pair[1]));
    });
}

#[test]
fn small_objects_and_none_are_measured() {
    on_an_engine(|engine| {
        let context = borrow(engine, None);
        for [width, height] in [[33, 21], [1, 1]] {
            let near = |a: f32, side: u32| a.abs() < 1.1 / side as f32;
            let one =
                maps(width, height, |x, y| (near(x, width) && near(y, height)).then_some(0.3));
            assert_eq!(one.counts.object(), 1);
            let drawn = Drawn::new(engine, one);
            let mut evaluator =
                PictureEvaluator::new(&context, [width, height], Objective::default()).unwrap();
            assert_eq!(evaluator.maps().unwrap().counts.object(), 0);
            let pictures = [0.2, 0.9].map(|i| vec![i; (width * height) as usize]);
            let texture = drawn.floats(&pictures);
            let imported = import(&evaluator, &texture, 2, red(ENCODED));
            let found = scores(&mut evaluator, &imported, 2);
            assert!(found[0] == found[1] && found[0].is_finite(), "before the first view");
            drop(evaluator);

            let mut evaluator = drawn.evaluator(&context);
            for (found, picture) in evaluator.qualities(&imported, 2).unwrap().iter().zip(&pictures)
            {
                let far = difference(*found, drawn.quality(picture));
                assert!(far < 1e-5, "{width}x{height}: {far}");
            }
        }
    });
}

#[test]
fn one_pixel_of_one_layer_is_noticed() {
    on_an_engine(|engine| {
        let drawn = Drawn::new(engine, ball(45, 38));
        let context = borrow(engine, None);
        let mut evaluator = drawn.evaluator(&context);
        let mut pictures = drawn.render(&rigs(8, 4, 2, LightKind::POINT));
        let mut look = |pictures: &[Vec<f32>]| {
            let texture = drawn.floats(pictures);
            let imported = import(&evaluator, &texture, 4, red(ENCODED));
            let layers: Vec<_> =
                (0..4).map(|layer| evaluator.inspect(&imported, layer).unwrap()).collect();
            (scores(&mut evaluator, &imported, 4), layers)
        };
        let before = look(&pictures);
        let find = |kind| drawn.maps.types.iter().position(|&t| t == kind).unwrap();
        pictures[2][find(PixelType::Surface)] += 0.1;
        pictures[1][find(PixelType::Background)] += 0.5;
        let after = look(&pictures);
        for layer in 0..4 {
            let (a, b) = (&before.1[layer], &after.1[layer]);
            let changed = a.picture.iter().zip(&b.picture).filter(|(a, b)| a != b).count();
            assert_eq!(changed, usize::from(layer == 2), "layer {layer}");
            assert_eq!(before.0[layer] != after.0[layer], layer == 2, "layer {layer}");
            assert_eq!((before.0[layer], after.0[layer]), (a.score, b.score));
        }
    });
}

/// The engine renders, which is a copy here, into layers that klieg may be reading still; klieg measures
/// them from `first` on.
struct Rendered<'a> {
    evaluator: &'a mut PictureEvaluator,
    drawn: &'a Drawn<'a>,
    texture: &'a Texture<'a>,
    surface: ImportedSurface,
    imported: ImportedPictures,
}

impl<'a> Rendered<'a> {
    fn new(
        evaluator: &'a mut PictureEvaluator,
        drawn: &'a Drawn<'a>,
        texture: &'a Texture<'a>,
        layers: u32,
    ) -> Self {
        let surface = drawn.surface(evaluator);
        let image = EngineImage { view: texture.view, layout: vk::ImageLayout::GENERAL };
        // SAFETY: every frame leaves the layers in this layout to compute shaders.
        let imported = unsafe { evaluator.import_pictures(image, layers, red(ENCODED)) }.unwrap();
        Self { evaluator, drawn, texture, surface, imported }
    }

    fn frame(
        &mut self,
        pictures: &HostBuffer<'_>,
        first: u32,
        count: u32,
        target: ScoreTarget,
    ) -> Frame<'a> {
        let read = (vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_READ);
        Frame::record(self.drawn.engine, |cmd| {
            self.texture.overwrite(cmd, pictures, read, vk::ImageLayout::GENERAL);
            // SAFETY: the frames are waited for before anything is dropped.
            unsafe {
                self.evaluator.record_view(cmd, &self.surface, &Drawn::camera()).unwrap();
                self.evaluator.record(cmd, &self.imported, first, count, target).unwrap();
            }
        })
    }
}

#[test]
fn recorded_frames_give_the_bits_of_an_evaluation() {
    on_an_engine(|engine| {
        let drawn = Drawn::new(engine, ball(45, 38));
        // Three pictures are measured at once.
        let context = borrow(engine, Some(3 * 4 * 45 * 38));
        let mut evaluator = drawn.evaluator(&context);
        let pictures = [1, 2].map(|seed| drawn.render(&rigs(seed, 8, 2, LightKind::POINT)));
        let expected = [0, 1].map(|k| {
            let texture = drawn.floats(&pictures[k]);
            let imported = import(&evaluator, &texture, 8, red(ENCODED));
            scores(&mut evaluator, &imported, 8)
        });
        assert_ne!(expected[0], expected[1]);
        let uploads =
            pictures.map(|p| HostBuffer::filled(engine, bytemuck::cast_slice(&p.concat())));
        let texture = drawn.layers(vk::Format::R32_SFLOAT, 8, &[0; 8 * 4 * 45 * 38]);
        let buffer = HostBuffer::new(engine, 16);
        let at = |offset| ScoreTarget::Buffer { buffer: buffer.raw, offset };
        let mut rendered = Rendered::new(&mut evaluator, &drawn, &texture, 8);
        let before = context.counters();
        // Both are under way at once.
        let frames = [
            rendered.frame(&uploads[0], 0, 8, at(0)),
            rendered.frame(&uploads[1], 3, 5, at(4 * 9)),
        ];
        let mapped = rendered.frame(&uploads[0], 1, 6, ScoreTarget::Mapped);
        assert_eq!(context.counters(), before, "a recording makes nothing and reads nothing");
        frames.iter().for_each(Frame::submit);
        frames.iter().for_each(Frame::wait);
        assert_eq!(buffer.read(0, 8), expected[0]);
        assert_eq!(buffer.read(9, 5), expected[1][3..]);
        mapped.submit();
        mapped.wait();
        let mut read = [0.0; 6];
        rendered.evaluator.read_scores(&mut read).unwrap();
        assert_eq!(read[..], expected[0][1..7]);
    });
}

#[test]
fn what_is_not_there_is_refused() {
    on_an_engine(|engine| {
        let drawn = Drawn::new(engine, ball(20, 10));
        let context = borrow(engine, None);
        let mut evaluator = drawn.evaluator(&context);
        let texture = drawn.floats(&vec![vec![0.5; 200]; 4]);
        let image = EngineImage { view: texture.view, layout: SAMPLED };
        // SAFETY: nothing is recorded with it.
        let none = unsafe { evaluator.import_pictures(image, 0, red(ENCODED)) };
        assert!(none.err().unwrap().to_string().contains("without layers"));
        let imported = import(&evaluator, &texture, 4, red(ENCODED));
        assert!(evaluator.read_scores(&mut [0.0]).is_err());
        evaluator.reserve(3).unwrap();
        Frame::record(engine, |cmd| {
            for (first, count, fits) in [
                (0, 3, true),
                (1, 3, true),
                (4, 0, true),
                (2, 3, false),
                (0, 4, false),
                (5, 0, false),
            ] {
                // SAFETY: the frame is never submitted.
                let made =
                    unsafe { evaluator.record(cmd, &imported, first, count, ScoreTarget::Mapped) };
                assert_eq!(made.is_ok(), fits, "{count} from {first}");
            }
            // SAFETY: as above.
            let made =
                unsafe { evaluator.record(cmd, &imported, u32::MAX, 2, ScoreTarget::Mapped) };
            assert!(made.is_err());
        });
        let fault = evaluator.evaluate(&imported, 5, &mut [0.0; 5]).unwrap_err();
        assert!(fault.is_input() && fault.to_string().contains("4 layers"), "{fault}");
        assert!(evaluator.evaluate(&imported, 2, &mut [0.0; 3]).is_err());
        assert!(evaluator.inspect(&imported, 4).is_err());
        evaluator.evaluate(&imported, 0, &mut []).unwrap();
        assert!(evaluator.qualities(&imported, 0).unwrap().is_empty());
        let others = borrow(engine, None);
        let fault = drawn.evaluator(&others).evaluate(&imported, 1, &mut [0.0]).unwrap_err();
        assert!(fault.to_string().contains("another context"), "{fault}");
    });
}

#[test]
fn pictures_of_another_size_are_refused() {
    on_an_engine(|engine| {
        let context = borrow(engine, None);
        let (small, large) = (Drawn::new(engine, ball(9, 7)), Drawn::new(engine, ball(33, 21)));
        let picture = vec![0.0; 9 * 7];
        let texture = small.floats(&[picture]);
        let pictures = import(&small.evaluator(&context), &texture, 1, red(ENCODED));
        let error = large.evaluator(&context).evaluate(&pictures, 1, &mut [0.0]);
        let error = error.expect_err("pictures of 9x7").to_string();
        assert!(error.contains("pictures of 9x7 for an evaluator of 33x21"), "{error}");
    });
}
