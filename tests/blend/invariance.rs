//! What may be turned and moved without the blend noticing.

use handover_mesh::Point;
use handover_mesh::blend::{BlendSettings, Energy};
use handover_mesh::{Isometry, Vector};

use crate::ends::every_way;
use crate::shapes::{
    bar, bar_triangles, blended, blended_tetrahedra, block, deformed, farthest, farthest_laid_on,
};

#[test]
fn only_shears_do_not_see_how_a_shape_is_turned() {
    let (reference, structure) = block([3, 1, 1], 4);
    let shape = deformed(&reference, 1, 1.0);
    let turn = Isometry::new(Vector::new(1.0, 2.0, 3.0), Vector::new(0.5, -0.9, 0.7));
    let turned: Vec<Point> = shape.iter().map(|place| turn * place).collect();
    let off = |energy| {
        let settings = BlendSettings {
            energy,
            iterations: 20_000,
            tolerance: 1e-13,
            ..BlendSettings::default()
        };
        let of = |shape: &Vec<Point>| {
            let shapes = [reference.clone(), shape.clone()];
            blended_tetrahedra(&structure, &shapes, &[0.6], settings).0
        };
        farthest_laid_on(&of(&shape), &of(&turned))
    };
    let (shears, transforms) = (off(Energy::Shears), off(Energy::Transforms));
    assert!(shears < 1e-8, "{shears}");
    assert!(transforms > 1e-3, "{transforms}");
}

#[test]
fn a_blend_moves_with_its_shapes() {
    let shapes = [bar(0.0), bar(1.0), deformed(&bar(0.5), 2, 1.0)];
    let shift = Vector::new(10.0, -5.0, 3.0);
    let turn = Isometry::new(shift, Vector::new(0.4, 1.0, -0.3));
    let moved = shapes.clone().map(|shape| shape.iter().map(|place| turn * place).collect());
    let triangles = bar_triangles();
    for settings in every_way() {
        // As many steps on both sides, so that only rounding may differ.
        let settings = BlendSettings { iterations: 5, tolerance: 0.0, ..settings };
        let (here, _) = blended(&triangles, &shapes, &[0.4, -0.3], settings);
        let (there, _) = blended(&triangles, &moved, &[0.4, -0.3], settings);
        let here: Vec<Point> = here.iter().map(|place| turn * place).collect();
        let off = farthest(&here, &there);
        assert!(off < 1e-9, "{settings:?}: {off}");
    }
}

#[test]
fn a_rigid_motion_is_interpolated_by_its_angle() {
    let reference = bar(0.0);
    let turn = nalgebra::Rotation3::new(Vector::z() * 2.0);
    let turned: Vec<Point> = reference.iter().map(|place| turn * place).collect();
    for settings in every_way() {
        let shapes = [reference.clone(), turned.clone()];
        let (found, blended) = blended(&bar_triangles(), &shapes, &[0.25], settings);
        let half = nalgebra::Rotation3::new(Vector::z() * 0.5);
        let expected: Vec<Point> = reference.iter().map(|place| half * place).collect();
        // Lengths stay and it is turned by a quarter; its mean is the weighted mean.
        assert!(farthest_laid_on(&found, &expected) < 1e-9, "{settings:?}");
        let direction = |shape: &[Point]| shape[200] - shape[0];
        assert!((direction(&found) - direction(&expected)).norm() < 1e-9, "{settings:?}");
        assert!(blended.energy < 1e-15, "{settings:?}");
    }
}
