//! A boundary that loses all light once the user has asked to stop.

use std::sync::atomic::{AtomicBool, Ordering};

use asperity_core::bsdf::{Scatter, Scattered};
use asperity_core::direction::Direction;

/// Looks at `stop` before every ray: on steep maps a ray takes a thousand times what it takes on others, so that no
/// number of rays is a measure of time. To look costs a nanosecond. What was traced then is to be thrown away.
#[derive(Debug)]
pub(crate) struct Heeding<'a, S> {
    /// The boundary.
    pub(crate) boundary: &'a S,
    /// Set when the user wants to stop.
    pub(crate) stop: &'a AtomicBool,
}

impl<S: Scatter<f64>> Scatter<f64> for Heeding<'_, S> {
    #[inline(always)]
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        if self.stop.load(Ordering::Relaxed) { None } else { self.boundary.sample(wi, uniform) }
    }
}
