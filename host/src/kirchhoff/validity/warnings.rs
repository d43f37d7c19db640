//! Warnings about waves on a map, with figures and the remedy.

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;

use super::light::{LOBES, SIDES};
use super::limits::{
    FEWEST_AREAS, FarField, LobeValidity, MOST_EXCESS, MOST_SHARE, MOST_VIOLATING, Validity,
};

/// `q_z Rq` from which on rays are right to 3 % where no facet violates a condition, in the atlas of rigorous solutions.
const RAYS: f64 = 3.5;

impl Validity {
    /// Whether there is no objection to waves on this map, at any angle examined.
    pub fn holds(&self) -> bool {
        self.warnings().is_empty()
    }

    /// One or two sentences for each condition that fails: where, by how much, and the remedy.
    pub fn warnings(&self) -> Vec<String> {
        let conditions = [
            self.facets(),
            self.critical(),
            self.energy(),
            self.diffuse(),
            self.far_field(),
            self.phase(),
            self.size(),
        ];
        conditions.into_iter().flatten().collect()
    }

    fn facets(&self) -> Option<String> {
        let bad = self.first_failures(
            |l| l.is_seen_aright() || l.specular_deg.is_none(),
            |l| l.violating.any,
        );
        let remedy = if bad.iter().all(|l| l.phase_rms >= RAYS) {
            "trust ray methods from there on"
        } else {
            "keep to smaller angles; rays are right only where heights are large beside the wavelength"
        };
        let what = |l: &LobeValidity| {
            let violating = l.violating;
            let parts = [
                (violating.horizon, "send it below the horizon"),
                (violating.away, "face away"),
                (violating.critical, "see it beyond the critical angle, or not"),
            ];
            let most = parts.iter().max_by(|a, b| a.0.total_cmp(&b.0));
            format!("{:.2} % {}", 100.0 * violating.any, most.map_or("", |m| m.1))
        };
        said(&bad, what).map(|places| {
            format!(
                "Kirchhoff: facets turn the light too far, shadow it or are in shadow, in {places} (at most {:.2} % asked); \
                 {remedy}",
                100.0 * MOST_VIOLATING
            )
        })
    }

    fn critical(&self) -> Option<String> {
        let bad = self.first_failures(|l| l.specular_deg.is_some(), |l| l.violating.any);
        let place =
            |l: &&LobeValidity| format!("{} at {} deg", way(l.side, l.lobe), l.incidence_deg);
        let places: Vec<String> = bad.iter().map(place).collect();
        (!bad.is_empty()).then(|| {
            format!(
                "Kirchhoff: {} is beyond the critical angle: what the surface lets through there is not to be \
                 trusted at all, by a factor",
                places.join(", ")
            )
        })
    }

    fn energy(&self) -> Option<String> {
        let most = self.lobes.iter().filter(|l| !l.conserves_energy());
        let worst = most.min_by(|a, b| a.lost.unwrap_or(0.0).total_cmp(&b.lost.unwrap_or(0.0)))?;
        let from = match worst.side {
            Side::Air => "from air",
            Side::Dielectric => "from inside",
        };
        Some(format!(
            "Kirchhoff: R + T is {:.3} {from} at {} deg (at most {:.2} asked): no lobe there is to be trusted",
            1.0 - worst.lost.unwrap_or(0.0),
            worst.incidence_deg,
            1.0 + MOST_EXCESS
        ))
    }

    fn diffuse(&self) -> Option<String> {
        let length = self.correlation_um?;
        let bad = self.first_failures(
            |l| l.is_long_enough() || l.specular_deg.is_none(),
            |l| l.least_correlation_wavelengths,
        );
        let remedy = if bad.iter().any(|l| l.incidence_deg <= 0.0) {
            "structures are about as small as the wavelength: take results as estimates, rays are no better"
        } else {
            "there trust the specular light only"
        };
        let least = |l: &LobeValidity| {
            format!("{:.2} um needed", l.least_correlation_wavelengths * l.wavelength_nm / 1e3)
        };
        said(&bad, least).map(|places| {
            format!(
                "Kirchhoff: too strongly curved for diffuse light beside the specular (eq. 9): structures are {} um long \
                 for {places}; {remedy}",
                short(length)
            )
        })
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
        let share =
            |l: &LobeValidity| format!("{:.1} % of the map", 100.0 * l.undersampled_fraction);
        said(&bad, share).map(|places| {
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
                "Kirchhoff: the autocorrelation does not fall to 1/e inside the map: speckle is not averaged out; \
                 remove the form with --form, or measure a larger area"
                    .to_owned(),
            );
        }
        let areas = self.correlation_areas.filter(|areas| *areas < FEWEST_AREAS)?;
        Some(format!(
            "Kirchhoff: the map holds {areas:.0} correlation areas only (at least {FEWEST_AREAS:.0} asked): speckle \
             is not averaged out; measure a larger area"
        ))
    }

    /// For each path of the light, the wavelength and the smallest incidence at which a condition fails.
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

/// All paths of the light.
fn ways() -> impl Iterator<Item = (Side, Lobe)> {
    SIDES.into_iter().flat_map(|side| LOBES.map(|lobe| (side, lobe)))
}

/// A path of the light in words.
fn way(side: Side, lobe: Lobe) -> &'static str {
    match (side, lobe) {
        (Side::Air, Lobe::Reflection) => "reflection in air",
        (Side::Air, Lobe::Transmission) => "transmission from air",
        (Side::Dielectric, Lobe::Reflection) => "reflection inside",
        (Side::Dielectric, Lobe::Transmission) => "transmission from inside",
    }
}

/// Where a condition fails first, with the text for each place; `None` if nowhere.
fn said(bad: &[&LobeValidity], what: impl Fn(&LobeValidity) -> String) -> Option<String> {
    let place = |l: &&LobeValidity| {
        format!(
            "{} at {} deg, {} nm ({})",
            way(l.side, l.lobe),
            l.incidence_deg,
            l.wavelength_nm,
            what(l)
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

    use crate::kirchhoff::validity::Loss;
    use crate::kirchhoff::{Validity, ValidityError, Wavelengths};
    use crate::surface::{Edges, HeightMap};

    /// Waves along both axes, 4 to 64 whole periods over 64 um.
    fn waves(period: f64, height: f64, pitch: f64) -> HeightMap {
        let (n, tau) = ((64.0 / pitch) as usize, std::f64::consts::TAU);
        let wave = |k: usize| height * (tau * k as f64 * pitch / period).sin();
        let heights = (0..n * n).map(|k| wave(k % n) + wave(k / n)).collect();
        HeightMap::new((n, n), (pitch, pitch), heights).unwrap()
    }

    fn validity_at(map: &HeightMap, nm: &str, incidences_deg: &[f64]) -> Validity {
        let eta = RelativeIor::new(1.5).unwrap();
        let light = nm.parse::<Wavelengths>().unwrap();
        Validity::of(map, Edges::Periodic, eta, &light, incidences_deg).unwrap()
    }

    fn validity(map: &HeightMap, nm: &str) -> Validity {
        validity_at(map, nm, &[0.0, 35.0])
    }

    fn warned(map: &HeightMap, nm: &str) -> String {
        validity(map, nm).warnings().join("\n")
    }

    #[test]
    fn a_gentle_fine_surface_is_trusted() {
        let good = validity(&waves(8.0, 0.05, 0.25), "400,550");
        assert!(good.holds() && good.lobes.iter().all(|l| l.passes), "{:?}", good.warnings());
        assert!(good.lobes.iter().all(|l| l.diffuse_passes));
        assert!(good.passes(Side::Dielectric, Lobe::Transmission, 25.0));
        assert!(!good.passes(Side::Dielectric, Lobe::Transmission, 36.0), "not looked at");
        let flat = HeightMap::new((9, 9), (1.0, 1.0), vec![2.0; 81]).unwrap();
        assert!(validity(&flat, "550").holds());
    }

    #[test]
    fn each_condition_has_its_warning() {
        // slopes up to 0.31 of 1 um long waves: facets are well, structures too short
        let curved = validity_at(&waves(1.0, 0.02, 0.125), "550", &[0.0]).warnings().join("\n");
        assert!(curved.contains("eq. 9") && curved.contains("rays are no better"), "{curved}");
        assert!(!curved.contains("facets"), "{curved}");
        let steep = warned(&waves(8.0, 2.0, 0.125), "10");
        assert!(steep.contains("below the horizon") && steep.contains("ray methods"), "{steep}");
        let shadowed = validity_at(&waves(8.0, 0.65, 0.125), "100", &[70.0]);
        assert!(shadowed.warnings()[0].contains("face away"), "{:?}", shadowed.warnings());
        assert!(!shadowed.passes(Side::Air, Lobe::Transmission, 70.0));
        let coarse = warned(&waves(32.0, 2.0, 2.0), "550");
        assert!(
            coarse.contains("the pixel of 2 um") && coarse.contains("more than pi"),
            "{coarse}"
        );
        assert!(coarse.contains("correlation areas only"), "{coarse}");
    }

    #[test]
    fn near_and_beyond_the_critical_angle_nothing_passes() {
        let map = waves(8.0, 0.05, 0.25);
        let near = validity_at(&map, "550", &[40.0, 44.0, 60.0]);
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            assert!(!near.passes(Side::Dielectric, lobe, 40.0), "{lobe:?}");
            assert!(!near.passes(Side::Dielectric, lobe, 44.0), "{lobe:?}");
        }
        assert!(near.passes(Side::Dielectric, Lobe::Reflection, 60.0));
        assert!(!near.passes(Side::Dielectric, Lobe::Transmission, 60.0));
        let said = near.warnings().join("\n");
        assert!(
            said.contains("transmission from inside at 44 deg is beyond the critical"),
            "{said}"
        );
        assert!(said.contains("see it beyond the critical angle"), "{said}");
        // from air there is none
        assert!([40.0, 44.0, 60.0].iter().all(|deg| near.passes(
            Side::Air,
            Lobe::Reflection,
            *deg
        )));
    }

    #[test]
    fn where_more_light_comes_out_than_went_in_no_lobe_passes() {
        let of = |lost| {
            let loss = Loss { side: Side::Air, incidence_deg: 35.0, lost };
            validity(&waves(8.0, 0.05, 0.25), "400,550").balanced(&[loss])
        };
        for (lost, passes) in [(-0.0099, true), (-0.0101, false), (f64::NAN, false)] {
            let found = of(lost);
            for lobe in [Lobe::Reflection, Lobe::Transmission] {
                assert_eq!(found.passes(Side::Air, lobe, 35.0), passes, "{lost}");
                assert_eq!(found.diffuse_passes(Side::Air, lobe, 35.0), passes, "{lost}");
                assert!(found.passes(Side::Dielectric, lobe, 35.0));
            }
            assert_eq!(found.holds(), passes);
        }
        let said = of(-0.02).warnings().join("\n");
        assert!(said.contains("R + T is 1.020 from air at 35 deg"), "{said}");
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
