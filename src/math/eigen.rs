//! Eigenvalues and eigenvectors of symmetric matrices by Jacobi's rotations: Golub and Van Loan (2013), *Matrix
//! computations*, section 8.5. Matrices are square, row after row.

/// Sweeps over all pairs of axes; matrices of a hundred rows need about ten.
const SWEEPS: usize = 30;

/// The eigenvalues of the `n` × `n` matrix `a`, and its unit eigenvectors as the columns of a matrix.
pub fn symmetric(mut a: Vec<f64>, n: usize) -> (Vec<f64>, Vec<f64>) {
    let mut vectors = vec![0.0; n * n];
    (0..n).for_each(|i| vectors[i * n + i] = 1.0);
    let total: f64 = a.iter().map(|x| x * x).sum();
    for _ in 0..SWEEPS {
        let pairs = || (0..n).flat_map(|p| (p + 1..n).map(move |q| (p, q)));
        let off: f64 = pairs().map(|(p, q)| a[p * n + q] * a[p * n + q]).sum();
        if off <= f64::EPSILON * f64::EPSILON * total {
            break;
        }
        for (p, q) in pairs() {
            if a[p * n + q] != 0.0 {
                let turn = rotation(a[p * n + p], a[q * n + q], a[p * n + q]);
                (0..n).for_each(|k| rotate(&mut a, [k * n + p, k * n + q], turn));
                (0..n).for_each(|k| rotate(&mut a, [p * n + k, q * n + k], turn));
                (0..n).for_each(|k| rotate(&mut vectors, [k * n + p, k * n + q], turn));
            }
        }
    }
    ((0..n).map(|i| a[i * n + i]).collect(), vectors)
}

/// Cosine and sine of the rotation that makes the entry `pq` 0.
fn rotation(pp: f64, qq: f64, pq: f64) -> (f64, f64) {
    let cot = (qq - pp) / (2.0 * pq);
    let tan = 1.0_f64.copysign(cot) / (cot.abs() + cot.hypot(1.0));
    let cos = 1.0 / tan.hypot(1.0);
    (cos, tan * cos)
}

fn rotate(a: &mut [f64], [i, j]: [usize; 2], (cos, sin): (f64, f64)) {
    (a[i], a[j]) = (cos * a[i] - sin * a[j], sin * a[i] + cos * a[j]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn vectors_and_values_make_the_matrix_again() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for n in [1, 2, 5, 12, 40] {
            let root: Vec<f64> = (0..n * n).map(|_| rng.random_range(-1.0..1.0)).collect();
            let entry = |i: usize, j: usize| -> f64 {
                (0..n).map(|k| root[i * n + k] * root[j * n + k]).sum()
            };
            let a: Vec<f64> = (0..n * n).map(|at| entry(at / n, at % n)).collect();
            let (values, vectors) = symmetric(a.clone(), n);
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let row = |i: usize, k: usize| vectors[i * n + k];
                let again: f64 = (0..n).map(|k| row(i, k) * values[k] * row(j, k)).sum();
                assert!((again - a[i * n + j]).abs() < 1e-12 * n as f64, "{n}: {i} {j}");
                let product: f64 = (0..n).map(|k| row(k, i) * row(k, j)).sum();
                let unit = if i == j { 1.0 } else { 0.0 };
                assert!((product - unit).abs() < 1e-13 * n as f64, "{n}: {i} {j}");
            }
        }
    }
}
