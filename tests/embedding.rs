//! The Rust of `docs/EMBEDDING.md`, as an engine runs it: `tests/documents.rs` holds the page to it.

#![allow(clippy::undocumented_unsafe_blocks, reason = "the page says what an engine owes")]

use drawn::{Drawn, on_an_engine};
use engine::{ALL, Engine, Frame, HostBuffer};
use glam::{DMat4, DVec3};
use klieg::ash::vk;
use klieg::design::Designer;
use klieg::gpu::{BorrowedDevice, Context, EngineImage, Needs, SurfaceImages, Tuning};
use klieg::lighting::Role;
use klieg::scene::Material;
use klieg::scene::engine::{PictureChannels, PictureEncoding, PictureFormat, SurfaceFormat};
use klieg::scene::view::Projection;
use klieg_support::{drawn, engine, gpu as support};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::error::Error;
use std::sync::Arc;

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// What an engine does with its commands.
fn submit_and_wait(frame: &Frame<'_>) {
    frame.submit();
    frame.wait();
}

/// Commands that an engine records and klieg adds to.
fn recorded(
    engine: &Engine,
    add: impl FnOnce(vk::CommandBuffer) -> klieg::Result<()>,
) -> klieg::Result<Frame<'_>> {
    let mut added = Ok(());
    let frame = Frame::record(engine, |cmd| added = add(cmd));
    added.map(|()| frame)
}

fn borrow(engine: &Engine) -> Outcome<(ash::Device, Vec<u8>)> {
    let (instance, physical, queue_family) = (&engine.instance, engine.physical, engine.family);
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(0).queue_priorities(&[1.0])];
    let mut create_info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);

    use klieg::gpu::{BorrowedDevice, Context, EnabledFeatures, FeatureChain, Needs, Tuning};

    // When the engine creates its device. Levels 2 and 3 need nothing: skip this for `Needs::COMPUTE`.
    let needs = Needs { scene: true, layers: false };
    let mut chain = FeatureChain::new(needs.requirements().features);
    unsafe { chain.fill(&mut create_info)? };
    let features = unsafe { EnabledFeatures::of(&create_info) };
    let device = unsafe { instance.create_device(physical, &create_info, None)? };

    // Later, once.
    let queue = unsafe { device.get_device_queue(queue_family, 0) };
    let borrowed = BorrowedDevice {
        instance: instance.clone(),
        api_version: vk::API_VERSION_1_2,
        debug_utils: false,
        physical,
        device: device.clone(),
        queue,
        queue_family,
        features,
        queue_lock: None,
        allocator: None,
    };
    let context = unsafe { Context::borrow(borrowed, needs, &Tuning::default())? };

    drop(context);
    Ok((device, keep_pipelines(engine.lend(), needs)?))
}

fn keep_pipelines(borrowed: BorrowedDevice, needs: Needs) -> Outcome<Vec<u8>> {
    let file = std::env::temp_dir().join(format!("klieg-page-{}", std::process::id()));

    let pipeline_cache = std::fs::read(&file).unwrap_or_default();
    let tuning = Tuning { pipeline_cache, ..Tuning::default() };
    let context = unsafe { Context::borrow(borrowed, needs, &tuning)? };
    // At the end, or once the first generation has run:
    std::fs::write(&file, context.pipeline_cache_data()?)?;

    let stored = std::fs::read(&file)?;
    std::fs::remove_file(&file)?;
    Ok(stored)
}

#[test]
fn a_device_is_lent_and_its_pipelines_are_kept() {
    let engine = Engine::new(ALL);
    let (device, stored) = borrow(&engine).unwrap();
    assert!(!stored.is_empty());
    // SAFETY: klieg's objects on it have gone.
    unsafe { device.destroy_device(None) };
    assert_eq!(engine.end(), [""; 0]);
}

fn level_1(context: Arc<Context>) -> Outcome<f32> {
    let (material, world, seed) = (Material::default(), DMat4::IDENTITY, 7);
    let positions: &[[f32; 3]] = &[[1., 1., 1.], [-1., -1., 1.], [-1., 1., -1.], [1., -1., -1.]];
    let indices: &[u32] = &[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let (eye, target) = (DVec3::new(3.0, 2.5, 5.0), DVec3::ZERO);
    let lens = Projection::Perspective { yfov: 0.7 };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);

    use klieg::design::{Designer, profile, start};
    use klieg::evaluate::Evaluator as _;
    use klieg::gpu::GpuEvaluator;
    use klieg::objective::shadows::ShadowSettings;
    use klieg::scene::build::{MeshData, SceneBuilder};
    use klieg::scene::view::{Camera, View};
    use std::time::Duration;

    let mut builder = SceneBuilder::default();
    let material = Some(builder.add_material(material)?);
    let mesh = MeshData { positions, indices: Some(indices), material, ..MeshData::default() };
    let mesh = builder.add_mesh(&mesh)?;
    builder.add_instance("statue", mesh, world)?;
    let scene = builder.finish("the engine's scene")?;
    let view = View::new(&scene, Camera::look_at(eye, target, DVec3::Y, lens)?, 512, 512)?;
    let natural = profile::DEFAULT;
    let both = ((natural.objective)(), (natural.shading)());
    let shadows = ShadowSettings { on: natural.shadows, ..ShadowSettings::default() };
    let mut evaluator = GpuEvaluator::with_shadows(&context, &scene, &view, both, &shadows)?;

    let genome = natural.genome()?; // a key and a fill light; Genome::new for other roles
    let first = start::first(&scene, &view, evaluator.maps()?, &genome, &mut rng);
    let search = natural.optimizer.name; // "shade"; "ga" for the paper's, or any other
    let mut designer = Designer::new(genome, search, &natural.endless(), Some(first), seed)?;
    designer.advance_for(&mut evaluator, Duration::from_millis(4))?; // each frame
    let (rig, score) = designer.best().ok_or("no generation yet")?;

    assert_eq!(rig.iter().map(|light| light.role).collect::<Vec<_>>(), [Role::Key, Role::Fill]);
    Ok(score)
}

#[test]
fn klieg_draws_the_engine_s_scene() {
    let context = support::context();
    let score = level_1(context.clone()).unwrap();
    assert!((0.0..1.0).contains(&score), "{score}");
    support::assert_valid(&context);
}

fn a_designer() -> Outcome<Designer> {
    let natural = klieg::design::profile::DEFAULT;
    let search = natural.optimizer.name;
    Ok(Designer::new(natural.genome()?, search, &natural.endless(), None, 7)?)
}

fn level_2(engine: &Engine, drawn: &Drawn<'_>) -> Outcome<f32> {
    let (context, [width, height]) = (drawn::borrow(engine, None), drawn.size());
    let SurfaceImages { depth, normal, ids, .. } = drawn.images;
    let (base_color, roughness_metallic) = (None, None);
    let (format, camera) = (SurfaceFormat::default(), Drawn::camera());
    let mut designer = a_designer()?;
    let target = HostBuffer::new(engine, 64);
    let (buffer, offset) = (target.raw, 0);

    use klieg::design::profile;
    use klieg::gpu::{ScoreTarget, SurfaceEvaluator};

    let natural = profile::DEFAULT;
    let (objective, shading) = ((natural.objective)(), (natural.shading)());
    let mut klieg = SurfaceEvaluator::new(&context, [width, height], objective, shading)?;
    klieg.evaluator().reserve(30, 2)?;
    let emissive = None;
    let images = SurfaceImages { depth, normal, base_color, roughness_metallic, emissive, ids };
    let surface = unsafe { klieg.import(&images, &format)? };

    let frame = recorded(engine, |cmd| {
        // In the frame, after the G-buffer pass and a barrier to COMPUTE_SHADER.
        unsafe {
            klieg.record_view(cmd, &surface, &camera)?;
            // designer.follow(&old_frame, &klieg.view().unwrap().frame)? where the camera has moved
            let scores = ScoreTarget::Buffer { buffer, offset };
            klieg.evaluator().record(cmd, designer.ask(), scores)?;
        }
        Ok(())
    })?;
    submit_and_wait(&frame);
    let scores = target.read(0, designer.ask().len());

    // After the frame's fence.
    designer.tell(&scores)?;

    Ok(designer.best().ok_or("no scores")?.1)
}

#[test]
fn klieg_shades_the_engine_s_surface() {
    on_an_engine(|engine| {
        let score = level_2(engine, &Drawn::new(engine, support::ball(64, 48))).unwrap();
        assert!((0.0..1.0).contains(&score), "{score}");
    });
}

fn level_3(engine: &Engine, drawn: &Drawn<'_>) -> Outcome<f32> {
    let (context, [width, height]) = (drawn::borrow(engine, None), drawn.size());
    let (images, format, camera) = (drawn.images, SurfaceFormat::default(), Drawn::camera());
    let mut designer = a_designer()?;
    let rigs = designer.ask().len() as u32;
    let texture = drawn.floats(&drawn.render(&designer.rigs().collect::<Vec<_>>()));
    let array = EngineImage { view: texture.view, layout: drawn::SAMPLED };
    let picture_format =
        PictureFormat { encoding: PictureEncoding::Encoded, channels: PictureChannels::Red };
    let target = HostBuffer::new(engine, 64);
    let (buffer, offset) = (target.raw, 0);

    use klieg::design::profile;
    use klieg::gpu::{PictureEvaluator, ScoreTarget};

    let mut objective = (profile::DEFAULT.objective)();
    // Pictures do not tell the irradiance.
    objective.weights = objective.weights.filter(|term| !term.needs.irradiance);
    let mut klieg = PictureEvaluator::new(&context, [width, height], objective)?;
    klieg.reserve(rigs)?;
    let surface = unsafe { klieg.import_surface(&images, &format)? };
    let pictures = unsafe { klieg.import_pictures(array, rigs, picture_format)? };

    let frame = recorded(engine, |cmd| {
        // In the frame, when the engine has rendered a layer for each rig of designer.rigs().
        unsafe {
            klieg.record_view(cmd, &surface, &camera)?;
            let scores = ScoreTarget::Buffer { buffer, offset };
            klieg.record(cmd, &pictures, 0, rigs, scores)?;
        }
        Ok(())
    })?;
    submit_and_wait(&frame);
    designer.tell(&target.read(0, rigs as usize))?;
    Ok(designer.best().ok_or("no scores")?.1)
}

#[test]
fn klieg_judges_the_engine_s_pictures() {
    on_an_engine(|engine| {
        let score = level_3(engine, &Drawn::new(engine, support::ball(64, 48))).unwrap();
        assert!((0.0..1.0).contains(&score), "{score}");
    });
}

fn other_objective() -> klieg::Result<()> {
    use klieg::objective::Term;

    let mut objective = (klieg::design::profile::DEFAULT.objective)();
    objective.weights.set(Term::named("relief")?, 0.2)?;

    assert_eq!(objective.weights.get("relief"), Some(0.2));
    Ok(())
}

#[test]
fn another_objective_is_weighed() {
    other_objective().unwrap();
}
