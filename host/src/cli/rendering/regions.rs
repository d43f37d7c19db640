//! Rectangles of the image: read, and their means written.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::json;

use crate::cli::error::Failure;
use crate::input;
use crate::render::tracer::region::{Mean, Region};

const COLUMNS: [&str; 5] = ["region", "x0", "y0", "x1", "y1"];

/// The rectangles of a CSV file with the columns region,x0,y0,x1,y1; others are left alone, as are lines with `#`.
pub(in crate::cli) fn read_regions(path: &Path, pixels: [u32; 2]) -> Result<Vec<Region>, Failure> {
    let name = path.display().to_string();
    let bytes = input::read_file(path, 1 << 24).map_err(|e| {
        Failure::bad(format!("{name}: {e}; give a CSV file with the columns {}", COLUMNS.join(",")))
    })?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(bytes.as_slice());
    let head = reader.headers().map_err(|e| Failure::bad(format!("{name}: {e}")))?.clone();
    let place = |column: &str| {
        head.iter().position(|h| h == column).ok_or_else(|| {
            Failure::bad(format!(
                "{name}: the column {column} is missing; it needs {}",
                COLUMNS.join(",")
            ))
        })
    };
    let places = COLUMNS.map(place);
    let mut at = [0; 5];
    for (slot, place) in at.iter_mut().zip(places) {
        *slot = place?;
    }
    let mut regions = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| Failure::bad(format!("{name}: {e}")))?;
        let line = record.position().map_or(0, csv::Position::line);
        let field = |k: usize| record.get(at[k]).unwrap_or_default();
        let number = |k: usize| {
            field(k).parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| {
                Failure::bad(format!(
                    "{name}:{line}: {} `{}` is not a number",
                    COLUMNS[k],
                    field(k)
                ))
            })
        };
        let (from, to) = ([number(1)?, number(2)?], [number(3)?, number(4)?]);
        let fits =
            (0..2).all(|k| from[k] >= 0.0 && from[k] < to[k] && to[k] <= f64::from(pixels[k]));
        if !fits {
            return Err(Failure::bad(format!(
                "{name}:{line}: region {}: it needs x0 < x1 <= {} and y0 < y1 <= {}, pixels of the image",
                field(0),
                pixels[0],
                pixels[1]
            )));
        }
        regions.push(Region { name: field(0).to_owned(), from, to });
    }
    if regions.is_empty() {
        return Err(Failure::bad(format!("{name}: it has no region; give a line for each")));
    }
    Ok(regions)
}

/// The means: of one model as they are, of several under their names.
pub(in crate::cli) fn region_text(
    regions: &[Region],
    found: &[(String, Vec<Mean>)],
    as_json: bool,
) -> String {
    if as_json {
        let list = |means: &[Mean]| {
            let one = |(r, m): (&Region, &Mean)| json!({"region": r.name, "mean": m.mean, "se": m.std_error});
            regions.iter().zip(means).map(one).collect::<Vec<_>>()
        };
        let model =
            |(name, means): &(String, Vec<Mean>)| json!({"model": name, "regions": list(means)});
        let value = match found {
            [one] => model(one),
            several => json!({ "models": several.iter().map(model).collect::<Vec<_>>() }),
        };
        return format!("{value:#}\n");
    }
    let mut text = String::from("model,region,x0,y0,x1,y1,mean_radiance,se\n");
    for (name, means) in found {
        for (r, m) in regions.iter().zip(means) {
            let ([x0, y0], [x1, y1]) = (r.from, r.to);
            let _ = writeln!(
                text,
                "{name},{},{x0},{y0},{x1},{y1},{:.6},{:.6}",
                r.name, m.mean, m.std_error
            );
        }
    }
    text
}
