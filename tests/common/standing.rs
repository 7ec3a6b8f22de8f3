//! A pose that tests and benches of retargeting start from; included by path.

/// Joints of one upright person who looks along x, in NiTE's order `[m]`.
pub(crate) const STANDING: [[f64; 3]; 15] = [
    [0.0, 0.0, 1.65],
    [0.0, 0.0, 1.45],
    [0.02, 0.0, 1.12],
    [0.0, 0.18, 1.42],
    [0.03, 0.22, 1.15],
    [0.12, 0.22, 0.92],
    [0.0, -0.18, 1.42],
    [0.03, -0.22, 1.15],
    [0.12, -0.22, 0.92],
    [0.0, 0.1, 0.92],
    [0.03, 0.11, 0.5],
    [0.0, 0.12, 0.08],
    [0.0, -0.1, 0.92],
    [0.03, -0.11, 0.5],
    [0.0, -0.12, 0.08],
];
