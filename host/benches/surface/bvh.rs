//! The peer: a bounding volume hierarchy over independent triangles, as any renderer has one.

use asperity::raytrace::Ray;
use asperity::surface::HeightMap;

type Vector = [f32; 3];

#[derive(Clone, Copy)]
struct Node {
    low: Vector,
    high: Vector,
    /// Leaf: the first triangle. Else: the second child; the first is the next node.
    index: u32,
    /// Triangles of a leaf, or 0.
    count: u32,
}

/// Median splits of the longest side, four triangles a leaf; rays are Moeller and Trumbore's.
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    /// A corner and the two sides from it.
    triangles: Vec<[Vector; 3]>,
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Bvh {
    /// One image of a map, in pitches, heights from the middle of their range.
    pub(crate) fn new(map: &HeightMap) -> Self {
        let (nx, ny) = (map.nx(), map.ny());
        let heights = map.complete().unwrap_or_default();
        let (low, high) =
            heights.iter().fold((f64::MAX, f64::MIN), |(a, b), &h| (a.min(h), b.max(h)));
        let node = |x: usize, y: usize| {
            let height = (heights[y * nx + x] - 0.5 * (low + high)) / map.dx_um();
            [x as f32, y as f32, height as f32]
        };
        let mut triangles = Vec::with_capacity(2 * nx * ny);
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                let [a, d] = [node(x, y), node(x + 1, y + 1)];
                for b in [node(x + 1, y), node(x, y + 1)] {
                    triangles.push([a, minus(b, a), minus(d, a)]);
                }
            }
        }
        let mut all = Self { nodes: Vec::new(), triangles };
        all.split(0, all.triangles.len());
        all
    }

    fn split(&mut self, from: usize, to: usize) {
        let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
        for [a, e, f] in &self.triangles[from..to] {
            for k in 0..3 {
                low[k] = low[k].min(a[k] + e[k].min(f[k]).min(0.0));
                high[k] = high[k].max(a[k] + e[k].max(f[k]).max(0.0));
            }
        }
        let at = self.nodes.len();
        let count = to - from;
        self.nodes.push(Node { low, high, index: from as u32, count: count as u32 });
        if count <= 4 {
            return;
        }
        let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
        let middle = count / 2;
        self.triangles[from..to].select_nth_unstable_by(middle, |p, q| {
            let centre = |t: &[Vector; 3]| 3.0 * t[0][axis] + t[1][axis] + t[2][axis];
            centre(p).total_cmp(&centre(q))
        });
        self.split(from, from + middle);
        let second = self.nodes.len() as u32;
        self.split(from + middle, to);
        self.nodes[at] = Node { index: second, count: 0, ..self.nodes[at] };
    }

    /// Distance to the nearest triangle.
    pub(crate) fn nearest(&self, ray: &Ray) -> f32 {
        let (o, d) = (ray.origin, ray.direction);
        let inverse = d.map(|c| 1.0 / c);
        let mut nearest = f32::INFINITY;
        let enters = |node: &Node, nearest: f32| {
            let (mut near, mut far) = (0.0_f32, nearest);
            for k in 0..3 {
                let (a, b) =
                    ((node.low[k] - o[k]) * inverse[k], (node.high[k] - o[k]) * inverse[k]);
                near = near.max(a.min(b));
                far = far.min(a.max(b));
            }
            if near <= far { near } else { f32::INFINITY }
        };
        let (mut stack, mut depth) = ([(0_u32, 0.0_f32); 64], 1);
        while depth > 0 {
            depth -= 1;
            let (at, distance) = stack[depth];
            if distance >= nearest {
                continue;
            }
            let node = self.nodes[at as usize];
            if node.count > 0 {
                let first = node.index as usize;
                for t in &self.triangles[first..first + node.count as usize] {
                    nearest = nearest.min(meet(o, d, t));
                }
                continue;
            }
            let children = [at + 1, node.index];
            let [a, b] = children.map(|c| enters(&self.nodes[c as usize], nearest));
            // the nearer one is taken first
            let order = if a <= b {
                [(children[1], b), (children[0], a)]
            } else {
                [(children[0], a), (children[1], b)]
            };
            for entry in order {
                if entry.1 < nearest {
                    stack[depth] = entry;
                    depth += 1;
                }
            }
        }
        nearest
    }
}

fn meet(o: Vector, d: Vector, [a, e, f]: &[Vector; 3]) -> f32 {
    let p = cross(d, *f);
    let scale = 1.0 / dot(*e, p);
    let s = minus(o, *a);
    let u = dot(s, p) * scale;
    let q = cross(s, *e);
    let v = dot(d, q) * scale;
    let t = dot(*f, q) * scale;
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 { t } else { f32::INFINITY }
}
