//! Plots of measured against fitted readings, every incidence, linear and logarithmic.

use std::path::{Path, PathBuf};

use crate::measurement::Measurement;
use crate::output::{AtomicFile, OutputError, finish_all};
use crate::plot::{self, Figure, PlotError, Scale, sigma_panels};
use crate::reconstruct::Entry;

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

/// The figure of a measurement and its fits, one panel per incidence.
pub fn figure(title: &str, measurement: &Measurement, entries: &[&Entry], scale: Scale) -> Figure {
    drawn(title, measurement, entries, scale, &|_| true)
}

/// The same of one incidence alone.
pub fn figure_at(
    sigma_deg: f64,
    title: &str,
    measurement: &Measurement,
    entries: &[&Entry],
    scale: Scale,
) -> Figure {
    drawn(title, measurement, entries, scale, &|sigma| sigma.total_cmp(&sigma_deg).is_eq())
}

fn drawn(
    title: &str,
    measurement: &Measurement,
    entries: &[&Entry],
    scale: Scale,
    wanted: &dyn Fn(f64) -> bool,
) -> Figure {
    let incidences = || measurement.by_incidence().filter(|i| wanted(i.sigma_deg));
    let measured: Vec<_> = incidences()
        .map(|i| {
            (i.sigma_deg, i.readings.iter().map(|r| (r.theta_deg, r.value)).collect::<Vec<_>>())
        })
        .collect();
    let fits: Vec<_> = entries
        .iter()
        .map(|entry| {
            let curves = incidences()
                .map(|i| {
                    let angles = i.readings.iter().map(|r| r.theta_deg);
                    let values = entry.fit.readings[i.range.clone()].iter().copied();
                    (i.sigma_deg, angles.zip(values).collect::<Vec<_>>())
                })
                .collect::<Vec<_>>();
            (format!("{} ({:.2} %)", entry.label, entry.fit.rmsd_percent), curves)
        })
        .collect();
    sigma_panels(title, &measured, &fits, scale)
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
