//! The instrument as a client meets it: frames and text, on a clock that the test turns.

mod bench;
mod exchange;
mod line;
mod machine;
mod readings;
mod scans;
mod text;
