//! Rigs that are good and as different as can be: the dispersion phase of *Design Galleries* (Marks and others 1997),
//! which changes what is there at random and keeps what is good and unlike all else.

use super::gallery::{Picture, farthest, least};
use crate::math::range::Range;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Chromosomes that are asked for at once.
const ASKED: usize = 64;

/// Candidates that stay, for each rig that is wanted.
const STAYING: usize = 8;

/// Standard deviations of small, middle and large steps, shares of each allele's range.
const STEPS: [f32; 3] = [0.05, 0.15, 0.4];

/// A good rig that might be shown.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Its chromosome.
    pub chromosome: Vec<f32>,
    /// Its score.
    pub score: f32,
    /// What it shows.
    pub picture: Picture,
}

/// Candidates on their way to be dispersed. All random numbers are of one seeded generator.
#[derive(Debug, Clone)]
pub struct Dispersion {
    bounds: Vec<Range>,
    /// The first one, then others, each about as far as can be from all before it.
    candidates: Vec<Candidate>,
    wanted: usize,
    slack: f32,
    rng: ChaCha8Rng,
}

impl Dispersion {
    /// Begins with the rig `first`, which stays whatever its score is. `wanted` rigs are to be shown, whose scores
    /// are to lie no more than `slack` above the lowest. Chromosomes that are asked for are inside `bounds`.
    pub fn new(
        bounds: &[Range],
        first: Candidate,
        (wanted, slack): (usize, f32),
        rng: ChaCha8Rng,
    ) -> Self {
        Self { bounds: bounds.to_vec(), candidates: vec![first], wanted, slack, rng }
    }

    /// The candidates so far: the first one, then others, each about as far as can be from all before it.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// The highest score that is good enough.
    pub fn limit(&self) -> f32 {
        self.candidates.iter().map(|one| one.score).fold(f32::INFINITY, f32::min) + self.slack
    }

    /// New chromosomes to be scored: changes of the candidates that are farthest apart, what lies between two of them,
    /// and some from anywhere.
    pub fn ask(&mut self) -> Vec<Vec<f32>> {
        (0..ASKED).map(|_| self.child()).collect()
    }

    fn child(&mut self) -> Vec<f32> {
        let Self { bounds, candidates, wanted, rng, .. } = self;
        let mut parent =
            |most: usize| &candidates[rng.random_range(0..candidates.len().min(most))].chromosome;
        let (one, other) = (parent(*wanted), parent(usize::MAX));
        let (way, step) = (rng.random_range(0..4), STEPS[rng.random_range(0..STEPS.len())]);
        let allele = |(at, range): (usize, &Range)| match way {
            0 => range.uniform(rng),
            1 => range.step(if rng.random() { one[at] } else { other[at] }, STEPS[0], rng),
            _ => range.step(one[at], step, rng),
        };
        bounds.iter().enumerate().map(allele).collect()
    }

    /// Takes what is good enough of `found`, and of what is alike lets all but the best go.
    pub fn add(&mut self, found: impl IntoIterator<Item = Candidate>) {
        self.candidates.extend(found);
        let limit = self.limit();
        let mut first = true;
        self.candidates.retain(|one| std::mem::take(&mut first) || one.score <= limit);
        let apart =
            |a: usize, b: usize| self.candidates[a].picture.distance(&self.candidates[b].picture);
        let mut staying = farthest(self.candidates.len(), 0, STAYING * self.wanted, apart);
        // Of those that look the same the best one stays.
        let same = 0.5 * least(&staying, apart);
        for at in 0..self.candidates.len() {
            let near = staying.iter_mut().skip(1).find(|stays| apart(**stays, at) < same);
            if let Some(stays) = near
                && self.candidates[at].score < self.candidates[*stays].score
            {
                *stays = at;
            }
        }
        let mut all: Vec<_> = std::mem::take(&mut self.candidates).into_iter().map(Some).collect();
        self.candidates = staying.into_iter().filter_map(|at| all[at].take()).collect();
    }
}

/// The part of each range that is no more than `share` of its width from a chromosome inside.
pub fn near(bounds: &[Range], chromosome: &[f32], share: f32) -> Vec<Range> {
    let part = |(range, &at): (&Range, &f32)| {
        let reach = share * range.width();
        Range::new(range.nearest(at - reach), range.nearest(at + reach))
    };
    bounds.iter().zip(chromosome).map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{Rgb, RgbImage};
    use rand::SeedableRng;

    const BOUNDS: [Range; 2] = [Range::new(-1.0, 1.0), Range::new(0.0, 2.0)];

    /// Two pixels, as bright as the alleles say; a score of its distance from a ring.
    fn candidate(x: Vec<f32>) -> Candidate {
        let grey = |x: f32| [(127.0 + 60.0 * x).round() as u8; 3];
        let picture = RgbImage::from_fn(2, 1, |at, _| Rgb(grey(x[at as usize])));
        let score = (x[0].hypot(x[1] - 1.0) - 0.8).abs();
        Candidate { picture: Picture::of(&picture, &[true; 2], 1), chromosome: x, score }
    }

    fn dispersed(seed: u64, bounds: &[Range], first: [f32; 2]) -> Dispersion {
        let rng = ChaCha8Rng::seed_from_u64(seed);
        let mut dispersion = Dispersion::new(bounds, candidate(first.into()), (6, 0.05), rng);
        for _ in 0..20 {
            let asked = dispersion.ask();
            assert!(asked.iter().flat_map(|x| x.iter().zip(bounds)).all(|(x, r)| r.contains(*x)));
            dispersion.add(asked.into_iter().map(candidate));
        }
        dispersion
    }

    fn spread(dispersion: &Dispersion) -> f32 {
        let candidates = dispersion.candidates();
        let six: Vec<usize> = (0..6).collect();
        least(&six, |a, b| candidates[a].picture.distance(&candidates[b].picture))
    }

    #[test]
    fn what_is_good_is_spread_over_all_places() {
        let dispersion = dispersed(1, &BOUNDS, [0.8, 1.0]);
        let candidates = dispersion.candidates();
        assert_eq!(candidates[0].chromosome, [0.8, 1.0]);
        assert!(candidates.len() <= 6 * STAYING);
        assert!(candidates.iter().all(|one| one.score <= dispersion.limit()));
        assert!(candidates[1].chromosome[0] < -0.5, "the other side of the ring");
        let again = dispersed(1, &BOUNDS, [0.8, 1.0]);
        let all = |d: &Dispersion| {
            d.candidates().iter().map(|c| c.chromosome.clone()).collect::<Vec<_>>()
        };
        assert_eq!(all(&dispersion), all(&again));
        assert_ne!(all(&dispersion), all(&dispersed(2, &BOUNDS, [0.8, 1.0])));
    }

    #[test]
    fn near_a_rig_all_stay_near() {
        let bounds = near(&BOUNDS, &[0.8, 1.0], 0.15);
        assert_eq!((bounds[0], bounds[1]), (Range::new(0.5, 1.0), Range::new(0.7, 1.3)));
        let dispersion = dispersed(1, &bounds, [0.8, 1.0]);
        assert!(spread(&dispersion) < 0.5 * spread(&dispersed(1, &BOUNDS, [0.8, 1.0])));
    }

    #[test]
    fn the_first_one_stays_whatever_its_score() {
        let dispersion = dispersed(3, &BOUNDS, [0.0, 1.0]);
        assert_eq!(dispersion.candidates()[0].chromosome, [0.0, 1.0]);
        assert!(dispersion.candidates()[0].score > dispersion.limit());
    }
}
