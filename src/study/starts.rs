//! Greedy descents of one light at constant intensity from several starts (Ha and Olivier 2006,
//! figures 1 to 4): where a descent ends depends on where it begins.

use super::{Observe, Subject};
use crate::design::Batch;
use crate::lighting::Light;
use crate::lighting::genome::{Boxes, Genome};
use crate::lighting::{LightKind, Role};
use crate::math::range::Range;
use crate::optimize::{Descent, DescentSettings, Optimizer};
use crate::{Error, Result};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The steps of one descent.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Every light that was accepted, the start first.
    pub lights: Vec<Light>,
    /// `F` of each.
    pub scores: Vec<f32>,
}

/// A genome of one light whose position alone can change: every other value has the middle of its
/// range.
///
/// # Errors
/// As [`Genome::new`], and [`Error::Argument`] for a kind whose first values are
/// not its angles.
pub fn position_genome(role: Role, kind: LightKind, boxes: &Boxes) -> Result<Genome> {
    let mut boxes = *boxes;
    let space = boxes.of_mut(role)?;
    let ranges = [&mut space.diffuse, &mut space.distance, &mut space.cone];
    for range in ranges.into_iter().chain(&mut space.specular) {
        *range = Range::new(range.middle(), range.middle());
    }
    let genome = Genome::new(&[role], kind, &boxes)?;
    genome.check_angles()?;
    Ok(genome)
}

/// Four starts, one drawn at random from each quarter of the box's positions.
pub fn quarters(genome: &Genome, seed: u64) -> Vec<Vec<f32>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let bounds = genome.bounds();
    let mut start = |[elevation, azimuth]: [f32; 2]| {
        let mut chromosome: Vec<f32> = bounds.iter().map(Range::middle).collect();
        for (allele, low) in [elevation, azimuth].into_iter().enumerate() {
            chromosome[allele] = bounds[allele].at(Range::new(low, low + 0.5).uniform(&mut rng));
        }
        chromosome
    };
    [[0.5, 0.0], [0.5, 0.5], [0.0, 0.0], [0.0, 0.5]].map(&mut start).to_vec()
}

/// Descends from all `starts` side by side.
///
/// # Errors
/// [`Error::Argument`] for a setting out of range or no start, [`Error::Interrupted`], and what the
/// evaluator reports.
pub fn run(
    subject: &mut Subject,
    genome: &Genome,
    starts: &[Vec<f32>],
    settings: DescentSettings,
    observe: &mut Observe,
) -> Result<Vec<Path>> {
    let mut search = Descent::new(genome.bounds(), starts, settings)?;
    let mut paths = vec![Path { lights: Vec::new(), scores: Vec::new() }; starts.len()];
    let mut batch = Batch::new(genome)?;
    while !search.ask().is_empty() {
        batch.fill(&search)?;
        let scores = batch.evaluate(subject.evaluator)?;
        let evaluations = scores.len();
        search.tell(scores);
        for (path, (chromosome, score)) in paths.iter_mut().zip(search.positions()) {
            if path.scores.last().is_none_or(|last| score < *last) {
                path.lights.extend(genome.decode(chromosome));
                path.scores.push(score);
            }
        }
        if observe(evaluations).is_break() {
            return Err(Error::Interrupted);
        }
    }
    Ok(paths)
}
