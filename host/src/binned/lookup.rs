//! Values, densities and samples of a table, at any pair of directions.

use asperity_core::bsdf::{Bsdf, Lobe, Scatter, Scattered};
use asperity_core::direction::{Direction, Side};

use super::bins::{BinnedLobe, Estimate};
use super::disc::Shift;
use super::{Azimuth, BinnedBsdf, SideTable, Totals, of_lobe};

/// A tabulated lobe near an incidence: its share and its displacement.
struct Corner<'a> {
    lobe: &'a BinnedLobe,
    weight: f64,
    shift: Shift,
}

/// The lobes and weights of an incidence.
struct Blend<'a> {
    corners: [Option<Corner<'a>>; 4],
    /// Cosine and sine of the azimuth by which the table is turned.
    turned: [f64; 2],
}

impl BinnedBsdf {
    /// Hemispherical totals of light from `wi`; 0 in the surface, and on a side that was not tabulated.
    pub fn totals(&self, wi: Direction<f64>) -> Totals {
        let of = |lobe| {
            let Some(blend) = self.blend(wi, lobe) else { return Estimate::default() };
            let variance = |c: &Corner| (c.weight * c.lobe.total().std_error).powi(2);
            Estimate {
                value: blend.total(),
                std_error: blend.corners().map(variance).sum::<f64>().sqrt(),
            }
        };
        Totals { reflected: of(Lobe::Reflection), transmitted: of(Lobe::Transmission) }
    }

    /// Standard error of `f`, 1/sr, from the number of rays; what interpolation and the size of the bins add
    /// is not in it.
    pub fn std_error(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        let Some((blend, point)) = self.between(wi, wo) else { return 0.0 };
        let mut variance = 0.0;
        for corner in blend.corners() {
            corner.shift.origins(point, |p| {
                variance += (corner.weight * corner.lobe.std_error(p)).powi(2);
            });
        }
        variance.sqrt()
    }

    /// The lobes about an incidence; `None` in the surface, and where nothing was tabulated.
    fn blend(&self, wi: Direction<f64>, lobe: Lobe) -> Option<Blend<'_>> {
        let side = wi.side()?;
        let [x, y, z] = wi.xyz();
        let sine = x.hypot(y);
        if !(sine.is_finite() && z.is_finite()) {
            return None;
        }
        // tangential component of the far direction for one of the near
        let gain = match (lobe, side) {
            (Lobe::Reflection, _) => 1.0,
            (Lobe::Transmission, Side::Air) => self.eta.inverse(),
            (Lobe::Transmission, Side::Dielectric) => self.eta.get(),
        };
        let along = if sine > 0.0 { [-x / sine, -y / sine] } else { [1.0, 0.0] };
        let table = self.side(side);
        let incidences = bracket(&table.angles, sine.atan2(z.abs()))?;
        // the azimuths about it: number, share, and the way the light goes there, as seen in the table
        let (azimuths, target, turned) = match &self.azimuth {
            Azimuth::Isotropic => ([(0, 1.0, [1.0, 0.0]), (0, 0.0, [1.0, 0.0])], [1.0, 0.0], along),
            Azimuth::Fixed(degrees) => {
                let at = |(number, weight): (usize, f64)| {
                    let (s, c) = degrees[number].to_radians().sin_cos();
                    (number, weight, [c, s])
                };
                let azimuth = along[1].atan2(along[0]).to_degrees().rem_euclid(360.0);
                (around(degrees, azimuth)?.map(at), along, [1.0, 0.0])
            }
        };
        let corner = |k: usize| {
            let (row, share) = incidences[k / 2];
            let (column, of_azimuth, towards) = azimuths[k % 2];
            let weight = share * of_azimuth;
            let there = table.angles[row].sin();
            let shift = [0, 1].map(|k| gain * (sine * target[k] - there * towards[k]));
            (weight > 0.0).then(|| Corner {
                lobe: of_lobe(&table.beams[row * self.azimuths() + column], lobe),
                weight,
                shift: Shift::by(shift),
            })
        };
        Some(Blend { corners: [corner(0), corner(1), corner(2), corner(3)], turned })
    }

    /// The lobes about a pair of directions, and `wo` as a point of the table's disc.
    fn between(&self, wi: Direction<f64>, wo: Direction<f64>) -> Option<(Blend<'_>, [f64; 2])> {
        let lobe = if wo.side()? == wi.side()? { Lobe::Reflection } else { Lobe::Transmission };
        let [x, y, _] = wo.xyz();
        let blend = self.blend(wi, lobe)?;
        let [c, s] = blend.turned;
        let point = [x * c + y * s, y * c - x * s];
        point.iter().all(|p| p.is_finite()).then_some((blend, point))
    }

    /// Typical slope of the facets, from the width of the reflected lobe nearest to the normal.
    pub(super) fn find_slope(&self) -> f64 {
        let width = |table: &SideTable| {
            let angle = *table.angles.first()?;
            let lobe = of_lobe(table.beams.first()?, Lobe::Reflection);
            let (sin, cos) = match &self.azimuth {
                Azimuth::Isotropic => (0.0, 1.0),
                Azimuth::Fixed(degrees) => degrees.first()?.to_radians().sin_cos(),
            };
            let (s, c) = angle.sin_cos();
            // two directions, and a reflected ray turns by twice what the facet does
            let spread = lobe.spread([s * cos, s * sin]) / (2.0 * c * std::f64::consts::SQRT_2);
            (spread > 0.0).then_some(spread)
        };
        self.sides.iter().find_map(width).unwrap_or(0.1).clamp(1e-6, 10.0)
    }
}

impl<'a> Blend<'a> {
    fn corners(&self) -> impl Iterator<Item = &Corner<'a>> {
        self.corners.iter().flatten()
    }

    /// Flux of the lobe.
    fn total(&self) -> f64 {
        self.corners().map(|c| c.weight * c.lobe.total().value).sum()
    }

    /// `f` at a point of the table's disc, 1/sr.
    fn value(&self, point: [f64; 2]) -> f64 {
        let mut sum = 0.0;
        for corner in self.corners() {
            corner.shift.origins(point, |p| sum += corner.weight * corner.lobe.value(p));
        }
        sum
    }

    /// A direction of the lobe on a side, from two uniforms.
    fn draw(&self, side: Side, [u, v]: [f64; 2]) -> Option<Direction<f64>> {
        let mut rest = u * self.total();
        for corner in self.corners() {
            let share = corner.weight * corner.lobe.total().value;
            if rest < share {
                let drawn = corner.lobe.draw([rest / share, v])?;
                let [x, y] = corner.shift.of(drawn);
                let [c, s] = self.turned;
                let [x, y] = [x * c - y * s, y * c + x * s];
                let z = (1.0 - (x * x + y * y)).max(0.0).sqrt();
                let z = if side == Side::Air { z } else { -z };
                return (z.abs() > 0.0).then(|| Direction::from_unit(x, y, z));
            }
            rest -= share;
        }
        None
    }
}

/// The two numbers about `x` in an ascending list, and their shares; the end of the list beyond it.
fn bracket(list: &[f64], x: f64) -> Option<[(usize, f64); 2]> {
    let last = list.len().checked_sub(1)?;
    let above = list.partition_point(|a| *a < x).min(last);
    let below = above.saturating_sub(1);
    let width = list[above] - list[below];
    let share = if width > 0.0 { ((x - list[below]) / width).clamp(0.0, 1.0) } else { 1.0 };
    Some([(above, share), (below, 1.0 - share)])
}

/// The same on a circle of 360 degrees.
fn around(list: &[f64], x: f64) -> Option<[(usize, f64); 2]> {
    let last = list.len().checked_sub(1)?;
    let above = list.partition_point(|a| *a < x);
    let (above, below) = if above == 0 || above > last { (0, last) } else { (above, above - 1) };
    let width = (list[above] - list[below]).rem_euclid(360.0);
    let share = if width > 0.0 { (x - list[below]).rem_euclid(360.0) / width } else { 1.0 };
    let share = share.clamp(0.0, 1.0);
    Some([(above, share), (below, 1.0 - share)])
}

impl Scatter<f64> for BinnedBsdf {
    /// Chooses a lobe by its flux, a tabulated lobe by its share, a bin by its flux and a place in it; the weight
    /// is 1, and what neither is reflected nor transmitted is lost.
    ///
    /// Takes three uniforms.
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        let choice = uniform();
        let u = [uniform(), uniform()];
        let reflected = self.blend(wi, Lobe::Reflection)?;
        let share = reflected.total();
        let side = wi.side()?;
        let wo = if choice < share {
            reflected.draw(side, u)
        } else {
            let through = self.blend(wi, Lobe::Transmission)?;
            if choice >= share + through.total() {
                return None;
            }
            through.draw(opposite(side), u)
        };
        wo.map(|wo| Scattered { wo, weight: 1.0 })
    }
}

fn opposite(side: Side) -> Side {
    match side {
        Side::Air => Side::Dielectric,
        Side::Dielectric => Side::Air,
    }
}

impl Bsdf<f64> for BinnedBsdf {
    fn eval(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.between(wi, wo).map_or(0.0, |(blend, point)| blend.value(point))
    }

    /// That of the samples is `ars`: their weight is 1.
    fn pdf(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        self.ars(wi, wo)
    }

    /// The weight is the flux of the lobe.
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        let side = wi.side()?;
        let blend = self.blend(wi, lobe)?;
        let to = if lobe == Lobe::Reflection { side } else { opposite(side) };
        Some(Scattered { wo: blend.draw(to, u)?, weight: blend.total() })
    }

    fn slope(&self) -> f64 {
        self.slope
    }
}
