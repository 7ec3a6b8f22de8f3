//! Signs and volumes of simplices in integers, in any number of dimensions.

/// An integer point: of size up to 2¹⁰ where spheres are asked for, or else an overflow panics.
pub(crate) type Cell = Vec<i64>;

/// By elimination without fractions (Bareiss 1968): every number met is a minor.
fn determinant(mut rows: Vec<Vec<i128>>) -> i128 {
    let size = rows.len();
    let (mut sign, mut before) = (1, 1);
    for k in 0..size {
        let Some(pivot) = (k..size).find(|&i| rows[i][k] != 0) else { return 0 };
        if pivot != k {
            rows.swap(pivot, k);
            sign = -sign;
        }
        for i in k + 1..size {
            for j in k + 1..size {
                rows[i][j] = (rows[i][j] * rows[k][k] - rows[i][k] * rows[k][j]) / before;
            }
        }
        before = rows[k][k];
    }
    sign * before
}

fn minus(a: &Cell, b: &Cell) -> Vec<i128> {
    a.iter().zip(b).map(|(a, b)| i128::from(a - b)).collect()
}

/// The volume of a simplex times a factorial, with its orientation.
pub(crate) fn volume(corners: &[&Cell]) -> i128 {
    determinant(corners[1..].iter().map(|corner| minus(corner, corners[0])).collect())
}

/// Positive if `place` is strictly inside the sphere through the corners, negative outside.
pub(crate) fn in_sphere(corners: &[&Cell], place: &Cell) -> i128 {
    let lifted = corners.iter().map(|corner| {
        let mut row = minus(corner, place);
        row.push(row.iter().map(|x| x * x).sum());
        row
    });
    let even = if place.len().is_multiple_of(2) { 1 } else { -1 };
    even * determinant(lifted.collect()).signum() * volume(corners).signum()
}

/// Whether a simplex holds a place, its rim included.
pub(crate) fn holds(corners: &[&Cell], place: &Cell) -> bool {
    let whole = volume(corners).signum();
    (0..corners.len()).all(|at| {
        let mut part = corners.to_vec();
        part[at] = place;
        volume(&part).signum() * whole >= 0
    })
}

#[test]
fn signs_are_those_of_a_known_simplex() {
    for dimensions in 2..=4 {
        let unit = |axis: usize| (0..dimensions).map(|i| i64::from(i + 1 == axis)).collect();
        let corners: Vec<Cell> = (0..=dimensions).map(unit).collect();
        let corners: Vec<&Cell> = corners.iter().collect();
        assert_eq!(volume(&corners), 1);
        // The sphere goes through all corners of the unit cube.
        assert_eq!(in_sphere(&corners, &vec![1; dimensions]), 0);
        assert_eq!(in_sphere(&corners, &vec![2; dimensions]), -1);
        let mut turned = corners.clone();
        turned.swap(0, 1);
        assert_eq!((volume(&turned), in_sphere(&turned, &vec![2; dimensions])), (-1, -1));
        assert!(holds(&turned, &vec![0; dimensions]) && !holds(&turned, &vec![1; dimensions]));
    }
    let square: [&Cell; 3] = [&vec![0, 0], &vec![4, 0], &vec![0, 4]];
    assert_eq!(in_sphere(&square, &vec![3, 3]), 1);
    let cube: [&Cell; 4] = [&vec![0, 0, 0], &vec![4, 0, 0], &vec![0, 4, 0], &vec![0, 0, 4]];
    assert_eq!(in_sphere(&cube, &vec![3, 3, 3]), 1);
}
