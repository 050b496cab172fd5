//! Evaluators.

use crate::device::Device;
use crate::error::{OrRaise as _, refused};
use crate::light::{self, Light};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::view::View;
use klieg::lighting::genome::Genome;
use klieg::lighting::{Population, Rig};
use klieg::objective::Quality;
use klieg::session::{Session, announce, designer, device};
use numpy::{
    Element, IntoPyArray as _, PyArray1, PyArray2, PyArray3, PyArrayMethods as _, PyReadonlyArray1,
    PyReadonlyArray2, PyReadonlyArray3,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// What measures lights in a view.
#[pyclass(frozen, module = "klieg._klieg")]
pub struct Evaluator {
    session: Mutex<Session>,
    /// The lights that are searched.
    genome: Genome,
    /// The same with those of the scene that are kept.
    complete: Genome,
}

type Terms<'py> = Vec<(&'static str, Bound<'py, PyArray1<f32>>)>;
type Clusters<'py> = (Bound<'py, PyArray2<u8>>, Vec<[f32; 3]>);
type Inspected<'py> = (f32, Vec<(&'static str, f32)>, Bound<'py, PyArray2<f32>>);

/// An array of a picture's shape.
pub fn plane<'py, T: Element>(
    py: Python<'py>,
    values: Vec<T>,
    [height, width]: [usize; 2],
) -> PyResult<Bound<'py, PyArray2<T>>> {
    values.into_pyarray(py).reshape([height, width])
}

/// The same with three values a pixel.
fn vectors<'py>(
    py: Python<'py>,
    values: &[[f32; 3]],
    [height, width]: [usize; 2],
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    values.as_flattened().to_vec().into_pyarray(py).reshape([height, width, 3])
}

impl Evaluator {
    /// Does `work` on the session, while other threads of Python go on.
    fn on<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Session) -> anyhow::Result<T> + Send,
    ) -> PyResult<T> {
        let locked = || self.session.lock().unwrap_or_else(PoisonError::into_inner);
        py.detach(|| work(&mut locked())).or_raise()
    }

    fn scores<'py>(
        &self,
        py: Python<'py>,
        population: &Population,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let mut scores = vec![0.0; population.len()];
        let scores = self.on(py, |session| {
            session.evaluator.evaluate(population, &mut scores)?;
            Ok(scores)
        })?;
        Ok(scores.into_pyarray(py))
    }

    fn with_kept(&self, py: Python<'_>, rig: Rig) -> PyResult<Rig> {
        self.on(py, |session| Ok(session.with_kept(rig)))
    }

    /// The rigs of an array, with the lights that are kept.
    fn of_array(
        &self,
        py: Python<'_>,
        lights: &PyReadonlyArray3<'_, f32>,
        kind: &str,
        roles: Option<Vec<String>>,
    ) -> PyResult<Population> {
        let kept = self.with_kept(py, Rig::new())?;
        light::population(lights, (kind, roles), &kept)
    }
}

#[pymethods]
impl Evaluator {
    #[new]
    fn new(
        py: Python<'_>,
        scene: &Scene,
        view: &View,
        settings: &Settings,
        device: Option<&Device>,
    ) -> PyResult<Self> {
        let (loaded, view) = (&scene.loaded, &view.0);
        let begin = Instant::now();
        let session = py.detach(|| match device {
            Some(Device(opened)) => {
                let parts = (loaded.clone(), view.clone());
                Session::of_view(opened, parts, settings.0.clone(), begin)
            }
            None => device::or_cpu(settings.0.clone(), |settings| {
                let opened = device::open(&settings.device, &settings)?;
                let session =
                    Session::of_view(&opened, (loaded.clone(), view.clone()), settings, begin)?;
                announce(&session.evaluator);
                Ok(session)
            }),
        });
        let session = session.or_raise()?;
        let genome = settings.0.genome().or_raise()?;
        let complete = session.complete(&genome).or_raise()?;
        Ok(Self { session: Mutex::new(session), genome, complete })
    }

    /// Name, kind and driver of what computes.
    fn device(&self, py: Python<'_>) -> PyResult<(String, &'static str, String)> {
        self.on(py, |session| {
            let info = session.evaluator.device();
            Ok((info.name.clone(), info.kind, info.driver.clone()))
        })
    }

    /// Scores of `float32[rigs, lights, columns]`.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        lights: PyReadonlyArray3<'py, f32>,
        kind: &str,
        roles: Option<Vec<String>>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let population = self.of_array(py, &lights, kind, roles)?;
        self.scores(py, &population)
    }

    /// Scores of chromosomes `float32[rigs, genes]`.
    fn evaluate_genes<'py>(
        &self,
        py: Python<'py>,
        genes: PyReadonlyArray2<'py, f32>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let mut population = Population::new(self.complete.rig_lights()).or_raise()?;
        for chromosome in genes.as_array().outer_iter() {
            let rig = self.decoded(&chromosome.to_vec())?;
            population.push(&rig).or_raise()?;
        }
        self.scores(py, &population)
    }

    /// Scores of rigs.
    fn evaluate_rigs<'py>(
        &self,
        py: Python<'py>,
        rigs: Vec<Vec<PyRef<'py, Light>>>,
    ) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let kept = self.with_kept(py, Rig::new())?;
        let complete = |rig: &Vec<_>| [light::rig(rig), kept.clone()].concat();
        let rigs: Vec<Rig> = rigs.iter().map(complete).collect();
        let population = Population::of(rigs.iter().map(Vec::as_slice)).or_raise()?;
        self.scores(py, &population)
    }

    /// The terms of `float32[rigs, lights, columns]`, an array for each.
    fn terms<'py>(
        &self,
        py: Python<'py>,
        lights: PyReadonlyArray3<'py, f32>,
        kind: &str,
        roles: Option<Vec<String>>,
    ) -> PyResult<Terms<'py>> {
        let population = self.of_array(py, &lights, kind, roles)?;
        let found: Vec<Quality> =
            self.on(py, |session| Ok(session.evaluator.qualities(&population)?))?;
        let names: Vec<_> = found.first().map_or(Vec::new(), |q| q.terms.names().collect());
        let column = |(at, name): (usize, &'static str)| {
            let values = found.iter().filter_map(|quality| quality.terms.values().nth(at));
            (name, values.collect::<Vec<f32>>().into_pyarray(py))
        };
        Ok(names.into_iter().enumerate().map(column).collect())
    }

    /// Score, terms and the picture that was judged of one rig.
    fn inspect<'py>(
        &self,
        py: Python<'py>,
        rig: Vec<PyRef<'py, Light>>,
    ) -> PyResult<Inspected<'py>> {
        let rig = self.with_kept(py, light::rig(&rig))?;
        let (found, shape) = self.on(py, |session| {
            let shape = [session.view.height as usize, session.view.width as usize];
            Ok((session.evaluator.inspect(&rig)?, shape))
        })?;
        let terms = found.terms.iter().map(|(term, value)| (term.name, value)).collect();
        Ok((found.score, terms, plane(py, found.picture, shape)?))
    }

    /// The final picture of a rig, `uint8[rows, columns, 4]`.
    fn picture<'py>(
        &self,
        py: Python<'py>,
        rig: Vec<PyRef<'py, Light>>,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let rig = self.with_kept(py, light::rig(&rig))?;
        let image = self.on(py, |session| {
            let view = session.view.clone();
            Ok(session.render(&view, &[&rig])?.swap_remove(0).image)
        })?;
        let shape = [image.height() as usize, image.width() as usize, 4];
        image.into_raw().into_pyarray(py).reshape(shape)
    }

    /// Every map of the view.
    fn maps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let maps = self.on(py, |session| Ok(session.evaluator.maps()?.clone()))?;
        let surface = maps.surface;
        let shape = [surface.height as usize, surface.width as usize];
        let types = maps.types.iter().map(|&kind| kind as u8).collect();
        let all = PyDict::new(py);
        all.set_item("code", plane(py, surface.code, shape)?)?;
        all.set_item("types", plane(py, types, shape)?)?;
        for (name, values) in [
            ("depth", surface.depth),
            ("metallic", surface.metallic),
            ("roughness", surface.roughness),
            ("sobel", maps.sobel),
            ("laplace", maps.laplace),
            ("normal_gradient", maps.normal_gradient),
        ] {
            all.set_item(name, plane(py, values, shape)?)?;
        }
        for (name, values) in [
            ("position", &surface.position),
            ("normal", &surface.normal),
            ("face", &surface.face),
            ("base_color", &surface.base_color),
            ("emissive", &surface.emissive),
        ] {
            all.set_item(name, vectors(py, values, shape)?)?;
        }
        Ok(all)
    }

    /// The cluster of each pixel's polygon from 1 on, 0 in the background; and the clusters' directions.
    fn clusters<'py>(&self, py: Python<'py>, count: usize) -> PyResult<Clusters<'py>> {
        if !(1..=usize::from(u8::MAX)).contains(&count) {
            return Err(refused(format!("{count} clusters: there must be 1 to 255")));
        }
        let (labels, directions, shape) = self.on(py, |session| {
            let clustering = session.clusters(count)?;
            let maps = session.evaluator.maps()?;
            let label = |code: &u32| {
                let at = maps.visible.binary_search(code).ok();
                at.map_or(0, |at| clustering.labels[at] as u8 + 1)
            };
            let labels: Vec<u8> = maps.surface.code.iter().map(label).collect();
            let directions = clustering.clusters.iter().map(|c| c.direction.to_array()).collect();
            let shape = [maps.surface.height as usize, maps.surface.width as usize];
            Ok((labels, directions, shape))
        })?;
        Ok((plane(py, labels, shape)?, directions))
    }

    /// Lowest and highest value of each gene.
    fn bounds(&self) -> Vec<(f32, f32)> {
        self.genome.bounds().iter().map(|range| (range.low, range.high)).collect()
    }

    /// Role, number among the lights, and name of each gene.
    fn genes(&self) -> Vec<(&'static str, usize, &'static str)> {
        let light = |(at, role): (usize, &klieg::lighting::Role)| {
            let name = role.name();
            self.genome.alleles(at).map(move |allele| (name, at, allele.name)).collect::<Vec<_>>()
        };
        self.genome.roles().iter().enumerate().flat_map(light).collect()
    }

    /// The rig of a chromosome, with the lights that are kept.
    fn decode(&self, py: Python<'_>, genes: PyReadonlyArray1<'_, f32>) -> PyResult<Vec<Light>> {
        let rig = self.decoded(&genes.as_array().to_vec())?;
        self.on(py, |session| Ok(Light::rig(&rig, &session.view)))
    }

    /// Where a search begins.
    fn start<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let genes = self.on(py, |session| designer::beginning(session, &self.genome))?;
        Ok(genes.into_pyarray(py))
    }
}

impl Evaluator {
    fn decoded(&self, genes: &[f32]) -> PyResult<Rig> {
        let (given, wanted) = (genes.len(), self.complete.bounds().len());
        if given != wanted {
            return Err(refused(format!("{given} genes: a rig has {wanted}")));
        }
        if genes.iter().any(|gene| !gene.is_finite()) {
            return Err(refused("a gene is not finite"));
        }
        Ok(self.complete.decode(genes))
    }
}
