//! Quantiles and leans: what a finished lobe is sampled with.

use asperity_core::bsdf::Bsdf;
use asperity_core::table::{BsdfTableRef, Storage};

use crate::parallel;

use super::grid::LobeGrid;

/// Share of a lobe beyond its last quantile.
const LEFT_OUT: f64 = 1e-6;
/// Largest lean: the tails in azimuth are kept alive.
const MOST_LEAN: f64 = 0.9;

/// Quantiles and leans of all incidences.
pub(super) fn samples<S: Storage>(
    grid: &LobeGrid,
    table: &BsdfTableRef<'_, S>,
) -> (Vec<u16>, Vec<i8>) {
    let shape = grid.header.shape;
    let each = parallel::map(usize::from(shape.incidences), &|j| {
        one(grid, table, grid.cosine(j), usize::from(shape.intervals))
    });
    // what a facet reaches ends elsewhere at each incidence: between two of them no light is beyond both ends
    let ends: Vec<u16> = each.iter().filter_map(|(q, _)| q.last().copied()).collect();
    let reach = |j: usize| ends.iter().take(j + 2).skip(j.saturating_sub(1)).max().copied();
    let (mut quantiles, mut leans) = (Vec::new(), Vec::new());
    for (j, (mut q, l)) in each.into_iter().enumerate() {
        if let (Some(last), Some(end)) = (q.last_mut(), reach(j)) {
            *last = end;
        }
        quantiles.extend(q);
        leans.extend(l);
    }
    (quantiles, leans)
}

fn one<S: Storage>(
    grid: &LobeGrid,
    table: &BsdfTableRef<'_, S>,
    cos: f64,
    intervals: usize,
) -> (Vec<u16>, Vec<i8>) {
    let beam = grid.beam(cos);
    // r, flux, flux times the azimuth's cosine; one row a ring
    let mut rings: Vec<[f64; 3]> = Vec::new();
    grid.over_facets(&beam, |spot| {
        let flux = table.ars(beam.wi, spot.turned.wo) / spot.turned.jacobian * spot.weight;
        match rings.last_mut() {
            Some(ring) if ring[0].to_bits() == spot.r.to_bits() => {
                ring[1] += flux;
                ring[2] += flux * spot.p;
            }
            _ => rings.push([spot.r, flux, flux * spot.p]),
        }
    });
    let all: f64 = rings.iter().map(|r| r[1]).sum();
    let count = intervals as u16;
    if all <= 0.0 {
        let even = (0..=count).map(|k| (65535 * u32::from(k) / u32::from(count)) as u16).collect();
        return (even, vec![0; intervals]);
    }
    let mut quantiles = vec![0_u16];
    let mut leans = Vec::with_capacity(intervals);
    // the outermost ring ends at infinity: that of a wave in transmission at grazing incidence holds up to 1 % of the light, where
    // q_z vanishes
    let half = 0.5 / f64::from(grid.rings());
    let (mut sum, mut last) = (0.0, 0.0);
    let mut own = [0.0; 2];
    for &[r, flux, moment] in &rings {
        let end = r + half;
        last = end;
        let (mut from, mut rest, mut along) = (r - half, flux, moment);
        while leans.len() + 1 < intervals {
            let wanted = all * (leans.len() + 1) as f64 / intervals as f64 - sum;
            if wanted > rest {
                break;
            }
            let share = if rest > 0.0 { wanted / rest } else { 1.0 };
            // uniform in r^2 within a ring
            let at = (from * from + share * (end * end - from * from)).sqrt();
            leans.push(lean([own[0] + wanted, own[1] + share * along]));
            quantiles.push((at * at * 65536.0).round().min(65535.0) as u16);
            own = [0.0; 2];
            (from, rest, along) = (at, rest - wanted, along * (1.0 - share));
            sum += wanted;
        }
        own = [own[0] + rest, own[1] + along];
        sum += rest;
        let left: f64 = all - sum;
        if leans.len() + 1 == intervals && left <= LEFT_OUT * all {
            break;
        }
    }
    leans.push(lean(own));
    quantiles.push((last * last * 65536.0).ceil().min(65535.0) as u16);
    ascend(&mut quantiles);
    (quantiles, leans)
}

fn lean([flux, moment]: [f64; 2]) -> i8 {
    let mean = if flux > 0.0 { (moment / flux).clamp(-MOST_LEAN, MOST_LEAN) } else { 0.0 };
    (mean * 128.0).round() as i8
}

/// Makes whole numbers ascend strictly, by as little as it takes.
fn ascend(numbers: &mut [u16]) {
    for k in 1..numbers.len() {
        numbers[k] = numbers[k].max(numbers[k - 1].saturating_add(1));
    }
    let mut most = u16::MAX;
    for number in numbers.iter_mut().rev() {
        *number = (*number).min(most);
        most = number.saturating_sub(1);
    }
}
