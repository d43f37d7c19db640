//! A boundary that loses all light once the user stops the work.

use asperity_core::bsdf::{Scatter, Scattered};
use asperity_core::direction::Direction;

use crate::watch::Watch;

/// Looks at `stop` before every ray: on steep maps a ray takes a thousand times what it takes on others, so that no
/// number of rays is a measure of time. To look costs a nanosecond. Discard what was traced then.
#[derive(Debug)]
pub(crate) struct Heeding<'a, S> {
    /// The boundary.
    pub(crate) boundary: &'a S,
    /// Set when the user stops the work.
    pub(crate) watch: Watch<'a>,
}

impl<S: Scatter<f64>> Scatter<f64> for Heeding<'_, S> {
    #[inline]
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        if self.watch.is_stopped() { None } else { self.boundary.sample(wi, uniform) }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

    use asperity_core::bsdf::{Scatter, Scattered};
    use asperity_core::direction::Direction;
    use asperity_core::gonio::Geometry;

    use crate::forward::{Incidence, Rays, Sample, Setup, count_flux_until, monte_carlo};
    use crate::measurement::Quantity;
    use crate::watch::Watch;

    /// The user stops at the hundredth ray.
    #[derive(Default)]
    struct Stopped {
        rays: AtomicU64,
        stop: AtomicBool,
    }

    impl Scatter<f64> for Stopped {
        fn sample(
            &self,
            wi: Direction<f64>,
            _: &mut impl FnMut() -> f64,
        ) -> Option<Scattered<f64>> {
            if self.rays.fetch_add(1, Ordering::Relaxed) == 100 {
                self.stop.store(true, Ordering::Relaxed);
            }
            Some(Scattered { wo: wi, weight: 1.0 })
        }
    }

    #[test]
    fn flux_is_not_counted_any_more_however_many_rays_are_asked_for() {
        let boundary = Stopped::default();
        // numbers alone for a billion rays would take the whole time of all tests
        let rays = Rays { count: 1_000_000_000_000, seed: 1 };
        let wi = Direction::from_unit(0.0, 0.0, 1.0);
        count_flux_until(&boundary, wi, rays, Watch::silent(&boundary.stop));
        let most = 101 + rayon::current_num_threads() as u64;
        assert!(boundary.rays.load(Ordering::Relaxed) <= most);
    }

    #[test]
    fn no_ray_is_traced_once_the_user_has_asked_to_stop() {
        let boundary = Stopped::default();
        let setup = Setup {
            sample: Sample::Opaque,
            geometry: Geometry::Reflection,
            aperture_deg: 1.0,
            slit_height_deg: None,
            quantity: Quantity::Flux,
        };
        let angles = Incidence::in_plane(0.0, vec![0.0]);
        let rays = Rays { count: 1_000_000, seed: 1 };
        assert!(
            monte_carlo(&boundary, &setup, &angles, rays, Watch::silent(&boundary.stop)).is_none()
        );
        // one more a thread may have been on its way
        let most = 101 + rayon::current_num_threads() as u64;
        assert!(boundary.rays.load(Ordering::Relaxed) <= most);
    }
}
