//! The genetic search in steps: an engine advances it a little every frame.

use super::{Batch, Genetic, GeneticSettings, Optimizer, Progress, progress};
use crate::evaluate::Evaluator;
use crate::lighting::genome::Genome;
use crate::lighting::start::{self, StartSettings};
use crate::lighting::{Population, Rig};
use crate::math::frame::Frame;
use crate::math::range::Range;
use crate::{Error, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::time::{Duration, Instant};

/// A genetic search that its caller advances.
///
/// Either [`Designer::advance`] or [`Designer::advance_for`] evaluates at once, or the caller takes the
/// population from [`Designer::ask`], has it evaluated, and brings the scores to [`Designer::tell`] in
/// the same or a later frame. In whatever steps a search is advanced, its results are the bits of
/// [`optimize::run`](super::run) with the same seed and start.
///
/// When the view or the scene has changed, the scores hold no more: see [`Designer::follow`] and
/// [`Designer::renew`]. The scores of a population that was asked for before must not be told after.
///
/// ```
/// use glam::{DMat4, DVec3};
/// use klieg::cpu::{self, CpuEvaluator};
/// use klieg::lighting::genome::{Boxes, Genome};
/// use klieg::lighting::shading::Shading;
/// use klieg::lighting::start::StartSettings;
/// use klieg::lighting::{LightKind, Role};
/// use klieg::objective::Objective;
/// use klieg::optimize::{Designer, GeneticSettings};
/// use klieg::scene::build::{MeshData, SceneBuilder};
/// use klieg::scene::view::{Camera, Projection, View};
///
/// // A tetrahedron, as an engine might hold it.
/// let positions = [[1., 1., 1.], [-1., -1., 1.], [-1., 1., -1.], [1., -1., -1.]];
/// let indices = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
/// let mut builder = SceneBuilder::default();
/// let mesh = builder.add_mesh(&MeshData {
///     positions: &positions,
///     indices: Some(&indices),
///     ..MeshData::default()
/// })?;
/// builder.add_instance("tetrahedron", mesh, DMat4::IDENTITY)?;
/// let scene = builder.finish("example")?;
///
/// let lens = Projection::Perspective { yfov: 0.7 };
/// let camera = Camera::look_at(DVec3::new(1.0, 2.0, 6.0), DVec3::ZERO, DVec3::Y, lens)?;
/// let view = View::new(&scene, camera, 64, 64)?;
/// let (objective, shading) = (Objective::default(), Shading::default());
/// let maps = cpu::maps(cpu::visibility::draw(&scene, &view), &objective);
/// let mut evaluator = CpuEvaluator::new(maps, &view, objective, shading);
///
/// let genome = Genome::new(&[Role::Key, Role::Fill], LightKind::POINT, &Boxes::default())?;
/// let start = StartSettings::default();
/// let mut designer = Designer::new(genome, GeneticSettings::endless(), start, None, 1)?;
/// let first = designer.advance(&mut evaluator, 1)?;
/// let later = designer.advance(&mut evaluator, 9)?;
/// assert_eq!(later.generation, 10);
/// assert!(later.best <= first.best);
/// let (rig, score) = designer.best().expect("it has been advanced");
/// assert_eq!((rig.len(), score), (2, later.best));
/// # Ok::<(), klieg::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Designer {
    search: Genetic,
    batch: Batch,
    best: Option<(Vec<f32>, f32)>,
    progress: Progress,
}

impl Designer {
    /// A search whose first population `start` spreads around the chromosome `first`.
    ///
    /// `first` comes from [`start::first`] or [`start::first_of_surface`] (k-means of the normals) or
    /// from [`start::from_rig`] (given lights); `None` is the middle of every range.
    ///
    /// The search ends only where `settings` say so, with `generations` or `patience`: both count from
    /// the last [`Designer::follow`] or [`Designer::renew`], which wake a search that has ended.
    /// [`GeneticSettings::endless`] never ends; the plain defaults do, after 100 generations.
    ///
    /// # Errors
    /// [`Error::Argument`] for a setting out of its range, and for a first individual of another
    /// number of alleles or outside its box.
    pub fn new(
        genome: Genome,
        settings: GeneticSettings,
        start: StartSettings,
        first: Option<Vec<f32>>,
        seed: u64,
    ) -> Result<Self> {
        settings.check()?;
        start.check()?;
        let bounds = genome.bounds();
        let first = first.unwrap_or_else(|| bounds.iter().map(Range::middle).collect());
        check(bounds, &first)?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let population = start::population(bounds, first, settings.population, &start, &mut rng);
        let search = Genetic::new(bounds, population, settings, rng)?;
        let mut batch = Batch::new(&genome)?;
        batch.fill(search.ask());
        let nothing = f32::INFINITY;
        let (best, mean, worst) = (nothing, nothing, nothing);
        let progress = Progress { generation: 0, evaluations: 0, best, mean, worst };
        Ok(Self { search, batch, best: None, progress })
    }

    /// The codec of the search.
    pub fn genome(&self) -> &Genome {
        &self.batch.genome
    }

    /// The rigs whose scores the search wants next, [`GeneticSettings::population`] at most; none when
    /// it has ended.
    pub fn ask(&self) -> &Population {
        &self.batch.population
    }

    /// The lights of [`Designer::ask`], rig after rig, for those who render them.
    pub fn rigs(&self) -> impl Iterator<Item = Rig> {
        self.search.ask().iter().map(|chromosome| self.batch.genome.decode(chromosome))
    }

    /// Takes the scores of [`Designer::ask`], in order.
    ///
    /// # Errors
    /// [`Error::Argument`] for another number of scores or one that is not a number.
    pub fn tell(&mut self, scores: &[f32]) -> Result<Progress> {
        let (given, wanted) = (scores.len(), self.ask().len());
        if given != wanted {
            return Err(Error::Argument(format!("{given} scores for a population of {wanted}")));
        }
        if let Some(at) = scores.iter().position(|score| score.is_nan()) {
            return Err(Error::Argument(format!("score {at} is not a number")));
        }
        if wanted > 0 {
            self.search.tell(scores);
            self.count(wanted);
        }
        Ok(self.progress)
    }

    /// Evaluates so many generations, or fewer where the search ends.
    ///
    /// # Errors
    /// What the evaluator reports; the generation is then asked for again.
    pub fn advance(
        &mut self,
        evaluator: &mut dyn Evaluator,
        generations: usize,
    ) -> Result<Progress> {
        for _ in 0..generations {
            if self.ask().is_empty() {
                break;
            }
            let scores = self.batch.evaluate(evaluator)?;
            let count = scores.len();
            self.search.tell(scores);
            self.count(count);
        }
        Ok(self.progress)
    }

    /// Evaluates generations for about `budget` of wall time. The first is always made, so that the
    /// search progresses; another only where it ends within the budget if it takes as long as the one
    /// before it. So the budget is exceeded by less than one generation.
    ///
    /// # Errors
    /// As [`Designer::advance`].
    pub fn advance_for(
        &mut self,
        evaluator: &mut dyn Evaluator,
        budget: Duration,
    ) -> Result<Progress> {
        let start = Instant::now();
        self.advance_until(evaluator, budget, &|| start.elapsed())
    }

    /// As [`Designer::advance_for`], with the time since its beginning from `elapsed`.
    fn advance_until(
        &mut self,
        evaluator: &mut dyn Evaluator,
        budget: Duration,
        elapsed: &dyn Fn() -> Duration,
    ) -> Result<Progress> {
        let mut begun = Duration::ZERO;
        loop {
            let progress = self.advance(evaluator, 1)?;
            let now = elapsed();
            let last = now.saturating_sub(begun);
            if self.ask().is_empty() || now + last > budget {
                return Ok(progress);
            }
            begun = now;
        }
    }

    /// The best rig of the last generation and its `F`; `None` before the first scores. Between
    /// [`Designer::follow`] or [`Designer::renew`] and the next scores it is the one from before, where
    /// it stands now, with the score that it had.
    pub fn best(&self) -> Option<(Rig, f32)> {
        self.best.as_ref().map(|(chromosome, score)| (self.batch.genome.decode(chromosome), *score))
    }

    /// How the search stood after the last generation. Before the first it is generation 0, with
    /// infinite scores.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Goes on in the light frame `to`: the camera has moved, or the scene's centre or radius has.
    ///
    /// The lights of the present generation stay where they are in the world, each value moved to the
    /// nearest one of its box, and are all scored anew. Intensities stay as they are. Where both frames
    /// are the same nothing happens: a scene that has changed within its frame needs
    /// [`Designer::renew`].
    ///
    /// # Errors
    /// [`Error::Argument`] for a frame without finite axes, centre and positive radius.
    pub fn follow(&mut self, from: &Frame, to: &Frame) -> Result<()> {
        from.check()?;
        to.check()?;
        if from == to {
            return Ok(());
        }
        let genome = &self.batch.genome;
        let moved = |chromosome: Vec<f32>| {
            let rig = genome.decode(&chromosome);
            genome.encode(&rig.iter().map(|light| light.moved(from, to)).collect::<Rig>())
        };
        self.search.renew(moved);
        self.best = self.best.take().map(|(chromosome, score)| (moved(chromosome), score));
        self.batch.genome.follow(from, to);
        self.batch.fill(self.search.ask());
        Ok(())
    }

    /// Goes on from the present generation as it stands, all of it scored anew: the scene, or what the
    /// evaluator measures, has changed.
    pub fn renew(&mut self) {
        self.search.renew(|chromosome| chromosome);
        self.batch.fill(self.search.ask());
    }

    /// Takes note of a generation.
    fn count(&mut self, evaluations: usize) {
        let Progress { generation, evaluations: before, .. } = self.progress;
        self.progress = progress(&self.search, generation + 1, before + evaluations);
        self.best = self.search.best().map(|(chromosome, score)| (chromosome.to_vec(), score));
        self.batch.fill(self.search.ask());
    }
}

/// # Errors
/// [`Error::Argument`] unless `first` has one allele for each of `bounds`, inside it.
fn check(bounds: &[Range], first: &[f32]) -> Result<()> {
    let (given, wanted) = (first.len(), bounds.len());
    if given != wanted {
        let fault = format!("a first individual of {given} alleles: the genome has {wanted}");
        return Err(Error::Argument(fault));
    }
    for (at, (range, &value)) in std::iter::zip(bounds, first).enumerate() {
        if !range.contains(value) {
            let Range { low, high } = range;
            let fault =
                format!("allele {at} of the first individual is {value}: it is {low} to {high}");
            return Err(Error::Argument(fault));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
