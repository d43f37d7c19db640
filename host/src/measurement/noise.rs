//! The noise floor of a measurement: from its readings alone, or from the residuals of a fit.
//!
//! In the sense of the error figure \[Sokolov2022, eq. 18\]: RMS noise over all readings / largest
//! reading x 100. No reconstruction, however good, can have a smaller error than that.
//!
//! Two estimates, because "noise" has two meanings here:
//!
//! **Fluctuation**: the part of the readings that no smooth curve could follow. Within an incidence,
//! differences of order 3 to 8 remove whatever is locally a polynomial in theta; divided by the norm
//! of their binomial coefficients they leave the RMS of the independent part. Neighbouring readings
//! see nearly the same light where apertures overlap, and so does their noise: differences are taken
//! between readings more than one aperture apart. Of all orders and of two lags the smallest figure
//! counts, since what a too-low order leaves of the signal can only add. All differences enter, dark
//! and bright, so that noise which grows with the signal counts as it does in eq. (18).
//! Of the readings alone it *overestimates* where a lobe is as narrow as a few apertures, or steps are coarse against the
//! lobe: what changes direction within one lag looks like noise. So once there is a fit its residuals are differenced
//! instead ([`of_fit`]), which have no lobe; what a model misses within one lag still looks like noise, slower misfit does not. And it *includes* the sample's own grain
//! (speckle, single facets and caustics under a narrow beam), which is repeatable: the floor for a
//! model with a smooth BSDF, but not for one that follows the measured surface itself.
//! Without an aperture in the header it takes neighbouring readings, and then *underestimates* a scan
//! whose apertures overlap.
//!
//! Residuals are differenced where apertures touch, too: a misfit two steps long must not look like noise. Where a lobe is no more than three lags wide
//! neither estimate tells noise from misfit, and only a figure in the header or counts do ([`is_told`]).
//!
//! **Counting**: where readings are whole numbers of photons, or of traced rays, times a quantum,
//! their variance is quantum x reading (Poisson), whatever the grain of the sample. Readings count as counts only if
//! they behave so: none is below zero, and where few counts are
//! expected they scatter as counts do. Grain hides neither.

use super::{Measurement, Reading};

/// Orders of the differences of readings.
const ORDERS: std::ops::RangeInclusive<usize> = 3..=8;
/// Those of residuals, which have no lobe that low orders would leave.
const OF_RESIDUALS: std::ops::RangeInclusive<usize> = 1..=8;
/// With fewer differences there is no estimate.
const MIN_DIFFERENCES: usize = 30;
/// The share of the readings that are the dimmest.
const DIMMEST: f64 = 0.25;
/// Positions are equidistant up to this fraction of a step.
const STEP_TOLERANCE: f64 = 0.02;
/// More counts than this in one reading cannot be told from rounding to ten digits.
const MAX_COUNT: f64 = 1e7;
/// Share of the largest reading that a lobe has at least.
const LOBE: f64 = 0.05;
/// A count is a whole number up to this.
const COUNT_TOLERANCE: f64 = 0.02;
/// Pairs of readings with at most so many counts together are "few".
const FEW: f64 = 20.0;
/// Variance / mean of few counts, 1 for Poisson: from here, rounding of a smooth curve gives less ...
const DISPERSION_MIN: f64 = 0.7;
/// ... and noise of electronics more than this. Fixed on virtual scans, which give 1.0 to 1.5.
const DISPERSION_MAX: f64 = 2.0;

/// The noise floor, each figure as RMS over all readings / largest reading x 100.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseEstimate {
    /// Everything a smooth curve cannot follow, grain of the sample included.
    pub fluctuation_percent: f64,
    /// Order of the differences that gave it.
    pub order: usize,
    /// Shot noise alone; `None` where the readings are not counts.
    pub counting_percent: Option<f64>,
}

impl NoiseEstimate {
    /// The floor of a reconstruction that may follow the grain of the sample: shot noise where the
    /// readings are counts, all fluctuation otherwise.
    pub fn floor_percent(&self) -> f64 {
        let counting = self.counting_percent.unwrap_or(f64::INFINITY);
        self.fluctuation_percent.min(counting)
    }
}

/// Estimates the noise floor before there is a fit; `None` where too few readings stand at equal steps (fewer than 30
/// differences of order 3 beyond the aperture). An upper bound: narrow lobes add to it.
pub fn estimate(scan: &Measurement) -> Option<NoiseEstimate> {
    let runs = all_runs(scan);
    let values: Vec<f64> = scan.readings().iter().map(|reading| reading.value).collect();
    let (order, rms) = least(&runs, &values, ORDERS, Apart::Separate)?;
    let percent = |rms: f64| 100.0 * rms / scan.largest_reading();
    Some(NoiseEstimate {
        fluctuation_percent: percent(rms),
        order,
        counting_percent: counting(scan, &runs).map(percent),
    })
}

/// The noise floor without a fit, %: from the header, else an upper bound from the readings ([`estimate`]).
pub fn before_fit(scan: &Measurement) -> Option<f64> {
    let estimate = || estimate(scan).map(|noise| noise.floor_percent());
    scan.meta.noise_floor_percent.or_else(estimate)
}

/// The noise floor of a measurement beside a fit, % in the sense of eq. (18): from the header, else the least of the
/// estimates from the readings ([`estimate`]) and the residuals; never above the error of the fit itself.
///
/// `simulated` are the fitted readings in the order of the scan's, `rays_percent` their own noise where they come from
/// rays, which is taken off the residuals'. `None` where nothing is known.
pub fn of_fit(scan: &Measurement, simulated: &[f64], rays_percent: Option<f64>) -> Option<f64> {
    let residuals: Vec<f64> =
        scan.readings().iter().zip(simulated).map(|(reading, s)| reading.value - s).collect();
    let percent = |rms: f64| 100.0 * rms / scan.largest_reading();
    let squares: f64 = residuals.iter().map(|r| r * r).sum();
    let error = percent((squares / residuals.len().max(1) as f64).sqrt());
    let stated = scan.meta.noise_floor_percent.is_some();
    let runs = all_runs(scan);
    let left = |apart| least(&runs, &residuals, OF_RESIDUALS, apart).filter(|_| !stated);
    let left = [Apart::Touching, Apart::Separate].into_iter().filter_map(left);
    let left = left
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .and_then(|(_, rms)| without_rays(percent(rms), rays_percent));
    let floor = before_fit(scan).into_iter().chain(left).min_by(f64::total_cmp);
    // an error that is no number bounds nothing
    floor.map(|floor| if error < floor { error } else { floor })
}

/// Lags in the width of a lobe from which differences tell noise from what a law misses.
const TELLING: f64 = 3.0;

/// Whether the noise of a scan can be told from the misfit of a law: it stands in the header, the readings are counts, or the lobes are wide beside the
/// lag of the differences.
pub fn is_told(scan: &Measurement) -> bool {
    let runs = all_runs(scan);
    scan.meta.noise_floor_percent.is_some()
        || counting(scan, &runs).is_some()
        || widths_in_lags(scan, &runs).is_none_or(|width| width >= TELLING)
}

/// The median over the runs with a lobe of its full width at half maximum, in lags; `None` without one.
fn widths_in_lags(scan: &Measurement, runs: &[Run]) -> Option<f64> {
    let largest = scan.largest_reading();
    let width = |run: &Run| {
        let values = || scan.readings()[run.readings.clone()].iter().map(|r| r.value);
        let peak = values().fold(0.0, f64::max);
        let above = values().filter(|v| *v >= 0.5 * peak).count();
        (peak > LOBE * largest).then(|| above as f64 / run.touching as f64)
    };
    let mut widths: Vec<f64> = runs.iter().filter_map(width).collect();
    widths.sort_by(f64::total_cmp);
    widths.get(widths.len() / 2).copied()
}

/// A figure without the noise of the rays in it; `None` where that is most of it, and the rest is not known.
fn without_rays(percent: f64, rays_percent: Option<f64>) -> Option<f64> {
    let rays = rays_percent.unwrap_or(0.0);
    let rest = percent * percent - rays * rays;
    (rest >= 0.5 * percent * percent).then(|| rest.sqrt())
}

/// The least figure of all orders and lags, with its order.
fn least(
    runs: &[Run],
    values: &[f64],
    orders: std::ops::RangeInclusive<usize>,
    apart: Apart,
) -> Option<(usize, f64)> {
    let candidates = orders.flat_map(|order| [0, 1].map(|more| (order, more)));
    let figures = candidates.filter_map(|(order, more)| {
        let lag = |run: &Run| run.lag(apart) + more;
        Some((order, fluctuation(runs, values, order, &lag)?))
    });
    figures.min_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// Readings in one plane of observation at equal steps.
struct Run {
    /// Which of the scan's.
    readings: std::ops::Range<usize>,
    /// The smallest number of steps at which two apertures do not overlap.
    touching: usize,
    /// One step more, if they are as wide as that: the edge of an aperture is never sharp.
    separate: usize,
}

/// Which readings are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Apart {
    Touching,
    Separate,
}

impl Run {
    fn lag(&self, apart: Apart) -> usize {
        if apart == Apart::Touching { self.touching } else { self.separate }
    }
}

fn all_runs(scan: &Measurement) -> Vec<Run> {
    let mut first = 0;
    let mut found = Vec::new();
    for plane in scan.by_plane() {
        found.extend(runs(scan, plane.readings, first));
        first += plane.readings.len();
    }
    found
}

/// Those of a plane whose readings begin at `first`.
fn runs(scan: &Measurement, plane: &[Reading], mut first: usize) -> Vec<Run> {
    let spacing = |pair: &[Reading]| pair[1].theta_deg - pair[0].theta_deg;
    let mut spacings: Vec<f64> = plane.windows(2).map(spacing).collect();
    spacings.sort_by(f64::total_cmp);
    let Some(&step) = spacings.get(spacings.len() / 2) else {
        return Vec::new();
    };
    let aperture = scan.meta.aperture_deg.unwrap_or(0.0);
    let most = plane.len().max(1);
    let steps = aperture / step;
    let touching = ((steps * (1.0 - 1e-9)).ceil() as usize).clamp(1, most);
    let separate = ((steps * (1.0 + 1e-9)).floor() as usize).saturating_add(1).min(most);
    let regular = |a: &Reading, b: &Reading| {
        (b.theta_deg - a.theta_deg - step).abs() <= STEP_TOLERANCE * step
    };
    let pieces = plane.chunk_by(regular).map(|piece| {
        let readings = first..first + piece.len();
        first = readings.end;
        Run { readings, touching, separate }
    });
    pieces.collect()
}

/// RMS of the differences of one order, normalised so that independent noise gives its own RMS.
fn fluctuation(
    runs: &[Run],
    values: &[f64],
    order: usize,
    lag: &dyn Fn(&Run) -> usize,
) -> Option<f64> {
    let mut coefficients = vec![1.0];
    for k in 0..order {
        let last: f64 = coefficients[k];
        coefficients.push(-last * (order - k) as f64 / (k + 1) as f64);
    }
    let norm: f64 = coefficients.iter().map(|c| c * c).sum();
    let (mut sum, mut count) = (0.0, 0);
    for run in runs {
        let lag = lag(run);
        let values = values.get(run.readings.clone()).unwrap_or_default();
        for window in values.windows(order * lag + 1) {
            let near = window.iter().step_by(lag);
            let difference: f64 = near.zip(&coefficients).map(|(value, c)| value * c).sum();
            sum += difference * difference / norm;
            count += 1;
        }
    }
    (count >= MIN_DIFFERENCES).then(|| (sum / count as f64).sqrt())
}

/// RMS of the shot noise, if the readings are counts: each incidence with its own quantum, since
/// each may be divided by its own beam.
fn counting(scan: &Measurement, runs: &[Run]) -> Option<f64> {
    if scan.readings().iter().any(|reading| reading.value < 0.0) {
        return None;
    }
    let mut variance = 0.0;
    // squared differences and sums of pairs, of few counts and of more
    let (mut few, mut many) = ([0.0; 2], [0.0; 2]);
    let mut pairs = 0;
    for incidence in scan.by_incidence() {
        let quantum = quantum(incidence.readings)?;
        variance += incidence.readings.iter().map(|reading| quantum * reading.value).sum::<f64>();
        let of_scan = |run: &Run| &scan.readings()[run.readings.clone()];
        let sigma_deg = incidence.sigma_deg;
        let same = |run: &&Run| of_scan(run)[0].sigma_deg.total_cmp(&sigma_deg).is_eq();
        for run in runs.iter().filter(same) {
            let readings = of_scan(run);
            for (a, b) in readings.iter().zip(readings.iter().skip(run.separate)) {
                let [a, b] = [a, b].map(|reading| reading.value / quantum);
                let part = if a + b <= FEW { &mut few } else { &mut many };
                part[0] += (a - b) * (a - b);
                part[1] += a + b;
                pairs += usize::from(a + b > 0.5 && a + b <= FEW);
            }
        }
    }
    let dispersion = |part: [f64; 2]| part[0] / part[1];
    let poisson = pairs >= MIN_DIFFERENCES
        && (DISPERSION_MIN..=DISPERSION_MAX).contains(&dispersion(few))
        && (many[1] <= 0.0 || dispersion(many) >= DISPERSION_MIN);
    poisson.then(|| (variance / scan.readings().len() as f64).sqrt())
}

/// The noise of the dimmest readings: of normal noise, from the median of absolute second differences.
pub(crate) fn dim_noise(scan: &Measurement) -> f64 {
    let mut sorted: Vec<f64> = scan.readings().iter().map(|r| r.value).collect();
    sorted.sort_by(f64::total_cmp);
    let place = (DIMMEST * sorted.len() as f64) as usize;
    let Some(&most) = sorted.get(place) else { return 0.0 };
    let mut bends: Vec<f64> = scan
        .by_plane()
        .flat_map(|plane| plane.readings.windows(3))
        .filter(|three| three.iter().all(|r| r.value <= most))
        .map(|three| (three[0].value - 2.0 * three[1].value + three[2].value).abs())
        .collect();
    bends.sort_by(f64::total_cmp);
    // the median of |x| is 0.6745 sigma, and a second difference has six times the variance
    bends.get(bends.len() / 2).map_or(0.0, |median| median / (0.674_49 * 6.0_f64.sqrt()))
}

/// The number of which all readings are whole multiples, found upwards from the smallest gap.
fn quantum(readings: &[Reading]) -> Option<f64> {
    let mut values: Vec<f64> = readings.iter().map(|reading| reading.value).collect();
    values.push(0.0);
    values.sort_by(f64::total_cmp);
    let gaps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let mut quantum = gaps.filter(|&gap| gap > 0.0).fold(f64::INFINITY, f64::min);
    let positive = || values.iter().filter(|&&value| value > 0.0);
    for value in positive() {
        let count = (value / quantum).round();
        if !(1.0..=MAX_COUNT).contains(&count) {
            return None;
        }
        // each larger reading knows the quantum better
        quantum = value / count;
    }
    let whole = |value: f64| (value / quantum - (value / quantum).round()).abs() <= COUNT_TOLERANCE;
    positive().all(|&value| whole(value)).then_some(quantum)
}

#[cfg(test)]
mod tests {
    use super::super::{Metadata, csv};
    use super::*;

    /// Uniform in [0, 1), the same on every machine.
    fn uniforms(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// A lobe of `width_deg` (standard deviation) with values changed by `disturb`, step 0.1 deg.
    fn lobe(width_deg: f64, mut disturb: impl FnMut(f64) -> f64) -> Measurement {
        let reading = |k: i32| {
            let theta_deg = f64::from(k) / 10.0;
            let clean = (-0.5 * (theta_deg / width_deg).powi(2)).exp();
            Reading::in_plane(0.0, theta_deg, disturb(clean))
        };
        let meta = Metadata { aperture_deg: Some(0.6), ..Metadata::default() };
        Measurement::new(meta, (-900..=900).map(reading).collect()).unwrap()
    }

    #[test]
    fn steps_far_below_the_aperture_are_no_trouble() {
        let reading = |theta_deg| Reading::in_plane(0.0, theta_deg, 1.0);
        let meta = Metadata { aperture_deg: Some(0.6), ..Metadata::default() };
        let readings = vec![reading(0.0), reading(1e-20), reading(2e-20)];
        let scan = Measurement::new(meta, readings).unwrap();
        assert!(estimate(&scan).is_none());
    }

    #[test]
    fn shot_noise_of_the_virtual_samples_is_found() {
        for (name, percent) in [("scan5", 0.12), ("scan8", 0.17)] {
            let Some(path) = asperity_needs::data(&format!("samples/{name}.csv")) else {
                return;
            };
            let noise = estimate(&csv::read(path).unwrap()).unwrap();
            let floor = noise.floor_percent();
            assert!((floor / percent - 1.0).abs() < 0.1, "{name}: {noise:?}");
            // a map of 0.4 mm side is grainy
            assert!(noise.fluctuation_percent > 3.0 * floor, "{name}: {noise:?}");
        }
    }

    #[test]
    fn noise_that_grows_with_the_signal_counts_as_rms() {
        let mut uniform = uniforms(1);
        let noise = |clean: f64| 0.02 * clean.sqrt();
        // uniform in +-sqrt(3) has unit variance
        let scan = lobe(8.0, |clean| clean + noise(clean) * (2.0 * uniform() - 1.0) * 3_f64.sqrt());
        let clean = lobe(8.0, |clean| clean);
        let square = |reading: &Reading| noise(reading.value).powi(2);
        let mean = clean.readings().iter().map(square).sum::<f64>() / 1801.0;
        let expected = 100.0 * mean.sqrt() / scan.largest_reading();
        let found = estimate(&scan).unwrap();
        assert_eq!(found.counting_percent, None);
        let ratio = found.floor_percent() / expected;
        assert!((0.85..1.1).contains(&ratio), "{found:?}, expected {expected}");
    }

    #[test]
    fn a_smooth_lobe_has_hardly_noise_and_a_narrow_one_is_overestimated() {
        let percent = |width| estimate(&lobe(width, |clean| clean)).unwrap().floor_percent();
        assert!(percent(8.0) < 1e-5 && percent(4.0) < 1e-2, "{} {}", percent(8.0), percent(4.0));
        assert!(percent(1.0) > 0.1, "{}", percent(1.0));
    }

    #[test]
    fn residuals_have_no_lobe_and_no_slow_misfit() {
        for width in [0.05, 0.5, 1.0, 8.0] {
            let mut uniform = uniforms(5);
            let mut draw = || 0.001 * (2.0 * uniform() - 1.0) * 3_f64.sqrt();
            let scan = lobe(width, |clean| clean + draw());
            let clean = lobe(width, |clean| clean);
            let exact: Vec<f64> = clean.readings().iter().map(|r| r.value).collect();
            let true_percent = 100.0 * 0.001 / scan.largest_reading();
            let found = of_fit(&scan, &exact, None).unwrap();
            assert!((0.88..1.06).contains(&(found / true_percent)), "{width} {found}");
            // misfit ten times the noise, over a few degrees
            let off = |r: &Reading| r.value + 0.02 * (r.theta_deg / 5.0).sin();
            let wrong: Vec<f64> = clean.readings().iter().map(off).collect();
            let found = of_fit(&scan, &wrong, None).unwrap();
            assert!((0.88..1.1).contains(&(found / true_percent)), "{width} {found}");
        }
    }

    #[test]
    fn a_floor_is_never_above_the_error_of_its_fit() {
        let mut uniform = uniforms(6);
        let mut scan = lobe(1.0, |clean| clean + 1e-3 * uniform());
        let clean = lobe(1.0, |clean| clean);
        let exact: Vec<f64> = clean.readings().iter().map(|r| r.value).collect();
        let error = |scan: &Measurement| {
            let squares = scan.readings().iter().zip(&exact).map(|(r, s)| (r.value - s).powi(2));
            100.0 * (squares.sum::<f64>() / exact.len() as f64).sqrt() / scan.largest_reading()
        };
        assert!(of_fit(&scan, &exact, None).unwrap() <= error(&scan));
        // what a header states is capped too, and readings without noise have none
        scan.meta.noise_floor_percent = Some(5.0);
        assert!((of_fit(&scan, &exact, None).unwrap() - error(&scan)).abs() < 1e-12);
        assert!(of_fit(&clean, &exact, None).unwrap() <= 0.0);
        // the noise of rays is not the measurement's
        let mut uniform = uniforms(7);
        let rays: Vec<f64> = exact.iter().map(|r| r + 0.02 * (uniform() - 0.5)).collect();
        scan.meta.noise_floor_percent = None;
        let own = 100.0 * 0.02 / 12_f64.sqrt();
        assert!(of_fit(&scan, &rays, Some(own)).unwrap() < error(&scan) + 0.3 * own);
    }

    #[test]
    fn rounded_readings_are_not_taken_for_counts() {
        let rounded = lobe(8.0, |clean| (clean * 1000.0).round() / 1000.0);
        assert_eq!(estimate(&rounded).unwrap().counting_percent, None);
        let mut uniform = uniforms(2);
        // an offset keeps the noise of the electronics above zero
        let noisy = lobe(8.0, |clean| (clean * 4096.0 + 20.0 + 40.0 * uniform()).round() / 4096.0);
        assert_eq!(estimate(&noisy).unwrap().counting_percent, None);
    }

    #[test]
    fn a_few_readings_or_uneven_steps_have_no_estimate() {
        let reading = |k: i32| Reading::in_plane(0.0, f64::from(k * k) / 20.0, 1.0);
        let scan = Measurement::new(Metadata::default(), (0..40).map(reading).collect()).unwrap();
        assert_eq!(estimate(&scan), None);
        let point = Measurement::new(Metadata::default(), vec![reading(0)]).unwrap();
        assert_eq!(estimate(&point), None);
    }
}
