//! The command line as a user meets it: the real program, run in a folder of its own.
//!
//! | module | what it holds |
//! |---|---|
//! | `program` | where the program is, and how it is run |
//! | `refusal` | how a refusal is judged |
//! | `help` | help, version, completions |
//! | `effect` | flags without effect, short help, old names, how much is said |
//! | `snapshots` | help, JSON, tables and errors held still |
//! | `book` | the commands of the user guide |
//! | `bounces`, `mix` | options of laws, from the model to its evaluators |
//! | `happy` | every verb does what it says |
//! | `maps` | `stats` on height maps |
//! | `atlas` | true errors of waves and rays beside the verdict |
//! | `instruments` | files of many instruments, several maps in a file |
//! | `map_verbs` | light on height maps |
//! | `hybrid` | rays and waves on one map |
//! | `compare` | every method side by side |
//! | `trade` | error against cost of every evaluator |
//! | `plan` | what a scene requires, and verbs that do what a plan says |
//! | `tables` | tables in place of models |
//! | `exchange` | models in the formats of other programs, and scans from them |
//! | `foreign` | scatter as other programs write it |
//! | `malformed` | every mistake is answered in a line or two, and nothing is written |
//! | `malformed_maps` | the same for files of height maps, in bounded memory |
//! | `map_files` | height maps of all formats, made here |
//! | `extreme_maps` | maps at the edge of what is one |
//! | `endless_inputs` | devices, folders and pipes given as files |
//! | `units` | units of height maps: read, or asked for |
//! | `doubtful_maps` | maps too steep, hardly measured, of pixels that no map has |
//! | `no` | exit status 1: all went well and the answer is no |
//! | `determinism` | the same seed gives the same bits, for any number of threads |
//! | `custody` | no output is an input, or another output |
//! | `full_disk` | full disks, streams that nobody reads |
//! | `interrupt` | Ctrl-C keeps what is finished |
//! | `signals` | signals at any moment of any verb |
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "in a test a panic is the report"
)]

mod program;
mod refusal;
mod render;
mod samples;
mod help;
mod effect;
mod snapshots;
mod atlas;
mod believe;
mod book;
mod bounces;
mod merge;
mod mix;
mod grooves;
mod happy;
mod maps;
mod instruments;
mod stats_waves;
mod map_verbs;
mod wave;
mod hybrid;
mod compare;
mod trade;
mod plan;
mod plot;
mod tables;
mod exchange;
mod foreign;
mod malformed;
mod map_files;
mod malformed_maps;
mod extreme_maps;
#[cfg(unix)]
mod endless_inputs;
mod units;
mod doubtful_maps;
mod doubtful_scans;
mod no;
mod determinism;
mod custody;
#[cfg(unix)]
mod full_disk;
#[cfg(unix)]
mod interrupt;
#[cfg(unix)]
mod signals;
