//! Ridge-regularised least squares, shared by the regressions.
//!
//! Knows nothing of what the numbers mean.

use nalgebra::DMatrix;

/// `argmin_B ‖X B − Y‖² + penalty ‖B‖²`: `(XᵀX + λI)⁻¹ XᵀY`.
///
/// `x` is samples × inputs, `y` samples × outputs; `penalty > 0` makes the system positive
/// definite whatever `x` holds.
pub(crate) fn ridge(x: &DMatrix<f64>, y: &DMatrix<f64>, penalty: f64) -> DMatrix<f64> {
    let mut normal = x.tr_mul(x);
    for i in 0..normal.nrows() {
        normal[(i, i)] += penalty;
    }
    let right = x.tr_mul(y);
    match normal.cholesky() {
        Some(factor) => factor.solve(&right),
        // Only where a penalty underflows beside huge inputs: then nothing is predicted from them.
        None => DMatrix::zeros(x.ncols(), y.ncols()),
    }
}
