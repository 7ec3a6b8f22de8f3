//! No weight gives the reference, all of it on one shape gives that shape.

use handover_mesh::Point;
use handover_mesh::blend::{BlendSettings, Blender, Energy, Rotation, Structure, Tetrisation};

use crate::shapes::{bar, bar_triangles, blended, block, deformed, farthest};

/// All ways to blend.
pub(crate) fn every_way() -> impl Iterator<Item = BlendSettings> {
    let settings = |tetrisation| {
        Rotation::ALL.into_iter().flat_map(move |rotation| {
            Energy::ALL.map(|energy| BlendSettings {
                tetrisation,
                rotation,
                energy,
                ..BlendSettings::default()
            })
        })
    };
    Tetrisation::ALL.into_iter().flat_map(settings)
}

/// Of shapes of about this extent `[m]`, to this share.
const EXACT: f64 = 1e-9 * 4.0;

#[test]
fn the_ends_are_the_shapes() {
    let triangles = bar_triangles();
    let shapes = [bar(0.0), bar(2.0), deformed(&bar(-1.0), 3, 1.0)];
    for settings in every_way() {
        for (weights, expected) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].iter().zip(&shapes) {
            let (found, _) = blended(&triangles, &shapes, weights, settings);
            let off = farthest(&found, expected);
            assert!(off < EXACT, "{settings:?} {weights:?}: {off}");
        }
    }
}

#[test]
fn what_hangs_together_keeps_its_place_and_what_does_not_takes_the_mean() {
    let (one, structure) = block([1, 1, 1], 1);
    let count = one.len() as u32;
    let shifted = |places: &[Point], by: f64| -> Vec<Point> {
        places.iter().map(|p| p + handover_mesh::Vector::x() * by).collect()
    };
    // Two blocks and a lone vertex.
    let shape = |places: &[Point], by: f64, lone: f64| {
        [places.to_vec(), shifted(places, by), vec![Point::new(0.0, lone, 0.0)]].concat()
    };
    let shapes = [shape(&one, 3.0, 0.0), shape(&deformed(&one, 5, 1.0), 5.0, 2.0)];
    let more = structure.tetrahedra().iter().map(|corners| corners.map(|corner| corner + count));
    let all = structure.tetrahedra().iter().copied().chain(more).collect();
    let structure = Structure::new(2 * one.len() + 1, all).unwrap();
    let views: Vec<&[Point]> = shapes.iter().map(Vec::as_slice).collect();
    let settings = BlendSettings::default();
    let blender = Blender::of_tetrahedra(&structure, &views, &[], settings).unwrap();
    assert_eq!((blender.free(), blender.flipped()), (1, 0));
    let (mut workspace, mut out) = (blender.workspace(), shapes[0].clone());
    blender.blend(&[1.0], &mut workspace, &mut out);
    assert!(farthest(&out, &shapes[1]) < EXACT);
    blender.blend(&[0.25], &mut workspace, &mut out);
    assert_eq!(out[2 * one.len()].y, 0.5);
    let mean = |places: &[Point]| {
        places.iter().map(|p| p.coords).sum::<handover_mesh::Vector>() / places.len() as f64
    };
    for part in [0..one.len(), one.len()..2 * one.len()] {
        let [from, to, here] =
            [&shapes[0], &shapes[1], &out].map(|shape| mean(&shape[part.clone()]));
        assert!((from + (to - from) * 0.25 - here).norm() < 1e-12);
    }
}
