//! Small symmetric positive systems.

/// Inverse of a small symmetric positive matrix by Cholesky, scaled to unit diagonal first; `None` if it
/// is singular to about 1e-12.
pub fn inverse(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let p = matrix.len();
    let scale: Vec<f64> = (0..p).map(|i| matrix[i][i].sqrt()).collect();
    if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
        return None;
    }
    let mut l = vec![vec![0.0; p]; p];
    for i in 0..p {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = matrix[i][j] / (scale[i] * scale[j]) - known;
            if i == j {
                if rest < 1e-12 {
                    return None;
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    // Columns of L^-1, then A^-1 = L^-T L^-1.
    let lower: Vec<Vec<f64>> = (0..p)
        .map(|k| {
            let mut y = vec![0.0; p];
            for i in k..p {
                let known: f64 = (k..i).map(|j| l[i][j] * y[j]).sum();
                y[i] = (if i == k { 1.0 } else { 0.0 } - known) / l[i][i];
            }
            y
        })
        .collect();
    let entry = |i: usize, j: usize| {
        let sum: f64 = lower[i].iter().zip(&lower[j]).map(|(a, b)| a * b).sum();
        sum / (scale[i] * scale[j])
    };
    Some((0..p).map(|i| (0..p).map(|j| entry(i, j)).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::inverse;

    #[test]
    fn the_inverse_of_a_known_matrix_and_the_refusal_of_a_singular_one() {
        // [[4, 2], [2, 3]] has the inverse [[3, -2], [-2, 4]] / 8
        let found = inverse(&[vec![4.0, 2.0], vec![2.0, 3.0]]).unwrap();
        for (row, exact) in found.iter().zip([[0.375, -0.25], [-0.25, 0.5]]) {
            assert!(row.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
        }
        assert!(inverse(&[vec![1.0, 1.0], vec![1.0, 1.0]]).is_none());
        assert!(inverse(&[vec![0.0]]).is_none());
    }
}
