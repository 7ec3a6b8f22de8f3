//! Rotations far beyond half a turn (Kaji 2015, Fig. 7).

use handover_mesh::blend::{BlendSettings, Energy, Rotation, Tetrisation};

use crate::shapes::{bar, bar_triangles, blended, farthest, farthest_laid_on, thickness};

#[test]
fn a_twisted_bar_is_untwisted_without_collapse() {
    let triangles = bar_triangles();
    let [thin, thick] = thickness(&bar(0.0));
    for degrees in [180.0f64, 270.0, 360.0, 540.0, 720.0] {
        let twist = degrees.to_radians();
        let shapes = [bar(0.0), bar(twist)];
        for tetrisation in Tetrisation::ALL {
            for energy in [Energy::Transforms, Energy::Shears] {
                for weight in [0.25, 0.5, 0.75] {
                    let settings =
                        BlendSettings { tetrisation, energy, ..BlendSettings::default() };
                    let (found, _) = blended(&triangles, &shapes, &[weight], settings);
                    let [thinnest, thickest] = thickness(&found);
                    assert!(
                        thinnest > 0.6 * thin && thickest < 1.2 * thick,
                        "{degrees}° {settings:?} {weight}: {thinnest} to {thickest}"
                    );
                    // Half a blend is a bar of half the twist, wherever it is turned.
                    let off = farthest_laid_on(&found, &bar(weight * twist));
                    assert!(off < 0.35, "{degrees}° {settings:?} {weight}: {off}");
                }
            }
        }
    }
}

#[test]
fn angles_up_to_half_a_turn_tear_what_is_twisted_farther() {
    let settings = BlendSettings { rotation: Rotation::Principal, ..BlendSettings::default() };
    let [thin, _] = thickness(&bar(0.0));
    let (found, _) =
        blended(&bar_triangles(), &[bar(0.0), bar(4.0 * std::f64::consts::PI)], &[0.5], settings);
    assert!(thickness(&found)[0] < 0.4 * thin);
}

#[test]
fn what_does_not_move_in_a_shape_does_not_move_in_a_blend() {
    // The first third stays, the rest is twisted by a turn and a half.
    let twist = 3.0 * std::f64::consts::PI;
    let (straight, twisted) = (bar(0.0), bar(1.5 * twist));
    let along = |x: f64| ((x / 4.0 - 1.0 / 3.0) / (2.0 / 3.0)).max(0.0);
    let shape = straight.iter().map(|place| {
        nalgebra::Rotation3::new(handover_mesh::Vector::x() * twist * along(place.x)) * place
    });
    let shape: Vec<_> = shape.collect();
    assert!(farthest(&shape, &twisted) > 0.1);
    let settings = BlendSettings::default();
    let (found, _) = blended(&bar_triangles(), &[straight.clone(), shape], &[0.5], settings);
    let still = 8 * 9;
    let off = farthest(&found[..still], &straight[..still]);
    assert!(off < 0.2, "{off}");
}
