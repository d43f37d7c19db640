//! The potentials of a single and a double layer on the surface, as matrices over its nodes.

use std::f64::consts::{FRAC_1_PI, PI};

use multiversion::multiversion;
use num_complex::Complex64;

use crate::bessel::Table as BesselTable;
use crate::images::Images;
use crate::linear::Matrix;
use crate::nodes::Node;
use crate::quadrature::Corrections;
use crate::stage::{Stopped, Tally};

/// Euler's constant.
const GAMMA: f64 = 0.577_215_664_901_532_9;
/// Operations that a pair of nodes is worth, for the share of the work that is done.
const PAIR: f64 = 3000.0;

/// Nodes at equal distances along the arc of one period.
#[derive(Debug)]
pub(crate) struct Surface {
    /// Period in um.
    pub(crate) period: f64,
    /// Distance of the nodes along the arc, um.
    pub(crate) step: f64,
    /// An even number of them.
    pub(crate) nodes: Vec<Node>,
}

impl Surface {
    /// The largest difference of heights of the nodes, um.
    pub(crate) fn height(&self) -> f64 {
        let (low, high) = self
            .nodes
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), node| (low.min(node.z), high.max(node.z)));
        high - low
    }
}

/// Both layers for one wavenumber.
#[derive(Debug)]
pub(crate) struct Layers {
    /// `int G(r_i, r') f(r') ds'`, symmetric.
    pub(crate) single: Matrix,
    /// `int dG(r_i, r')/dn' f(r') ds'`, the principal value, n' into the air.
    pub(crate) double: Matrix,
}

impl Layers {
    /// Operations of the assembly for so many nodes.
    pub(crate) fn operations(nodes: usize) -> f64 {
        0.5 * PAIR * (nodes * nodes) as f64
    }

    /// `wavenumber` in the medium, 1/um.
    ///
    /// # Errors
    /// The watcher wants the work to end.
    pub(crate) fn new(
        surface: &Surface,
        wavenumber: f64,
        tally: &Tally<'_>,
    ) -> Result<Self, Stopped> {
        let count = surface.nodes.len();
        // within so many nodes the nearest image cannot change, however steep the profile
        let half = (surface.period / (2.0 * surface.step)) as usize;
        let integrals = Integrals {
            surface,
            wavenumber,
            images: Images::new(wavenumber, surface.period, surface.height(), tally)?,
            bessel: BesselTable::get(),
            corrections: Corrections::new(count, half.min(count / 2 - 1)),
            turns: surface
                .nodes
                .iter()
                .map(|node| Complex64::from_polar(1.0, wavenumber * node.x))
                .collect(),
            turn: Complex64::from_polar(1.0, wavenumber * surface.period),
        };
        let mut layers =
            Self { single: Matrix::zeros(count, count), double: Matrix::zeros(count, count) };
        let mut row = Vec::with_capacity(count);
        for i in 0..count {
            integrals.row(i, &mut row);
            layers.set_row(i, &row, surface);
            layers.set_diagonal(i, &integrals);
            tally.spend(PAIR * i as f64)?;
        }
        Ok(layers)
    }

    /// A row and, by symmetry, the column of the same number, up to the diagonal.
    fn set_row(&mut self, i: usize, row: &[Weighted], surface: &Surface) {
        let here = &surface.nodes[i];
        for (j, (weighted, there)) in row.iter().zip(&surface.nodes).enumerate() {
            self.single.set(i, j, weighted.value);
            self.single.set(j, i, weighted.value);
            self.double.set(i, j, -(weighted.along_x * there.nx + weighted.along_z * there.nz));
            self.double.set(j, i, weighted.along_x * here.nx + weighted.along_z * here.nz);
        }
    }

    fn set_diagonal(&mut self, i: usize, integrals: &Integrals<'_>) {
        let step = integrals.surface.step;
        let count = integrals.surface.nodes.len() as f64;
        let radius = step * count / (2.0 * PI); // of a circle with the length of the arc
        let smooth = -0.5 * FRAC_1_PI * (GAMMA + (0.5 * integrals.wavenumber * radius).ln());
        let log = -0.25 * FRAC_1_PI * integrals.corrections.near[0];
        let images = integrals.images.at(0.0, 0.0, Complex64::ONE).value;
        self.single.set(i, i, step * (Complex64::new(smooth + log, 0.25) + images));
        let bend = integrals.surface.nodes[i].curvature * 0.25 * FRAC_1_PI;
        self.double.set(i, i, Complex64::new(step * bend, 0.0));
    }
}

/// Green's function and its gradient with the weights of the quadrature.
#[derive(Clone, Copy, Debug)]
struct Weighted {
    value: Complex64,
    along_x: Complex64,
    along_z: Complex64,
}

struct Integrals<'a> {
    surface: &'a Surface,
    wavenumber: f64,
    images: Images,
    bessel: &'static BesselTable,
    corrections: Corrections,
    /// `exp(i k x)` of the nodes.
    turns: Vec<Complex64>,
    /// `exp(i k period)`.
    turn: Complex64,
}

impl Integrals<'_> {
    /// From node `i` to all nodes before it.
    fn row(&self, i: usize, row: &mut Vec<Weighted>) {
        row.clear();
        fill(self, i, row);
    }

    #[inline(always)]
    #[allow(clippy::inline_always, reason = "its instructions are those of the caller's version")]
    fn pair(&self, i: usize, j: usize) -> Weighted {
        let (here, there) = (&self.surface.nodes[i], &self.surface.nodes[j]);
        let (period, step, k) = (self.surface.period, self.surface.step, self.wavenumber);
        let z = here.z - there.z;
        let mut x = here.x - there.x; // positive: nodes are in order of x
        let mut turn = self.turns[i] * self.turns[j].conj();
        if x > 0.5 * period {
            x -= period;
            turn = self.turn * turn.conj(); // of |x|
        }
        let images = self.images.at(x, z, turn);
        let square = x * x + z * z;
        let r = square.sqrt();
        let bessel = self.bessel.at(k * r);
        let radial = -0.25 * k * step / r;
        let mut value = 0.25 * step * Complex64::new(-bessel.y0, bessel.j0);
        let mut gradient = radial * Complex64::new(-bessel.y1, bessel.j1);
        let apart = i - j;
        if let Some(near) = self.corrections.near.get(apart.min(self.surface.nodes.len() - apart)) {
            let weight = 0.25 * FRAC_1_PI * near;
            value -= weight * step * bessel.j0;
            gradient -= FRAC_1_PI * near * radial * bessel.j1;
        }
        Weighted {
            value: value + step * images.value,
            along_x: gradient * x + step * images.along_x,
            along_z: gradient * z + step * images.along_z,
        }
    }
}

#[multiversion(targets("x86_64+avx2+fma"))]
fn fill(integrals: &Integrals<'_>, i: usize, row: &mut Vec<Weighted>) {
    for j in 0..i {
        row.push(integrals.pair(i, j));
    }
}
