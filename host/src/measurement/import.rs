//! Reading any CSV file whose columns are named by a [`ColumnMap`].
//!
//! Lines that begin with `#` are comments; above the columns they may be a header, as in a standard file, and what the user says goes
//! before it. A file without headings is read by column numbers alone, or by names in the last comment above the numbers.
//! Encoding, separator and decimal mark are found in the file ([`layout`](super::layout)).

use std::path::Path;

use super::columns::ColumnMap;
use super::csv::{header, load};
use super::error::{ScanError, ScanFault};
use super::layout::Layout;
use super::select::SelectionFault;
use super::table::{Role, Table};
use super::text::decode;
use super::{Measurement, Reading, Selection, Stated};

/// The import of a foreign file.
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// Which column is what.
    pub columns: ColumnMap,
    /// What the numbers are; where it is not said the header must.
    pub quantity: Option<Stated>,
    /// Keys of the header that are not read because the user has said them.
    pub said: Vec<&'static str>,
    /// The angles used; rows outside are not read.
    pub selection: Selection,
    /// Whether rows without a measured value (nothing, `nan`, `NA`, infinite) are left out; they
    /// are an error otherwise.
    pub skip_missing: bool,
}

/// The counts of the rows of a foreign file, and how it is written.
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
    /// How the file is written.
    pub layout: Layout,
}

impl Import {
    /// Reads a foreign file.
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
        let (text, encoding) = decode(bytes.as_ref(), name)?;
        let mut said = self.said.clone();
        said.extend(self.quantity.map(|_| "quantity"));
        let mut meta = header(&text, name, &said)?;
        if let Some(stated) = self.quantity {
            meta.state(stated);
        } else if meta.quantity.is_none() {
            return Err(ScanError::new(name, ScanFault::NoQuantity));
        }
        let table = Table::read(&text, &self.columns, name)?;
        table.check_filters()?;
        let layout = Layout { encoding, ..table.layout };
        let mut counts = RowCounts { total: table.rows.len(), layout, ..RowCounts::default() };
        let (mut readings, mut rows, mut outside) = (Vec::new(), Vec::new(), Vec::new());
        for (row, record) in table.rows.iter().enumerate() {
            if !table.passes(record) {
                counts.filtered += 1;
                continue;
            }
            let [sigma, theta] = [table.angle(row, Role::Sigma)?, table.angle(row, Role::Theta)?];
            if let (Some(sigma), Some(theta)) = (sigma, theta)
                && !self.selection.contains(sigma, theta)
            {
                counts.out_of_range += 1;
                outside.push((sigma, theta));
                continue;
            }
            let value = table.value(row, Role::Reading)?;
            let [phi, rotation] = [table.angle(row, Role::Phi)?, table.angle(row, Role::Rotation)?];
            let role = match (sigma, theta, value, phi, rotation) {
                (Some(sigma), Some(theta), Some(value), Some(phi), Some(rotation)) => {
                    let azimuth = if theta < 0.0 { phi + 180.0 } else { phi };
                    let rotation_deg = rotation.rem_euclid(360.0);
                    let reading = Reading::at(sigma, [theta.abs(), azimuth], value);
                    readings.push(Reading { rotation_deg, ..reading });
                    rows.push(row);
                    continue;
                }
                (None, ..) => Role::Sigma,
                (_, None, ..) => Role::Theta,
                (_, _, None, ..) => Role::Reading,
                (_, _, _, None, _) => Role::Phi,
                _ => Role::Rotation,
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
        let invalid = |error| ScanError::of_reading(name, error, |index| table.line(rows[index]));
        Ok((Measurement::new(meta, readings).map_err(invalid)?, counts))
    }
}

#[cfg(test)]
mod tests {
    use super::super::columns::{AngleUnit, Column};
    use super::super::{Metadata, Quantity};
    use super::*;

    fn import(columns: &str, filters: &[&str]) -> Import {
        let map: ColumnMap = columns.parse().unwrap();
        let columns = filters.iter().fold(map, |map, filter| map.with_filter(filter).unwrap());
        let selection = Selection::default();
        let quantity = Some(Stated::Bsdf);
        Import { columns, quantity, said: Vec::new(), selection, skip_missing: false }
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
        let layout = Layout::default();
        let expected =
            RowCounts { total: 5, kept: 1, filtered: 1, out_of_range: 2, missing: 1, layout };
        assert_eq!(counts, expected);
        import.skip_missing = false;
        let error = import.parse(FILE, "f.csv").unwrap_err().to_string();
        assert!(error.starts_with("f.csv:8, column f: ``"), "{error}");
    }

    #[test]
    fn numbers_alone_read_a_file_without_headings() {
        let mut import = import("sigma=2,theta=1,reading=3", &["4=0.50"]);
        let found = import.clone();
        import.columns = import.columns.with_delimiter(";").unwrap();
        import.columns.decimal_comma = true;
        for import in [import, found] {
            let (scan, rows) = import.parse("1,5;0;2,5;0,5\n2;0;3;0,6\n", "f.csv").unwrap();
            assert_eq!(scan.readings(), [Reading::in_plane(0.0, 1.5, 2.5)]);
            assert_eq!(rows.layout.to_string(), "separated by `;`, with decimal commas");
        }
    }

    #[test]
    fn a_header_counts_and_what_the_user_says_goes_before_it() {
        let text =
            "# sample: x\n# ior: glass\n# quantity: ars\n# note: y\nt,s,f\n60,10,3\n# seed: -1\n";
        let mut import = import("sigma=s,theta=t,reading=f", &[]);
        import.quantity = None;
        let error = import.parse(text, "f.csv").unwrap_err().to_string();
        assert!(error.starts_with("f.csv:2: `glass`"), "{error}");
        import.said = vec!["ior"];
        let (scan, _) = import.parse(text, "f.csv").unwrap();
        let meta = Metadata {
            sample: Some("x".into()),
            quantity: Some(Quantity::Bsdf),
            other: vec![("note".into(), "y".into())],
            ..Metadata::default()
        };
        assert_eq!(scan.meta, meta);
        assert!((scan.readings()[0].value - 6.0).abs() < 1e-14);
        import.quantity = Some(Stated::Bsdf);
        let (scan, _) = import.parse(text.replace("ars", "lumen"), "f.csv").unwrap();
        assert_eq!(scan.readings(), [Reading::in_plane(10.0, 60.0, 3.0)]);
        import.quantity = None;
        let error = import.parse("t,s,f\n60,10,3\n", "f.csv").unwrap_err().to_string();
        assert!(error.contains("--quantity") && error.contains("# quantity: bsdf"), "{error}");
    }

    #[test]
    fn separators_decimal_marks_and_encodings_are_found() {
        let import = import("sigma=s,theta=t,reading=f", &[]);
        let expected = [Reading::in_plane(0.0, -1.5, 0.25), Reading::in_plane(0.5, 2.0, 1.25e-3)];
        let plain = "n,s,t,f\n\"a b\",0,-1.5,0.25\n\"c\",0.5,2,1.25e-3\n";
        let comma = plain.replace(',', ";").replace('.', ",");
        let tabs = plain.replace(',', "\t");
        let comma_tabs = comma.replace(';', "\t");
        let blanks = plain.replace(',', "   ").replace('\n', "  \n");
        let named = "# measured\n# s t f\n0 -1.5 0.25\n0.5 2 1.25e-3\n".to_owned();
        let wide: Vec<u8> = "\u{feff}"
            .encode_utf16()
            .chain(comma.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect();
        for (text, words) in [
            (plain.as_bytes(), ""),
            (comma.as_bytes(), "separated by `;`, with decimal commas"),
            (tabs.as_bytes(), "separated by tabs"),
            (comma_tabs.as_bytes(), "separated by tabs, with decimal commas"),
            (blanks.as_bytes(), "separated by blanks"),
            (named.as_bytes(), "separated by blanks"),
            (&wide, "UTF-16, separated by `;`, with decimal commas"),
        ] {
            let (scan, rows) = import.parse(text, "f.csv").unwrap();
            assert_eq!((scan.readings(), rows.layout.to_string().as_str()), (&expected[..], words));
        }
        // quoted numbers between commas
        let quoted = "s,t,f\n\"0\",\"-1,5\",\"0,25\"\n\"0,5\",2,\"1,25e-3\"\n";
        let (scan, rows) = import.parse(quoted, "f.csv").unwrap();
        assert_eq!(
            (scan.readings(), rows.layout.to_string().as_str()),
            (&expected[..], "with decimal commas")
        );
    }

    #[test]
    fn lines_are_counted_whatever_separates_values() {
        let import = import("sigma=s,theta=t,reading=f", &[]);
        for text in
            ["# a\n\ns t  f\n0  1 2\n\n0 2 dark\n", "# a\r\n\r\ns;t;f\r\n0;1;2\r\n\r\n0;2;dark"]
        {
            let error = import.parse(text, "f.csv").unwrap_err().to_string();
            assert!(error.starts_with("f.csv:6, column f: `dark`"), "{error}");
        }
        let error = import.parse("s;t;g\n0;1;2\n", "f.csv").unwrap_err().to_string();
        assert!(
            error.starts_with("f.csv:1: there is no column `f`; the columns are `s`"),
            "{error}"
        );
    }

    #[test]
    fn angles_in_radians_and_rotations_are_read() {
        let mut import = import("sigma=1,theta=2,reading=3,rotation=4,phi=5", &[]);
        import.columns.angles = AngleUnit::Radian;
        import.selection.sigma = "30:30".parse().unwrap();
        let sixth = std::f64::consts::FRAC_PI_6;
        let text = format!("{sixth},-{sixth},2,{},{sixth}\n1,0,1,0,0\n", -sixth);
        let (scan, _) = import.parse(text, "f.csv").unwrap();
        let expected =
            Reading { rotation_deg: 330.0, phi_deg: 30.0, ..Reading::in_plane(30.0, -30.0, 2.0) };
        assert_eq!(scan.readings(), [expected]);
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
            (map, &[], "name|t|s|f\nA|1|2|3\n", &["f.csv:1: ", "`,`", "--delimiter"]),
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
