//! The lobe of a block.

use std::f64::consts::{FRAC_PI_2, PI};

use super::block::{Block, Kind};
use crate::error::Fault;
use crate::formats::own;
use crate::frame::{Frame, around};
use crate::interpolation::Interpolation;
use crate::sampled::{Band, Grid, Incidence, Lobe, Nodes, SampledBsdf, Side, Symmetry};

pub(super) fn of(format: &'static str, block: &Block) -> Result<SampledBsdf, Fault> {
    let said = own::said(block.comments.iter().map(String::as_str));
    let notes = block.comments.iter().filter(|c| !own::is_own(c) && !c.starts_with("PARAM"));
    let mut bands = block.bands.clone();
    if let ([Band::Unknown], Some(nm)) = (bands.as_slice(), said.wavelength_nm) {
        bands = vec![Band::Wavelength(nm)];
    }
    let incidences = match (block.kind.is_specular(), block.coordinates.as_str()) {
        (true, _) => coherent(block),
        (false, "specular") => about_ray(block),
        (false, "spherical") => absolute(block),
        (false, other) => {
            let what = format!("PARAM_TYPE {}", crate::text::excerpt(other));
            let what = format!("{what} (the block before line {})", block.line);
            let remedy = "convert it to the specular or the spherical coordinate system";
            return Err(Fault::Unsupported { format, what, remedy });
        }
    };
    Ok(SampledBsdf {
        side: said.side.unwrap_or(Side::Air),
        lobe: match block.kind {
            Kind::Brdf | Kind::SpecularReflectance => Lobe::Reflection,
            Kind::Btdf | Kind::SpecularTransmittance => Lobe::Transmission,
        },
        index: said.index,
        symmetry: match (block.lists[1].len(), block.is_bilateral) {
            (1, true) => Symmetry::Isotropic,
            (1, false) => said.symmetry.unwrap_or(Symmetry::Rotational),
            _ => Symmetry::None,
        },
        bands,
        interpolation: Interpolation::Linear,
        incidences,
        has_level: true,
        notes: notes.cloned().collect(),
    })
}

/// An incidence for each pair of `PARAM1_LIST` and `PARAM0_LIST`.
fn pairs(block: &Block, f: impl Fn(usize, usize) -> Incidence) -> Vec<Incidence> {
    let [thetas, phis, ..] = &block.lists;
    (0..phis.len())
        .flat_map(|p| (0..thetas.len()).map(move |t| (p, t)))
        .map(|(p, t)| f(p, t))
        .collect()
}

fn coherent(block: &Block) -> Vec<Incidence> {
    let [thetas, phis, ..] = &block.lists;
    let bands = block.bands.len();
    pairs(block, |p, t| {
        let start = (p * thetas.len() + t) * bands;
        Incidence {
            theta: thetas[t],
            phi: around(phis[p]),
            nodes: Nodes::Points(Vec::new()),
            values: Vec::new(),
            stated: block.values[start..start + bands].to_vec(),
        }
    })
}

fn about_ray(block: &Block) -> Vec<Incidence> {
    let [thetas, phis, radii, azimuths, offsets] = &block.lists;
    let order: Vec<usize> = (0..azimuths.len()).collect();
    pairs(block, |p, t| {
        let ray = thetas[t] + offsets.get(t).copied().unwrap_or(0.0);
        let nodes = Nodes::Grid(Grid {
            frame: Frame::Specular { theta: ray },
            radii: reach(radii, PI),
            azimuths: azimuths.clone(),
            mirrored: block.is_bilateral,
        });
        let values = values(block, [t, p], &order);
        Incidence { theta: thetas[t], phi: around(phis[p]), nodes, values, stated: Vec::new() }
    })
}

/// Azimuths from the source become such from the specular ray.
fn absolute(block: &Block) -> Vec<Incidence> {
    let [thetas, phis, radii, azimuths, _] = &block.lists;
    pairs(block, |p, t| {
        let relative = |a: f64| {
            // those of the half that is kept are about the plane of incidence
            if block.is_bilateral { PI - a } else { around(a - phis[p] - PI) }
        };
        let mut places: Vec<(f64, usize)> =
            azimuths.iter().enumerate().map(|(k, a)| (relative(*a), k)).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        // 0 and 360 are the same
        places.dedup_by(|a, b| (a.0 - b.0).abs() < 1e-9);
        let order: Vec<usize> = places.iter().map(|(_, k)| *k).collect();
        let nodes = Nodes::Grid(Grid {
            frame: Frame::Absolute,
            radii: reach(radii, FRAC_PI_2),
            azimuths: places.iter().map(|(a, _)| *a).collect(),
            mirrored: block.is_bilateral,
        });
        let values = values(block, [t, p], &order);
        Incidence { theta: thetas[t], phi: around(phis[p]), nodes, values, stated: Vec::new() }
    })
}

/// A single radius stands for all up to the end.
fn reach(radii: &[f64], end: f64) -> Vec<f64> {
    match radii {
        [one] => vec![*one, end.max(*one + 1e-9)],
        _ => radii.to_vec(),
    }
}

/// Values of an incidence, band after band, the radius fastest, of the azimuths in `order`.
fn values(block: &Block, [t, p]: [usize; 2], order: &[usize]) -> Vec<f64> {
    let [n0, n1, n2, ..] = block.lists.each_ref().map(Vec::len);
    let bands = block.bands.len();
    let at = |i2: usize, i3: usize, band: usize| {
        block.values[(t + n0 * (p + n1 * (i2 + n2 * i3))) * bands + band]
    };
    // as `reach` has it
    let radii: &[usize] = &if n2 == 1 { vec![0; 2] } else { (0..n2).collect() };
    let mut all = Vec::with_capacity(bands * radii.len() * order.len());
    for band in 0..bands {
        for i3 in order {
            all.extend(radii.iter().map(|i2| at(*i2, *i3, band)));
        }
    }
    all
}
