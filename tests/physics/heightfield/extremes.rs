//! Maps and rays at the edge of what numbers can hold: an answer each, and bounded flux. A ray that does not end keeps its test
//! from ending.

use asperity::raytrace::{Fate, Field, Ray, Triangle};
use asperity::surface::HeightMap;
use asperity_core::bsdf::Scatter;
use asperity_core::direction::Direction;

use super::maps::{EDGES, boundary, stream};

fn map(size: (usize, usize), pitch: (f64, f64), height: impl Fn(usize, usize) -> f64) -> HeightMap {
    let heights = (0..size.0 * size.1).map(|k| height(k % size.0, k / size.0)).collect();
    HeightMap::new(size, pitch, heights).unwrap()
}

fn maps() -> Vec<(&'static str, HeightMap)> {
    let unit = (1.0, 1.0);
    let wave = |x: usize, y: usize| (x as f64).sin() + (1.3 * y as f64).cos();
    let spike = |x: usize, y: usize| if (x, y) == (4, 6) { 1e4 } else { 0.0 };
    vec![
        ("2 x 2", map((2, 2), unit, |x, y| (x ^ y) as f64)),
        ("2 x 1000", map((2, 1000), unit, wave)),
        ("1000 x 2", map((1000, 2), unit, wave)),
        ("flat", map((9, 9), unit, |_, _| 3.0)),
        ("spike", map((16, 16), unit, spike)),
        ("pit", map((16, 16), unit, |x, y| -spike(x, y))),
        // rises gently, and falls by 1e5 within a pitch
        ("sawtooth", map((33, 8), unit, |x, _| 1e5 * x as f64 / 32.0)),
        ("sawtooth along y", map((8, 33), unit, |_, y| 1e5 * y as f64 / 32.0)),
        ("upright", map((8, 8), unit, |x, y| 1e3 * ((x + y) % 2) as f64)),
        ("of 1e-9 um", map((16, 16), unit, |x, y| 1e-9 * wave(x, y))),
        ("of 1e-300 um", map((16, 16), unit, |x, y| 1e-300 * wave(x, y))),
        ("far up", map((16, 16), unit, |x, y| 1e9 + wave(x, y))),
        ("narrow pixels", map((16, 16), (1.0, 1e-3), wave)),
        ("wide pixels", map((16, 16), (1.0, 1e3), wave)),
    ]
}

/// Heights so large that a nearly level ray goes around the map a million times on its way through them.
fn tall(map: &HeightMap) -> bool {
    map.points().any(|p| p.2.abs() > 1e3 && map.height_um(0, 0) != Some(p.2))
}

/// Ways along the axes, the diagonals, up and down, and nearly level.
fn directions(level: f32) -> Vec<[f32; 3]> {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let mut all = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    for (s, c) in [level, 45.0].map(|degrees| degrees.to_radians().sin_cos()) {
        for [x, y] in [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.0, -1.0],
            [half, half],
            [-half, half],
            [0.6, -0.8],
        ] {
            all.push([x * s, y * s, c]);
            all.push([x * s, y * s, -c]);
        }
    }
    all
}

/// Nodes, edges, the far rim and the inside of the grid.
fn places(field: &Field) -> Vec<[f32; 2]> {
    let (nx, ny) = field.size();
    let (nx, ny) = (nx as f32, ny as f32);
    let x = [0.0, nx.midpoint(0.0).floor(), nx - 0.25, nx];
    let y = [0.0, ny.midpoint(0.0).floor(), ny - 0.25, ny];
    x.into_iter().flat_map(|x| y.map(|y| [x, y])).collect()
}

/// Follows a ray, and looks whether its hit is a point of the map.
fn follow(field: &Field, ray: &Ray, name: &str) -> Fate {
    let fate = field.follow(ray);
    if let Fate::Hits(hit) = fate {
        let (nx, ny) = field.size();
        let [x, y] = hit.triangle.cell;
        let inside = (0..nx as i32).contains(&x) && (0..ny as i32).contains(&y);
        assert!(inside && hit.point.iter().all(|c| c.is_finite()), "{name} {ray:?} {hit:?}");
        let within =
            (0.0..=nx as f32).contains(&hit.point[0]) && (0.0..=ny as f32).contains(&hit.point[1]);
        assert!(within && hit.slope.iter().all(|s| !s.is_nan()), "{name} {ray:?} {hit:?}");
    }
    fate
}

/// It was sent from wall to wall for ever: nothing times minus one is nothing, and goes neither way.
#[test]
fn an_upright_ray_in_a_mirror_wall_meets_the_surface() {
    let map = map((5, 4), (1.0, 1.0), |x, y| (x * y) as f64);
    let field = Field::new(&map, EDGES[1]).unwrap();
    let (nx, ny) = field.size();
    for at in [[0.0, 0.0], [nx as f32, 1.5], [1.5, ny as f32], [nx as f32, ny as f32]] {
        for nothing in [0.0, -0.0, 1e-38, -1e-38] {
            for (above, z) in [(true, 6.0), (false, -6.0)] {
                let origin = [at[0], at[1], z];
                let ray =
                    Ray { origin, direction: [nothing, nothing, -z.signum()], above, from: None };
                let Fate::Hits(hit) = field.follow(&ray) else { panic!("{ray:?} meets nothing") };
                let height = field.height(at[0], at[1]);
                assert!((hit.point[2] - height).abs() < 1e-5, "{ray:?} {hit:?} {height}");
            }
        }
    }
}

#[test]
fn any_ray_on_any_map_gets_an_answer() {
    let mut answers = [0; 3];
    for (name, map) in maps() {
        let level = if tall(&map) { 60.0 } else { 89.99 };
        let narrow = map.dy_um() < map.dx_um();
        let level = if narrow { 60.0 } else { level };
        for edges in EDGES {
            let field = Field::new(&map, edges).unwrap();
            let top = map.points().map(|p| p.2).fold(f64::NEG_INFINITY, f64::max);
            let low = map.points().map(|p| p.2).fold(f64::INFINITY, f64::min);
            let top = (0.5 * (top - low)) as f32;
            for direction in directions(level) {
                for [x, y] in places(&field) {
                    for (above, z) in [(true, top), (false, -top), (true, 0.0), (false, 0.0)] {
                        let cell = [(x as i32).min(field.size().0 as i32 - 1), 0];
                        let triangle = Triangle { cell, upper: above };
                        // from the surface it may start only where it stands on it
                        let on = [x, y.min(1.0), field.height(x, y.min(1.0))];
                        let free = Ray { origin: [x, y, z], direction, above, from: None };
                        let from = Ray { origin: on, direction, above, from: Some(triangle) };
                        for ray in [free, from] {
                            let k = match follow(&field, &ray, name) {
                                Fate::Hits(_) => 0,
                                Fate::Escapes => 1,
                                Fate::Lost => 2,
                            };
                            answers[k] += 1;
                        }
                    }
                }
            }
            println!("{name}: hits, escapes, lost {answers:?}");
        }
    }
}

#[test]
fn rays_that_are_level_or_no_rays_end() {
    let nan = f32::NAN;
    let infinite = f32::INFINITY;
    let mut answers = [0; 3];
    // most of them run until they are given up, which takes a tenth of a second: a few maps must do
    let steepest = map((8, 8), (1.0, 1.0), |x, y| 1e6 * ((x + y) % 2) as f64);
    let spike = map((16, 16), (1.0, 1.0), |x, y| if (x, y) == (4, 6) { 1e4 } else { 0.0 });
    let no_width = map((9, 7), (1.0, 1e-60), |x, y| (x * y % 3) as f64);
    for (map, edges) in [(steepest, EDGES[0]), (spike, EDGES[1]), (no_width, EDGES[1])] {
        let field = Field::new(&map, edges).unwrap();
        let (nx, _) = field.size();
        let directions = [
            [1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.6, 0.8, 0.0],
            [0.0, 0.0, 0.0],
            [nan, nan, nan],
            [0.6, nan, -0.8],
            [1.0, 0.0, nan],
            [infinite, 0.0, -1.0],
            [0.0, 0.0, -infinite],
        ];
        for (k, direction) in directions.into_iter().enumerate() {
            let origin = [[0.3, 0.4, 0.01], [nx as f32, nan, 0.0]][k % 2];
            let ray = Ray { origin, direction, above: k % 3 > 0, from: None };
            let answer = match field.follow(&ray) {
                Fate::Hits(_) => 0,
                Fate::Escapes => 1,
                Fate::Lost => 2,
            };
            answers[answer] += 1;
        }
    }
    println!("hits, escapes, lost: {answers:?}");
}

#[test]
fn no_flux_comes_from_nowhere_on_any_map() {
    let mut random = stream(4);
    for (name, map) in maps() {
        for edges in EDGES {
            let boundary = boundary(&map, edges);
            let (mut lost, mut rays) = (0, 0);
            let least = if tall(&map) || map.dy_um() < map.dx_um() { 0.2 } else { 1e-4 };
            for z in [1.0, 0.5, 0.2, least, -least, -0.2, -0.5, -1.0] {
                for [x, y] in [[1.0, 0.0], [0.0, -1.0], [0.6, 0.8], [-0.8, 0.6]] {
                    let level = f64::sqrt(1.0 - z * z);
                    let wi = Direction::new(x * level, y * level, z).unwrap();
                    for _ in 0..10 {
                        rays += 1;
                        let Some(ray) = boundary.sample(wi, &mut || random.next()) else {
                            lost += 1;
                            continue;
                        };
                        let length = ray.wo.dot(ray.wo);
                        assert!((length - 1.0).abs() < 1e-9 && ray.weight <= 1.0, "{name} {ray:?}");
                    }
                }
            }
            println!("{name} {}: {lost} of {rays} lost", edges.name());
        }
    }
    // what is no direction is no ray
    let boundary = boundary(&maps()[0].1, EDGES[0]);
    for [x, y, z] in [[f64::NAN; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, f64::NAN]] {
        let wi = Direction::from_unit(x, y, z);
        assert!(boundary.sample(wi, &mut || random.next()).is_none(), "{wi:?}");
    }
}
