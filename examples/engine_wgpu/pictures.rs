//! klieg judges the engine's own pictures: the engine draws the world under every rig that klieg asks
//! for, with its own lighting, and a frame is a generation.

use crate::design::{self, FRAMES, PROFILE, RIGS, SIZE, Scored, Stage};
use crate::renderer::LIGHTS;
use crate::{Result, handover, picture, surface};
use ash::vk;
use glam::Vec3;
use klieg::cpu::fitness;
use klieg::gpu::{Context, EngineImage, PictureEvaluator, ScoreTarget};
use klieg::lighting::Population;
use klieg::math::color::{luminance, srgb_decode, srgb_encode};
use klieg::objective::Objective;
use klieg::objective::maps::{Maps, PixelType};
use klieg::scene::engine::{PictureEncoding, PictureFormat};
use std::sync::Arc;

/// Designs over some frames. Returns the scores of the last generation by klieg, and by the plain stages
/// on the pictures that were read back.
pub fn design(stage: &Stage<'_>, context: &Arc<Context>) -> Result<Vec<Scored>> {
    let (gpu, renderer, objective) = (stage.gpu, stage.renderer, (PROFILE.objective)());
    let mut klieg = PictureEvaluator::new(context, SIZE, objective)?;
    klieg.reserve(RIGS)?;
    let layout = vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL;
    let array = EngineImage { view: handover::raw_view(&renderer.codes)?, layout };
    // SAFETY: wgpu's views are of the borrowed device and of this size, and outlive the evaluator.
    let (seen, pictures) = unsafe {
        let images = surface::images(&renderer.gbuffer)?;
        let seen = klieg.import_surface(&images, &surface::format())?;
        // Drivers may decode sRGB formats roughly: klieg reads the codes, and decodes them itself.
        let format = PictureFormat { encoding: PictureEncoding::Encoded, ..Default::default() };
        (seen, klieg.import_pictures(array, RIGS, format)?)
    };
    let mut designer = design::designer()?;
    let first = designer.ask().clone();
    let (camera, told) = stage.camera(0);
    let frame = told.view(SIZE[0], SIZE[1])?.frame;
    let mut scores = Vec::new();
    for number in 0..FRAMES {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if number == 0 {
            renderer.draw_gbuffer(gpu, &mut encoder, &camera);
        }
        let rigs: Vec<_> = designer.ask().rigs().map(|rig| design::lights(rig, &frame)).collect();
        renderer.draw_pictures(gpu, &mut encoder, &camera, &rigs);
        // SAFETY: the commands before draw the images and share them; the queue is waited for before
        // the evaluator is used in another way.
        let (measuring, ()) = handover::record(gpu, |cmd| unsafe {
            if number == 0 {
                klieg.record_view(cmd, &seen, &told)?;
            }
            klieg.record(cmd, &pictures, 0, rigs.len() as u32, ScoreTarget::Mapped)
        })?;
        gpu.queue.submit([encoder.finish(), measuring]);
        gpu.wait()?;
        scores.resize(rigs.len(), 0.0);
        klieg.read_scores(&mut scores)?;
        let progress = designer.tell(&scores)?;
        println!("pictures: frame {number}, generation {}: {}", progress.generation, progress.best);
    }
    let scored = |(layer, score)| Ok([score, native(stage, klieg.maps()?, &objective, layer)?]);
    let scored = (0..).zip(scores).map(scored).collect::<Result<_>>()?;
    let (best, _) = designer.best().ok_or("no rig")?;
    let best = Population::of([&best[..]])?;
    stage.save("pictures", &camera, &frame, [&first.records()[..LIGHTS], best.records()])?;
    Ok(scored)
}

/// The score of a picture of the engine's, read back, by the plain stages.
fn native(stage: &Stage<'_>, maps: &Maps, objective: &Objective, layer: u32) -> Result<f32> {
    let bytes = picture::read(stage.gpu, &stage.renderer.pictures, layer)?;
    let texels = bytes.chunks_exact(4).zip(&maps.types);
    let brightness = |(texel, &kind): (&[u8], &PixelType)| {
        if kind == PixelType::Background {
            return 0.0;
        }
        let color = [0, 1, 2].map(|channel| srgb_decode(f32::from(texel[channel]) / 255.0));
        srgb_encode(luminance(Vec3::from(color)))
    };
    let picture: Vec<f32> = texels.map(brightness).collect();
    Ok(objective.quality(&fitness::statistics(maps, &picture, objective), &maps.statistics()).score)
}
