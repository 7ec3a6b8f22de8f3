//! Weights beyond 0 and 1 (Kaji 2015, Fig. 6), weights of tetrahedra (Remark 2), pins.

use handover_mesh::Point;
use handover_mesh::blend::{BlendError, BlendSettings, Blender, Rotation};
use proptest::prelude::*;

use crate::shapes::{blended_tetrahedra, block, deformed, farthest};

/// Six times the volume of a tetrahedron: negative where it is inside out.
fn determinant(corners: [u32; 4], shape: &[Point]) -> f64 {
    let [a, b, c, d] = corners.map(|corner| shape[corner as usize]);
    (b - a).cross(&(c - a)).dot(&(d - a))
}

#[test]
fn extrapolation_does_not_turn_inside_out() {
    let (reference, structure) = block([2, 1, 1], 6);
    let flat: Vec<Point> = reference.iter().map(|p| Point::new(p.x, p.y, 0.3 * p.z)).collect();
    let shapes = [reference.clone(), flat];
    let least = |rotation, weight: f64| {
        let settings = BlendSettings { rotation, ..BlendSettings::default() };
        let (found, _) = blended_tetrahedra(&structure, &shapes, &[weight], settings);
        let all = structure.tetrahedra().iter();
        let shares =
            all.map(|corners| determinant(*corners, &found) / determinant(*corners, &reference));
        shares.fold(f64::INFINITY, f64::min)
    };
    for weight in [-2.0f64, -1.0, -0.5, 1.5, 2.0, 3.0] {
        let found = least(Rotation::Continuous, weight);
        assert!((found / 0.3f64.powf(weight) - 1.0).abs() < 1e-9, "{weight}: {found}");
    }
    // 1 + 2 (0.3 − 1) is below 0.
    assert!((least(Rotation::Principal, 2.0) + 0.4).abs() < 1e-9);
}

proptest! {
    /// Of one tetrahedron the blend is its map: so its determinant is seen.
    #[test]
    fn determinants_stay_positive(
        places in prop::array::uniform12(-1.0f64..1.0), weights in prop::array::uniform2(-2.0f64..3.0),
    ) {
        let (one, structure) = block([1, 1, 1], 0);
        let corners = structure.tetrahedra()[0];
        let reference: Vec<Point> = corners.iter().map(|corner| one[*corner as usize]).collect();
        let off = |shape: usize| -> Vec<Point> {
            let moved = places[3 * shape..].iter().cycle();
            let moved = reference.iter().flat_map(|p| p.iter().copied()).zip(moved);
            let moved: Vec<f64> = moved.map(|(p, by)| p + 0.35 * by).collect();
            moved.chunks_exact(3).map(Point::from_slice).collect()
        };
        let structure = handover_mesh::blend::Structure::new(4, vec![[0, 1, 2, 3]]).unwrap();
        let determinant = |shape: &[Point]| determinant([0, 1, 2, 3], shape);
        let shapes = [reference.clone(), off(0), off(2)];
        prop_assume!(shapes.iter().all(|shape| determinant(shape) > 0.05));
        let settings = BlendSettings::default();
        let (found, blended) = blended_tetrahedra(&structure, &shapes, &weights, settings);
        prop_assert!(determinant(&found) > 0.0);
        prop_assert!(blended.energy < 1e-12, "one map fits: {}", blended.energy);
        // det exp(X) = exp tr(X): the determinants blend as powers.
        let [a, b, c] = [0, 1, 2].map(|at| determinant(&shapes[at]));
        let expected = a * (b / a).powf(weights[0]) * (c / a).powf(weights[1]);
        prop_assert!((determinant(&found) / expected - 1.0).abs() < 1e-8);
    }
}

#[test]
fn tetrahedra_count_by_their_weight() {
    let (reference, structure) = block([2, 1, 1], 2);
    let shapes = [reference.clone(), deformed(&reference, 7, 1.5)];
    let count = structure.tetrahedra().len();
    let of = |weights: Vec<f64>| {
        let structure = structure.clone().weighted(weights).unwrap();
        blended_tetrahedra(&structure, &shapes, &[0.5], BlendSettings::default())
    };
    let (even, energy) = of(vec![1.0; count]);
    let (doubled, twice) = of(vec![2.0; count]);
    assert!(farthest(&even, &doubled) < 1e-12);
    assert!((twice.energy / energy.energy - 2.0).abs() < 1e-9);
    // The more the first cube counts, the nearer it comes to its own blend.
    let first = structure.tetrahedra()[..6].to_vec();
    let alone = handover_mesh::blend::Structure::new(reference.len(), first).unwrap();
    let (alone, _) = blended_tetrahedra(&alone, &shapes, &[0.5], BlendSettings::default());
    let off = |weight: f64| {
        let weights = (0..count).map(|at| if at < 6 { weight } else { 1.0 }).collect();
        let cube = |shape: &[Point]| -> Vec<Point> {
            let mut corners: Vec<u32> = structure.tetrahedra()[..6].concat();
            corners.sort_unstable();
            corners.dedup();
            corners.iter().map(|corner| shape[*corner as usize]).collect()
        };
        crate::shapes::farthest_laid_on(&cube(&of(weights).0), &cube(&alone))
    };
    assert!(off(1.0) > 1e-4 && off(100.0) < 0.1 * off(1.0), "{} {}", off(1.0), off(100.0));
    // Of weight 0 it might as well not be there.
    let (without, _) = of((0..count).map(|at| if at < 6 { 1.0 } else { 0.0 }).collect());
    assert!(farthest(&without, &alone) < 1e-12);
    let refused = structure.weighted([vec![1.0; 3], vec![f64::NAN; count - 3]].concat());
    assert_eq!(refused.unwrap_err(), BlendError::Weight { tetrahedron: 3 });
}

#[test]
fn pinned_vertices_are_where_they_are_put() {
    let (reference, structure) = block([3, 1, 1], 3);
    let shapes = [reference.clone(), deformed(&reference, 9, 1.0)];
    let views: Vec<&[Point]> = shapes.iter().map(Vec::as_slice).collect();
    let pins = [0, 1, 2, 15];
    for energy in handover_mesh::blend::Energy::ALL {
        let settings = BlendSettings { energy, ..BlendSettings::default() };
        let blender = Blender::of_tetrahedra(&structure, &views, &pins, settings).unwrap();
        let mut out = reference.clone();
        out[15] += handover_mesh::Vector::new(0.3, 0.5, 0.0);
        let put = out.clone();
        blender.blend(&[0.0], &mut blender.workspace(), &mut out);
        for pin in pins {
            assert_eq!(out[pin], put[pin]);
        }
        // The rest follows, most of all what is near.
        let moved = |at: usize| (out[at] - reference[at]).norm();
        assert!(moved(14) > 0.1 && moved(14) > 2.0 * moved(4), "{} {}", moved(14), moved(4));
        // Where they are pinned to a shape, the weight of that shape gives it.
        let mut out = shapes[1].clone();
        blender.blend(&[1.0], &mut blender.workspace(), &mut out);
        assert!(farthest(&out, &shapes[1]) < 1e-9);
    }
    let refused = Blender::of_tetrahedra(&structure, &views, &[99], BlendSettings::default());
    assert_eq!(refused.unwrap_err(), BlendError::Pin { vertex: 99, vertices: reference.len() });
}
