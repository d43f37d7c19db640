//! Plane waves above and below the surface: incident fields, and the orders that the fields on the surface send out.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::layers::Surface;
use crate::nodes::Node;
use crate::problem::{Incidence, Problem, Side};

/// The direction of the field that is along the grooves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Polarisation {
    /// The electric field.
    Te,
    /// The magnetic field.
    Tm,
}

impl Polarisation {
    /// By how much the normal derivative is larger below the surface than above it: 1, or the square of the index.
    pub(crate) fn jump(self, index: f64) -> f64 {
        match self {
            Self::Te => 1.0,
            Self::Tm => index * index,
        }
    }
}

/// Whether light goes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Into the medium that it came from.
    Reflected,
    /// Into the other one.
    Transmitted,
}

/// One direction of the light that leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Reflected or transmitted.
    pub kind: Kind,
    /// Its tangential wavenumber is `2 pi m / period`.
    pub m: i32,
    /// The sine of its angle from the normal, in its medium, positive towards +x.
    pub sine: f64,
    /// The field along the grooves, scaled so that its square is the efficiency; the phase is that at x = z = 0, where
    /// the incident light has the phase 0.
    pub amplitude: Complex64,
}

impl Order {
    /// Share of the incident power.
    pub fn efficiency(&self) -> f64 {
        self.amplitude.norm_sqr()
    }
}

/// The field and its normal derivative (on the side of the air) at the nodes.
#[derive(Clone, Debug)]
pub(crate) struct Traces {
    pub(crate) field: Vec<Complex64>,
    pub(crate) normal: Vec<Complex64>,
}

/// A plane wave in one medium.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wave {
    side: Side,
    /// Wavenumber along x, 1/um.
    alpha: f64,
    /// Wavenumber along z, 1/um, positive.
    beta: f64,
}

impl Wave {
    pub(crate) fn new(problem: &Problem, side: Side, order: i32) -> Self {
        let k = TAU * problem.index_of(side) / problem.wavelength_um();
        let alpha = TAU * f64::from(order) / problem.profile().period_um();
        Self { side, alpha, beta: (k * k - alpha * alpha).max(0.0).sqrt() }
    }

    /// The wave as it comes to the surface.
    pub(crate) fn incident(&self, surface: &Surface) -> Traces {
        let beta = match self.side {
            Side::Air => -self.beta,
            Side::Dielectric => self.beta,
        };
        let at = |node: &Node| Complex64::from_polar(1.0, self.alpha * node.x + beta * node.z);
        let field: Vec<Complex64> = surface.nodes.iter().map(at).collect();
        let normal = field.iter().zip(&surface.nodes);
        let normal =
            normal.map(|(u, node)| u * Complex64::new(0.0, self.alpha * node.nx + beta * node.nz));
        Traces { normal: normal.collect(), field }
    }

    /// What the field and its normal derivative at each node add to the amplitude of this wave as it leaves.
    fn leaving(&self, surface: &Surface, jump: f64) -> Vec<Leaving> {
        let (sign, jump) = match self.side {
            Side::Air => (1.0, 1.0),
            Side::Dielectric => (-1.0, jump),
        };
        let scale = Complex64::new(0.0, -0.5 * sign * surface.step / (surface.period * self.beta));
        let of_node = |node: &Node| {
            let back = scale
                * Complex64::from_polar(1.0, -self.alpha * node.x - sign * self.beta * node.z);
            let slope = self.alpha * node.nx + sign * self.beta * node.nz;
            Leaving { field: back * Complex64::new(0.0, slope), normal: jump * back }
        };
        surface.nodes.iter().map(of_node).collect()
    }

    /// The flux of a field along the grooves: beta, for TM over the permittivity, which is the jump below the surface.
    fn flux(&self, jump: f64) -> f64 {
        match self.side {
            Side::Air => self.beta,
            Side::Dielectric => self.beta / jump,
        }
    }
}

/// Of one node.
struct Leaving {
    field: Complex64,
    normal: Complex64,
}

impl Leaving {
    fn sum(all: &[Self], total: &Traces) -> Complex64 {
        let traces = total.field.iter().zip(&total.normal);
        all.iter().zip(traces).map(|(leaving, (u, v))| leaving.field * u + leaving.normal * v).sum()
    }
}

/// What becomes of one incidence.
#[derive(Clone, Debug)]
pub struct Response {
    /// The light.
    pub incidence: Incidence,
    /// Orders for the electric field along the grooves, reflected ones first, by increasing m.
    pub te: Vec<Order>,
    /// Orders for the magnetic field along the grooves, the same ones in the same order.
    pub tm: Vec<Order>,
}

impl Response {
    /// Orders of a polarisation.
    pub fn orders(&self, polarisation: Polarisation) -> &[Order] {
        match polarisation {
            Polarisation::Te => &self.te,
            Polarisation::Tm => &self.tm,
        }
    }

    /// By how much the power that leaves differs from the power that came, the worse of both polarisations.
    pub fn energy_error(&self) -> f64 {
        let off =
            |orders: &[Order]| (orders.iter().map(Order::efficiency).sum::<f64>() - 1.0).abs();
        off(&self.te).max(off(&self.tm))
    }
}

/// The fields of each incidence for both polarisations.
#[derive(Debug)]
pub(crate) struct Both {
    pub(crate) te: Vec<Traces>,
    pub(crate) tm: Vec<Traces>,
}

impl Both {
    fn of(&self, polarisation: Polarisation) -> &[Traces] {
        match polarisation {
            Polarisation::Te => &self.te,
            Polarisation::Tm => &self.tm,
        }
    }
}

/// All orders that travel, for all incidences.
pub(crate) fn respond(
    problem: &Problem,
    surface: &Surface,
    incidences: &[Incidence],
    totals: &Both,
) -> Vec<Response> {
    let empty = |&incidence| Response { incidence, te: Vec::new(), tm: Vec::new() };
    let mut responses: Vec<Response> = incidences.iter().map(empty).collect();
    // reflected orders of all come before transmitted ones
    for kind in [Kind::Reflected, Kind::Transmitted] {
        for side in [Side::Air, Side::Dielectric] {
            let from = if kind == Kind::Reflected { side } else { side.other() };
            let last = problem.last_order(side);
            for m in -last..=last {
                let out = Out { kind, m, from, wave: Wave::new(problem, side, m) };
                for polarisation in [Polarisation::Te, Polarisation::Tm] {
                    out.add_to(
                        &mut responses,
                        problem,
                        surface,
                        polarisation,
                        totals.of(polarisation),
                    );
                }
            }
        }
    }
    responses
}

/// One wave that leaves, for light from one side.
struct Out {
    kind: Kind,
    m: i32,
    from: Side,
    wave: Wave,
}

impl Out {
    fn add_to(
        &self,
        responses: &mut [Response],
        problem: &Problem,
        surface: &Surface,
        polarisation: Polarisation,
        totals: &[Traces],
    ) {
        let jump = polarisation.jump(problem.index());
        let leaving = self.wave.leaving(surface, jump);
        for (response, total) in responses.iter_mut().zip(totals) {
            if response.incidence.side != self.from {
                continue;
            }
            let received = Wave::new(problem, self.from, response.incidence.order).flux(jump);
            let scale = (self.wave.flux(jump) / received).sqrt();
            let order = Order {
                kind: self.kind,
                m: self.m,
                sine: problem.sine(self.wave.side, self.m),
                amplitude: scale * Leaving::sum(&leaving, total),
            };
            match polarisation {
                Polarisation::Te => response.te.push(order),
                Polarisation::Tm => response.tm.push(order),
            }
        }
    }
}
