//! Reading any CSV file whose columns are named by a [`ColumnMap`].
//!
//! Lines that begin with `#` are comments: the program does not interpret the header of such a file; flags give what
//! is needed of it. A file without headings is read by column numbers alone.

use std::path::Path;

use super::columns::ColumnMap;
use super::csv::{load, text};
use super::error::{ScanError, ScanFault};
use super::select::SelectionFault;
use super::table::{Role, Table};
use super::{Measurement, Metadata, Quantity, Reading, Selection};

/// The import of a foreign file.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// Which column is what.
    pub columns: ColumnMap,
    /// The quantity of the readings, which a foreign file cannot give.
    pub quantity: Quantity,
    /// The angles used; rows outside are not read.
    pub selection: Selection,
    /// Whether rows without a measured value (nothing, `nan`, `NA`, infinite) are left out; they
    /// are an error otherwise.
    pub skip_missing: bool,
}

/// The counts of the rows of a foreign file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowCounts {
    /// All rows below the headings.
    pub total: usize,
    /// Rows that became readings.
    pub kept: usize,
    /// Rows that a filter left out.
    pub filtered: usize,
    /// Rows outside the selected angles.
    pub out_of_range: usize,
    /// Rows without a measured value, left out on request.
    pub missing: usize,
}

impl Import {
    /// Reads a foreign file. The header of the result holds the quantity and nothing else.
    ///
    /// # Errors
    /// [`ScanError`] with the place and the remedy.
    pub fn read(&self, path: impl AsRef<Path>) -> Result<(Measurement, RowCounts), ScanError> {
        let path = path.as_ref();
        self.parse(load(path)?, path)
    }

    /// Reads the content of a foreign file; `name` is the path that errors show.
    ///
    /// # Errors
    /// [`ScanError`] with the place and the remedy.
    pub fn parse(
        &self,
        bytes: impl AsRef<[u8]>,
        name: impl AsRef<Path>,
    ) -> Result<(Measurement, RowCounts), ScanError> {
        let name = name.as_ref();
        let text = text(bytes.as_ref(), name)?;
        let table = Table::read(text, &self.columns, name)?;
        table.check_filters()?;
        let mut counts = RowCounts { total: table.rows.len(), ..RowCounts::default() };
        let (mut readings, mut rows, mut outside) = (Vec::new(), Vec::new(), Vec::new());
        for (row, record) in table.rows.iter().enumerate() {
            if !table.passes(record) {
                counts.filtered += 1;
                continue;
            }
            let [sigma, theta] = [table.value(row, Role::Sigma)?, table.value(row, Role::Theta)?];
            if let (Some(sigma), Some(theta)) = (sigma, theta)
                && !self.selection.contains(sigma, theta)
            {
                counts.out_of_range += 1;
                outside.push((sigma, theta));
                continue;
            }
            let (value, phi) = (table.value(row, Role::Reading)?, table.phi(row)?);
            let role = match (sigma, theta, value, phi) {
                (Some(sigma_deg), Some(theta_deg), Some(value), Some(phi_deg)) => {
                    let azimuth = if theta_deg < 0.0 { phi_deg + 180.0 } else { phi_deg };
                    readings.push(Reading::at(sigma_deg, [theta_deg.abs(), azimuth], value));
                    rows.push(row);
                    continue;
                }
                (None, ..) => Role::Sigma,
                (_, None, ..) => Role::Theta,
                (_, _, None, _) => Role::Reading,
                _ => Role::Phi,
            };
            if !self.skip_missing {
                return Err(table.missing(row, role));
            }
            counts.missing += 1;
        }
        counts.kept = readings.len();
        if counts.kept == 0 {
            let fault = if counts.missing > 0 {
                ScanFault::AllMissing(counts.missing)
            } else if counts.out_of_range > 0 {
                let covered = Selection::covering(outside.into_iter());
                SelectionFault::Nothing { asked: self.selection, covered }.into()
            } else if counts.filtered > 0 {
                ScanFault::NoJointMatch
            } else {
                ScanFault::NoRows
            };
            return Err(ScanError::new(name, fault));
        }
        let meta = Metadata { quantity: Some(self.quantity), ..Metadata::default() };
        let invalid = |error| ScanError::of_reading(name, error, |index| table.line(rows[index]));
        Ok((Measurement::new(meta, readings).map_err(invalid)?, counts))
    }
}

#[cfg(test)]
mod tests {
    use super::super::columns::Column;
    use super::*;

    fn import(columns: &str, filters: &[&str]) -> Import {
        let map: ColumnMap = columns.parse().unwrap();
        let columns = filters.iter().fold(map, |map, filter| map.with_filter(filter).unwrap());
        let selection = Selection::default();
        Import { columns, quantity: Quantity::Bsdf, selection, skip_missing: false }
    }

    const FILE: &str = "# remark\r\nname,t,\"s, deg\",f\r\n\r\n# more\r\nA,1,0,2\r\nB,1,0,nan\r\n\
                        # a remark\r\n\"A\",2,0,\r\nA,3,90,1\r\nA,4,10,dark\r\n";

    #[test]
    fn measured_aluminium_is_read() {
        let Some(path) = asperity_needs::data("scatter/jsss-mwir-brdf/inplane_radiance_brdf.csv")
        else {
            return;
        };
        let map = "sigma=theta_i_deg,theta=theta_o_deg,reading=brdf_per_sr";
        let mut import = import(map, &["surface=Alu sandgestrahlt"]);
        import.selection.sigma = "5:75".parse().unwrap();
        import.selection.theta = "-60:60".parse().unwrap();
        let (scan, counts) = import.read(&path).unwrap();
        assert_eq!((scan.readings().len(), scan.incidences().len()), (497, 71));
        assert_eq!(scan.quantity(), Quantity::Bsdf);
        assert_eq!((counts.total, counts.filtered, counts.out_of_range), (10_800, 9_900, 403));
        assert_eq!((counts.kept, counts.missing), (497, 0));
        import.selection = Selection::default();
        let error = import.read(&path).unwrap_err();
        assert!(error.line.is_some() && error.to_string().contains("--skip-missing"), "{error}");
    }

    #[test]
    fn rows_are_filtered_counted_and_found_again() {
        let mut import = import("sigma=s; deg,theta=2,reading=f", &["name=A"]);
        import.columns.sigma = Column::Name("s, deg".to_owned());
        import.skip_missing = true;
        import.selection.sigma = "0:5".parse().unwrap();
        let (scan, counts) = import.parse(FILE, "f.csv").unwrap();
        assert_eq!(scan.readings(), [Reading::in_plane(0.0, 1.0, 2.0)]);
        let expected = RowCounts { total: 5, kept: 1, filtered: 1, out_of_range: 2, missing: 1 };
        assert_eq!(counts, expected);
        import.skip_missing = false;
        let error = import.parse(FILE, "f.csv").unwrap_err().to_string();
        assert!(error.starts_with("f.csv:8, column f: ``"), "{error}");
    }

    #[test]
    fn numbers_alone_read_a_file_without_headings() {
        let mut import = import("sigma=2,theta=1,reading=3", &["4=0.50"]);
        import.columns = import.columns.with_delimiter(";").unwrap();
        import.columns.decimal_comma = true;
        let (scan, _) = import.parse("1,5;0;2,5;0,5\n2;0;3;0,6\n", "f.csv").unwrap();
        assert_eq!(scan.readings(), [Reading::in_plane(0.0, 1.5, 2.5)]);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_line_and_remedy() {
        let map = "sigma=3,theta=t,reading=f";
        let cases: [(&str, &[&str], &str, &[&str]); 10] = [
            (
                "sigma=3,theta=t,reading=g",
                &[],
                FILE,
                &["f.csv:2: ", "no column `g`", "`name`, `t`"],
            ),
            ("sigma=3,theta=t,reading=9", &[], FILE, &["f.csv:2: ", "no column `9`"]),
            (map, &["name=C"], FILE, &["f.csv: ", "`C`", "`A`, `B`", "--where"]),
            (map, &["name=B", "t=2"], FILE, &["all of --where together"]),
            (
                map,
                &["name=B"],
                FILE,
                &["f.csv:6, column f: `nan`", "--sigma-range", "--skip-missing"],
            ),
            (map, &["t=3"], FILE, &["f.csv:9: ", "incidence 90", "--sigma-range"]),
            (map, &["t=4"], FILE, &["f.csv:10, column f: `dark`"]),
            (map, &[], "name;t;s;f\nA;1;2;3\n", &["f.csv:1: ", "--delimiter"]),
            (map, &[], "n,t,s,f\nA,1,2,3\nA,1\n", &["f.csv:3, column 3: ", "column 3 is needed"]),
            (map, &[], "n,t,s,f\n#x\nA,1,2,3\n\nB,1,2,3\n", &["f.csv:5: ", "line 3", "--where"]),
        ];
        for (columns, filters, text, words) in cases {
            let message = import(columns, filters).parse(text, "f.csv").unwrap_err().to_string();
            for word in words {
                assert!(
                    message.contains(word),
                    "{columns} {filters:?}: {word} is not in: {message}"
                );
            }
        }
    }
}
