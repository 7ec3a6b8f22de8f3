//! Rows of numbers, all of one width.

use super::MotionError;

/// The largest size of a number: the squares of two such, summed over any row, stay finite.
pub const LARGEST: f64 = 1e48;

/// Rows of equal width, no number larger than [`LARGEST`]: the poses of a sequence, or points of a
/// latent space.
///
/// ```
/// use handover_mesh::motion::Rows;
/// let poses = Rows::new(3, vec![0.0, 0.1, 0.2, 1.0, 1.1, 1.2])?;
/// assert_eq!((poses.len(), poses.row(1)), (2, &[1.0, 1.1, 1.2][..]));
/// assert!(Rows::new(3, vec![0.0, 0.1]).is_err());
/// # Ok::<(), handover_mesh::motion::MotionError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    width: usize,
    values: Vec<f64>,
}

impl Rows {
    /// The only way in.
    ///
    /// - `width`: numbers per row, at least 1.
    /// - `values`: row after row; none is no rows.
    ///
    /// # Errors
    /// [`MotionError::Ragged`], [`MotionError::OutOfRange`].
    pub fn new(width: usize, values: Vec<f64>) -> Result<Self, MotionError> {
        if width == 0 || !values.len().is_multiple_of(width) {
            return Err(MotionError::Ragged { width, values: values.len() });
        }
        let out_of_range = |value: &f64| value.is_nan() || value.abs() > LARGEST;
        if let Some(at) = values.iter().position(out_of_range) {
            let (row, column) = (at / width, at % width);
            return Err(MotionError::OutOfRange { row, column, value: values[at] });
        }
        Ok(Self { width, values })
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.values.len() / self.width
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The numbers in a row, at least 1.
    pub fn width(&self) -> usize {
        self.width
    }

    /// One row.
    ///
    /// # Panics
    /// If there is no such row: the caller's bug.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.width..][..self.width]
    }

    /// All rows, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        self.values.chunks_exact(self.width)
    }

    /// All numbers, row after row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Rows computed from finite ones: finite themselves, by the caller's word.
    pub(super) fn computed(width: usize, values: Vec<f64>) -> Self {
        debug_assert!(width > 0 && values.len().is_multiple_of(width));
        Self { width, values }
    }
}

/// The distance between two points of one space.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
