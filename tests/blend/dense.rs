//! Many shapes of a small structure.

use handover_mesh::Point;
use handover_mesh::blend::{Apart, BlendError, BlendSettings, Blender, DenseBlender, Structure};

use crate::shapes::{block, deformed, farthest};

/// `Σ wₖ Pₖ`.
fn mean(weights: &[f64], shapes: &[Vec<Point>]) -> Vec<Point> {
    let place = |vertex: usize| {
        let sum = weights.iter().zip(shapes).map(|(weight, shape)| *weight * shape[vertex].coords);
        Point::from(sum.sum::<handover_mesh::Vector>())
    };
    (0..shapes[0].len()).map(place).collect()
}

fn blend(blender: &DenseBlender, weights: &[f64], shapes: &[Vec<Point>]) -> Vec<Point> {
    let apart: Vec<Apart> = shapes.iter().map(|shape| blender.apart(shape)).collect();
    let mut out = mean(weights, shapes);
    let parts = weights.iter().copied().zip(&apart);
    blender.blend(parts, &mut out, &mut blender.workspace());
    out
}

#[test]
fn it_is_the_blend_with_pins() {
    for seed in 0..5 {
        let (rest, structure) = block([2, 2, 1], seed);
        let shapes: Vec<Vec<Point>> =
            (0..4).map(|shape| deformed(&rest, 10 * seed + shape, 1.0)).collect();
        let (weights, pins) = ([0.4, 0.3, 0.2, 0.1], [0, 17]);
        let dense = DenseBlender::new(&structure, &rest, &pins).unwrap();
        let found = blend(&dense, &weights, &shapes);
        let views: Vec<&[Point]> = std::iter::once(&rest).chain(&shapes).map(|s| &s[..]).collect();
        let settings = BlendSettings::default();
        let sparse = Blender::of_tetrahedra(&structure, &views, &pins, settings).unwrap();
        assert_eq!(sparse.flipped(), 0);
        let mut expected = mean(&weights, &shapes);
        sparse.blend(&weights, &mut sparse.workspace(), &mut expected);
        assert!(farthest(&found, &expected) < 1e-10, "{}", farthest(&found, &expected));
    }
}

#[test]
fn one_shape_alone_stays_even_inside_out() {
    let (rest, structure) = block([2, 1, 1], 3);
    let mut shape = deformed(&rest, 4, 1.0);
    shape.swap(3, 7);
    let dense = DenseBlender::new(&structure, &rest, &[0]).unwrap();
    assert!(farthest(&blend(&dense, &[1.0], &[shape.clone()]), &shape) < 1e-10);
}

#[test]
fn where_all_is_inside_out_the_mean_remains() {
    let (rest, structure) = block([2, 1, 1], 3);
    let mirrored = |seed: u64| -> Vec<Point> {
        deformed(&rest, seed, 1.0).iter().map(|p| Point::new(p.x, p.y, -p.z)).collect()
    };
    let (weights, shapes) = ([0.5, 0.5], [mirrored(1), mirrored(2)]);
    let dense = DenseBlender::new(&structure, &rest, &[0]).unwrap();
    let off = farthest(&blend(&dense, &weights, &shapes), &mean(&weights, &shapes));
    assert!(off < 1e-6, "{off}");
}

#[test]
fn nothing_jumps_where_a_tetrahedron_turns_inside_out() {
    let (rest, structure) = block([1, 1, 1], 5);
    let dense = DenseBlender::new(&structure, &rest, &[0]).unwrap();
    let other = deformed(&rest, 8, 1.5);
    // A vertex wanders through the opposite side.
    let at = |step: usize| {
        let mut shape = deformed(&rest, 6, 1.0);
        let (from, to) = (shape[7], shape[0] + (shape[0] - shape[7]) * 0.5);
        shape[7] = from + (to - from) * (step as f64 / 1000.0);
        let weights = [0.5, 0.5];
        (blend(&dense, &weights, &[shape.clone(), other.clone()]), shape)
    };
    let (mut before, mut shape_before) = at(0);
    for step in 1..=1000 {
        let (here, shape) = at(step);
        let (moved, by) = (farthest(&here, &before), farthest(&shape, &shape_before));
        assert!(moved < 20.0 * by, "step {step}: {moved} for {by}");
        (before, shape_before) = (here, shape);
    }
}

#[test]
fn what_nothing_holds_is_refused() {
    let (rest, structure) = block([1, 1, 1], 5);
    let refused = |structure: &Structure, rest: &[Point], pins: &[usize]| {
        DenseBlender::new(structure, rest, pins).unwrap_err()
    };
    assert_eq!(refused(&structure, &rest, &[]), BlendError::Undetermined);
    assert_eq!(refused(&structure, &rest, &[8]), BlendError::Pin { vertex: 8, vertices: 8 });
    let flat: Vec<Point> = rest.iter().map(|p| Point::new(p.x, p.y, 0.0)).collect();
    assert_eq!(refused(&structure, &flat, &[0]), BlendError::Empty);
}
