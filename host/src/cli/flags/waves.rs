//! The flags of the Kirchhoff validity of a map, and how the verdict is printed.

use std::fmt::Write as _;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;

use super::scan::number;
use crate::atlas;
use crate::cli::error::Failure;
use crate::cli::progress;
use crate::energy;
use crate::kirchhoff::validity::{COS_RQ_OVER_ACL, CURVATURE_WAVELENGTHS, LobeValidity};
use crate::kirchhoff::{Speckle, Validity, WaveBoundary, Wavelengths};
use crate::method::{Body, Waves};
use crate::reconstruct::Light;
use crate::rigorous::solver::{RigorousError, Side as SolverSide};
use crate::rigorous::{CutsRequest, MapCuts, NoCuts};
use crate::surface::{Edges, HeightMap};

/// Heading of these flags.
pub(in crate::cli) const HEADING: &str = "Waves on the map";

/// Light on a map; both the index and the wavelength, or neither.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = HEADING)]
pub(in crate::cli) struct KirchhoffFlags {
    /// Relative index of the material, for the validity of waves on the map
    #[arg(long, value_name = "N", allow_negative_numbers = true, requires = "wavelength_nm", value_parser = number)]
    ior: Option<f64>,
    /// Vacuum wavelengths of the light, alone or each with its weight: 550, or 450,550, or 450:0.3,550:1
    #[arg(long, value_name = "NM,...", requires = "ior", allow_negative_numbers = true)]
    wavelength_nm: Option<Wavelengths>,
    /// Angles of incidence in degrees, in the medium the light comes from [default: 0,30,60]
    #[arg(
        long,
        value_name = "DEG,...",
        value_delimiter = ',',
        requires = "ior",
        allow_negative_numbers = true
    )]
    incidence: Vec<f64>,
    /// Solve Maxwell's equations on N cuts of the map, and print what waves, rays and single facets are off by there
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "12", requires = "ior", value_parser = clap::value_parser!(u16).range(2..=1000))]
    rigorous: Option<u16>,
    /// Length of these cuts in um [default: 60 wavelengths]
    #[arg(long, value_name = "UM", requires = "rigorous", value_parser = number)]
    period_um: Option<f64>,
}

/// What is asked about waves on a map.
pub(in crate::cli) struct Question {
    eta: RelativeIor<f64>,
    wavelengths: Wavelengths,
    incidences_deg: Vec<f64>,
}

impl KirchhoffFlags {
    /// What the flags ask; `None` without them.
    ///
    /// # Errors
    /// Values that are none of an index or of an incidence.
    pub(in crate::cli) fn question(&self) -> Result<Option<Question>, Failure> {
        let (Some(ior), Some(wavelengths)) = (self.ior, &self.wavelength_nm) else {
            return Ok(None);
        };
        let eta = Body::Dielectric { ior }.eta().map_err(Failure::bad)?;
        if let Some(bad) = self.incidence.iter().find(|deg| !(0.0..90.0).contains(*deg)) {
            return Err(Failure::bad(format!(
                "--incidence {bad} is not usable; give 0 to below 90 degrees"
            )));
        }
        let incidences_deg = self.incidences_deg();
        Ok(Some(Question { eta, wavelengths: wavelengths.clone(), incidences_deg }))
    }

    /// The incidences, the usual ones where none are given.
    fn incidences_deg(&self) -> Vec<f64> {
        match self.incidence.as_slice() {
            [] => Validity::INCIDENCES_DEG.to_vec(),
            given => given.to_vec(),
        }
    }

    /// What is asked of cuts of the map; `None` without the flag.
    ///
    /// # Errors
    /// Several wavelengths.
    pub(in crate::cli) fn cuts(&self) -> Result<Option<CutsRequest>, Failure> {
        let (Some(solved), Some(ior)) = (self.rigorous, self.ior) else { return Ok(None) };
        let nm = self.wavelength_nm.as_ref().and_then(Wavelengths::only_nm);
        let nm = nm.ok_or_else(|| {
            Failure::bad("--rigorous solves for one wavelength; give one, --wavelength-nm NM")
        })?;
        Ok(Some(CutsRequest {
            ior,
            wavelength_um: 1e-3 * nm,
            incidences: CutsRequest::each_side(
                &[SolverSide::Air, SolverSide::Dielectric],
                &self.incidences_deg(),
            ),
            solved: usize::from(solved),
            period_um: self.period_um,
        }))
    }
}

/// Solves on cuts of a map, with its progress.
pub(in crate::cli) fn solved_cuts(
    request: &CutsRequest,
    map: &HeightMap,
) -> Result<MapCuts, Failure> {
    let bar = progress::bar(1000, "solving Maxwell's equations on cuts");
    bar.watch(|watch| request.run(map, watch)).map_err(|e| match e {
        NoCuts::Unsolved(RigorousError::Stopped) => {
            Failure::No("interrupted before the end of the solution".into())
        }
        NoCuts::Unsolved(
            e @ (RigorousError::Unsettled { .. } | RigorousError::TooManyNodes { .. }),
        ) => Failure::No(e.to_string()),
        e => Failure::bad(e),
    })
}

impl Question {
    /// The answer for a map; with the balance that `check` would find, unless the map is too large for waves.
    pub(in crate::cli) fn of(&self, map: &HeightMap, edges: Edges) -> Result<Validity, Failure> {
        let light = Light::of(self.wavelengths.clone());
        let Ok(options) = light.variant(Waves::AnySpeckle, (map, edges), &[Speckle::Averaged])
        else {
            let found = Validity::of(map, edges, self.eta, &self.wavelengths, &self.incidences_deg);
            return found.map_err(Failure::bad);
        };
        let wave = WaveBoundary::of_map(map, edges, self.eta, &options).map_err(Failure::bad)?;
        let bar = progress::bar(0, "balancing");
        let found = bar.watch(|watch| energy::verdict(&wave, &self.incidences_deg, watch));
        found.map_err(Failure::bad)?.ok_or_else(|| Failure::No("interrupted before the end".into()))
    }
}

/// A line for each lobe.
pub(in crate::cli) fn table(validity: &Validity) -> String {
    let mut text = "from        lobe          nm        deg     facets %  curved %  phase %   \
                        length      reading   diffuse\n"
        .to_owned();
    for l in &validity.lobes {
        let side = if l.side == Side::Air { "air" } else { "inside" };
        let lobe = if l.lobe == Lobe::Reflection { "reflection" } else { "transmission" };
        let verdict = |passes| if passes { "passes" } else { "fails" };
        // writing to a String cannot fail
        let _ = writeln!(
            text,
            "{side:<11} {lobe:<13} {:<9} {:<7} {:<9.2} {:<9.2} {:<9.2} {:<11} {:<9} {}",
            l.wavelength_nm,
            l.incidence_deg,
            100.0 * l.violating.any,
            100.0 * l.curved_fraction,
            100.0 * l.undersampled_fraction,
            length(l),
            verdict(l.passes),
            verdict(l.diffuse_passes)
        );
    }
    text
}

/// The figures, a line for each lobe, and all warnings.
pub(in crate::cli) fn human(v: &Validity) -> String {
    let or_none =
        |x: Option<f64>, digits: usize| x.map_or("-".to_owned(), |x| format!("{x:.digits$}"));
    let mut text = format!(
        "\nKirchhoff   n {}, {} nm\n\
             Rq / l      {} (eq. 10)\n\
             most angle  {} deg (eq. 11: cos theta > {COS_RQ_OVER_ACL} Rq / l)\n\
             corr. areas {}\n\
             structures  {} um, sqrt(2) Rq over the steepest slope {:.4}\n",
        v.ior,
        v.wavelengths,
        or_none(v.rq_over_acl, 4),
        or_none(v.most_angle_deg, 1),
        or_none(v.correlation_areas, 0),
        or_none(v.correlation_um, 3),
        v.steepest_slope
    );
    text += &table(v);
    let _ = writeln!(
        text,
        "reading: with the specular light, to 1 % of its peak; diffuse: the diffuse light alone. facets: share that turns light \
             too far or shadows it. curved: 2 pi R cos^3 <= {CURVATURE_WAVELENGTHS} lambda (eq. 9). length: of structures, in \
             wavelengths, / what diffuse light alone needs"
    );
    for warning in v.warnings() {
        let _ = writeln!(text, "warning: {warning}");
    }
    text
}

/// What the atlas says of each lobe.
pub(in crate::cli) fn atlas(v: &Validity) -> String {
    let rows = atlas::of_validity(v);
    let head =
        format!("\natlas       true errors, % of the peak of the reading ({})", atlas::CAVEAT);
    if let Some(why) = rows.iter().find_map(|r| r.outside.as_ref())
        && rows.iter().all(|r| r.quotes.is_none())
    {
        return format!("{head}: none, {why}\n");
    }
    let mut text = format!(
        "{head}, nine of ten within\nfrom        lobe          nm        deg     {:23}{:23}{:23}waves, diffuse\n",
        "waves", "rays", "facets"
    );
    for r in &rows {
        let side = if r.side == "air" { r.side } else { "inside" };
        let figures = match (&r.quotes, &r.outside) {
            (Some(q), _) => {
                let cells = [q.kirchhoff, q.rays, q.facet].map(|q| format!("{:<23}", q.text()));
                format!("{}{}", cells.concat(), q.kirchhoff_diffuse.text())
            }
            (None, why) => why.clone().unwrap_or_default(),
        };
        // writing to a String cannot fail
        let _ = writeln!(
            text,
            "{side:<11} {:<13} {:<9} {:<7} {figures}",
            r.lobe, r.wavelength_nm, r.incidence_deg
        );
    }
    text += "waves: Kirchhoff without shadowing; facets: one bounce, no shadows; diffuse: of the peak of the diffuse light\n";
    text
}

/// Length of the structures beside what the diffuse light needs.
fn length(l: &LobeValidity) -> String {
    let found = l.correlation_wavelengths.map_or("-".to_owned(), |found| format!("{found:.1}"));
    format!("{found}/{:.1}", l.least_correlation_wavelengths)
}
