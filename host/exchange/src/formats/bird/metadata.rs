//! What a file says of the sample, the instrument and its origin.

use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value as Json, json};

use crate::formats::own;
use crate::sampled::{Lobe, SampledBsdf};

const SCHEMA: &str = "https://raw.githubusercontent.com/BiRD-project/BiRD_view/master/BRDF_JSON_schema/brdf_json_schema_v1.0.json";

/// Notes of a file, and its comments.
pub(super) fn notes(metadata: &Json) -> (Vec<String>, String) {
    let text = |path: &str| metadata.pointer(path).and_then(Json::as_str);
    let mut notes = Vec::new();
    for (title, path) in [
        ("Sample", "/sample/name"),
        ("Sample type", "/sample/type"),
        ("Description", "/description"),
        ("Method", "/method"),
        ("Instrument", "/instrumentation/name"),
        ("Software", "/software/name"),
        ("Organization", "/provenance/organization"),
        ("License", "/license/type"),
        ("Rights holder", "/license/rights_holder"),
        ("Time", "/timestamp"),
    ] {
        if let Some(value) = text(path).filter(|value| !value.is_empty() && *value != "NA") {
            notes.push(format!("{title}: {value}"));
        }
    }
    let comments = text("/comments").unwrap_or("").to_owned();
    let others = comments.lines().filter(|line| !own::is_own(line) && !line.trim().is_empty());
    notes.extend(others.map(str::to_owned));
    (notes, comments)
}

/// The metadata of lobes; what is not known is `NA`.
pub(super) fn of(lobes: &[SampledBsdf]) -> Json {
    let mut comments: Vec<String> = lobes.first().map(own::lines).unwrap_or_default();
    if lobes.iter().any(|lobe| lobe.lobe == Lobe::Transmission) {
        comments.push(
            "theta_r above 90 deg is transmission (an extension: the schema is of reflection)"
                .into(),
        );
    }
    let sample = comments.iter().find_map(|note| note.strip_prefix("Sample:"));
    let sample = sample.unwrap_or("NA").trim().to_owned();
    json!({
        "schema": SCHEMA,
        "id": "urn:asperity:bsdf",
        "type": "BRDF",
        "timestamp": timestamp(),
        "provenance": {
            "organization": "NA",
            "location": {
                "country": "NA", "city": "NA", "street": "NA", "building_nr": "NA", "postal_code": "NA"
            },
            "email": "NA@example.org",
            "contact_person": "NA"
        },
        "description": "BSDF sampled on a grid of angles.",
        "method": "simulation",
        "instrumentation": "NA",
        "software": { "name": "Asperity", "version": env!("CARGO_PKG_VERSION") },
        "sample": {
            "name": sample, "type": "NA", "shape": "NA", "dimensions": {}, "zero_azimuth_location": "x axis"
        },
        "environment": "NA",
        "comments": comments.join("\n")
    })
}

/// The time now, as RFC 3339 in UTC.
fn timestamp() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    let [year, month, day] = civil(days);
    let [h, m, s] = [second / 3600, second / 60 % 60, second % 60];
    format!("{year:04}-{month:02}-{day:02}T{h:02}:{m:02}:{s:02}Z")
}

/// The date of a day from 1970-01-01, in the Gregorian calendar (H. Hinnant, "chrono-compatible low-level date algorithms").
fn civil(days: u64) -> [u64; 3] {
    let z = days + 719_468;
    let (era, of_era) = (z / 146_097, z % 146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let shifted = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    [year + era * 400 + u64::from(month <= 2), month, day]
}

#[cfg(test)]
mod tests {
    use super::civil;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(civil(0), [1970, 1, 1]);
        assert_eq!(civil(59), [1970, 3, 1]);
        // 2000 is a leap year: 30 years with 7 leap days, then 59 days
        assert_eq!(civil(30 * 365 + 7 + 59), [2000, 2, 29]);
        assert_eq!(civil(30 * 365 + 7 + 60), [2000, 3, 1]);
    }
}
