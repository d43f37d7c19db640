//! The matrix as XML.

use std::fmt::Write as _;

use super::basis::{BASES, Known, Piece, pieces};
use super::places;
use crate::error::CannotHold;
use crate::formats::window;
use crate::sampled::{Incidence, SampledBsdf};

pub(super) fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = || CannotHold {
        format: "WINDOW XML",
        what: "directions that are not the patches of a Klems basis".into(),
        remedy: "sample it anew".into(),
    };
    let first = lobes.first().ok_or_else(refuse)?;
    let known = BASES.into_iter().find(|k| k.count() == first.incidences.len());
    let known = known.ok_or_else(refuse)?;
    let pieces = pieces(&known.rings());
    let data: Option<Vec<String>> = lobes.iter().map(|lobe| matrix(lobe, &pieces)).collect();
    let data = data.ok_or_else(refuse)?;
    let basis = format!(
        "\t\t\t<ColumnAngleBasis>{0}</ColumnAngleBasis>\n\t\t\t<RowAngleBasis>{0}</RowAngleBasis>\n",
        known.name
    );
    Ok(window::text(lobes, &definition(known), &basis, &data))
}

/// The numbers of a lobe: a line for each outgoing patch.
fn matrix(lobe: &SampledBsdf, pieces: &[Piece]) -> Option<String> {
    let places = places(lobe, pieces)?;
    let is_whole = |i: &Incidence| i.values.len() == pieces.len();
    if lobe.bands.len() != 1 || !lobe.incidences.iter().all(is_whole) {
        return None;
    }
    let mut of_patch = vec![0; pieces.len()];
    places.iter().enumerate().for_each(|(k, i)| of_patch[*i] = k);
    let mut out = String::new();
    for o in 0..pieces.len() {
        for k in &of_patch {
            let _ = write!(out, "{:.7e}, ", lobe.incidences[*k].values[o]);
        }
        out.push('\n');
    }
    Some(out)
}

/// The definition of a basis.
fn definition(known: &Known) -> String {
    let mut out = format!(
        "\t\t<IncidentDataStructure>Columns</IncidentDataStructure>\n\t\t<AngleBasis>\n\
         \t\t\t<AngleBasisName>{}</AngleBasisName>\n",
        known.name
    );
    let mut lower = 0.0;
    for &(upper, count) in known.rings {
        let theta = if lower == 0.0 { 0.0 } else { f64::midpoint(lower, upper) };
        let _ = write!(
            out,
            "\t\t\t<AngleBasisBlock>\n\t\t\t\t<Theta>{theta}</Theta>\n\t\t\t\t<nPhis>{count}</nPhis>\n\
             \t\t\t\t<ThetaBounds>\n\t\t\t\t\t<LowerTheta>{lower}</LowerTheta>\n\
             \t\t\t\t\t<UpperTheta>{upper}</UpperTheta>\n\t\t\t\t</ThetaBounds>\n\t\t\t</AngleBasisBlock>\n"
        );
        lower = upper;
    }
    out.push_str("\t\t</AngleBasis>\n");
    out
}
