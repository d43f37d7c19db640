//! What the atlas says of a surface, in a line or two.

use std::fmt::Write as _;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;

use super::answer::{Outside, Question, Quote, quote};
use super::rows::CAVEAT;
use super::table::{Engine, Measure};
use crate::kirchhoff::{self, Wavelengths};
use crate::surface::{Edges, HeightMap};

/// Incidences from inside that are told, degrees: below the critical angle.
const INSIDE_DEG: [f64; 2] = [0.0, 30.0];
/// Nobody measures less, % of the peak.
const LEAST: f64 = 0.01;

/// What the atlas asks of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Rms height, um.
    pub rq_um: f64,
    /// Rms slope along the direction in which it is largest.
    pub rms_slope: f64,
    /// Index of the dielectric over that of air.
    pub ior: f64,
}

/// A lobe at some angles of incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured<'a> {
    /// Where the light that meets the surface comes from.
    pub side: Side,
    /// Where it goes.
    pub lobe: Lobe,
    /// Angles of incidence in the medium the light comes from, degrees.
    pub incidences_deg: &'a [f64],
}

impl Surface {
    /// Of a map.
    pub fn of(map: &HeightMap, edges: Edges, ior: f64) -> Self {
        let heights = || map.points().map(|p| p.2);
        let count = heights().count().max(1) as f64;
        let mean = heights().sum::<f64>() / count;
        let square = heights().map(|h| (h - mean).powi(2)).sum::<f64>() / count;
        Self { rq_um: square.sqrt(), rms_slope: kirchhoff::steepest_slope(map, edges), ior }
    }

    /// The errors of waves and rays for the lobe that was measured, and for the light from inside.
    pub fn words(&self, light: &Wavelengths, measured: &Measured<'_>) -> Vec<String> {
        let rq = self.rq_um / light.shortest_um();
        let head = format!("{CAVEAT}; Rq {rq:.2} wavelengths, slope {:.2}", self.rms_slope);
        let lobe = |lobe| Measured { side: Side::Dielectric, lobe, incidences_deg: &INSIDE_DEG };
        let inside = [Lobe::Reflection, Lobe::Transmission].map(|l| self.said(light, &lobe(l)));
        vec![
            format!("{head}: {}", self.said(light, measured)),
            format!("from inside, 0 and 30 deg: {}; {}", inside[0], inside[1]),
        ]
    }

    /// One lobe: the worst of its angles and wavelengths for each engine.
    fn said(&self, light: &Wavelengths, lobe: &Measured<'_>) -> String {
        let way = match (lobe.side, lobe.lobe) {
            (Side::Air, Lobe::Reflection) => "reflection in air",
            (Side::Air, Lobe::Transmission) => "transmission from air",
            (Side::Dielectric, Lobe::Reflection) => "reflection inside",
            (Side::Dielectric, Lobe::Transmission) => "transmission from inside",
        };
        let [waves, rays] = [Engine::Kirchhoff, Engine::Rays].map(|e| self.worst(light, lobe, e));
        let (waves, rays) = match (waves, rays) {
            (Ok(waves), Ok(rays)) => (waves, rays),
            (Err(why), _) | (_, Err(why)) => return format!("{way}: {why}"),
        };
        let mut text = format!("{way}: waves err by {}, rays by {}", waves.text(), rays.text());
        if let Some(why) = waves.outside {
            // writing to a String cannot fail
            let _ = write!(text, " ({why})");
        }
        let is_shadowed = (lobe.side, lobe.lobe) == (Side::Air, Lobe::Reflection)
            && kirchhoff::shadows_by_itself(self.rms_slope, self.rq_um / light.shortest_um());
        if is_shadowed {
            text += "; of waves without shadowing, which is used here and better";
        }
        text
    }

    fn worst(
        &self,
        light: &Wavelengths,
        lobe: &Measured<'_>,
        engine: Engine,
    ) -> Result<Worst, Outside> {
        let (mut worst, mut outside) = (None::<Worst>, None);
        for (um, _) in light.iter() {
            for &incidence_deg in lobe.incidences_deg {
                let question = Question {
                    rq_over_lambda: self.rq_um / um,
                    rms_slope: self.rms_slope,
                    ior: self.ior,
                    incidence_deg,
                    side: lobe.side,
                    lobe: lobe.lobe,
                    engine,
                    measure: Measure::Reading,
                };
                match quote(&question) {
                    Ok(q) if worst.is_none_or(|w| w.quote.error_percent < q.error_percent) => {
                        worst = Some(Worst { quote: q, incidence_deg, outside: None });
                    }
                    Ok(_) => {}
                    Err(why) => outside = Some(why),
                }
            }
        }
        match (worst, outside) {
            (Some(worst), outside) => Ok(Worst { outside, ..worst }),
            (None, Some(why)) => Err(why),
            (None, None) => Err(Outside::Incidence(f64::NAN)),
        }
    }
}

/// The largest error over some angles.
#[derive(Clone, Copy, Debug)]
struct Worst {
    quote: Quote,
    incidence_deg: f64,
    /// Of the last angle that the atlas does not know.
    outside: Option<Outside>,
}

impl Worst {
    fn text(&self) -> String {
        format!("{} at {} deg", self.quote.text(), self.incidence_deg)
    }
}

impl Quote {
    /// Such as `0.34 % (0.2 to 0.58)`; `<0.01 %` where that is all there is to say.
    pub fn text(&self) -> String {
        if self.high_percent < LEAST {
            return format!("<{LEAST} %");
        }
        let [error, low, high] =
            [self.error_percent, self.low_percent, self.high_percent].map(two_digits);
        format!("{error} % ({low} to {high})")
    }
}

/// A percentage to two digits; what is below a hundredth is said to be.
pub fn two_digits(percent: f64) -> String {
    if percent < LEAST {
        return format!("<{LEAST}");
    }
    let places = (1.0 - percent.log10().floor()).clamp(0.0, 4.0) as usize;
    let text = format!("{percent:.places$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use asperity_core::bsdf::Lobe;
    use asperity_core::direction::Side;

    use super::{Measured, Surface, two_digits};
    use crate::kirchhoff::Wavelengths;
    use crate::surface::{Edges, GaussianSurface};

    #[test]
    fn figures_have_two_digits() {
        let of = |x: f64| two_digits(x);
        let found = [0.0002, 0.012_3, 0.3401, 0.5, 5.04, 17.6, 236.2].map(of);
        assert_eq!(found, ["<0.01", "0.012", "0.34", "0.5", "5", "18", "236"]);
    }

    #[test]
    fn a_surface_gets_a_line_for_what_was_measured_and_one_for_the_inside() {
        let light: Wavelengths = "450,550".parse().unwrap();
        let words = |surface: Surface, side, lobe, incidences_deg: &[f64]| {
            surface.words(&light, &Measured { side, lobe, incidences_deg })
        };
        let frosted = Surface { rq_um: 0.4, rms_slope: 0.35, ior: 1.49 };
        let [first, second] = &words(frosted, Side::Air, Lobe::Reflection, &[0.0, 30.0])[..] else {
            panic!()
        };
        assert!(first.starts_with("grooves, Gaussian, n 1.49; Rq 0.89 wavelengths, slope 0.35: "));
        assert!(first.contains("reflection in air: waves err by ") && first.contains("rays by "));
        assert!(first.contains("shadowing"), "{first}");
        assert!(
            second.contains("reflection inside") && second.contains("transmission from inside")
        );
        // some angles are outside, or all
        let partly = words(frosted, Side::Air, Lobe::Transmission, &[0.0, 75.0]);
        assert!(partly[0].contains("at 0 deg (an incidence of 75 deg is outside"), "{partly:?}");
        let smooth = Surface { rms_slope: 0.01, ..frosted };
        let outside = words(smooth, Side::Air, Lobe::Transmission, &[0.0]);
        assert!(
            outside.iter().all(|l| l.contains("slope 0.010 is outside the atlas")),
            "{outside:?}"
        );
    }

    #[test]
    fn of_a_map_the_figures_are_those_it_was_made_with() {
        let made = GaussianSurface {
            size: (256, 256),
            pitches_um: (0.2, 0.2),
            rq_um: 0.3,
            lengths_um: (2.0, 2.0),
            seed: 5,
        };
        let found = Surface::of(&made.map().unwrap(), Edges::Periodic, 1.5);
        let slope = std::f64::consts::SQRT_2 * 0.3 / 2.0;
        assert!((found.rq_um / 0.3 - 1.0).abs() < 0.06, "{found:?}");
        assert!((found.rms_slope / slope - 1.0).abs() < 0.12, "{found:?}");
    }
}
