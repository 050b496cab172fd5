//! Chromosomes as an evaluator takes them.

use crate::evaluate::{Evaluator, check_scores};
use crate::lighting::Population;
use crate::lighting::genome::Genome;
use crate::math::frame::Frame;
use crate::optimize::Optimizer;
use crate::{Error, Result};

/// Chromosomes on their way to an evaluator, and their scores.
#[derive(Debug, Clone)]
pub(crate) struct Batch {
    genome: Genome,
    population: Population,
    scores: Vec<f32>,
}

impl Batch {
    pub fn new(genome: &Genome) -> Result<Self> {
        let population = Population::new(genome.rig_lights())?;
        Ok(Self { genome: genome.clone(), population, scores: Vec::new() })
    }

    pub fn genome(&self) -> &Genome {
        &self.genome
    }

    /// Goes on in another light frame.
    pub fn follow(&mut self, from: &Frame, to: &Frame) {
        self.genome.follow(from, to);
    }

    pub fn population(&self) -> &Population {
        &self.population
    }

    /// Takes what a search asks for in the place of all before.
    ///
    /// # Errors
    /// As [`Batch::add`].
    pub fn fill(&mut self, search: &dyn Optimizer) -> Result<()> {
        self.clear();
        self.add(search, search.ask())
    }

    /// Takes out all chromosomes.
    pub fn clear(&mut self) {
        self.population.clear();
    }

    /// Adds chromosomes that a search asks for.
    ///
    /// # Errors
    /// [`Error::Argument`] for one of another length than the genome's.
    pub fn add(&mut self, search: &dyn Optimizer, chromosomes: &[Vec<f32>]) -> Result<()> {
        let wanted = self.genome.bounds().len();
        for chromosome in chromosomes {
            let given = chromosome.len();
            if given != wanted {
                let name = search.name();
                return Err(Error::Argument(format!(
                    "the search '{name}' asks for {given} alleles: the genome has {wanted}"
                )));
            }
            self.population.push(&self.genome.decode(chromosome))?;
        }
        Ok(())
    }

    /// The scores of the chromosomes, evaluated as one population.
    ///
    /// # Errors
    /// What the evaluator reports, and [`Error::NotANumber`].
    pub fn evaluate(&mut self, evaluator: &mut dyn Evaluator) -> Result<&[f32]> {
        self.scores.resize(self.population.len(), 0.0);
        evaluator.evaluate(&self.population, &mut self.scores)?;
        check_scores(&self.population, &self.scores)?;
        Ok(&self.scores)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::testing::{Hills, genome};
    use crate::math::range::Range;

    #[test]
    fn a_score_that_is_not_a_number_is_an_error_with_its_rig() {
        let genome = genome();
        let mut batch = Batch::new(&genome).unwrap();
        for share in [0.2, 0.5, 0.8] {
            let chromosome: Vec<f32> =
                genome.bounds().iter().map(|r: &Range| r.at(share)).collect();
            batch.population.push(&genome.decode(&chromosome)).unwrap();
        }
        let fault =
            batch.evaluate(&mut Hills { bottomless: Some(1), ..Hills::default() }).unwrap_err();
        assert!(!fault.is_input() && !fault.is_device());
        let [x, y, z] = batch.population.records()[2].position;
        let told = fault.to_string();
        assert!(told.contains(&format!("a light at ({x}, {y}, {z}) of diffuse ")), "{told}");
    }
}
