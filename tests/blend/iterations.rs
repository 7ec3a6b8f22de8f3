//! The iteration of `E_S`.

use handover_mesh::blend::{BlendError, BlendSettings, Energy};

use crate::shapes::{blended_tetrahedra, block, deformed};

/// The energy before each of so many iterations.
fn energies(energy: Energy, seed: u64, weights: &[f64], count: usize) -> Vec<f64> {
    let (reference, structure) = block([2, 2, 1], seed);
    let shapes =
        [reference.clone(), deformed(&reference, seed, 3.0), deformed(&reference, seed + 50, 3.0)];
    let after = |iterations| {
        let settings =
            BlendSettings { energy, iterations, tolerance: 0.0, ..BlendSettings::default() };
        blended_tetrahedra(&structure, &shapes, weights, settings).1.energy
    };
    (1..=count).map(after).collect()
}

#[test]
fn the_energy_of_shears_never_rises() {
    for seed in 0..10 {
        let energies = energies(Energy::Shears, seed, &[0.8, -0.6], 40);
        for pair in energies.windows(2) {
            assert!(pair[1] <= pair[0] * (1.0 + 1e-12), "{seed}: {pair:?}");
        }
    }
}

#[test]
fn shears_settle() {
    for seed in 0..6 {
        let (reference, structure) = block([2, 2, 1], seed);
        let shapes = [reference.clone(), deformed(&reference, seed, 2.0)];
        let settings = BlendSettings {
            energy: Energy::Shears,
            iterations: 5_000,
            tolerance: 1e-12,
            ..BlendSettings::default()
        };
        let (_, blended) = blended_tetrahedra(&structure, &shapes, &[0.7], settings);
        assert!(blended.iterations < 5_000, "{blended:?}");
        assert!(blended.change <= 1e-12 * 5.0, "{blended:?}");
    }
}

#[test]
fn settings_out_of_bounds_are_refused() {
    let (reference, structure) = block([1, 1, 1], 0);
    let of = |settings| {
        handover_mesh::blend::Blender::of_tetrahedra(&structure, &[&reference], &[], settings)
    };
    for (iterations, tolerance) in [(0, 0.0), (1, -1.0), (1, f64::NAN)] {
        let settings = BlendSettings { iterations, tolerance, ..BlendSettings::default() };
        assert!(matches!(of(settings), Err(BlendError::Settings(_))), "{settings:?}");
    }
}
