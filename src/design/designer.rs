//! A search in steps: an engine advances it a little every frame.

use super::{Batch, Progress, progress};
use crate::evaluate::Evaluator;
use crate::lighting::genome::Genome;
use crate::lighting::{Population, Rig};
use crate::math::frame::Frame;
use crate::math::range::Range;
use crate::optimize::{self, Optimizer, Settings, Setup};
use crate::{Error, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::time::{Duration, Instant};

/// A search that its caller advances, with any optimiser.
///
/// Either [`Designer::advance`] or [`Designer::advance_for`] evaluates at once, or the caller takes the
/// population from [`Designer::ask`], has it evaluated, and brings the scores to [`Designer::tell`] in
/// the same or a later frame. In whatever steps a search is advanced, its results are the bits of
/// [`design::run`](super::run) with the same seed and start.
///
/// When the view or the scene has changed, the scores hold no more: see [`Designer::follow`] and
/// [`Designer::renew`]. The scores of a population that was asked for before must not be told after.
///
/// ```
/// use glam::{DMat4, DVec3};
/// use klieg::cpu::{self, CpuEvaluator};
/// use klieg::design::{Designer, profile};
/// use klieg::objective::shadows::ShadowSettings;
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
/// let natural = profile::DEFAULT;
/// let (objective, shading) = ((natural.objective)(), (natural.shading)());
/// let shadows = ShadowSettings { on: true, ..ShadowSettings::default() };
/// let maps = cpu::draw(&scene, &view, &objective, (&shadows, None))?;
/// let mut evaluator = CpuEvaluator::new(maps, &view, objective, shading)?;
///
/// let search = natural.optimizer.name;
/// let mut designer = Designer::new(natural.genome()?, search, &natural.endless(), None, 1)?;
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
    search: Box<dyn Optimizer>,
    batch: Batch,
    best: Option<(Vec<f32>, f32)>,
    progress: Progress,
}

impl Designer {
    /// The search that is called `optimizer` in [`optimize::OPTIMIZERS`], from the chromosome `first`.
    ///
    /// `first` comes from [`start::first`](super::start::first) or
    /// [`start::first_of_surface`](super::start::first_of_surface) (k-means of the normals) or from
    /// [`start::from_rig`](super::start::from_rig) (given lights); `None` is the middle of every range.
    ///
    /// What ends the search, such as `generations` or `patience` of the genetic algorithm and SHADE, counts from
    /// the last [`Designer::follow`] or [`Designer::renew`], which wake a search that has ended.
    /// [`Settings::endless`] never ends it, unless it is a greedy descent on level ground; the plain
    /// defaults do.
    ///
    /// # Errors
    /// [`Error::Argument`] for an unknown name, a setting out of its range, and for a first individual
    /// of another number of alleles or outside its box.
    pub fn new(
        genome: Genome,
        optimizer: &str,
        settings: &Settings,
        first: Option<Vec<f32>>,
        seed: u64,
    ) -> Result<Self> {
        let bounds = genome.bounds();
        let first = first.unwrap_or_else(|| bounds.iter().map(Range::middle).collect());
        let rng = ChaCha8Rng::seed_from_u64(seed);
        let search = optimize::create(optimizer, Setup { bounds, first, settings, rng })?;
        Self::of(genome, search)
    }

    /// Any search, such as one that the caller has written; its chromosomes are `genome`'s.
    ///
    /// # Errors
    /// [`Error::Argument`] for a search that asks for chromosomes of another length than the genome's.
    pub fn of(genome: Genome, search: Box<dyn Optimizer>) -> Result<Self> {
        let mut batch = Batch::new(&genome)?;
        batch.fill(&*search)?;
        let nothing = f32::INFINITY;
        let (best, mean, worst) = (nothing, nothing, nothing);
        let progress = Progress { generation: 0, evaluations: 0, best, mean, worst, step: 1 };
        Ok(Self { search, batch, best: None, progress })
    }

    /// The search.
    pub fn optimizer(&self) -> &dyn Optimizer {
        &*self.search
    }

    /// The codec of the search.
    pub fn genome(&self) -> &Genome {
        self.batch.genome()
    }

    /// The rigs whose scores the search wants next; none when it has ended. Of the genetic algorithm and SHADE
    /// they are [`population`](optimize::GeneticSettings::population) at most, of greedy descents two
    /// for each allele of each start.
    pub fn ask(&self) -> &Population {
        self.batch.population()
    }

    /// The lights of [`Designer::ask`], rig after rig, for those who render them.
    pub fn rigs(&self) -> impl Iterator<Item = Rig> {
        self.search.ask().iter().map(|chromosome| self.genome().decode(chromosome))
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
            self.count(wanted)?;
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
            self.count(count)?;
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

    /// The best rig so far and its `F`; `None` before the first scores. It starts anew with the first
    /// scores after a [`Designer::follow`] or [`Designer::renew`]; until then it is the one from before,
    /// where it stands now, with the score that it had.
    pub fn best(&self) -> Option<(Rig, f32)> {
        self.best.as_ref().map(|(chromosome, score)| (self.genome().decode(chromosome), *score))
    }

    /// How the search stood after the last generation. Before the first it is generation 0, with
    /// infinite scores.
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Goes on in the light frame `to`: the camera has moved, or the scene's centre or radius has.
    ///
    /// The lights that the search holds at present stay where they are in the world, each value moved to the
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
        let genome = self.batch.genome();
        let moved = |chromosome: &[f32]| {
            let rig = genome.decode(chromosome);
            genome.encode(&rig.iter().map(|light| light.moved(from, to)).collect::<Rig>())
        };
        self.search.renew(&moved);
        self.best = self.best.take().map(|(chromosome, score)| (moved(&chromosome), score));
        self.batch.follow(from, to);
        self.batch.fill(&*self.search)
    }

    /// Goes on with what the search holds at present as it stands, all of it scored anew: the scene, or
    /// what the evaluator measures, has changed.
    ///
    /// # Errors
    /// As [`Designer::of`].
    pub fn renew(&mut self) -> Result<()> {
        self.search.renew(&|chromosome| chromosome.to_vec());
        self.batch.fill(&*self.search)
    }

    /// Goes on with what the search holds at present, all of it scored anew, as more exact scores of the same landscape
    /// come from here on: the search is no younger for it.
    ///
    /// # Errors
    /// As [`Designer::of`].
    pub fn refine(&mut self) -> Result<()> {
        self.search.refine();
        self.batch.fill(&*self.search)
    }

    /// Takes note of a generation.
    fn count(&mut self, evaluations: usize) -> Result<()> {
        let Progress { generation, evaluations: before, .. } = self.progress;
        self.progress = progress(&*self.search, (generation + 1, before + evaluations), 1);
        self.best = self.search.best().map(|(chromosome, score)| (chromosome.to_vec(), score));
        self.batch.fill(&*self.search)
    }
}

#[cfg(test)]
mod tests;
