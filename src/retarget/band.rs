//! Banded symmetric positive definite systems: `A = L Lᵀ`, factored in place, no pivoting.
//!
//! Unknowns ordered frame by frame couple only within a fixed distance, so the factor fills the
//! band and nothing else (George & Liu 1981, 4.2). Rows are stored contiguously and factored four at
//! a time, turned so that four numbers of a column lie side by side.
//!
//! Knows nothing of meshes. Allocates only when made.

use pulp::{Arch, Simd, WithSimd};

/// Rows factored together; their storage starts at a common column.
const BLOCK: usize = 4;

/// A pivot below this share of its diagonal entry means the system does not determine its unknown.
const PIVOT_TOLERANCE: f64 = 1e-12;

/// The lower half of a symmetric matrix within its band, or its Cholesky factor.
#[derive(Debug, Clone)]
pub struct BandMatrix {
    size: usize,
    /// Columns stored left of a block of rows.
    reach: usize,
    /// `size` rows of `reach + BLOCK` numbers.
    values: Vec<f64>,
    /// A block's rows, column by column: room for [`Self::factor`].
    panel: Vec<[f64; BLOCK]>,
    /// `1 / L[r][r]`.
    inverse_diagonal: Vec<f64>,
    arch: Arch,
}

/// The unknown at which a factorisation found the system undetermined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotPositiveDefinite {
    /// Row of the matrix.
    pub row: usize,
}

impl BandMatrix {
    /// A zero matrix of `size` rows whose entries lie within `half_bandwidth` of the diagonal.
    pub fn new(size: usize, half_bandwidth: usize) -> Self {
        let reach = half_bandwidth.next_multiple_of(BLOCK);
        Self {
            size,
            reach,
            values: vec![0.0; size * (reach + BLOCK)],
            panel: vec![[0.0; BLOCK]; reach + BLOCK],
            inverse_diagonal: vec![0.0; size],
            arch: Arch::new(),
        }
    }

    /// Entries farther from the diagonal than this are zero.
    pub fn half_bandwidth(&self) -> usize {
        self.reach
    }

    /// The number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Takes over the values of a matrix of the same shape.
    ///
    /// # Panics
    /// If it has another shape: the caller's bug.
    pub fn copy_from(&mut self, other: &Self) {
        self.values.copy_from_slice(&other.values);
        self.inverse_diagonal.copy_from_slice(&other.inverse_diagonal);
    }

    /// Sets every entry to zero, ready for [`Self::add`].
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds to the entry at `row`, `column ≤ row`, within the band.
    #[inline]
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let at = self.place(row, column);
        self.values[at] += value;
    }

    /// The entry at `row`, `column ≤ row`, within the band.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        self.values[self.place(row, column)]
    }

    /// Where `column` of `row` is stored. A block's rows share their first column, which is
    /// `reach` left of the block, so `+ reach` keeps the difference from going negative.
    #[inline]
    fn place(&self, row: usize, column: usize) -> usize {
        debug_assert!(column <= row && column + self.reach >= row - row % BLOCK);
        row * (self.reach + BLOCK) + column + self.reach - (row - row % BLOCK)
    }

    /// The product with `W` columns at once, of the matrix itself: before [`Self::factor`].
    ///
    /// # Panics
    /// If there is not one row per unknown.
    pub fn multiply<const W: usize>(&self, x: &[[f64; W]]) -> Vec<[f64; W]> {
        assert_eq!(x.len(), self.size, "one row per unknown");
        let width = self.reach + BLOCK;
        let mut product = vec![[0.0; W]; self.size];
        for row in 0..self.size {
            let (first, start) = self.first_of(row);
            let values = &self.values[row * width + start..][..row - first];
            let mut sum = x[row].map(|x| x * self.get(row, row));
            for (column, value) in (first..).zip(values) {
                for w in 0..W {
                    sum[w] += value * x[column][w];
                    product[column][w] += value * x[row][w];
                }
            }
            for w in 0..W {
                product[row][w] += sum[w];
            }
        }
        product
    }

    /// Replaces the matrix by its factor `L`.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] names the first undetermined unknown; the values are then
    /// meaningless until the next [`Self::clear`].
    pub fn factor(&mut self) -> Result<(), NotPositiveDefinite> {
        let arch = self.arch;
        arch.dispatch(Factor(self))
    }

    #[inline(always)]
    fn factor_blocks(&mut self) -> Result<(), NotPositiveDefinite> {
        let Self { size, reach, values, inverse_diagonal, panel, .. } = self;
        let (size, reach, width) = (*size, *reach, *reach + BLOCK);
        for block in (0..size).step_by(BLOCK) {
            let rows = BLOCK.min(size - block);
            let (above, here) = values.split_at_mut(block * width);
            let here = &mut here[..rows * width];
            let first = block.saturating_sub(reach);
            // Column `c` of the block's rows is stored at `c + reach − block` in each.
            let start = first + reach - block;
            let panel = &mut panel[..block - first + BLOCK];
            for (row, values) in here.chunks_exact(width).enumerate() {
                for (column, value) in panel.iter_mut().zip(&values[start..]) {
                    column[row] = *value;
                }
            }
            // `first` is a block's, too: the columns come block by block.
            for column in (first..block).step_by(BLOCK) {
                let (known, open) = panel.split_at_mut(column - first);
                let from = first + reach - column;
                let rows = &above[column * width..][..BLOCK * width];
                let sums = sums_of_four(known, |at| &rows[at * width + from..]);
                for at in 0..BLOCK {
                    let scale = inverse_diagonal[column + at];
                    let (earlier, now) = open.split_at_mut(at);
                    let mut sum = sums[at];
                    for (earlier, factor) in earlier.iter().zip(&rows[at * width + reach..]) {
                        for row in 0..BLOCK {
                            sum[row] = factor.mul_add(earlier[row], sum[row]);
                        }
                    }
                    for row in 0..BLOCK {
                        now[0][row] = (now[0][row] - sum[row]) * scale;
                    }
                }
            }
            let (known, own) = panel.split_at_mut(block - first);
            for (row, values) in here.chunks_exact_mut(width).enumerate() {
                for (column, value) in known.iter().zip(&mut values[start..]) {
                    *value = column[row];
                }
            }
            let sums = sums_of_four(known, |at| &here[at.min(rows - 1) * width + start..]);
            for column in 0..rows {
                for row in column..rows {
                    let earlier = own[..column].iter().map(|own| own[column] * own[row]);
                    let sum = sums[column][row] + earlier.sum::<f64>();
                    let entry = own[column][row];
                    let value = entry - sum;
                    own[column][row] = if row > column {
                        value * inverse_diagonal[block + column]
                    } else if value.is_nan() || value <= PIVOT_TOLERANCE * entry {
                        return Err(NotPositiveDefinite { row: block + column });
                    } else {
                        inverse_diagonal[block + column] = 1.0 / value.sqrt();
                        value.sqrt()
                    };
                    here[row * width + reach + column] = own[column][row];
                }
            }
        }
        Ok(())
    }

    /// Solves `L Lᵀ x = b` in place for `W` right-hand sides at once; call after
    /// [`Self::factor`].
    ///
    /// # Panics
    /// If `rhs` has not one row per unknown.
    pub fn solve<const W: usize>(&self, rhs: &mut [[f64; W]]) {
        assert_eq!(rhs.len(), self.size, "one row of the right-hand side per unknown");
        self.arch.dispatch(Substitute(self, rhs));
    }

    #[inline(always)]
    fn substitute<const W: usize>(&self, rhs: &mut [[f64; W]]) {
        let width = self.reach + BLOCK;
        for row in 0..self.size {
            let (first, start) = self.first_of(row);
            let (solved, rest) = rhs.split_at_mut(row);
            let coefficients = &self.values[row * width + start..][..row - first];
            let solved = &solved[first..];
            // As many sums at once as fill the registers: one would wait for itself.
            let sum = if W == 1 {
                weighted_sum::<W, 8>(coefficients, solved)
            } else {
                weighted_sum::<W, 4>(coefficients, solved)
            };
            for w in 0..W {
                rest[0][w] = (rest[0][w] - sum[w]) * self.inverse_diagonal[row];
            }
        }
        for row in (0..self.size).rev() {
            let (first, start) = self.first_of(row);
            let (open, rest) = rhs.split_at_mut(row);
            let coefficients = &self.values[row * width + start..][..row - first];
            let value = rest[0].map(|v| v * self.inverse_diagonal[row]);
            rest[0] = value;
            take_away(coefficients, value, &mut open[first..]);
        }
    }

    /// A row's first stored column that exists, and where in the row it is stored.
    #[inline]
    fn first_of(&self, row: usize) -> (usize, usize) {
        let block = row - row % BLOCK;
        let first = block.saturating_sub(self.reach);
        (first, first + self.reach - block)
    }
}

/// Work that is compiled once for each set of vector instructions; all it calls is inlined.
struct Factor<'a>(&'a mut BandMatrix);

impl WithSimd for Factor<'_> {
    type Output = Result<(), NotPositiveDefinite>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        self.0.factor_blocks()
    }
}

/// As [`Factor`], for the substitutions.
struct Substitute<'a, const W: usize>(&'a BandMatrix, &'a mut [[f64; W]]);

impl<const W: usize> WithSimd for Substitute<'_, W> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.0.substitute(self.1);
    }
}

/// `Σ coefficientᵢ · rowᵢ`, by `L` sums that do not wait for each other.
#[inline(always)]
fn weighted_sum<const W: usize, const L: usize>(
    coefficients: &[f64],
    rows: &[[f64; W]],
) -> [f64; W] {
    let (coefficients, rows) = (coefficients.chunks_exact(L), rows.chunks_exact(L));
    let mut total = [0.0; W];
    for (coefficient, row) in coefficients.remainder().iter().zip(rows.remainder()) {
        for w in 0..W {
            total[w] = coefficient.mul_add(row[w], total[w]);
        }
    }
    let mut sums = [[0.0; W]; L];
    for (coefficients, rows) in coefficients.zip(rows) {
        for lane in 0..L {
            for w in 0..W {
                sums[lane][w] = coefficients[lane].mul_add(rows[lane][w], sums[lane][w]);
            }
        }
    }
    for sum in sums {
        for w in 0..W {
            total[w] += sum[w];
        }
    }
    total
}

/// Takes `coefficientᵢ · value` from each row.
///
/// A few rows in one go, in local arrays: only of those does the compiler know that they do not
/// overlap the coefficients; and row by row it would gather each column of them first.
#[inline(always)]
fn take_away<const W: usize>(coefficients: &[f64], value: [f64; W], rows: &mut [[f64; W]]) {
    const ROWS: usize = 4;
    let coefficients = coefficients.chunks_exact(ROWS);
    let mut rows = rows.chunks_exact_mut(ROWS);
    let rest = coefficients.remainder();
    for (coefficients, rows) in coefficients.zip(&mut rows) {
        let (mut factors, mut block) = ([0.0; ROWS], [[0.0; W]; ROWS]);
        factors.copy_from_slice(coefficients);
        block.copy_from_slice(rows);
        for row in 0..ROWS {
            for w in 0..W {
                block[row][w] = (-factors[row]).mul_add(value[w], block[row][w]);
            }
        }
        rows.copy_from_slice(&block);
    }
    for (coefficient, row) in rest.iter().zip(rows.into_remainder()) {
        for w in 0..W {
            row[w] = (-coefficient).mul_add(value[w], row[w]);
        }
    }
}

/// Sums of columns, weighted by the numbers of each of four other rows.
///
/// A column holds the numbers of a block's rows: all products fill a vector register, and no sum
/// has to be taken across one.
///
/// - `weights`: one of the other rows, at least as long as there are columns.
#[inline(always)]
fn sums_of_four<'a>(
    columns: &[[f64; BLOCK]],
    weights: impl Fn(usize) -> &'a [f64],
) -> [[f64; BLOCK]; BLOCK] {
    /// Sums of every other column, so that an addition need not wait for the last.
    const CHAINS: usize = 2;
    let (columns, _) = columns.as_chunks::<CHAINS>();
    let weights: [&[[f64; CHAINS]]; BLOCK] =
        std::array::from_fn(|at| &weights(at).as_chunks().0[..columns.len()]);
    let mut sums = [[[0.0; BLOCK]; BLOCK]; CHAINS];
    for (at, columns) in columns.iter().enumerate() {
        for chain in 0..CHAINS {
            for other in 0..BLOCK {
                let weight = weights[other][at][chain];
                for row in 0..BLOCK {
                    let sum = &mut sums[chain][other][row];
                    *sum = columns[chain][row].mul_add(weight, *sum);
                }
            }
        }
    }
    let [even, odd] = sums;
    std::array::from_fn(|other| std::array::from_fn(|row| even[other][row] + odd[other][row]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A random diagonally dominant matrix in the band, banded and dense.
    fn random(size: usize, half_bandwidth: usize) -> (BandMatrix, DMatrix<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64((size * 1000 + half_bandwidth) as u64);
        let mut band = BandMatrix::new(size, half_bandwidth);
        let mut dense = DMatrix::zeros(size, size);
        for row in 0..size {
            for column in row.saturating_sub(half_bandwidth)..row {
                let value = random.random_range(-1.0..1.0);
                band.add(row, column, value);
                dense[(row, column)] = value;
                dense[(column, row)] = value;
            }
            let diagonal = 2.0 * half_bandwidth as f64 + 1.0;
            band.add(row, row, diagonal);
            dense[(row, row)] = diagonal;
        }
        (band, dense)
    }

    #[test]
    fn solves_what_a_dense_factorisation_solves() {
        for (size, half_bandwidth) in [(1, 0), (3, 1), (4, 7), (9, 2), (23, 6), (50, 28), (61, 86)]
        {
            let (mut band, dense) = random(size, half_bandwidth);
            let mut rhs: Vec<[f64; 3]> =
                (0..size).map(|i| [i as f64, 1.0, (i as f64).sin()]).collect();
            let columns = DMatrix::from_fn(size, 3, |i, j| rhs[i][j]);
            let expected = dense.cholesky().unwrap().solve(&columns);
            band.factor().unwrap();
            band.solve(&mut rhs);
            for (i, row) in rhs.iter().enumerate() {
                for j in 0..3 {
                    assert!((row[j] - expected[(i, j)]).abs() < 1e-11, "{size} {half_bandwidth}");
                }
            }
        }
    }

    #[test]
    fn an_undetermined_unknown_is_named() {
        // A path graph's Laplacian without an anchor: rows sum to zero.
        let mut band = BandMatrix::new(7, 1);
        for row in 0..7 {
            band.add(row, row, if row == 0 || row == 6 { 1.0 } else { 2.0 });
            if row > 0 {
                band.add(row, row - 1, -1.0);
            }
        }
        assert_eq!(band.factor(), Err(NotPositiveDefinite { row: 6 }));
        band.clear();
        band.add(0, 0, f64::NAN);
        assert_eq!(band.factor(), Err(NotPositiveDefinite { row: 0 }));
    }
}
