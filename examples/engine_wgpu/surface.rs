//! klieg lights the engine's surface by itself: it is given the G-buffer of every frame, and
//! measures several generations of rigs against it.

use crate::design::{self, FRAMES, PROFILE, RIGS, SIZE, Scored, Stage};
use crate::renderer::{GBuffer, LIGHTS, Target};
use crate::world::BALLS;
use crate::{Result, handover};
use ash::vk;
use glam::Vec3;
use klieg::cpu::CpuEvaluator;
use klieg::evaluate::Evaluator;
use klieg::gpu::{
    Context, EngineImage, GpuEvaluator, ScoreTarget, SurfaceEvaluator, SurfaceImages,
};
use klieg::lighting::Population;
use klieg::lighting::shading::Shading;
use klieg::math::frame::Frame;
use klieg::objective::Objective;
use klieg::objective::maps::Surface;
use klieg::scene::engine::SurfaceFormat;
use klieg::scene::view::View;
use std::sync::Arc;

/// Generations of a frame beside the one in the engine's own commands.
const MORE: usize = 2;

/// Designs over some frames. Returns the scores of the last generation by both evaluators.
pub fn design(stage: &Stage<'_>, context: &Arc<Context>) -> Result<Vec<Scored>> {
    let (gpu, objective, shading) = (stage.gpu, (PROFILE.objective)(), (PROFILE.shading)());
    let mut klieg = SurfaceEvaluator::new(context, SIZE, objective, shading)?;
    klieg.evaluator().reserve(RIGS, LIGHTS)?;
    let images = images(&stage.renderer.gbuffer)?;
    // SAFETY: wgpu's views are of the borrowed device and of this size, and outlive the evaluator.
    let surface = unsafe { klieg.import(&images, &format()) }?;
    let mut designer = design::designer()?;
    let first = designer.ask().clone();
    for number in 0..FRAMES {
        let (camera, told) = stage.camera(number);
        if let Some(view) = klieg.view() {
            designer.follow(&view.frame, &told.view(SIZE[0], SIZE[1])?.frame)?;
        }
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        stage.renderer.draw_gbuffer(gpu, &mut encoder, &camera);
        let asked = designer.ask();
        // SAFETY: the commands before draw the G-buffer and share it; the queue is waited for before
        // the evaluator is used in another way.
        let (measuring, ()) = handover::record(gpu, |cmd| unsafe {
            klieg.record_view(cmd, &surface, &told)?;
            klieg.evaluator().record(cmd, asked, ScoreTarget::Mapped)
        })?;
        gpu.queue.submit([encoder.finish(), measuring]);
        gpu.wait()?;
        let mut scores = vec![0.0; asked.len()];
        klieg.evaluator().read_scores(&mut scores)?;
        designer.tell(&scores)?;
        let progress = designer.advance(klieg.evaluator(), MORE)?;
        println!("surface: frame {number}, generation {}: {}", progress.generation, progress.best);
    }
    let view = klieg.view().ok_or("no view")?.clone();
    let (best, _) = designer.best().ok_or("no rig")?;
    let best = Population::of([&best[..]])?;
    let (camera, _) = stage.camera(FRAMES - 1);
    stage.save("surface", &camera, &view.frame, [&first.records()[..LIGHTS], best.records()])?;
    check(klieg.evaluator(), &view, designer.ask(), (objective, shading))
}

/// The scores of some rigs, and those that the native evaluator gives them on the maps that klieg
/// made of the engine's G-buffer.
fn check(
    klieg: &mut GpuEvaluator,
    view: &View,
    rigs: &Population,
    (objective, shading): (Objective, Shading),
) -> Result<Vec<Scored>> {
    let mut scores = vec![0.0; rigs.len()];
    klieg.evaluate(rigs, &mut scores)?;
    check_balls(&klieg.maps()?.surface, &view.frame)?;
    let mut expected = vec![0.0; rigs.len()];
    CpuEvaluator::new(klieg.maps()?.clone(), view, objective, shading)?
        .evaluate(rigs, &mut expected)?;
    Ok(scores.into_iter().zip(expected).map(|(klieg, native)| [klieg, native]).collect())
}

/// # Errors
/// Unless the balls are in klieg's surface where they are in the world, and face outwards. At outlines
/// klieg turns normals a little to face the viewer.
fn check_balls(surface: &Surface, frame: &Frame) -> Result<()> {
    for ball in &BALLS {
        let of_ball = |&at: &usize| surface.code[at] == ball.object;
        let pixels: Vec<_> = (0..surface.code.len()).filter(of_ball).collect();
        let outside = pixels.iter().find(|&&at| {
            let [p, n] =
                [surface.position[at], surface.normal[at]].map(|v| Vec3::from(v).as_dvec3());
            let outwards = (frame.point_to_world(p).as_vec3() - ball.center) / ball.radius;
            outwards.distance(frame.direction_to_world(n).as_vec3()) > 0.1
        });
        if pixels.len() < 100 || outside.is_some() {
            return Err(
                format!("ball {}: {} pixels, {outside:?}", ball.object, pixels.len()).into()
            );
        }
    }
    Ok(())
}

/// The G-buffer as the engine shares it.
pub fn images(gbuffer: &GBuffer) -> Result<SurfaceImages> {
    let image = |target: &Target, layout| {
        handover::raw_view(&target.view).map(|view| EngineImage { view, layout })
    };
    let color = |target| image(target, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL).map(Some);
    Ok(SurfaceImages {
        depth: image(&gbuffer.depth, vk::ImageLayout::DEPTH_STENCIL_READ_ONLY_OPTIMAL)?,
        normal: color(&gbuffer.normal)?,
        base_color: color(&gbuffer.base_color)?,
        roughness_metallic: color(&gbuffer.roughness_metallic)?,
        emissive: None,
        ids: color(&gbuffer.objects)?,
    })
}

/// wgpu draws with a viewport of negative height; the rest of the G-buffer is klieg's default.
pub fn format() -> SurfaceFormat {
    SurfaceFormat { cleared_depth: 0.0, flipped: true, ..SurfaceFormat::default() }
}
