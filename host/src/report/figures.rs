//! Plots of measured against fitted readings, every incidence, linear and logarithmic.

use std::path::{Path, PathBuf};

use super::angle_text;
use crate::measurement::{Incidence, Measurement, Quantity, Reading};
use crate::output::{AtomicFile, OutputError, finish_all};
use crate::plot::{
    self, Figure, PlotError, PolarPicture, PolarPoint, PolarRow, Scale, sigma_panels,
};
use crate::reconstruct::{Cell, Entry};

/// Why a plot was not written.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// It cannot be drawn.
    #[error("the plot cannot be drawn: {0}")]
    Plot(#[from] PlotError),
    /// It cannot be stored.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// A fit as it is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    /// Method, with its law if it has one.
    pub label: &'a str,
    /// Error of eq. (18), %.
    pub rmsd_percent: f64,
    /// Simulated readings, in the order of the measurement's.
    pub readings: &'a [f64],
}

impl<'a> From<&'a Entry> for Drawn<'a> {
    fn from(entry: &'a Entry) -> Self {
        let fit = &entry.fit;
        Self { label: &entry.label, rmsd_percent: fit.rmsd_percent, readings: &fit.readings }
    }
}

impl<'a> From<&'a Cell> for Drawn<'a> {
    fn from(cell: &'a Cell) -> Self {
        let rmsd_percent = cell.rmsd_percent();
        Self { label: &cell.label, rmsd_percent, readings: &cell.readings }
    }
}

/// The figure of a measurement and its fits, one panel per incidence.
pub fn figure(title: &str, measurement: &Measurement, fits: &[Drawn<'_>], scale: Scale) -> Figure {
    drawn(title, measurement, fits, scale, &|_| true)
}

/// The same of one incidence alone.
pub fn figure_at(
    sigma_deg: f64,
    title: &str,
    measurement: &Measurement,
    fits: &[Drawn<'_>],
    scale: Scale,
) -> Figure {
    drawn(title, measurement, fits, scale, &|sigma| sigma.total_cmp(&sigma_deg).is_eq())
}

fn drawn(
    title: &str,
    measurement: &Measurement,
    fits: &[Drawn<'_>],
    scale: Scale,
    wanted: &dyn Fn(f64) -> bool,
) -> Figure {
    let is_drawn = |i: &Incidence<'_>| wanted(i.sigma_deg) && cut(i.readings).next().is_some();
    let incidences = || measurement.by_incidence().filter(is_drawn);
    let measured: Vec<_> = incidences()
        .map(|i| {
            let readings = cut(i.readings).map(|k| (i.readings[k].theta_deg, i.readings[k].value));
            (i.sigma_deg, readings.collect::<Vec<_>>())
        })
        .collect();
    let fits: Vec<_> = fits
        .iter()
        .map(|fit| {
            let curves = incidences()
                .map(|i| {
                    let values = &fit.readings[i.range.clone()];
                    let readings = cut(i.readings).map(|k| (i.readings[k].theta_deg, values[k]));
                    (i.sigma_deg, readings.collect::<Vec<_>>())
                })
                .collect::<Vec<_>>();
            (format!("{} ({:.2} %)", fit.label, fit.rmsd_percent), curves)
        })
        .collect();
    Figure { y_label: reading_label(measurement), ..sigma_panels(title, &measured, &fits, scale) }
}

/// What a reading is, with its unit.
fn reading_label(measurement: &Measurement) -> String {
    match measurement.quantity() {
        Quantity::Flux => "flux into the detector, of that of the beam".into(),
        Quantity::Bsdf => "BSDF (1/sr)".into(),
    }
}

/// The places of the readings in the plane of incidence, of the first rotation of the sample.
fn cut(readings: &[Reading]) -> impl Iterator<Item = usize> {
    let first = readings.first().map_or(0.0, |r| r.rotation_deg);
    let in_plane =
        move |r: &Reading| r.phi_deg.abs() <= 0.0 && r.rotation_deg.total_cmp(&first).is_eq();
    readings.iter().enumerate().filter(move |(_, r)| in_plane(r)).map(|(k, _)| k)
}

/// The lobes of a scan over the hemisphere, measured and fitted; `None` of a scan in the plane of incidence alone.
pub fn hemispheres(title: &str, measurement: &Measurement, entry: &Entry) -> Option<PolarPicture> {
    if measurement.is_in_plane() {
        return None;
    }
    let all: Vec<_> = measurement.by_incidence().collect();
    let row = |k: usize| {
        let incidence = &all[k];
        let rotation = incidence.readings[0].rotation_deg;
        let of_first = |(r, _): &(&Reading, &f64)| r.rotation_deg.total_cmp(&rotation).is_eq();
        let fitted = &entry.fit.readings[incidence.range.clone()];
        let point = |(r, fitted): (&Reading, &f64)| {
            let [polar_deg, azimuth_deg] = r.direction();
            PolarPoint { polar_deg, azimuth_deg, values: [r.value, *fitted] }
        };
        let points = incidence.readings.iter().zip(fitted).filter(of_first).map(point).collect();
        PolarRow {
            caption: format!("measured, σ = {}°", angle_text(incidence.sigma_deg)), points
        }
    };
    let label = match measurement.quantity() {
        Quantity::Flux => "flux",
        Quantity::Bsdf => "BSDF (1/sr)",
    };
    Some(PolarPicture {
        title: format!("{title}: {} ({:.2} %)", entry.label, entry.fit.rmsd_percent),
        label: label.into(),
        rows: plot::shown(all.len()).into_iter().map(row).collect(),
    })
}

/// The files `stem-linear` and `stem-log`, each as SVG and PNG, opened before the work.
#[derive(Debug)]
pub struct FigureFiles(Vec<AtomicFile>);

impl FigureFiles {
    /// Opens all four.
    ///
    /// # Errors
    /// Those of [`AtomicFile::create`].
    pub fn create(folder: &Path, stem: &str) -> Result<Self, OutputError> {
        Self::names(folder, stem)
            .into_iter()
            .map(AtomicFile::create)
            .collect::<Result<_, _>>()
            .map(Self)
    }

    /// Their paths.
    pub fn names(folder: &Path, stem: &str) -> [PathBuf; 4] {
        ["linear.svg", "linear.png", "log.svg", "log.png"]
            .map(|end| folder.join(format!("{stem}-{end}")))
    }

    /// Draws and completes all four; returns their paths.
    ///
    /// # Errors
    /// [`FigureError`]; none is written then.
    pub fn write(self, figure: &dyn Fn(Scale) -> Figure) -> Result<Vec<PathBuf>, FigureError> {
        let mut contents = Vec::new();
        for scale in [Scale::Linear, Scale::LOG] {
            let figure = figure(scale);
            contents.push(plot::svg(&figure)?.into_bytes());
            contents.push(plot::png(&figure)?);
        }
        let written = self.0.iter().map(|file| file.path().to_owned()).collect();
        finish_all(self.0.into_iter().zip(contents).collect())?;
        Ok(written)
    }
}

/// The files `stem-polar`, SVG and PNG, opened before the work.
#[derive(Debug)]
pub struct PolarFiles([AtomicFile; 2]);

impl PolarFiles {
    /// Opens both.
    ///
    /// # Errors
    /// Those of [`AtomicFile::create`].
    pub fn create(folder: &Path, stem: &str) -> Result<Self, OutputError> {
        let open = |end| AtomicFile::create(folder.join(format!("{stem}-polar.{end}")));
        Ok(Self([open("svg")?, open("png")?]))
    }

    /// Draws and completes both; returns their paths.
    ///
    /// # Errors
    /// [`FigureError`]; none is written then.
    pub fn write(self, picture: &PolarPicture) -> Result<Vec<PathBuf>, FigureError> {
        let contents = [plot::polar_svg(picture)?.into_bytes(), plot::polar_png(picture)?];
        let written = self.0.iter().map(|file| file.path().to_owned()).collect();
        finish_all(self.0.into_iter().zip(contents).collect())?;
        Ok(written)
    }
}
