use super::*;
use rand::SeedableRng;

/// Hansen's tutorial as it stands: equations 38 to 47 and 49 to 58, the inverse root of the matrix made anew each time.
struct Tutorial {
    mean: Vec<f64>,
    step: f64,
    covariance: Vec<f64>,
    path: Vec<f64>,
    step_path: Vec<f64>,
    generation: i32,
    /// Generations in which the path stood still.
    stalled: usize,
}

impl Tutorial {
    fn of(run: &Run) -> Self {
        let n = run.mean.len();
        Self {
            mean: run.mean.clone(),
            step: run.step,
            covariance: run.covariance.clone(),
            path: vec![0.0; n],
            step_path: vec![0.0; n],
            generation: 0,
            stalled: 0,
        }
    }

    /// `C^(-1/2) y`.
    fn whitened(&self, y: &[f64]) -> Vec<f64> {
        let n = y.len();
        let (values, axes) = eigen::symmetric(self.covariance.clone(), n);
        let along = |k: usize| (0..n).map(|j| axes[j * n + k] * y[j]).sum::<f64>();
        (0..n)
            .map(|i| (0..n).map(|k| axes[i * n + k] * along(k) / values[k].sqrt()).sum())
            .collect()
    }

    /// `steps` are the samples' `y`, the best first.
    fn update(&mut self, steps: &[Vec<f64>]) {
        let (count, n) = (steps.len(), self.mean.len() as f64);
        let dimensions = 0..self.mean.len();
        let mu = count / 2;
        let raw: Vec<f64> =
            (1..=count).map(|i| ((count as f64 + 1.0) / 2.0).ln() - (i as f64).ln()).collect();
        let square = |x: f64| x * x;
        let worth =
            |w: &[f64]| square(w.iter().sum::<f64>()) / w.iter().map(|&w| square(w)).sum::<f64>();
        let (worth, negative) = (worth(&raw[..mu]), worth(&raw[mu..]));
        let c_1 = 2.0 / (square(n + 1.3) + worth);
        let c_mu =
            (1.0 - c_1).min(2.0 * (0.25 + worth + 1.0 / worth - 2.0) / (square(n + 2.0) + worth));
        let c_c = (4.0 + worth / n) / (n + 4.0 + 2.0 * worth / n);
        let c_s = (worth + 2.0) / (n + worth + 5.0);
        let d_s = 1.0 + 2.0 * f64::max(0.0, ((worth - 1.0) / (n + 1.0)).sqrt() - 1.0) + c_s;
        let alpha = [
            1.0 + c_1 / c_mu,
            1.0 + 2.0 * negative / (worth + 2.0),
            (1.0 - c_1 - c_mu) / (n * c_mu),
        ];
        let alpha = alpha.into_iter().fold(f64::INFINITY, f64::min);
        let plus: f64 = raw.iter().filter(|&&w| w > 0.0).sum();
        let minus: f64 = -raw.iter().filter(|&&w| w < 0.0).sum::<f64>();
        let weights: Vec<f64> =
            raw.iter().map(|&w| if w >= 0.0 { w / plus } else { alpha * w / minus }).collect();

        self.generation += 1;
        let best = |i: usize| (0..mu).map(|k| weights[k] * steps[k][i]).sum::<f64>();
        let best: Vec<f64> = dimensions.clone().map(best).collect();
        let white = self.whitened(&best);
        let expected = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
        for i in dimensions.clone() {
            self.mean[i] += self.step * best[i];
            self.step_path[i] =
                (1.0 - c_s) * self.step_path[i] + (c_s * (2.0 - c_s) * worth).sqrt() * white[i];
        }
        let length = self.step_path.iter().map(|&x| square(x)).sum::<f64>().sqrt();
        let bound = (1.4 + 2.0 / (n + 1.0)) * expected;
        let moves = length / (1.0 - (1.0 - c_s).powi(2 * self.generation)).sqrt() < bound;
        self.stalled += usize::from(!moves);
        let h = if moves { 1.0 } else { 0.0 };
        for i in dimensions.clone() {
            self.path[i] =
                (1.0 - c_c) * self.path[i] + h * (c_c * (2.0 - c_c) * worth).sqrt() * best[i];
        }
        let long = |k: usize| self.whitened(&steps[k]).iter().map(|&x| square(x)).sum::<f64>();
        let rated: Vec<f64> = (0..count)
            .map(|k| if weights[k] >= 0.0 { weights[k] } else { weights[k] * n / long(k) })
            .collect();
        let lost = (1.0 - h) * c_c * (2.0 - c_c);
        let kept = 1.0 + c_1 * lost - c_1 - c_mu * weights.iter().sum::<f64>();
        for i in dimensions.clone() {
            for j in dimensions.clone() {
                let part = |k: usize| rated[k] * steps[k][i] * steps[k][j];
                let entry = &mut self.covariance[i * dimensions.len() + j];
                *entry = kept * *entry
                    + c_1 * self.path[i] * self.path[j]
                    + c_mu * (0..count).map(part).sum::<f64>();
            }
        }
        self.step *= (c_s / d_s * (length / expected - 1.0)).exp();
    }
}

fn assert_near(a: &[f64], b: &[f64], what: &str) {
    let size = b.iter().fold(0.0, |size: f64, b| size.max(b.abs()));
    let near = std::iter::zip(a, b).all(|(a, b)| (a - b).abs() <= 1e-9 * size);
    assert!(near, "{what}: {a:?} {b:?}");
}

#[test]
fn a_generation_learns_what_the_tutorial_says() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    // So far from the bottom that the step has to grow first, and the path stands still meanwhile.
    let mut run = Run::new(vec![4.0, -3.0, 2.0, 1.0, -5.0], 0.01, 8);
    let mut tutorial = Tutorial::of(&run);
    for generation in 0..80 {
        let height = |x: &Vec<f64>| {
            let term = |(i, x): (usize, &f64)| 4f64.powi(i as i32) * x * x;
            (x.iter().enumerate().map(term).sum::<f64>() + 3.0 * x[0] * x[4]) as f32
        };
        let scores: Vec<f32> = run.sample(&mut rng).iter().map(height).collect();
        let mut order: Vec<usize> = (0..8).collect();
        order.sort_by(|&a, &b| scores[a].total_cmp(&scores[b]));
        let steps: Vec<_> = order.iter().map(|&at| run.steps[at].clone()).collect();
        tutorial.update(&steps);
        run.update(&scores);
        assert_near(&run.mean, &tutorial.mean, &format!("mean {generation}"));
        assert_near(&[run.step], &[tutorial.step], &format!("step {generation}"));
        assert_near(&run.step_path, &tutorial.step_path, &format!("its path {generation}"));
        assert_near(&run.path, &tutorial.path, &format!("path {generation}"));
        assert_near(&run.covariance, &tutorial.covariance, &format!("matrix {generation}"));
    }
    assert!((5..75).contains(&tutorial.stalled), "{}", tutorial.stalled);
}

#[test]
fn a_run_whose_lowest_scores_stand_still_ends_after_its_span() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut run = Run::new(vec![0.5; 4], 0.2, 8);
    // Ten generations and 30 · 4 / 8.
    for generation in 1..=25 {
        run.sample(&mut rng);
        run.update(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        assert_eq!(run.has_ended(1e-4), generation == 25, "{generation}");
    }
    // A lower one among them is enough to go on.
    run.sample(&mut rng);
    run.update(&[0.9, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    assert!(!run.has_ended(1e-4));
    // Scores that are all alike end it at once.
    run.sample(&mut rng);
    run.update(&[0.9; 8]);
    assert!(run.has_ended(1e-4));
}
