//! The tables of the page.

use asperity_core::direction::Side;
use maud::{Markup, html};

use crate::energy::side_name;
use crate::reconstruct::{Attempt, Cell, Comparison, CutErrors, LobeErrors, SampleResult};

use super::super::grid::{Field, Grid};
use super::super::number::{angle_text, significant, with_error};

/// Method by method.
pub(super) fn methods(sample: &SampleResult, timing: bool) -> Markup {
    let mut grid = sample.details();
    if timing {
        grid.head.push("time (s)".into());
        for (row, attempt) in grid.rows.iter_mut().zip(&sample.attempts) {
            let seconds = attempt.cell().and_then(Cell::seconds);
            row.push(seconds.map_or_else(|| "-".to_owned(), |s| format!("{s:.2}")).into());
        }
    }
    grid.html(&format!("Methods, {}", sample.title))
}

/// The methods in the order of what the data support, if they were ranked.
pub(super) fn ranking(sample: &SampleResult) -> Option<Markup> {
    let (grid, why) = sample.ranked()?;
    Some(html! { (grid.html(&format!("What the data support, {}", sample.title))) p { (why) } })
}

/// Where the light goes from inside, by the best method.
pub(super) fn inside(sample: &SampleResult) -> Option<Markup> {
    let cell = sample.best().and_then(Attempt::cell)?;
    let inside = cell.model.fluxes.iter().filter(|f| f.side == side_name(Side::Dielectric));
    let share = |value: f64, error: Option<f64>| match error.filter(|e| *e > 0.0) {
        Some(error) => with_error(value, Some(error)),
        None => format!("{:.4}", value + 0.0),
    };
    let rows: Vec<Vec<Field>> = inside
        .map(|f| {
            let cells = [
                format!("{}°", angle_text(f.incidence_deg)),
                share(f.reflected, f.std_reflected),
                share(f.transmitted, f.std_transmitted),
                share(f.lost, None),
            ];
            cells.map(Field::from).to_vec()
        })
        .collect();
    let head = ["incidence", "reflected", "transmitted", "lost"].map(String::from).to_vec();
    let title = format!("From inside, {}, {}", sample.title, cell.label);
    (!rows.is_empty()).then(|| Grid { head, rows }.html(&title))
}

/// What each engine is off by, lobe by lobe.
pub(super) fn accuracy(title: &str, errors: &CutErrors) -> Markup {
    let row = |lobe: &LobeErrors| {
        let measured = if lobe.is_measured { " (measured)" } else { "" };
        let cells = [
            format!("{}{measured}", lobe.name()),
            format!("{}°", angle_text(lobe.incidence_deg)),
            lobe.waves.text(),
            lobe.rays.text(),
            lobe.facets.text(),
        ];
        cells.map(Field::from).to_vec()
    };
    let head = ["lobe", "incidence", "waves", "rays", "single facets"].map(String::from).to_vec();
    let rows = errors.lobes.iter().map(row).collect();
    Grid { head, rows }.html(&format!("Off from Maxwell's equations, % of the peak, {title}"))
}

/// The figures of the maps, as in the paper's Table 1: a column a sample. `None` without maps.
pub(super) fn surfaces(comparison: &Comparison) -> Option<Markup> {
    let with_map: Vec<_> =
        comparison.samples.iter().filter_map(|s| Some((&s.name, s.surface.as_ref()?))).collect();
    if with_map.is_empty() {
        return None;
    }
    let mut rows: Vec<Vec<Field>> = Vec::new();
    let mut row = |name: &str, values: Vec<String>| {
        rows.push(std::iter::once(name.to_owned()).chain(values).map(Field::from).collect());
    };
    let each = |of: &dyn Fn(&crate::reconstruct::SurfaceFigures) -> String| {
        with_map.iter().map(|(_, s)| of(s)).collect::<Vec<_>>()
    };
    row("size (mm)", each(&|s| format!("{:.3} x {:.3}", s.extent_mm.0, s.extent_mm.1)));
    row("points", each(&|s| format!("{} x {}", s.size.0, s.size.1)));
    row("Ra (µm)", each(&|s| significant(s.roughness.ra_um, 4)));
    row("Rq (µm)", each(&|s| significant(s.roughness.rq_um, 4)));
    row("Rv (µm)", each(&|s| significant(s.roughness.rv_um, 4)));
    row("Rp (µm)", each(&|s| significant(s.roughness.rp_um, 4)));
    row("Rz (µm)", each(&|s| significant(s.roughness.rz_um, 4)));
    row("Rz5 (µm)", each(&|s| significant(s.roughness.rz5_um, 4)));
    row("Rsk", each(&|s| format!("{:.3}", s.roughness.rsk)));
    row("Rku", each(&|s| format!("{:.3}", s.roughness.rku)));
    let slope = |s: Option<f64>| s.map_or_else(|| "-".to_owned(), |s| format!("{s:.3}"));
    row(
        "rms slope x, y",
        each(&|s| {
            format!("{}, {}", slope(s.roughness.rms_slope_x), slope(s.roughness.rms_slope_y))
        }),
    );
    row(
        "1/e lag (µm)",
        each(&|s| s.roughness.acl_um.map_or_else(|| "-".to_owned(), |l| significant(l, 3))),
    );
    let names = with_map.iter().map(|(name, _)| (*name).clone());
    let head = std::iter::once("figure".to_owned()).chain(names).collect();
    Some(Grid { head, rows }.html("Table 1, the maps as the methods were given them"))
}

/// Samples down, methods across, as in the paper's Table 2.
pub(super) fn errors(comparison: &Comparison) -> Markup {
    let mut grid = comparison.errors();
    grid.head.push("noise floor".into());
    for (row, sample) in grid.rows.iter_mut().zip(&comparison.samples) {
        let floor = sample.noise_floor_percent;
        row.push(floor.map_or_else(|| "unknown".to_owned(), |f| format!("{f:.3} %")).into());
    }
    grid.html("Table 2, error of eq. (18), in % of the largest reading")
}

/// How long the fits took.
pub(super) fn times(comparison: &Comparison) -> Option<Markup> {
    Some(comparison.times()?.html("Times of the fits, s"))
}
