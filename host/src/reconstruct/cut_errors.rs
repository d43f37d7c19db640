//! What waves, rays and single facets are off by on the measured map itself: rigorous solutions on cuts of it, for the lobe that was measured and for
//! the light from inside. Where they are there they stand in place of the atlas, which knows surfaces like it only.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::atlas::Engine;
use crate::kirchhoff::Wavelengths;
use crate::method::{Bounces, Kind};
use crate::model::Model;
use crate::provenance::InputFile;
use crate::rigorous::solver::{Kind as SolverLobe, Light, Side as SolverSide, Verdict};
use crate::rigorous::{CutsRequest, MapCuts, OffBy, solver_side};

use super::task::Task;

/// Incidences from inside that are told beside those of the measurement, degrees: below the critical angle.
const INSIDE_DEG: [f64; 2] = [0.0, 30.0];
/// Angles as near as this are one, degrees.
const SAME_DEG: f64 = 1e-6;
/// The engines with what people call them.
const ENGINES: [(Engine, &str); 3] =
    [(Engine::Kirchhoff, "waves"), (Engine::Rays, "rays"), (Engine::Facet, "single facets")];

/// One lobe of the boundary.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LobeErrors {
    /// Whether the light comes from inside the dielectric.
    pub from_inside: bool,
    /// Whether it goes through.
    pub is_transmitted: bool,
    /// Angle of incidence in the medium the light comes from, degrees.
    pub incidence_deg: f64,
    /// Whether the measured light meets the surface in this way first.
    pub is_measured: bool,
    /// Kirchhoff's integral, without shadowing.
    pub waves: OffBy,
    /// Rays with all bounces.
    pub rays: OffBy,
    /// Single facets.
    pub facets: OffBy,
}

/// All lobes that were asked for, and what was cut.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CutErrors {
    /// Wavelength in vacuum, um.
    pub wavelength_um: f64,
    /// Cuts of the map.
    pub cuts: usize,
    /// Those of them on which Maxwell's equations were solved.
    pub solved: usize,
    /// Length of a cut, um.
    pub period_um: f64,
    /// Rms height of the cuts as they were solved, um.
    pub rq_um: f64,
    /// Their rms slope.
    pub rms_slope: f64,
    /// By incidence, then reflected and transmitted.
    pub lobes: Vec<LobeErrors>,
}

/// Why nothing can be solved on the map of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoCutsOf {
    /// No map.
    #[error("Maxwell's equations are solved on cuts of a height map, and there is none")]
    NoMap,
    /// No index.
    #[error("Maxwell's equations are solved for a dielectric, and this body is opaque")]
    Opaque,
    /// No wavelength, or several.
    #[error("Maxwell's equations are solved for one wavelength")]
    Wavelength,
}

impl Task<'_> {
    /// What has to be solved on `solved` cuts of the map: at the incidences of the measurement and from inside.
    ///
    /// # Errors
    /// [`NoCutsOf`].
    pub fn cuts_request(&self, solved: usize) -> Result<CutsRequest, NoCutsOf> {
        let _map = self.map.ok_or(NoCutsOf::NoMap)?;
        let ior = self.options.body.eta().map_err(|_| NoCutsOf::Opaque)?.get();
        let nm = self.light.wavelengths.as_ref().and_then(Wavelengths::only_nm);
        let nm = nm.ok_or(NoCutsOf::Wavelength)?;
        let (side, measured) = self.measured_incidences();
        let mut incidences: Vec<(SolverSide, f64)> =
            measured.into_iter().map(|deg| (solver_side(side), deg)).collect();
        for deg in INSIDE_DEG {
            let there = (SolverSide::Dielectric, deg);
            if !incidences.iter().any(|i| i.0 == there.0 && (i.1 - deg).abs() < SAME_DEG) {
                incidences.push(there);
            }
        }
        let wavelength_um = 1e-3 * nm;
        Ok(CutsRequest { ior, wavelength_um, incidences, solved, period_um: None })
    }

    /// What was found, told of this measurement.
    pub fn cut_errors(&self, request: &CutsRequest, found: &MapCuts) -> CutErrors {
        let (side, _) = self.measured_incidences();
        let measured = (side == Side::Dielectric, self.setup.lobe() == Lobe::Transmission);
        CutErrors::of(found, request.wavelength_um, Some(measured))
    }

    /// What names the map and the question, a SHA-256: equal where the answer would come out equal.
    pub fn cuts_key(&self, request: &CutsRequest) -> String {
        let map = self.map.map(|map| (&map.input, &map.preparation, map.edges));
        let text = format!("{}\n{request:?}\n{map:?}\n", env!("CARGO_PKG_VERSION"));
        InputFile::of_bytes("", text.as_bytes()).sha256
    }

    /// The side from which the measured light meets the rough face first, and its angles there.
    fn measured_incidences(&self) -> (Side, Vec<f64>) {
        let angles: Vec<f64> = self.measurement.by_incidence().map(|i| i.sigma_deg.abs()).collect();
        self.at_the_rough_face(&angles)
    }
}

impl LobeErrors {
    /// Of an engine.
    pub fn of(&self, engine: Engine) -> OffBy {
        match engine {
            Engine::Kirchhoff => self.waves,
            Engine::Rays => self.rays,
            Engine::Facet => self.facets,
        }
    }

    /// Such as `reflection inside`.
    pub fn name(&self) -> &'static str {
        match (self.from_inside, self.is_transmitted) {
            (false, false) => "reflection in air",
            (false, true) => "transmission from air",
            (true, false) => "reflection inside",
            (true, true) => "transmission from inside",
        }
    }
}

impl CutErrors {
    /// What was found at a wavelength in um; `measured` is the lobe that the measured light meets first: whether from inside, and whether through.
    pub fn of(found: &MapCuts, wavelength_um: f64, measured: Option<(bool, bool)>) -> Self {
        let lobe = |v: &Verdict| {
            let from_inside = v.side == SolverSide::Dielectric;
            let is_transmitted = v.kind == SolverLobe::Transmitted;
            let [waves, rays, facets] = v.comparisons.map(|c| OffBy::from(c.reading));
            LobeErrors {
                from_inside,
                is_transmitted,
                incidence_deg: v.asked_deg,
                is_measured: measured == Some((from_inside, is_transmitted)),
                waves,
                rays,
                facets,
            }
        };
        let unpolarised = found.verdicts.lobes.iter().filter(|v| v.light == Light::Unpolarised);
        Self {
            wavelength_um,
            cuts: found.cuts,
            solved: found.verdicts.solved,
            period_um: found.period_um,
            rq_um: found.shapes[2].rq_um,
            rms_slope: found.shapes[2].rms_slope,
            lobes: unpolarised.map(lobe).collect(),
        }
    }

    /// The largest error of an engine in the lobe that was measured.
    pub fn measured(&self, engine: Engine) -> Option<&LobeErrors> {
        worst(self.lobes.iter().filter(|lobe| lobe.is_measured), engine)
    }

    /// What the engine that a fitted method is computed with is off by in the measured lobe; `None` of a method that is more than one of them.
    pub fn of_method(&self, method: &str, model: &Model) -> Option<OffBy> {
        let engine = engine_of(method, model)?;
        self.measured(engine).map(|lobe| lobe.of(engine))
    }

    /// For machines, in the words of `stats --rigorous --json`.
    pub fn json(&self) -> Value {
        let lobe = |l: &LobeErrors| {
            json!({
                "side": if l.from_inside { "inside" } else { "air" },
                "lobe": if l.is_transmitted { "transmission" } else { "reflection" },
                "incidence_deg": l.incidence_deg,
                "measured": l.is_measured,
                "waves": l.waves.json(),
                "rays": l.rays.json(),
                "single facets": l.facets.json(),
            })
        };
        json!({
            "wavelength_nm": 1e3 * self.wavelength_um,
            "cuts": self.cuts,
            "solved": self.solved,
            "period_um": self.period_um,
            "rq_um": self.rq_um,
            "rms_slope": self.rms_slope,
            "lobes": self.lobes.iter().map(lobe).collect::<Vec<_>>(),
        })
    }

    /// In place of the lines of the atlas: the measured lobe, and the light from inside.
    pub fn words(&self) -> Vec<String> {
        let head = format!(
            "on {} of {} cuts of the map itself, as grooves; Rq {:.2} wavelengths, slope {:.2}",
            self.solved,
            self.cuts,
            self.rq_um / self.wavelength_um,
            self.rms_slope
        );
        let measured: Vec<&LobeErrors> = self.lobes.iter().filter(|l| l.is_measured).collect();
        let inside = |is_transmitted: bool| {
            let is_usual = |deg: f64| INSIDE_DEG.iter().any(|usual| (usual - deg).abs() < SAME_DEG);
            let lobes = self.lobes.iter().filter(|l| {
                l.from_inside && l.is_transmitted == is_transmitted && is_usual(l.incidence_deg)
            });
            said(&lobes.collect::<Vec<_>>())
        };
        vec![
            format!("{head}: {}", said(&measured)),
            format!("from inside, 0 and 30 deg: {}; {}", inside(false), inside(true)),
        ]
    }
}

/// The engine that a method is computed with.
fn engine_of(method: &str, model: &Model) -> Option<Engine> {
    let kind = Kind::named(method).ok()?;
    let is_hybrid = kind.is_wave() && kind.traced;
    if kind.of_parts || is_hybrid {
        return None;
    }
    let all = model.bounces.as_deref().is_some_and(|word| word != Bounces::One.word());
    Some(match (kind.is_wave(), kind.traced || all) {
        (true, _) => Engine::Kirchhoff,
        (_, true) => Engine::Rays,
        _ => Engine::Facet,
    })
}

/// The lobe with the largest error of an engine.
fn worst<'a>(
    lobes: impl Iterator<Item = &'a LobeErrors>,
    engine: Engine,
) -> Option<&'a LobeErrors> {
    lobes.max_by(|a, b| a.of(engine).percent.total_cmp(&b.of(engine).percent))
}

/// One lobe at several incidences: the worst of them for each engine.
fn said(lobes: &[&LobeErrors]) -> String {
    let Some(first) = lobes.first() else { return "no light".into() };
    let one = |(engine, name): &(Engine, &str)| {
        let lobe = worst(lobes.iter().copied(), *engine)?;
        Some(format!("of {name} {} at {} deg", lobe.of(*engine).text(), lobe.incidence_deg))
    };
    let parts: Vec<String> = ENGINES.iter().filter_map(one).collect();
    format!("{}: errors {}", first.name(), parts.join(", "))
}
