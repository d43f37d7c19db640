//! Flags that several verbs share, one file for each group of them.

pub(in crate::cli) mod stem;
pub(in crate::cli) mod scan;
pub(in crate::cli) mod method;
pub(in crate::cli) mod nuisance;
pub(in crate::cli) mod part;
pub(in crate::cli) mod rays;
pub(in crate::cli) mod map;
pub(in crate::cli) mod light;
pub(in crate::cli) mod waves;
pub(in crate::cli) mod subject;
pub(in crate::cli) mod clean;
pub(in crate::cli) mod effort;
pub(in crate::cli) mod sample;
pub(in crate::cli) mod port;
pub(in crate::cli) mod schedule;
