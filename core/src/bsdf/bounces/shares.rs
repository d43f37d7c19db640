//! What light of later bounces depends on: four functions of the cosine, in tables of straight pieces.

use crate::math::Real;

/// Pieces of a table.
pub(crate) const PIECES: usize = 32;

/// A function of `|cos|` from 0 to 1, straight between nodes that are dense at grazing directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shares<T> {
    /// Value at 0 and slope of each piece.
    pub(crate) pieces: [[T; 2]; PIECES],
}

/// Where the nodes are: `mu = w x / (1 + w - x)` for evenly spaced `x` from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spacing<T> {
    /// `w`: half of the nodes are below `w / (1 + 2 w)`.
    pub(crate) warp: T,
    /// `1 + w` times the number of pieces.
    pub(crate) scale: T,
}

impl<T: Real> Spacing<T> {
    pub(crate) fn new(warp: f64) -> Self {
        Self { warp: T::from_f64(warp), scale: T::from_f64((1.0 + warp) * PIECES as f64) }
    }

    pub(crate) fn cast<U: Real>(&self) -> Spacing<U> {
        Spacing::new(self.warp.to_f64())
    }

    /// The piece at `mu` from 0 to 1; 0 for NaN.
    #[inline(always)]
    pub(crate) fn piece(&self, mu: T) -> usize {
        let k = (self.scale * mu / (mu + self.warp)).to_index();
        if k < PIECES { k } else { PIECES - 1 }
    }
}

/// Node `k` of `of`.
#[inline]
pub(crate) fn node<T: Real>(warp: T, k: u32, of: u32) -> T {
    let x = T::from_index(k) / T::from_index(of);
    warp * x / (T::ONE + warp - x)
}

impl<T: Real> Shares<T> {
    pub(crate) const NONE: Self = Self { pieces: [[T::ZERO; 2]; PIECES] };

    /// Through values at the nodes, of which there is one more than pieces.
    pub(crate) fn through(warp: f64, values: &[f64]) -> Self {
        let mut shares = Self::NONE;
        for ((k, piece), pair) in (0..).zip(&mut shares.pieces).zip(values.windows(2)) {
            let [a, b] = pair else { continue };
            let [start, end] = [k, k + 1].map(|k| node(warp, k, PIECES as u32));
            let slope = (b - a) / (end - start);
            *piece = [a - slope * start, slope].map(T::from_f64);
        }
        shares
    }

    pub(crate) fn cast<U: Real>(&self) -> Shares<U> {
        Shares { pieces: self.pieces.map(|piece| piece.map(|x| U::from_f64(x.to_f64()))) }
    }

    /// At `mu`, which lies in piece `k`; never negative.
    #[inline(always)]
    pub(crate) fn value(&self, k: usize, mu: T) -> T {
        let Some([at_0, slope]) = self.pieces.get(k) else { return T::ZERO };
        (*at_0 + *slope * mu).max(T::ZERO)
    }

    /// `2 integral of value mu dmu`: the mean over directions of a diffuse source.
    pub(crate) fn mean(&self, spacing: &Spacing<T>) -> T {
        self.areas(spacing).fold(T::ZERO, |sum, piece| sum + piece.area(piece.end))
    }

    /// The cosine below which a share `u` of that mean lies.
    pub(crate) fn quantile(&self, spacing: &Spacing<T>, u: T) -> T {
        let mut left = u * self.mean(spacing);
        let mut last = T::ONE;
        for piece in self.areas(spacing) {
            let area = piece.area(piece.end);
            if left < area {
                return piece.quantile(left);
            }
            left = left - area;
            last = piece.end;
        }
        last
    }

    fn areas(&self, spacing: &Spacing<T>) -> impl Iterator<Item = Piece<T>> {
        let warp = spacing.warp;
        (0..).zip(&self.pieces).map(move |(k, &line)| {
            let [start, end] = [k, k + 1].map(|k| node(warp, k, PIECES as u32));
            Piece { start, end, line }
        })
    }
}

/// A piece of a table, for sums over it.
struct Piece<T> {
    start: T,
    end: T,
    line: [T; 2],
}

impl<T: Real> Piece<T> {
    /// `2 integral of value mu dmu` up to `mu`.
    fn area(&self, mu: T) -> T {
        let ([at_0, slope], [a, b]) = (self.line, [self.start, mu]);
        let squares = a * a + a * b + b * b;
        let sum = at_0 * (a + b) + T::from_f64(2.0 / 3.0) * slope * squares;
        ((b - a) * sum).max(T::ZERO)
    }

    fn quantile(&self, area: T) -> T {
        let (mut low, mut high) = (self.start, self.end);
        let [at_0, slope] = self.line;
        let mut mu = T::HALF * (low + high);
        for _ in 0..20 {
            let error = self.area(mu) - area;
            if error > T::ZERO {
                high = mu;
            } else {
                low = mu;
            }
            let newton = mu - error / (T::TWO * mu * (at_0 + slope * mu));
            let inside = newton > low && newton < high;
            let next = if inside { newton } else { T::HALF * (low + high) };
            if (next - mu).abs() <= T::EPSILON * mu {
                break;
            }
            mu = next;
        }
        mu
    }
}
