//! Orders into bins: the table of the very map that scatters waves.
//!
//! Orders are delta functions, so a bin holds the flux of those within it, and `f` is the mean over the bin. Where bins
//! are is decided by points drawn evenly from the orders by their flux: bright places get small bins. The error
//! of a bin is that of its speckle, the root of the sum of the squares of its orders.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::{Direction, Side};
use rayon::prelude::*;

use super::binning::{Azimuth, Binning, side_index};
use super::bins::{BinnedLobe, Estimate, Partition};
use super::{BinnedBsdf, SideTable};
use crate::kirchhoff::{Beam, BeamOrders, WaveBoundary, orders};
use crate::watch::Watch;

/// Points that decide where the bins are, and most of them in one.
const POINTS: usize = 1 << 17;
const MOST_POINTS: usize = 48;

/// Sums all orders that a binning asks for, at its azimuths or, if it has none, at azimuth 0.
///
/// The same bits for any number of threads. `None` if it was stopped before the end. `watch` is told the
/// transforms done, anew for each incidence.
pub fn gather_orders(
    boundary: &WaveBoundary,
    binning: &Binning,
    watch: Watch<'_>,
) -> Option<BinnedBsdf> {
    let azimuths = match &binning.azimuth {
        Azimuth::Isotropic => vec![0.0],
        Azimuth::Fixed(degrees) => degrees.clone(),
    };
    let mut sides = [SideTable::default(), SideTable::default()];
    for side in [Side::Air, Side::Dielectric] {
        let table = &mut sides[side_index(side)];
        for &incidence_deg in binning.incidences_deg(side) {
            table.angles.push(incidence_deg.to_radians());
            for &azimuth_deg in &azimuths {
                let wi = from(side, incidence_deg, azimuth_deg);
                table.beams.push(lobes(boundary, wi, watch)?);
            }
        }
    }
    let binning = Binning { azimuth: Azimuth::Fixed(azimuths), ..binning.clone() };
    Some(BinnedBsdf::new(&binning, sides))
}

/// Where light comes from.
fn from(side: Side, incidence_deg: f64, azimuth_deg: f64) -> Direction<f64> {
    let (s, c) = incidence_deg.to_radians().sin_cos();
    let (sin, cos) = azimuth_deg.to_radians().sin_cos();
    Direction::from_unit(-s * cos, -s * sin, if side == Side::Air { c } else { -c })
}

/// The reflected and the transmitted lobe.
fn lobes(boundary: &WaveBoundary, wi: Direction<f64>, watch: Watch<'_>) -> Option<[BinnedLobe; 2]> {
    let weights: Vec<(f64, f64)> = boundary.wavelengths().iter().collect();
    let beam = |lobe, um| Beam { wi, lobe, wavelength_um: um };
    let of_lobe = |lobe| weights.iter().map(move |(um, _)| beam(lobe, *um));
    let beams: Vec<Beam> = of_lobe(Lobe::Reflection).chain(of_lobe(Lobe::Transmission)).collect();
    // the map of a boundary is complete
    let found = orders(boundary.map(), boundary.tiling(), boundary.eta(), &beams, watch).ok()??;
    let shares: Vec<f64> = weights.iter().map(|w| w.1).collect();
    let (reflected, transmitted) = found.split_at(shares.len());
    let both: Vec<BinnedLobe> =
        [reflected, transmitted].par_iter().map(|of| binned(boundary, of, &shares)).collect();
    both.try_into().ok()
}

fn binned(boundary: &WaveBoundary, of: &[BeamOrders], shares: &[f64]) -> BinnedLobe {
    let mut flux: Vec<([f64; 2], f64)> = Vec::new();
    for (beam, share) in of.iter().zip(shares) {
        flux.extend(beam.iter().map(|order| {
            let [x, y, _] = order.wo.xyz();
            ([x, y], share * boundary.shadowed(beam.beam(), &order))
        }));
    }
    let total: f64 = flux.iter().map(|f| f.1).sum();
    let mut points = Vec::with_capacity(POINTS + 1);
    let mut before = 0.0;
    for (point, power) in &flux {
        let place = |sum: f64| if total > 0.0 { (sum / total * POINTS as f64) as usize } else { 0 };
        let count = place(before + power).saturating_sub(place(before));
        points.extend(std::iter::repeat_n(*point, count));
        before += power;
    }
    let partition = Partition::grow(&points, MOST_POINTS, false);
    let mut sums = vec![[0.0; 2]; partition.len()];
    for (point, power) in &flux {
        let sum = &mut sums[partition.index(*point)];
        sum[0] += power;
        sum[1] += power * power;
    }
    let bins: Vec<Estimate> =
        sums.iter().map(|s| Estimate { value: s[0], std_error: s[1].sqrt() }).collect();
    let all: f64 = sums.iter().map(|s| s[1]).sum();
    BinnedLobe::new(partition, &bins, all.sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::{Azimuth, Binning};
    use super::{from, gather_orders};
    use crate::forward::Rays;
    use crate::kirchhoff::{
        Beam, Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths, orders,
    };
    use crate::surface::{Edges, GaussianSurface};
    use crate::watch::Watch;
    use asperity_core::bsdf::{Bsdf, Lobe, Scatter};
    use asperity_core::direction::Side;
    use asperity_core::quantity::RelativeIor;

    #[test]
    fn a_table_holds_the_flux_of_the_orders() {
        let eta = RelativeIor::new(1.49).unwrap();
        let surface = GaussianSurface {
            size: (96, 96),
            pitches_um: (0.4, 0.4),
            rq_um: 0.3,
            lengths_um: (4.0, 4.0),
            seed: 3,
        };
        let options = WaveOptions {
            wavelengths: Wavelengths::single(550.0).unwrap(),
            speckle: Speckle::Kept,
            shadowing: Shadowing::Off,
        };
        let map = surface.map().unwrap();
        let wave = WaveBoundary::of_map(&map, Edges::Periodic, eta, &options).unwrap();
        let binning = Binning::new(eta, Rays { count: 1, seed: 1 })
            .with_incidences(Side::Air, &[30.0])
            .unwrap()
            .with_incidences(Side::Dielectric, &[])
            .unwrap()
            .with_azimuth(Azimuth::Fixed(vec![20.0]))
            .unwrap();
        let table = gather_orders(&wave, &binning, Watch::nobody()).unwrap();
        let wi = from(Side::Air, 30.0, 20.0);
        let beam = |lobe| Beam { wi, lobe, wavelength_um: 0.55 };
        let beams = [beam(Lobe::Reflection), beam(Lobe::Transmission)];
        let exact = orders(&map, Edges::Periodic, eta, &beams, Watch::nobody()).unwrap().unwrap();
        let totals = table.totals(wi);
        assert!((totals.reflected.value - exact[0].totals().0).abs() < 1e-9);
        assert!((totals.transmitted.value - exact[1].totals().0).abs() < 1e-9);
        // f over the bins about an order is its neighbourhood's flux
        let brightest = exact[1].iter().max_by(|a, b| a.power.total_cmp(&b.power)).unwrap();
        assert!(table.eval(wi, brightest.wo) > 1.0);
        let ray = table.sample(wi, &mut || 0.5).unwrap();
        assert!(table.pdf(wi, ray.wo) > 0.0);
    }
}
