//! Laplace's equation over the gaps of a grid, solved by conjugate gradients with a multigrid preconditioner.
//!
//! The unknowns are the points of the gaps, joined to their neighbours by springs of strength 1/dx^2 and
//! 1/dy^2; springs to known points hold them. Coarser grids lump 2 x 2 unknowns and add up their springs
//! (aggregation, so that gaps of any shape coarsen by themselves), and a cycle over them with red-black
//! Gauss-Seidel makes the number of iterations nearly independent of the size of the gaps. The unknowns are
//! kept by colour of the chessboard: those of one colour see the other only, so threads change no bit.

use rayon::prelude::*;

/// The equation of the gaps of one grid.
pub(super) struct Membrane {
    levels: Vec<Level>,
    /// Forces of the known neighbours on the unknowns.
    pull: Both,
    /// Place of each unknown in the grid, by colour.
    places: [Vec<usize>; 2],
    /// Points of the grid.
    count: usize,
}

/// A number for each unknown, by colour. The first of each colour stands for no unknown and is 0.
type Both = [Vec<f64>; 2];

/// Springs between the unknowns of one grid.
struct Level {
    points: [Vec<Point>; 2],
}

/// An unknown: its springs to the left, right, up and down, by the place among those of the other colour.
#[derive(Clone, Copy, Default)]
struct Point {
    to: [u32; 4],
    spring: [f64; 4],
    /// All springs together, those to known points included.
    total: f64,
    /// Colour and place in the coarser level.
    parent: (u8, u32),
}

/// The residual at which the iteration ends, relative to that of the start.
const TOLERANCE: f64 = 1e-11;
/// Iterations at most; the largest gaps take some 20.
const MOST_ITERATIONS: usize = 300;

impl Membrane {
    /// The equation for the points that are NaN.
    pub(super) fn new((nx, ny): (usize, usize), (dx, dy): (f64, f64), heights: &[f64]) -> Self {
        // Only the ratio of the springs matters.
        let strengths = [dy / dx, dx / dy].map(|s| s.clamp(1e-6, 1e6));
        let lattice = Lattice::new((nx, ny), |k| heights[k].is_nan());
        let mut level = Level::empty(&lattice);
        let mut pull = level.zeros();
        for (colour, pull) in pull.iter_mut().enumerate() {
            for (i, &k) in lattice.places[colour].iter().enumerate().skip(1) {
                let point = &mut level.points[colour][i];
                for direction in 0..4 {
                    let Some(other) = lattice.beside(k, direction) else { continue };
                    let spring = strengths[direction / 2];
                    point.total += spring;
                    if heights[other].is_nan() {
                        point.to[direction] = lattice.index[other];
                        point.spring[direction] = spring;
                    } else {
                        pull[i] += spring * heights[other];
                    }
                }
            }
        }
        let mut levels = vec![level];
        let (places, count) = (lattice.places.clone(), nx * ny);
        let mut fine = lattice;
        while fine.nx * fine.ny > 4
            && let Some(last) = levels.last_mut()
        {
            let (coarse, lattice) = last.coarser(&fine);
            levels.push(coarse);
            fine = lattice;
        }
        Self { levels, pull, places, count }
    }

    /// Heights of the unknowns over the grid; 0 elsewhere.
    pub(super) fn solve(&self) -> Vec<f64> {
        let Some(top) = self.levels.first() else { return vec![0.0; self.count] };
        let (mut x, mut p, mut ap) = (top.zeros(), top.zeros(), top.zeros());
        let mut r = self.pull.clone();
        let mut work: Vec<Work> = self.levels.iter().map(Work::new).collect();
        let start = dot(&r, &r);
        let mut last = None;
        for _ in 0..MOST_ITERATIONS {
            // Also an end for NaN, which the caller finds.
            if dot(&r, &r).partial_cmp(&(TOLERANCE * TOLERANCE * start))
                != Some(std::cmp::Ordering::Greater)
            {
                break;
            }
            work[0].right.clone_from(&r);
            cycle(&self.levels, &mut work, 1);
            let z = &work[0].x;
            let rz = dot(&r, z);
            let beta = last.map_or(0.0, |last| rz / last);
            add(&mut p, beta, z, 1.0);
            top.apply(&p, &mut ap);
            let alpha = rz / dot(&p, &ap);
            add(&mut x, 1.0, &p, alpha);
            add(&mut r, 1.0, &ap, -alpha);
            last = Some(rz);
        }
        let mut heights = vec![0.0; self.count];
        for (places, x) in self.places.iter().zip(&x) {
            for (&k, &x) in places.iter().zip(x).skip(1) {
                heights[k] = x;
            }
        }
        heights
    }
}

/// Which points of a grid are unknowns, and their places by colour.
struct Lattice {
    nx: usize,
    ny: usize,
    /// Place of a point among those of its colour; 0 if it is no unknown.
    index: Vec<u32>,
    /// The points, by colour; the first of each is none.
    places: [Vec<usize>; 2],
}

impl Lattice {
    fn new((nx, ny): (usize, usize), unknown: impl Fn(usize) -> bool) -> Self {
        let mut places = [vec![0], vec![0]];
        let mut index = vec![0; nx * ny];
        for k in (0..nx * ny).filter(|&k| unknown(k)) {
            let own = &mut places[(k % nx + k / nx) % 2];
            index[k] = own.len() as u32;
            own.push(k);
        }
        Self { nx, ny, index, places }
    }

    /// The point to the left, right, up or down.
    fn beside(&self, k: usize, direction: usize) -> Option<usize> {
        let (col, row) = (k % self.nx, k / self.nx);
        match direction {
            0 => (col > 0).then(|| k - 1),
            1 => (col + 1 < self.nx).then_some(k + 1),
            2 => (row > 0).then(|| k - self.nx),
            _ => (row + 1 < self.ny).then_some(k + self.nx),
        }
    }
}

impl Level {
    fn empty(lattice: &Lattice) -> Self {
        Self { points: [0, 1].map(|c| vec![Point::default(); lattice.places[c].len()]) }
    }

    fn zeros(&self) -> Both {
        [0, 1].map(|c| vec![0.0; self.points[c].len()])
    }

    /// Unknowns lumped 2 x 2.
    fn coarser(&mut self, fine: &Lattice) -> (Self, Lattice) {
        let (nx, ny) = (fine.nx.div_ceil(2), fine.ny.div_ceil(2));
        let lump = |k: usize| k / fine.nx / 2 * nx + k % fine.nx / 2;
        let mut any = vec![false; nx * ny];
        for k in fine.places.iter().flat_map(|places| &places[1..]) {
            any[lump(*k)] = true;
        }
        let lattice = Lattice::new((nx, ny), |k| any[k]);
        let mut coarse = Self::empty(&lattice);
        for colour in 0..2 {
            for (point, &k) in self.points[colour].iter_mut().zip(&fine.places[colour]).skip(1) {
                let own = lump(k);
                let (c, i) = ((own % nx + own / nx) % 2, lattice.index[own]);
                point.parent = (c as u8, i);
                let sum = &mut coarse.points[c][i as usize];
                sum.total += point.total;
                for direction in (0..4).filter(|&d| point.spring[d] > 0.0) {
                    let Some(other) = fine.beside(k, direction).map(lump) else { continue };
                    if other == own {
                        sum.total -= point.spring[direction];
                    } else {
                        sum.spring[direction] += point.spring[direction];
                        sum.to[direction] = lattice.index[other];
                    }
                }
            }
        }
        (coarse, lattice)
    }

    /// `out = A x`.
    fn apply(&self, x: &Both, out: &mut Both) {
        for (colour, out) in out.iter_mut().enumerate() {
            let (own, other) = (&x[colour], &x[1 - colour]);
            out.par_iter_mut()
                .zip(&self.points[colour])
                .zip(own)
                .with_min_len(GRAIN)
                .for_each(|((out, point), x)| *out = point.total * x - point.force(other));
        }
    }

    /// A sweep of Gauss-Seidel over one colour, then the other.
    fn smooth(&self, x: &mut Both, right: &Both, colours: [usize; 2]) {
        for colour in colours {
            let [red, black] = x;
            let (own, other) = if colour == 0 { (red, &*black) } else { (black, &*red) };
            let points = self.points[colour].par_iter().zip(&right[colour]);
            own.par_iter_mut().zip(points).with_min_len(GRAIN).for_each(|(x, (point, b))| {
                if point.total > 0.0 {
                    *x = (b + point.force(other)) / point.total;
                }
            });
        }
    }
}

impl Point {
    /// Of the neighbours.
    #[inline]
    fn force(&self, other: &[f64]) -> f64 {
        let [a, b, c, d] = self.to.map(|i| other[i as usize]);
        let s = self.spring;
        s[0] * a + s[1] * b + s[2] * c + s[3] * d
    }
}

/// Vectors of one level.
struct Work {
    x: Both,
    right: Both,
    residual: Both,
}

impl Work {
    fn new(level: &Level) -> Self {
        Self { x: level.zeros(), right: level.zeros(), residual: level.zeros() }
    }
}

/// A symmetric cycle: `x` of the first level becomes about the solution for its `right`. The next level is
/// visited `visits` times, those below it twice as often each.
fn cycle(levels: &[Level], work: &mut [Work], visits: usize) {
    let (Some((level, coarser)), Some((here, below))) =
        (levels.split_first(), work.split_first_mut())
    else {
        return;
    };
    here.x.iter_mut().for_each(|x| x.fill(0.0));
    if below.is_empty() {
        for _ in 0..4 {
            level.smooth(&mut here.x, &here.right, [0, 1]);
            level.smooth(&mut here.x, &here.right, [1, 0]);
        }
        return;
    }
    level.smooth(&mut here.x, &here.right, [0, 1]);
    for visit in 0..visits {
        if visit > 0 {
            level.smooth(&mut here.x, &here.right, [1, 0]);
            level.smooth(&mut here.x, &here.right, [0, 1]);
        }
        let Some(next) = below.first_mut() else { return };
        level.apply(&here.x, &mut here.residual);
        next.right.iter_mut().for_each(|b| b.fill(0.0));
        for colour in 0..2 {
            let both = here.right[colour].iter().zip(&here.residual[colour]);
            for (point, (b, ax)) in level.points[colour].iter().zip(both).skip(1) {
                next.right[usize::from(point.parent.0)][point.parent.1 as usize] += b - ax;
            }
        }
        cycle(coarser, below, 2);
        let Some(Work { x: coarse, .. }) = below.first() else { return };
        for colour in 0..2 {
            let points = level.points[colour].par_iter();
            here.x[colour].par_iter_mut().zip(points).skip(1).with_min_len(GRAIN).for_each(
                |(x, point)| {
                    *x += OVER * coarse[usize::from(point.parent.0)][point.parent.1 as usize];
                },
            );
        }
    }
    level.smooth(&mut here.x, &here.right, [1, 0]);
}

/// Lumps are too stiff: a step between two of them is spread over both \[Braess 1995\].
const OVER: f64 = 1.6;

/// Numbers that are worth a thread.
const GRAIN: usize = 16384;

/// Summed in fixed pieces, so that the number of threads changes no bit.
fn dot(a: &Both, b: &Both) -> f64 {
    let pieces = |a: &[f64], b: &[f64]| -> f64 {
        let sum = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let sums: Vec<f64> = a.par_chunks(GRAIN).zip(b.par_chunks(GRAIN)).map(sum).collect();
        sums.iter().sum()
    };
    pieces(&a[0], &b[0]) + pieces(&a[1], &b[1])
}

/// `a = s a + t b`
fn add(a: &mut Both, s: f64, b: &Both, t: f64) {
    for (a, b) in a.iter_mut().zip(b) {
        a.par_iter_mut().zip(b).with_min_len(GRAIN).for_each(|(a, b)| *a = s * *a + t * b);
    }
}
