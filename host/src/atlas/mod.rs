//! What Kirchhoff's integral, rays and single facets really err by, from rigorous solutions for grooved dielectric surfaces.
//!
//! ```
//! use asperity::atlas::{Engine, Measure, Question, quote};
//! use asperity_core::bsdf::Lobe;
//! use asperity_core::direction::Side;
//!
//! let question = Question {
//!     rq_over_lambda: 0.6,
//!     rms_slope: 0.25,
//!     ior: 1.49,
//!     incidence_deg: 15.0,
//!     side: Side::Air,
//!     lobe: Lobe::Transmission,
//!     engine: Engine::Kirchhoff,
//!     measure: Measure::Reading,
//! };
//! let found = quote(&question)?; // Result<Quote, Outside>
//! assert!(found.low_percent < found.error_percent && found.error_percent < found.high_percent);
//! assert!(found.high_percent < 1.0, "{found:?}");
//! # Ok::<(), asperity::atlas::Outside>(())
//! ```
//! Errors are those of eq. (18) for one lobe: rms over the angles of observation, in percent of the peak of the lobe in a window of
//! 2 degrees ([`Measure::Reading`]), or without the coherent light in percent of the peak of the diffuse light ([`Measure::Diffuse`]).
//!
//! `table` holds the solutions, `kriging` interpolates between them, `region` says which of them belong together, `answer` is the question
//! and its answer, `proof` leaves each surface out and predicts it from the others, `rows` asks for all lobes of a map, `words` says it of a measurement. What is
//! quoted holds for grooves with Gaussian heights and autocorrelation, and an index of 1.49; it quotes, and judges nothing: the verdict on waves is
//! that of [`crate::kirchhoff::validity`].

mod table;
mod kriging;
mod region;
mod answer;
mod proof;
mod rows;
mod words;

pub use answer::{Nearest, Outside, Question, Quote, quote};
pub use proof::{LeftOut, left_out};
pub use rows::{CAVEAT, EngineQuotes, Row, of_validity};
pub use table::{Engine, Measure, Solution, solutions};
pub use words::{Measured, Surface, two_digits};
