//! No weight gives the reference, all of it on one shape gives that shape.

use handover_mesh::Point;
use handover_mesh::blend::{BlendSettings, Blender, Energy, Rotation, Tetrisation};

use crate::shapes::{bar_triangles, turned_bar};

/// The farthest two vertices of the same number are apart.
fn farthest(a: &[Point], b: &[Point]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

#[test]
fn the_ends_are_the_shapes() {
    let triangles = bar_triangles();
    let shapes = [turned_bar(0.0), turned_bar(2.0), turned_bar(-1.0)];
    let shapes: Vec<&[Point]> = shapes.iter().map(Vec::as_slice).collect();
    for tetrisation in Tetrisation::ALL {
        for rotation in Rotation::ALL {
            for energy in Energy::ALL {
                let settings =
                    BlendSettings { tetrisation, rotation, energy, ..BlendSettings::default() };
                let blender = Blender::of_triangles(&triangles, &shapes, settings).unwrap();
                let mut workspace = blender.workspace();
                let mut out = shapes[0].to_vec();
                for (weights, expected) in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].iter().zip(&shapes)
                {
                    let blended = blender.blend(weights, &mut workspace, &mut out);
                    let off = farthest(&out, expected);
                    println!("{settings:?} {weights:?} {off:e} {blended:?} {}", blender.flipped());
                    assert!(off < 1e-9 * 4.0, "{settings:?} {weights:?}: {off}");
                }
            }
        }
    }
}
