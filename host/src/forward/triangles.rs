//! Linear systems of a diagonal that outweighs the rest.

/// Splits a matrix into triangles, in place; it is `1 - M` with `M` of norm below 1, so that no row need be exchanged.
pub(super) fn factorise(matrix: &mut [f64], n: usize) {
    for k in 0..n {
        let (above, below) = matrix.split_at_mut((k + 1) * n);
        let pivot_row = &above[k * n..];
        let inverse = 1.0 / pivot_row[k];
        for row in below.chunks_exact_mut(n) {
            let factor = row[k] * inverse;
            row[k] = factor;
            for (value, pivot) in row[k + 1..].iter_mut().zip(&pivot_row[k + 1..]) {
                *value -= factor * pivot;
            }
        }
    }
}

/// Solves with a matrix split by [`factorise`], in place.
pub(super) fn solve(factors: &[f64], n: usize, x: &mut [f64]) {
    for k in 0..n {
        let row = &factors[k * n..][..k];
        let sum: f64 = row.iter().zip(&x[..k]).map(|(f, x)| f * x).sum();
        x[k] -= sum;
    }
    for k in (0..n).rev() {
        let row = &factors[k * n..][..n];
        let sum: f64 = row[k + 1..].iter().zip(&x[k + 1..]).map(|(f, x)| f * x).sum();
        x[k] = (x[k] - sum) / row[k];
    }
}

#[cfg(test)]
mod tests {
    use super::{factorise, solve};

    #[test]
    fn a_solution_satisfies_its_system() {
        let n = 5;
        let entry = |i: usize, j: usize| {
            let off = 0.15 / (1.0 + (i as f64 - 1.7 * j as f64).abs());
            if i == j { 1.0 - off } else { -off }
        };
        let matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
        let right: Vec<f64> = (0..n).map(|k| 1.0 + k as f64).collect();
        let (mut factors, mut x) = (matrix.clone(), right.clone());
        factorise(&mut factors, n);
        solve(&factors, n, &mut x);
        for (row, wanted) in matrix.chunks(n).zip(&right) {
            let sum: f64 = row.iter().zip(&x).map(|(m, x)| m * x).sum();
            assert!((sum - wanted).abs() < 1e-13, "{sum} {wanted}");
        }
    }
}
