//! The rigorous solutions, as they are in the crate.

use std::sync::OnceLock;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;

const TEXT: &str = include_str!("atlas.csv");
/// Columns of the table.
const COLUMNS: usize = 19;

/// What computes the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Kirchhoff's integral, without shadowing: the mean over the surface.
    Kirchhoff,
    /// Rays with all bounces.
    Rays,
    /// Single facets that all see the light: rays of one bounce without shadowing.
    Facet,
}

impl Engine {
    /// All.
    pub const ALL: [Self; 3] = [Self::Kirchhoff, Self::Rays, Self::Facet];

    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kirchhoff => "kirchhoff",
            Self::Rays => "rays",
            Self::Facet => "facet",
        }
    }
}

/// What of the light is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// All of it, in percent of the peak of the lobe.
    Reading,
    /// What is not coherent, in percent of its own peak.
    Diffuse,
}

impl Measure {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Reading, Self::Diffuse];
}

/// One lobe of one surface, rigorously and by each engine. Fluxes are shares of the incident light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Rms height, vacuum wavelengths.
    pub rq_over_lambda: f64,
    /// Rms slope across the grooves.
    pub rms_slope: f64,
    /// Where the light comes from.
    pub side: Side,
    /// Where it goes.
    pub lobe: Lobe,
    /// Angle of incidence in the medium the light comes from, degrees.
    pub incidence_deg: f64,
    /// Flux of the lobe.
    pub flux: f64,
    /// Of it, the coherent light.
    pub coherent_flux: f64,
    /// Noise of the solution at the peak of the diffuse light, % of it.
    pub noise_percent: f64,
    fluxes: [f64; 3],
    floors: [f64; 2],
    errors: [[f64; 3]; 2],
}

impl Solution {
    /// Flux of the lobe by an engine.
    pub fn flux_of(&self, engine: Engine) -> f64 {
        self.fluxes[engine as usize]
    }

    /// Error of an engine, %; the noise of the solution is subtracted.
    pub fn error_percent(&self, engine: Engine, measure: Measure) -> f64 {
        self.errors[measure as usize][engine as usize]
    }

    /// Noise of the solution in the terms of that error, %.
    pub fn floor_percent(&self, measure: Measure) -> f64 {
        self.floors[measure as usize]
    }

    fn parse(line: &str) -> Option<Self> {
        let cells: Vec<&str> = line.split(',').collect();
        let side = match *cells.get(2)? {
            "air" => Side::Air,
            "inside" => Side::Dielectric,
            _ => return None,
        };
        let lobe = match *cells.get(4)? {
            "R" => Lobe::Reflection,
            "T" => Lobe::Transmission,
            _ => return None,
        };
        let number = |k: usize| cells.get(k)?.parse::<f64>().ok().filter(|x| x.is_finite());
        let three = |k: usize| Some([number(k)?, number(k + 1)?, number(k + 2)?]);
        (cells.len() == COLUMNS).then_some(())?;
        Some(Self {
            rq_over_lambda: number(0)?,
            rms_slope: number(1)?,
            side,
            lobe,
            incidence_deg: number(3)?,
            flux: number(5)?,
            fluxes: three(6)?,
            coherent_flux: number(9)?,
            floors: [number(10)?, number(11)?],
            errors: [three(12)?, three(15)?],
            noise_percent: number(18)?,
        })
    }
}

/// All lobes of the atlas, surface by surface.
pub fn solutions() -> &'static [Solution] {
    static FOUND: OnceLock<Vec<Solution>> = OnceLock::new();
    // comments and the head of the table are no solutions
    FOUND.get_or_init(|| TEXT.lines().filter_map(Solution::parse).collect())
}

#[cfg(test)]
mod tests {
    use super::{Engine, Measure, TEXT, solutions};

    #[test]
    fn every_line_is_a_lobe_and_every_figure_is_possible() {
        let lines = TEXT.lines().filter(|l| !l.starts_with('#')).count() - 1;
        assert_eq!((lines, solutions().len()), (504, 504));
        for s in solutions() {
            assert!(s.flux > 0.0 && s.flux < 1.0 + 1e-6 && s.coherent_flux <= s.flux, "{s:?}");
            assert!((0.0..61.0).contains(&s.incidence_deg) && s.noise_percent > 0.0, "{s:?}");
            for measure in Measure::ALL {
                assert!(s.floor_percent(measure) > 0.0, "{s:?}");
                let errors = Engine::ALL.map(|engine| s.error_percent(engine, measure));
                assert!(errors.iter().all(|e| *e > 0.0), "{s:?}");
            }
        }
    }

    #[test]
    fn lobes_of_a_beam_hold_all_light() {
        for pair in solutions().chunks(2) {
            let [r, t] = pair else { panic!("{pair:?}") };
            assert!((r.incidence_deg - t.incidence_deg).abs() < 1e-9 && r.lobe != t.lobe);
            assert!((r.flux + t.flux - 1.0).abs() < 2e-4, "{pair:?}");
        }
    }
}
