//! What every measuring command begins with, and the Python package too: settings, the scene, the view, a device and an
//! evaluator on it.

pub mod config;
pub mod designer;
pub mod device;
mod engine;
pub mod focus;
pub mod gallery;
pub mod input;
pub mod intent;
mod message;
pub mod optimizer;
pub mod painter;
pub mod picture;
pub mod pipelines;
pub mod profile;
pub mod rig;
mod strokes;
pub mod values;
mod view;
pub mod views;

pub use engine::{Engine, announce, evaluator, evaluator_on};
pub use message::message;
pub use view::{SIZE, view};

use self::config::{Settings, ViewsSettings};
use self::device::Opened;
use self::profile::ProfileName;
use self::strokes::Drawn;
use self::views::Seen;
use crate::Error;
use crate::cpu;
use crate::design::start;
use crate::lighting::clusters::Clustering;
use crate::lighting::genome::Genome;
use crate::lighting::{Light, Population, Rig};
use crate::objective::Quality;
use crate::objective::shadows::{ShadowSettings, Shadows};
use crate::render::{BACKGROUND, Picture};
use crate::report::Inputs;
use crate::report::exhibit::Studio;
use crate::report::json::{CameraRecord, Header, SceneLights, Timing, ViewRecord, ViewsRecord};
use crate::scene::load::LoadOptions;
use crate::scene::occluders::Occluders;
use crate::scene::view::View;
use crate::scene::{self, Scene};
use crate::study::Subject;
use anyhow::Result;
use image::RgbImage;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// A scene in view and what measures it.
pub struct Session {
    /// The scene, in the moment of the first view.
    pub scene: Arc<Scene>,
    /// The view, the first where there are several: rigs are told in its light frame.
    pub view: View,
    /// All views.
    pub views: Vec<Seen>,
    /// What measures, all views together.
    pub evaluator: Engine,
    /// Settings of the run.
    pub settings: Settings,
    /// Times so far.
    pub timing: Timing,
    /// The scene's own lights, where they are kept: they are part of every rig.
    kept: Rig,
    /// What evaluators are made on.
    pub device: Opened,
    /// Where highlights and shadows are to lie.
    strokes: Option<Drawn>,
    /// When the scene was there.
    begin: Instant,
}

/// A scene, and how long it took to load.
#[derive(Clone)]
pub struct Loaded {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Milliseconds.
    pub load: f64,
}

impl Loaded {
    /// Loads a scene.
    ///
    /// # Errors
    /// [`crate::Error::Input`].
    pub fn read(path: &Path, options: &LoadOptions) -> crate::Result<Self> {
        let start = Instant::now();
        let scene = Arc::new(scene::load::load_with(path, options.clone())?);
        let load = milliseconds(start);
        let (files, triangles) = (scene.files.len(), scene.polygons());
        tracing::debug!(
            "read {}: {triangles} triangles, files: {files}, in {load:.0} ms",
            path.display()
        );
        Ok(Self { scene, load })
    }
}

impl Session {
    /// Loads the scene, chooses camera and device, and makes the view's maps; on the CPU where a device fails that
    /// nobody has named.
    ///
    /// # Errors
    /// Faults of the settings, the file and the device.
    pub fn open(path: &Path, settings: Settings) -> Result<Self> {
        settings.check()?;
        let loaded = Loaded::read(path, &settings.loading())?;
        warn(&loaded.scene.warnings);
        let begin = Instant::now();
        let session = device::or_cpu(settings, |settings| {
            let device = device::open(&settings.device, &settings)?;
            Self::on(&device, loaded.clone(), settings, begin)
        })?;
        announce(&session.evaluator);
        Ok(session)
    }

    /// Makes the maps of a scene's view on an open device, with settings that have passed their
    /// check. Work on the view, the device's opening included, began at `begin`.
    ///
    /// # Errors
    /// Faults of the settings, the scene and the device.
    pub fn on(device: &Opened, loaded: Loaded, settings: Settings, begin: Instant) -> Result<Self> {
        let views = views::all(&loaded.scene, &settings)?;
        Self::of_views(device, (views, loaded.load), settings, begin)
    }

    /// As [`Session::on`], of a view that is there, whatever the settings say of it.
    ///
    /// # Errors
    /// Faults of the settings, the scene and the device.
    pub fn of_view(
        device: &Opened,
        (Loaded { scene, load }, view): (Loaded, View),
        settings: Settings,
        begin: Instant,
    ) -> Result<Self> {
        Self::of_views(device, (vec![Seen::single(scene, view)], load), settings, begin)
    }

    /// Of views, one or more, of a scene that took so long to load, milliseconds.
    fn of_views(
        device: &Opened,
        (views, load): (Vec<Seen>, f64),
        mut settings: Settings,
        begin: Instant,
    ) -> Result<Self> {
        let (scene, view) = (Arc::clone(&views[0].scene), views[0].view.clone());
        let kept = kept(&scene, &view, &settings)?;
        let evaluator = views::evaluator(device, &views, &settings, kept.len())?;
        settings.weigh_dim()?;
        let timing = Timing { load, maps: milliseconds(begin), ..Timing::default() };
        let (camera, width, height) = (&view.camera.name, view.width, view.height);
        tracing::debug!(
            "looked through {camera} at {width}x{height} pixels in {:.0} ms, the device's opening included",
            timing.maps
        );
        let device = device.clone();
        let strokes = None;
        Ok(Self { scene, view, views, evaluator, settings, timing, kept, device, strokes, begin })
    }

    /// What outputs must not replace: all files of the scene, and the configuration's, if any.
    pub fn inputs(&self, config: Option<&Path>) -> Inputs {
        inputs(&self.scene, config)
    }

    /// The times of a design that is complete.
    pub fn finish(&mut self) -> Timing {
        self.timing.total = self.timing.load + milliseconds(self.begin);
        self.timing
    }

    /// What a result of `schema` begins with.
    pub fn header(&self, schema: &'static str) -> Header {
        let ProfileName(profile) = self.settings.profile;
        Header::new(schema, profile, (&self.scene, &self.view), self.evaluator.device())
    }

    /// The genome with the lights that are kept.
    ///
    /// # Errors
    /// As [`Genome::with_fixed`].
    pub fn complete(&self, genome: &Genome) -> crate::Result<Genome> {
        genome.clone().with_fixed(&self.kept)
    }

    /// A rig with the lights that are kept.
    pub fn with_kept(&self, rig: Rig) -> Rig {
        [rig, self.kept.clone()].concat()
    }

    /// Several views with the qualities of a rig in them, and of a headlight where those are known; nothing of a single
    /// view.
    pub fn views_record(&self, rig: &[Quality], headlight: &[Quality]) -> Option<ViewsRecord> {
        let record = |(at, (seen, &quality)): (usize, (&Seen, &Quality))| ViewRecord {
            title: seen.title.clone(),
            camera: CameraRecord::new(&seen.view),
            time: seen.time,
            quality,
            headlight: headlight.get(at).copied(),
        };
        let each = self.views.iter().zip(rig).enumerate().map(record).collect();
        let ViewsSettings { rig, over, .. } = self.settings.views;
        (self.views.len() > 1).then_some(ViewsRecord { rig, over, each })
    }

    /// What became of the scene's own lights.
    pub fn scene_lights(&self) -> SceneLights {
        let count = scene::lights::own(&self.scene).count();
        SceneLights { count, kept: self.settings.lights.keep }
    }

    /// The view as studies take it.
    pub fn subject(&mut self) -> Subject<'_> {
        Subject { scene: &self.scene, view: &self.view, evaluator: &mut *self.evaluator }
    }

    /// The normals of the visible polygons in `k` clusters, as [`start::visible_clusters`].
    ///
    /// # Errors
    /// What the device reports.
    pub fn clusters(&mut self, k: usize) -> Result<Clustering> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.settings.seed);
        let maps = self.evaluator.maps()?;
        Ok(start::visible_clusters(&self.scene, &self.view, maps, k, &mut rng))
    }

    /// What casts shadows in each view, in its light frame; nothing where there are none.
    ///
    /// # Errors
    /// What the device reports.
    fn occluders(&mut self) -> crate::Result<Vec<Option<Arc<Occluders>>>> {
        self.evaluator.of_views().map(views::occluders).collect()
    }

    /// The final picture of each rig in a view of this scene through this camera.
    ///
    /// # Errors
    /// As [`picture::draw`].
    pub fn render(&mut self, view: &View, rigs: &[&[Light]]) -> Result<Vec<Picture>> {
        let shadows = self.evaluator.maps()?.shadows.as_ref();
        let occluders = shadows.map(|shadows| &**shadows.occluders());
        Ok(picture::draw((&self.scene, view), occluders, &self.settings, rigs)?)
    }

    /// The picture of a rig as the search sees it, in colour.
    ///
    /// # Errors
    /// What the device reports.
    pub fn picture(&mut self, rig: &[Light]) -> Result<RgbImage> {
        let rig = Population::of([rig])?;
        let maps = self.evaluator.maps()?;
        let shading = &self.settings.shading;
        let records = rig.records();
        Ok(cpu::population::color_picture(maps, &self.view, shading, records, BACKGROUND))
    }
}

impl Studio for Session {
    fn view(&self) -> &View {
        &self.view
    }

    fn paint(&mut self, rig: &[Light]) -> Result<RgbImage> {
        self.picture(rig)
    }

    fn judge(&mut self, rig: &[Light]) -> Result<Quality> {
        Ok(self.evaluator.inspect(rig)?.quality())
    }
}

/// Loads a scene and says what was left out of it.
///
/// # Errors
/// [`crate::Error::Input`].
pub fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let scene = scene::load::load_with(path, options.clone())?;
    warn(&scene.warnings);
    Ok(scene)
}

/// What outputs must not replace: all files of a scene, and the configuration's, if any.
pub fn inputs(scene: &Scene, config: Option<&Path>) -> Inputs {
    let files = scene.files.iter().chain(&scene.named).map(PathBuf::as_path);
    Inputs::new(files.chain(config))
}

/// Prints warnings.
pub fn warn(warnings: &[String]) {
    warnings.iter().for_each(|warning| tracing::warn!("{warning}"));
}

/// The scene's own lights, where the settings keep them.
fn kept(scene: &Scene, view: &View, settings: &Settings) -> crate::Result<Rig> {
    if !settings.lights.keep {
        return Ok(Rig::new());
    }
    let (rig, warnings) = scene::lights::own_rig(scene, view)?;
    warn(&warnings);
    Ok(rig)
}

/// Whether any object is in the picture.
///
/// # Errors
/// [`Error::Input`] when none is: there is nothing to judge.
fn sees(evaluator: &mut Engine, scene: &Scene, view: &View) -> crate::Result<()> {
    if evaluator.maps()?.counts.object() > 0 {
        return Ok(());
    }
    Err(sees_nothing(scene, view))
}

/// Tells of a shadow table that has fewer directions than were asked for.
fn note_coarse_shadows(evaluator: &mut Engine, settings: &ShadowSettings) -> crate::Result<()> {
    let asked = settings.side;
    let side = evaluator.maps()?.shadows.as_ref().map_or(asked, Shadows::side);
    if side < asked {
        warn(&[format!(
            "the shadow table has {side}x{side} directions in place of {asked}x{asked}, so as not to take more \
             than {} MiB (shadows.memory): shadows are softer",
            settings.memory
        )]);
    }
    Ok(())
}

/// The fault of a picture without any object.
pub fn sees_nothing(scene: &Scene, view: &View) -> Error {
    let camera = &view.camera.name;
    let advice = "--azimuth and --elevation look from another side, in case its surfaces face away";
    Error::input(&scene.path, format!("camera '{camera}' sees nothing of the scene: {advice}"))
}

/// Time since `start`.
pub fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// Whether what the caller gave is at fault, rather than the machine.
pub fn is_input(error: &anyhow::Error) -> bool {
    let input = |cause: &(dyn std::error::Error + 'static)| {
        cause.downcast_ref::<Error>().is_some_and(Error::is_input)
    };
    error.chain().any(input)
}

/// An error and its causes in one line; a cause that the text before it already tells is left out.
pub fn describe(error: &anyhow::Error) -> String {
    error.chain().skip(1).fold(error.to_string(), |text, cause| {
        let cause = cause.to_string();
        if text.contains(&cause) { text } else { format!("{text}: {cause}") }
    })
}
