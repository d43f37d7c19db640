//! A scene: where light comes from, the body with the rough face, what is wanted of it and how exactly, and what evaluates it.
//!
//! It is a TOML file ([`Scene::read`]); the examples ([`EXAMPLES`]) show every key. Lengths are in um and mm as their names
//! say, angles in degrees, wavelengths in nm. Whatever is not said is not known: nothing is guessed but the seed.

mod error;
mod content;
mod draft;
mod faults;
mod rays;
mod checked;
mod examples;
mod read;

pub use content::{
    Behind, Body, BodyKind, Emission, Face, Figures, Grasp, Quantity, Scene, Source, Statistics,
    Surface, Target, TargetKind, Wanted,
};
pub use error::SceneError;
pub use examples::{EXAMPLES, Example, example};
