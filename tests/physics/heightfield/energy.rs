//! No ray is lost, none is doubled.

use asperity::forward::{Rays, count_flux};
use asperity_tests::{count, tolerance};

use super::maps::{EDGES, boundary, noise, waves};
use crate::common::{dir, incidence};

#[test]
fn no_ray_is_lost_on_steep_surfaces_up_to_grazing_incidence() {
    let mut rays = 0.0;
    for slope in [0.3, 1.0, 3.0] {
        for map in [noise((128, 93), (1.0, 0.8), slope, 2), waves((128, 93), (1.0, 0.8), slope, 3)]
        {
            for edges in EDGES {
                let boundary = boundary(&map, edges);
                for degrees in [0.0, 30.0, 60.0, 85.0] {
                    for air in [true, false] {
                        let wi = dir(incidence(degrees, air));
                        let asked = Rays { count: count(22_500) as u64, seed: 1 };
                        let flux = count_flux(&boundary, wi, asked);
                        let case = format!("{slope} {} {degrees} {air} {flux:?}", edges.name());
                        // counts over a common number: one lost ray of so many is 4e-5
                        assert!(flux.lost.abs() < 1e-9, "{case}");
                        let total = flux.reflected + flux.transmitted + flux.lost;
                        assert!((total - 1.0).abs() < 1e-12, "{case}");
                        // a gentle surface reflects grazing light in the glass totally
                        assert!(flux.reflected > 0.0 && (!air || flux.transmitted > 0.0), "{case}");
                        rays += asked.count as f64;
                    }
                }
            }
        }
    }
    println!("{rays} rays, none lost");
    assert!(rays > 1e6);
}

#[test]
fn hardly_a_ray_is_lost_where_walls_are_nearly_upright() {
    for slope in [10.0, 30.0, 100.0] {
        for edges in EDGES {
            let boundary = boundary(&noise((64, 64), (1.0, 1.0), slope, 5), edges);
            for (degrees, air) in [(0.0, true), (60.0, true), (0.0, false), (60.0, false)] {
                let asked = Rays { count: count(10_000) as u64, seed: 2 };
                let flux = count_flux(&boundary, dir(incidence(degrees, air)), asked);
                println!("{slope} {} {degrees} {air} {flux:?}", edges.name());
                assert!(flux.lost < tolerance::UPRIGHT_LOST.allowed, "{slope} {flux:?}");
            }
        }
    }
}
