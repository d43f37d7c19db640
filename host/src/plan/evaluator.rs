//! Ways to evaluate a law, made as the verbs make them.

use asperity_core::bsdf::{Lobe, LobeSet, Scattered};
use asperity_core::direction::{Direction, Side};
use asperity_exchange::convention::Global;
use asperity_exchange::formats::Writer;
use asperity_exchange::law::{Law as _, Options};
use asperity_exchange::resample::FileLaw;
use asperity_exchange::{Format, SampledBsdf};

use super::rough::Rough;
use crate::boundary::Boundary;
use crate::embedded::EmbeddedTable;
use crate::export::BoundaryLaw;
use crate::forward::Rays;
use crate::tabulate::{Budget, tabulate};
use crate::watch::Watch;

/// The rays of closed forms and waves: none.
const NO_RAYS: Rays = Rays { count: 0, seed: 1 };

/// The table of some lobes within so many bytes, as `tabulate --bytes` makes it.
pub(super) fn table(
    boundary: &Boundary,
    lobes: LobeSet,
    bytes: usize,
) -> Result<EmbeddedTable, String> {
    let budget = Budget { lobes, bytes, kept: None, rays: NO_RAYS };
    tabulate(boundary, &budget, Watch::nobody()).map_err(|e| e.to_string())
}

/// The table of a law as a law.
pub(super) fn of_table(table: EmbeddedTable) -> Boundary {
    Boundary::Table(Box::new(table))
}

/// The grid of an export.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Grid {
    /// Incidences, degrees.
    pub(super) incidences_deg: Vec<f64>,
    /// Error between angles, % of the peak.
    pub(super) tolerance_percent: f64,
}

/// Files of lobes, and their size.
#[derive(Clone, Debug)]
pub(super) struct Files {
    lobes: Vec<(LobeSet, SampledBsdf)>,
    /// Bytes of all files.
    pub(super) bytes: usize,
}

fn exchanged((side, lobe): (Side, Lobe)) -> (asperity_exchange::Side, asperity_exchange::Lobe) {
    let side = match side {
        Side::Air => asperity_exchange::Side::Air,
        Side::Dielectric => asperity_exchange::Side::Dielectric,
    };
    let lobe = match lobe {
        Lobe::Reflection => asperity_exchange::Lobe::Reflection,
        Lobe::Transmission => asperity_exchange::Lobe::Transmission,
    };
    (side, lobe)
}

/// What writes a format.
pub(super) fn writer(format: &str) -> Option<Writer> {
    Format::of_name(format)?.write
}

/// The files of some lobes, as `export` writes them.
pub(super) fn files(
    boundary: &Boundary,
    lobes: LobeSet,
    (writer, grid): (&Writer, &Grid),
    wavelength_nm: f64,
) -> Result<Files, String> {
    let mut made = Files { lobes: Vec::new(), bytes: 0 };
    let incidences: Vec<[f64; 2]> =
        grid.incidences_deg.iter().map(|deg| [deg.to_radians(), 0.0]).collect();
    for which in lobes.iter() {
        let (side, lobe) = exchanged(which);
        let law = BoundaryLaw::of(boundary, (side, lobe), &incidences, NO_RAYS, Watch::nobody())
            .map_err(|e| e.to_string())?;
        let options = Options {
            incidences: incidences.clone(),
            tolerance: grid.tolerance_percent / 100.0,
            accept: true,
            ..Options::default()
        };
        let subject = law.subject(Some(wavelength_nm), Vec::new());
        let sampled = (writer.sample)(&law, &subject, &options).map_err(|e| e.to_string())?;
        let encoded = (writer.encode)(std::slice::from_ref(&sampled)).map_err(|e| e.to_string())?;
        made.bytes += encoded.len();
        made.lobes.push((LobeSet::of(which.0, which.1), sampled));
    }
    Ok(made)
}

/// Files as their program reads them, drawn from as the law they were made of.
pub(super) struct FileRough<'a> {
    laws: Vec<(LobeSet, FileLaw<'a>)>,
    drawn: &'a Boundary,
}

impl<'a> FileRough<'a> {
    /// The law of files; rays are drawn as from `drawn`, with the weights of the files.
    pub(super) fn new(files: &'a Files, drawn: &'a Boundary) -> Self {
        let laws = files.lobes.iter().map(|(lobe, sampled)| (*lobe, FileLaw::new(sampled)));
        Self { laws: laws.collect(), drawn }
    }
}

fn global(w: Direction<f64>) -> Global {
    let [x, y, z] = w.xyz();
    Global { theta: z.clamp(-1.0, 1.0).acos(), phi: y.atan2(x) }
}

impl Rough for FileRough<'_> {
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        let met = super::rough::lobe_of(wi, wo);
        let Some((_, law)) = self.laws.iter().find(|(lobe, _)| *lobe == met) else { return 0.0 };
        let (from, to) = (global(wi), global(wo));
        let out = [to.side().1, to.relative(from.phi)];
        law.value([from.side().1, 0.0], out) * wo.z().abs()
    }

    fn draw(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        let ray = self.drawn.draw(wi, lobe, u)?;
        let own = self.drawn.ars(wi, ray.wo);
        let weight = if own > 0.0 { ray.weight * self.ars(wi, ray.wo) / own } else { ray.weight };
        (weight > 0.0 && weight.is_finite()).then_some(Scattered { wo: ray.wo, weight })
    }
}
