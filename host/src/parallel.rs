//! Loops over all cores whose machinery is compiled once. Generic code that calls rayon itself has a copy of it for each boundary: of the program
//! a third was that. Here the work is called through a pointer, once an item; items are worth that, a plane of readings or a tile of rays.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// What each of the numbers below `count` gives, in their order.
pub(crate) fn map<T: Send>(count: usize, one: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    let places: Vec<Mutex<Option<T>>> = (0..count).map(|_| Mutex::new(None)).collect();
    each(count, &|k| {
        let found = one(k);
        *places[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(found);
    });
    let found = places.into_iter().map(|p| p.into_inner().unwrap_or_else(PoisonError::into_inner));
    // every number has been called, or its panic has gone on
    found.flatten().collect()
}

/// What each item of a slice gives, in their order.
pub(crate) fn map_slice<S: Sync, T: Send>(items: &[S], one: &(dyn Fn(&S) -> T + Sync)) -> Vec<T> {
    map(items.len(), &|k| one(&items[k]))
}

/// Calls with every number below `count`.
pub(crate) fn each(count: usize, one: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(one);
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_found_stands_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..1000).map(|k| k * 7).collect();
        assert_eq!(super::map_slice(&items, &|x| x / 7), (0..1000).collect::<Vec<_>>());
        assert_eq!(super::map(0, &|k| k), Vec::<usize>::new());
    }

    #[test]
    #[should_panic(expected = "seven")]
    fn a_panic_goes_on() {
        super::map(20, &|k| assert!(k != 7, "seven"));
    }
}
