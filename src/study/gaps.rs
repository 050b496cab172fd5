//! How far above the lowest `F` that is known searches end, over scenes and numbers of lights, as benchmarks of
//! optimisers have it: Hansen, Auger, Ros, Mersmann, Tušar and Brockhoff (2021), *COCO: a platform for comparing
//! continuous optimizers in a black-box setting*.

use super::contest::{self, Contest};
use super::statistics::Quartiles;
use super::{Observe, Subject};
use crate::Result;
use crate::design::Course;
use crate::lighting::genome::Genome;
use crate::optimize::{Entry, Settings, ShadeSettings, shade};

/// Gaps, in percent, that run-length distributions count as targets.
pub const TARGETS: [f32; 6] = [10.0, 5.0, 2.0, 1.0, 0.5, 0.2];

/// The runs of all optimisers for one scene and one number of lights.
#[derive(Debug, Clone)]
pub struct Case {
    /// Name of the scene.
    pub scene: String,
    /// Number of lights.
    pub lights: usize,
    /// The runs.
    pub contest: Contest,
    /// The lowest `F` of all runs, the long ones included.
    pub lowest: f32,
}

/// Runs the optimisers of these names, `budget` evaluations each, and as many long runs of SHADE, which draws new
/// populations for as long as it may, to know how low `F` can be.
///
/// # Errors
/// As [`contest::run`].
pub fn case(
    subject: &mut Subject,
    genome: &Genome,
    settings: &Settings,
    runs: (u64, usize),
    optimizers: &[&str],
    long: Long,
    observe: &mut Observe,
) -> Result<Case> {
    let contest = contest::run(subject, genome, settings, runs, optimizers, observe)?;
    let without_end = Settings { shade: ShadeSettings::endless(), ..*settings };
    let (seed, names) = (runs.0.wrapping_add(runs.1 as u64), [shade::NAME]);
    let Long { evaluations, runs } = long;
    let far = match runs {
        0 => None,
        _ => Some(contest::run_within(
            evaluations,
            subject,
            genome,
            &without_end,
            (seed, runs),
            &names,
            observe,
        )?),
    };
    let all = far.iter().chain([&contest]).flat_map(|contest| &contest.contestants);
    let lowest = all.flat_map(|one| &one.courses).map(Course::score).fold(f32::INFINITY, f32::min);
    let scene = subject.scene.path.display().to_string();
    Ok(Case { scene, lights: genome.lights(), contest, lowest })
}

/// Runs that tell how low `F` can be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Long {
    /// Evaluations of each.
    pub evaluations: usize,
    /// How many, each with a seed of its own; 0 for none.
    pub runs: usize,
}

impl Case {
    /// How far a score is above the lowest, percent.
    pub fn gap(&self, score: f32) -> f32 {
        if score <= self.lowest { 0.0 } else { 100.0 * (score - self.lowest) / self.lowest.abs() }
    }

    fn courses(&self, optimizer: &Entry) -> impl Iterator<Item = &Course> {
        let own = self.contest.contestants.iter().filter(move |one| one.optimizer == optimizer);
        own.flat_map(|one| &one.courses)
    }
}

/// How an optimiser does with a number of lights, over all scenes and runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// The optimiser.
    pub optimizer: &'static Entry,
    /// Number of lights.
    pub lights: usize,
    /// Gaps of the last scores, percent.
    pub gaps: Quartiles,
    /// Share of the runs that end within each of [`TARGETS`].
    pub within: [f32; TARGETS.len()],
    /// Evaluations of a run, the median: fewer than the budget where searches end by themselves.
    pub evaluations: f32,
}

/// The standings of all optimisers, by number of lights.
pub fn standings(cases: &[Case]) -> Vec<Standing> {
    let mut standings = Vec::new();
    for (lights, own) in by_lights(cases) {
        for optimizer in optimizers(&own) {
            let runs =
                || own.iter().flat_map(|case| case.courses(optimizer).map(move |c| (case, c)));
            let gaps: Vec<f32> = runs().map(|(case, course)| case.gap(course.score())).collect();
            let evaluations: Vec<f32> = runs().map(|(_, c)| c.evaluations as f32).collect();
            let share = |target: f32| {
                gaps.iter().filter(|&&gap| gap <= target).count() as f32 / gaps.len().max(1) as f32
            };
            standings.push(Standing {
                optimizer,
                lights,
                gaps: Quartiles::of(&gaps),
                within: TARGETS.map(share),
                evaluations: Quartiles::of(&evaluations).median,
            });
        }
    }
    standings
}

/// The share of runs and [`TARGETS`] that an optimiser has reached after some evaluations, with `lights` lights.
pub fn reached(cases: &[Case], lights: usize, optimizer: &Entry, evaluations: usize) -> f32 {
    let (mut hit, mut all) = (0, 0);
    for case in cases.iter().filter(|case| case.lights == lights) {
        for course in case.courses(optimizer) {
            let gap = case.gap(course.best_after(evaluations));
            hit += TARGETS.iter().filter(|&&target| gap <= target).count();
            all += TARGETS.len();
        }
    }
    hit as f32 / all.max(1) as f32
}

/// The cases of each number of lights, in the order in which they first come.
pub fn by_lights(cases: &[Case]) -> Vec<(usize, Vec<&Case>)> {
    let mut groups: Vec<(usize, Vec<&Case>)> = Vec::new();
    for case in cases {
        match groups.iter_mut().find(|(lights, _)| *lights == case.lights) {
            Some((_, group)) => group.push(case),
            None => groups.push((case.lights, vec![case])),
        }
    }
    groups
}

/// The optimisers of the first of these cases, as of all.
pub fn optimizers(cases: &[&Case]) -> Vec<&'static Entry> {
    let contestants = cases.first().map_or(&[][..], |case| &case.contest.contestants);
    contestants.iter().map(|one| one.optimizer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::race::Improvement;
    use crate::optimize::{OPTIMIZERS, genetic};
    use crate::study::contest::Contestant;

    fn course(improvements: &[(usize, f32)], evaluations: usize) -> Course {
        let improvements = improvements
            .iter()
            .map(|&(evaluation, score)| Improvement { evaluation, score })
            .collect();
        Course { improvements, chromosome: Vec::new(), evaluations }
    }

    fn case(lowest: f32, courses: Vec<Course>) -> Case {
        let optimizer = OPTIMIZERS.iter().find(|entry| entry.name == genetic::NAME).unwrap();
        let minima = vec![Vec::new(); courses.len()];
        let contestants = vec![Contestant { optimizer, courses, minima }];
        let contest = Contest { budget: 100, seed: 0, contestants };
        Case { scene: "a".into(), lights: 2, contest, lowest }
    }

    #[test]
    fn gaps_targets_and_run_lengths_by_hand() {
        let runs = vec![course(&[(1, 0.4), (50, 0.2)], 100), course(&[(1, 0.3), (20, 0.201)], 60)];
        let cases = [case(0.2, runs), case(0.1, vec![course(&[(5, 0.11)], 100)])];
        let standings = standings(&cases);
        assert_eq!(standings.len(), 1);
        let Standing { gaps, within, evaluations, lights, .. } = standings[0].clone();
        assert_eq!((lights, evaluations), (2, 100.0));
        assert!(gaps.low == 0.0 && (gaps.median - 0.5).abs() < 1e-3, "{gaps:?}");
        assert!((gaps.high - 10.0).abs() < 1e-3, "{gaps:?}");
        let third = 1.0 / 3.0;
        assert!((within[2] - 2.0 * third).abs() < 1e-6 && (within[5] - third).abs() < 1e-6);
        let entry = standings[0].optimizer;
        let reached = |evaluations| reached(&cases, 2, entry, evaluations);
        assert_eq!([reached(1), reached(4)], [0.0; 2]);
        // The second run is within 10 to 1 % by then, and the first within none.
        assert!(reached(20) >= 4.0 / 18.0 && reached(20) < 7.0 / 18.0);
        assert!(reached(50) >= reached(20) + 6.0 / 18.0 - 1e-6);
        assert_eq!(super::reached(&cases, 3, entry, 100), 0.0);
    }
}
