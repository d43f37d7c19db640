//! Peaks of a law that lie between nodes.

use std::f64::consts::PI;

use super::{At, Refined};

impl Refined<'_> {
    /// The peaks that interpolation does not reach.
    pub(super) fn missed_peaks(&self, at: &At, values: &[f64]) -> Vec<[f64; 2]> {
        let grid = self.grid(at);
        let mut peaks = self.peaks(at);
        let misses = |peak: &[f64; 2]| {
            let is = self.over(at, *peak);
            let seen = grid.value(values, *peak, self.layout.interpolation);
            (seen - is).abs() > 0.3 * self.options.tolerance * is
        };
        peaks.retain(misses);
        peaks
    }

    /// Where an incidence has its largest values: uphill from the best node or middle of every radius that is better than its neighbours.
    fn peaks(&self, at: &At) -> Vec<[f64; 2]> {
        let azimuths = self.around.halves();
        let mut profile = Vec::new();
        for r in self.radii.halves() {
            let values = azimuths.iter().map(|a| ([r, *a], self.over(at, [r, *a])));
            profile.push(values.fold(([r, 0.0], 0.0), |m, v| if v.1 > m.1 { v } else { m }));
        }
        let mut tops: Vec<([f64; 2], f64)> = Vec::new();
        for k in 0..profile.len() {
            let side = |k: Option<usize>| k.and_then(|k| profile.get(k)).map_or(0.0, |p| p.1);
            if profile[k].1 > 0.0 && profile[k].1 >= side(k.checked_sub(1)).max(side(Some(k + 1))) {
                tops.push(profile[k]);
            }
        }
        tops.sort_by(|a, b| b.1.total_cmp(&a.1));
        tops.truncate(8);
        let tops: Vec<_> = tops.into_iter().map(|(start, _)| self.climb(at, start)).collect();
        let best = tops.iter().map(|top| top.1).fold(0.0, f64::max);
        tops.into_iter().filter(|top| top.1 > 0.8 * best).map(|top| top.0).collect()
    }

    /// Uphill, along one coordinate after the other.
    fn climb(&self, at: &At, start: [f64; 2]) -> ([f64; 2], f64) {
        let axes = [&self.radii.nodes, &self.around.nodes];
        let gap = |k: usize| {
            let high = axes[k].partition_point(|x| *x <= start[k]).clamp(1, axes[k].len() - 1);
            axes[k][high] - axes[k][high - 1]
        };
        let ends = axes.map(|axis| axis.last().copied().unwrap_or(0.0));
        let mut steps = [gap(0), gap(1)];
        let (mut best, mut most) = (start, self.over(at, start));
        for _ in 0..40 {
            for k in [0, 1] {
                for sign in [-1.0, 1.0] {
                    let mut next = best;
                    next[k] = (best[k] + sign * steps[k]).clamp(0.0, ends[k]);
                    let here = self.over(at, next);
                    if here > most {
                        (best, most) = (next, here);
                    }
                }
                steps[k] *= 0.7;
            }
        }
        // a full turn is the first node again
        if !self.mirrored && best[1] >= 2.0 * PI {
            best[1] = 0.0;
        }
        (best, most)
    }
}
