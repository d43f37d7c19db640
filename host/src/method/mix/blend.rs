//! From the laws of a mix and its shares to the boundary.

use asperity_core::bsdf::{Backing, Bsdf, Mix, MixShares};
use asperity_core::direction::Direction;

use super::super::kind::{Kind, Lack};
use super::super::{Body, BuildError, Method};
use super::names::second;
use super::{LAMBERT, SPECULAR};
use crate::boundary::{Boundary, Mixed, Part};

/// What the laws share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Blend {
    /// The surface: each law has a share of it.
    Shares,
    /// The light: laws about the specular direction scatter a part of it each, and the rest keeps its direction.
    Scatter,
    /// Nothing: laws of an opaque body have levels, which add.
    Opaque,
}

/// The level of facets on an opaque body.
const GAIN: &str = "gain";

impl Blend {
    /// Of methods on a body.
    pub(super) fn of(kinds: &[&Kind], body: Body) -> Result<Self, Lack> {
        if let Some(other) = kinds.iter().find(|kind| !kind.is_closed()) {
            let what = format!("{} is no closed form with values, and only those mix", other.name);
            return Err(Lack::Mix(what));
        }
        let about_specular = kinds.iter().filter(|kind| kind.describes_sheet).count();
        match about_specular {
            0 if body == Body::Opaque => Ok(Self::Opaque),
            0 => Ok(Self::Shares),
            all if all == kinds.len() => Ok(Self::Scatter),
            _ => Err(Lack::Mix(
                "a law of facets and one about the specular direction do not mix; take two of a kind".into(),
            )),
        }
    }

    /// Whether a parameter of law `k` is its own, not the mix's.
    pub(super) fn is_own(self, k: usize, name: &str) -> bool {
        match self {
            Self::Shares => true,
            Self::Scatter => name != SPECULAR.name,
            Self::Opaque => k == 0 || name != LAMBERT.name,
        }
    }
}

/// What is asked for.
pub(super) struct Asked<'a> {
    /// Own values of the laws; those of the second may be none.
    pub(super) values: [&'a [f64]; 2],
    pub(super) second: f64,
    pub(super) specular: f64,
    pub(super) lambert: f64,
}

/// One of the laws.
struct Law<'a> {
    method: &'a dyn Method,
    /// 0 or 1.
    place: usize,
    own: &'a [f64],
}

impl Law<'_> {
    /// All values of its parameters: its own, and those that the mix has for both.
    fn values(&self, blend: Blend, shared: f64) -> Vec<f64> {
        let mut own = self.own.iter().copied();
        let value = |name| if blend.is_own(self.place, name) { own.next() } else { Some(shared) };
        self.method.parameters().iter().map(|p| p.name).filter_map(value).collect()
    }

    fn boundary(&self, values: &[f64], body: Body) -> Result<Boundary, BuildError> {
        self.method.boundary(values, body).map_err(|e| match e {
            BuildError::Missing(name) if self.place > 0 => BuildError::Missing(second(name)),
            BuildError::OutOfDomain { name, value, least, most, unit } if self.place > 0 => {
                BuildError::OutOfDomain { name: second(name), value, least, most, unit }
            }
            e => e,
        })
    }

    /// The place of its level among its parameters.
    fn level(&self) -> Option<usize> {
        self.method.parameters().iter().position(|p| p.is_level)
    }
}

/// A boundary as a part of a mix.
fn part(boundary: Boundary) -> Result<Part, BuildError> {
    // methods that make others are refused by name
    Part::of(boundary).ok_or_else(|| BuildError::Ior("only closed forms mix".into()))
}

/// The mix of one law or two.
pub(super) fn blended(
    methods: &[Box<dyn Method>],
    blend: Blend,
    asked: &Asked<'_>,
    body: Body,
) -> Result<Mixed, BuildError> {
    let own = asked.values;
    let laws = methods.iter().zip(own).enumerate();
    let laws: Vec<Law<'_>> =
        laws.map(|(place, (method, own))| Law { method: &**method, place, own }).collect();
    match blend {
        Blend::Shares => of_shares(&laws, asked, body),
        Blend::Scatter => of_scatter(&laws, asked, body),
        Blend::Opaque => of_levels(&laws),
    }
}

fn mixed(
    backing: Backing<f64>,
    parts: Vec<Part>,
    shares: MixShares<f64>,
) -> Result<Mixed, BuildError> {
    let mut parts = parts.into_iter();
    let first = parts.next().ok_or(BuildError::Missing("of"))?;
    let sum = shares.second + shares.specular + shares.lambert;
    Mix::new(backing, first, parts.next(), shares).ok_or(BuildError::Shares { sum })
}

fn of_shares(laws: &[Law<'_>], asked: &Asked<'_>, body: Body) -> Result<Mixed, BuildError> {
    let Asked { second, specular, lambert, .. } = *asked;
    let make = |law: &Law<'_>| part(law.boundary(&law.values(Blend::Shares, 0.0), body)?);
    let parts = laws.iter().map(make).collect::<Result<Vec<_>, _>>()?;
    let shares = MixShares { second, specular, lambert };
    mixed(Backing::Dielectric(body.eta()?), parts, shares)
}

/// Laws whose levels add: each has the share of the surface that it has of all the light that is scattered, and there its level
/// is divided by that share. What no law scatters then keeps its direction on either.
fn of_scatter(laws: &[Law<'_>], asked: &Asked<'_>, body: Body) -> Result<Mixed, BuildError> {
    let Asked { specular, lambert, .. } = *asked;
    let scattered = |law: &Law<'_>| match law.boundary(&law.values(Blend::Scatter, 0.0), body)? {
        Boundary::Tail(tail) => Ok(tail.scattered(Direction::normal())),
        _ => Err(BuildError::Ior("only laws about the specular direction scatter".into())),
    };
    let totals = laws.iter().map(scattered).collect::<Result<Vec<f64>, _>>()?;
    let all: f64 = totals.iter().sum();
    if all + specular + lambert > 1.0 + 1e-6 || lambert >= 1.0 {
        return Err(BuildError::TooBright { scattered: all + specular + lambert });
    }
    let even = 1.0 / totals.len() as f64;
    // what is so dim that it scatters nothing may be anywhere
    let share = |total: f64| (1.0 - lambert) * if all > 0.0 { total / all } else { even };
    let make = |(law, total): (&Law<'_>, &f64)| {
        let mut values = law.values(Blend::Scatter, specular / (1.0 - lambert));
        let level = law.level().and_then(|k| values.get_mut(k));
        if let Some(level) = level.filter(|_| share(*total) > 0.0) {
            *level /= share(*total);
        }
        law.boundary(&values, body)
    };
    let made = laws.iter().zip(&totals).map(make).collect::<Result<Vec<_>, _>>()?;
    let backing = match made.first() {
        Some(Boundary::Tail(tail)) if tail.eta().is_matched() => Backing::Air(tail.lobe()),
        _ => Backing::Dielectric(body.eta()?),
    };
    let parts = made.into_iter().map(part).collect::<Result<Vec<_>, _>>()?;
    let second = totals.get(1).map_or(0.0, |total| share(*total));
    mixed(backing, parts, MixShares { second, specular: 0.0, lambert })
}

/// The same on an opaque body, whose levels are `gain` and the floor that of the first law.
fn of_levels(laws: &[Law<'_>]) -> Result<Mixed, BuildError> {
    let floor = laws.first().map_or(&[][..], |law| law.method.parameters());
    let floor = floor.iter().position(|p| p.name == LAMBERT.name);
    let floor = laws.first().zip(floor).and_then(|(law, k)| law.own.get(k)).copied();
    let floor = floor.ok_or(BuildError::Missing(LAMBERT.name))?;
    let gain = |law: &Law<'_>| {
        let value = law.level().and_then(|k| law.own.get(k)).copied();
        value.ok_or(BuildError::Missing(GAIN))
    };
    let gains = laws.iter().map(gain).collect::<Result<Vec<f64>, _>>()?;
    let all: f64 = gains.iter().sum();
    let make = |law: &Law<'_>| {
        // its own values are in order, and its level then that of both
        let mut values = law.values(Blend::Opaque, floor);
        law.boundary(&values, Body::Opaque)?;
        if let Some(level) = law.level().and_then(|k| values.get_mut(k)) {
            *level = all;
        }
        part(law.boundary(&values, Body::Opaque)?)
    };
    let parts = laws.iter().map(make).collect::<Result<Vec<_>, _>>()?;
    let second = match gains.get(1) {
        Some(gain) if all > 0.0 => gain / all,
        _ => 0.0,
    };
    mixed(Backing::Opaque, parts, MixShares { second, specular: 0.0, lambert: 0.0 })
}

/// Whether the wider of two laws comes first.
pub(super) fn is_disordered(mix: &Mixed) -> bool {
    mix.second().is_some_and(|second| mix.first().slope() > second.slope())
}
