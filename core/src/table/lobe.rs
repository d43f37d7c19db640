//! One lobe from one side: its values, and the quantiles it is sampled with.

use super::axes::{
    GAIN_STEPS, INWARDS, Incidence, Place, cells, incidence_place, real, steps, whole,
};
use super::error::TableError;
use super::storage::Storage;
use crate::direction::Direction;
use crate::math::Real;
use crate::ndf::ggx::shadow_sum;

/// The factors divided out of a lobe, and the coordinates of its look-up. `S = |wi.m| J F` is the exact share of one
/// facet: its Fresnel factor
/// (reflected or transmitted), its Jacobian `J = d omega_m / d omega_o` and its projection on `wi`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `f = 4 Q S / (M(wi) M(wo))` with `M = |cos| + sqrt(cos^2 + a^2 sin^2)`, which is Smith's masking of GGX facets of
    /// width `a` \[Walter2007, eq. 34\]: exact for them, near for what facets of any law hide from each other, and
    /// `f = Q S / |cos_i cos_o|`, facets met in proportion to their projected area (Kirchhoff's waves), for `a` = 0.
    Masked,
    /// `f = Q S / (|wi.m| |cos_o|)`: facets met in proportion to their number (the method `normals`).
    Drawn,
    /// `f = Q / (M(wi) M(wo))`, and in place of the facet's slope the length of `h_xy = n_i wi_xy + n_o wo_xy`, how far
    /// the light leaves from the mirror direction or Snell's; in reflection without the index they share. For light
    /// that has met several facets, which also goes where none alone leads.
    Direct,
}

impl Form {
    /// The number that stands for it in C and on the device.
    pub const fn number(self) -> u16 {
        match self {
            Self::Masked => 0,
            Self::Drawn => 1,
            Self::Direct => 2,
        }
    }

    /// The form of a number; `None` if there is none.
    #[inline(always)]
    pub const fn of_number(number: u16) -> Option<Self> {
        match number {
            0 => Some(Self::Masked),
            1 => Some(Self::Drawn),
            2 => Some(Self::Direct),
            _ => None,
        }
    }
}

/// The fall of the tail of `Q`: `Q = v^2 q^n` with `q = s0 / (s0^2 cos^2 + sin^2)` of the facet's polar angle,
/// so `v` is constant for GGX facets (`n` = 2), `1/s^2` tails (`n` = 1), or as `Q` itself (`n` = 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fall {
    /// `n` = 0.
    Flat,
    /// `n` = 1.
    Second,
    /// `n` = 2.
    Fourth,
}

impl Fall {
    /// `2 n`, the power of the slope, which stands for it in files, in C and on the device.
    pub const fn number(self) -> u16 {
        match self {
            Self::Flat => 0,
            Self::Second => 2,
            Self::Fourth => 4,
        }
    }

    /// The fall of a number; `None` if there is none.
    #[inline(always)]
    pub const fn of_number(number: u16) -> Option<Self> {
        match number {
            0 => Some(Self::Flat),
            2 => Some(Self::Second),
            4 => Some(Self::Fourth),
            _ => None,
        }
    }
}

/// Numbers of nodes; each at least 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Of incidence.
    pub incidences: u16,
    /// Of the azimuth's cosine.
    pub azimuths: u16,
    /// Of the radius.
    pub radii: u16,
    /// Intervals of equal probability that samples are drawn from; at least 1.
    pub intervals: u16,
}

impl Shape {
    /// Number of values.
    pub const fn values(self) -> usize {
        self.incidences as usize * self.azimuths as usize * self.radii as usize
    }
    /// Number of gains: between nodes of incidence there are [`GAIN_STEPS`].
    pub const fn gains(self) -> usize {
        (self.incidences as usize * GAIN_STEPS as usize + 1).saturating_sub(GAIN_STEPS as usize)
    }
    /// [`cells`](super::cells) of gains, of azimuths on each half of the cosine's range, of radii, and of samples.
    pub const fn cells(self) -> [f32; 4] {
        [
            steps(self.incidences, GAIN_STEPS as f32),
            steps(self.azimuths, 0.5),
            cells(self.radii),
            self.intervals as f32 * INWARDS,
        ]
    }
    /// Number of quantiles.
    pub const fn quantiles(self) -> usize {
        self.incidences as usize * (self.intervals as usize + 1)
    }
    /// Number of leans.
    pub const fn leans(self) -> usize {
        self.incidences as usize * self.intervals as usize
    }
}

/// A lobe; a view of arrays that may lie in flash.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeTable<'a, S> {
    /// Numbers of nodes.
    pub shape: Shape,
    /// The factors divided out.
    pub form: Form,
    /// The fall of the tail.
    pub fall: Fall,
    /// `s0`, the scale of slopes, or of `|h_xy|` of [`Form::Direct`].
    pub scale: f32,
    /// `k`, by which nodes of incidence crowd: towards the normal above 0, towards grazing below.
    pub grazing: f32,
    /// `a` of [`Form::Masked`].
    pub masking: f32,
    /// The value of the square of a stored unit, linear between steps of incidence: with it the flux is that of the model.
    pub gains: &'a [f32],
    /// [`Shape::cells`], which every look-up needs.
    pub cells: [f32; 4],
    /// What a sample stands for, but for its interval, its slope and its azimuth, which every one needs.
    pub unit: f32,
    /// `v`: radii run fastest, then azimuths, then incidences.
    pub values: &'a [S],
    /// `r^2` in units of 1/65536, strictly ascending from 0 within each incidence.
    pub quantiles: &'a [u16],
    /// Mean of the azimuth's cosine in each interval, in units of 1/128.
    pub leans: &'a [i8],
}

/// Four times what a sample stands for in a lobe of a scale of slopes, but for its interval, its slope and its azimuth:
/// `dt = 2 r dr`, `d omega = s ds cos^3`, `ds = s0 / (1 - r)^2 dr`; a quarter of one over the density of [`half_angle`].
#[inline(always)]
pub(super) const fn unit(shape: Shape, scale: f32) -> f32 {
    let [.., intervals] = shape.cells();
    intervals * (scale * scale)
}

/// A facet drawn from a lobe.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn<T> {
    /// Cosine of its azimuth against the mirror direction.
    pub(super) p: T,
    /// Sine of it.
    pub(super) across: T,
    /// `r`.
    pub(super) r: T,
    /// Sine and cosine of its polar angle.
    pub(super) sin: T,
    pub(super) cos: T,
    /// Four times `Q` at `v` = 1 and the gain there, times the solid angle of normals a sample stands for: one over their density.
    pub(super) room: T,
}

/// `v^2 s0^2` at most, or `v^2` if that is less. A lobe no narrower than `w` scales that holds all light has a peak of `Q` of
/// `1 / (pi w^2 s0^2)`, and where a tail is as bright as a broad lobe `v^2` is about `1 / s0^2`; this leaves a margin of 1e5.
const STEEPEST: f32 = 1e6;

impl<S: Storage> LobeTable<'_, S> {
    /// Checks numbers against lengths and domains.
    pub(super) fn check(&self) -> Result<(), TableError> {
        let Shape { incidences, azimuths, radii, intervals } = self.shape;
        if incidences < 2 || azimuths < 2 || radii < 2 || intervals < 1 {
            return Err(TableError::Shape);
        }
        let lengths = self.gains.len() == self.shape.gains()
            && self.values.len() == self.shape.values()
            && self.quantiles.len() == self.shape.quantiles()
            && self.leans.len() == self.shape.leans()
            && self.cells.map(f32::to_bits) == self.shape.cells().map(f32::to_bits)
            && self.unit.to_bits() == unit(self.shape, self.scale).to_bits();
        if !lengths {
            return Err(TableError::Length);
        }
        let fine = |x: f32, least: f32, most: f32| (least..=most).contains(&x);
        let most = STEEPEST * (1.0 / (self.scale * self.scale)).max(1.0);
        let numbers = fine(self.scale, 1e-7, 1e4)
            && fine(self.grazing, -0.95, 100.0)
            && fine(self.masking, 0.0, 1e4)
            && self.gains.iter().all(|&g| fine(g * S::FULL * S::FULL, 0.0, most))
            && self.values.iter().all(|v| fine(v.get::<f32>(), 0.0, S::FULL));
        if !numbers {
            return Err(TableError::Number);
        }
        let row = usize::from(intervals) + 1;
        let ascends = |row: &[u16]| {
            row.first() == Some(&0) && row.windows(2).all(|w| matches!(w, [a, b] if a < b))
        };
        let leans = self.leans.iter().all(|l| l.unsigned_abs() <= 125);
        if self.quantiles.chunks(row).all(ascends) && leans {
            Ok(())
        } else {
            Err(TableError::Quantiles)
        }
    }

    /// `|cos_o| / (M(wi) M(wo))` of [`Form::Masked`].
    #[inline(always)]
    pub(super) fn unmasked<T: Real>(&self, wi: Direction<T>, wo: Direction<T>) -> T {
        let a: T = real(self.masking);
        let sums = shadow_sum(a, wi.xyz()) * shadow_sum(a, wo.xyz());
        wo.z().abs() / (sums + T::MIN_POSITIVE)
    }

    /// Where an incidence lies, by its sine and cosine.
    #[inline(always)]
    pub(super) fn incidence<T: Real>(&self, s: T, c: T) -> Option<Incidence<T>> {
        let [steps, ..] = self.cells;
        Incidence::of(incidence_place(s, c, real(self.grazing)), steps, self.gains)
    }

    /// `v^2` at an incidence, an azimuth's cosine and a radius, but for its gain; `None` only for places that no table has.
    #[inline(always)]
    pub(super) fn square<T: Real>(&self, y: Place<T>, p: T, r: T) -> Option<T> {
        let Shape { azimuths, radii, .. } = self.shape;
        let [_, around, outwards, _] = self.cells;
        let p = Place::of(T::ONE + p, around);
        let r = Place::of(r, outwards);
        let (rows, columns) = (usize::from(azimuths), usize::from(radii));
        let plane = rows * columns;
        let at = (y.cell * rows + p.cell) * columns + r.cell;
        // one block of both incidences, so that its length is looked at once
        let block = self.values.get(at..)?.get(..plane + columns + 2)?;
        let pair = |at: usize| -> Option<T> {
            let (a, b) = (*block.get(at)?, *block.get(at + 1)?);
            Some(r.mix(a.get(), b.get()))
        };
        let low = p.mix(pair(0)?, pair(columns)?);
        let high = p.mix(pair(plane)?, pair(plane + columns)?);
        Some(y.mix(low * low, high * high))
    }

    /// `Q` from `v^2` and `q`.
    #[inline(always)]
    pub(super) fn shaped<T: Real>(&self, v2: T, q: T) -> T {
        match self.fall {
            Fall::Fourth => v2 * q * q,
            Fall::Second => v2 * q,
            Fall::Flat => v2,
        }
    }

    /// Ends of interval `k` in units of 1/65536 of `r^2`.
    #[inline(always)]
    fn ends<T: Real>(&self, y: Place<T>, k: usize) -> Option<[T; 2]> {
        let row = usize::from(self.shape.intervals) + 1;
        let at = y.cell * row + k;
        // both incidences in one piece: their ends are its ends
        let both = self.quantiles.get(at..)?.get(..row + 2)?;
        let (&[a, b], &[c, d]) = (both.first_chunk()?, both.last_chunk()?);
        Some([y.mix(whole(a), whole(c)), y.mix(whole(b), whole(d))])
    }

    /// Lean of interval `k`, of the nearer incidence.
    #[inline(always)]
    fn lean<T: Real>(&self, y: Incidence<T>, k: usize) -> Option<T> {
        let lean = self.leans.get(y.nearest * usize::from(self.shape.intervals) + k)?;
        Some(T::from_f64(f64::from(*lean)) * T::from_f64(1.0 / 128.0))
    }

    /// A facet from two uniforms: `u[0]` its azimuth, `u[1]` its slope.
    #[inline(always)]
    pub(super) fn draw<T: Real>(&self, y: Incidence<T>, u: [T; 2]) -> Option<Drawn<T>> {
        let [.., intervals] = self.cells;
        let scaled = u[1] * real(intervals);
        let k = scaled.to_index();
        let [a, b] = self.ends(y.place, k)?;
        let lean = self.lean(y, k)?;
        let t = (a + (scaled - T::from_index(k as u32)) * (b - a)) * T::from_f64(1.0 / 65536.0);
        let w = T::TWO * u[0] - T::ONE;
        let (w2, [c, s]) = (w * w, half_angle(w, lean));
        let (c2, s2) = (c * c, s * s);
        let over = T::ONE / (c2 + s2);
        let r = t.abs().sqrt();
        let s0: T = real(self.scale);
        let (x, z) = (s0 * r, T::ONE - r);
        let (z2, length2) = (z * z, x * x + z * z);
        let length = length2.sqrt();
        let inverse = T::ONE / length;
        // q = length^2 even, from sin^2 and cos^2 with their common divisor; its power over the cube of the length
        let even = T::ONE / (s0 * (z2 + t));
        let tail = match self.fall {
            Fall::Fourth => length * even * even,
            Fall::Second => inverse * even,
            Fall::Flat => inverse * inverse * inverse,
        };
        let room = real::<T>(self.unit) * (b - a) * over * spread(w2, lean);
        Some(Drawn {
            p: (c2 - s2) * over,
            across: (c + c) * s * over,
            r,
            sin: x * inverse,
            cos: z * inverse,
            room: room * y.gain * tail,
        })
    }

    /// Density of [`Self::draw`] per solid angle, for a facet of radius `r`, azimuth's cosine `p` and polar cosine `cos_m`.
    pub(super) fn density<T: Real>(&self, y: Incidence<T>, p: T, r: T, cos_m: T) -> T {
        let t = r * r * T::from_f64(65536.0);
        let count = usize::from(self.shape.intervals);
        // bisection: the last interval that starts at or below t
        let (mut low, mut high) = (0, count);
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            match self.ends(y.place, middle) {
                Some([a, _]) if a <= t => low = middle,
                _ => high = middle,
            }
        }
        let Some([a, b]) = self.ends(y.place, low).filter(|[_, b]| t < *b) else {
            return T::ZERO;
        };
        let Some(lean) = self.lean(y, low) else { return T::ZERO };
        // the number that draws this azimuth: the positive root of k w / (1 - w^2) = sin / cos
        let (cos, sin) = ((T::ONE + p).sqrt_positive(), (T::ONE - p).sqrt_positive());
        let k = T::from_f64(core::f64::consts::SQRT_2) * (T::ONE - lean) / (T::ONE + lean);
        let w =
            T::TWO * sin / (k * cos + (k * k * (T::ONE + p) + T::from_f64(4.0) * sin * sin).sqrt());
        let [x, y] = half_angle(w, lean);
        let ratio = (T::ONE - r) / cos_m;
        (x * x + y * y) * (ratio * ratio * ratio)
            / (T::from_f64(0.25) * real(self.unit) * (b - a) * spread(w * w, lean))
    }
}

/// Cosine and sine, but for a factor, of half an azimuth from `w` in [-1, 1): `tan(phi / 2) = k w / (1 - w^2)`.
///
/// With `k` = sqrt 2 that is within 10 % of an even law of azimuths without a sine or cosine, and a lean shrinks the tangent, which
/// turns the even law into the wrapped Cauchy law whose mean cosine it is.
#[inline(always)]
fn half_angle<T: Real>(w: T, lean: T) -> [T; 2] {
    [
        (T::ONE - w * w) * (T::ONE + lean),
        T::from_f64(core::f64::consts::SQRT_2) * w * (T::ONE - lean),
    ]
}

/// `1 / (4 sqrt 2)` of the sum of the squares of [`half_angle`], over the density of that azimuth on the circle.
#[inline(always)]
fn spread<T: Real>(w2: T, lean: T) -> T {
    T::from_f64(core::f64::consts::SQRT_2 / 8192.0)
        * (T::ONE + lean)
        * (T::ONE - lean)
        * (T::ONE + w2)
}
