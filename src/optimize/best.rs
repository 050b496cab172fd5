//! The best chromosome so far.

/// The chromosome with the lowest score of all that were offered.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Best(Option<(Vec<f32>, f32)>);

impl Best {
    /// Takes note of a chromosome and its score; says whether it is better than all before it. Of equal
    /// ones the first stays; what is not a number is never the best.
    pub fn offer(&mut self, chromosome: &[f32], score: f32) -> bool {
        let better = self.0.as_ref().map_or(!score.is_nan(), |(_, best)| score < *best);
        if better {
            self.0 = Some((chromosome.to_vec(), score));
        }
        better
    }

    /// The same with chromosomes and their scores, one after another; says whether any is better than all before
    /// these.
    pub fn offer_all(&mut self, chromosomes: &[Vec<f32>], scores: &[f32]) -> bool {
        let each = chromosomes.iter().zip(scores);
        each.fold(false, |better, (chromosome, &score)| self.offer(chromosome, score) | better)
    }

    /// The best and its score; `None` before the first.
    pub fn get(&self) -> Option<(&[f32], f32)> {
        self.0.as_ref().map(|(chromosome, score)| (chromosome.as_slice(), *score))
    }
}
