//! Whatever triangles and shapes, it ends, and what it says is finite.

use handover_mesh::Point;
use handover_mesh::blend::{BlendSettings, Blender, Triangles};
use proptest::prelude::*;

use crate::ends::every_way;

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1.0f64..1.0,
        1 => prop::sample::select(vec![0.0, 1.0, 1e-300, 1e150, -1e300, 1e-12]),
    ]
}

proptest! {
    #[test]
    fn no_triangles_panic(
        corners in prop::collection::vec(prop::array::uniform3(0u32..7), 1..12),
        places in prop::collection::vec(prop::array::uniform3(coordinate()), 14),
        weight in prop_oneof![-3.0f64..3.0, Just(1e6)],
        way in 0usize..18,
    ) {
        let Ok(triangles) = Triangles::new(7, corners) else { return Ok(()) };
        let places: Vec<Point> = places.into_iter().map(Point::from).collect();
        let settings = every_way().nth(way).unwrap();
        let settings = BlendSettings { iterations: 3, ..settings };
        let shapes = [&places[..7], &places[7..]];
        let Ok(blender) = Blender::of_triangles(&triangles, &shapes, settings) else {
            return Ok(());
        };
        let mut out = places[..7].to_vec();
        blender.blend(&[0.0], &mut blender.workspace(), &mut out);
        prop_assert!(out.iter().all(|place| place.iter().all(|along| along.is_finite())));
        // What it says beyond all bounds may be infinite; it has to end.
        blender.blend(&[weight], &mut blender.workspace(), &mut out);
    }
}

#[test]
fn a_fan_of_many_triangles_takes_room_in_proportion() {
    // All triangles at one vertex: a ghost above it would join all corners with each other.
    const MANY: u32 = 20_000;
    let turn = |at: u32| std::f64::consts::TAU * f64::from(at) / f64::from(MANY);
    let rim = (0..MANY).map(|at| Point::new(turn(at).cos(), turn(at).sin(), 0.0));
    let places: Vec<Point> = std::iter::once(Point::new(0.0, 0.0, 1.0)).chain(rim).collect();
    let corners = (0..MANY).map(|at| [0, 1 + at, 1 + (at + 1) % MANY]).collect();
    let triangles = Triangles::new(places.len(), corners).unwrap();
    for tetrisation in handover_mesh::blend::Tetrisation::ALL {
        let settings = BlendSettings { tetrisation, ..BlendSettings::default() };
        let blender = Blender::of_triangles(&triangles, &[&places, &places], settings).unwrap();
        let mut out = places.clone();
        blender.blend(&[0.5], &mut blender.workspace(), &mut out);
        assert!(crate::shapes::farthest(&out, &places) < 1e-6, "{tetrisation:?}");
    }
}
