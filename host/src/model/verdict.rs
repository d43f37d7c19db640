//! What a fit is worth: its grade, its causes, and the figures that they rest on.

use std::fmt;

use serde::{Deserialize, Serialize};

/// How far a fit can be trusted, from the best to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Grade {
    /// What is left is noise.
    WithinNoise,
    /// The law describes the readings, with deviations that are no noise.
    Misfit,
    /// Values that the readings do not determine.
    NotIdentifiable,
    /// The law does not describe the readings, or the fit did not end.
    NotDescribed,
    /// More light than there is.
    Unphysical,
}

impl Grade {
    /// Whether the fit may be used: within noise, or with a misfit that is said.
    pub fn is_accepted(self) -> bool {
        matches!(self, Self::WithinNoise | Self::Misfit)
    }

    /// The word in files.
    pub fn word(self) -> &'static str {
        match self {
            Self::WithinNoise => "within-noise",
            Self::Misfit => "misfit",
            Self::NotIdentifiable => "not-identifiable",
            Self::NotDescribed => "not-described",
            Self::Unphysical => "unphysical",
        }
    }
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::WithinNoise => "within noise",
            Self::Misfit => "systematic misfit",
            Self::NotIdentifiable => "not identifiable",
            Self::NotDescribed => "does not describe",
            Self::Unphysical => "unphysical",
        })
    }
}

/// The verdict about a fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verdict {
    /// The grade.
    pub grade: Grade,
    /// Why it is not the best one, in plain words: first what is wrong, then what would explain it.
    #[serde(default)]
    pub causes: Vec<String>,
    /// The error of eq. (18) over the noise of the measurement; `None` if that is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub times_noise: Option<f64>,
    /// The incidence described worst, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst_sigma_deg: Option<f64>,
    /// By how much the fitted peak lies beside the measured one there, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peak_off_deg: Option<f64>,
    /// Rms of `log10(fitted / measured)` above the noise floor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tail_score: Option<f64>,
}

impl Verdict {
    /// In one sentence.
    pub fn sentence(&self) -> String {
        let mut parts = vec![self.grade.to_string()];
        if self.grade == Grade::WithinNoise {
            return parts.join(", ");
        }
        if let Some(times) = self.times_noise.filter(|t| t.is_finite()) {
            let digits = usize::from(times < 99.5) + usize::from(times < 9.95);
            parts.push(format!("{times:.digits$} times the noise"));
        }
        if let Some(off) = self.peak_off_deg.filter(|off| off.abs() > 0.0) {
            parts.push(format!("peak off by {off:.2} deg"));
        }
        if let Some(sigma) = self.worst_sigma_deg {
            parts.push(format!("worst at sigma {sigma} deg"));
        }
        parts.join(", ")
    }

    /// Why the fit is refused, in plain words; `None` if it may be used.
    pub fn refusal(&self) -> Option<String> {
        if self.grade.is_accepted() {
            return None;
        }
        Some(match &self.causes[..] {
            [] => self.sentence(),
            // the first of these says it already
            causes if self.grade == Grade::NotDescribed => causes.join("; "),
            causes => format!("{}: {}", self.grade, causes.join("; ")),
        })
    }
}

/// Where the flux of one incidence goes, as fractions of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flux {
    /// `air` or `dielectric`.
    pub side: String,
    /// Angle of incidence in that medium, degrees.
    pub incidence_deg: f64,
    /// Reflected.
    pub reflected: f64,
    /// Transmitted.
    pub transmitted: f64,
    /// Neither.
    pub lost: f64,
    /// Standard uncertainty of `reflected`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_reflected: Option<f64>,
    /// Standard uncertainty of `transmitted`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_transmitted: Option<f64>,
}

/// What one source of uncertainty adds to fitted values, a row of a budget.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contribution {
    /// The source: noise, gain, drift, zero of theta ...
    pub source: String,
    /// Its standard deviation, in its unit; relative if that is empty, and 0 for noise.
    pub std_dev: f64,
    /// The unit of that.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// The standard uncertainty that it adds to each value, by the name of the parameter.
    pub effects: Vec<(String, f64)>,
}

/// Correlation of the errors of two fitted parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Correlation {
    /// Their names.
    pub of: [String; 2],
    /// -1 to 1.
    pub r: f64,
}

impl Correlation {
    /// Of a matrix, each pair once.
    pub fn all(names: &[&str], matrix: &[Vec<f64>]) -> Vec<Self> {
        let mut found = Vec::new();
        for (i, row) in matrix.iter().enumerate() {
            for (j, r) in row.iter().enumerate().skip(i + 1) {
                if let (Some(a), Some(b)) = (names.get(i), names.get(j))
                    && r.is_finite()
                {
                    found.push(Self { of: [(*a).into(), (*b).into()], r: *r });
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::{Correlation, Grade, Verdict};

    #[test]
    fn a_verdict_is_a_sentence_and_a_word() {
        let verdict = Verdict {
            grade: Grade::Misfit,
            causes: vec!["percent".into()],
            times_noise: Some(36.04),
            worst_sigma_deg: Some(60.0),
            peak_off_deg: Some(-1.5),
            tail_score: None,
        };
        let said =
            "systematic misfit, 36.0 times the noise, peak off by -1.50 deg, worst at sigma 60 deg";
        assert_eq!(verdict.sentence(), said);
        assert_eq!(verdict.refusal(), None);
        let refused = Verdict { grade: Grade::Unphysical, ..verdict };
        assert_eq!(refused.refusal().unwrap(), "unphysical: percent");
        let json = serde_json::to_string(&refused).unwrap();
        assert!(json.contains(r#""grade":"unphysical""#), "{json}");
        assert!(Grade::NotDescribed < Grade::Unphysical && Grade::Misfit.is_accepted());
        assert_eq!(serde_json::from_str::<Verdict>(&json).unwrap(), refused);
    }

    #[test]
    fn each_pair_stands_once() {
        let matrix = vec![vec![1.0, 0.5], vec![0.5, 1.0]];
        let all = Correlation::all(&["a", "b"], &matrix);
        assert_eq!(all, [Correlation { of: ["a".into(), "b".into()], r: 0.5 }]);
    }
}
