//! What waves, rays and single facets are off by on cuts of a height map.

use std::fmt::Write as _;

use asperity_rigorous::{
    Accuracy, Approximation, Comparison, Cut, CutError, CutOptions, Deviation, Kind, Light, Piece,
    Profile, Question, RayOptions, RigorousError, Shape, Side, Verdict, Verdicts, measure,
};
use serde_json::{Value, json};

use super::off_by::OffBy;
use crate::surface::{HeightMap, Incomplete};
use crate::watch::Watch;

/// What is asked of the cuts of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct CutsRequest {
    /// Index of the dielectric under the map over that of air.
    pub ior: f64,
    /// Wavelength in vacuum, um.
    pub wavelength_um: f64,
    /// Sides the light comes from, each with an angle of incidence in that medium, degrees.
    pub incidences: Vec<(Side, f64)>,
    /// Cuts that are solved rigorously.
    pub solved: usize,
    /// Length of a cut, um; `None`: 60 wavelengths, or as much as the map has room for.
    pub period_um: Option<f64>,
}

/// What was cut and found.
#[derive(Clone, Debug)]
pub struct MapCuts {
    /// Cuts in all.
    pub cuts: usize,
    /// Whether columns are among them, which needs square pixels.
    pub has_columns: bool,
    /// Length of a period, um, and of the crossfade in it.
    pub period_um: f64,
    /// See there.
    pub crossfade_um: f64,
    /// Cut-off of the low-pass, um.
    pub cutoff_um: f64,
    /// Rms over the cuts: levelled, with the ends joined, after the low-pass.
    pub shapes: [Shape; 3],
    /// What waves, rays and facets are off by.
    pub verdicts: Verdicts,
}

/// Why nothing was found.
#[derive(Debug, thiserror::Error)]
pub enum NoCuts {
    /// Missing points.
    #[error(transparent)]
    Incomplete(#[from] Incomplete),
    /// The map is too small.
    #[error(
        "the map has room for {cuts} cuts of {period_um:.1} um ({wavelengths:.0} wavelengths), and two of at least {least:.0} wavelengths are needed; give a larger map, or a shorter --period-um"
    )]
    TooSmall {
        /// Cuts that have room.
        cuts: usize,
        /// Their length.
        period_um: f64,
        /// The same in wavelengths.
        wavelengths: f64,
        /// The least length.
        least: f64,
    },
    /// A setting out of range, or a profile that is none.
    #[error(transparent)]
    Cut(#[from] CutError),
    /// No solution.
    #[error(transparent)]
    Unsolved(#[from] RigorousError),
}

/// Length of a cut in wavelengths: usual, and at least.
const USUAL_WAVELENGTHS: f64 = 60.0;
const LEAST_WAVELENGTHS: f64 = 10.0;
/// Cuts that waves, rays and facets are computed on at most.
const MOST_CUTS: usize = 200;
/// Starts of rays on each cut and incidence.
const RAYS: usize = 2000;
/// Error of an efficiency.
const TOLERANCE: f64 = 1e-6;

impl CutsRequest {
    /// The same angles from each of some sides.
    pub fn each_side(sides: &[Side], incidences_deg: &[f64]) -> Vec<(Side, f64)> {
        let of = |side: &Side| {
            let side = *side;
            incidences_deg.iter().map(move |deg| (side, *deg))
        };
        sides.iter().flat_map(of).collect()
    }

    /// Cuts rows and columns, solves some, and compares. `watch` is told the share that is done.
    ///
    /// # Errors
    /// [`NoCuts`].
    pub fn run(&self, map: &HeightMap, watch: Watch<'_>) -> Result<MapCuts, NoCuts> {
        let heights = map.need_complete()?;
        let (nx, ny) = (map.nx(), map.ny());
        let has_columns = (map.dx_um() / map.dy_um() - 1.0).abs() < 1e-6;
        let longest = if has_columns { nx.max(ny) } else { nx } as f64 * map.dx_um();
        let usual = CutOptions::new(1.0, self.ior, self.wavelength_um);
        let room = longest / (1.0 + usual.crossfade) - 2.0 * map.dx_um();
        let period_um = self.period_um.unwrap_or(USUAL_WAVELENGTHS * self.wavelength_um).min(room);
        let wavelengths = period_um / self.wavelength_um;
        let too_small = |cuts: usize| NoCuts::TooSmall {
            cuts,
            period_um,
            wavelengths,
            least: LEAST_WAVELENGTHS,
        };
        if wavelengths.is_nan() || wavelengths < LEAST_WAVELENGTHS {
            return Err(too_small(0));
        }
        let options = CutOptions { period_um, ..usual };
        let mut lines: Vec<Vec<f64>> = heights.chunks(nx).map(<[f64]>::to_vec).collect();
        if has_columns {
            let column = |x: usize| (0..ny).map(|y| heights[y * nx + x]).collect();
            lines.extend((0..nx).map(column));
        }
        let mut places: Vec<(usize, usize)> = Vec::new();
        for (number, line) in lines.iter().enumerate() {
            let starts = options.starts(line.len(), map.dx_um())?;
            places.extend(starts.into_iter().map(|start| (number, start)));
        }
        if places.len() < 2 {
            return Err(too_small(places.len()));
        }
        let count = places.len().min(MOST_CUTS);
        let picked = (0..count).map(|i| places[(2 * i + 1) * places.len() / (2 * count)]);
        let cuts = picked
            .map(|(line, start)| options.cut(&lines[line], map.dx_um(), start))
            .collect::<Result<Vec<Cut>, CutError>>()?;
        let profiles: Vec<Profile> = cuts.iter().map(|cut| cut.profile.clone()).collect();
        let pieces = Piece::spread(profiles, self.solved.max(2));
        let question = Question {
            index: self.ior,
            wavelength_um: self.wavelength_um,
            incidences: self.incidences.clone(),
            accuracy: Accuracy { tolerance: TOLERANCE, ..Accuracy::default() },
            rays: RayOptions { starts: RAYS, seed: 1 },
        };
        let verdicts = measure(&pieces, &question, &|share| watch.share(share))?;
        let rms = |of: &dyn Fn(&Cut) -> f64| {
            (cuts.iter().map(|cut| of(cut).powi(2)).sum::<f64>() / count as f64).sqrt()
        };
        let shape = |of: &dyn Fn(&Cut) -> Shape| Shape {
            rq_um: rms(&|cut| of(cut).rq_um),
            rms_slope: rms(&|cut| of(cut).rms_slope),
        };
        Ok(MapCuts {
            cuts: count,
            has_columns,
            period_um: cuts[0].profile.period_um(),
            crossfade_um: cuts[0].crossfade_um,
            cutoff_um: options.cutoff_um,
            shapes: [shape(&|c| c.measured), shape(&|c| c.joined), shape(&|c| c.filtered)],
            verdicts,
        })
    }
}

pub(super) fn side_word(side: Side) -> &'static str {
    if side == Side::Air { "air" } else { "inside" }
}

pub(super) fn lobe_word(kind: Kind) -> &'static str {
    if kind == Kind::Reflected { "reflection" } else { "transmission" }
}

fn light_word(light: Light) -> &'static str {
    match light {
        Light::Te => "TE",
        Light::Tm => "TM",
        Light::Unpolarised => "unpolarised",
    }
}

fn approximation_word(approximation: Approximation) -> &'static str {
    match approximation {
        Approximation::Kirchhoff => "waves",
        Approximation::Rays => "rays",
        Approximation::Facets => "single facets",
    }
}

impl MapCuts {
    /// What was cut, and a line for each lobe.
    pub fn text(&self) -> String {
        let of = |shape: &Shape| format!("Rq {:.4} um, slope {:.4}", shape.rq_um, shape.rms_slope);
        let v = &self.verdicts;
        let mut text = format!(
            "rigorous on cuts of this map, taken as grooves: {} {}, period {:.2} um, levelled ({}), ends faded into each other over \
             {:.2} um ({}), low-pass at {:.3} um ({})\n\
             {} of them solved by Maxwell's equations (energy to {:.0e}); off by, % of the peak of the lobe (eq. 18; one standard error), unpolarised\n\
             from    lobe          deg    waves                      to 1 %  rays                       single facets              flux: rigorous, waves, rays\n",
            self.cuts,
            if self.has_columns { "rows and columns" } else { "rows" },
            self.period_um,
            of(&self.shapes[0]),
            self.crossfade_um,
            of(&self.shapes[1]),
            self.cutoff_um,
            of(&self.shapes[2]),
            v.solved,
            v.energy_error
        );
        for lobe in v.lobes.iter().filter(|lobe| lobe.light == Light::Unpolarised) {
            let [waves, rays, facets] = lobe.comparisons.map(|c| deviation(c.reading));
            let holds = OffBy::from(lobe.comparisons[0].reading).holds_word();
            let [w, r, _] = lobe.comparisons.map(|c| c.total.value);
            let _ = writeln!(
                text,
                "{:<7} {:<13} {:<6.1} {waves:<26} {holds:<7} {rays:<26} {facets:<26} {:.4}, {w:.4}, {r:.4}; coherent {:.4}, {:.4}",
                side_word(lobe.side),
                lobe_word(lobe.kind),
                lobe.incidence_deg,
                lobe.total.value,
                unsigned(lobe.coherent.value),
                unsigned(lobe.coherent_kirchhoff.value),
            );
        }
        text + &self.polarised()
    }

    /// Where polarisation matters: single orders.
    fn polarised(&self) -> String {
        let lobes = &self.verdicts.lobes;
        let single = |like: &Verdict, light: Light| {
            let same = |v: &&Verdict| {
                v.side == like.side
                    && v.kind == like.kind
                    && (v.asked_deg - like.asked_deg).abs() < 1e-9
                    && v.light == light
            };
            lobes.iter().find(same).map_or(f64::NAN, |v| v.single_orders_percent.value)
        };
        let mut text =
            String::from("single orders, waves, % of the strongest: unpolarised / TE / TM\n");
        for lobe in lobes.iter().filter(|lobe| lobe.light == Light::Unpolarised) {
            let [un, te, tm] = [Light::Unpolarised, Light::Te, Light::Tm].map(|l| single(lobe, l));
            let _ = writeln!(
                text,
                "{:<7} {:<13} {:<6.1} {un:.4} / {te:.4} / {tm:.4}",
                side_word(lobe.side),
                lobe_word(lobe.kind),
                lobe.incidence_deg
            );
        }
        text
    }

    /// All of it as JSON.
    pub fn json(&self) -> Value {
        let shape = |s: &Shape| json!({"rq_um": s.rq_um, "rms_slope": s.rms_slope});
        let of = |d: &Deviation| json!({"percent": d.percent, "low_percent": d.low_percent, "high_percent": d.high_percent, "noise_percent": d.noise_percent});
        let compared = |c: &Comparison| {
            json!({
                "engine": approximation_word(c.approximation),
                "flux": c.total.value,
                "reading": of(&c.reading),
                "diffuse": of(&c.diffuse),
            })
        };
        let lobe = |v: &Verdict| {
            json!({
                "side": side_word(v.side),
                "lobe": lobe_word(v.kind),
                "light": light_word(v.light),
                "incidence_deg": v.incidence_deg,
                "flux": v.total.value,
                "flux_std_error": v.total.error,
                "coherent": v.coherent.value,
                "coherent_waves": v.coherent_kirchhoff.value,
                "single_orders_percent": v.single_orders_percent.value,
                "waves_hold": OffBy::from(v.comparisons[0].reading).holds(),
                "engines": v.comparisons.iter().map(compared).collect::<Vec<_>>(),
            })
        };
        json!({
            "cuts": self.cuts,
            "columns": self.has_columns,
            "period_um": self.period_um,
            "crossfade_um": self.crossfade_um,
            "cutoff_um": self.cutoff_um,
            "levelled": shape(&self.shapes[0]),
            "joined": shape(&self.shapes[1]),
            "filtered": shape(&self.shapes[2]),
            "solved": self.verdicts.solved,
            "nodes": self.verdicts.nodes,
            "energy_error": self.verdicts.energy_error,
            "lobes": self.verdicts.lobes.iter().map(lobe).collect::<Vec<_>>(),
        })
    }
}

/// A share that noise may have made negative, for print.
fn unsigned(share: f64) -> f64 {
    if share.abs() < 5e-5 { 0.0 } else { share }
}

fn deviation(d: Deviation) -> String {
    format!("{:.3} ({:.3} to {:.3})", d.percent, d.low_percent, d.high_percent)
}
