//! Ghosts and tetrahedra, and what triangles are refused or taken otherwise.

use handover_mesh::blend::{BlendError, BlendSettings, Blender, Tetrisation, Triangles, tetrise};
use handover_mesh::{Isometry, Point, Vector};

use crate::shapes::{blended, farthest, octahedron};

fn points(places: &[[f64; 3]]) -> Vec<Point> {
    places.iter().copied().map(Point::from).collect()
}

/// Two triangles of a square, bent along the diagonal by a height.
fn square(height: f64) -> (Vec<Point>, Triangles) {
    let places = [[0.0, 0.0, 0.0], [1.0, 0.0, height], [1.0, 1.0, 0.0], [0.0, 1.0, height]];
    (points(&places), Triangles::new(4, vec![[0, 1, 2], [0, 2, 3]]).unwrap())
}

#[track_caller]
fn counts(places: &[Point], triangles: &Triangles, tetrisation: Tetrisation) -> [usize; 4] {
    let tetrised = tetrise(triangles, &[places], tetrisation).unwrap();
    let structure = tetrised.structure();
    [
        structure.tetrahedra().len(),
        structure.vertices() - places.len(),
        tetrised.flipped(),
        tetrised.replaced(),
    ]
}

#[test]
fn a_closed_surface_has_the_papers_numbers() {
    let (places, triangles) = octahedron();
    // 8 faces, 12 edges, 6 vertices.
    assert_eq!(counts(&places, &triangles, Tetrisation::Face), [8, 8, 0, 0]);
    assert_eq!(counts(&places, &triangles, Tetrisation::Edge), [24, 12, 0, 0]);
    assert_eq!(counts(&places, &triangles, Tetrisation::Vertex), [24, 6, 0, 0]);
}

#[test]
fn ghosts_are_where_the_paper_has_them() {
    let (places, triangles) = square(0.0);
    let ghosts = |tetrisation| {
        let tetrised = tetrise(&triangles, &[&places], tetrisation).unwrap();
        tetrised.with_ghosts(&places)[4..].to_vec()
    };
    let check = |found: Vec<Point>, expected: &[[f64; 3]]| {
        assert_eq!(found.len(), expected.len());
        assert!(farthest(&found, &points(expected)) < 1e-12, "{found:?}");
    };
    let third = 1.0 / 3.0;
    check(ghosts(Tetrisation::Face), &[[2.0 * third, third, 1.0], [third, 2.0 * third, 1.0]]);
    check(ghosts(Tetrisation::Edge), &[[0.5, 0.5, 2f64.sqrt()]]);
    // Vertices 1 and 3 belong to one triangle each.
    check(ghosts(Tetrisation::Vertex), &[[0.0, 0.0, 1.0], [1.0, 1.0, 1.0]]);
}

#[test]
fn ghosts_move_and_grow_with_the_shape() {
    let (places, triangles) = octahedron();
    let turn = Isometry::new(Vector::new(1.0, 2.0, 3.0), Vector::new(0.3, 0.2, 1.0));
    let moved: Vec<Point> = places.iter().map(|place| turn * (place * 2.5)).collect();
    for tetrisation in Tetrisation::ALL {
        let tetrised = tetrise(&triangles, &[&places, &moved], tetrisation).unwrap();
        let expected: Vec<Point> =
            tetrised.with_ghosts(&places).iter().map(|place| turn * (place * 2.5)).collect();
        assert!(farthest(&tetrised.with_ghosts(&moved), &expected) < 1e-12);
    }
}

#[test]
fn lone_triangles_take_the_ghost_over_their_face() {
    let places = points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let triangles = Triangles::new(3, vec![[0, 1, 2]]).unwrap();
    for tetrisation in Tetrisation::ALL {
        let replaced = usize::from(tetrisation != Tetrisation::Face);
        assert_eq!(counts(&places, &triangles, tetrisation), [1, 1, 0, replaced]);
    }
}

#[test]
fn what_is_inside_out_in_a_shape_is_left_out_and_counted() {
    let (open, triangles) = square(0.0);
    // Folded shut the other way round: the normals at the diagonal cancel out.
    let shut = points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
    for (tetrisation, flipped) in [(Tetrisation::Edge, 2), (Tetrisation::Vertex, 4)] {
        let tetrised = tetrise(&triangles, &[&open, &shut], tetrisation).unwrap();
        assert_eq!((tetrised.flipped(), tetrised.replaced()), (flipped, 2), "{tetrisation:?}");
        let settings = BlendSettings { tetrisation, ..BlendSettings::default() };
        let (found, _) = blended(&triangles, &[open.clone(), shut.clone()], &[1.0], settings);
        assert!(farthest(&found, &shut) < 1e-9);
    }
}

#[test]
fn triangles_without_area_are_left_out_and_their_vertices_held_by_others_or_the_mean() {
    let places = points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]]);
    let triangles = Triangles::new(4, vec![[0, 1, 2], [0, 3, 1]]).unwrap();
    for tetrisation in Tetrisation::ALL {
        let settings = BlendSettings { tetrisation, ..BlendSettings::default() };
        let blender = Blender::of_triangles(&triangles, &[&places, &places], settings).unwrap();
        assert_eq!(blender.free(), 1, "{tetrisation:?}");
        let mut out = places.clone();
        blender.blend(&[0.5], &mut blender.workspace(), &mut out);
        assert!(farthest(&out, &places) < 1e-9);
    }
    let line = points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    for tetrisation in Tetrisation::ALL {
        let refused = tetrise(&triangles, &[&line], tetrisation);
        assert_eq!(refused.unwrap_err(), BlendError::Empty);
    }
}

#[test]
fn what_is_no_surface_is_refused_with_all_its_faults() {
    let places = points(&[
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.2],
        [0.0, 0.3, 1.0],
        [5.0, 0.0, 0.0],
        [5.0, 1.0, 0.0],
    ]);
    // Three triangles at the edge 0-1.
    let fin = Triangles::new(7, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
    // Two triangles that go along 0-1 the same way.
    let twisted = Triangles::new(7, vec![[0, 1, 2], [0, 1, 3]]).unwrap();
    // Two triangles that share the corner 1 alone.
    let bow = Triangles::new(7, vec![[0, 1, 2], [1, 5, 6]]).unwrap();
    let refused = |triangles: &Triangles, tetrisation| {
        tetrise(triangles, &[&places], tetrisation).unwrap_err().to_string()
    };
    for tetrisation in [Tetrisation::Edge, Tetrisation::Vertex] {
        for triangles in [&fin, &twisted] {
            assert!(refused(triangles, tetrisation).contains("at edge 0-1"));
        }
    }
    assert!(refused(&bow, Tetrisation::Vertex).contains("more than one fan at vertex 1"));
    // Edges are none the worse for that, and faces for nothing.
    assert!(tetrise(&bow, &[&places], Tetrisation::Edge).is_ok());
    for triangles in [&fin, &twisted, &bow] {
        assert!(tetrise(triangles, &[&places], Tetrisation::Face).is_ok());
    }
}

#[test]
fn what_is_no_triangle_or_shape_is_refused_by_name() {
    for corners in [[0, 1, 1], [0, 1, 4]] {
        let refused = Triangles::new(4, vec![[0, 1, 2], corners]).unwrap_err();
        assert!(refused.to_string().starts_with("triangle 1 has the corners"), "{refused}");
    }
    let (places, triangles) = square(0.1);
    let refused = |shapes: &[&[Point]]| {
        Blender::of_triangles(&triangles, shapes, BlendSettings::default()).unwrap_err()
    };
    assert_eq!(refused(&[]), BlendError::NoShape);
    let shape = BlendError::Shape { shape: 1, places: 3, vertices: 4 };
    assert_eq!(refused(&[&places, &places[..3]]), shape);
    let mut broken = places.clone();
    broken[2].y = f64::NAN;
    assert_eq!(refused(&[&places, &broken]), BlendError::NotFinite { shape: 1, vertex: 2 });
}
