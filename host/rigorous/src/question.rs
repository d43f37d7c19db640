//! What is asked of profiles, and in which order it is answered.

use crate::accuracy::Accuracy;
use crate::ensemble::Light;
use crate::problem::Side;
use crate::profile::Profile;
use crate::rays::RayOptions;
use crate::waves::Kind;

/// One profile among those of a surface.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The profile.
    pub profile: Profile,
    /// Whether it is solved rigorously; the others are given to the approximations alone, and take off the noise that the number of
    /// solved ones leaves.
    pub is_solved: bool,
    /// Pieces that know of each other, such as neighbouring rows of a map, are of one block: noise is told from block to block.
    pub block: usize,
}

impl Piece {
    /// Of profiles in the order of their places: `solved` of them, evenly spread, are solved, each in the middle of its block.
    pub fn spread(profiles: Vec<Profile>, solved: usize) -> Vec<Self> {
        let all = profiles.len();
        let solved = solved.clamp(1, all.max(1));
        let place = |at: usize| at * solved / all;
        let first = |block: usize| (block * all).div_ceil(solved);
        let middle = |block: usize| usize::midpoint(first(block), first(block + 1));
        let piece = |(at, profile)| {
            let block = place(at);
            Self { profile, is_solved: at == middle(block), block }
        };
        profiles.into_iter().enumerate().map(piece).collect()
    }

    /// Of profiles that do not know of each other, the first `solved` ones of which are solved.
    pub fn independent(profiles: Vec<Profile>, solved: usize) -> Vec<Self> {
        let piece = |(block, profile)| Self { profile, is_solved: block < solved, block };
        profiles.into_iter().enumerate().map(piece).collect()
    }
}

/// What is asked of profiles.
#[derive(Clone, Debug)]
pub struct Question {
    /// Index of the dielectric.
    pub index: f64,
    /// Wavelength in vacuum, um.
    pub wavelength_um: f64,
    /// Sides that light comes from, with its angle from the normal in that medium, degrees, positive towards +x. Each profile gets
    /// the nearest of its orders.
    pub incidences: Vec<(Side, f64)>,
    /// Of the rigorous solutions.
    pub accuracy: Accuracy,
    /// Of each profile and incidence.
    pub rays: RayOptions,
}

/// Full width of the window of a curve's angle.
pub(crate) const WINDOW_DEG: f64 = 2.0;
/// The order in which lights are told.
pub(crate) const LIGHTS: [Light; 3] = [Light::Unpolarised, Light::Te, Light::Tm];
/// The order in which lobes are told.
pub(crate) const KINDS: [Kind; 2] = [Kind::Reflected, Kind::Transmitted];

/// Of the curves, degrees.
pub(crate) fn angles() -> impl Iterator<Item = f64> {
    (-89..=89).map(f64::from)
}

#[cfg(test)]
mod tests {
    use super::Piece;
    use crate::profile::Profile;

    #[test]
    fn each_block_has_one_solved_piece() {
        let flat = Profile::new(vec![0.0; 8], 1.0).unwrap();
        for (all, solved) in [(1, 3), (2, 2), (7, 3), (296, 12), (592, 592), (5, 4)] {
            let pieces = Piece::spread(vec![flat.clone(); all], solved);
            assert_eq!(pieces.len(), all);
            for block in 0..solved.min(all) {
                let of_block = pieces.iter().filter(|piece| piece.block == block);
                assert_eq!(of_block.filter(|piece| piece.is_solved).count(), 1, "{all} {solved}");
            }
        }
    }
}
