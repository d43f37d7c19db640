//! Where a fit starts from: all combinations of the starts of the parameters, or a few of them for laws that trace rays. Parameters
//! in which readings are linear (the level of a law, its Lambert floor, what stays specular) are solved for as non-negative least
//! squares.

use super::problem::Problem;
use crate::forward::Effort;
use crate::linear::inverse;
use crate::method::{Body, BuildError, Parameter};

/// Shares below which a solution stays inside the bounds of its parameter.
const INSIDE: f64 = 1.01;
/// The least share of what a parameter would be without the others.
const SOME: f64 = 0.02;
/// The share of that with which each of two laws starts.
const HALF: f64 = 0.5;

impl Problem<'_> {
    /// Points to start from: all combinations of the parameters' starts, the linear ones solved for.
    pub(super) fn starts(&self) -> Vec<Vec<f64>> {
        let of = |p: &Parameter| match (p.name, self.options.body) {
            ("ior", Body::Dielectric { ior }) => vec![ior.clamp(1.06, 3.9)],
            _ if p.starts.is_empty() => vec![1.0],
            _ => p.starts.to_vec(),
        };
        let of_each: Vec<Vec<f64>> = self.parameters.iter().map(of).collect();
        if self.is_traced() {
            return one_by_one(&of_each);
        }
        let mut points = vec![Vec::new()];
        for starts in of_each {
            points = points
                .iter()
                .flat_map(|point: &Vec<f64>| {
                    starts.iter().map(move |s| [point.as_slice(), &[*s]].concat())
                })
                .collect();
        }
        for point in &mut points {
            self.solve_linear(point);
        }
        points
    }

    /// Sets the linear parameters to their least-squares values, no higher than there is light.
    pub(super) fn solve_linear(&self, point: &mut [f64]) {
        let places: Vec<usize> =
            (0..self.parameters().len()).filter(|&k| self.parameters()[k].is_linear).collect();
        if !places.iter().any(|&k| self.parameters()[k].is_level) {
            return;
        }
        let Some(parts) = self.linear_parts(point, &places) else { return };
        let Some(mut solved) = parts.solve() else { return };
        let is_level = |place: usize| self.parameters()[places[place]].is_level;
        let levels: Vec<usize> = (0..places.len()).filter(|&place| is_level(place)).collect();
        if levels.len() > 1 && levels.iter().any(|&place| solved[place] <= 0.0) {
            // of two laws that are both there none is nothing
            for &place in &levels {
                solved[place] = HALF * parts.alone(place);
            }
        }
        let mut found = point.to_vec();
        for (place, (&k, value)) in places.iter().zip(&solved).enumerate() {
            let p = &self.parameters()[k];
            let (least, most) = (p.bounds.0 * INSIDE, p.bounds.1 / INSIDE);
            // what ends at nothing may be there all the same: a start must not forbid it
            let alone = (SOME * parts.alone(place)).max(least);
            let low = if p.is_level { alone } else { alone.max(1e-3 * self.unit_of(k)) };
            found[k] = value.clamp(low.min(most), most);
        }
        let build = |values: &[f64]| self.simulate(values, Effort::Draft).err();
        if let Some(BuildError::TooBright { scattered }) = build(&found) {
            for &k in &places {
                found[k] *= 0.95 / scattered;
            }
        }
        point.copy_from_slice(&found);
    }

    /// A value at which a linear parameter makes readings of the size of the measured ones.
    fn unit_of(&self, k: usize) -> f64 {
        if self.parameters()[k].unit.is_empty() { 1.0 } else { self.largest().min(1.0) }
    }

    /// The readings without any of the linear parameters, and what each adds.
    fn linear_parts(&self, point: &[f64], places: &[usize]) -> Option<Parts> {
        let mut none = point.to_vec();
        for &k in places {
            none[k] = self.parameters()[k].none.unwrap_or(self.parameters()[k].bounds.0);
        }
        let at = |values: &[f64]| self.simulate(values, Effort::Draft).map(|r| r.map(|r| r.values));
        let base = at(&none).ok()??;
        let mut columns = Vec::with_capacity(places.len());
        for &k in places {
            let mut unit = self.unit_of(k);
            let more = loop {
                let mut probe = none.clone();
                probe[k] = unit;
                match at(&probe) {
                    Ok(Some(values)) => break values,
                    Err(BuildError::TooBright { scattered }) if scattered > 1.0 => {
                        unit *= 0.5 / scattered;
                    }
                    _ => return None,
                }
            };
            let by = unit - none[k];
            columns.push(more.iter().zip(&base).map(|(more, base)| (more - base) / by).collect());
        }
        let weights =
            self.measured().iter().map(|&m| self.objective().weight2(m, self.largest())).collect();
        let rest = self.measured().iter().zip(&base).map(|(m, base)| m - base).collect();
        Some(Parts { columns, weights, rest })
    }
}

/// The middle starts of all parameters, and each other start of one of them: where a simulation takes long.
fn one_by_one(of_each: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let middle: Vec<f64> = of_each.iter().map(|starts| starts[starts.len() / 2]).collect();
    let mut points = vec![middle.clone()];
    for (k, starts) in of_each.iter().enumerate() {
        for (_, start) in starts.iter().enumerate().filter(|(at, _)| *at != starts.len() / 2) {
            let mut point = middle.clone();
            point[k] = *start;
            points.push(point);
        }
    }
    points
}

/// A linear problem.
struct Parts {
    columns: Vec<Vec<f64>>,
    weights: Vec<f64>,
    rest: Vec<f64>,
}

impl Parts {
    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        self.weights.iter().zip(a.iter().zip(b)).map(|(w, (a, b))| w * a * b).sum()
    }

    /// The solution of one parameter if the others were nothing.
    fn alone(&self, k: usize) -> f64 {
        let column = &self.columns[k];
        let found = self.dot(column, &self.rest) / self.dot(column, column);
        if found.is_finite() { found.max(0.0) } else { 0.0 }
    }

    /// The non-negative solution of least squares: the best of those of all subsets, which are few.
    fn solve(&self) -> Option<Vec<f64>> {
        let n = self.columns.len();
        let subsets = (1_u32..1 << n.min(6)).filter_map(|set| {
            let of: Vec<usize> = (0..n).filter(|k| set >> k & 1 == 1).collect();
            let row = |i: &usize| {
                of.iter().map(|j| self.dot(&self.columns[*i], &self.columns[*j])).collect()
            };
            let normal: Vec<Vec<f64>> = of.iter().map(row).collect();
            let right: Vec<f64> =
                of.iter().map(|i| self.dot(&self.columns[*i], &self.rest)).collect();
            let product = |row: &Vec<f64>| row.iter().zip(&right).map(|(a, b)| a * b).sum::<f64>();
            let found: Vec<f64> = inverse(&normal)?.iter().map(product).collect();
            let is_sound = found.iter().all(|x| x.is_finite() && *x >= 0.0);
            let fall: f64 = found.iter().zip(&right).map(|(x, b)| x * b).sum();
            let mut all = vec![0.0; n];
            of.iter().zip(&found).for_each(|(&k, &x)| all[k] = x);
            is_sound.then_some((fall, all))
        });
        subsets.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, all)| all)
    }
}

#[cfg(test)]
mod tests {
    use super::Parts;

    #[test]
    fn what_would_be_negative_is_nothing() {
        let (a, b) = (vec![1.0, 0.0, 1.0], vec![0.0, 1.0, 1.0]);
        let solve = |x: f64, y: f64| {
            let rest = a.iter().zip(&b).map(|(a, b)| x * a + y * b).collect();
            Parts { columns: vec![a.clone(), b.clone()], weights: vec![1.0; 3], rest }.solve()
        };
        let found = solve(2.0, 3.0).unwrap();
        assert!((found[0] - 2.0).abs() < 1e-12 && (found[1] - 3.0).abs() < 1e-12);
        // of 2 a - b the part along a alone
        let found = solve(2.0, -1.0).unwrap();
        assert!((found[0] - 1.5).abs() < 1e-12 && found[1].abs() <= 0.0, "{found:?}");
    }
}
