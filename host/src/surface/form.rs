//! Form removal: what is subtracted from a map before its roughness is looked at.

use super::HeightMap;
use crate::linear::inverse;

/// The form that is removed, by least squares over the points with a height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Nothing: heights as in the file.
    None,
    /// The mean height.
    Mean,
    /// The mean plane.
    #[default]
    Plane,
    /// The mean surface of second order.
    Quadratic,
}

/// Terms of the highest form.
const MOST_TERMS: usize = 6;

impl Form {
    /// Powers of x and y of the terms.
    fn terms(self) -> &'static [(i32, i32)] {
        const TERMS: [(i32, i32); MOST_TERMS] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
        match self {
            Self::None => &[],
            Self::Mean => &TERMS[..1],
            Self::Plane => &TERMS[..3],
            Self::Quadratic => &TERMS,
        }
    }

    /// The map without this form.
    ///
    /// One row or column has no slope or curvature across it; where the points do not determine the rest,
    /// the mean alone is removed.
    pub fn removed(self, map: HeightMap) -> HeightMap {
        // Powers of coordinates from -1 to 1 are nearly independent.
        let unit = |k: usize, n: usize| {
            if n > 1 { 2.0 * k as f64 / (n - 1) as f64 - 1.0 } else { 0.0 }
        };
        let (nx, ny) = (map.nx(), map.ny());
        let mut terms = self.terms().to_vec();
        terms.retain(|&(i, j)| (i == 0 || nx > i as usize) && (j == 0 || ny > j as usize));
        let powers = |col: usize, row: usize| {
            let (x, y) = (unit(col, nx), unit(row, ny));
            let mut powers = [0.0; MOST_TERMS];
            for (power, &(i, j)) in powers.iter_mut().zip(&terms) {
                *power = x.powi(i) * y.powi(j);
            }
            powers
        };
        let p = terms.len();
        let mut normal = vec![vec![0.0; p]; p];
        let mut right = vec![0.0; p];
        for (col, row, h) in map.points() {
            let v = powers(col, row);
            for i in 0..p {
                right[i] += v[i] * h;
                for j in 0..=i {
                    normal[i][j] += v[i] * v[j];
                    normal[j][i] = normal[i][j];
                }
            }
        }
        let Some(inverse) = inverse(&normal) else {
            return if self == Self::Mean || p <= 1 { map } else { Self::Mean.removed(map) };
        };
        let coefficients: Vec<f64> =
            inverse.iter().map(|r| r.iter().zip(&right).map(|(a, b)| a * b).sum()).collect();
        map.map(|col, row, h| {
            h - powers(col, row).iter().zip(&coefficients).map(|(v, c)| v * c).sum::<f64>()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Form;
    use crate::surface::HeightMap;

    fn map(nx: usize, ny: usize, height: impl Fn(f64, f64) -> f64) -> HeightMap {
        let heights = (0..nx * ny).map(|k| height((k % nx) as f64, (k / nx) as f64)).collect();
        HeightMap::new((nx, ny), (0.5, 0.7), heights).unwrap()
    }

    fn largest(map: &HeightMap) -> f64 {
        map.points().map(|p| p.2.abs()).fold(0.0, f64::max)
    }

    #[test]
    fn each_form_removes_itself_and_leaves_the_next_order() {
        let plane = map(30, 20, |x, y| 5.0 + 0.3 * x - 0.1 * y);
        let bowl = map(30, 20, |x, y| 1.0 + 0.02 * x * x - 0.01 * x * y + 0.1 * y);
        assert!(largest(&Form::Plane.removed(plane.clone())) < 1e-12);
        assert!(largest(&Form::Mean.removed(plane.clone())) > 1.0);
        assert!(largest(&Form::Quadratic.removed(bowl.clone())) < 1e-11);
        assert!(largest(&Form::Plane.removed(bowl.clone())) > 0.1);
        assert_eq!(Form::None.removed(bowl.clone()), bowl);
    }

    #[test]
    fn one_row_and_missing_points_are_no_trouble() {
        let row = map(9, 1, |x, _| 2.0 * x + 1.0);
        assert!(largest(&Form::Quadratic.removed(row)) < 1e-12);
        let mut heights: Vec<f64> = (0..100).map(|k| f64::from(k % 10) + 7.0).collect();
        heights[13] = f64::NAN;
        let holed = HeightMap::new((10, 10), (1.0, 1.0), heights).unwrap();
        let flat = Form::Plane.removed(holed);
        assert!(largest(&flat) < 1e-12 && flat.height_um(3, 1).is_none());
        let point = map(1, 1, |_, _| 3.0);
        assert!(largest(&Form::Plane.removed(point)) < 1e-12);
    }
}
