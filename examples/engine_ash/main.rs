//! A program on Vulkan that lets klieg design its lights.
//!
//! It has an instance, a device, a queue, a scene and a frame loop with two frames in flight, all its
//! own and headless; klieg borrows the device. At level 1 klieg draws the scene itself, from the
//! engine's arrays; at level 2 it measures the engine's G-buffer. The validation layer watches both.
//!
//! `cargo run --example engine_ash -- FOLDER` leaves pictures in the folder: under a headlight, and
//! under the lights of each level. The exit code is 0 when all that it claims holds.

mod passes;
mod renderer;
mod vulkan;
mod world;

use image::{Rgb, RgbImage};
use klieg::design::profile::{PAPER, Profile};
use klieg::design::{Designer, start};
use klieg::evaluate::{Evaluator, Inspection};
use klieg::glam::Vec3;
use klieg::gpu::{
    Context, ContextOptions, DeviceChoice, EngineImage, GpuEvaluator, ImportedSurface, Needs,
    ScoreTarget, SurfaceEvaluator, SurfaceImages, Tuning,
};
use klieg::lighting::genome::Genome;
use klieg::lighting::presets::Preset;
use klieg::lighting::{Light, Population, Role};
use klieg::math::color::{luminance, srgb_decode, srgb_encode};
use klieg::math::frame::Frame;
use klieg::optimize::Settings;
use klieg::rand::SeedableRng;
use klieg::rand::rngs::StdRng;
use klieg::scene::Scene;
use klieg::scene::engine::{EngineCamera, SurfaceFormat};
use klieg::scene::view::View;
use renderer::{LightUniform, Renderer};
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, PoisonError};
use std::time::Duration;
use vulkan::{Gpu, Messages};
use world::World;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The engine shades with Blinn-Phong and has no shadows, as this profile has it.
const PROFILE: &Profile = &PAPER;
const SIZE: [u32; 2] = [192, 144];
const ROLES: [Role; 3] = [Role::Key, Role::Fill, Role::Rim];
const SEED: u64 = 1;
/// Frames of each design whose evaluations are recorded, and of the one with a budget.
const FRAMES: u32 = 48;
const BUDGET_FRAMES: u32 = 8;
const BUDGET: Duration = Duration::from_millis(20);
/// What the camera turns in a frame, radians.
const TURN: f64 = 0.008;

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1) else {
        eprintln!("usage: engine_ash FOLDER");
        return ExitCode::from(2);
    };
    let messages = Arc::<Messages>::default();
    let outcome = run(&messages, Path::new(&folder));
    // The device is gone now, so that the layer has said all.
    let mut faults = std::mem::take(&mut *messages.lock().unwrap_or_else(PoisonError::into_inner));
    faults.extend(outcome.err().map(|error| error.to_string()));
    for fault in &faults {
        eprintln!("engine_ash: {fault}");
    }
    if faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn run(messages: &Arc<Messages>, folder: &Path) -> Result<()> {
    let needs = Needs { scene: true, layers: false };
    let gpu = Gpu::new(messages, needs)?;
    // SAFETY: the context, declared after the device, goes before it; the features are enabled.
    let context = unsafe { Context::borrow(gpu.lend(), needs, &Tuning::default())? };
    let world = World::new();
    let scene = world.scene()?;
    println!("{} triangles on {}", scene.polygons(), context.report().info.name);
    let resting = world::camera(&scene, 0.0, SIZE)?;
    let view = View::new(&scene, world::lens(&resting)?, SIZE[0], SIZE[1])?;

    // All that frames use of klieg's is declared before the renderer, which waits for them as it goes.
    let (objective, shading) = ((PROFILE.objective)(), (PROFILE.shading)());
    let mut whole = GpuEvaluator::new(&context, &scene, &view, objective, shading)?;
    let mut seen = SurfaceEvaluator::new(&context, SIZE, objective, shading)?;
    let surface;
    let mut renderer = Renderer::new(&gpu, &world, SIZE)?;
    surface = import(&renderer, &seen)?;

    std::fs::create_dir_all(folder)?;
    let headlight = Preset::Headlight.rig();
    let show = |renderer: &mut Renderer, rig: &[Light], frame, name| -> Result<RgbImage> {
        let drawn = renderer.begin(&resting)?;
        let slot = drawn.slot;
        renderer.end(drawn, &lights(rig, frame))?;
        let picture = renderer.picture(slot)?;
        picture.save(folder.join(name))?;
        Ok(picture)
    };
    show(&mut renderer, &headlight, &view.frame, "before.png")?;

    let (designer, measured) = level_1(&mut renderer, &mut whole, &scene, &view, &resting)?;
    let first = designer.best().ok_or("level 1 made no design")?.0;
    let shown = show(&mut renderer, &first, &view.frame, "level_1.png")?;
    shown_is_judged("level 1", &shown, &whole.inspect(&first)?)?;

    let mut designer = level_2(&mut renderer, &mut seen, &surface, &scene)?;
    level_2_in_budget(&mut renderer, &mut seen, &surface, &scene, &mut designer)?;
    let second = designer.best().ok_or("level 2 made no design")?.0;
    let shown = show(&mut renderer, &second, &frame_of(&seen)?, "level_2.png")?;
    shown_is_judged("level 2", &shown, &seen.evaluator().inspect(&second)?)?;

    same_bits_on_a_device_of_its_own(&context, &scene, &view, &measured)?;
    same_scores_on_both_levels(&mut seen, &measured)?;
    better_than_the_headlight("level 1", &mut whole, &headlight, &first)?;
    better_than_the_headlight("level 2", seen.evaluator(), &headlight, &second)
}

/// What a recorded evaluation gave.
struct Measured {
    population: Population,
    scores: Vec<f32>,
}

/// klieg draws the engine's arrays; the engine records the evaluation of a generation into every second
/// frame and tells the scores when the frame has run, while the next one does.
fn level_1(
    renderer: &mut Renderer,
    klieg: &mut GpuEvaluator,
    scene: &Scene,
    view: &View,
    camera: &EngineCamera,
) -> Result<(Designer, Vec<Measured>)> {
    let genome = genome()?;
    let first = start::first(scene, view, klieg.maps()?, &genome, &mut StdRng::seed_from_u64(SEED));
    let mut designer = designer(genome, first)?;
    klieg.reserve(designer.ask().len() as u32, ROLES.len())?;
    let (mut measured, mut running) = (vec![], None);
    for _ in 0..FRAMES {
        let frame = renderer.begin(camera)?;
        if running == Some(frame.slot) {
            let population = designer.ask().clone();
            let mut scores = vec![0.0; population.len()];
            klieg.read_scores(&mut scores)?;
            designer.tell(&scores)?;
            measured.push(Measured { population, scores });
            running = None;
        }
        if running.is_none() {
            // SAFETY: the frame is outside its passes; `klieg` lives until all frames have run.
            unsafe { klieg.record(frame.cmd, designer.ask(), ScoreTarget::Mapped)? };
            running = Some(frame.slot);
        }
        renderer.end(frame, &best_lights(&designer, &view.frame))?;
    }
    renderer.finish()?;
    println!("level 1: {}", said(&designer));
    Ok((designer, measured))
}

/// klieg measures what the engine draws, from a camera that moves: the lights stay where they are in the
/// world, and scores are those of the view that was recorded before them.
fn level_2(
    renderer: &mut Renderer,
    klieg: &mut SurfaceEvaluator,
    surface: &ImportedSurface,
    scene: &Scene,
) -> Result<Designer> {
    // A first look, for a start by the normals that are seen.
    let camera = moving_camera(scene, 0)?;
    let frame = renderer.begin(&camera)?;
    renderer.end(frame, &[])?;
    // SAFETY: no recording of klieg's runs, and the frame before has left the images readable.
    unsafe { klieg.look(surface, &camera)? };
    let (genome, mut rng) = (genome()?, StdRng::seed_from_u64(SEED));
    let first = start::first_of_surface(klieg.evaluator().maps()?, &genome, &mut rng);
    let mut designer = designer(genome, first)?;
    klieg.evaluator().reserve(designer.ask().len() as u32, ROLES.len())?;
    let mut running = None;
    for number in 0..FRAMES {
        let camera = moving_camera(scene, number)?;
        let frame = renderer.begin(&camera)?;
        if running == Some(frame.slot) {
            designer.tell(&renderer.scores(frame.slot, designer.ask().len()))?;
            running = None;
        }
        if running.is_none() {
            let before = frame_of(klieg)?;
            let target = ScoreTarget::Buffer { buffer: frame.scores, offset: 0 };
            // SAFETY: the frame is outside its passes, and the G-buffer pass has made its images
            // visible to compute shaders; all outlive the frames.
            unsafe {
                klieg.record_view(frame.cmd, surface, &camera)?;
                designer.follow(&before, &frame_of(klieg)?)?;
                klieg.evaluator().record(frame.cmd, designer.ask(), target)?;
            }
            running = Some(frame.slot);
        }
        renderer.end(frame, &best_lights(&designer, &frame_of(klieg)?))?;
    }
    renderer.finish()?;
    if let Some(slot) = running {
        designer.tell(&renderer.scores(slot, designer.ask().len()))?;
    }
    println!("level 2: {}", said(&designer));
    Ok(designer)
}

/// The same without a recording: after each frame klieg takes some time of its own.
fn level_2_in_budget(
    renderer: &mut Renderer,
    klieg: &mut SurfaceEvaluator,
    surface: &ImportedSurface,
    scene: &Scene,
    designer: &mut Designer,
) -> Result<()> {
    for number in FRAMES..FRAMES + BUDGET_FRAMES {
        let camera = moving_camera(scene, number)?;
        let before = frame_of(klieg)?;
        let frame = renderer.begin(&camera)?;
        renderer.end(frame, &best_lights(designer, &before))?;
        // SAFETY: no recording of klieg's runs; its commands follow the frame that draws the images.
        unsafe { klieg.look(surface, &camera)? };
        designer.follow(&before, &frame_of(klieg)?)?;
        designer.advance_for(klieg.evaluator(), BUDGET)?;
    }
    println!("level 2, {} ms a frame: {}", BUDGET.as_millis(), said(designer));
    Ok(())
}

/// The engine's G-buffer as klieg is to read it.
fn import(renderer: &Renderer, klieg: &SurfaceEvaluator) -> Result<ImportedSurface> {
    let layout = renderer::SAMPLED;
    let [depth, normal, _, roughness_metallic, ids] =
        renderer.g_buffer.map(|image| EngineImage { view: image.view, layout });
    // klieg decodes sRGB by the formula; drivers may be content with less, as lavapipe is.
    let base_color = EngineImage { view: renderer.encoded_colors, layout };
    let images = SurfaceImages {
        depth,
        normal: Some(normal),
        base_color: Some(base_color),
        roughness_metallic: Some(roughness_metallic),
        emissive: None,
        ids: Some(ids),
    };
    let format = SurfaceFormat {
        base_color_encoded: true,
        cleared_depth: 0.0,
        roughness_channel: 0,
        metallic_channel: 1,
        ..SurfaceFormat::default()
    };
    // SAFETY: the views are of this device and size, and live as long as it does.
    Ok(unsafe { klieg.import(&images, &format)? })
}

/// klieg on a device of its own gives the bits that it recorded for the engine.
fn same_bits_on_a_device_of_its_own(
    context: &Context,
    scene: &Scene,
    view: &View,
    measured: &[Measured],
) -> Result<()> {
    let device = DeviceChoice::Name(context.report().info.name.clone());
    let options = ContextOptions { device, validation: true, ..Default::default() };
    let own = Context::new(&options)?;
    let (objective, shading) = ((PROFILE.objective)(), (PROFILE.shading)());
    let mut klieg = GpuEvaluator::new(&own, scene, view, objective, shading)?;
    for (number, Measured { population, scores }) in measured.iter().enumerate() {
        let mut expected = vec![0.0; scores.len()];
        klieg.evaluate(population, &mut expected)?;
        let bits = |scores: &[f32]| scores.iter().map(|s| s.to_bits()).collect::<Vec<_>>();
        if bits(scores) != bits(&expected) {
            return Err(format!("generation {number}: {scores:?}, alone {expected:?}").into());
        }
    }
    if let Some(message) = own.validation_messages().first() {
        return Err(message.clone().into());
    }
    println!("level 1 alone: the same bits in {} generations", measured.len());
    Ok(())
}

/// Both levels show the same scene, so their scores agree but for what the G-buffer's formats round. Here
/// these are the normals, at half precision, for all else of a material has 8 bits from the beginning.
/// A colour that is rounded would move all of an even floor to other bins of the histogram.
fn same_scores_on_both_levels(klieg: &mut SurfaceEvaluator, measured: &[Measured]) -> Result<()> {
    let mut far = 0.0_f32;
    for Measured { population, scores } in measured {
        let mut others = vec![0.0; scores.len()];
        klieg.evaluator().evaluate(population, &mut others)?;
        far = std::iter::zip(scores, &others).map(|(a, b)| (a - b).abs()).fold(far, f32::max);
    }
    println!("levels 1 and 2: scores differ by {far:.1e} at most");
    // A difference that is no number is none below the bound.
    if far < 1e-3 { Ok(()) } else { Err(format!("the levels' scores differ by {far}").into()) }
}

/// The engine shades as klieg does, so its picture has the brightness that klieg has judged, pixel by
/// pixel: nothing is mirrored, and every light stands where it should.
fn shown_is_judged(level: &str, shown: &RgbImage, judged: &Inspection) -> Result<()> {
    let far = |(pixel, &judged): (&Rgb<u8>, &f32)| {
        let color = Vec3::from(pixel.0.map(|byte| srgb_decode(f32::from(byte) / 255.0)));
        (srgb_encode(luminance(color)) - judged).abs()
    };
    // klieg's background is black.
    let pixels = shown.pixels().zip(&judged.picture).filter(|&(_, &judged)| judged > 0.0);
    let (sum, count) = pixels.map(far).fold((0.0, 0), |(sum, n), far| (sum + far, n + 1));
    let mean = sum / count as f32;
    println!("{level}: the picture is {mean:.4} from the one that was judged");
    if mean < 0.005 { Ok(()) } else { Err(format!("{level} shows another picture").into()) }
}

fn better_than_the_headlight(
    level: &str,
    klieg: &mut GpuEvaluator,
    headlight: &[Light],
    design: &[Light],
) -> Result<()> {
    let [before, after] = [klieg.inspect(headlight)?.score, klieg.inspect(design)?.score];
    println!("{level}: F {before:.4} under the headlight, {after:.4} as designed");
    if after < before { Ok(()) } else { Err(format!("{level}: the design is no better").into()) }
}

fn genome() -> Result<Genome> {
    Ok(Genome::new(&ROLES, PROFILE.kind, &(PROFILE.boxes)())?)
}

fn designer(genome: Genome, first: Vec<f32>) -> Result<Designer> {
    Ok(Designer::new(genome, "ga", &Settings::endless(), Some(first), SEED)?)
}

fn said(designer: &Designer) -> String {
    let progress = designer.progress();
    format!("F {:.4} after {} generations", progress.best, progress.generation)
}

/// The camera of frame `number`, which comes to rest in the last one.
fn moving_camera(scene: &Scene, number: u32) -> Result<EngineCamera> {
    let left = FRAMES + BUDGET_FRAMES - 1 - number;
    world::camera(scene, -TURN * f64::from(left), SIZE)
}

/// The frame in which the lights of level 2 stand.
fn frame_of(klieg: &SurfaceEvaluator) -> Result<Frame> {
    Ok(klieg.view().ok_or("klieg has seen nothing yet")?.frame)
}

/// The best lights so far, a headlight before there are any.
fn best_lights(designer: &Designer, frame: &Frame) -> Vec<LightUniform> {
    let rig = designer.best().map_or_else(|| Preset::Headlight.rig(), |(rig, _)| rig);
    lights(&rig, frame)
}

/// A rig in the world, for the engine's shaders.
fn lights(rig: &[Light], frame: &Frame) -> Vec<LightUniform> {
    let uniform = |light: &Light| LightUniform {
        place: light.to_world(frame).as_vec4().to_array(),
        diffuse: light.diffuse,
        specular: light.specular,
        reach2: (f64::from(light.distance) * frame.radius).powi(2) as f32,
        padding: 0.0,
    };
    rig.iter().map(uniform).collect()
}
