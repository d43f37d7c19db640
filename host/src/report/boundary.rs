//! The boundary of a model in the plane of incidence, from both sides, with the band that its errors give it.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asperity_core::direction::Side;

use super::angle_text;
use super::figures::FigureError;
use crate::energy::side_name;
use crate::output::{AtomicFile, OutputError, finish_all};
use crate::plot::{self, Across, Curve, CurveStyle, Figure, Panel, Scale};
use crate::reconstruct::BoundaryValue;

/// Half the width of a band, in standard uncertainties: 95 % of a normal distribution.
pub(super) const BAND: f64 = 1.96;

/// The values as CSV, with the columns `side,lobe,incidence_deg,theta_deg,bsdf_per_sr,std_per_sr`.
pub fn boundary_csv(values: &[BoundaryValue]) -> String {
    let mut text = String::from("side,lobe,incidence_deg,theta_deg,bsdf_per_sr,std_per_sr\n");
    for v in values {
        let std = v.std.map(|std| format!("{std:e}")).unwrap_or_default();
        // writing to a string cannot fail
        let _ = writeln!(
            text,
            "{},{},{},{},{:e},{std}",
            side_name(v.side),
            lobe_name(v.is_transmitted),
            angle_text(v.incidence_deg),
            angle_text(v.theta_deg),
            v.f
        );
    }
    text
}

pub(super) fn lobe_name(is_transmitted: bool) -> &'static str {
    if is_transmitted { "transmission" } else { "reflection" }
}

/// The values as a figure: a panel for each side and incidence, with both lobes and their bands.
pub fn boundary_figure(title: &str, values: &[BoundaryValue]) -> Figure {
    let has_band = values.iter().any(|v| v.std.is_some());
    let panels = values
        .chunk_by(|a, b| a.side == b.side && a.incidence_deg.total_cmp(&b.incidence_deg).is_eq());
    let panel = |here: &[BoundaryValue]| {
        let from = if here[0].side == Side::Air { "from the air" } else { "from inside" };
        let curves = here
            .chunk_by(|a, b| a.is_transmitted == b.is_transmitted)
            .flat_map(|lobe| curve_and_band(lobe_name(lobe[0].is_transmitted), lobe));
        let caption = format!("{from}, {}°", angle_text(here[0].incidence_deg));
        Panel { caption, curves: curves.collect() }
    };
    let bands = if has_band { ", with 95 % bands" } else { "" };
    Figure {
        title: format!("{title}: the rough boundary{bands}"),
        x_label: "angle of observation in the medium that the light goes to (°)".into(),
        y_label: "BSDF (1/sr)".into(),
        x_range: (-90.0, 90.0),
        across: Across::Angle,
        scale: Scale::LOG,
        shared_y: true,
        columns: None,
        panels: panels.map(panel).collect(),
    }
}

/// A curve and its band, if it has one.
pub(super) fn curve_and_band(label: &str, values: &[BoundaryValue]) -> Vec<Curve> {
    if values.is_empty() {
        return Vec::new();
    }
    let points = values.iter().map(|v| (v.theta_deg, v.f)).collect();
    let line = Curve { label: label.to_owned(), points, style: CurveStyle::Fitted };
    if values.iter().all(|v| v.std.is_none()) {
        return vec![line];
    }
    let ends = |v: &BoundaryValue| {
        let by = BAND * v.std.filter(|std| std.is_finite()).unwrap_or(0.0);
        [(v.theta_deg, (v.f - by).max(0.0)), (v.theta_deg, v.f + by)]
    };
    let points = values.iter().flat_map(ends).collect();
    vec![Curve { label: label.to_owned(), points, style: CurveStyle::Band }, line]
}

/// The files `stem-boundary.svg`, `.png` and `.csv`, opened before the work.
#[derive(Debug)]
pub struct BoundaryFiles([AtomicFile; 3]);

impl BoundaryFiles {
    /// Opens all three.
    ///
    /// # Errors
    /// Those of [`AtomicFile::create`].
    pub fn create(folder: &Path, stem: &str) -> Result<Self, OutputError> {
        let open = |end| AtomicFile::create(folder.join(format!("{stem}-boundary.{end}")));
        Ok(Self([open("svg")?, open("png")?, open("csv")?]))
    }

    /// Draws and completes all three; returns their paths.
    ///
    /// # Errors
    /// [`FigureError`]; none is written then.
    pub fn write(self, title: &str, values: &[BoundaryValue]) -> Result<Vec<PathBuf>, FigureError> {
        let figure = boundary_figure(title, values);
        let csv = boundary_csv(values).into_bytes();
        let contents = [plot::svg(&figure)?.into_bytes(), plot::png(&figure)?, csv];
        let written = self.0.iter().map(|file| file.path().to_owned()).collect();
        finish_all(self.0.into_iter().zip(contents).collect())?;
        Ok(written)
    }
}
