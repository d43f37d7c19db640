//! The Kirchhoff integral by brute force: one sum over all points for one pair of directions.

use std::f64::consts::TAU;

use crate::oracle::fresnel;
use asperity::surface::{Edges, HeightMap};
use asperity_core::direction::Direction;

/// Refractive index of the medium a direction lies in.
fn index(eta: f64, w: Direction<f64>) -> f64 {
    if w.z() > 0.0 { 1.0 } else { eta }
}

/// `n_i wi + n_o wo`.
fn half(eta: f64, wi: Direction<f64>, wo: Direction<f64>) -> [f64; 3] {
    let (i, o) = (wi.xyz(), wo.xyz());
    [0, 1, 2].map(|k| index(eta, wi) * i[k] + index(eta, wo) * o[k])
}

/// `|A|^2` of the periodic surface that the map, or the map and its mirror images, make.
pub fn intensity(
    map: &HeightMap,
    edges: Edges,
    eta: f64,
    wavelength_um: f64,
    (wi, wo): (Direction<f64>, Direction<f64>),
) -> f64 {
    let q = half(eta, wi, wo).map(|h| h * TAU / wavelength_um);
    let copies: &[[bool; 2]] = match edges {
        Edges::Periodic => &[[false, false]],
        Edges::Mirrored => &[[false, false], [true, false], [false, true], [true, true]],
    };
    let (mut re, mut im) = (0.0, 0.0);
    for (col, row, h) in map.points() {
        for [across_x, across_y] in copies {
            let place =
                |k: usize, n: usize, turned: bool| if turned { 2 * n - 1 - k } else { k } as f64;
            let x = map.dx_um() * place(col, map.nx(), *across_x);
            let y = map.dy_um() * place(row, map.ny(), *across_y);
            let phase = q[0] * x + q[1] * y + q[2] * h;
            re += phase.cos();
            im -= phase.sin();
        }
    }
    let n = (map.nx() * map.ny() * copies.len()) as f64;
    (re * re + im * im) / (n * n)
}

/// `ars / ((k n_o)^2 D)`: a single facet of \[Walter2007, eqs 20, 21\] with G = 1, its density of normals
/// `p / cos^4` that of slopes `p = D q_z^2`.
pub fn obliquity(eta: f64, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
    let (n_i, n_o) = (index(eta, wi), index(eta, wo));
    let h = half(eta, wi, wo);
    let length = (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]).sqrt();
    let mut m = h.map(|x| x / length);
    let mirrored = wi.z() * wo.z() > 0.0;
    // on the side of the light
    if m[2] * wi.z() < 0.0 {
        m = m.map(|x| -x);
    }
    let dot = |w: Direction<f64>| w.x() * m[0] + w.y() * m[1] + w.z() * m[2];
    let (i_m, o_m) = (dot(wi), dot(wo));
    if i_m <= 0.0 || (o_m > 0.0) != mirrored {
        return 0.0;
    }
    let other = if wi.z() > 0.0 { eta } else { 1.0 / eta };
    let reflected = fresnel(i_m.min(1.0), other).unpolarised();
    let normals = h[2] * h[2] / m[2].powi(4);
    let jacobian = if mirrored {
        1.0 / (4.0 * i_m)
    } else {
        n_o * n_o * -o_m / (n_i * i_m + n_o * o_m).powi(2)
    };
    let share = if mirrored { reflected } else { 1.0 - reflected };
    share * i_m * jacobian * normals / (wi.z().abs() * n_o * n_o)
}

/// What one order of a map that alone is lit is made of, by a sum over its tangent planes.
#[derive(Clone, Copy, Debug)]
pub struct LitOrder {
    /// `h_z / |h|^2` times the mean of `h.N exp(-i q.r)`, real and imaginary, `N = (-slope, 1)`.
    pub amplitude: [f64; 2],
    /// The mean field times the far field of the lit area.
    pub kept: [f64; 2],
    /// `h_z^2 / |h|^2`.
    pub upright: f64,
}

/// An order of a map that alone is lit, its slopes known at `(x, y)` in um: nothing is done by parts, so nothing is known of a rim.
pub fn lit_order(
    map: &HeightMap,
    slope: impl Fn(f64, f64) -> [f64; 2],
    eta: f64,
    wavelength_um: f64,
    (wi, wo): (Direction<f64>, Direction<f64>),
) -> LitOrder {
    let h = half(eta, wi, wo);
    let q = h.map(|h| h * TAU / wavelength_um);
    let square: f64 = h.iter().map(|h| h * h).sum();
    let (mut planes, mut mean, mut area) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    let n = (map.nx() * map.ny()) as f64;
    let add = |sum: &mut [f64; 2], weight: f64, phase: f64| {
        sum[0] += weight * phase.cos() / n;
        sum[1] -= weight * phase.sin() / n;
    };
    for (col, row, height) in map.points() {
        let (x, y) = (map.dx_um() * col as f64, map.dy_um() * row as f64);
        let [along, across] = slope(x, y);
        let plane = h[2] - h[0] * along - h[1] * across;
        let flat = q[0] * x + q[1] * y;
        add(&mut planes, plane * h[2] / square, flat + q[2] * height);
        add(&mut mean, 1.0, q[2] * height);
        add(&mut area, 1.0, flat);
    }
    let kept = [mean[0] * area[0] - mean[1] * area[1], mean[0] * area[1] + mean[1] * area[0]];
    LitOrder { amplitude: planes, kept, upright: h[2] * h[2] / square }
}
