//! What each number of the quality function does: the search is run with one weight, target or
//! threshold changed at a time, and what it finds is measured by the unchanged function.

use super::statistics::median_index;
use super::{Observe, Subject, seeds};
use crate::Result;
use crate::design::race;
use crate::evaluate::{Evaluator, Inspection};
use crate::lighting::Rig;
use crate::lighting::genome::Genome;
use crate::objective::maps::PixelType;
use crate::objective::{MeanTarget, Objective, Term};
use crate::optimize::{Settings, genetic};

/// A quality function with one number changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// What is changed, and to what.
    pub name: String,
    /// The function.
    pub objective: Objective,
}

/// What the search finds under a variant, one entry a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    /// The variant.
    pub variant: Variant,
    /// The best rigs.
    pub rigs: Vec<Rig>,
    /// These rigs under the unchanged function, without their pictures.
    pub inspections: Vec<Inspection>,
    /// Mean absolute difference of `I` over the object from the picture that the unchanged function
    /// finds with the same seed; for the unchanged function itself, with the next seed.
    pub changes: Vec<f32>,
}

impl Effect {
    /// Index of the run with the median score.
    pub fn median_run(&self) -> usize {
        let scores: Vec<f32> = self.inspections.iter().map(|i| i.score).collect();
        median_index(&scores)
    }
}

/// One number of the quality function; none where the scene sets it.
type Number = fn(&mut Objective) -> Option<&mut f32>;

fn mean_target(objective: &mut Objective) -> Option<&mut f32> {
    match &mut objective.mean_target {
        MeanTarget::Value(value) => Some(value),
        MeanTarget::Scene => None,
    }
}

/// The unchanged function first, then every weight left out and doubled, and the targets and
/// thresholds halved and doubled (the mean brightness: a fifth to each side).
pub fn variants(base: &Objective) -> Vec<Variant> {
    let mut variants = vec![Variant { name: "unchanged".into(), objective: *base }];
    let mut add = |name: String, change: &dyn Fn(&mut Objective)| {
        let mut objective = *base;
        change(&mut objective);
        if objective != *base && objective.check().is_ok() {
            variants.push(Variant { name, objective });
        }
    };
    for (term, _) in base.weights.iter() {
        let times = |o: &mut Objective, factor: f32| {
            let scaled = |other: &'static Term, weight| {
                if other == term { weight * factor } else { weight }
            };
            o.weights = o.weights.map(scaled);
        };
        add(format!("without F_{}", term.name), &|o| times(o, 0.0));
        add(format!("F_{} doubled", term.name), &|o| times(o, 2.0));
    }
    let numbers: [(&str, Number, [f32; 2]); 4] = [
        ("mean_target", mean_target, [0.8, 1.2]),
        ("edge_contrast", |o| Some(&mut o.edge_contrast), [0.5, 2.0]),
        ("edge_sobel", |o| Some(&mut o.edge_sobel), [0.5, 2.0]),
        ("edge_laplace", |o| Some(&mut o.edge_laplace), [0.5, 2.0]),
    ];
    for (name, number, factors) in numbers {
        let mut changed = *base;
        let Some(&mut value) = number(&mut changed) else { continue };
        for value in factors.map(|factor| value * factor) {
            let set = |o: &mut Objective| number(o).into_iter().for_each(|n| *n = value);
            add(format!("{name} {value}"), &set);
        }
    }
    variants
}

/// Makes an evaluator of the subject's view for a quality function.
pub type MakeEvaluator<'a> = dyn FnMut(&Objective) -> Result<Box<dyn Evaluator>> + 'a;

/// Searches under every variant of `base`, the function of the subject's evaluator. All runs of a
/// variant are evaluated side by side.
///
/// # Errors
/// [`crate::Error::Argument`] for settings or a number of runs out of range,
/// [`crate::Error::Interrupted`], and what the evaluators report.
pub fn run(
    subject: &mut Subject,
    genome: &Genome,
    (base, settings): (&Objective, &Settings),
    (seed, runs): (u64, usize),
    make: &mut MakeEvaluator,
    observe: &mut Observe,
) -> Result<Vec<Effect>> {
    let seeds = seeds(seed, runs)?;
    settings.check()?;
    let beginnings = subject.beginnings(genome, &seeds)?;
    let types = subject.evaluator.maps()?.types.clone();
    let mut unchanged: Vec<Vec<f32>> = Vec::new();
    let mut effects = Vec::new();
    for variant in variants(base) {
        let mut evaluator = make(&variant.objective)?;
        let mut searches = Vec::new();
        for beginning in &beginnings {
            searches.push(beginning.clone().search(genetic::NAME, genome, settings)?);
        }
        let budget = settings.genetic.budget();
        let courses = race(&mut searches, budget, genome, &mut *evaluator, observe)?;
        let rigs: Vec<Rig> =
            courses.iter().map(|course| genome.decode(&course.chromosome)).collect();
        let mut inspections =
            rigs.iter().map(|rig| subject.evaluator.inspect(rig)).collect::<Result<Vec<_>>>()?;
        let pictures: Vec<Vec<f32>> =
            inspections.iter_mut().map(|i| std::mem::take(&mut i.picture)).collect();
        if unchanged.is_empty() {
            unchanged = pictures.clone();
            unchanged.rotate_left(1);
        }
        let changes = pictures.iter().zip(&unchanged).map(|(a, b)| change(a, b, &types)).collect();
        if effects.is_empty() {
            unchanged = pictures;
        }
        effects.push(Effect { variant, rigs, inspections, changes });
    }
    Ok(effects)
}

/// Mean absolute difference of two pictures over the object.
fn change(a: &[f32], b: &[f32], types: &[PixelType]) -> f32 {
    let pixels = a.iter().zip(b).zip(types).filter(|(_, kind)| **kind != PixelType::Background);
    let (sum, count) = pixels.fold((0.0, 0usize), |(sum, count), ((a, b), _)| {
        (sum + f64::from((a - b).abs()), count + 1)
    });
    (sum / count.max(1) as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::maps::ViewStatistics;

    #[test]
    fn each_variant_changes_one_number() {
        let base = Objective::default();
        let variants = variants(&base);
        assert_eq!(variants.len(), 1 + 10 + 8);
        let numbers = |o: &Objective| {
            let mut all = o.weights.values().collect::<Vec<_>>();
            let mean_target = o.mean_target.of(&ViewStatistics::default());
            all.extend([mean_target, o.edge_contrast, o.edge_sobel, o.edge_laplace]);
            all
        };
        for variant in &variants[1..] {
            let pairs = std::iter::zip(numbers(&variant.objective), numbers(&base));
            assert_eq!(pairs.filter(|(a, b)| a != b).count(), 1, "{}", variant.name);
        }
        // A weight that is 0 already cannot be left out.
        let mut single = base;
        single.weights = single.weights.map(|term, _| f32::from(u8::from(term.name == "edge")));
        assert_eq!(super::variants(&single).len(), 1 + 1 + 8);
        // A target that the scene sets is no number to change.
        let of_scene = Objective { mean_target: MeanTarget::Scene, ..base };
        let variants = super::variants(&of_scene);
        assert_eq!(variants.len(), 1 + 10 + 6);
        assert!(variants.iter().all(|v| v.objective.mean_target == MeanTarget::Scene));
    }

    #[test]
    fn the_background_takes_no_part_in_a_change() {
        let types = [PixelType::Background, PixelType::Edge, PixelType::Surface];
        assert_eq!(change(&[0.0, 0.5, 0.25], &[1.0, 0.25, 0.25], &types), 0.125);
        assert_eq!(change(&[0.0], &[1.0], &types[..1]), 0.0);
    }
}
