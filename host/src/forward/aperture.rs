//! Integration of a lobe over detector cones.
//!
//! In coordinates `theta` in the plane of incidence and `psi` out of it a solid angle is
//! `cos psi dpsi dtheta`, and the cone of half angle `a` about (`theta0`, 0) holds, at a given `psi`,
//! the interval `theta0 +- D(psi)` with `cos D = cos a / cos psi`. So a lobe is tabulated on a few
//! lines of constant `psi`, integrated along each once, and every reading is a sum of differences of
//! these integrals. Both coordinates are warped by sinh about the direction of the peak, with the
//! lobe's own width as their scale: a lobe a thousandth of the aperture wide costs little more than one
//! a hundred times wider.

use std::f64::consts::{FRAC_PI_2, PI};

use asperity_core::quadrature::gauss_legendre;

/// Lines of constant `psi` for a lobe narrower than the cone.
const NARROW_LINES: usize = 24;

/// The coordinate `theta` in [-pi/2, pi/2] as `centre + scale sinh v`, with a node at the centre.
#[derive(Clone, Debug)]
pub(super) struct Warp {
    centre: f64,
    scale: f64,
    /// `v` at both ends, and cells on both sides of the centre.
    ends: [f64; 2],
    cells: [usize; 2],
}

impl Warp {
    /// About a peak at `centre` (rad) of a width `scale` (rad), with so many cells per unit of `v`.
    ///
    /// The error of the integrals falls with the fourth power of the cells; 16 per unit leave about 1e-6.
    pub(super) fn new(centre: f64, scale: f64, cells_per_unit: f64) -> Self {
        let v = |theta: f64| asinh((theta - centre) / scale);
        let ends = [v(-FRAC_PI_2), v(FRAC_PI_2)];
        // multiples of eight, so that every eighth node is a node of the coarse table
        let cells = ends.map(|v| 8 * (v.abs() * cells_per_unit / 8.0).ceil().max(1.0) as usize);
        Self { centre, scale, ends, cells }
    }

    /// Number of cells.
    pub(super) fn cells(&self) -> usize {
        self.cells[0] + self.cells[1]
    }

    /// `v` at half cells: `half` counts half cells from the lower end.
    fn v(&self, half: usize) -> f64 {
        let position = half as f64 * 0.5 - self.cells[0] as f64;
        let side = usize::from(position > 0.0);
        self.ends[side] * (position.abs() / self.cells[side] as f64)
    }

    /// All half cells, from -pi/2 to pi/2.
    pub(super) fn nodes(&self) -> Vec<Node> {
        let node = |half: usize| {
            let e = self.v(half).exp();
            let (sinh, cosh) = (0.5 * (e - 1.0 / e), 0.5 * (e + 1.0 / e));
            let theta = (self.centre + self.scale * sinh).clamp(-FRAC_PI_2, FRAC_PI_2);
            Node { slope: self.scale * cosh, ..Node::at(theta) }
        };
        (0..=2 * self.cells()).map(node).collect()
    }

    /// A value at `theta` from values at half cells, by a cubic within each side of the centre.
    pub(super) fn interpolate(&self, at_half_cells: &[f64], theta: f64) -> f64 {
        let (cell, t) = self.locate(theta);
        let half = 2 * cell + usize::from(t > 0.5);
        let t = 2.0 * t - if t > 0.5 { 1.0 } else { 0.0 };
        // The spacing may change at the centre, and the lobe may have a cusp there: no cubic across.
        let centre = 2 * self.cells[0];
        let (first, last) = if half < centre { (0, centre) } else { (centre, 2 * self.cells()) };
        let at = |k: usize| at_half_cells.get(k).copied().unwrap_or(0.0);
        let (b, c) = (at(half), at(half + 1));
        let a = if half > first { at(half - 1) } else { 3.0 * (b - c) + at(half + 2) };
        let d = if half + 1 < last { at(half + 2) } else { 3.0 * (c - b) + at(half - 1) };
        cubic([a, b, c, d], t)
    }

    /// Cell and place in it, 0 to 1, of an angle.
    fn locate(&self, theta: f64) -> (usize, f64) {
        let v = asinh((theta - self.centre) / self.scale);
        let side = usize::from(v > 0.0);
        let n = self.cells[side] as f64;
        let along = (v / self.ends[side] * n).clamp(0.0, n);
        let position = if side == 1 { self.cells[0] as f64 + along } else { n - along };
        let cell = (position as usize).min(self.cells() - 1);
        (cell, position - cell as f64)
    }
}

/// A place in the plane of incidence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Angle of observation, rad.
    pub(super) theta: f64,
    /// Its sine and cosine.
    pub(super) sin_cos: (f64, f64),
    /// `d theta / dv` of the warp.
    pub(super) slope: f64,
}

impl Node {
    /// At an angle, of no warp.
    pub(super) fn at(theta: f64) -> Self {
        Self { theta, sin_cos: theta.sin_cos(), slope: 1.0 }
    }
}

/// Lagrange's cubic through four evenly spaced values, at `t` in [0, 1] between the middle two.
pub(super) fn cubic([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    let (p, q, r) = (t + 1.0, t - 1.0, t - 2.0);
    -t * q * r / 6.0 * a + p * q * r / 2.0 * b - p * t * r / 2.0 * c + p * t * q / 6.0 * d
}

/// Inverse hyperbolic sine to about 1e-15 absolute, cheaper than the library's.
pub(super) fn asinh(x: f64) -> f64 {
    let a = x.abs();
    (a + (a * a + 1.0).sqrt()).ln().copysign(x)
}

/// One line of constant `psi`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// Angle out of the plane, rad, >= 0; both signs are meant.
    pub(super) psi: f64,
    /// Half length `D` of the cone along the line, rad.
    reach: f64,
    /// The weight of the integral along the line in a reading.
    weight: f64,
}

/// What the detector's opening is: a cone, or a slit across the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Opening {
    /// Half the angle of a cone, or half the width of a slit, rad.
    pub(super) half_width: f64,
    /// Half the height of a slit, rad; `None` for a cone.
    half_height: Option<f64>,
}

impl Opening {
    pub(super) fn of(aperture_deg: f64, slit_height_deg: Option<f64>) -> Self {
        let half = |deg: f64| 0.5 * deg.to_radians();
        Self { half_width: half(aperture_deg), half_height: slit_height_deg.map(half) }
    }

    /// The largest angle from the axis along a line or across all lines, rad.
    pub(super) fn reach(&self) -> f64 {
        self.half_width.max(self.half_height.unwrap_or(0.0))
    }

    /// Whether it is a slit.
    pub(super) fn is_slit(&self) -> bool {
        self.half_height.is_some()
    }

    /// Whether a direction is in it: by its offsets in the plane and out of it for a slit, by its angle from the axis for a
    /// cone, rad. The rim counts.
    pub(super) fn contains(&self, [along, across]: [f64; 2], from_axis: f64) -> bool {
        let within = |x: f64, half: f64| x.abs() <= half * (1.0 + 1e-9);
        match self.half_height {
            None => within(from_axis, self.half_width),
            Some(half) => within(along, self.half_width) && within(across, half),
        }
    }

    /// A line; `weight` counts `psi` alone.
    fn line(&self, psi: f64, weight: f64) -> Line {
        let reach = match self.half_height {
            None => (self.half_width.cos() / psi.cos()).min(1.0).acos(),
            Some(_) => self.half_width,
        };
        Line { psi, reach, weight: weight * psi.cos() }
    }

    /// The lines where the density is smooth over the opening. Of a cone the three-point Gauss-Chebyshev rule of the second
    /// kind, whose weight is the chord itself; of a slit six points of Gauss and Legendre over its height.
    pub(super) fn smooth_lines(&self) -> Vec<Line> {
        let Some(height) = self.half_height else {
            let (a, x) = (self.half_width, std::f64::consts::FRAC_1_SQRT_2);
            return vec![self.line(0.0, a * PI / 4.0), self.line(a * x, a * PI / 4.0 / x)];
        };
        // both signs of psi are meant
        let of = |&(t, w): &(f64, f64)| self.line(height * t, 2.0 * w * height);
        gauss_legendre::<6>().iter().map(of).collect()
    }

    /// The lines for a lobe of width `scale` (rad), which may be far narrower than the opening: Gauss-Legendre in a warped
    /// coordinate dense at the plane.
    pub(super) fn narrow_lines(&self, scale: f64) -> Vec<Line> {
        let a = self.half_height.unwrap_or(self.half_width);
        let kappa = asinh(a / scale);
        let rule = gauss_legendre::<NARROW_LINES>();
        let one = |&(t, w): &(f64, f64)| {
            let tau = (kappa * t).sinh() / kappa.sinh();
            let slope = kappa * (kappa * t).cosh() / kappa.sinh();
            match self.half_height {
                // the chord of a cone ends like a root: no weight there
                None => {
                    let (s, c) = (FRAC_PI_2 * tau).sin_cos();
                    self.line(a * s, 2.0 * w * a * FRAC_PI_2 * c * slope)
                }
                Some(_) => self.line(a * tau, 2.0 * w * a * slope),
            }
        };
        rule.iter().map(one).collect()
    }
}

/// A lobe integrated along one line, up to every cell's lower end, with what is needed inside a cell.
#[derive(Debug)]
pub(super) struct Integral {
    /// Per cell: integral up to it, and the coefficients of the cubic inside.
    cells: Vec<[f64; 4]>,
}

impl Integral {
    /// From densities times `d theta / dv` at all half cells of the warp.
    pub(super) fn new(warp: &Warp, density: &[f64]) -> Self {
        let mut below = 0.0;
        let cells = density
            .windows(3)
            .step_by(2)
            .enumerate()
            .map(|(k, g)| {
                let side = usize::from(k >= warp.cells[0]);
                let h = warp.ends[side].abs() / warp.cells[side] as f64;
                // integral of the parabola through the three values
                let quadratic = 0.5 * (4.0 * g[1] - 3.0 * g[0] - g[2]);
                let cubic = (2.0 / 3.0) * (g[0] - 2.0 * g[1] + g[2]);
                let cell = [below, h * g[0], h * quadratic, h * cubic];
                below += cell[1] + cell[2] + cell[3];
                cell
            })
            .collect();
        Self { cells }
    }

    /// Integral from -pi/2 to `theta`.
    fn up_to(&self, warp: &Warp, theta: f64) -> f64 {
        let (cell, t) = warp.locate(theta);
        self.cells.get(cell).map_or(0.0, |c| c[0] + t * (c[1] + t * (c[2] + t * c[3])))
    }

    /// This line's part of the reading of a detector at `theta` (rad).
    pub(super) fn reading(&self, warp: &Warp, line: &Line, theta: f64) -> f64 {
        let from = (theta - line.reach).max(-FRAC_PI_2);
        let to = (theta + line.reach).min(FRAC_PI_2);
        line.weight * (self.up_to(warp, to) - self.up_to(warp, from))
    }
}

#[cfg(test)]
mod tests {
    use super::{Integral, Opening, Warp};
    use crate::forward::solid_angle;

    const CONE: Opening =
        Opening { half_width: 0.3 * std::f64::consts::PI / 180.0, half_height: None };

    fn reading(density: impl Fn(f64, f64) -> f64, peak: f64, scale: f64, theta: f64) -> f64 {
        in_opening(CONE, density, peak, scale, theta)
    }

    fn in_opening(
        opening: Opening,
        density: impl Fn(f64, f64) -> f64,
        peak: f64,
        scale: f64,
        theta: f64,
    ) -> f64 {
        let warp = Warp::new(peak, scale, 16.0);
        let wide = scale > 2.0 * opening.reach();
        let lines = if wide { opening.smooth_lines() } else { opening.narrow_lines(scale) };
        lines
            .iter()
            .map(|line| {
                let values: Vec<f64> =
                    warp.nodes().iter().map(|n| density(n.theta, line.psi) * n.slope).collect();
                Integral::new(&warp, &values).reading(&warp, line, theta)
            })
            .sum()
    }

    #[test]
    fn a_constant_gives_the_solid_angle_of_the_cone() {
        for scale in [1e-6, 1e-4, 1e-2, 0.3] {
            let got = reading(|_, _| 1.0, 0.3, scale, 0.2);
            assert!((got / solid_angle(0.6) - 1.0).abs() < 2e-3, "{scale} {got}");
        }
        let wide = reading(|_, _| 1.0, 0.3, 0.1, 0.2);
        assert!((wide / solid_angle(0.6) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_constant_gives_the_solid_angle_of_the_slit() {
        let opening = Opening::of(0.5, Some(8.0));
        let exact = 0.5_f64.to_radians() * 2.0 * 4.0_f64.to_radians().sin();
        for scale in [1e-4, 1e-2, 0.3] {
            let got = in_opening(opening, |_, _| 1.0, 0.3, scale, 0.2);
            assert!((got / exact - 1.0).abs() < 1e-5, "{scale} {got}");
        }
    }

    #[test]
    fn a_slit_holds_the_share_of_a_gaussian_that_error_functions_say() {
        let opening = Opening::of(0.5, Some(4.0));
        for width in [1e-4, 2e-3, 0.02, 0.1] {
            let lobe =
                |t: f64, p: f64| (-((t - 0.1).powi(2) + p * p) / (2.0 * width * width)).exp();
            for offset in [0.0, 0.003, 0.01] {
                let share = |from: f64, to: f64| {
                    let at = |x: f64| libm::erf(x / (width * std::f64::consts::SQRT_2));
                    width * (std::f64::consts::FRAC_PI_2).sqrt() * (at(to) - at(from))
                };
                let (w, h) = (opening.half_width, opening.reach());
                // cos psi counts as 1 - psi^2 / 2, at most 6e-4
                let exact = share(offset - w, offset + w) * share(-h, h);
                let got = in_opening(opening, lobe, 0.1, width, 0.1 + offset);
                let peak = share(-w, w) * share(-h, h);
                assert!((got - exact).abs() < 1e-3 * peak, "{width} {offset}: {got} {exact}");
            }
        }
    }

    #[test]
    fn a_narrow_lobe_is_held_whole_by_the_cone_it_points_into_and_missed_by_others() {
        for width in [1e-6, 1e-5, 1e-4, 1e-3] {
            // a lobe (1 + r^2/w^2)^-2 / (pi w^2) of unit flux; a share w^2 / (w^2 + a^2) lies outside
            let lobe = |t: f64, p: f64| {
                let q = 1.0 + ((t - 0.4) * (t - 0.4) + p * p) / (width * width);
                1.0 / (std::f64::consts::PI * width * width * q * q)
            };
            let a = 0.3_f64.to_radians();
            let held = reading(lobe, 0.4, width, 0.4);
            let exact = a * a / (a * a + width * width);
            assert!((held - exact).abs() < 1e-4, "{width} {held} {exact}");
            let missed = reading(lobe, 0.4, width, 0.4 + 2.0 * a);
            assert!(missed.abs() < width * width / (a * a) && missed >= 0.0, "{width} {missed}");
        }
    }

    #[test]
    fn a_wide_lobe_is_averaged_to_the_fourth_order() {
        // reading = solid angle times (g + a^2/8 laplacian): compared with a dense sum over the cone
        let lobe = |t: f64, p: f64| (-((t - 0.1) * (t - 0.1) + p * p) / (2.0 * 0.03 * 0.03)).exp();
        let a = 0.3_f64.to_radians();
        for theta in [0.1_f64, 0.115, 0.15] {
            let (mut sum, mut area) = (0.0, 0.0);
            let n = 800;
            for i in 0..n {
                for j in 0..n {
                    let u = a * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0);
                    let p = a * (2.0 * (f64::from(j) + 0.5) / f64::from(n) - 1.0);
                    if p.cos() * u.cos() >= a.cos() {
                        sum += lobe(theta + u, p) * p.cos();
                        area += p.cos();
                    }
                }
            }
            let got = reading(lobe, 0.1, 0.03, theta) / solid_angle(0.6);
            assert!((got / (sum / area) - 1.0).abs() < 1e-4, "{theta} {got} {}", sum / area);
        }
    }
}
