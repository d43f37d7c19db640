//! Rays into bins: one beam after the other, reflected and transmitted.
//!
//! A beam is traced twice. An eighth of the rays decides where the bins are, and the others are counted in them; the
//! two sets are independent. Rays come in the tiles of the Monte Carlo scan, so that the bits do not
//! depend on the number of threads, and errors come from the differences of neighbouring rays as there.

use asperity_core::bsdf::{Lobe, Scatter};
use asperity_core::direction::{Direction, Side};

use super::binning::{Azimuth, Binning, side_index};
use super::bins::{BinnedLobe, Estimate, Partition};
use super::{BinnedBsdf, SideTable};
use crate::forward::{Heeding, Rays, Tiles, mix};
use crate::parallel;
use crate::watch::Watch;

/// Tiles that are in memory at once.
const GROUP: u64 = 64;
/// Most rays of a pilot: beyond it bins would gain nothing.
const MOST_PILOT: u64 = 1 << 22;
/// What golden steps leave of the circle, so that any number of successive ones divides it evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Traces all that a binning asks for.
///
/// The same bits for any number of threads. `None` if it was stopped before the end. `watch` is told of
/// more rays; they are [`Binning::rays_in_all`].
pub fn gather<S: Scatter<f64> + Sync>(
    boundary: &S,
    binning: &Binning,
    watch: Watch<'_>,
) -> Option<BinnedBsdf> {
    watch.done(0, usize::try_from(binning.rays_in_all()).unwrap_or(usize::MAX));
    let heeding = Heeding { boundary, watch };
    let work = Work { boundary: &heeding, binning, watch };
    let azimuths: Vec<Option<f64>> = match &binning.azimuth {
        Azimuth::Isotropic => vec![None],
        Azimuth::Fixed(degrees) => degrees.iter().copied().map(Some).collect(),
    };
    let mut sides = [SideTable::default(), SideTable::default()];
    for side in [Side::Air, Side::Dielectric] {
        let table = &mut sides[side_index(side)];
        for &incidence_deg in binning.incidences_deg(side) {
            table.angles.push(incidence_deg.to_radians());
            for &azimuth_deg in &azimuths {
                table.beams.push(work.beam(Beam { side, incidence_deg, azimuth_deg })?);
            }
        }
    }
    Some(BinnedBsdf::new(binning, sides))
}

impl Binning {
    fn pilot(&self) -> Rays {
        // as many as give a bin of the smallest number of rays at least a few
        let least = (self.rays.count / 8).max(1024).min(self.rays.count);
        Rays { count: least.min(MOST_PILOT), seed: mix(self.rays.seed, 0x7069_6c6f) }
    }

    /// Rays to trace in all.
    pub fn rays_in_all(&self) -> u64 {
        let azimuths = match &self.azimuth {
            Azimuth::Isotropic => 1,
            Azimuth::Fixed(degrees) => degrees.len() as u64,
        };
        let incidences = self.incidences_deg.iter().map(Vec::len).sum::<usize>() as u64;
        let each = count(self.pilot().tiles(0.0)).saturating_add(count(self.rays.tiles(0.0)));
        each.saturating_mul(incidences * azimuths)
    }
}

/// Rays of all tiles.
fn count(tiles: Tiles) -> u64 {
    tiles.count() * u64::from(tiles.rays_each())
}

/// One incidence.
#[derive(Clone, Copy)]
struct Beam {
    side: Side,
    incidence_deg: f64,
    /// `None`: every ray at its own.
    azimuth_deg: Option<f64>,
}

impl Beam {
    fn tiles(self, rays: Rays) -> Tiles {
        let word = side_index(self.side) as u64 + 1;
        let seed = mix(mix(rays.seed, word), self.azimuth_deg.map_or(1, f64::to_bits));
        Rays { seed, ..rays }.tiles(self.incidence_deg)
    }

    /// Traces a ray: the lobe it ends in, the point of the disc, its weight.
    ///
    /// With all azimuths alike it is seen from an incidence at azimuth 0.
    #[inline]
    fn trace<S: Scatter<f64>>(
        self,
        boundary: &S,
        tiles: Tiles,
        tile: u64,
        k: u32,
    ) -> Option<Ended> {
        let mut uniforms = tiles.ray(tile, k);
        let turned = if let Some(degrees) = self.azimuth_deg {
            degrees.to_radians()
        } else {
            let number = tile * u64::from(tiles.rays_each()) + u64::from(k);
            std::f64::consts::TAU * (number as f64 * GOLDEN).fract()
        };
        let (sin, cos) = turned.sin_cos();
        let (s, c) = self.incidence_deg.to_radians().sin_cos();
        let z = if self.side == Side::Air { c } else { -c };
        let wi = Direction::from_unit(-s * cos, -s * sin, z);
        let ray = boundary.sample(wi, &mut || uniforms.next())?;
        let lobe = if ray.wo.side()? == self.side { Lobe::Reflection } else { Lobe::Transmission };
        let [x, y, _] = ray.wo.xyz();
        let point = if self.azimuth_deg.is_some() {
            [x, y]
        } else {
            [x * cos + y * sin, y * cos - x * sin]
        };
        Some(Ended { lobe, point, weight: ray.weight })
    }
}

struct Ended {
    lobe: Lobe,
    point: [f64; 2],
    weight: f64,
}

struct Work<'a, S> {
    boundary: &'a S,
    binning: &'a Binning,
    watch: Watch<'a>,
}

impl<S: Scatter<f64> + Sync> Work<'_, S> {
    /// The reflected and the transmitted lobe of a beam.
    fn beam(&self, beam: Beam) -> Option<[BinnedLobe; 2]> {
        let pilot = beam.tiles(self.binning.pilot());
        let mut points = [Vec::new(), Vec::new()];
        let all = |tile| -> Vec<_> {
            (0..pilot.rays_each())
                .filter_map(|k| beam.trace(self.boundary, pilot, tile, k))
                .map(|end| (end.lobe, end.point))
                .collect()
        };
        self.in_order(pilot, all, |tile| {
            for (lobe, point) in tile {
                points[lobe_index(lobe)].push(point);
            }
        })?;
        let rays = beam.tiles(self.binning.rays);
        let n = count(rays) as f64;
        let share = count(pilot) as f64 / n;
        let most = (2.0 * f64::from(self.binning.rays_per_bin) * share).ceil() as usize;
        let mirrored = beam.azimuth_deg.is_none();
        let partitions = points.map(|points| Partition::grow(&points, most, mirrored));

        let mut tallies = partitions.each_ref().map(|p| Tally::new(p.len()));
        let all = |tile| -> Vec<_> {
            let binned = |end: Ended| {
                let lobe = lobe_index(end.lobe);
                (lobe, partitions[lobe].index(end.point), end.weight)
            };
            (0..rays.rays_each())
                .map(|k| beam.trace(self.boundary, rays, tile, k).map(binned))
                .collect()
        };
        self.in_order(rays, all, |tile| {
            for pair in tile.chunks(2) {
                for (k, tally) in tallies.iter_mut().enumerate() {
                    let of_lobe = |end: &Option<(usize, usize, f64)>| {
                        end.filter(|(lobe, ..)| *lobe == k).map(|(_, bin, weight)| (bin, weight))
                    };
                    let mut ends = pair.iter().map(of_lobe);
                    tally.add(ends.next().flatten(), ends.next().flatten());
                }
            }
        })?;
        let [a, b] = partitions;
        let [ta, tb] = tallies;
        Some([ta.lobe(a, n), tb.lobe(b, n)])
    }

    /// Works on tiles in groups, and gives what came of them to `take` in their order.
    fn in_order<T: Send>(
        &self,
        tiles: Tiles,
        work: impl Fn(u64) -> T + Sync,
        mut take: impl FnMut(T),
    ) -> Option<()> {
        let mut from = 0;
        while from < tiles.count() {
            let to = (from + GROUP).min(tiles.count());
            let one = |tile| {
                let done = work(tile);
                self.watch.more(u64::from(tiles.rays_each()));
                done
            };
            let group = parallel::map((to - from) as usize, &|k| one(from + k as u64));
            group.into_iter().for_each(&mut take);
            if self.watch.is_stopped() {
                return None;
            }
            from = to;
        }
        Some(())
    }
}

fn lobe_index(lobe: Lobe) -> usize {
    usize::from(lobe == Lobe::Transmission)
}

/// Sums of a lobe.
struct Tally {
    flux: Vec<f64>,
    /// Squares of the differences of neighbouring rays.
    squares: Vec<f64>,
    total_squares: f64,
}

impl Tally {
    fn new(bins: usize) -> Self {
        Self { flux: vec![0.0; bins], squares: vec![0.0; bins], total_squares: 0.0 }
    }

    /// Counts two neighbouring rays: bin and weight, if they ended in this lobe.
    fn add(&mut self, one: Option<(usize, f64)>, other: Option<(usize, f64)>) {
        for (bin, weight) in [one, other].into_iter().flatten() {
            self.flux[bin] += weight;
        }
        match (one, other) {
            (Some((a, wa)), Some((b, wb))) if a == b => self.squares[a] += (wa - wb) * (wa - wb),
            _ => {
                for (bin, weight) in [one, other].into_iter().flatten() {
                    self.squares[bin] += weight * weight;
                }
            }
        }
        let difference = one.map_or(0.0, |e| e.1) - other.map_or(0.0, |e| e.1);
        self.total_squares += difference * difference;
    }

    /// The lobe that `n` rays of unit flux in all have made.
    fn lobe(self, partition: Partition, n: f64) -> BinnedLobe {
        // A bin that no ray has met may be as much in error as one that a single ray has met; nor is any other
        // known better than to one ray.
        let bin = |(flux, squares): (&f64, &f64)| Estimate {
            value: flux / n,
            std_error: squares.max(1.0).sqrt() / n,
        };
        let bins: Vec<Estimate> = self.flux.iter().zip(&self.squares).map(bin).collect();
        BinnedLobe::new(partition, &bins, self.total_squares.sqrt() / n)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

    use super::super::{Azimuth, BinnedBsdf, Binning};
    use super::gather;
    use crate::forward::Rays;
    use crate::raytrace::{Field, TracedBoundary};
    use crate::surface::{Edges, HeightMap};
    use crate::watch::{Progress, Watch};
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;
    use asperity_core::quantity::RelativeIor;

    #[test]
    fn the_bits_do_not_depend_on_the_number_of_threads() {
        let eta = RelativeIor::new(1.49).unwrap();
        let heights = (0..64 * 64).map(|k| 0.3 * f64::from(k * 7919 % 101) / 101.0).collect();
        let map = HeightMap::new((64, 64), (1.0, 1.0), heights).unwrap();
        let field = Arc::new(Field::new(&map, Edges::Periodic).unwrap());
        let again = field.map().unwrap();
        assert_eq!((again.nx(), again.ny()), (64, 64));
        let boundary = TracedBoundary { field, eta };
        for azimuth in [Azimuth::Isotropic, Azimuth::Fixed(vec![0.0, 40.0])] {
            let mut binning = Binning::new(eta, Rays { count: 20_000, seed: 6 });
            for side in [Side::Air, Side::Dielectric] {
                binning = binning.with_incidences(side, &[10.0, 50.0]).unwrap();
            }
            let binning = binning.with_azimuth(azimuth).unwrap();
            let done = AtomicU64::new(0);
            let count = |told: Progress<'_>| {
                if let Progress::More(rays) = told {
                    done.fetch_add(rays, Ordering::Relaxed);
                }
            };
            let never = AtomicBool::new(false);
            let watch = Watch::new(&never, &count);
            let table = |threads| -> BinnedBsdf {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| gather(&boundary, &binning, watch)).unwrap()
            };
            let (one, three) = (table(1), table(3));
            assert_eq!(done.load(Ordering::Relaxed), 2 * binning.rays_in_all());
            for side in [Side::Air, Side::Dielectric] {
                for (k, lobe) in [(0, Lobe::Reflection), (1, Lobe::Transmission)] {
                    assert!(one.bins(side, k, 0, lobe).count() > 10);
                    assert!(one.bins(side, k, 0, lobe).eq(three.bins(side, k, 0, lobe)));
                }
            }
            assert!(gather(&boundary, &binning, Watch::silent(&AtomicBool::new(true))).is_none());
        }
    }
}
