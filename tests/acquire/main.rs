//! Acquisition against the simulated instrument: whole scans, bad lines, broken machines, killed clients.
//!
//! In this process on a clock of its own (`soak`; `unfaithful`, which goes through the `misdeeds` of a
//! `hostile` instrument), and as programs at the two ends of a pseudo terminal or a
//! TCP connection (`whole`, `killed`, `misbehaving`).
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests may fail")]

mod bench;
mod hostile;
mod killed;
mod misbehaving;
mod misdeeds;
mod programs;
mod signalled;
mod soak;
mod unfaithful;
mod whole;
