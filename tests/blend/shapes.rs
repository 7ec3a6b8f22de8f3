//! Made-up shapes, and how far two are apart.

use handover_mesh::blend::{BlendSettings, Blended, Blender, Structure, Triangles};
use handover_mesh::geometry::rigid_alignment;
use handover_mesh::{Point, Vector};
use nalgebra::Rotation3;
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

/// Cross-sections of a bar, and vertices around each.
pub(crate) const SECTIONS: u32 = 33;
pub(crate) const AROUND: u32 = 8;
const LENGTH: f64 = 4.0;

/// A bar along x, open at both ends, its oval sections turned by an angle that grows along it.
pub(crate) fn bar(twist: f64) -> Vec<Point> {
    let vertex = |section: u32, around: u32| {
        let along = f64::from(section) / f64::from(SECTIONS - 1);
        let angle = std::f64::consts::TAU * f64::from(around) / f64::from(AROUND);
        let straight = Point::new(LENGTH * along, 0.5 * angle.cos(), 0.3 * angle.sin());
        Rotation3::new(Vector::x() * twist * along) * straight
    };
    (0..SECTIONS).flat_map(|section| (0..AROUND).map(move |at| vertex(section, at))).collect()
}

/// How far a bar's vertices are from its axis, at least and at most.
pub(crate) fn thickness(bar: &[Point]) -> [f64; 2] {
    let mut found = [f64::INFINITY, 0.0f64];
    for section in bar.chunks_exact(AROUND as usize) {
        let middle = section.iter().map(|place| place.coords).sum::<Vector>() / f64::from(AROUND);
        for place in section {
            let off = (place.coords - middle).norm();
            found = [found[0].min(off), found[1].max(off)];
        }
    }
    found
}

pub(crate) fn bar_triangles() -> Triangles {
    let corners = (0..SECTIONS - 1).flat_map(|s| (0..AROUND).map(move |j| (s, j)));
    let corners = corners.flat_map(|(s, j)| {
        let at = |s: u32, j: u32| s * AROUND + j % AROUND;
        let [a, b, c, d] = [at(s, j), at(s + 1, j), at(s + 1, j + 1), at(s, j + 1)];
        [[a, c, b], [a, d, c]]
    });
    Triangles::new((SECTIONS * AROUND) as usize, corners.collect()).unwrap()
}

/// The corners of an octahedron, at different distances, and its faces.
pub(crate) fn octahedron() -> (Vec<Point>, Triangles) {
    let places = [[1.0, 0.0, 0.0], [-1.2, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, -1.0, 0.0]];
    let places = places.into_iter().chain([[0.0, 0.1, 1.1], [0.1, 0.0, -0.8]]);
    let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5]];
    let faces = faces.into_iter().chain([[0, 3, 5]]).collect();
    (places.map(Point::from).collect(), Triangles::new(6, faces).unwrap())
}

/// A block of cubes, each of six tetrahedra, its vertices somewhat off their places.
pub(crate) fn block(sides: [u32; 3], seed: u64) -> (Vec<Point>, Structure) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let [nx, ny, nz] = sides.map(|side| side + 1);
    let at = |[x, y, z]: [u32; 3]| (x * ny + y) * nz + z;
    let mut places = Vec::new();
    for x in 0..nx {
        for y in 0..ny {
            for z in 0..nz {
                let off: [f64; 3] = std::array::from_fn(|_| rng.random_range(-0.1..0.1));
                places
                    .push(Point::new(f64::from(x), f64::from(y), f64::from(z)) + Vector::from(off));
            }
        }
    }
    // From one corner of a cube to the opposite one, axis by axis in all six orders.
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]];
    let mut tetrahedra = Vec::new();
    for x in 0..sides[0] {
        for y in 0..sides[1] {
            for z in 0..sides[2] {
                for (order, is_odd) in orders.iter().zip([false, false, false, true, true, true]) {
                    let mut corner = [x, y, z];
                    let mut corners = [at(corner); 4];
                    for (step, axis) in order.iter().enumerate() {
                        corner[*axis] += 1;
                        corners[step + 1] = at(corner);
                    }
                    if is_odd {
                        corners.swap(2, 3);
                    }
                    tetrahedra.push(corners);
                }
            }
        }
    }
    let structure = Structure::new(places.len(), tetrahedra).unwrap();
    (places, structure)
}

/// A shape bent, twisted and stretched a little, otherwise by each seed.
pub(crate) fn deformed(places: &[Point], seed: u64, strength: f64) -> Vec<Point> {
    let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
    let mut number = |scale: f64| rng.random_range(-scale..scale) * strength;
    let (axis, bend) = (Vector::new(number(0.5), number(0.5), number(0.5)), number(0.4));
    let (turn, stretch) = (Vector::new(number(1.0), number(1.0), number(1.0)), number(0.3));
    let place = |p: &Point| {
        let turned = Rotation3::new(turn + axis * p.x * 0.3) * (p * (1.0 + stretch));
        turned + Vector::new(0.0, 0.0, bend * p.x * p.y * 0.1)
    };
    places.iter().map(place).collect()
}

/// The farthest that two vertices of the same number are apart `[m]`.
pub(crate) fn farthest(a: &[Point], b: &[Point]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// The same once one is laid on the other as well as may be.
pub(crate) fn farthest_laid_on(a: &[Point], b: &[Point]) -> f64 {
    let b_from_a = rigid_alignment(a.iter().zip(b));
    let moved: Vec<Point> = a.iter().map(|place| b_from_a * place).collect();
    farthest(&moved, b)
}

/// A blend of triangles' shapes.
#[track_caller]
pub(crate) fn blended(
    triangles: &Triangles,
    shapes: &[Vec<Point>],
    weights: &[f64],
    settings: BlendSettings,
) -> (Vec<Point>, Blended) {
    let shapes: Vec<&[Point]> = shapes.iter().map(Vec::as_slice).collect();
    blend_by(&Blender::of_triangles(triangles, &shapes, settings).unwrap(), shapes[0], weights)
}

/// A blend of tetrahedra's shapes.
#[track_caller]
pub(crate) fn blended_tetrahedra(
    structure: &Structure,
    shapes: &[Vec<Point>],
    weights: &[f64],
    settings: BlendSettings,
) -> (Vec<Point>, Blended) {
    let shapes: Vec<&[Point]> = shapes.iter().map(Vec::as_slice).collect();
    let blender = Blender::of_tetrahedra(structure, &shapes, &[], settings).unwrap();
    blend_by(&blender, shapes[0], weights)
}

fn blend_by(blender: &Blender, reference: &[Point], weights: &[f64]) -> (Vec<Point>, Blended) {
    let mut out = reference.to_vec();
    let blended = blender.blend(weights, &mut blender.workspace(), &mut out);
    (out, blended)
}
