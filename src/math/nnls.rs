//! Non-negative least squares.

/// The `x ≥ 0` with the least `|Ax − b|²`, given `AᵀA` row after row and `Aᵀb`: the active set method of Lawson and Hanson
/// (1974, *Solving Least Squares Problems*, chapter 23), on the normal equations as in Bro and de Jong (1997).
///
/// # Panics
/// Unless `gram` has the square of the entries of `moments`.
pub fn nnls(gram: &[f64], moments: &[f64]) -> Vec<f64> {
    let n = moments.len();
    assert_eq!(gram.len(), n * n, "a square matrix");
    let scale = (0..n).map(|i| gram[i * n + i]).fold(0.0, f64::max);
    let (mut x, mut free) = (vec![0.0; n], vec![false; n]);
    // Each round lowers the residual, so that no set comes twice; rounding might have it otherwise.
    for _ in 0..3 * n {
        let gain = |i: usize| moments[i] - (0..n).map(|j| gram[i * n + j] * x[j]).sum::<f64>();
        let most = (0..n).filter(|&i| !free[i]).max_by(|&a, &b| gain(a).total_cmp(&gain(b)));
        let Some(next) = most.filter(|&i| gain(i) > 1e-12 * scale * (1.0 + moments[i].abs()))
        else {
            break;
        };
        free[next] = true;
        while free.iter().any(|&is| is) {
            let solved = solve(gram, moments, &free, scale);
            let negative = |&i: &usize| free[i] && solved[i] <= 0.0;
            let step = |i: usize| x[i] / (x[i] - solved[i]);
            let blocked = (0..n).filter(negative).map(step).reduce(f64::min);
            let share = blocked.map_or(1.0, |share| if share.is_finite() { share } else { 0.0 });
            for i in 0..n {
                x[i] += share * (solved[i] - x[i]);
                if blocked.is_some() && free[i] && solved[i] <= 0.0 && x[i] <= 1e-15 {
                    (x[i], free[i]) = (0.0, false);
                }
            }
            if blocked.is_none() {
                break;
            }
        }
    }
    x
}

/// The unconstrained solution over the free entries, 0 elsewhere, by Cholesky's decomposition.
fn solve(gram: &[f64], moments: &[f64], free: &[bool], scale: f64) -> Vec<f64> {
    let n = moments.len();
    let at: Vec<usize> = (0..n).filter(|&i| free[i]).collect();
    let k = at.len();
    let mut lower = vec![0.0; k * k];
    for i in 0..k {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|m| lower[i * k + m] * lower[j * k + m]).sum();
            let rest = gram[at[i] * n + at[j]] - dot;
            // Two lights in one place: either of them may have it all.
            lower[i * k + j] = if i == j {
                rest.max(1e-14 * scale).sqrt().max(f64::MIN_POSITIVE)
            } else {
                rest / lower[j * k + j]
            };
        }
    }
    let mut y = vec![0.0; k];
    for i in 0..k {
        let dot: f64 = (0..i).map(|m| lower[i * k + m] * y[m]).sum();
        y[i] = (moments[at[i]] - dot) / lower[i * k + i];
    }
    let mut x = vec![0.0; n];
    for i in (0..k).rev() {
        let dot: f64 = (i + 1..k).map(|m| lower[m * k + i] * x[at[m]]).sum();
        x[at[i]] = (y[i] - dot) / lower[i * k + i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn gram(a: &[Vec<f64>]) -> Vec<f64> {
        let dot = |i: usize, j: usize| std::iter::zip(&a[i], &a[j]).map(|(x, y)| x * y).sum();
        (0..a.len())
            .flat_map(|i| (0..a.len()).map(move |j| (i, j)))
            .map(|(i, j)| dot(i, j))
            .collect()
    }

    fn moments(a: &[Vec<f64>], b: &[f64]) -> Vec<f64> {
        a.iter().map(|column| std::iter::zip(column, b).map(|(x, y)| x * y).sum()).collect()
    }

    #[test]
    fn what_would_be_negative_is_zero() {
        // Columns (1, 1) and (0, 1): b = (1, 0) asks for x = (1, −1); the best without is (1/2, 0).
        let a = [vec![1.0, 1.0], vec![0.0, 1.0]];
        let x = nnls(&gram(&a), &moments(&a, &[1.0, 0.0]));
        assert!((x[0] - 0.5).abs() < 1e-12 && x[1] == 0.0, "{x:?}");
        assert_eq!(nnls(&gram(&a), &moments(&a, &[-1.0, -1.0])), [0.0, 0.0]);
        // The same column twice, and one of nothing.
        let a = [vec![1.0, 2.0], vec![1.0, 2.0], vec![0.0, 0.0]];
        let x = nnls(&gram(&a), &moments(&a, &[2.0, 4.0]));
        assert!((x[0] + x[1] - 2.0).abs() < 1e-6 && x[2] == 0.0, "{x:?}");
    }

    proptest! {
        #[test]
        fn the_conditions_of_the_optimum_hold(
            entries in prop::collection::vec(0f64..1.0, 60), b in prop::collection::vec(-1f64..1.0, 12),
        ) {
            let a: Vec<Vec<f64>> = entries.chunks(12).map(<[f64]>::to_vec).collect();
            let (gram, moments) = (gram(&a), moments(&a, &b));
            let x = nnls(&gram, &moments);
            for i in 0..5 {
                let gain = moments[i] - (0..5).map(|j| gram[i * 5 + j] * x[j]).sum::<f64>();
                prop_assert!(x[i] >= 0.0 && gain < 1e-8, "{x:?} {gain}");
                prop_assert!(x[i] == 0.0 || gain.abs() < 1e-8, "{x:?} {gain}");
            }
        }
    }
}
