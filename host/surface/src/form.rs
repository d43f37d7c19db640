//! Form removal: the form that is subtracted from a map before its roughness is computed.

use crate::heightmap::HeightMap;
use crate::linear::inverse;

/// The form that is removed, by least squares over the points with a height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
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

/// Terms of the richest form.
const MOST_TERMS: usize = 6;

impl Form {
    /// The word in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "nothing",
            Self::Mean => "mean",
            Self::Plane => "plane",
            Self::Quadratic => "quadratic",
        }
    }

    /// Powers of x and y of the terms.
    fn terms(self) -> &'static [(i32, i32)] {
        const TERMS: [(i32, i32); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];
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
    pub fn removed(self, map: &HeightMap) -> HeightMap {
        let fitted = self.fitted(map);
        map.clone().map(|col, row, h| h - fitted.height_um(col, row))
    }

    /// The form itself, as [`removed`](Self::removed) takes it away: the surface of this kind nearest to the
    /// points with a height.
    pub fn fitted(self, map: &HeightMap) -> FittedForm {
        let mut form = FittedForm {
            nx: map.nx(),
            ny: map.ny(),
            terms: self.terms().to_vec(),
            coefficients_um: Vec::new(),
        };
        form.terms
            .retain(|&(i, j)| (i == 0 || form.nx > i as usize) && (j == 0 || form.ny > j as usize));
        let p = form.terms.len();
        let mut normal = vec![vec![0.0; p]; p];
        let mut right = vec![0.0; p];
        for (col, row, h) in map.points() {
            let v = form.powers(col, row);
            for i in 0..p {
                right[i] += v[i] * h;
                for j in 0..=i {
                    normal[i][j] += v[i] * v[j];
                    normal[j][i] = normal[i][j];
                }
            }
        }
        let Some(inverse) = inverse(&normal) else {
            if self == Self::Mean || p <= 1 {
                form.terms = Vec::new();
                return form;
            }
            return Self::Mean.fitted(map);
        };
        form.coefficients_um =
            inverse.iter().map(|r| r.iter().zip(&right).map(|(a, b)| a * b).sum()).collect();
        form
    }
}

/// A form that was fitted to a map.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedForm {
    nx: usize,
    ny: usize,
    terms: Vec<(i32, i32)>,
    /// One per term, um.
    coefficients_um: Vec<f64>,
}

impl FittedForm {
    /// Its height at a point of the map, missing or not, in um.
    pub fn height_um(&self, col: usize, row: usize) -> f64 {
        self.powers(col, row).iter().zip(&self.coefficients_um).map(|(v, c)| v * c).sum()
    }

    /// The terms at a point. Powers of coordinates from -1 to 1 are nearly independent.
    fn powers(&self, col: usize, row: usize) -> [f64; MOST_TERMS] {
        let unit = |k: usize, n: usize| {
            if n > 1 { 2.0 * k as f64 / (n - 1) as f64 - 1.0 } else { 0.0 }
        };
        let (x, y) = (unit(col, self.nx), unit(row, self.ny));
        let mut powers = [0.0; MOST_TERMS];
        for (power, &(i, j)) in powers.iter_mut().zip(&self.terms) {
            *power = x.powi(i) * y.powi(j);
        }
        powers
    }
}

#[cfg(test)]
mod tests {
    use super::Form;
    use crate::HeightMap;

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
        assert!(largest(&Form::Plane.removed(&plane)) < 1e-12);
        assert!(largest(&Form::Mean.removed(&plane)) > 1.0);
        assert!(largest(&Form::Quadratic.removed(&bowl)) < 1e-11);
        assert!(largest(&Form::Plane.removed(&bowl)) > 0.1);
        assert_eq!(Form::None.removed(&bowl), bowl);
    }

    #[test]
    fn one_row_and_missing_points_are_no_trouble() {
        let row = map(9, 1, |x, _| 2.0 * x + 1.0);
        assert!(largest(&Form::Quadratic.removed(&row)) < 1e-12);
        let mut heights: Vec<f64> = (0..100).map(|k| f64::from(k % 10) + 7.0).collect();
        heights[13] = f64::NAN;
        let holed = HeightMap::new((10, 10), (1.0, 1.0), heights).unwrap();
        let flat = Form::Plane.removed(&holed);
        assert!(largest(&flat) < 1e-12 && flat.height_um(3, 1).is_none());
        let point = map(1, 1, |_, _| 3.0);
        assert!(largest(&Form::Plane.removed(&point)) < 1e-12);
    }
}
