//! Sets of the four lobes of a boundary.

use core::ops::{BitAnd, BitOr, Sub};

use super::Lobe;
use crate::direction::Side;

/// Some of the four lobes: reflection and transmission of light from the air and from the dielectric.
///
/// ```
/// use asperity_core::bsdf::{Lobe, LobeSet};
/// use asperity_core::direction::Side;
/// let seen = LobeSet::AIR | LobeSet::of(Side::Dielectric, Lobe::Transmission);
/// assert!(seen.contains(LobeSet::AIR_TRANSMISSION) && !seen.contains(LobeSet::DIELECTRIC));
/// assert_eq!((LobeSet::ALL - seen).iter().collect::<Vec<_>>(), [(Side::Dielectric, Lobe::Reflection)]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LobeSet(u8);

impl LobeSet {
    /// No lobe.
    pub const NONE: Self = Self(0);
    /// Light from the air that comes back.
    pub const AIR_REFLECTION: Self = Self(1);
    /// Light from the air that goes through.
    pub const AIR_TRANSMISSION: Self = Self(2);
    /// Light from the dielectric that comes back.
    pub const DIELECTRIC_REFLECTION: Self = Self(4);
    /// Light from the dielectric that goes through.
    pub const DIELECTRIC_TRANSMISSION: Self = Self(8);
    /// Both lobes of light from the air.
    pub const AIR: Self = Self(3);
    /// Both lobes of light from the dielectric.
    pub const DIELECTRIC: Self = Self(12);
    /// All four lobes.
    pub const ALL: Self = Self(15);

    /// The lobes in the order of tables and their files: reflection and transmission from the air, then from the dielectric.
    pub const ORDER: [(Side, Lobe); 4] = [
        (Side::Air, Lobe::Reflection),
        (Side::Air, Lobe::Transmission),
        (Side::Dielectric, Lobe::Reflection),
        (Side::Dielectric, Lobe::Transmission),
    ];

    /// One lobe.
    pub const fn of(side: Side, lobe: Lobe) -> Self {
        match (side, lobe) {
            (Side::Air, Lobe::Reflection) => Self::AIR_REFLECTION,
            (Side::Air, Lobe::Transmission) => Self::AIR_TRANSMISSION,
            (Side::Dielectric, Lobe::Reflection) => Self::DIELECTRIC_REFLECTION,
            (Side::Dielectric, Lobe::Transmission) => Self::DIELECTRIC_TRANSMISSION,
        }
    }

    /// Each of these lobes from each of these sides.
    pub fn of_each(sides: &[Side], lobes: &[Lobe]) -> Self {
        let wanted = |(side, lobe): &(Side, Lobe)| sides.contains(side) && lobes.contains(lobe);
        Self::ORDER.into_iter().filter(wanted).collect()
    }

    /// This set if `wanted`, else none.
    pub const fn only_if(self, wanted: bool) -> Self {
        if wanted { self } else { Self::NONE }
    }

    /// Whether all of `others` are in it.
    pub const fn contains(self, others: Self) -> bool {
        self.0 & others.0 == others.0
    }

    /// Whether there is no lobe in it.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Number of lobes.
    pub const fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// The lobes, in [their order](Self::ORDER).
    pub fn iter(self) -> impl Iterator<Item = (Side, Lobe)> {
        Self::ORDER.into_iter().filter(move |&(side, lobe)| self.contains(Self::of(side, lobe)))
    }
}

impl FromIterator<(Side, Lobe)> for LobeSet {
    fn from_iter<I: IntoIterator<Item = (Side, Lobe)>>(lobes: I) -> Self {
        lobes.into_iter().fold(Self::NONE, |set, (side, lobe)| set | Self::of(side, lobe))
    }
}

/// The lobes of either.
impl BitOr for LobeSet {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// The lobes of both.
impl BitAnd for LobeSet {
    type Output = Self;

    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

/// The lobes of the first that are not in the second.
impl Sub for LobeSet {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::LobeSet;
    use crate::bsdf::Lobe;
    use crate::direction::Side;

    #[test]
    fn names_order_and_sides_agree() {
        let names = [
            LobeSet::AIR_REFLECTION,
            LobeSet::AIR_TRANSMISSION,
            LobeSet::DIELECTRIC_REFLECTION,
            LobeSet::DIELECTRIC_TRANSMISSION,
        ];
        assert_eq!(LobeSet::ORDER.map(|(side, lobe)| LobeSet::of(side, lobe)), names);
        assert!(LobeSet::ALL.iter().eq(LobeSet::ORDER));
        let both = [Lobe::Reflection, Lobe::Transmission];
        assert_eq!(LobeSet::of_each(&[Side::Air], &both), LobeSet::AIR);
        assert_eq!(LobeSet::of_each(&[Side::Dielectric], &both), LobeSet::DIELECTRIC);
        assert_eq!(LobeSet::of_each(&[Side::Air], &[Lobe::Transmission]), names[1]);
    }

    #[test]
    fn it_is_a_set() {
        for a in 0..16 {
            for b in 0..16 {
                let (x, y) = (LobeSet(a), LobeSet(b));
                assert_eq!((x | y) - y, x - y);
                assert_eq!((x - y) | (x & y), x);
                assert_eq!(x.contains(y), (y - x).is_empty());
                assert_eq!(x.len(), x.iter().count());
                assert_eq!(x.iter().collect::<LobeSet>(), x);
            }
        }
    }
}
