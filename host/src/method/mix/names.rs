//! Names of parameters and references that only a mix has, kept for the life of the program.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

type References = &'static [&'static str];

static SECOND: Mutex<BTreeMap<String, &'static str>> = Mutex::new(BTreeMap::new());
static TOGETHER: Mutex<BTreeMap<Vec<&'static str>, References>> = Mutex::new(BTreeMap::new());

/// The name of a parameter of the second law: there are some dozens in all.
pub(super) fn second(name: &str) -> &'static str {
    let mut all = SECOND.lock().unwrap_or_else(PoisonError::into_inner);
    all.entry(name.to_owned()).or_insert_with(|| Box::leak(format!("{name}2").into_boxed_str()))
}

/// The references of several methods, each once.
pub(super) fn together(parts: impl Iterator<Item = References>) -> References {
    let mut each: Vec<&'static str> = Vec::new();
    for reference in parts.flatten() {
        if !each.contains(reference) {
            each.push(reference);
        }
    }
    let mut all = TOGETHER.lock().unwrap_or_else(PoisonError::into_inner);
    all.entry(each.clone()).or_insert_with(|| Box::leak(each.into_boxed_slice()))
}
