//! Searches against each other: their courses over the evaluations, and their last scores in pairs.

use super::{Exhibit, PLOT, Studio, plotted, table};
use crate::lighting::genome::Genome;
use crate::objective::Quality;
use crate::optimize::{Entry, descent, genetic, restarts};
use crate::report::json::LightRecord;
use crate::report::plot::{self, Band, Group};
use crate::study::contest::{Comparison, Contest, Contestant};
use crate::study::statistics::{Quartiles, median_index};
use anyhow::{Context, Result};
use serde::Serialize;

/// Points of a course at most.
const POINTS: usize = 100;

/// The courses in figures.
#[derive(Debug, Clone, Serialize)]
pub struct Courses {
    /// Evaluations of every run.
    pub budget: usize,
    /// Runs of each optimiser.
    pub runs: usize,
    /// Numbers of evaluations at which the courses are given.
    pub evaluations: Vec<usize>,
    /// The optimisers' courses.
    pub methods: Vec<CourseRecord>,
}

/// An optimiser's course.
#[derive(Debug, Clone, Serialize)]
pub struct CourseRecord {
    /// What results call it.
    pub method: &'static str,
    /// What plots and tables call it.
    #[serde(skip)]
    pub title: &'static str,
    /// Mean over the runs of the best `F` so far.
    pub mean: Vec<f32>,
    /// Its first quartile.
    pub first: Vec<f32>,
    /// Its third quartile.
    pub third: Vec<f32>,
    /// Evaluations after which the mean had come within 5 % of its whole fall.
    pub settled: usize,
    /// The last scores.
    pub last: Quartiles,
}

/// Numbers of evaluations: the first population, and then generation after generation, or fewer.
fn points(contest: &Contest, (first, generation): (usize, usize)) -> Vec<usize> {
    let generations = (contest.budget - first) / generation.max(1);
    let step = generation.max(1) * generations.div_ceil(POINTS - 1).max(1);
    let mut points: Vec<usize> = (first..=contest.budget).step_by(step).collect();
    if points.last() != Some(&contest.budget) {
        points.push(contest.budget);
    }
    points
}

fn course(contestant: &Contestant, points: &[usize]) -> CourseRecord {
    let runs = contestant.courses.len() as f32;
    let samples: Vec<Vec<f32>> =
        points.iter().map(|&evaluations| contestant.best_after(evaluations)).collect();
    let mean: Vec<f32> = samples.iter().map(|s| s.iter().sum::<f32>() / runs).collect();
    let quartiles: Vec<Quartiles> = samples.iter().map(|sample| Quartiles::of(sample)).collect();
    let (begin, end) = (mean[0], mean[mean.len() - 1]);
    let near = mean.iter().position(|&mean| mean <= end + 0.05 * (begin - end)).unwrap_or(0);
    CourseRecord {
        method: stem(contestant.optimizer),
        title: contestant.optimizer.title,
        mean,
        first: quartiles.iter().map(|q| q.first).collect(),
        third: quartiles.iter().map(|q| q.third).collect(),
        settled: points[near],
        last: Quartiles::of(&contestant.scores()),
    }
}

/// The courses of all optimisers; `generation` is the size of the first population and of each later
/// generation.
///
/// # Errors
/// The plotting library's reason, and what the studio reports.
pub fn convergence(
    contest: &Contest,
    generation: (usize, usize),
    genome: &Genome,
    studio: &mut dyn Studio,
) -> Result<Exhibit<Courses>> {
    let evaluations = points(contest, generation);
    let methods: Vec<_> =
        contest.contestants.iter().map(|contestant| course(contestant, &evaluations)).collect();
    let x: Vec<f32> = evaluations.iter().map(|&n| n as f32).collect();
    let bands: Vec<_> = methods
        .iter()
        .map(|m| Band { name: m.title, x: &x, middle: &m.mean, low: &m.first, high: &m.third })
        .collect();
    let plot = plotted(plot::bands(&bands, "evaluations", "best F, lower is better", PLOT))?;
    let rows = methods.iter().flat_map(|m| {
        let curves = m.mean.iter().zip(&m.first).zip(&m.third);
        let curves = curves.zip(&evaluations);
        curves.map(|(((mean, first), third), n)| (m.method, *n, *mean, *first, *third))
    });
    let names = ["method", "evaluations", "mean", "first_quartile", "third_quartile"];
    let tables = vec![("convergence", table(&names, rows)?)];
    let mut pictures = Vec::new();
    for contestant in &contest.contestants {
        pictures.push((
            stem(contestant.optimizer).to_owned(),
            median_picture(contestant, genome, studio)?,
        ));
    }
    let runs = contest.contestants.first().map_or(0, |c| c.courses.len());
    let data = Courses { budget: contest.budget, runs, evaluations, methods };
    Ok(Exhibit { data, tables, plots: vec![("convergence".into(), plot)], pictures })
}

/// The name of the genetic algorithm in results.
pub const GENETIC: &str = "genetic";

/// The name of greedy descents with restarts in results, the one greedy search that studies compare by
/// default.
const GREEDY: &str = "greedy";

/// What results and their pictures call an optimiser: its name, but for the paper's two.
fn stem(optimizer: &Entry) -> &'static str {
    match optimizer.name {
        genetic::NAME => GENETIC,
        restarts::NAME => GREEDY,
        descent::NAME => "descents",
        name => name,
    }
}

fn median_picture(
    contestant: &Contestant,
    genome: &Genome,
    studio: &mut dyn Studio,
) -> Result<image::RgbImage> {
    let run = median_index(&contestant.scores());
    studio.paint(&genome.decode(&contestant.courses[run].chromosome))
}

/// The genetic algorithm against greedy descents, in figures.
#[derive(Debug, Clone, Serialize)]
pub struct Pairs {
    /// Evaluations of every run.
    pub budget: usize,
    /// Runs of each optimiser.
    pub runs: usize,
    /// The first seed; each further run has the next.
    pub first_seed: u64,
    /// The genetic algorithm.
    pub genetic: Side,
    /// Greedy descents with restarts.
    pub greedy: Side,
    /// Where single descents ended, from the clusters' individual and from random ones.
    pub single_descents: SingleDescents,
    /// The two, paired by seed: a negative difference is in favour of the genetic algorithm.
    pub comparison: Comparison,
}

/// One of the two.
#[derive(Debug, Clone, Serialize)]
pub struct Side {
    /// The last score of each run.
    pub scores: Vec<f32>,
    /// Their quartiles.
    pub quartiles: Quartiles,
    /// Index of the run with the median score.
    pub median_run: usize,
    /// That run's quality.
    pub median_quality: Quality,
    /// That run's lights.
    pub median_lights: Vec<LightRecord>,
}

/// Ends of descents without restarts.
#[derive(Debug, Clone, Serialize)]
pub struct SingleDescents {
    /// How many came to their end within the budget.
    pub count: usize,
    /// Quartiles of their last scores; none without any.
    pub quartiles: Option<Quartiles>,
}

/// The genetic algorithm against greedy descents.
///
/// # Errors
/// When either is not in the contest, the plotting library's reason, and what the studio
/// reports.
pub fn compare(
    contest: &Contest,
    genome: &Genome,
    studio: &mut dyn Studio,
) -> Result<Exhibit<Pairs>> {
    let find = |name| contest.contestants.iter().find(|c| c.optimizer.name == name);
    let genetic = find(genetic::NAME).context("a contest without the genetic algorithm")?;
    let greedy = find(restarts::NAME).context("a contest without greedy descents")?;
    let mut side = |contestant: &Contestant| -> Result<Side> {
        let scores = contestant.scores();
        let median_run = median_index(&scores);
        let rig = genome.decode(&contestant.courses[median_run].chromosome);
        Ok(Side {
            quartiles: Quartiles::of(&scores),
            median_run,
            median_quality: studio.judge(&rig)?,
            median_lights: LightRecord::rig(&rig, studio.view()),
            scores,
        })
    };
    let ends: Vec<f32> = greedy.minima.iter().flatten().copied().collect();
    let data = Pairs {
        budget: contest.budget,
        runs: genetic.courses.len(),
        first_seed: contest.seed,
        genetic: side(genetic)?,
        greedy: side(greedy)?,
        single_descents: SingleDescents {
            count: ends.len(),
            quartiles: (!ends.is_empty()).then(|| Quartiles::of(&ends)),
        },
        comparison: Comparison::of(&genetic.scores(), &greedy.scores()),
    };
    let plot = plot::paired(
        &Group { name: genetic.optimizer.title, values: &data.genetic.scores },
        &Group { name: greedy.optimizer.title, values: &data.greedy.scores },
        PLOT,
    );
    let rows = data.genetic.scores.iter().zip(&data.greedy.scores).enumerate();
    let rows = rows.map(|(i, pair)| (contest.seed.wrapping_add(i as u64), *pair.0, *pair.1));
    let tables = vec![("compare", table(&["seed", GENETIC, GREEDY], rows)?)];
    let pictures = vec![
        (GENETIC.to_owned(), median_picture(genetic, genome, studio)?),
        (GREEDY.to_owned(), median_picture(greedy, genome, studio)?),
    ];
    Ok(Exhibit { data, tables, plots: vec![("compare".into(), plotted(plot)?)], pictures })
}
