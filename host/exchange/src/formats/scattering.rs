//! Analytic surfaces of Ansys Speos: `.scattering` (by incidence and wavelength) and `.simplescattering`.
//!
//! Meaning: Ansys, "Speos Scattering Surface Format" and "Parameters of a Simple Scattering Surface"; files of ansys/pyspeos. Of a `.scattering` the
//! rows of an incidence are the percentages of the specular, Lambertian and Gaussian parts and the full widths at half maximum in and across the plane of
//! incidence, degrees; the columns are reflection and transmission for each wavelength. Of a `.simplescattering` the numbers are the absorption in
//! percent, then the Lambertian and the Gaussian part in percent of what is not absorbed and the full width; the rest is specular.
//!
//! Assumed, for the help gives no formula: the Gaussian part is `exp(-4 ln 2 delta^2 / FWHM^2)` of scattered flux per solid angle, `delta` the angle from
//! the ray, cut at the horizon and scaled to its percentage; the BSDF of it goes on from 89 degrees as it is there. The direct ray has the angle of the incident one, as no index is given. The specular part is not
//! scatter: it is told in the notes.

use std::f64::consts::{FRAC_PI_2, LN_2, PI};

use super::{Format, Source};
use crate::error::Fault;
use crate::frame::Frame;
use crate::interpolation::Interpolation;
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};
use crate::text::{Lines, excerpt};

const NAME: &str = "Speos scattering surface";

pub(super) const FORMAT: Format = Format {
    name: "speos-scattering",
    title: "Ansys Speos scattering surface",
    extensions: &["scattering", "simplescattering"],
    sniff: |source| kind(source.start()).is_some(),
    read: Some(read),
    write: None,
};

/// The parts of one incidence and wavelength; fractions of the incident flux.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Parts {
    specular: f64,
    lambertian: f64,
    gaussian: f64,
    /// Full widths at half maximum in and across the plane of incidence, radians.
    widths: [f64; 2],
}

/// The parts at an incidence, a wavelength after the other.
#[derive(Debug)]
struct Row {
    theta: f64,
    parts: Vec<Parts>,
}

/// Incidences a simple surface is sampled at, degrees.
const THETAS: [f64; 7] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0];

/// Nodes a half width, and azimuths of half a turn.
const FINENESS: f64 = 12.0;
const AZIMUTHS: usize = 24;

/// Whether the first line is that of a `.simplescattering`; `None` if of neither.
fn kind(start: &str) -> Option<bool> {
    let first = start.split(['\r', '\n']).next()?.to_ascii_lowercase();
    let rest = first.trim().strip_prefix("optis - ")?.to_owned();
    if rest.starts_with("simple scattering surface file") {
        return Some(true);
    }
    rest.starts_with("scattering surface file").then_some(false)
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let mut lines = Lines::new(NAME, &source.text);
    lines.expect("the title")?;
    let name = lines.next_raw().unwrap_or("").trim().to_owned();
    let is_simple = kind(source.start()) == Some(true);
    let (lobes, bands) = if is_simple { simple(&mut lines)? } else { table(&mut lines)? };
    let mut all = Vec::new();
    for (lobe, rows) in lobes {
        let all_parts = || rows.iter().flat_map(|row| &row.parts);
        if all_parts().all(|p| *p == Parts::default()) {
            continue;
        }
        let specular = all_parts().map(|p| p.specular);
        let ends = specular.fold([1.0_f64, 0.0_f64], |e, s| [e[0].min(s), e[1].max(s)]);
        let mut notes = vec![name.clone()];
        if ends[1] > 0.0 {
            let [low, high] = ends.map(|s| (1e8 * s).round() / 1e6);
            notes.push(format!("specular part, not in the values: {low} to {high} percent"));
        }
        if all_parts().any(|p| p.gaussian > 0.0) {
            notes.push("the Gaussian part is taken as one of flux per solid angle".into());
        }
        all.push(SampledBsdf {
            side: Side::Air,
            lobe,
            index: None,
            symmetry: Symmetry::Isotropic,
            bands: bands.clone(),
            interpolation: Interpolation::Linear,
            incidences: rows.iter().map(incidence).collect(),
            has_level: true,
            notes,
        });
    }
    if all.is_empty() {
        return Err(lines.fault("a surface that neither reflects nor transmits"));
    }
    Ok(all)
}

type Lobes = Vec<(Lobe, Vec<Row>)>;

fn simple(lines: &mut Lines<'_>) -> Result<(Lobes, Vec<Band>), Fault> {
    let line = lines.expect("Reflection or Transmission")?;
    let lobe = match line.to_ascii_lowercase().as_str() {
        "reflection" => Lobe::Reflection,
        "transmission" => Lobe::Transmission,
        other if other.contains("reflection") && other.contains("transmission") => {
            let what = "a simple surface that both reflects and transmits".to_owned();
            let remedy = "save it as a .scattering file with the percentages of each";
            return Err(Fault::Unsupported { format: NAME, what, remedy });
        }
        _ => {
            let line = excerpt(line);
            return Err(lines.fault(format!("neither Reflection nor Transmission: '{line}'")));
        }
    };
    let line = lines.expect("absorption, Lambertian, Gaussian and width")?;
    let numbers = lines.numbers(line, "a percentage")?;
    let [absorption, lambertian, gaussian, width] = numbers[..] else {
        return Err(lines.fault("expected four numbers: absorption, Lambertian, Gaussian, width"));
    };
    percentages(lines, &[absorption, lambertian, gaussian])?;
    if lambertian + gaussian > 100.0 + 1e-6 {
        return Err(lines.fault("Lambertian and Gaussian parts of more than 100 percent"));
    }
    let rest = 1.0 - absorption / 100.0;
    let gaussian = rest * gaussian / 100.0;
    let parts = Parts {
        specular: (rest * (1.0 - lambertian / 100.0) - gaussian).max(0.0),
        lambertian: rest * lambertian / 100.0,
        gaussian,
        widths: widths(lines, gaussian, [width; 2])?,
    };
    let row = |theta: f64| Row { theta: theta.to_radians(), parts: vec![parts] };
    Ok((vec![(lobe, THETAS.map(row).into())], vec![Band::Unknown]))
}

fn table(lines: &mut Lines<'_>) -> Result<(Lobes, Vec<Band>), Fault> {
    let line = lines.expect("the numbers of incidences and wavelengths")?;
    let mut counts = crate::text::fields(line);
    let n = lines.count(counts.next().unwrap_or(""), "incidences")?;
    let m = lines.count(counts.next().unwrap_or(""), "wavelengths")?;
    let wavelengths = lines.exactly(m, "wavelengths")?;
    lines.ascending(&wavelengths, "wavelengths")?;
    if wavelengths[0] <= 0.0 {
        return Err(lines.fault("a wavelength of 0 or less, in nm"));
    }
    let mut lobes: Lobes =
        [Lobe::Reflection, Lobe::Transmission].map(|lobe| (lobe, Vec::new())).into();
    let mut last = -1.0;
    for _ in 0..n {
        let first =
            lines.exactly_in_line(2 * m + 1, "an incidence and its specular percentages")?;
        let theta = first[0];
        if !(0.0..=90.0).contains(&theta) || theta <= last {
            return Err(lines.fault(format!("incidences do not ascend from 0 to 90: {theta}")));
        }
        last = theta;
        let lambertian = lines.exactly_in_line(2 * m, "Lambertian percentages")?;
        let gaussian = lines.exactly_in_line(2 * m, "Gaussian percentages")?;
        let along = lines.exactly_in_line(2 * m, "widths in the plane of incidence")?;
        let across = lines.exactly_in_line(2 * m, "widths across the plane of incidence")?;
        for percents in [&first[1..], &lambertian, &gaussian] {
            percentages(lines, percents)?;
        }
        let part = |k: usize| -> Result<Parts, Fault> {
            Ok(Parts {
                specular: first[k + 1] / 100.0,
                lambertian: lambertian[k] / 100.0,
                gaussian: gaussian[k] / 100.0,
                widths: widths(lines, gaussian[k], [along[k], across[k]])?,
            })
        };
        for (of, (_, rows)) in lobes.iter_mut().enumerate() {
            let parts = (0..m).map(|band| part(2 * band + of)).collect::<Result<_, _>>()?;
            rows.push(Row { theta: theta.to_radians().min(FRAC_PI_2), parts });
        }
        for band in 0..m {
            let sum: f64 = [2 * band, 2 * band + 1]
                .map(|k| first[k + 1] + lambertian[k] + gaussian[k])
                .iter()
                .sum();
            if sum > 100.0 + 1e-6 {
                return Err(lines.fault(format!("parts of {sum} percent together")));
            }
        }
    }
    Ok((lobes, wavelengths.into_iter().map(Band::Wavelength).collect()))
}

impl Lines<'_> {
    /// Exactly `n` numbers of the next line that holds something.
    fn exactly_in_line(&mut self, n: usize, what: &str) -> Result<Vec<f64>, Fault> {
        let line = self.expect(what)?;
        let numbers = self.numbers(line, what)?;
        if numbers.len() != n {
            let is = numbers.len();
            return Err(self.fault(format!("{is} numbers of {what} where {n} are expected")));
        }
        Ok(numbers)
    }
}

fn percentages(lines: &Lines<'_>, all: &[f64]) -> Result<(), Fault> {
    match all.iter().find(|p| !(0.0..=100.0).contains(*p)) {
        Some(p) => Err(lines.fault(format!("a percentage outside 0 to 100: {p}"))),
        None => Ok(()),
    }
}

/// Full widths in radians; they must be there if the part is.
fn widths(lines: &Lines<'_>, gaussian: f64, degrees: [f64; 2]) -> Result<[f64; 2], Fault> {
    let range = if gaussian > 0.0 { 0.01..=180.0 } else { 0.0..=180.0 };
    match degrees.iter().find(|w| !range.contains(*w)) {
        Some(w) => Err(lines.fault(format!("a width at half maximum outside 0.01 to 180: {w}"))),
        None => Ok(degrees.map(f64::to_radians)),
    }
}

/// The values of an incidence on a grid about the ray.
fn incidence(row: &Row) -> Incidence {
    let gaussians = row.parts.iter().filter(|p| p.gaussian > 0.0);
    let least = gaussians.flat_map(|p| p.widths).fold(PI, f64::min);
    let grid = grid(row.theta, least);
    let mut values = Vec::new();
    for parts in &row.parts {
        let gauss = parts.gaussian_bsdf(&grid);
        values.extend(gauss.iter().map(|g| parts.lambertian / PI + g));
    }
    let stated = row.parts.iter().map(|p| p.lambertian + p.gaussian).collect();
    Incidence { theta: row.theta, phi: 0.0, nodes: Nodes::Grid(grid), values, stated }
}

impl Parts {
    /// BSDF of the Gaussian part at the nodes of a grid.
    fn gaussian_bsdf(&self, grid: &Grid) -> Vec<f64> {
        let coordinates =
            grid.azimuths.iter().flat_map(|a| grid.radii.iter().map(move |r| [*r, *a]));
        if self.gaussian <= 0.0 {
            return coordinates.map(|_| 0.0).collect();
        }
        let near_horizon = FRAC_PI_2 - 1.0_f64.to_radians();
        let bsdf = |(c, out): ([f64; 2], [f64; 2])| self.shape(c) / out[0].min(near_horizon).cos();
        let own: Vec<f64> = coordinates.zip(grid.directions()).map(bsdf).collect();
        let sum = grid.integral(&|c, _| grid.value(&own, c, Interpolation::Linear));
        let scale = if sum > 0.0 { self.gaussian / sum } else { 0.0 };
        own.into_iter().map(|v| v * scale).collect()
    }

    /// Flux per solid angle of the Gaussian part, 1 at the ray.
    fn shape(&self, [radius, azimuth]: [f64; 2]) -> f64 {
        let [along, across] = self.widths;
        let square = (azimuth.cos() / along).powi(2) + (azimuth.sin() / across).powi(2);
        (-4.0 * LN_2 * radius * radius * square).exp()
    }
}

/// Radii that grow from a twelfth of the half width to 3 degrees.
fn grid(theta: f64, width: f64) -> Grid {
    let end = theta + FRAC_PI_2;
    let step = (width / 2.0 / FINENESS).min(3.0_f64.to_radians());
    let mut radii = vec![0.0];
    let mut at = step;
    while at < end - 1e-9 {
        radii.push(at);
        at += step.max(at / 20.0).min(3.0_f64.to_radians());
    }
    radii.push(end);
    let azimuths = (0..=AZIMUTHS).map(|k| PI * k as f64 / AZIMUTHS as f64).collect();
    Grid { frame: Frame::Specular { theta }, radii, azimuths, mirrored: true }
}
