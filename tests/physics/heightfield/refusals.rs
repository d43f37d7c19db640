//! Maps that cannot be traced are refused with the reason; those that can take little memory.

use asperity::raytrace::{Field, FieldError};
use asperity::surface::{Edges, HeightMap};

use super::maps::EDGES;

fn refusal(size: (usize, usize), heights: Vec<f64>) -> FieldError {
    let map = HeightMap::new(size, (1.0, 1.0), heights).unwrap();
    let [a, b] = EDGES.map(|edges| Field::new(&map, edges).unwrap_err());
    assert_eq!(a, b);
    assert!(!a.to_string().is_empty());
    a
}

#[test]
fn what_cannot_be_traced_is_refused_with_its_reason() {
    let holed = vec![0.0, f64::NAN, 1.0, 2.0];
    assert_eq!(refusal((2, 2), holed), FieldError::Missing(25.0));
    assert_eq!(refusal((2, 1), vec![0.0; 2]), FieldError::Size { nx: 2, ny: 1 });
    assert_eq!(refusal((1, 9), vec![0.0; 9]), FieldError::Size { nx: 1, ny: 9 });
    let nx = Field::MOST_POINTS + 1;
    assert_eq!(refusal((nx, 2), vec![0.0; 2 * nx]), FieldError::Size { nx, ny: 2 });
    assert_eq!(refusal((2, nx), vec![0.0; 2 * nx]), FieldError::Size { nx: 2, ny: nx });
    assert_eq!(refusal((2, 2), vec![0.0, 0.0, 0.0, 2e6]), FieldError::Steep(2e6));
    // neither the range nor its middle is a number of double precision
    let most = f64::MAX;
    assert_eq!(refusal((2, 2), vec![-most, most, 0.0, 0.0]), FieldError::Steep(f64::INFINITY));
}

#[test]
fn the_largest_maps_that_are_allowed_are_taken() {
    let n = Field::MOST_POINTS;
    let map = HeightMap::new((n, 2), (1.0, 1.0), vec![0.5; 2 * n]).unwrap();
    assert_eq!(Field::new(&map, Edges::Periodic).unwrap().size(), (n, 2));
    assert_eq!(Field::new(&map, Edges::Mirrored).unwrap().size(), (n - 1, 1));
    let high = HeightMap::new((2, 2), (1.0, 1.0), vec![0.0, 0.0, 0.0, 1e6]).unwrap();
    assert!(Field::new(&high, Edges::Periodic).is_ok());
    // an offset is no roughness, however large
    let far = HeightMap::new((2, 2), (1.0, 1.0), vec![1e12; 4]).unwrap();
    assert!(Field::new(&far, Edges::Periodic).is_ok());
}

#[test]
fn a_field_takes_little_more_than_its_heights() {
    for n in [100, 1000, 4096] {
        let map = HeightMap::new((n, n), (1.0, 1.0), vec![0.0; n * n]).unwrap();
        for edges in EDGES {
            let bytes = Field::new(&map, edges).unwrap().bytes();
            assert!(bytes as f64 <= 2.5 * (4 * n * n) as f64, "{n}: {bytes}");
        }
    }
}
