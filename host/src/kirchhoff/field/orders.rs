//! The light of a map, order by order: exact Kirchhoff for every direction of a periodic or mirrored surface.
//!
//! Such a surface scatters into discrete orders `q_xy`, and each order has a `q_z` of its own. The planes of a
//! stack over `q_z` are transformed one after the other, and every order takes up the planes about its
//! `q_z` ([`super::kernel`]); all beams share the stack. The error of an amplitude is 1e-5 of the field, beside the
//! rounding of f32. Cost: planes (the range of `q_z` times that of heights over 2 pi, half as many again)
//! times N log N.

use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;
use asperity_fourier::{Ends, place};
use rayon::prelude::*;
use rustfft::num_complex::Complex;

use super::horizon::{ALONG, mean_secant};
use super::kernel::WIDTH;
use super::patch::{Aperture, incident_share, shares};
use super::stack::{Plane, Stack, Tiling};
use crate::kirchhoff::optics::{Beam, Optics};
use crate::surface::{HeightMap, Incomplete};
use crate::watch::Watch;

/// Amplitudes that are in memory at once; more beams are worked on in turns.
const MOST_AMPLITUDES: usize = 96 << 20;

/// One order of a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Its number along x and y, of the period, or of twice the size of a mirrored map.
    pub number: [isize; 2],
    /// Where it goes.
    pub wo: Direction<f64>,
    /// `|A|^2`: its share of the light without obliquity and Fresnel's factor. Of a patch `|A'|^2`, without what its rim
    /// diffracts, times the quarter of an order's area that is a cell of a patch.
    pub intensity: f64,
    /// Flux in it, as a fraction of the incident flux.
    pub power: f64,
}

impl Order {
    /// Whether it is the one that a flat surface has: the coherent light. Of a patch, its middle.
    pub fn is_specular(&self) -> bool {
        self.number == [0, 0]
    }
}

/// All orders of a beam that propagate and that a facet can reach.
#[derive(Clone, Debug)]
pub struct BeamOrders {
    beam: Beam,
    optics: Option<Optics>,
    columns: Vec<Column>,
    /// Distance of orders, 1/um.
    step: [f64; 2],
    /// From `|A|^2` of the whole field to that of the lit part, by order.
    unit: f64,
    /// Only orders of `y >= 0` are kept; those below are their mirror images.
    halved: bool,
    /// Of a patch.
    lit: Option<Lit>,
}

/// A beam on a patch.
#[derive(Clone, Debug)]
struct Lit {
    aperture: Aperture,
    /// Fresnel's share in the specular direction; 0 without one.
    specular: f64,
    /// Share of the area on which light falls.
    incident: f64,
}

/// Orders of one number along x.
#[derive(Clone, Debug)]
struct Column {
    order_x: isize,
    first_y: isize,
    amplitudes: Vec<Complex<f32>>,
}

/// The orders of several beams on a map, in their order; `None` if it was stopped before the end.
///
/// `watch` is told the planes done. The same bits for any number of threads.
///
/// # Errors
/// [`Incomplete`] if points of the map are missing.
pub fn orders(
    map: &HeightMap,
    tiling: impl Into<Tiling>,
    eta: RelativeIor<f64>,
    beams: &[Beam],
    watch: Watch<'_>,
) -> Result<Option<Vec<BeamOrders>>, Incomplete> {
    let stack = Stack::new(map, tiling.into())?;
    let mut found: Vec<BeamOrders> = Vec::with_capacity(beams.len());
    let mut group: Vec<BeamOrders> = Vec::new();
    let (mut done, mut kept) = (0, 0);
    for (k, beam) in beams.iter().enumerate() {
        let next = BeamOrders::new(&stack, eta, *beam);
        kept += next.len();
        group.push(next);
        let last = k + 1 == beams.len();
        if last || kept > MOST_AMPLITUDES {
            let planes = stack.planes(group.iter().filter_map(BeamOrders::range));
            let count = (planes.end - planes.start) as usize;
            // the groups to come are about as long
            let all = done + count * (1 + (beams.len() - k - 1).div_ceil(group.len()));
            let mut now = done;
            let finished = stack.each(planes, watch, |plane| {
                for beam in &mut group {
                    beam.add(&stack, plane);
                }
                now += 1;
                watch.done(now, all);
            });
            if !finished {
                return Ok(None);
            }
            done += count;
            kept = 0;
            found.append(&mut group);
        }
    }
    Ok(Some(found))
}

impl BeamOrders {
    /// Room for all orders of a beam.
    fn new(stack: &Stack, eta: RelativeIor<f64>, beam: Beam) -> Self {
        let optics = Optics::new(eta, &beam);
        let halved = stack.ends == Ends::Mirrored && beam.wi.y().abs() <= 0.0;
        let (columns, step, unit) = (Vec::new(), stack.step, stack.unit);
        let lit = stack.rim.as_ref().zip(optics).map(|(rim, optics)| Lit {
            aperture: Aperture::new(rim, &stack.kernel),
            specular: optics.specular().map_or(0.0, |(wo, _)| optics.factor(wo) / wo.z().abs()),
            incident: incident_share(rim.slope, beam.wi.xyz()),
        });
        let mut this = Self { beam, optics, columns, step, unit, halved, lit };
        let Some(optics) = optics.filter(|o| o.heights().is_some()) else { return this };
        let least_cos = optics.cosine(0.0);
        // facets lead only to where q_z has its sign: within a circle, or beyond one
        let most = if optics.height(1.0) > optics.height(0.0) && least_cos > 0.0 {
            (1.0 - least_cos * least_cos).max(0.0)
        } else {
            1.0
        };
        let (first, last) = stack.numbers(0);
        let (lowest, highest) = stack.numbers(1);
        for order_x in first..=last {
            let [tx, _] = optics.tangent([order_x as f64 * stack.step[0], 0.0]);
            let half = most - tx * tx;
            if half <= 0.0 {
                continue;
            }
            let half = half.sqrt();
            let order = |ty: f64| optics.momentum([tx, ty])[1] / stack.step[1];
            let from = (order(-half).ceil() as isize).max(lowest);
            let from = if halved { from.max(0) } else { from };
            let to = (order(half).floor() as isize).min(highest);
            if from <= to {
                let amplitudes = vec![Complex::default(); (to - from + 1) as usize];
                this.columns.push(Column { order_x, first_y: from, amplitudes });
            }
        }
        this
    }

    /// The `|q_z|` of its orders, 1/um; `None` if there are none.
    fn range(&self) -> Option<(f64, f64)> {
        let optics = self.optics?;
        let (low, high) = optics.heights()?;
        Some((low * optics.k, high * optics.k))
    }

    fn len(&self) -> usize {
        self.columns.iter().map(|c| c.amplitudes.len()).sum()
    }

    /// Adds a plane of the stack to the orders whose `q_z` is near it.
    fn add(&mut self, stack: &Stack, plane: &Plane<'_>) {
        let Some(optics) = self.optics else { return };
        let q_z = plane.q_z;
        if let Some(lit) = &mut self.lit {
            lit.aperture.add(plane.coefficients, q_z);
        }
        let reach = 0.5 * WIDTH as f64 * stack.kernel.distance;
        let Some((low, high)) = self.range() else { return };
        if q_z + reach < low || q_z - reach > high {
            return;
        }
        let ends = [(q_z - reach) / optics.k, (q_z + reach) / optics.k].map(|v| optics.cosine(v));
        let (low, high) = (ends[0].min(ends[1]).max(0.0), ends[0].max(ends[1]).min(1.0));
        if low > high {
            return;
        }
        let near = Near { stack, plane, optics, cosines: (low, high) };
        self.columns.par_iter_mut().for_each(|column| near.add(column));
    }

    /// The beam.
    pub fn beam(&self) -> &Beam {
        &self.beam
    }

    /// All orders.
    pub fn iter(&self) -> impl Iterator<Item = Order> + '_ {
        self.optics.into_iter().flat_map(move |optics| {
            self.columns.iter().flat_map(move |column| {
                (column.first_y..).zip(&column.amplitudes).flat_map(move |(y, a)| {
                    let order = self.order(&optics, [column.order_x, y], *a);
                    let mirrored = if self.halved && y > 0 { order } else { None };
                    [order, mirrored.map(Order::mirrored)].into_iter().flatten()
                })
            })
        })
    }

    fn order(&self, optics: &Optics, number: [isize; 2], a: Complex<f32>) -> Option<Order> {
        let t = optics.tangent([number[0] as f64 * self.step[0], number[1] as f64 * self.step[1]]);
        let cos2 = 1.0 - t[0] * t[0] - t[1] * t[1];
        if cos2 <= ALONG {
            return None;
        }
        let cos = cos2.sqrt();
        let wo = optics.direction(t, cos);
        let amplitude = Complex::new(f64::from(a.re), f64::from(a.im));
        let intensity = self.unit * amplitude.norm_sqr();
        let factor = optics.factor(wo);
        let power = match &self.lit {
            None => intensity * factor / cos,
            Some(lit) => {
                let half = self.step.map(|step| 0.5 * step / (optics.k * optics.n_o));
                let facet = (factor * mean_secant(t, half, cos2)).sqrt();
                let [.., upright] = shares(optics.half(number, self.step), optics.height(cos));
                let own =
                    OwnLight { amplitude, facet, upright, q_z: optics.k * optics.height(cos) };
                self.unit * lit.amplitude(&own, number, optics.negative).norm_sqr() / lit.incident
            }
        };
        Some(Order { number, wo, intensity, power })
    }

    /// Flux of the lobe and its coherent part, as fractions of the incident flux.
    pub fn totals(&self) -> (f64, f64) {
        let (all, middle) = self.iter().fold((0.0, 0.0), |(all, coherent), order| {
            (all + order.power, coherent + if order.is_specular() { order.power } else { 0.0 })
        });
        // the middle of a patch's light is a part of what keeps its direction
        (all, self.coherent().unwrap_or(middle))
    }

    /// Coherent flux of a patch, all of it however wide diffraction makes it, as a fraction of the incident flux; `None` of a surface
    /// that goes on, whose coherent light is its specular order.
    pub fn coherent(&self) -> Option<f64> {
        let lit = self.lit.as_ref()?;
        let q_z = self.optics.and_then(|optics| optics.specular()).map(|(_, q_z)| q_z);
        let signed = q_z.map_or(0.0, |q_z| lit.aperture.mean(q_z).norm_sqr());
        // the mean field is one over the doubled grid, four times the patch
        Some(16.0 * signed * lit.specular / lit.incident)
    }
}

/// An order of a patch, before the light that keeps its direction is told apart.
struct OwnLight {
    /// Its amplitude without the rim's diffraction.
    amplitude: Complex<f64>,
    /// Its factor at the stationary facet.
    facet: f64,
    /// `h_z^2 / |h|^2`.
    upright: f64,
    q_z: f64,
}

impl Lit {
    /// Amplitude whose square is the power of an order.
    fn amplitude(&self, own: &OwnLight, number: [isize; 2], negative: bool) -> Complex<f64> {
        let OwnLight { amplitude, facet, upright, q_z } = *own;
        if facet <= 0.0 {
            return Complex::default();
        }
        let number = if negative { number.map(|n| -n) } else { number };
        let Some(far) = self.aperture.far_field(number) else { return amplitude * facet };
        let mean = self.aperture.mean(q_z) * far;
        amplitude * facet + mean * (self.specular.sqrt() - facet * upright)
    }
}

impl Order {
    /// The same at the other side of the plane of incidence.
    fn mirrored(mut self) -> Self {
        let [x, y, z] = self.wo.xyz();
        self.number[1] = -self.number[1];
        self.wo = Direction::from_unit(x, -y, z);
        self
    }
}

/// A plane and the orders about it.
struct Near<'a> {
    stack: &'a Stack,
    plane: &'a Plane<'a>,
    optics: Optics,
    /// Range of `cos theta_o` that the plane serves.
    cosines: (f64, f64),
}

impl Near<'_> {
    fn add(&self, column: &mut Column) {
        let step = self.stack.step;
        let [tx, _] = self.optics.tangent([column.order_x as f64 * step[0], 0.0]);
        let (low, high) = self.cosines;
        let outer = 1.0 - low * low - tx * tx;
        if outer < 0.0 {
            return;
        }
        let (inner, outer) = ((1.0 - high * high - tx * tx).max(0.0).sqrt(), outer.sqrt());
        let order = |ty: f64| self.optics.momentum([tx, ty])[1] / step[1];
        if inner > 0.0 {
            let (a, b) = (order(-outer).ceil() as isize, order(-inner).floor() as isize);
            self.run(column, tx, a, b);
            let first = order(inner).ceil() as isize;
            // an order on the edge of both runs is added once
            self.run(column, tx, first.max(b + 1), order(outer).floor() as isize);
        } else {
            self.run(column, tx, order(-outer).ceil() as isize, order(outer).floor() as isize);
        }
    }

    fn run(&self, column: &mut Column, tx: f64, from: isize, to: isize) {
        let last = column.first_y + column.amplitudes.len() as isize - 1;
        let (from, to) = (from.max(column.first_y), to.min(last));
        let sign = if self.optics.negative { -1 } else { 1 };
        let values = self.plane.coefficients.column(sign * column.order_x);
        let per_plane = 1.0 / self.stack.kernel.distance;
        for order_y in from..=to {
            let [_, ty] = self.optics.tangent([0.0, order_y as f64 * self.stack.step[1]]);
            let cos2 = 1.0 - tx * tx - ty * ty;
            if cos2 < 0.0 {
                continue;
            }
            let height = self.optics.height(cos2.sqrt());
            let weight =
                self.stack.kernel.at((self.optics.k * height - self.plane.q_z) * per_plane);
            let at = place(sign * order_y, self.stack.size[1], self.stack.ends);
            let mut value = values[at];
            if let Some(rim) = &self.plane.rim {
                let number = [column.order_x, order_y];
                let [x, y, _] = shares(self.optics.half(number, self.stack.step), height);
                let [of_x, of_y] =
                    rim.at([place(sign * column.order_x, self.stack.size[0], self.stack.ends), at]);
                value -= of_x * x as f32 + of_y * y as f32;
            }
            column.amplitudes[(order_y - column.first_y) as usize] += value * weight;
        }
    }
}
