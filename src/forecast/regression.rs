//! Displacements as a linear function of features: the baseline `ridge`, and the space that the
//! fields are in.

use nalgebra::DMatrix;

use super::examples::Examples;
use crate::linear;

/// `d_h = m_h + B_hᵀ (φ − μ)` per horizon, ridge-regularised about the means of the moments that
/// reach it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Regression {
    feature_mean: Vec<f64>,
    /// `horizons × joints`: what is expected at the mean of all features.
    displacement_mean: Vec<f64>,
    /// `width × (horizons · joints)`, row by row.
    coefficients: Vec<f64>,
}

impl Regression {
    /// - `penalty`: per moment.
    pub(super) fn fit(examples: &Examples, horizons: usize, penalty: f64) -> Self {
        let (count, width, joints) = (examples.len(), examples.width, examples.joints);
        let outputs = horizons * joints;
        let mean_features = |moments: &[usize]| {
            let share = 1.0 / moments.len() as f64;
            let mut mean = vec![0.0; width];
            for moment in moments {
                let features = examples.features_of(*moment).iter();
                mean.iter_mut().zip(features).for_each(|(m, x)| *m += x * share);
            }
            mean
        };
        let feature_mean = mean_features(&(0..count).collect::<Vec<_>>());
        let mut displacement_mean = vec![0.0; outputs];
        let mut coefficients = vec![0.0; width * outputs];
        for horizon in 0..horizons {
            let reaching: Vec<usize> =
                (0..count).filter(|m| examples.reach[*m] as usize > horizon).collect();
            if reaching.is_empty() {
                continue;
            }
            let displacement =
                |row: usize| examples.displacement_of(reaching[row], horizon, horizons);
            let mean = &mut displacement_mean[horizon * joints..][..joints];
            for row in 0..reaching.len() {
                let share = 1.0 / reaching.len() as f64;
                mean.iter_mut().zip(displacement(row)).for_each(|(m, d)| *m += d * share);
            }
            // Those that reach as far have a mean of their own, which goes with that of where they go.
            let own_mean = mean_features(&reaching);
            let x = DMatrix::from_fn(reaching.len(), width, |row, column| {
                examples.features_of(reaching[row])[column] - own_mean[column]
            });
            let y = DMatrix::from_fn(reaching.len(), joints, |row, column| {
                displacement(row)[column] - mean[column]
            });
            let solved = linear::ridge(&x, &y, penalty * reaching.len() as f64);
            for feature in 0..width {
                let row = &mut coefficients[feature * outputs + horizon * joints..][..joints];
                row.iter_mut().zip(solved.row(feature).iter()).for_each(|(c, s)| *c = *s);
                let off = feature_mean[feature] - own_mean[feature];
                mean.iter_mut().zip(row).for_each(|(m, c)| *m += *c * off);
            }
        }
        Self { feature_mean, displacement_mean, coefficients }
    }

    /// Displacements over all horizons, `horizons × joints` `[m]`; overwritten.
    pub(super) fn predict(&self, features: &[f64], displacement: &mut [f64]) {
        displacement.copy_from_slice(&self.displacement_mean);
        let rows = self.coefficients.chunks_exact(displacement.len());
        for ((row, feature), mean) in rows.zip(features).zip(&self.feature_mean) {
            let centred = feature - mean;
            displacement.iter_mut().zip(row).for_each(|(d, c)| *d += c * centred);
        }
    }
}
