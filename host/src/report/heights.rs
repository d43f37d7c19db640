//! Plots of a height map: the map in colours, its histogram, its radial spectrum.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::{FigureError, significant};
use crate::output::{AtomicFile, OutputError, finish_all};
use crate::plot::{self, Across, Curve, CurveStyle, Figure, MapPicture, Panel, Scale};
use crate::surface::{HeightMap, Roughness, Spectrum};

/// The content of the plots.
#[derive(Clone, Copy, Debug)]
pub struct MapFigures<'a> {
    /// Line above each.
    pub title: &'a str,
    /// The map.
    pub map: &'a HeightMap,
    /// Its spectrum; left out without it.
    pub spectrum: Option<&'a Spectrum>,
}

impl MapFigures<'_> {
    /// The title of a map in a file: its name, and Rq.
    pub fn title(file: &Path, map: &HeightMap) -> String {
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
        format!("{name}, Rq {} µm", significant(Roughness::of(map).rq_um, 4))
    }
}

/// The files `STEM-map`, `STEM-histogram` and `STEM-spectrum`, each as SVG and PNG, opened before the work.
#[derive(Debug)]
pub struct MapFigureFiles([[AtomicFile; 2]; 3]);

impl MapFigureFiles {
    /// Opens all six.
    ///
    /// # Errors
    /// Those of [`AtomicFile::create`].
    pub fn create(stem: &Path) -> Result<Self, OutputError> {
        let open = |word: &str, extension: &str| {
            let mut name = OsString::from(stem.file_name().unwrap_or_default());
            name.push(format!("-{word}.{extension}"));
            AtomicFile::create(stem.with_file_name(name))
        };
        let both = |word: &str| Ok([open(word, "svg")?, open(word, "png")?]);
        Ok(Self([both("map")?, both("histogram")?, both("spectrum")?]))
    }

    /// Draws and completes them; returns their paths.
    ///
    /// # Errors
    /// [`FigureError`]; none is written then.
    pub fn write(self, figures: &MapFigures<'_>) -> Result<Vec<PathBuf>, FigureError> {
        let mut values = vec![f64::NAN; figures.map.nx() * figures.map.ny()];
        for (col, row, h) in figures.map.points() {
            values[row * figures.map.nx() + col] = h;
        }
        let picture = picture(figures, &values);
        let drawn = |figure: &Figure| -> Result<_, FigureError> {
            Ok([plot::svg(figure)?.into_bytes(), plot::png(figure)?])
        };
        let mut contents = vec![
            [plot::map_svg(&picture)?.into_bytes(), plot::map_png(&picture)?],
            drawn(&histogram(figures))?,
        ];
        if let Some(figure) = figures.spectrum.and_then(|s| radial(figures.title, s)) {
            contents.push(drawn(&figure)?);
        }
        let drawn: Vec<_> =
            self.0.into_iter().flatten().zip(contents.into_iter().flatten()).collect();
        let written = drawn.iter().map(|(file, _)| file.path().to_owned()).collect();
        finish_all(drawn)?;
        Ok(written)
    }
}

fn picture<'a>(figures: &MapFigures<'a>, values: &'a [f64]) -> MapPicture<'a> {
    let map = figures.map;
    MapPicture {
        title: figures.title.to_owned(),
        points: (map.nx(), map.ny()),
        extent_um: (map.nx() as f64 * map.dx_um(), map.ny() as f64 * map.dy_um()),
        label: "height (µm)",
        values,
    }
}

/// Bins of the histogram.
const BINS: usize = 120;

/// The density of heights about the mean, and that of a Gaussian with the same Rq.
fn histogram(figures: &MapFigures<'_>) -> Figure {
    let r = Roughness::of(figures.map);
    let count = figures.map.points().count() as f64;
    let mean = figures.map.points().map(|p| p.2).sum::<f64>() / count;
    let rq = if r.rq_um > 0.0 { r.rq_um } else { 1.0 };
    // a lonely spike must not squeeze the rest
    let (lo, hi) = (-r.rv_um.clamp(3.0 * rq, 6.0 * rq), r.rp_um.clamp(3.0 * rq, 6.0 * rq));
    let width = (hi - lo) / BINS as f64;
    let mut bins = vec![0.0; BINS];
    for (_, _, h) in figures.map.points() {
        let place = (h - mean - lo) / width;
        if let (true, Some(bin)) = (place >= 0.0, bins.get_mut(place as usize)) {
            *bin += 1.0 / (count * width);
        }
    }
    let steps = bins
        .iter()
        .enumerate()
        .flat_map(|(k, &density)| [k, k + 1].map(|end| (lo + end as f64 * width, density)));
    let gauss = (0..=400).map(|k| {
        let h = lo + (hi - lo) * f64::from(k) / 400.0;
        let density = (-0.5 * (h / rq) * (h / rq)).exp() / (rq * std::f64::consts::TAU.sqrt());
        (h, density)
    });
    Figure {
        title: figures.title.to_owned(),
        x_label: "height about the mean (µm)".into(),
        y_label: "density (1/µm)".into(),
        x_range: (lo, hi),
        across: Across::Linear,
        scale: Scale::Linear,
        shared_y: true,
        columns: None,
        panels: vec![Panel {
            caption: format!("Rsk {:.3}, Rku {:.3}", r.rsk, r.rku).replace('-', "−"),
            curves: vec![
                Curve {
                    label: "heights".into(),
                    points: steps.collect(),
                    style: CurveStyle::Measured,
                },
                Curve {
                    label: format!("Gaussian, Rq {:.4} µm", r.rq_um),
                    points: gauss.collect(),
                    style: CurveStyle::Fitted,
                },
            ],
        }],
    }
}

/// The radial density over the frequency, both logarithmic; `None` if there are no two frequencies to join.
fn radial(title: &str, spectrum: &Spectrum) -> Option<Figure> {
    let rings = spectrum.radial();
    let points: Vec<(f64, f64)> = rings
        .iter()
        .filter(|ring| ring.density_um4 > 0.0)
        .map(|ring| (ring.frequency_per_um, ring.density_um4))
        .collect();
    let (first, last) = (points.first()?.0, points.last()?.0);
    let highest = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let lowest = points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
    (last > first).then(|| Figure {
        title: title.to_owned(),
        x_label: "spatial frequency (1/µm)".into(),
        y_label: "power spectral density (µm⁴)".into(),
        x_range: (first, last),
        across: Across::Log,
        scale: Scale::Log { decades: (highest / lowest).log10().ceil().clamp(1.0, 15.0) as u8 },
        shared_y: true,
        columns: None,
        panels: vec![Panel {
            caption: "mean over directions".into(),
            curves: vec![Curve { label: "heights".into(), points, style: CurveStyle::Measured }],
        }],
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{MapFigureFiles, MapFigures};
    use crate::surface::{Edges, HeightMap, Spectrum};

    #[test]
    fn six_files_are_written_also_for_flat_and_tiny_maps() {
        let folder = tempfile::tempdir().unwrap();
        for (n, height) in [(32, 1.0), (32, 0.0), (4, 1.0), (1, 0.0)] {
            let heights = (0..n * n).map(|k| height * f64::from(k * k % 17)).collect();
            let size = (n as usize, n as usize);
            let map = HeightMap::new(size, (0.5, 0.5), heights).unwrap();
            let spectrum = Spectrum::of(&map, Edges::Mirrored).unwrap();
            let files = MapFigureFiles::create(&folder.path().join("s")).unwrap();
            let title = MapFigures::title(Path::new("folder/s.npy"), &map);
            assert!(title.starts_with("s.npy, Rq ") && title.ends_with(" µm"), "{title}");
            let figures = MapFigures { title: &title, map: &map, spectrum: Some(&spectrum) };
            let written = files.write(&figures).unwrap();
            assert_eq!(written.len(), if height > 0.0 { 6 } else { 4 }, "{n}");
            assert!(written.iter().all(|path| path.exists()));
        }
    }
}
