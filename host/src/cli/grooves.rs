//! `check --engine rigorous`: Maxwell's equations on one period of grooves.

use std::path::{Path, PathBuf};

use asperity_core::direction::Side;

use super::error::{Failure, without_effect};
use super::flags::scan::number;
use super::{progress, put};
use crate::input;
use crate::output::AtomicFile;
use crate::provenance::InputFile;
use crate::rigorous::solver::{
    Accuracy, Incidence, Problem, RigorousError, Side as SolverSide, Solution, Stage, solve,
};
use crate::rigorous::{orders_csv, orders_json, read_profile, summary};

/// A profile of grooves in place of a model.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Grooves in place of a model (--engine rigorous)")]
pub(super) struct ProfileFlags {
    /// One period of grooves: a CSV file with the columns x_um,z_um at equal steps, air above; needs --ior and --wavelength-nm
    #[arg(long, value_name = "FILE")]
    pub(super) profile: Option<PathBuf>,
    /// Its period in um, or the length of cuts of a map [default: what the file says, or its points times their step; of cuts 60
    /// wavelengths]
    #[arg(long, value_name = "UM", value_parser = number)]
    period_um: Option<f64>,
    /// Incidences as orders m0: the tangential wavenumber of the light is 2 pi m0 / period [default: 0]
    #[arg(long, value_name = "M0,...", value_delimiter = ',', allow_hyphen_values = true)]
    incidence_orders: Vec<i32>,
    /// Write every order as CSV (side,m0,theta_i_deg,kind,m,theta_deg,eff_TE,eff_TM) in place of sums
    #[arg(long)]
    orders: bool,
}

/// What falls on the grooves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    pub(super) ior: f64,
    pub(super) wavelength_um: f64,
    /// Both without it.
    pub(super) side: Option<Side>,
}

/// Error of an efficiency that is asked for.
const TOLERANCE: f64 = 1e-7;
/// Most bytes of a profile.
const MOST_BYTES: u64 = 1 << 28;

impl ProfileFlags {
    /// Refuses the flags without a profile.
    pub(super) fn need_profile(&self) -> Result<(), Failure> {
        let flags = [
            ("--period-um", self.period_um.is_some()),
            ("--incidence-orders", !self.incidence_orders.is_empty()),
            ("--orders", self.orders),
        ];
        without_effect(&flags, "they are of grooves; give --profile FILE")
    }

    /// The length of cuts of a map, which takes the place of the profile.
    pub(super) fn period_of_cuts(&self) -> Result<Option<f64>, Failure> {
        let flags =
            [("--incidence-orders", !self.incidence_orders.is_empty()), ("--orders", self.orders)];
        without_effect(&flags, "they are of one period of grooves; give --profile FILE")?;
        Ok(self.period_um)
    }

    /// Solves, and prints or writes what is asked for.
    pub(super) fn solve(
        &self,
        path: &Path,
        light: Light,
        (as_json, output): (bool, Option<&Path>),
    ) -> Result<(), Failure> {
        let bytes = input::read_file(path, MOST_BYTES)
            .map_err(|e| Failure::bad(format!("{}: {e}", path.display())))?;
        let text = String::from_utf8_lossy(&bytes);
        let profile = read_profile(&text, path, self.period_um).map_err(Failure::bad)?;
        let problem = Problem::new(profile, light.ior, light.wavelength_um)
            .map_err(|e| Failure::bad(format!("{}: {e}", path.display())))?;
        let output = output.map(AtomicFile::create).transpose()?;
        let incidences = self.incidences(light.side, &problem);
        let solution = solved(&problem, &incidences)?;
        let answer = if as_json {
            orders_json(&problem, &solution)
        } else if self.orders {
            let head = format!(
                "asperity {}; profile {} (SHA-256 {}), period_um={}, ior={}, wavelength_nm={}\n\
                 boundary integral, {} nodes; balance of energy to {:.1e}; change in the last refinement {:.1e}\n\
                 light and orders have the tangential wavenumbers 2 pi m0 / period and 2 pi m / period; R goes back, T through",
                env!("CARGO_PKG_VERSION"),
                path.display(),
                InputFile::of_bytes(path, &bytes).sha256,
                problem.profile().period_um(),
                light.ior,
                1e3 * light.wavelength_um,
                solution.nodes,
                solution.energy_error,
                solution.change.unwrap_or(f64::NAN)
            );
            orders_csv(&problem, &solution, &head)
        } else {
            summary(&problem, &solution)
        };
        put(output, &answer)
    }

    /// Every order from the side asked for; from both where none is, as far as the order travels there.
    fn incidences(&self, side: Option<Side>, problem: &Problem) -> Vec<Incidence> {
        let orders =
            if self.incidence_orders.is_empty() { &[0][..] } else { &self.incidence_orders };
        let of = |side: SolverSide| orders.iter().map(move |&order| Incidence { side, order });
        match side {
            Some(Side::Air) => of(SolverSide::Air).collect(),
            Some(Side::Dielectric) => of(SolverSide::Dielectric).collect(),
            None => {
                let travels = |i: &Incidence| i.order.abs() <= problem.last_order(i.side);
                let air = of(SolverSide::Air).filter(travels);
                air.chain(of(SolverSide::Dielectric)).collect()
            }
        }
    }
}

/// The solution, with its progress.
fn solved(problem: &Problem, incidences: &[Incidence]) -> Result<Solution, Failure> {
    let accuracy = Accuracy { tolerance: TOLERANCE, rerun: true, ..Accuracy::default() };
    let bar = progress::bar(1000, "solving Maxwell's equations");
    let solution = bar.watch(|watch| {
        solve(problem, incidences, accuracy, &|stage: Stage| watch.share(stage.done))
    });
    solution.map_err(|e| match e {
        RigorousError::Stopped => Failure::No("interrupted before the end of the solution".into()),
        RigorousError::Unsettled { .. } | RigorousError::TooManyNodes { .. } => {
            Failure::No(e.to_string())
        }
        e => Failure::bad(e),
    })
}
