//! What readings themselves say of how they were made, before any fit.

use super::{Measurement, Plane, Reading};

/// Readings in a row that are the same to the last digit and the largest of their plane: more than chance, and where readings are
/// written with so many digits.
const SATURATED: usize = 4;
const SATURATED_FINE: usize = 3;
const FINE_DIGITS: usize = 5;
/// Angles of observation that are all below this, degrees, while there are many: radians?
const RADIANS: f64 = 1.58;
/// Readings that a plane needs before its shape says anything.
const MANY: usize = 12;
/// A reading beside zeros is light if it is above this share of its plane's largest, and so many times the scatter of the readings
/// beside, of which this many are looked at.
const LIGHT: f64 = 1e-3;
const TIMES_SCATTER: f64 = 6.0;
const BESIDE: usize = 6;
/// Angles of observation from which on there is no flux, degrees.
const ALONG_DEG: f64 = 89.5;

/// Suspicions, each with its remedy.
pub fn signs(scan: &Measurement) -> Vec<String> {
    [radians(scan), saturated(scan), dropped_out(scan), one_sided(scan)]
        .into_iter()
        .flatten()
        .collect()
}

/// A level that is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Normalised {
    /// Of all readings together: the largest is exactly this.
    Together(f64),
    /// Of each incidence: every largest is exactly this.
    Each(f64),
}

impl std::fmt::Display for Normalised {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Each(to) => write!(
                f,
                "the largest reading of every incidence is exactly {to}: they are normalised to their own peaks, and their levels \
                 are lost; --fit-gains=free"
            ),
            Self::Together(to) => write!(
                f,
                "the largest reading is exactly {to}: the readings are normalised to their peak, and the level is lost; \
                 --fit-gain, or --quantity counts"
            ),
        }
    }
}

fn radians(scan: &Measurement) -> Option<String> {
    let most = scan.readings().iter().map(|r| r.theta_deg.abs()).fold(0.0, f64::max);
    let tilt = scan.incidences().into_iter().fold(0.0, f64::max);
    let many = scan.by_plane().any(|plane| plane.readings.len() >= MANY);
    let says = "all angles are below 1.58: are they in radians? --angle-unit rad";
    // a lobe in a degree and a half has a fall; one incidence at 0 leaves sigma open
    (many && most > 0.5 && most <= RADIANS && tilt <= RADIANS).then(|| says.into())
}

/// Whether the readings have lost their level.
pub fn normalised(scan: &Measurement) -> Option<Normalised> {
    let largest = |plane: Plane<'_>| {
        let values = plane.readings.iter().map(|r| r.value);
        (plane.readings.len() >= MANY).then(|| values.fold(0.0, f64::max))
    };
    let peaks: Vec<f64> = scan.by_plane().filter_map(largest).collect();
    let is_at = |to: f64| peaks.iter().all(|p| (p / to - 1.0).abs() < 1e-9);
    let is_one = |to: f64| (scan.largest_reading() / to - 1.0).abs() < 1e-9;
    let to = [1.0, 100.0].into_iter().find(|&to| is_one(to))?;
    let each = peaks.len() > 1 && is_at(to);
    (!peaks.is_empty()).then_some(if each {
        Normalised::Each(to)
    } else {
        Normalised::Together(to)
    })
}

fn saturated(scan: &Measurement) -> Option<String> {
    let run = |plane: Plane<'_>| -> Option<(f64, f64, usize)> {
        let top = plane.readings.iter().map(|r| r.value).fold(0.0, f64::max);
        let at_top = |value: f64| value.total_cmp(&top).is_eq();
        let runs = plane.readings.chunk_by(|a, b| at_top(a.value) && at_top(b.value));
        let longest = runs.filter(|run| at_top(run[0].value)).map(<[_]>::len).max()?;
        // a flat plane is no saturated lobe
        let is_lobe = plane.readings.len() >= MANY && 2 * longest < plane.readings.len();
        let is_clipped =
            longest >= SATURATED || longest >= SATURATED_FINE && is_fine(plane.readings);
        (is_clipped && is_lobe && top > 0.0).then_some((plane.sigma_deg, top, longest))
    };
    let (sigma, top, longest) = scan.by_plane().find_map(run)?;
    Some(format!(
        "{longest} readings in a row at sigma {sigma} deg are exactly {top}, the largest there: a saturated detector? Leave them \
         out with --theta-range"
    ))
}

/// Whether most readings are written with [`FINE_DIGITS`] or more.
fn is_fine(readings: &[Reading]) -> bool {
    let digits = |r: &Reading| {
        let text = format!("{:e}", r.value.abs());
        text.split('e').next().map_or(0, |mantissa| mantissa.replace('.', "").len())
    };
    2 * readings.iter().filter(|r| digits(r) >= FINE_DIGITS).count() > readings.len()
}

fn dropped_out(scan: &Measurement) -> Option<String> {
    let count = zeros_in_light(scan).iter().filter(|is| **is).count();
    (count > 0).then(|| {
        format!("{count} readings are exactly 0 where there is light beside them: drop-outs? --drop zeros")
    })
}

/// Which readings are exactly zero next to light: a run of zeros in a plane with bright readings on each side that it has.
///
/// Counts may be none by chance: readings beside zeros are light only if they are far above their own scatter. Along the surface there is
/// no flux.
pub fn zeros_in_light(scan: &Measurement) -> Vec<bool> {
    let mut found = Vec::with_capacity(scan.readings().len());
    for plane in scan.by_plane() {
        found.extend(plane_zeros(plane.readings));
    }
    found
}

fn plane_zeros(readings: &[Reading]) -> Vec<bool> {
    let light = LIGHT * readings.iter().map(|r| r.value).fold(0.0, f64::max);
    let is_zero = |r: &Reading| r.value.abs() <= 0.0 && r.theta_deg.abs() < ALONG_DEG;
    let mut found = Vec::with_capacity(readings.len());
    for run in readings.chunk_by(|a, b| is_zero(a) == is_zero(b)) {
        let (from, to) = (found.len(), found.len() + run.len());
        let before: Vec<f64> = near(readings[..from].iter().rev());
        let after: Vec<f64> = near(readings[to..].iter());
        let sides = [before, after];
        let mut known = sides.iter().filter(|side| !side.is_empty()).peekable();
        let is_lit = is_zero(&run[0])
            && known.peek().is_some()
            && known.all(|side| side[0] > light && side[0] > TIMES_SCATTER * scatter(side));
        found.extend(std::iter::repeat_n(is_lit, run.len()));
    }
    found
}

/// The readings nearest to a run, those along the surface left out.
fn near<'a>(side: impl Iterator<Item = &'a Reading>) -> Vec<f64> {
    side.take(BESIDE).filter(|r| r.theta_deg.abs() < ALONG_DEG).map(|r| r.value).collect()
}

/// The scatter of neighbours about a line: of second differences, which have six times the variance. Infinite if there are too few.
fn scatter(side: &[f64]) -> f64 {
    if side.len() < 3 {
        return f64::INFINITY;
    }
    let bends = side.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]);
    let count = (side.len() - 2) as f64;
    (bends.map(|b| b * b).sum::<f64>() / (6.0 * count)).sqrt()
}

/// In reflection and transmission the beam goes to the same sign of theta; a file may have it on the other.
fn one_sided(scan: &Measurement) -> Option<String> {
    let tilted =
        scan.by_plane().filter(|plane| plane.sigma_deg > 5.0 && plane.phi_deg.abs() <= 0.0);
    let (mut here, mut there) = (0_usize, 0_usize);
    for plane in tilted {
        let range = |r: f64| plane.readings.iter().any(|x| (x.theta_deg - r).abs() < 5.0);
        if !(range(plane.sigma_deg) && range(-plane.sigma_deg)) {
            continue;
        }
        let near = |at: f64| {
            let close = plane.readings.iter().filter(|x| (x.theta_deg - at).abs() < 5.0);
            close.map(|x| x.value).fold(0.0, f64::max)
        };
        let (mine, other) = (near(plane.sigma_deg), near(-plane.sigma_deg));
        here += usize::from(mine > other);
        there += usize::from(other > 1.5 * mine);
    }
    (there > 0 && here == 0).then(|| {
        "every lobe lies at -sigma: the mirror direction of this file has the other sign; --theta-sign minus".into()
    })
}

#[cfg(test)]
mod tests {
    use super::super::Metadata;
    use super::{Measurement, Normalised, Reading};
    use super::{signs, zeros_in_light};

    fn scan(value: impl Fn(f64, f64) -> f64) -> Measurement {
        let mut readings = Vec::new();
        for sigma in [0.0, 30.0] {
            for k in -40..=40 {
                let theta = 2.0 * f64::from(k);
                readings.push(Reading::in_plane(sigma, theta, value(sigma, theta)));
            }
        }
        Measurement::new(Metadata::default(), readings).unwrap()
    }

    fn lobe(sigma: f64, theta: f64) -> f64 {
        0.013 * (-((theta - sigma) / 20.0).powi(2)).exp() + 1e-4
    }

    fn said(value: impl Fn(f64, f64) -> f64) -> Vec<String> {
        signs(&scan(value))
    }

    #[test]
    fn sound_readings_say_nothing() {
        assert_eq!(said(lobe), Vec::<String>::new());
        // counts that run out in the tail are no drop-outs
        let counts = |s: f64, t: f64| ((lobe(s, t) - 1e-4) * 2e4).round();
        assert!(!zeros_in_light(&scan(counts)).contains(&true));
    }

    #[test]
    fn each_fault_is_named() {
        let one = |text: Vec<String>, word: &str| {
            assert!(text.len() == 1 && text[0].contains(word), "{word}: {text:?}");
        };
        let normalised = |value: &dyn Fn(f64, f64) -> f64| super::normalised(&scan(value));
        assert_eq!(normalised(&|s, t| lobe(s, t) / lobe(s, s)), Some(Normalised::Each(1.0)));
        let top = lobe(0.0, 0.0);
        let one_lobe = |s: f64, t: f64| 100.0 * lobe(s, t) / top * (1.0 - 0.01 * s);
        assert_eq!(normalised(&one_lobe), Some(Normalised::Together(100.0)));
        assert_eq!(normalised(&lobe), None);
        one(said(|s, t| lobe(s, t).min(0.01)), "saturated");
        // three in a row: of many digits no chance, of three digits one
        let clipped = |s: f64, t: f64| lobe(s, t).min(lobe(0.0, 2.0));
        one(said(clipped), "saturated");
        assert!(said(|s, t| (1e5 * clipped(s, t)).round() / 1e5).is_empty());
        one(said(|s, t| lobe(-s, t)), "--theta-sign");
        one(said(|s, t| if (t - s - 10.0).abs() < 5.0 { 0.0 } else { lobe(s, t) }), "--drop zeros");
        let mut radians = Vec::new();
        for k in -80..=80 {
            let theta = f64::from(k) / 57.3;
            radians.push(Reading::in_plane(0.0, theta, lobe(0.0, f64::from(k))));
        }
        let radians = Measurement::new(Metadata::default(), radians).unwrap();
        one(signs(&radians), "radians");
    }
}
