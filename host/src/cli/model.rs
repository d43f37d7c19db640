//! `model`: a model from parameters, without a fit.

use std::path::PathBuf;

use asperity_core::bsdf::Lobe;
use asperity_core::gonio::Geometry;
use clap::ValueEnum;

use super::error::{Failure, without_effect};
use super::flags::light::LightFlags;
use super::flags::map::MapFlags;
use super::flags::method::MethodName;
use super::flags::scan::{BodyFlag, GeometryFlag, number};
use super::print;
use crate::kirchhoff::Speckle;
use crate::method::{Body, Bounces, Choice, Kind};
use crate::model::{MapRecord, Model, Value};
use crate::output::AtomicFile;
use crate::provenance::Provenance;

/// Profile of a density, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum ProfileFlag {
    /// exp(-|t|^n / (2 delta^n))
    Gauss,
    /// delta^n / (|t|^n + delta^n)
    Cauchy,
}

impl ProfileFlag {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Gauss => "gauss",
            Self::Cauchy => "cauchy",
        }
    }
}

/// How many facets light may meet, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum BouncesFlag {
    /// One; light that meets another is lost
    One,
    /// All, in closed form
    All,
    /// All, by a random walk: the reference, which can only be sampled
    Walk,
}

impl BouncesFlag {
    pub(super) fn bounces(self) -> Bounces {
        match self {
            Self::One => Bounces::One,
            Self::All => Bounces::All,
            Self::Walk => Bounces::Walk,
        }
    }
}

/// Make a model from parameters, without a fit
///
/// Methods and their parameters:
///   ggx      alpha (width, 1e-6 to 100); with --opaque also gain and lambert (1/sr);
///            or alpha_x, alpha_y and orientation (deg, of the axis of alpha_x from x to y)
///   normals  delta (deg), n (exponent, 0.1 to 100), theta0 (deg, optional); --profile gauss or cauchy
///   heights  delta (steps of the grid), optional n, h_max, z0 (steps); --profile gauss or cauchy, --seed
///   measured-ray   scale, cutoff_um (optional); --map FILE
///   measured-wave  the same, and --wavelength-nm NM
///   measured-hybrid  the same as measured-wave
///   beckmann  as ggx; smith-normals  as normals
///   student  sigma, gamma (tail, 1.51 to 500); or sigma_x, sigma_y, orientation and gamma
///   slopes   width (slope at the last knot), knot1 to knot7 (ln of the density there over that at 0)
///   abg  A (1/sr), B, g; harvey  b0 (1/sr), L, S; super-gauss  A (1/sr), w, p; k-correlation  A (um^4), B (um), C with
///        --wavelength-nm and in transmission --ior; all with --lobe, and an optional specular (share; the rest without it)
///   ggx-ms    ggx with --bounces all
///   mix  with --of A or --of A,B: the parameters of both laws, those of B with a 2 (alpha2), share2, optional specular and
///        lambert (shares of the surface)
///
/// Examples:
///   asperity model normals --set delta=6.9 n=1.66 --profile gauss --ior 1.49 -o m.json
///   asperity model abg --set A=0.0025 B=0.001 g=1.8 --lobe reflection -o mirror.json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// Method
    #[arg(value_parser = MethodName)]
    method: String,
    /// Parameters as name=value; an angle may end in deg (the default) or rad
    #[arg(long = "set", value_name = "NAME=VALUE", num_args = 1.., value_delimiter = ',')]
    set: Vec<String>,
    /// The one law or two that `mix` is made of
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    of: Vec<String>,
    /// Refractive index over that of air
    #[arg(long, value_name = "N", conflicts_with = "opaque", allow_negative_numbers = true, value_parser = number)]
    ior: Option<f64>,
    /// The body is opaque (ggx only)
    #[arg(long)]
    opaque: bool,
    /// The lobe that abg, harvey, k-correlation or super-gauss describes
    #[arg(long, value_enum, value_name = "LOBE")]
    lobe: Option<GeometryFlag>,
    /// What these describe [default: sheet]
    #[arg(long, value_enum)]
    body: Option<BodyFlag>,
    /// Profile of the density of `normals` and `heights`
    #[arg(long, value_enum, alias = "law")]
    profile: Option<ProfileFlag>,
    /// Facets that light may meet, for ggx, beckmann, student and smith-normals: one (the rest of the
    /// light is lost), all, or all by a random walk [default: one]
    #[arg(long, value_enum)]
    bounces: Option<BouncesFlag>,
    /// Height map of the methods `measured-...`
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Seed of the heights of `heights` [default: 1]
    #[arg(long, value_name = "K")]
    seed: Option<u64>,
    /// File to write; stdout without it
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print the model as JSON (also with -o)
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    light: LightFlags,
    #[command(flatten)]
    map_flags: MapFlags,
}

pub(super) fn run(args: &Args) -> Result<(), Failure> {
    let kind = Kind::named(&args.method)?;
    let kinds = Kind::with_parts(&args.method, &args.of)?;
    let any = |is: &dyn Fn(&Kind) -> bool| kinds.iter().any(|kind| is(kind));
    let (body, lobe) = args.body_and_lobe(any(&|kind| kind.describes_sheet))?;
    if args.profile.is_some() && !any(&|kind| kind.has_profile) {
        return Err(Failure::bad(format!(
            "method {} has no profile; leave --profile out",
            args.method
        )));
    }
    if args.map.is_some() && !kind.needs_map {
        return Err(Failure::bad(format!("method {} has no map; leave --map out", args.method)));
    }
    if any(&|kind| kind.name == "k-correlation") {
        args.light.need_no_speckle()?;
    } else {
        let why = format!("method {} sends no waves", args.method);
        args.light.need_waves(kind.is_wave(), &why)?;
    }
    args.map_flags.need_map(args.map.is_some())?;
    let drawn = kind.traced && !kind.needs_map;
    without_effect(&[("--seed", args.seed.is_some() && !drawn)], "the method draws no heights")?;
    let pairs = args.set.iter().map(|text| split(text)).collect::<Result<Vec<_>, _>>()?;
    let map = match &args.map {
        Some(path) => Some(args.map_flags.load_for_light(path)?),
        None => None,
    };
    let output = args.output.as_ref().map(AtomicFile::create).transpose()?;
    let wave = match (&map, kind.is_wave()) {
        (Some(m), true) => {
            let light = args.light.light(None)?;
            let light = light.variant(kind.waves, (&m.map, m.edges), &[Speckle::Averaged]);
            Some(light?)
        }
        _ => None,
    };
    let choice = Choice {
        wave: wave.as_ref(),
        profile: args.profile.map(ProfileFlag::word),
        bounces: args.bounces.map(|flag| flag.bounces().word()),
        asked: &|wanted| pairs.iter().any(|(name, _)| name == wanted),
        map: map.as_ref().map(|m| (&m.map, m.edges)),
        seed: args.seed.unwrap_or(1),
        lobe,
        wavelength_nm: args.light.single_nm(),
        of: &args.of,
        ..Choice::new(&args.method, body)
    };
    let method = choice.method()?;
    let mut values = Vec::new();
    for (name, text) in &pairs {
        let names = || method.parameters().iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
        let Some(parameter) = method.parameters().iter().find(|p| p.name == name) else {
            return Err(Failure::bad(format!(
                "--set {name}: method {} has no such parameter; it has {}",
                args.method,
                names()
            )));
        };
        if values.iter().any(|(n, _): &(String, Value)| n == name) {
            return Err(Failure::bad(format!("--set {name} is given twice; leave one out")));
        }
        let value = set_value(name, text, parameter.unit)?;
        let unit = parameter.unit.to_owned();
        values.push((name.clone(), Value::given(value, unit)));
    }
    let mut model = Model::new(&*method, body, values);
    model.map = map.as_ref().map(MapRecord::from);
    model.boundary(None).map_err(|(key, what)| {
        let flag = if key == "ior" { "--ior" } else { "--set" };
        Failure::bad(format!("{what}; set it with {flag}"))
    })?;
    let mut provenance = Provenance::of_this_program(None);
    provenance.references = method.references().iter().map(|&r| r.to_owned()).collect();
    model.provenance = Some(provenance);
    let text = model.to_json();
    match output {
        Some(file) => {
            let twice = args.json && !file.is_stdout();
            file.finish(text.as_bytes())?;
            if twice { print(&text) } else { Ok(()) }
        }
        None => print(&text),
    }
}

impl Args {
    /// The body, and the lobe of a law that describes one.
    fn body_and_lobe(&self, may_be_sheet: bool) -> Result<(Body, Option<Lobe>), Failure> {
        if self.body.is_some() && !may_be_sheet {
            return Err(Failure::bad(format!(
                "method {} describes a rough face; leave --body out",
                self.method
            )));
        }
        let of_sheet = may_be_sheet && self.body != Some(BodyFlag::Plate);
        let body = match (self.opaque, self.ior) {
            _ if of_sheet => Body::Sheet { ior: self.ior },
            (true, _) => Body::Opaque,
            (false, Some(ior)) => Body::Dielectric { ior },
            (false, None) => {
                return Err(Failure::bad(
                    "the refractive index is missing; give --ior N, or --opaque",
                ));
            }
        };
        let lobe = self.lobe.map(Geometry::from).map(|geometry| match geometry {
            Geometry::Reflection => Lobe::Reflection,
            Geometry::Transmission => Lobe::Transmission,
        });
        if lobe.is_some() && !may_be_sheet {
            return Err(Failure::bad(format!(
                "method {} describes both lobes; leave --lobe out",
                self.method
            )));
        }
        Ok((body, lobe))
    }
}

fn split(text: &str) -> Result<(String, String), Failure> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err(Failure::bad(format!("--set {text}: write NAME=VALUE, such as alpha=0.2"))),
    }
}

/// A number with an optional unit, in the unit of the parameter.
fn set_value(name: &str, text: &str, unit: &str) -> Result<f64, Failure> {
    let (digits, factor) = match (unit, text.strip_suffix("rad"), text.strip_suffix("deg")) {
        ("deg", Some(digits), _) => (digits, 1.0_f64.to_degrees()),
        ("deg", _, Some(digits)) => (digits, 1.0),
        _ => (text, 1.0),
    };
    match digits.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x * factor),
        _ => Err(Failure::bad(format!("--set {name}={text}: `{text}` is not a finite number"))),
    }
}
