//! An adaptive histogram of directions: a lobe 0.02 deg wide and one of a hemisphere in the same bins.
//!
//! The disc of direction cosines is the unit square (an area of it times pi is a projected solid angle), and
//! the square is halved along its longer side wherever many rays fall. Where to halve is decided by a
//! pilot of other rays than those counted: bins that follow the very rays they count would shrink
//! around chance accumulations and be biased upwards. Within a bin `f` is constant.

use super::disc::{to_disc, to_square};

/// A bin of this side of the square is not halved: 0.012 deg at normal incidence, and by 1/cos more beyond.
const SMALLEST: f32 = 1.0 / 8192.0;
/// Marks a leaf among the nodes; the rest of the word is its number.
const LEAF: u32 = 1 << 31;

/// A rectangle of the square: its lower corner and its sides. Halves of halves of 1, so exact.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rectangle {
    corner: [f32; 2],
    sides: [f32; 2],
}

impl Rectangle {
    /// All of the square, or the half that is y >= 0.
    fn whole(mirrored: bool) -> Self {
        let b = if mirrored { 0.5 } else { 0.0 };
        Self { corner: [0.0, b], sides: [1.0, 1.0 - b] }
    }

    /// The axis along which it is halved, and where.
    fn middle(&self) -> (usize, f32) {
        let axis = usize::from(self.sides[1] > self.sides[0]);
        (axis, self.corner[axis] + 0.5 * self.sides[axis])
    }

    fn half(mut self, upper: bool) -> Self {
        let (axis, middle) = self.middle();
        self.sides[axis] *= 0.5;
        if upper {
            self.corner[axis] = middle;
        }
        self
    }

    fn area(&self) -> f64 {
        f64::from(self.sides[0]) * f64::from(self.sides[1])
    }
}

/// A tree of halved rectangles.
#[derive(Clone, Debug)]
pub(super) struct Partition {
    /// The number of the lower half (the upper follows it), or of a leaf.
    nodes: Vec<u32>,
    leaves: Vec<Rectangle>,
    /// The half y < 0 of the disc is the mirror image of the other, and both are one.
    mirrored: bool,
}

impl Partition {
    /// Halves where more than `most` of the points fall, points of the disc.
    pub(super) fn grow(points: &[[f64; 2]], most: usize, mirrored: bool) -> Self {
        let mut partition = Self { nodes: vec![0], leaves: Vec::new(), mirrored };
        let mut points: Vec<[f32; 2]> =
            points.iter().map(|&p| partition.square(p).map(|c| c as f32)).collect();
        partition.split(0, &mut points, Rectangle::whole(mirrored), most);
        partition
    }

    fn split(&mut self, node: usize, points: &mut [[f32; 2]], of: Rectangle, most: usize) {
        let (axis, middle) = of.middle();
        if points.len() <= most || of.sides[axis] <= SMALLEST {
            self.nodes[node] = LEAF | self.leaves.len() as u32;
            self.leaves.push(of);
            return;
        }
        points.sort_unstable_by(|a, b| a[axis].total_cmp(&b[axis]));
        let (lower, upper) = points.split_at_mut(points.partition_point(|p| p[axis] < middle));
        let first = self.nodes.len();
        self.nodes[node] = first as u32;
        self.nodes.extend([0, 0]);
        self.split(first, lower, of.half(false), most);
        self.split(first + 1, upper, of.half(true), most);
    }

    /// The point of the square that stands for a point of the disc.
    fn square(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        to_square([x, if self.mirrored { y.abs() } else { y }])
    }

    /// The bin of a point of the disc.
    pub(super) fn index(&self, point: [f64; 2]) -> usize {
        let place = self.square(point);
        let (mut node, mut within) = (0, Rectangle::whole(self.mirrored));
        while self.nodes[node] & LEAF == 0 {
            let (axis, middle) = within.middle();
            let upper = place[axis] >= f64::from(middle);
            node = self.nodes[node] as usize + usize::from(upper);
            within = within.half(upper);
        }
        (self.nodes[node] & !LEAF) as usize
    }

    /// Number of bins.
    pub(super) fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Projected solid angle of a bin, sr; of both halves if they are mirrored.
    fn projected(&self, bin: usize) -> f64 {
        let halves = if self.mirrored { 2.0 } else { 1.0 };
        std::f64::consts::PI * halves * self.leaves[bin].area()
    }
}

/// A number with its statistical error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
}

/// One bin of a lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Lower corner and sides in the unit square, see [`to_disc`].
    pub corner: [f64; 2],
    /// Sides in the unit square.
    pub sides: [f64; 2],
    /// The bin and its mirror image at y < 0 are one.
    pub mirrored: bool,
    /// Flux of a beam of unit flux that falls into it.
    pub flux: Estimate,
    /// Projected solid angle, sr: `f` is flux over it.
    pub projected_sr: f64,
}

/// The light of one beam that leaves to one side.
#[derive(Clone, Debug)]
pub(super) struct BinnedLobe {
    partition: Partition,
    /// Flux of all bins before each one, and of all.
    cumulated: Vec<f64>,
    /// Standard errors of the flux of the bins.
    std_errors: Vec<f32>,
    total: Estimate,
}

impl BinnedLobe {
    /// From the flux of each bin and the error of the whole.
    pub(super) fn new(partition: Partition, flux: &[Estimate], total_error: f64) -> Self {
        let mut cumulated = Vec::with_capacity(flux.len() + 1);
        let mut sum = 0.0;
        cumulated.push(sum);
        for bin in flux {
            sum += bin.value;
            cumulated.push(sum);
        }
        Self {
            partition,
            cumulated,
            std_errors: flux.iter().map(|bin| bin.std_error as f32).collect(),
            total: Estimate { value: sum, std_error: total_error },
        }
    }

    /// The flux of the lobe.
    pub(super) fn total(&self) -> Estimate {
        self.total
    }

    fn flux(&self, bin: usize) -> f64 {
        self.cumulated[bin + 1] - self.cumulated[bin]
    }

    /// `f` in 1/sr at a point of the disc.
    pub(super) fn value(&self, point: [f64; 2]) -> f64 {
        let bin = self.partition.index(point);
        self.flux(bin) / self.partition.projected(bin)
    }

    /// Standard error of [`Self::value`].
    pub(super) fn std_error(&self, point: [f64; 2]) -> f64 {
        let bin = self.partition.index(point);
        f64::from(self.std_errors[bin]) / self.partition.projected(bin)
    }

    /// A point of the disc drawn from two uniforms in [0, 1); `None` for an empty lobe.
    pub(super) fn draw(&self, [u, v]: [f64; 2]) -> Option<[f64; 2]> {
        let wanted = u * self.total.value;
        // the last bin that begins at or below has flux, unless the lobe has none
        let bin = self.cumulated.partition_point(|c| *c <= wanted).checked_sub(1)?;
        let flux = (bin < self.partition.len()).then(|| self.flux(bin)).filter(|f| *f > 0.0)?;
        let rest = ((wanted - self.cumulated[bin]) / flux).clamp(0.0, 1.0);
        let (v, below) = match (self.partition.mirrored, 2.0 * v) {
            (false, _) => (v, false),
            (true, v) if v < 1.0 => (v, false),
            (true, v) => (v - 1.0, true),
        };
        let r = self.partition.leaves[bin];
        let at = |axis: usize, u: f64| f64::from(r.corner[axis]) + u * f64::from(r.sides[axis]);
        let [x, y] = to_disc([at(0, rest), at(1, v)]);
        Some([x, if below { -y } else { y }])
    }

    /// All bins.
    pub(super) fn bins(&self) -> impl Iterator<Item = Bin> + '_ {
        let mirrored = self.partition.mirrored;
        self.partition.leaves.iter().enumerate().map(move |(k, r)| Bin {
            corner: r.corner.map(f64::from),
            sides: r.sides.map(f64::from),
            mirrored,
            flux: Estimate { value: self.flux(k), std_error: f64::from(self.std_errors[k]) },
            projected_sr: self.partition.projected(k),
        })
    }

    /// Root mean square distance of the flux from a point of the disc.
    pub(super) fn spread(&self, [x, y]: [f64; 2]) -> f64 {
        let moment = |bin: Bin| {
            let [a, b] = [0, 1].map(|k| bin.corner[k] + 0.5 * bin.sides[k]);
            let [px, py] = to_disc([a, b]);
            let square = (px - x).powi(2) + py.powi(2) + y * y;
            // of a mirrored pair the mixed terms cancel
            let mixed = if bin.mirrored { 0.0 } else { 2.0 * y * py };
            bin.flux.value * (square - mixed)
        };
        let sum: f64 = self.bins().map(moment).sum();
        if self.total.value > 0.0 { (sum / self.total.value).max(0.0).sqrt() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::{BinnedLobe, Estimate, Partition, SMALLEST};

    /// Points about (0.3, 0.2), a spiral of a given size.
    fn spiral(count: u32, size: f64) -> Vec<[f64; 2]> {
        let point = |k: u32| {
            let (s, c) = (2.399_963 * f64::from(k)).sin_cos();
            let r = size * (f64::from(k) / f64::from(count)).sqrt();
            [0.3 + r * c, 0.2 + r * s]
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn narrow_and_wide_lobes_have_as_many_bins() {
        for (size, most) in [(0.6, 20), (0.01, 20)] {
            let points = spiral(10_000, size);
            let p = Partition::grow(&points, most, false);
            assert!((700..3000).contains(&p.len()), "{size}: {} bins", p.len());
            let area: f64 = p.leaves.iter().map(super::Rectangle::area).sum();
            assert!((area - 1.0).abs() < 1e-12);
            let mut counts = vec![0; p.len()];
            for point in points {
                counts[p.index(point)] += 1;
            }
            assert!(counts.iter().all(|n| *n <= most), "{counts:?}");
        }
        // a beam ends in one smallest bin
        let p = Partition::grow(&vec![[0.301, 0.2]; 1000], 20, true);
        let leaf = p.leaves[p.index([0.301, -0.2])];
        assert!(leaf.sides.iter().all(|s| *s <= SMALLEST), "{leaf:?}");
        assert!(p.len() < 40);
    }

    #[test]
    fn draws_fall_where_the_flux_is() {
        for mirrored in [false, true] {
            let points = spiral(2000, 0.3);
            let p = Partition::grow(&points, 20, mirrored);
            let mut flux = vec![Estimate::default(); p.len()];
            for point in points {
                flux[p.index(point)].value += 0.25 / 2000.0;
            }
            let lobe = BinnedLobe::new(p, &flux, 0.01);
            assert!((lobe.total().value - 0.25).abs() < 1e-12);
            let mut counts = vec![0.0; lobe.partition.len()];
            let (n, mut below) = (400, 0);
            for k in 0..n * n {
                let u = [k % n, k / n].map(|i| (f64::from(i) + 0.5) / f64::from(n));
                let point = lobe.draw(u).unwrap();
                below += u32::from(point[1] < 0.0);
                counts[lobe.partition.index(point)] += 0.25 / f64::from(n * n);
                assert!(lobe.value(point) > 0.0);
            }
            assert_eq!(mirrored, below == (n * n / 2) as u32, "{below}");
            for (bin, found) in lobe.bins().zip(counts) {
                assert!((bin.flux.value - found).abs() < 4e-3 * 0.25, "{bin:?} {found}");
            }
        }
        let empty = BinnedLobe::new(Partition::grow(&[], 1, true), &[Estimate::default()], 0.0);
        assert!(empty.draw([0.3, 0.3]).is_none() && empty.value([0.1, 0.1]).abs() <= 0.0);
    }
}
