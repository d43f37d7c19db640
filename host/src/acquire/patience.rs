//! The limits of all waits.

use std::time::Duration;

/// Times and counts of waiting. Every wait ends, whatever comes over the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// For the answer to one request: 500 ms.
    pub answer: Duration,
    /// Number of times a request is sent: 6.
    pub tries: u32,
    /// Extra wait of the first repetition, doubled each time: 50 ms. The wait for an answer is thus 6.2 s in all.
    pub back_off: Duration,
    /// The longest back-off: 2 s.
    pub most_back_off: Duration,
    /// For the first answer of all: 5 s.
    pub identify: Duration,
    /// For a lost line to come back: 30 s.
    pub lost: Duration,
    /// For another client to give the instrument up: 6 s. One that was killed is forgotten in 5 s.
    pub in_use: Duration,
    /// Between two questions about progress: 200 ms, far below the 5 s after which an instrument considers its owner gone.
    pub poll: Duration,
    /// The longest time without a request to an owned instrument, however fast points come: 1 s.
    pub keep_alive: Duration,
    /// Extra time of a motion beyond twice its travel at its speed: 15 s.
    pub grace: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            answer: Duration::from_millis(500),
            tries: 6,
            back_off: Duration::from_millis(50),
            most_back_off: Duration::from_secs(2),
            identify: Duration::from_secs(5),
            lost: Duration::from_secs(30),
            in_use: Duration::from_secs(6),
            poll: Duration::from_millis(200),
            keep_alive: Duration::from_secs(1),
            grace: Duration::from_secs(15),
        }
    }
}

impl Patience {
    /// For the last requests to an instrument that may be gone: two tries of 300 ms, 2 s for all else.
    pub fn brief(self) -> Self {
        let short = Duration::from_secs(2);
        Self {
            answer: self.answer.min(Duration::from_millis(300)),
            tries: self.tries.min(2),
            identify: self.identify.min(short),
            lost: self.lost.min(short),
            ..self
        }
    }

    /// The back-off of try `k`, from 0.
    pub fn back_off(&self, k: u32) -> Duration {
        self.back_off
            .saturating_mul(1_u32.checked_shl(k).unwrap_or(u32::MAX))
            .min(self.most_back_off)
    }

    /// Time limit of a motion that should take `time`.
    pub fn motion(&self, time: Duration) -> Duration {
        time.saturating_mul(2).saturating_add(self.grace)
    }
}
