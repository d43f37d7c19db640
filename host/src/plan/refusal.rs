//! Why there is no plan.

use super::record::Plan;

/// Why there is no plan.
#[derive(Debug, thiserror::Error)]
pub enum NoPlan {
    /// The scene, or a file that it names, cannot be used.
    #[error("{0}")]
    Bad(String),
    /// The scene asks for what cannot be done.
    #[error("{}", .0.sentence())]
    Impossible(Box<Impossible>),
}

/// What cannot be done.
#[derive(Clone, Debug)]
pub struct Impossible {
    /// The nearest plan that can.
    pub nearest: Option<Plan>,
    /// What stands in the way, a sentence each.
    pub obstacles: Vec<String>,
    /// The bound that was asked, %.
    pub asked_percent: f64,
}

impl Impossible {
    /// Both in one sentence.
    pub fn sentence(&self) -> String {
        let asked = self.asked_percent;
        let nearest = match &self.nearest {
            Some(plan) => format!(
                "; the nearest that is possible errs by {:.3} %{}",
                plan.predicted.error_percent.abs(),
                plan.costs.bytes.map(|b| format!(" with {b} bytes")).unwrap_or_default()
            ),
            None => String::new(),
        };
        format!(
            "the scene cannot have {asked} %{nearest}. In the way: {}",
            self.obstacles.join("; ")
        )
    }
}
