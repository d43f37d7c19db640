//! The time of the line, and where bytes go.

/// Microseconds since power-on, by the clock of the line. Never runs backwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Instant(pub u64);

impl Instant {
    /// This much later, microseconds.
    pub const fn after(self, us: u64) -> Self {
        Self(self.0.saturating_add(us))
    }

    /// Microseconds from `earlier` to here; 0 if it is the later one.
    pub const fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }
}

/// Where bytes go. Any `FnMut(&[u8])` is one.
pub trait Sink {
    /// Takes all of `bytes`.
    fn write(&mut self, bytes: &[u8]);
}

impl<F: FnMut(&[u8])> Sink for F {
    fn write(&mut self, bytes: &[u8]) {
        self(bytes);
    }
}

/// The earlier of two deadlines, where there are any.
pub(crate) fn earlier(a: Option<Instant>, b: Option<Instant>) -> Option<Instant> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod tests {
    use super::{Instant, earlier};

    #[test]
    fn times_neither_wrap_nor_go_back() {
        assert_eq!(Instant(u64::MAX).after(5), Instant(u64::MAX));
        assert_eq!(Instant(3).since(Instant(7)), 0);
        assert_eq!(earlier(None, Some(Instant(2))), Some(Instant(2)));
        assert_eq!(earlier(Some(Instant(1)), Some(Instant(2))), Some(Instant(1)));
        assert_eq!(earlier(None, None), None);
    }
}
