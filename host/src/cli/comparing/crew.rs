//! Several fits at once, as many as memory allows.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Condvar, Mutex, PoisonError};

use rayon::ThreadPoolBuilder;

use crate::output::internal;

/// Work with the memory that it takes.
pub(super) struct Job<T> {
    pub(super) what: T,
    pub(super) bytes: u64,
}

/// What is still to be done, and the memory that is free for it.
struct Queue<T> {
    waiting: VecDeque<Job<T>>,
    free: u64,
    running: usize,
}

/// Does all jobs, `workers` at once and in their order as far as `budget` bytes allow; one that needs more than that runs
/// alone. Each job has as many threads as there are: what one cannot use another does, and the system shares them fairly.
pub(super) fn carry_out<T: Send>(
    jobs: Vec<Job<T>>,
    (workers, budget): (usize, u64),
    work: &(dyn Fn(T) + Sync),
) {
    let workers = workers.clamp(1, jobs.len().max(1));
    let queue = Mutex::new(Queue { waiting: jobs.into(), free: budget, running: 0 });
    let changed = Condvar::new();
    let lock = || queue.lock().unwrap_or_else(PoisonError::into_inner);
    let worker = || {
        let mut here = lock();
        while !here.waiting.is_empty() {
            let Some(Job { what, bytes }) = here.next() else {
                here = changed.wait(here).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            let taken = bytes.min(here.free);
            here.free -= taken;
            here.running += 1;
            drop(here);
            // threads of its own, or a job with little to do would wait for one with much
            match ThreadPoolBuilder::new().build() {
                Ok(threads) if workers > 1 => threads.install(|| work(what)),
                _ => work(what),
            }
            here = lock();
            here.free += taken;
            here.running -= 1;
            changed.notify_all();
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..workers {
            scope.spawn(worker);
        }
        worker();
    });
}

impl<T> Queue<T> {
    /// The first job for which there is memory; if none runs, the first.
    fn next(&mut self) -> Option<Job<T>> {
        let fits = self.waiting.iter().position(|job| job.bytes <= self.free);
        let place = fits.or((self.running == 0).then_some(0))?;
        self.waiting.remove(place)
    }
}

/// Half of the memory that the system has to give, bytes; much where it does not say.
pub(super) fn usual_budget() -> u64 {
    let text = internal::text(Path::new("/proc/meminfo"));
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kib = line.and_then(|rest| rest.split_whitespace().next()?.parse::<u64>().ok());
    kib.map_or(8 << 30, |kib| kib * 512)
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

    use super::{Job, carry_out};

    #[test]
    fn jobs_run_at_once_as_far_as_memory_allows() {
        for (workers, budget, most) in [(3, 100, 2), (1, 1000, 1), (8, 1000, 8), (8, 10, 1)] {
            let (used, largest) = (AtomicU64::new(0), AtomicU64::new(0));
            let (running, at_once) = (AtomicUsize::new(0), AtomicUsize::new(0));
            let done = Mutex::new(Vec::new());
            let jobs = (0..20).map(|what| Job { what, bytes: 40 }).collect();
            carry_out(jobs, (workers, budget), &|what: u64| {
                largest.fetch_max(used.fetch_add(40, Ordering::SeqCst) + 40, Ordering::SeqCst);
                at_once.fetch_max(running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                std::thread::sleep(std::time::Duration::from_millis(2));
                running.fetch_sub(1, Ordering::SeqCst);
                used.fetch_sub(40, Ordering::SeqCst);
                done.lock().unwrap().push(what);
            });
            let mut done = done.into_inner().unwrap();
            done.sort_unstable();
            assert_eq!(done, (0..20).collect::<Vec<_>>());
            assert!(at_once.into_inner() <= most, "{workers} {budget}");
            assert!(largest.into_inner() <= budget.max(40), "{workers} {budget}");
        }
    }
}
