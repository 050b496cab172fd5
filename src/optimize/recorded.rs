//! A search that leaves behind what it has looked at: good and different places, not the best alone.

use super::Optimizer;
use crate::math::range::Range;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Parts of each allele's range in which one place at most is kept.
const PARTS: f32 = 5.0;

/// The best chromosome of each cell of a grid over the box of all alleles (an archive of elites: Mouret and Clune
/// 2015, *Illuminating search spaces by mapping elites*), in the order of the cells. Shared by all copies.
#[derive(Debug, Clone)]
pub struct Record {
    bounds: Vec<Range>,
    cells: Arc<Mutex<BTreeMap<Vec<u8>, Elite>>>,
}

/// A chromosome and its score.
type Elite = (Vec<f32>, f32);

impl Record {
    /// An empty record of chromosomes inside these bounds.
    pub fn new(bounds: &[Range]) -> Self {
        Self { bounds: bounds.to_vec(), cells: Arc::default() }
    }

    fn cell(&self, chromosome: &[f32]) -> Vec<u8> {
        let part = |(range, &x): (&Range, &f32)| (range.share(x) * PARTS).min(PARTS - 1.0) as u8;
        self.bounds.iter().zip(chromosome).map(part).collect()
    }

    fn offer(&self, chromosome: &[f32], score: f32) {
        let mut cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
        let place =
            cells.entry(self.cell(chromosome)).or_insert_with(|| (Vec::new(), f32::INFINITY));
        if score < place.1 {
            *place = (chromosome.to_vec(), score);
        }
    }

    /// The `most` best of them, best first; those that are equal in the order of their cells.
    pub fn best(&self, most: usize) -> Vec<Vec<f32>> {
        let cells = self.cells.lock().unwrap_or_else(PoisonError::into_inner);
        let mut elites: Vec<&Elite> = cells.values().filter(|elite| !elite.0.is_empty()).collect();
        elites.sort_by(|a, b| a.1.total_cmp(&b.1));
        elites.into_iter().take(most).map(|elite| elite.0.clone()).collect()
    }
}

/// A search whose chromosomes go into a [`Record`].
#[derive(Debug, Clone)]
pub struct Recorded {
    search: Box<dyn Optimizer>,
    record: Record,
}

impl Recorded {
    /// The same search, and what becomes of it.
    pub fn new(search: Box<dyn Optimizer>, record: Record) -> Self {
        Self { search, record }
    }
}

impl Optimizer for Recorded {
    fn name(&self) -> &'static str {
        self.search.name()
    }

    fn ask(&self) -> &[Vec<f32>] {
        self.search.ask()
    }

    fn tell(&mut self, scores: &[f32]) {
        for (chromosome, &score) in self.search.ask().iter().zip(scores) {
            self.record.offer(chromosome, score);
        }
        self.search.tell(scores);
    }

    fn best(&self) -> Option<(&[f32], f32)> {
        self.search.best()
    }

    fn scores(&self) -> &[f32] {
        self.search.scores()
    }

    fn renew(&mut self, change: &dyn Fn(&[f32]) -> Vec<f32>) {
        self.search.renew(change);
    }

    fn refine(&mut self) {
        self.search.refine();
    }

    fn boxed(&self) -> Box<dyn Optimizer> {
        Box::new(self.clone())
    }

    fn minima(&self) -> &[f32] {
        self.search.minima()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::{Settings, Setup, create, shade};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const BOUNDS: [Range; 2] = [Range::new(-1.0, 1.0); 2];

    fn search() -> Box<dyn Optimizer> {
        let mut settings = Settings::default();
        (settings.genetic.population, settings.genetic.generations) = (12, 20);
        let rng = ChaCha8Rng::seed_from_u64(4);
        create(
            shade::NAME,
            Setup { bounds: &BOUNDS, first: vec![0.5; 2], settings: &settings, rng },
        )
        .unwrap()
    }

    #[test]
    fn of_equal_ones_in_a_cell_the_first_stays() {
        let record = Record::new(&BOUNDS);
        for (place, score) in [(0.1, 1.0), (0.11, 1.0), (0.12, 2.0)] {
            record.offer(&[place; 2], score);
        }
        assert_eq!(record.best(9), [[0.1; 2]]);
    }

    #[test]
    fn a_recorded_search_goes_its_way_and_leaves_the_best_of_each_cell() {
        let height = |x: &[f32]| x.iter().map(|x| (x - 0.3).powi(2)).sum::<f32>();
        let record = Record::new(&BOUNDS);
        let (mut plain, mut recorded) = (search(), Recorded::new(search(), record.clone()));
        let mut told = Vec::new();
        while !plain.ask().is_empty() {
            assert_eq!(plain.ask(), recorded.ask());
            let scores: Vec<f32> = plain.ask().iter().map(|x| height(x)).collect();
            told.extend(plain.ask().iter().cloned().zip(scores.clone()));
            plain.tell(&scores);
            recorded.tell(&scores);
        }
        assert_eq!(plain.best(), recorded.best());
        let elites = record.best(usize::MAX);
        assert_eq!(elites[0], plain.best().unwrap().0);
        assert!(elites.is_sorted_by(|a, b| height(a) <= height(b)));
        let cells: std::collections::BTreeSet<_> =
            told.iter().map(|(x, _)| record.cell(x)).collect();
        assert_eq!(elites.len(), cells.len());
        for elite in &elites {
            let cell = record.cell(elite);
            let same = told.iter().filter(|(x, _)| record.cell(x) == cell);
            let lowest = same.map(|(_, score)| *score).fold(f32::INFINITY, f32::min);
            assert_eq!(height(elite), lowest);
        }
        assert_eq!(record.best(3), elites[..3]);
    }
}
