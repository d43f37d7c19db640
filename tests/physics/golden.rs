//! Tables of `golden` beside those of other programs, where the shared reference data are.

use asperity_tests::{data, golden};

/// Keys of a row and its value.
type Row = (Vec<f64>, f64);

/// Rows of numbers; words count as the length they have.
fn rows(text: &str, keys: usize, value: usize) -> Vec<Row> {
    let number = |cell: &str| match cell.trim() {
        "refl_air" => Some(0.0),
        "trans_air_to_n" => Some(1.0),
        "trans_n_to_air" => Some(2.0),
        number => number.parse().ok(),
    };
    let row = |line: &str| -> Option<Row> {
        let cells: Vec<f64> = line.split(',').map(number).collect::<Option<_>>()?;
        Some((cells[..keys].to_vec(), cells[value]))
    };
    text.lines().filter(|line| !line.starts_with('#')).filter_map(row).collect()
}

/// A table and that of another program: file, columns of its keys, its value, and what may differ.
struct Pair {
    ours: (&'static str, usize, usize),
    theirs: (&'static str, usize),
    /// Relative, of values above the last.
    relative: f64,
    absolute: f64,
}

/// Figures are given to nine digits at angles rounded to 1e-6 or 1e-3 degrees; coupled waves are right to some 1e-4.
const PAIRS: [Pair; 5] = [
    Pair {
        ours: ("facets.csv", 3, 3),
        theirs: ("facet_gauss_slope_s0.1_n1.49.csv", 4),
        relative: 2e-5,
        absolute: 1e-12,
    },
    Pair {
        ours: ("perturbation.csv", 3, 3),
        theirs: ("rayleigh_rice_sigma0.01_L2_n1.49_lam0.55.csv", 3),
        relative: 1e-7,
        absolute: 1e-12,
    },
    Pair {
        ours: ("gratings.csv", 3, 3),
        theirs: ("rcw_sinusoid_transmission_n1.49_lam0.55.csv", 3),
        relative: 0.0,
        absolute: 2e-4,
    },
    Pair {
        ours: ("kirchhoff_gaussian.csv", 5, 5),
        theirs: ("kirchhoff_gaussian_scalar.csv", 5),
        relative: 1e-7,
        absolute: 1e-30,
    },
    Pair {
        ours: ("kirchhoff_gaussian.csv", 5, 6),
        theirs: ("kirchhoff_gaussian_scalar.csv", 6),
        relative: 1e-6,
        absolute: 2e-9,
    },
];

#[test]
fn tables_of_the_tree_are_those_of_other_programs() {
    for Pair { ours: (name, keys, value), theirs: (file, other), relative, absolute } in PAIRS {
        let Some(path) = data::find(&format!("reference/{file}")) else { return };
        let theirs = rows(&std::fs::read_to_string(path).unwrap(), keys, other);
        let ours = rows(&golden::text(name), keys, value);
        let (mut seen, mut worst) = (0, 0.0_f64);
        for (keys, found) in &ours {
            let same = |row: &&Row| row.0.iter().zip(keys).all(|(a, b)| (a - b).abs() < 2e-6);
            let Some((_, expected)) = theirs.iter().find(same) else { continue };
            let off = (found - expected).abs();
            assert!(
                off <= relative * expected.abs() + absolute,
                "{name} {keys:?} {found} {expected}"
            );
            worst = worst.max(off / expected.abs().max(absolute));
            seen += 1;
        }
        println!("{name} and {file}: {seen} of {} rows, worst {worst:.1e}", ours.len());
        assert!(seen > 50, "{name} {seen}");
    }
}
