//! The light of a map, order by order: exact Kirchhoff for every direction of a periodic or mirrored surface.
//!
//! Such a surface scatters into discrete orders `q_xy`, and each order has a `q_z` of its own. The planes of a
//! stack over `q_z` are transformed one after the other, and every order takes up the planes about its
//! `q_z` ([`super::kernel`]); all beams share the stack. The error of an amplitude is 1e-5 of the field, beside the
//! rounding of f32. Cost: planes (the range of `q_z` times that of heights over 2 pi, half as many again)
//! times N log N.

use std::sync::atomic::AtomicBool;

use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;
use rayon::prelude::*;
use rustfft::num_complex::Complex;

use super::fft::{Coefficients, place};
use super::kernel::WIDTH;
use super::optics::{Beam, Optics};
use super::stack::{Stack, Tiling};
use crate::surface::{Edges, HeightMap, Incomplete};

/// Amplitudes that are in memory at once; more beams are worked on in turns.
const MOST_AMPLITUDES: usize = 96 << 20;

/// One order of a beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Its number along x and y, of the period, or of twice the size of a mirrored map.
    pub number: [isize; 2],
    /// Where it goes.
    pub wo: Direction<f64>,
    /// `|A|^2`: its share of the light without obliquity and Fresnel's factor.
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
}

/// Orders of one number along x.
#[derive(Clone, Debug)]
struct Column {
    order_x: isize,
    first_y: isize,
    amplitudes: Vec<Complex<f32>>,
}

/// The orders of several beams on a map, in their order; `None` if `stop` was set before the end.
///
/// `progress(done, all)` counts planes. The same bits for any number of threads.
///
/// # Errors
/// [`Incomplete`] if points of the map are missing.
pub fn orders(
    map: &HeightMap,
    tiling: impl Into<Tiling>,
    eta: RelativeIor<f64>,
    beams: &[Beam],
    stop: &AtomicBool,
    progress: &(dyn Fn(usize, usize) + Sync),
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
            let finished = stack.each(planes, stop, |plane, q_z| {
                for beam in &mut group {
                    beam.add(&stack, plane, q_z);
                }
                now += 1;
                progress(now, all);
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
        let halved = stack.edges == Edges::Mirrored && beam.wi.y().abs() <= 0.0;
        let (columns, step, unit) = (Vec::new(), stack.step, stack.unit);
        let mut this = Self { beam, optics, columns, step, unit, halved };
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
    fn add(&mut self, stack: &Stack, plane: &Coefficients<f32>, q_z: f64) {
        let Some(optics) = self.optics else { return };
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
        let near = Near { stack, plane, optics, q_z, cosines: (low, high) };
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
                    let intensity = self.unit * f64::from(a.norm_sqr());
                    let order = self.order(&optics, [column.order_x, y], intensity);
                    let mirrored = if self.halved && y > 0 { order } else { None };
                    [order, mirrored.map(Order::mirrored)].into_iter().flatten()
                })
            })
        })
    }

    fn order(&self, optics: &Optics, number: [isize; 2], intensity: f64) -> Option<Order> {
        let [x, y] =
            optics.tangent([number[0] as f64 * self.step[0], number[1] as f64 * self.step[1]]);
        let sine2 = x * x + y * y;
        let cos2 = 1.0 - sine2;
        if cos2 <= 0.0 {
            return None;
        }
        let cos = cos2.sqrt();
        let wo = optics.direction([x, y], cos);
        let inverse = if number == [0, 0] {
            1.0 / cos
        } else {
            // near the horizon 1 / cos changes within the cell that an order stands for
            let half = 0.25 * (self.step[0] + self.step[1]) / (optics.k * optics.n_o);
            mean_secant(sine2.sqrt(), half)
        };
        let power = intensity * optics.factor(wo) * inverse;
        Some(Order { number, wo, intensity, power })
    }

    /// Flux of the lobe and its coherent part, as fractions of the incident flux.
    pub fn totals(&self) -> (f64, f64) {
        self.iter().fold((0.0, 0.0), |(all, coherent), order| {
            (all + order.power, coherent + if order.is_specular() { order.power } else { 0.0 })
        })
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

/// `1 / cos` averaged over sines within `half` of `sine`.
fn mean_secant(sine: f64, half: f64) -> f64 {
    let (low, high) = ((sine - half).max(-1.0), (sine + half).min(1.0));
    (high.asin() - low.asin()) / (2.0 * half)
}

/// A plane and the orders about it.
struct Near<'a> {
    stack: &'a Stack,
    plane: &'a Coefficients<f32>,
    optics: Optics,
    q_z: f64,
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
        let values = self.plane.column(sign * column.order_x);
        let per_plane = 1.0 / self.stack.kernel.distance;
        for order_y in from..=to {
            let [_, ty] = self.optics.tangent([0.0, order_y as f64 * self.stack.step[1]]);
            let cos2 = 1.0 - tx * tx - ty * ty;
            if cos2 < 0.0 {
                continue;
            }
            let q_z = self.optics.k * self.optics.height(cos2.sqrt());
            let weight = self.stack.kernel.at((q_z - self.q_z) * per_plane);
            let at = place(sign * order_y, self.stack.size[1], self.stack.edges);
            column.amplitudes[(order_y - column.first_y) as usize] += values[at] * weight;
        }
    }
}
