//! Writing the standard scan file.

use std::io::{self, Write};

use super::csv::COLUMNS;
use super::{Measurement, Reading};

/// Writes a measurement as a standard scan file, which [`csv::read`](super::csv::read) reads back.
///
/// Angles are written with as many digits as they need, readings with ten. A line break or another
/// control character inside a header value becomes a space.
///
/// # Errors
/// Those of `out`.
pub fn write(scan: &Measurement, mut out: impl Write) -> io::Result<()> {
    for (key, value) in scan.meta.entries() {
        writeln!(out, "# {}: {}", one_line(&key), one_line(&value))?;
    }
    // a scan in the plane of incidence needs no more than three columns
    let is_plain = scan.is_in_plane() && scan.readings()[0].rotation_deg <= 0.0;
    let columns = if is_plain { &COLUMNS[..3] } else { &COLUMNS[..5] };
    writeln!(out, "{}", columns.join(","))?;
    for Reading { sigma_deg, theta_deg, value, phi_deg, rotation_deg } in scan.readings() {
        write!(out, "{sigma_deg},{theta_deg},{value:.9e}")?;
        if !is_plain {
            write!(out, ",{phi_deg},{rotation_deg}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Metadata, Reading, csv};
    use super::*;

    fn written(scan: &Measurement) -> String {
        let mut bytes = Vec::new();
        write(scan, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn the_file_looks_as_the_contract_says() {
        let mut meta = Metadata::default();
        for (key, value) in
            [("note", "two\nlines"), ("ior", "1.49"), ("seed", "7"), ("sample", "5")]
        {
            meta.set(key, value).unwrap();
        }
        let reading = |theta_deg, value| Reading::in_plane(0.0, theta_deg, value);
        let scan = Measurement::new(meta, vec![reading(0.5, 1.0 / 3.0), reading(-89.9, -1e-5)]);
        let expected = "# sample: 5\n# ior: 1.49\n# seed: 7\n# note: two lines\n\
                        sigma_deg,theta_deg,reading\n0,-89.9,-1.000000000e-5\n0,0.5,3.333333333e-1\n";
        assert_eq!(written(&scan.unwrap()), expected);
    }

    #[test]
    fn a_written_scan_reads_back_as_itself() {
        let Some(path) = asperity_needs::data("samples/scan8.csv") else {
            return;
        };
        let scan = csv::read(path).unwrap();
        let text = written(&scan);
        assert_eq!(csv::parse(&text, "again.csv").unwrap(), scan);
        assert_eq!(written(&csv::parse(&text, "again.csv").unwrap()), text);
    }
}
