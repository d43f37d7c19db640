//! What evaluates the law on a target: the cheapest way that errs by no more than was asked.

use asperity_core::bsdf::LobeSet;

use super::cost::{Cost, Costs, Way};
use super::evaluator::{FileRough, Grid, files, of_table, table, writer};
use super::record::ExportRecord;
use super::rough::Rough;
use super::scene::{Scene, Statistics, TargetKind};
use super::study::{Reduced, Study};

/// Share of the bound that the errors of a plan may use: paths are finite, and errors add.
pub(super) const USED: f64 = 0.85;
/// Share of the bound below which the light of later bounces is left out where that makes nothing cheaper but the fit.
const LITTLE: f64 = 0.3;
/// Sizes of tables that are tried, bytes.
const SIZES: [usize; 14] =
    [1536, 2048, 3072, 4096, 6144, 8192, 12288, 16384, 24576, 32768, 49152, 65536, 98304, 131_072];
/// Grids that are tried: steps of the incidence in degrees, and error between angles in % of the peak.
const GRIDS: [(f64, f64); 8] = [
    (30.0, 10.0),
    (20.0, 5.0),
    (15.0, 5.0),
    (15.0, 2.0),
    (10.0, 2.0),
    (7.5, 1.0),
    (5.0, 0.5),
    (2.5, 0.25),
];

/// What is decided of the evaluation.
#[derive(Clone, Debug)]
pub(super) struct Chosen {
    pub(super) all_bounces: bool,
    pub(super) is_single: bool,
    pub(super) lobes: LobeSet,
    pub(super) table_bytes: Option<usize>,
    pub(super) export: Option<ExportRecord>,
    /// Bytes of files or flash.
    pub(super) bytes: Option<usize>,
    pub(super) cost: Cost,
    /// Error and its standard error, fractions; of the band of wavelengths not yet.
    pub(super) error: (f64, f64),
    /// Why, one line.
    pub(super) why: String,
}

/// The nearest that is possible, and what stands in the way.
#[derive(Clone, Debug)]
pub(super) struct Blocked {
    pub(super) nearest: Option<Chosen>,
    pub(super) obstacles: Vec<String>,
}

/// What is searched with.
pub(super) struct Search<'a> {
    pub(super) scene: &'a Scene,
    pub(super) study: &'a Study,
    pub(super) costs: &'a Costs,
    /// The lobes that matter.
    pub(super) lobes: LobeSet,
    /// What the wavelengths of the plan err, a fraction.
    pub(super) band: f64,
}

impl Search<'_> {
    /// The largest error that evaluation may have, a fraction.
    pub(super) fn bound(&self) -> f64 {
        USED * self.scene.wanted.error_percent / 100.0
    }

    fn meets(&self, (off, spread): (f64, f64)) -> bool {
        (off + self.band).abs() + 2.0 * spread <= self.bound()
    }

    /// The law without later bounces, where these are worth next to nothing.
    fn is_one_enough(&self, share: f64) -> bool {
        let one = self.study.error(Some(Reduced::One), self.lobes);
        one.is_some_and(|(off, spread)| {
            (off + self.band).abs() + 2.0 * spread <= share * self.bound()
        })
    }

    /// The cheapest way on the target of the scene.
    pub(super) fn run(&self) -> Result<Chosen, Box<Blocked>> {
        match self.scene.target.kind {
            TargetKind::Host => Ok(self.on_host()),
            TargetKind::CortexM4f => self.on_device(),
            TargetKind::Zemax | TargetKind::Radiance => self.as_file(),
            TargetKind::Mitsuba => self.as_snippet(),
        }
    }

    fn on_host(&self) -> Chosen {
        let method = &self.study.law.method;
        let [double, single] = [Way::Double, Way::Single].map(|way| self.costs.of(method, way));
        let is_faster = single.eval_ns.zip(double.eval_ns).is_some_and(|(s, d)| s < d);
        let one = self.study.law.has_bounces() && self.is_one_enough(1.0);
        let kind = match (one, is_faster) {
            (true, true) => Some(Reduced::OneSingle),
            (true, false) => Some(Reduced::One),
            (false, true) => Some(Reduced::AllSingle),
            (false, false) => None,
        };
        let found = self.study.error(kind, self.lobes);
        let (kind, is_single) =
            if found.is_some() { (kind, is_faster) } else { (one.then_some(Reduced::One), false) };
        let error = self.study.error(kind, self.lobes).unwrap_or_default();
        let cost = if is_single { single } else { double };
        let ns = |cost: Cost| {
            cost.eval_ns.map_or("no measured time".into(), |ns| format!("{ns:.0} ns a value"))
        };
        let why = format!(
            "its formula in {}: {} ({} in {}; {})",
            if is_single { "single precision" } else { "double precision" },
            ns(cost),
            ns(if is_single { double } else { single }),
            if is_single { "double" } else { "single" },
            self.costs.origin
        );
        Chosen {
            all_bounces: !one,
            is_single,
            lobes: self.lobes,
            table_bytes: None,
            export: None,
            bytes: None,
            cost,
            error,
            why,
        }
    }

    fn on_device(&self) -> Result<Chosen, Box<Blocked>> {
        let target = self.scene.target;
        let mut obstacles = Vec::new();
        let mut nearest: Option<Chosen> = None;
        let formula = self.costs.of(&self.study.law.method, Way::Single);
        if let (Some(code), Some(count)) = (formula.code_bytes, formula.instructions)
            && let Some(error) = self.study.error(Some(Reduced::OneSingle), self.lobes)
        {
            let chosen = Chosen {
                all_bounces: false,
                is_single: true,
                lobes: self.lobes,
                table_bytes: None,
                export: None,
                bytes: Some(code),
                cost: formula,
                error,
                why: format!(
                    "its formula in single precision: {code} bytes of code, {count} instructions a value ({})",
                    self.costs.origin
                ),
            };
            let fits = code <= target.bytes && count <= target.instructions;
            if fits && self.meets(error) {
                return Ok(chosen);
            }
            if fits {
                obstacles.push(format!(
                    "its formula has one bounce, which errs by {:.2} %",
                    100.0 * error.0
                ));
                nearest = Some(chosen);
            } else {
                obstacles.push(format!("its formula takes {code} bytes and {count} instructions"));
            }
        }
        let of_table = self.costs.of("", Way::Table);
        let (code, count) = (of_table.code_bytes.unwrap_or(0), of_table.instructions.unwrap_or(0));
        if count > target.instructions {
            obstacles.push(format!(
                "a value of a table takes {count} instructions, {} are allowed",
                target.instructions
            ));
            return Err(Box::new(Blocked { nearest, obstacles }));
        }
        let one = self.study.law.has_bounces() && self.is_one_enough(LITTLE);
        let made = if one { &self.study.one } else { &self.study.full };
        for size in SIZES {
            let flash = code + size;
            let fits = flash <= target.bytes;
            let Ok(table) = table(made, self.lobes, size) else { continue };
            let bytes = table.bytes();
            let law = of_table_law(table);
            let error = self.study.error_of(&law, self.lobes);
            let chosen = Chosen {
                all_bounces: !one,
                is_single: true,
                lobes: self.lobes,
                table_bytes: Some(size),
                export: None,
                bytes: Some(code + bytes),
                cost: of_table,
                error,
                why: format!(
                    "a table of {bytes} bytes beside {code} bytes of code, {count} instructions a value ({}); the smallest that is near enough",
                    self.costs.origin
                ),
            };
            if fits && self.meets(error) {
                return Ok(chosen);
            }
            if self.meets(error) {
                obstacles.push(format!(
                    "{} KiB of flash hold no table with its code that errs by less; {:.1} KiB would do ({} + {bytes} bytes)",
                    target.bytes / 1024,
                    (code + bytes) as f64 / 1024.0,
                    code
                ));
                break;
            }
            if !fits && nearest.is_none() {
                // the smallest that there is shows what the flash would have to be at least
                obstacles.push(format!(
                    "the smallest table of these lobes takes {} bytes with its code, {} are allowed",
                    code + bytes,
                    target.bytes
                ));
                nearest = Some(chosen);
            } else if fits && nearest.as_ref().is_none_or(|n| error.0.abs() < n.error.0.abs()) {
                nearest = Some(chosen);
            }
        }
        if obstacles.is_empty() {
            obstacles.push("no table of up to 128 KiB is near enough".into());
        }
        Err(Box::new(Blocked { nearest, obstacles }))
    }

    fn as_file(&self) -> Result<Chosen, Box<Blocked>> {
        let nothing = |what: String| Box::new(Blocked { nearest: None, obstacles: vec![what] });
        let name = self.scene.target.kind.format().unwrap_or_default();
        let Some(writer) = writer(name) else {
            return Err(nothing(format!("format {name} is not written")));
        };
        let one = self.study.law.has_bounces() && self.is_one_enough(LITTLE);
        let made = if one { &self.study.one } else { &self.study.full };
        let most = self.study.most_incidence(self.lobes);
        let nm = self.scene.source.wavelength_nm;
        let mut nearest: Option<Chosen> = None;
        let mut obstacles = Vec::new();
        for (step, tolerance_percent) in GRIDS {
            let incidences_deg = incidences(step, most);
            let grid = Grid { incidences_deg, tolerance_percent };
            let files = match files(made, self.lobes, (&writer, &grid), f64::midpoint(nm[0], nm[1]))
            {
                Ok(files) => files,
                Err(what) => {
                    if !obstacles.contains(&what) {
                        obstacles.push(what);
                    }
                    continue;
                }
            };
            let law = FileRough::new(&files, made);
            let error = self.study.error_of(&law, self.lobes);
            let chosen = Chosen {
                all_bounces: !one,
                is_single: false,
                lobes: self.lobes,
                table_bytes: None,
                export: Some(ExportRecord {
                    format: name.to_owned(),
                    incidences_deg: grid.incidences_deg,
                    tolerance_percent,
                }),
                bytes: Some(files.bytes),
                cost: Cost::default(),
                error,
                why: format!(
                    "{name}, {} incidences to {most} deg, within {tolerance_percent} % of the peak between angles: {} bytes; the coarsest \
                     that is near enough",
                    incidences(step, most).len(),
                    files.bytes
                ),
            };
            if self.meets(error) {
                return Ok(chosen);
            }
            if nearest.as_ref().is_none_or(|n| error.0.abs() < n.error.0.abs()) {
                nearest = Some(chosen);
            }
        }
        if let Some(nearest) = &nearest {
            obstacles.push(format!(
                "the finest grid of {name} that was tried (2.5 deg, 0.25 %) is no nearer than {:.2} %: its reader interpolates so",
                100.0 * nearest.error.0.abs()
            ));
        }
        Err(Box::new(Blocked { nearest, obstacles }))
    }

    fn as_snippet(&self) -> Result<Chosen, Box<Blocked>> {
        let is_ggx = self.study.law.figures.is_some_and(|f| f.statistics == Statistics::Ggx);
        // its material has all four, whatever the scene sees
        let error = self.study.error(Some(Reduced::One), LobeSet::ALL).unwrap_or_default();
        let chosen = Chosen {
            all_bounces: false,
            is_single: false,
            lobes: self.lobes,
            table_bytes: None,
            export: Some(ExportRecord {
                format: "mitsuba".into(),
                incidences_deg: vec![0.0],
                tolerance_percent: 0.5,
            }),
            bytes: None,
            cost: Cost::default(),
            error,
            why: format!(
                "Mitsuba's own GGX facets, which know one bounce and every incidence: what they lose moves the quantity by {:.3} %",
                100.0 * error.0
            ),
        };
        if is_ggx && self.meets(error) {
            return Ok(chosen);
        }
        let mut obstacles = Vec::new();
        if !is_ggx {
            obstacles.push("Mitsuba knows GGX in closed form and no tables of transmission; this surface is not GGX".into());
        }
        if !self.meets(error) {
            obstacles.push(format!(
                "its facets lose the light of later bounces, which is {:.2} % of the quantity",
                100.0 * error.0.abs()
            ));
        }
        Err(Box::new(Blocked { nearest: is_ggx.then_some(chosen), obstacles }))
    }
}

fn of_table_law(table: crate::embedded::EmbeddedTable) -> impl Rough {
    of_table(table)
}

/// Incidences from 0 in steps up to the largest that is needed.
pub(super) fn incidences(step: f64, most: f64) -> Vec<f64> {
    let count = (most / step).ceil().max(1.0) as usize;
    (0..=count).map(|k| (k as f64 * step).min(most.max(step).min(85.0))).collect()
}
