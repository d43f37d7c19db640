//! Maxwell's equations on one periodic surface, for any number of incidences.
//!
//! With u the field along the grooves and v its normal derivative on the side of the air, Green's theorem on both sides
//! reads
//! `(1/2 - D1) u + S1 v = f1`, `(1/2 + D2) u - rho S2 v = f2`,
//! S and D the potentials of a single and a double layer with the periodic Green's function of air (1) and
//! dielectric (2), f the incident field on the side that it comes from, rho = 1 (TE) or n^2 (TM). With
//! `A = S1^-1 (1/2 - D1)`, which both polarisations share, what remains is `(Y + rho X) u = f`, `Y = 1/2 + D2`, `X = S2 A`.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::layers::{Layers, Surface};
use crate::linear::{Factors, Matrix, Product, Scratch, add_product};
use crate::nodes::Curve;
use crate::problem::{Incidence, Problem, RigorousError, Side};
use crate::stage::{Part, Stopped, Tally, Watcher, nobody};
use crate::waves::{Both, Polarisation, Response, Traces, Wave, respond};

impl From<Stopped> for RigorousError {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}

/// Part of a wavelength that no phase notices.
const LEAST: f64 = 3e-10;

/// The factored equations of one surface. Its memory is `64 nodes^2` bytes, also at the peak of its making.
#[derive(Debug)]
pub struct Solver {
    problem: Problem,
    surface: Surface,
    /// A: the normal derivative from the field.
    derivative: Matrix,
    /// S2.
    single: Matrix,
    te: Factors,
    tm: Factors,
}

impl Solver {
    /// Assembles and factors the equations for a number of nodes (raised to an even one, at least 32).
    ///
    /// # Errors
    /// The watcher wants the work to end.
    pub fn new(
        problem: Problem,
        nodes: usize,
        watcher: Watcher<'_>,
    ) -> Result<Self, RigorousError> {
        let curve = curve_of(&problem);
        Self::on(problem, &curve, nodes, watcher)
    }

    pub(crate) fn on(
        problem: Problem,
        curve: &Curve,
        nodes: usize,
        watcher: Watcher<'_>,
    ) -> Result<Self, RigorousError> {
        let count = nodes.max(32).next_multiple_of(2);
        let tally =
            Tally::new(watcher, 24.0 * (count as f64).powi(3) + 2.0 * Layers::operations(count));
        let mut scratch = Scratch::default();
        let surface = Surface {
            period: curve.period,
            step: curve.arc() / count as f64,
            nodes: curve.nodes(count),
        };
        let k = TAU / problem.wavelength_um();

        let Layers { single, double: mut derivative } = Layers::new(&surface, k, &tally)?;
        derivative.re.iter_mut().chain(&mut derivative.im).for_each(|x| *x = -*x);
        add_half(&mut derivative);
        tally.enter(Part::Elimination);
        let factors = Factors::new(single, &mut scratch, &tally)?;
        factors.solve(&mut derivative, &mut scratch, &tally)?;
        let mut te = factors.into_matrix(); // X, then Y + X
        tally.enter(Part::Kernels);
        let Layers { single, double: mut tm } = Layers::new(&surface, problem.index() * k, &tally)?;
        add_half(&mut tm); // Y
        tally.enter(Part::Elimination);
        te.re.fill(0.0);
        te.im.fill(0.0);
        add_product(&mut te, 0, 0, &Product::of(&single, &derivative, 1.0), &mut scratch, &tally)?;
        let jump = Polarisation::Tm.jump(problem.index());
        for (x, y) in te.re.iter_mut().chain(&mut te.im).zip(tm.re.iter_mut().chain(&mut tm.im)) {
            (*x, *y) = (*y + *x, *y + jump * *x);
        }
        tally.enter(Part::Factors);
        let te = Factors::new(te, &mut scratch, &tally)?;
        let tm = Factors::new(tm, &mut scratch, &tally)?;
        Ok(Self { problem, surface, derivative, single, te, tm })
    }

    /// The problem.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.surface.nodes.len()
    }

    /// Length of the arc over one period, um.
    pub fn arc_um(&self) -> f64 {
        self.surface.step * self.nodes() as f64
    }

    /// Bytes of the matrices.
    pub fn bytes(&self) -> usize {
        64 * self.nodes() * self.nodes()
    }

    /// All orders of both polarisations for each incidence.
    ///
    /// # Errors
    /// An incidence that does not travel.
    pub fn solve(&self, incidences: &[Incidence]) -> Result<Vec<Response>, RigorousError> {
        for &Incidence { side, order } in incidences {
            let last = self.problem.last_order(side);
            if order.abs() > last {
                return Err(RigorousError::Incidence { order, last });
            }
        }
        let sources = self.sources(incidences)?;
        let te = self.traces(&sources, Polarisation::Te)?;
        let tm = self.traces(&sources, Polarisation::Tm)?;
        Ok(respond(&self.problem, &self.surface, incidences, &Both { te, tm }))
    }

    /// What the incident fields, a column each, contribute to the equations.
    fn sources(&self, incidences: &[Incidence]) -> Result<Sources, RigorousError> {
        let (count, columns) = (self.nodes(), incidences.len());
        let zeros = || Matrix::zeros(count, columns);
        let (mut below, mut above, mut normal, mut through) = (zeros(), zeros(), zeros(), zeros());
        for (column, &Incidence { side, order }) in incidences.iter().enumerate() {
            let wave = Wave::new(&self.problem, side, order).incident(&self.surface);
            match side {
                Side::Air => {
                    set_column(&mut above, column, &wave.field);
                    set_column(&mut normal, column, &wave.normal);
                }
                Side::Dielectric => set_column(&mut below, column, &wave.field),
            }
        }
        // S1^-1 f1 = A f1 + df1/dn, because f1 solves the equation of air below the surface too
        multiply(&mut normal, &self.derivative, &above, 1.0)?;
        multiply(&mut through, &self.single, &normal, 1.0)?;
        Ok(Sources { below, normal, through })
    }

    /// The field and its normal derivative on the surface.
    fn traces(
        &self,
        sources: &Sources,
        polarisation: Polarisation,
    ) -> Result<Vec<Traces>, RigorousError> {
        let jump = polarisation.jump(self.problem.index());
        let mut field = sources.below.clone();
        let through = sources.through.re.iter().chain(&sources.through.im);
        for (f, s) in field.re.iter_mut().chain(&mut field.im).zip(through) {
            *f += jump * s;
        }
        let factors = match polarisation {
            Polarisation::Te => &self.te,
            Polarisation::Tm => &self.tm,
        };
        factors.solve(&mut field, &mut Scratch::default(), &Tally::new(&nobody, 1.0))?;
        let mut normal = sources.normal.clone();
        multiply(&mut normal, &self.derivative, &field, -1.0)?;
        let column =
            |matrix: &Matrix, at| (0..matrix.rows).map(|row| matrix.get(row, at)).collect();
        Ok((0..field.cols)
            .map(|at| Traces { field: column(&field, at), normal: column(&normal, at) })
            .collect())
    }
}

/// Right sides, a column for each incidence.
struct Sources {
    /// f2.
    below: Matrix,
    /// `S1^-1 f1`.
    normal: Matrix,
    /// `S2 S1^-1 f1`.
    through: Matrix,
}

/// The profile as a curve, without harmonics that no phase notices.
pub(crate) fn curve_of(problem: &Problem) -> Curve {
    Curve::new(problem.profile(), LEAST * problem.wavelength_um())
}

fn add_half(matrix: &mut Matrix) {
    let cols = matrix.cols;
    for row in 0..matrix.rows {
        matrix.re[row * cols + row] += 0.5;
    }
}

fn set_column(matrix: &mut Matrix, column: usize, values: &[Complex64]) {
    for (row, value) in values.iter().enumerate() {
        matrix.set(row, column, *value);
    }
}

/// `result += sign left right`, unwatched: of few columns.
fn multiply(result: &mut Matrix, left: &Matrix, right: &Matrix, sign: f64) -> Result<(), Stopped> {
    let product = Product::of(left, right, sign);
    add_product(result, 0, 0, &product, &mut Scratch::default(), &Tally::new(&nobody, 1.0))
}
