//! How alike two paths are: the paper's errors A and F, in the latent space's unit.

use super::Rows;
use super::rows::distance;

/// Error A: how far apart two paths run. The mean distance from the points of one to the nearest
/// point of the other, in both directions, halved (Gauch & Peters IV-A).
///
/// NaN if one of them is empty.
pub fn error_a(path: &Rows, truth: &Rows) -> f64 {
    0.5 * (mean_distance(path, truth) + mean_distance(truth, path))
}

/// Error F: how near a path comes to the truth's last point (Gauch & Peters IV-A).
///
/// Infinite if the path is empty, or the truth.
pub fn error_f(path: &Rows, truth: &Rows) -> f64 {
    let Some(last) = truth.iter().last() else { return f64::INFINITY };
    nearest(last, path)
}

fn nearest(point: &[f64], path: &Rows) -> f64 {
    path.iter().map(|other| distance(point, other)).fold(f64::INFINITY, f64::min)
}

fn mean_distance(from: &Rows, to: &Rows) -> f64 {
    from.iter().map(|point| nearest(point, to)).sum::<f64>() / from.len() as f64
}
