//! Beside a slow implementation of another kind: dense least squares, eigenvalue decompositions,
//! the printed 4 × 4 matrices.

use handover_mesh::Point;
use handover_mesh::blend::{BlendSettings, Rotation, Structure};
use nalgebra::{DMatrix, Matrix3, Matrix4, Rotation3, SymmetricEigen};

use crate::shapes::{blended_tetrahedra, block, deformed, farthest};

/// `Pᵢ` (Kaji 2015, eq. 1).
fn matrix(corners: [u32; 4], shape: &[Point]) -> Matrix4<f64> {
    Matrix4::from_columns(&corners.map(|corner| shape[corner as usize].to_homogeneous()))
}

fn function(of: &Matrix3<f64>, function: impl Fn(f64) -> f64) -> Matrix3<f64> {
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(*of);
    eigenvectors * Matrix3::from_diagonal(&eigenvalues.map(function)) * eigenvectors.transpose()
}

/// The blended map of one tetrahedron.
fn blended_map(
    corners: [u32; 4],
    shapes: &[Vec<Point>],
    weights: &[f64],
    by: Rotation,
) -> Matrix3<f64> {
    let rest = matrix(corners, &shapes[0]).try_inverse().unwrap();
    let (mut turn, mut stretch) = (nalgebra::Vector3::zeros(), Matrix3::zeros());
    for (weight, shape) in weights.iter().zip(&shapes[1..]) {
        let map: Matrix3<f64> =
            (matrix(corners, shape) * rest).fixed_view::<3, 3>(0, 0).into_owned();
        let s = function(&(map.transpose() * map), f64::sqrt);
        let r = Rotation3::from_matrix_unchecked(map * s.try_inverse().unwrap());
        turn += *weight * r.scaled_axis();
        stretch += *weight
            * match by {
                Rotation::Continuous => function(&s, f64::ln),
                Rotation::Principal => s - Matrix3::identity(),
            };
    }
    let stretch = match by {
        Rotation::Continuous => function(&stretch, f64::exp),
        Rotation::Principal => stretch + Matrix3::identity(),
    };
    Rotation3::new(turn).matrix() * stretch
}

/// The minimum of `E_T`, its mean at the weighted mean: a row for each entry of each map.
fn by_least_squares(
    structure: &Structure,
    shapes: &[Vec<Point>],
    weights: &[f64],
    by: Rotation,
) -> Vec<Point> {
    let vertices = shapes[0].len();
    let rows = 3 * structure.tetrahedra().len() + 1;
    let mut left = DMatrix::<f64>::zeros(rows, vertices);
    let mut right = DMatrix::<f64>::zeros(rows, 3);
    for (at, corners) in structure.tetrahedra().iter().enumerate() {
        let inverse = matrix(*corners, &shapes[0]).try_inverse().unwrap();
        let map = blended_map(*corners, shapes, weights, by);
        for column in 0..3 {
            for (corner, vertex) in corners.iter().enumerate() {
                left[(3 * at + column, *vertex as usize)] = inverse[(corner, column)];
            }
            for axis in 0..3 {
                right[(3 * at + column, axis)] = map[(axis, column)];
            }
        }
    }
    let mean = |shape: &[Point]| {
        shape.iter().map(|p| p.coords).sum::<handover_mesh::Vector>() / vertices as f64
    };
    let mut middle = mean(&shapes[0]);
    for (weight, shape) in weights.iter().zip(&shapes[1..]) {
        middle += *weight * (mean(shape) - mean(&shapes[0]));
    }
    for vertex in 0..vertices {
        left[(rows - 1, vertex)] = 1.0 / vertices as f64;
    }
    for axis in 0..3 {
        right[(rows - 1, axis)] = middle[axis];
    }
    let solved = left.svd(true, true).solve(&right, 1e-12).unwrap();
    (0..vertices).map(|v| Point::new(solved[(v, 0)], solved[(v, 1)], solved[(v, 2)])).collect()
}

#[test]
fn agrees_with_dense_least_squares() {
    for seed in 0..8 {
        let (reference, structure) = block([2, 1, 1], seed);
        let shapes = [
            reference.clone(),
            deformed(&reference, seed, 1.0),
            deformed(&reference, seed + 20, 1.5),
        ];
        for rotation in Rotation::ALL {
            for weights in [[0.5, 0.5], [-0.4, 1.3], [0.2, 0.0]] {
                let settings = BlendSettings { rotation, ..BlendSettings::default() };
                let (found, _) = blended_tetrahedra(&structure, &shapes, &weights, settings);
                let expected = by_least_squares(&structure, &shapes, &weights, rotation);
                let off = farthest(&found, &expected);
                assert!(off < 1e-9, "{seed} {rotation:?} {weights:?}: {off}");
            }
        }
    }
}
