//! What is wrong with waves on a map, in words, with figures and the remedy.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;

use super::light::{LOBES, SIDES};
use super::validity::{
    COS_RQ_OVER_ACL, CURVATURE_WAVELENGTHS, FEWEST_AREAS, FarField, LobeValidity, MOST_RQ_OVER_ACL,
    MOST_SHARE, MOST_TURNED_AWAY, Validity,
};

impl Validity {
    /// Whether nothing at all is to be said against waves on this map, at any angle looked at.
    pub fn holds(&self) -> bool {
        self.warnings().is_empty()
    }

    /// One sentence or two for each condition that fails: where, by how much, and what to do.
    pub fn warnings(&self) -> Vec<String> {
        let conditions = [
            self.curvature(),
            self.slope(),
            self.shadow(),
            self.turned_away(),
            self.far_field(),
            self.phase(),
            self.size(),
        ];
        conditions.into_iter().flatten().collect()
    }

    fn curvature(&self) -> Option<String> {
        let bad = self.first_failures(LobeValidity::is_gently_curved, |l| l.curved_fraction);
        let remedy = if bad.iter().any(|l| l.incidence_deg <= 0.0) {
            "structures are about as small as the wavelength: take results as estimates, rays are no better"
        } else if self.rq_um > self.wavelengths.longest_um() {
            "trust ray methods at these angles"
        } else {
            "keep to smaller angles"
        };
        said(&bad, |l| l.curved_fraction).map(|places| {
            format!(
                "Kirchhoff: too strongly curved for {places} (2 pi R cos^3 > {CURVATURE_WAVELENGTHS} lambda \
                 asked of {:.0} %, eq. 9); {remedy}",
                100.0 * (1.0 - MOST_SHARE)
            )
        })
    }

    fn slope(&self) -> Option<String> {
        let ratio = self.rq_over_acl.filter(|_| !self.is_met_once())?;
        Some(format!(
            "Kirchhoff: Rq / l is {ratio:.3} (at most {MOST_RQ_OVER_ACL} asked, eq. 10): light meets the surface \
             more than once; trust ray methods"
        ))
    }

    fn shadow(&self) -> Option<String> {
        let most = self.most_angle_deg?;
        self.lobes.iter().find(|l| !self.is_unshadowed(l))?;
        Some(format!(
            "Kirchhoff: shadowing and masking count beyond {most:.0} deg (cos theta > {COS_RQ_OVER_ACL} Rq / l \
             asked, eq. 11); trust ray methods for incidence and observation beyond"
        ))
    }

    fn turned_away(&self) -> Option<String> {
        let bad = self.first_failures(LobeValidity::is_lit, |l| l.turned_away_fraction);
        let worst =
            bad.iter().max_by(|a, b| a.turned_away_fraction.total_cmp(&b.turned_away_fraction))?;
        Some(format!(
            "Kirchhoff: facets that face away would take {:.1} % of the light at {} deg (at most {:.1} % asked); \
             trust ray methods from there on",
            100.0 * worst.turned_away_fraction,
            worst.incidence_deg,
            100.0 * MOST_TURNED_AWAY
        ))
    }

    fn far_field(&self) -> Option<String> {
        let narrow = |side, lobe| {
            let all = self.far_fields.iter();
            all.filter(|f| f.side == side && f.lobe == lobe && !f.is_wide_enough())
                .max_by(|a, b| (a.lobe_deg - a.reach_deg).total_cmp(&(b.lobe_deg - b.reach_deg)))
        };
        let bad: Vec<&FarField> = ways().filter_map(|(side, lobe)| narrow(side, lobe)).collect();
        let places: Vec<String> = bad
            .iter()
            .map(|f| {
                format!(
                    "{} needs {:.1} deg and has {:.1} deg at {} nm",
                    way(f.side, f.lobe),
                    f.lobe_deg,
                    f.reach_deg,
                    f.wavelength_nm
                )
            })
            .collect();
        (!bad.is_empty()).then(|| {
            format!(
                "Kirchhoff: the pixel of {} um limits the far field: {}; measure with a smaller pixel, or trust \
                 ray methods",
                short(self.pixel_um),
                places.join(", ")
            )
        })
    }

    fn phase(&self) -> Option<String> {
        let bad = self.first_failures(LobeValidity::is_sampled, |l| l.undersampled_fraction);
        said(&bad, |l| l.undersampled_fraction).map(|places| {
            format!(
                "Kirchhoff: steps between neighbours change the phase by more than pi for {places} (at most \
                 {:.0} % asked); measure with a smaller pixel, or trust ray methods",
                100.0 * MOST_SHARE
            )
        })
    }

    fn size(&self) -> Option<String> {
        if self.rq_over_acl.is_none() {
            return Some(
                "Kirchhoff: the autocorrelation does not fall to 1/e inside the map, so that eqs 10 and 11 cannot \
                 be judged; remove the form with --form, or measure a larger area"
                    .to_owned(),
            );
        }
        let areas = self.correlation_areas.filter(|areas| *areas < FEWEST_AREAS)?;
        Some(format!(
            "Kirchhoff: the map holds {areas:.0} correlation areas only (at least {FEWEST_AREAS:.0} asked): speckle \
             is not averaged out; measure a larger area"
        ))
    }

    /// For each way of the light, the wavelength and the smallest incidence at which a condition fails.
    fn first_failures(
        &self,
        holds: fn(&LobeValidity) -> bool,
        share: fn(&LobeValidity) -> f64,
    ) -> Vec<&LobeValidity> {
        let first = |(side, lobe)| {
            let all = self.lobes.iter();
            all.filter(|l| l.side == side && l.lobe == lobe && !holds(l)).min_by(|a, b| {
                let earlier = a.incidence_deg.total_cmp(&b.incidence_deg);
                earlier.then(share(b).total_cmp(&share(a)))
            })
        };
        ways().filter_map(first).collect()
    }
}

/// All ways of the light.
fn ways() -> impl Iterator<Item = (Side, Lobe)> {
    SIDES.into_iter().flat_map(|side| LOBES.map(|lobe| (side, lobe)))
}

/// A way of the light in words.
fn way(side: Side, lobe: Lobe) -> &'static str {
    match (side, lobe) {
        (Side::Air, Lobe::Reflection) => "reflection in air",
        (Side::Air, Lobe::Transmission) => "transmission from air",
        (Side::Dielectric, Lobe::Reflection) => "reflection inside",
        (Side::Dielectric, Lobe::Transmission) => "transmission from inside",
    }
}

/// Where a condition fails first, with the share of the map; `None` if nowhere.
fn said(bad: &[&LobeValidity], share: fn(&LobeValidity) -> f64) -> Option<String> {
    let place = |l: &&LobeValidity| {
        format!(
            "{} at {} deg, {} nm ({:.1} % of the map)",
            way(l.side, l.lobe),
            l.incidence_deg,
            l.wavelength_nm,
            100.0 * share(l)
        )
    };
    (!bad.is_empty()).then(|| bad.iter().map(place).collect::<Vec<_>>().join(", "))
}

/// A length without the digits of rounding.
fn short(um: f64) -> String {
    format!("{um:.4}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;
    use asperity_core::quantity::RelativeIor;

    use crate::kirchhoff::{Validity, ValidityError, Wavelengths};
    use crate::surface::{Edges, HeightMap};

    /// Waves along both axes, 4 to 64 whole periods over 64 um.
    fn waves(period: f64, height: f64, pitch: f64) -> HeightMap {
        let (n, tau) = ((64.0 / pitch) as usize, std::f64::consts::TAU);
        let wave = |k: usize| height * (tau * k as f64 * pitch / period).sin();
        let heights = (0..n * n).map(|k| wave(k % n) + wave(k / n)).collect();
        HeightMap::new((n, n), (pitch, pitch), heights).unwrap()
    }

    fn validity(map: &HeightMap, nm: &str) -> Validity {
        let eta = RelativeIor::new(1.5).unwrap();
        let light = nm.parse::<Wavelengths>().unwrap();
        Validity::of(map, Edges::Periodic, eta, &light, &[0.0, 40.0]).unwrap()
    }

    fn warned(map: &HeightMap, nm: &str) -> String {
        validity(map, nm).warnings().join("\n")
    }

    #[test]
    fn a_gentle_fine_surface_is_trusted() {
        let good = validity(&waves(8.0, 0.05, 0.25), "400,550");
        assert!(good.holds() && good.lobes.iter().all(|l| l.passes), "{:?}", good.warnings());
        assert!(good.passes(Side::Dielectric, Lobe::Transmission, 25.0));
        assert!(!good.passes(Side::Dielectric, Lobe::Transmission, 41.0), "not looked at");
        let flat = HeightMap::new((9, 9), (1.0, 1.0), vec![2.0; 81]).unwrap();
        assert!(validity(&flat, "550").holds());
    }

    #[test]
    fn each_condition_has_its_warning() {
        // crest: 2 pi R = period^2 / (2 pi height)
        let curved = warned(&waves(1.0, 0.05, 0.125), "550");
        assert!(curved.contains("eq. 9") && curved.contains("rays are no better"), "{curved}");
        let steep = warned(&waves(8.0, 2.0, 0.125), "10");
        assert!(steep.contains("Rq / l is 0.") && steep.contains("eq. 10"), "{steep}");
        assert!(steep.contains("face away"), "{steep}");
        let shadowed = validity(&waves(8.0, 0.65, 0.125), "100");
        assert!(shadowed.warnings().iter().any(|w| w.contains("eq. 11")), "{shadowed:?}");
        assert!(!shadowed.passes(Side::Air, Lobe::Reflection, 40.0));
        let coarse = warned(&waves(32.0, 2.0, 2.0), "550");
        assert!(
            coarse.contains("the pixel of 2 um") && coarse.contains("more than pi"),
            "{coarse}"
        );
        assert!(coarse.contains("correlation areas only"), "{coarse}");
    }

    #[test]
    fn curvature_is_counted_at_its_wavelength() {
        // a grating at normal incidence: 2 pi R cos^3 = 2 pi / |z''|, least at the crests
        let wave = |k: u32| 0.3 * (std::f64::consts::TAU * f64::from(k % 512) * 0.125 / 16.0).sin();
        let map = HeightMap::new((512, 4), (0.125, 0.125), (0..2048).map(wave).collect()).unwrap();
        let least = 16.0_f64.powi(2) / (std::f64::consts::TAU * 0.3);
        let share = |nm: f64| {
            let all = validity(&map, &format!("{nm}")).lobes;
            let at = |l: &&super::LobeValidity| l.side == Side::Air && l.incidence_deg < 1.0;
            let of = |lobe| all.iter().filter(at).find(|l| l.lobe == lobe).unwrap().curved_fraction;
            (of(Lobe::Reflection), of(Lobe::Transmission))
        };
        let just = 1000.0 * least / 10.0;
        assert!(share(0.99 * just).0 < 1e-12);
        assert!(share(1.02 * just).0 > 1e-3);
        // in the dielectric the waves are shorter by the index
        assert!(share(1.02 * just).1 < 1e-12 && share(1.53 * just).1 > 1e-3);
    }

    #[test]
    fn what_cannot_be_judged_is_refused() {
        let eta = RelativeIor::new(1.5).unwrap();
        let light = Wavelengths::single(550.0).unwrap();
        let mut heights = vec![0.0; 81];
        let map = HeightMap::new((9, 9), (1.0, 1.0), heights.clone()).unwrap();
        for bad in [-1.0, 90.0, f64::NAN] {
            let error = Validity::of(&map, Edges::Mirrored, eta, &light, &[bad]).unwrap_err();
            assert!(matches!(error, ValidityError::Incidence(_)));
        }
        heights[40] = f64::NAN;
        let holed = HeightMap::new((9, 9), (1.0, 1.0), heights).unwrap();
        let error = Validity::of(&holed, Edges::Mirrored, eta, &light, &[0.0]).unwrap_err();
        assert!(error.to_string().contains("--fill"), "{error}");
    }
}
