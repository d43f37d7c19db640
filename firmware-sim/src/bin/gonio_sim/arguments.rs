//! What the command line says.

use asperity_core::gonio::Geometry;
use asperity_core::ndf::law::{Law, Profile};
use asperity_core::plate::RoughSide;
use asperity_core::protocol::{Axis, Microdegrees};
use asperity_firmware_sim::fault::LinkFaults;
use asperity_firmware_sim::{Boundary, Config, Instant, MachineFault};
use clap::{Parser, ValueEnum};

/// A goniophotometer that is not there: speaks the protocol of the GP-200 over a pseudo terminal or TCP
///
/// Prints one line, `listening on /dev/pts/N` or `listening on tcp:ADDRESS`, and serves until it is
/// killed. Without options it is the same instrument as the firmware.
#[derive(Debug, Parser)]
#[command(name = "gonio-sim", version)]
pub(crate) struct Arguments {
    /// Listen on a pseudo terminal (the default)
    #[arg(long, conflicts_with = "tcp")]
    pty: bool,
    /// Listen on this address, such as 127.0.0.1:0
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) tcp: Option<String>,
    /// Rough face of the sample
    #[arg(long, value_enum, default_value = "ggx")]
    boundary: Kind,
    /// Width of the GGX facets
    #[arg(long, default_value_t = 0.2)]
    alpha: f32,
    /// Width of the law of the facets' normals, degrees
    #[arg(long, default_value_t = 6.9)]
    delta: f32,
    /// Exponent of the law of the facets' normals
    #[arg(long, default_value_t = 1.66)]
    n: f32,
    /// Law of the facets' normals
    #[arg(long, value_enum, default_value = "gauss")]
    law: LawFlag,
    /// Index of the plate
    #[arg(long, default_value_t = 1.49)]
    ior: f32,
    /// Which way the rough face looks
    #[arg(long, value_enum, default_value = "source")]
    rough_side: Side,
    /// Where the detector moves
    #[arg(long, value_enum, default_value = "transmission")]
    geometry: Where,
    /// Rays for one incidence
    #[arg(long)]
    rays: Option<u32>,
    /// Seed of rays, noise, and faults of the line
    #[arg(long)]
    seed: Option<u64>,
    /// Relative change of the lamp in an hour
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    drift: f32,
    /// Play of the detector's axis, degrees
    #[arg(long)]
    backlash: Option<f64>,
    /// Dark current, nA
    #[arg(long)]
    dark: Option<f32>,
    /// Noise: variance of a current I over a time T is this times I / T; nA s
    #[arg(long)]
    shot: Option<f32>,
    /// How many times faster than a real instrument it moves and measures
    #[arg(long, default_value_t = 1)]
    acceleration: u32,
    /// Serial number
    #[arg(long)]
    serial: Option<u32>,
    /// How long an owner may be silent, milliseconds
    #[arg(long, default_value_t = 5000)]
    silence_ms: u32,
    /// A fault of the machine some time after the start (repeatable): stall-sigma, stall-theta,
    /// limit-sigma, limit-theta, over-range, lamp-off
    #[arg(long = "fault", value_name = "KIND@SECONDS", value_parser = fault)]
    pub(crate) faults: Vec<(Instant, MachineFault)>,
    /// Faults of the line: how likely each is for a chunk of bytes, 0 to 1
    #[arg(long, value_name = "RATE", default_value_t = 0.0)]
    link_faults: f32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    Ggx,
    Normals,
    Smooth,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum LawFlag {
    Gauss,
    Cauchy,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Side {
    Source,
    Detector,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Where {
    Transmission,
    Reflection,
}

/// `KIND@SECONDS`.
fn fault(text: &str) -> Result<(Instant, MachineFault), String> {
    let (kind, seconds) = text.split_once('@').ok_or("write KIND@SECONDS")?;
    let fault = match kind {
        "stall-sigma" => MachineFault::StalledAxis(Axis::Sigma),
        "stall-theta" => MachineFault::StalledAxis(Axis::Theta),
        "limit-sigma" => MachineFault::LimitSwitch(Axis::Sigma),
        "limit-theta" => MachineFault::LimitSwitch(Axis::Theta),
        "over-range" => MachineFault::OverRange,
        "lamp-off" => MachineFault::LampOff,
        _ => return Err(format!("no such fault: {kind}")),
    };
    let seconds: f64 = seconds.parse().map_err(|_| format!("not a number: {seconds}"))?;
    if seconds >= 0.0 {
        Ok((Instant((seconds * 1e6) as u64), fault))
    } else {
        Err("seconds are counted from the start".into())
    }
}

impl Arguments {
    /// The instrument.
    pub(crate) fn config(&self) -> Result<Config, String> {
        let demo = Config::demo();
        let backlash = self.backlash.map(Microdegrees::from_degrees);
        let config = Config {
            boundary: match self.boundary {
                Kind::Ggx | Kind::Normals => Boundary::Ggx(self.alpha),
                Kind::Smooth => Boundary::Smooth,
            },
            ior: self.ior,
            rough_side: match self.rough_side {
                Side::Source => RoughSide::Source,
                Side::Detector => RoughSide::Detector,
            },
            geometry: match self.geometry {
                Where::Transmission => Geometry::Transmission,
                Where::Reflection => Geometry::Reflection,
            },
            rays: self.rays.unwrap_or(demo.rays),
            seed: self.seed.unwrap_or(demo.seed),
            serial: self.serial.unwrap_or(demo.serial),
            acceleration: self.acceleration,
            silence_us: self.silence_ms.saturating_mul(1000),
            backlash: backlash.unwrap_or(Some(demo.backlash)).ok_or("--backlash is no angle")?,
            drift_per_hour: self.drift,
            dark_na: self.dark.unwrap_or(demo.dark_na),
            shot_na_s: self.shot.unwrap_or(demo.shot_na_s),
        };
        if !config.is_valid() {
            return Err(
                "a number is outside its domain (alpha 1e-6 to 100, ior 0.1 to 10, rays and \
                        acceleration 1 or more, the others 0 or more)"
                    .into(),
            );
        }
        match self.boundary {
            Kind::Normals => {
                config.with_normals(self.law()?).ok_or("--ior is outside 0.1 to 10".into())
            }
            Kind::Ggx | Kind::Smooth => Ok(config),
        }
    }

    fn law(&self) -> Result<Law<f32>, String> {
        let profile = match self.law {
            LawFlag::Gauss => Profile::Gauss,
            LawFlag::Cauchy => Profile::Cauchy,
        };
        Law::new(profile, self.delta.to_radians(), self.n, 0.0).map_err(|e| e.to_string())
    }

    /// The faults of the line, if there are to be any.
    pub(crate) fn link_faults(&self) -> Result<Option<LinkFaults>, String> {
        match self.link_faults {
            rate if rate > 0.0 && rate <= 1.0 => Ok(Some(LinkFaults::rate(rate))),
            0.0 => Ok(None),
            _ => Err("--link-faults is from 0 to 1".into()),
        }
    }
}
