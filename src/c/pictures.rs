//! Level 3: pictures that an engine has rendered.

use super::context::klieg_context;
use super::edge::{Fault, Opaque, Outcome, body, call, choice, destroy, make, room};
use super::error::klieg_status;
use super::evaluator::{EvaluatorBody, Level, klieg_evaluator, target};
use super::settings::{as_objective_of_pictures, klieg_objective, klieg_quality, write_qualities};
use super::surface::{as_image, klieg_image};
use crate::gpu::{ImportedPictures, PictureEvaluator};
use crate::scene::engine::{PictureChannels, PictureEncoding, PictureFormat};
use ash::vk;

/// An engine's pictures as an evaluator reads them. They may outlive the evaluator.
pub struct klieg_pictures(());

impl Opaque for klieg_pictures {
    type Body = ImportedPictures;
}

/// How the colours of an engine's pictures are encoded: one of `KLIEG_ENCODING_...`.
pub type klieg_encoding = i32;
/// Linear radiance, of which 1 is the brightest that is shown: what float images hold, and what images of an
/// sRGB format give.
pub const KLIEG_ENCODING_LINEAR: klieg_encoding = 0;
/// sRGB-encoded: what 8-bit images of a plain format hold.
pub const KLIEG_ENCODING_SRGB: klieg_encoding = 1;

/// Which components of an engine's pictures count: one of `KLIEG_CHANNELS_...`.
pub type klieg_channels = i32;
/// Red, green and blue, with Rec. 709 primaries.
pub const KLIEG_CHANNELS_RGB: klieg_channels = 0;
/// The first alone, a luminance.
pub const KLIEG_CHANNELS_RED: klieg_channels = 1;

/// Makes an evaluator of level 3, for pictures of `width` by `height` pixels. It needs a surface and a view
/// of it as level 2 does (`klieg_surface_create`, `klieg_evaluator_record_view`): before the first view
/// its picture is empty. `objective` may be `NULL`, for the defaults. Pictures do not tell the irradiance: terms
/// that need it do not count where their weights are those of the defaults. Any thread.
///
/// `KLIEG_ERROR_ARGUMENT` for such terms with other weights above 0, and for a picture larger than the device can
/// take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_of_pictures(
    context: *const klieg_context,
    width: u32,
    height: u32,
    objective: *const klieg_objective,
    evaluator: *mut *mut klieg_evaluator,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(evaluator, || {
            let context = &body(context, "context")?.context;
            let objective = as_objective_of_pictures(objective)?;
            let made = PictureEvaluator::new(context, [width, height], objective)?;
            Ok(EvaluatorBody::new(Level::Pictures(Box::new(made))))
        })
    }
}

/// Takes an engine's pictures in, for evaluators of this context: once for each layered image that the
/// engine renders into. klieg reads them by texel fetch, so that any float, normalised or sRGB format will
/// do. The thread that uses the evaluator.
///
/// `image` is a two-dimensional array view of `layers` layers of the evaluator's size, on the context's
/// device; it stays alive as long as the handle is used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_pictures_create(
    evaluator: *const klieg_evaluator,
    image: klieg_image,
    layers: u32,
    encoding: klieg_encoding,
    channels: klieg_channels,
    pictures: *mut *mut klieg_pictures,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the image.
    unsafe {
        make(pictures, || {
            let Level::Pictures(evaluator) = &body(evaluator, "evaluator")?.level else {
                return Err(no_pictures());
            };
            let image =
                as_image(image).ok_or_else(|| Fault::argument("there is no image of pictures"))?;
            let encodings = [PictureEncoding::Linear, PictureEncoding::Encoded];
            let kinds = [PictureChannels::Rgb, PictureChannels::Red];
            let format = PictureFormat {
                encoding: choice(&encodings, encoding, "encoding")?,
                channels: choice(&kinds, channels, "channels")?,
            };
            Ok(evaluator.import_pictures(image, layers, format)?)
        })
    }
}

/// Ends the pictures, not their image; `NULL` is left alone. No recording with them may be in use.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_pictures_destroy(pictures: *mut klieg_pictures) {
    // SAFETY: the caller's handle.
    unsafe { destroy(pictures) };
}

/// Records the evaluation of `count` pictures from layer `first` on, which show the view that was recorded
/// last. `commands`, `buffer` and `offset` as for `klieg_evaluator_record`; evaluator and pictures
/// outlive its submissions. The image's state as for `klieg_evaluator_record_view`.
///
/// `KLIEG_ERROR_ARGUMENT` for layers that are not there, and for more pictures than
/// `klieg_evaluator_reserve` has made room for.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_record_pictures(
    evaluator: *mut klieg_evaluator,
    commands: vk::CommandBuffer,
    pictures: *const klieg_pictures,
    first: u32,
    count: u32,
    buffer: vk::Buffer,
    offset: vk::DeviceSize,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the commands and the image.
    unsafe {
        call(evaluator, |evaluator| {
            let pictures = body(pictures, "pictures")?;
            let target = target(buffer, offset);
            Ok(of_pictures(evaluator)?.record(commands, pictures, first, count, target)?)
        })
    }
}

/// Evaluates the first `count` pictures and waits for the scores: lower is better. The image's state as for
/// `klieg_evaluator_record_view`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_evaluate_pictures(
    evaluator: *mut klieg_evaluator,
    pictures: *const klieg_pictures,
    count: u32,
    scores: *mut f32,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the image.
    unsafe {
        call(evaluator, |evaluator| {
            let pictures = body(pictures, "pictures")?;
            let scores = room(scores, count as usize, "scores")?;
            Ok(of_pictures(evaluator)?.evaluate(pictures, count, scores)?)
        })
    }
}

/// As `klieg_evaluator_evaluate_pictures`, with the terms of each picture beside its score.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_evaluator_qualities_of_pictures(
    evaluator: *mut klieg_evaluator,
    pictures: *const klieg_pictures,
    count: u32,
    qualities: *mut klieg_quality,
) -> klieg_status {
    // SAFETY: the caller's pointers, and his promises for the image.
    unsafe {
        call(evaluator, |evaluator| {
            let pictures = body(pictures, "pictures")?;
            let to = room(qualities, count as usize, "qualities")?;
            write_qualities(to, &of_pictures(evaluator)?.qualities(pictures, count)?);
            Ok(())
        })
    }
}

fn of_pictures(evaluator: &mut EvaluatorBody) -> Outcome<&mut PictureEvaluator> {
    match &mut evaluator.level {
        Level::Pictures(evaluator) => Ok(evaluator),
        _ => Err(no_pictures()),
    }
}

fn no_pictures() -> Fault {
    Fault::argument("this evaluator measures lights, not pictures")
}
