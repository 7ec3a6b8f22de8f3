//! The paper's errors A and F.

use handover_mesh::motion::{Rows, error_a, error_f};
use proptest::prelude::*;

use crate::random;

#[test]
fn errors_are_those_computed_by_hand() {
    let path = Rows::new(2, vec![0.0, 0.0, 1.0, 0.0, 2.0, 0.0]).unwrap();
    let truth = Rows::new(2, vec![0.0, 1.0, 5.0, 4.0]).unwrap();
    // From the path: 1, √2, √5; from the truth: 1, 5.
    let from_path = (1.0 + 2_f64.sqrt() + 5_f64.sqrt()) / 3.0;
    assert!((error_a(&path, &truth) - 0.5 * (from_path + 3.0)).abs() < 1e-15);
    assert_eq!(error_f(&path, &truth), 5.0);
    // F asks how near the path comes to the end, not where it ends.
    assert!((error_f(&truth, &path) - 5_f64.sqrt()).abs() < 1e-15);
    let none = Rows::new(2, vec![]).unwrap();
    assert!(error_a(&none, &path).is_nan() && error_a(&path, &none).is_nan());
    assert_eq!([error_f(&none, &path), error_f(&path, &none)], [f64::INFINITY; 2]);
}

proptest! {
    #[test]
    fn errors_are_zero_of_equal_paths_and_bounded_by_a_shift(
        seed: u64, count in 1..20_usize, width in 1..5_usize, shift in 0.0..3.0,
    ) {
        let path = random(seed, count, width);
        prop_assert_eq!((error_a(&path, &path), error_f(&path, &path)), (0.0, 0.0));
        let values = path.values().iter().enumerate();
        let moved = values.map(|(at, x)| if at % width == 0 { x + shift } else { *x });
        let moved = Rows::new(width, moved.collect()).unwrap();
        prop_assert!(error_a(&path, &moved) <= shift + 1e-12);
        prop_assert!(error_f(&path, &moved) <= shift + 1e-12);
        let other = random(seed + 1, count + 3, width);
        prop_assert_eq!(error_a(&path, &other), error_a(&other, &path));
        prop_assert!(error_a(&path, &other) > 0.0);
        let repeated = Rows::new(width, path.values().repeat(2)).unwrap();
        prop_assert!((error_a(&repeated, &other) - error_a(&path, &other)).abs() < 1e-12);
    }
}
