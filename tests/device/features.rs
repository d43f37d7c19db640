//! Core with some of its features only: every choice that makes sense builds for the device without a warning.

use asperity_needs::absent;

use crate::emulator::build;
const CHOICES: [&str; 19] = [
    "",
    "f32",
    "f64",
    "f32,fast",
    "f32,ggx,air,transmission",
    "f32,ggx,air,reflection",
    "f64,fast,ggx,air,dielectric,reflection,transmission",
    "f64,normals,air,dielectric,transmission",
    "f32,fast,normals,air,dielectric,reflection,transmission",
    "f32,microfacet,air,dielectric,reflection,transmission",
    "f32,tails,air,transmission",
    "f64,tails,air,dielectric,reflection,transmission",
    "table,air,transmission",
    "table,fast,dielectric,reflection",
    "table,ggx,normals",
    "checksum,air,transmission",
    "slot,air,reflection,fast",
    "f32,gonio",
    "protocol",
];

#[test]
fn core_builds_without_warnings_for_any_choice_of_features() {
    for choice in CHOICES {
        let arguments =
            ["--package", "asperity-core", "--no-default-features", "--features", choice];
        if let Err(remedy) = build(&arguments, "-Dwarnings") {
            return absent(&remedy);
        }
    }
}
