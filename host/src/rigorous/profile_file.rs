//! One period of grooves as a CSV file.

use std::path::Path;

use asperity_rigorous::{Profile, ProfileError};

use crate::message::brief;

/// Why a file holds no profile.
#[derive(Debug, thiserror::Error)]
pub enum ProfileFileError {
    /// A line that is no point.
    #[error("{file}:{line}: {what}")]
    Line {
        /// The file.
        file: String,
        /// Its line, from 1.
        line: usize,
        /// What is wrong, and what to do.
        what: String,
    },
    /// The file as a whole.
    #[error("{file}: {what}")]
    Whole {
        /// The file.
        file: String,
        /// What is wrong, and what to do.
        what: String,
    },
    /// Heights that are no profile.
    #[error("{file}: {why}")]
    Profile {
        /// The file.
        file: String,
        /// Why.
        why: ProfileError,
    },
}

/// How far a step may be off the mean one, as a share of it.
const UNEVEN: f64 = 1e-3;

/// The profile of a text with the columns `x_um,z_um`, at equal steps over one period, and lines with `#`.
///
/// The period is `period_um`, else what a comment says (`period_um=...`), else the number of points times their step. A last
/// point that repeats the first one period later is left out.
///
/// # Errors
/// [`ProfileFileError`] with file, line, and what to do.
pub fn read_profile(
    text: &str,
    path: &Path,
    period_um: Option<f64>,
) -> Result<Profile, ProfileFileError> {
    let file = || path.display().to_string();
    let whole = |what: String| ProfileFileError::Whole { file: file(), what };
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut has_head = false;
    for (number, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let fault = |what: String| ProfileFileError::Line { file: file(), line: number + 1, what };
        if !has_head {
            has_head = true;
            let names: Vec<&str> = line.split(',').map(str::trim).collect();
            if names != ["x_um", "z_um"] {
                return Err(fault(format!(
                    "the first line must name the columns x_um,z_um, lengths in um; it is `{}`",
                    brief(line)
                )));
            }
            continue;
        }
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let pair = line.split_once(',').and_then(|(x, z)| Some([number(x)?, number(z)?]));
        points
            .push(pair.ok_or_else(|| fault(format!("`{}` is not two numbers x,z", brief(line))))?);
    }
    let [first, .., last] = points.as_slice() else {
        return Err(whole("it has fewer than two points; give one period of grooves".into()));
    };
    let step = (last[0] - first[0]) / (points.len() - 1) as f64;
    if step <= 0.0 {
        return Err(whole("x does not rise from point to point; sort the points".into()));
    }
    let uneven =
        points.windows(2).position(|w| (w[1][0] - w[0][0] - step).abs() > UNEVEN * step.abs());
    if let Some(place) = uneven {
        let x = points[place + 1][0];
        return Err(whole(format!(
            "the points are not at equal steps (x = {x} um is {:.4} um after the one before, the mean step is {step:.4}); resample it",
            x - points[place][0]
        )));
    }
    let period = period_um.or_else(|| stated_period(text)).unwrap_or(step * points.len() as f64);
    let mut heights: Vec<f64> = points.iter().map(|p| p[1]).collect();
    let repeats = (period / step - (points.len() - 1) as f64).abs() < 0.5;
    if repeats && heights.len() > 2 {
        heights.pop();
    }
    let off = (period / step - heights.len() as f64).abs();
    if off.is_nan() || off >= 0.01 {
        return Err(whole(format!(
            "{} points at steps of {step} um are {} um, not the period of {period} um; give --period-um, or all of one period",
            points.len(),
            step * points.len() as f64
        )));
    }
    Profile::new(heights, period).map_err(|why| ProfileFileError::Profile { file: file(), why })
}

/// What a comment says.
fn stated_period(text: &str) -> Option<f64> {
    let mut comments = text.lines().filter(|line| line.trim_start().starts_with('#'));
    let after = |line: &'_ str| line.split("period_um=").nth(1).map(str::to_owned);
    let rest = comments.find_map(after)?;
    let end =
        rest.find(|c: char| !(c.is_ascii_digit() || ".eE+-".contains(c))).unwrap_or(rest.len());
    rest[..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::read_profile;

    fn read(text: &str, period: Option<f64>) -> Result<f64, String> {
        let profile = read_profile(text, Path::new("p.csv"), period).map_err(|e| e.to_string())?;
        Ok(profile.period_um())
    }

    fn points(count: u32, step: f64) -> String {
        let z = |k: u32| (std::f64::consts::TAU * f64::from(k) / 16.0).sin();
        let line = |k: u32| format!("{},{}\n", step * f64::from(k), z(k));
        (0..count).map(line).collect()
    }

    #[test]
    fn the_period_is_that_of_the_flag_the_comment_or_the_points() {
        let plain = format!("x_um,z_um\n{}", points(16, 0.5));
        assert!((read(&plain, None).unwrap() - 8.0).abs() < 1e-12);
        let said = format!("# period_um=8.0, more\n{plain}");
        assert!((read(&said, None).unwrap() - 8.0).abs() < 1e-12);
        // the first point once more, a period later
        let closed = format!("x_um,z_um\n{}", points(17, 0.5));
        assert!((read(&closed, Some(8.0)).unwrap() - 8.0).abs() < 1e-12);
        for (text, period, said) in [
            (plain.replace("x_um", "x_nm"), None, "p.csv:1"),
            (plain.replace("1.5,", "1.5;"), None, "p.csv:5"),
            (plain.replace("1.5,", "1.6,"), None, "equal steps"),
            (plain.clone(), Some(9.7), "not the period"),
            ("x_um,z_um\n0,1\n".to_owned(), None, "fewer than two"),
        ] {
            let error = read(&text, period).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
