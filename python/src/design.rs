//! Designs.

use crate::device::Device;
use crate::error::{OrRaise as _, refused};
use crate::light::Light;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::view::View;
use klieg::design::Outcome;
use klieg::lighting::Rig;
use klieg::lighting::presets::Preset;
use klieg::objective::Quality;
use klieg::report::Staging;
use klieg::report::json;
use klieg::scene::lit;
use klieg::scene::load::LoadOptions;
use klieg::scene::view;
use klieg::session::device::{self, Opened};
use klieg::session::{self, Loaded, Session, announce, config, designer, picture};
use numpy::{IntoPyArray as _, PyArray3, PyArrayMethods as _};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use tempfile::TempDir;

/// How a search stands after a generation.
#[pyclass(frozen, get_all, module = "klieg._klieg", skip_from_py_object)]
#[derive(Clone)]
pub struct Progress {
    /// Number of the generation, from 1.
    generation: usize,
    /// How many there will be at most; nothing where the search does not count them.
    generations: Option<usize>,
    /// Evaluations so far.
    evaluations: usize,
    /// Lowest score so far.
    best: f32,
    /// Mean score of the generation.
    mean: f32,
    /// Highest score of the generation.
    worst: f32,
    /// The scores are of pictures of every `step`-th pixel along both sides, 1 for whole ones.
    step: u32,
}

impl Progress {
    fn new(progress: &klieg::design::Progress, generations: Option<usize>) -> Self {
        let &klieg::design::Progress { generation, evaluations, best, mean, worst, step } =
            progress;
        Self { generation, generations, evaluations, best, mean, worst, step }
    }
}

/// What a search found.
#[pyclass(frozen, module = "klieg._klieg")]
pub struct Design {
    loaded: Loaded,
    options: Option<LoadOptions>,
    /// Keeps the file of a scene that was given as bytes.
    _folder: Option<Arc<TempDir>>,
    view: view::View,
    settings: config::Settings,
    device: Opened,
    outcome: Outcome,
    /// The headlight, with the lights that are kept.
    headlight: Rig,
    result: json::Design,
}

/// The caller of a search: hears of every generation, and may end it.
struct Listener {
    progress: Option<Py<PyAny>>,
    generations: Option<usize>,
    /// What the caller raised.
    raised: Option<PyErr>,
}

impl Listener {
    /// A signal, as of Ctrl-C, and a callback that returns `False` end the search with its best, and so does
    /// whatever the callback raises.
    fn hear(&mut self, progress: &klieg::design::Progress) -> ControlFlow<()> {
        let told = Python::attach(|py| -> PyResult<bool> {
            py.check_signals()?;
            let Some(callback) = &self.progress else { return Ok(true) };
            let answer = callback.call1(py, (Progress::new(progress, self.generations),))?;
            Ok(answer.is_none(py) || answer.is_truthy(py)?)
        });
        match told {
            Ok(true) => return ControlFlow::Continue(()),
            Ok(false) => {}
            Err(raised) => {
                let interrupt =
                    Python::attach(|py| raised.is_instance_of::<PyKeyboardInterrupt>(py));
                self.raised = (!interrupt).then_some(raised);
            }
        }
        ControlFlow::Break(())
    }
}

/// Searches lights. `progress` is called with a `Progress` after every generation.
#[pyfunction]
pub fn design(
    py: Python<'_>,
    scene: &Scene,
    view: &View,
    settings: &Settings,
    device: Option<&Device>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Design> {
    let begin = Instant::now();
    let generations = (settings.0.optimizer.0.generations)(&settings.0.optimizers());
    let mut listener = Listener { progress, generations, raised: None };
    let opened = device.map(|device| &device.0);
    let mut make = |settings: config::Settings| {
        let opened = match opened {
            Some(opened) => opened.clone(),
            None => device::open(&settings.device, &settings)?,
        };
        let parts = (scene.loaded.clone(), view.0.clone());
        let mut session = Session::of_view(&opened, parts, settings, begin)?;
        announce(&session.evaluator);
        let genome = session.settings.genome()?;
        let outcome = designer::search(&mut session, &genome, None, &mut |p| listener.hear(p))?;
        let result = designer::result(&mut session, &outcome)?;
        let headlight = session.with_kept(Preset::Headlight.rig());
        Ok(Design {
            loaded: scene.loaded.clone(),
            options: scene.options.clone(),
            _folder: scene.folder.clone(),
            view: session.view,
            settings: session.settings,
            device: opened,
            outcome,
            headlight,
            result,
        })
    };
    let asked = settings.0.steered().or_raise()?;
    let made = py.detach(|| match opened {
        Some(_) => make(asked),
        None => device::or_cpu(asked, make),
    });
    match listener.raised {
        Some(raised) => Err(raised),
        None => made.or_raise(),
    }
}

type Named = (f32, Vec<(&'static str, f32)>);

fn named(quality: &Quality) -> Named {
    (quality.score, quality.terms.iter().map(|(term, value)| (term.name, value)).collect())
}

type Course = Vec<(usize, usize, f32, f32, f32, u32)>;

#[pymethods]
impl Design {
    /// The best rig.
    #[getter]
    fn lights(&self) -> Vec<Light> {
        Light::rig(&self.outcome.rig, &self.view)
    }

    /// Score and terms of the best rig.
    #[getter]
    fn quality(&self) -> Named {
        named(&self.result.quality)
    }

    /// The same of the headlight.
    #[getter]
    fn headlight(&self) -> Named {
        named(&self.result.headlight)
    }

    /// Whether it was ended before its time.
    #[getter]
    fn stopped(&self) -> bool {
        self.outcome.stopped
    }

    /// Generation, evaluations, best, mean and worst score, and of every how manieth pixel the pictures are.
    fn history(&self) -> Course {
        let entry = |p: &klieg::design::Progress| {
            (p.generation, p.evaluations, p.best, p.mean, p.worst, p.step)
        };
        self.outcome.history.iter().map(entry).collect()
    }

    /// What `result.json` says.
    fn json(&self) -> PyResult<String> {
        json::text(&self.result).or_raise()
    }

    /// The final picture, of another size where one is given, `uint8[rows, columns, 4]`.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        headlight: bool,
        size: Option<(u32, u32)>,
        samples: Option<u32>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let picture = py.detach(|| self.drawn(headlight, size, samples)).or_raise()?;
        let shape = [picture.image.height() as usize, picture.image.width() as usize, 4];
        picture.image.into_raw().into_pyarray(py).reshape(shape)
    }

    /// The same as a PNG file.
    fn png<'py>(
        &self,
        py: Python<'py>,
        headlight: bool,
        size: Option<(u32, u32)>,
        samples: Option<u32>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let png = py.detach(|| -> anyhow::Result<Vec<u8>> {
            let picture = self.drawn(headlight, size, samples)?;
            Ok(klieg::report::picture::final_png(&picture.image)?)
        });
        Ok(PyBytes::new(py, &png.or_raise()?))
    }

    /// The lit scene.
    fn glb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let (path, options) = self.file()?;
        let glb =
            py.detach(|| lit::glb(path, options, &self.view, &self.outcome.rig)).or_raise()?;
        Ok(PyBytes::new(py, &glb))
    }

    /// Writes the lit scene.
    fn save_gltf(&self, py: Python<'_>, out: PathBuf) -> PyResult<()> {
        let (path, options) = self.file()?;
        py.detach(|| lit::write(path, options, &self.view, &self.outcome.rig, &out)).or_raise()
    }

    /// Writes all files that `klieg design` writes; gives their paths.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
        self.file()?;
        py.detach(|| -> anyhow::Result<Vec<PathBuf>> {
            let inputs = session::inputs(&self.loaded.scene, None);
            inputs.spare(&folder, designer::FILES)?;
            let mut staging = Staging::new(&folder)?.sparing(inputs);
            let parts = (self.loaded.clone(), self.view.clone());
            let begin = Instant::now();
            let mut session = Session::of_view(&self.device, parts, self.settings.clone(), begin)?;
            designer::write(&mut session, (&self.outcome, None), &mut staging)?;
            Ok(staging.publish()?)
        })
        .or_raise()
    }
}

impl Design {
    /// The scene's file, and how it is loaded.
    fn file(&self) -> PyResult<(&std::path::Path, LoadOptions)> {
        let options = self.options.clone().ok_or_else(|| {
            refused(
                "the scene was made of arrays: there is no file to put lights in; load one, or take \
                 Scene.from_trimesh",
            )
        })?;
        Ok((&self.loaded.scene.path, options))
    }

    fn drawn(
        &self,
        headlight: bool,
        size: Option<(u32, u32)>,
        samples: Option<u32>,
    ) -> klieg::Result<klieg::render::Picture> {
        let (width, height) = size.unwrap_or((self.view.width, self.view.height));
        let scene = &self.loaded.scene;
        let view = view::View::new(scene, self.view.camera.clone(), width, height)?;
        let mut settings = self.settings.clone();
        settings.picture.samples = samples.unwrap_or(settings.picture.samples);
        let rig = if headlight { &self.headlight } else { &self.outcome.rig };
        let occluders = picture::occluders(scene, &view, &settings)?;
        let drawn = picture::draw((scene, &view), occluders.as_ref(), &settings, &[rig])?;
        drawn.into_iter().next().ok_or_else(|| klieg::Error::Argument("no rig was drawn".into()))
    }
}
