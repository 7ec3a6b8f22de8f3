//! The definition, in integers: apart from the library's own predicates.

use handover_mesh::Point;
use handover_mesh::delaunay::{Delaunay, delaunay};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// An integer point, coordinates up to 2²⁰ in size.
pub(crate) type Cell = [i64; 3];

/// `det(b − a, c − a, d − a)`.
pub(crate) fn volume(a: Cell, b: Cell, c: Cell, d: Cell) -> i128 {
    let minus = |p: Cell| [0, 1, 2].map(|i| i128::from(p[i] - a[i]));
    det([minus(b), minus(c), minus(d)])
}

fn det([b, c, d]: [[i128; 3]; 3]) -> i128 {
    b[0] * (c[1] * d[2] - c[2] * d[1])
        + b[1] * (c[2] * d[0] - c[0] * d[2])
        + b[2] * (c[0] * d[1] - c[1] * d[0])
}

/// Positive if `p` is strictly inside the sphere of a positively oriented tetrahedron.
///
/// The determinant of the lifted differences to `p`, expanded along the lifted column. Differences
/// are at most 2²¹, minors 6·2⁶³, squared distances 3·2⁴²: the sum stays below 2¹¹³.
pub(crate) fn in_sphere(corners: [Cell; 4], p: Cell) -> i32 {
    let rows = corners.map(|corner| [0, 1, 2].map(|i| i128::from(corner[i] - p[i])));
    let lift = rows.map(|r| r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    let mut sum = 0;
    for i in 0..4 {
        let others: Vec<[i128; 3]> = (0..4).filter(|&j| j != i).map(|j| rows[j]).collect();
        let minor = det([others[0], others[1], others[2]]);
        sum += if i % 2 == 0 { minor } else { -minor } * lift[i];
    }
    sum.signum() as i32
}

pub(crate) fn at(cell: Cell, unit: f64) -> Point {
    Point::from(cell.map(|c| c as f64 * unit))
}

/// All the definition asks for, exactly.
#[track_caller]
pub(crate) fn check(cells: &[Cell], unit: f64) -> Delaunay {
    let points: Vec<Point> = cells.iter().map(|&cell| at(cell, unit)).collect();
    let found = delaunay(&points).expect("the points span a volume");
    let corners = |t: &[u32; 4]| t.map(|v| cells[v as usize]);

    let mut first = HashMap::new();
    let mut dropped = Vec::new();
    for (index, cell) in cells.iter().enumerate() {
        match first.get(cell) {
            Some(&kept) => dropped.push([index, kept]),
            None => drop(first.insert(*cell, index)),
        }
    }
    assert_eq!(found.duplicates(), dropped);
    let used: BTreeSet<usize> = found.tetrahedra().iter().flatten().map(|&v| v as usize).collect();
    assert_eq!(used, first.values().copied().collect(), "vertices");

    // Facets by corners: two tetrahedra on opposite sides, or one and then a face of the hull.
    let mut facets: BTreeMap<[u32; 3], Vec<(u32, [u32; 3])>> = BTreeMap::new();
    let mut sum = 0;
    for t in found.tetrahedra() {
        let [a, b, c, d] = corners(t);
        assert!(volume(a, b, c, d) > 0, "{t:?} is flat or turned inside out");
        sum += volume(a, b, c, d);
        for cell in first.keys() {
            assert!(in_sphere([a, b, c, d], *cell) <= 0, "{cell:?} inside the sphere of {t:?}");
        }
        let [a, b, c, d] = *t;
        for (apex, facet) in [(a, [b, d, c]), (b, [a, c, d]), (c, [a, d, b]), (d, [a, b, c])] {
            let mut key = facet;
            key.sort_unstable();
            facets.entry(key).or_default().push((apex, facet));
        }
    }
    // The cone from one point over the hull's faces is the hull.
    let mut hull = 0;
    let mut rim: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for sides in facets.values() {
        assert!(sides.len() <= 2);
        let [a, b, c] = sides[0].1.map(|v| cells[v as usize]);
        let side = |v: u32| volume(a, b, c, cells[v as usize]).signum();
        if let [(one, _), (other, _)] = sides[..] {
            assert_eq!(side(one), -side(other), "both on one side");
            continue;
        }
        for cell in first.keys() {
            assert!(volume(a, b, c, *cell).signum() * side(sides[0].0) >= 0, "not the hull");
        }
        hull += volume(a, b, c, cells[0]).abs();
        let [a, b, c] = sides[0].1;
        for [i, j] in [[a, b], [b, c], [c, a]] {
            *rim.entry([i.min(j), i.max(j)]).or_default() += if i < j { 1 } else { -1 };
        }
    }
    assert!(rim.values().all(|&turns| turns == 0), "the boundary is not closed");
    assert_eq!(sum, hull, "volume");

    let edges = found.edges();
    assert!(edges.windows(2).all(|pair| pair[0] < pair[1]));
    let expected: BTreeSet<[usize; 2]> = (found.tetrahedra().iter())
        .flat_map(|t| (0..16).map(move |k| [t[k / 4] as usize, t[k % 4] as usize]))
        .filter(|[i, j]| i < j)
        .collect();
    assert!(edges.iter().eq(expected.iter()));
    found
}
