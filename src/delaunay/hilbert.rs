//! The Hilbert curve, along which neighbours in space follow each other.

/// Bits per axis for a place along the curve that fits into 32.
pub(super) const fn bits(axes: usize) -> u32 {
    32 / axes as u32
}

/// The place of a grid cell along the Hilbert curve (Skilling 2004, transposed form).
pub(super) fn hilbert<const D: usize>(mut axes: [u32; D]) -> u32 {
    let bits = bits(D);
    let mut bit = 1 << (bits - 1);
    while bit > 1 {
        let mask = bit - 1;
        for i in 0..D {
            if axes[i] & bit != 0 {
                axes[0] ^= mask;
            } else {
                let swap = (axes[0] ^ axes[i]) & mask;
                axes[0] ^= swap;
                axes[i] ^= swap;
            }
        }
        bit >>= 1;
    }
    for i in 1..D {
        axes[i] ^= axes[i - 1];
    }
    let mut flip = 0;
    let mut bit = 1 << (bits - 1);
    while bit > 1 {
        if axes[D - 1] & bit != 0 {
            flip ^= bit - 1;
        }
        bit >>= 1;
    }
    axes.iter_mut().for_each(|axis| *axis ^= flip);
    (0..bits)
        .rev()
        .fold(0, |key, bit| axes.iter().fold(key, |key, axis| key << 1 | axis >> bit & 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first `side^D` cells of the curve fill a cube of as many cells a side in its corner.
    fn check<const D: usize>(side: u32) {
        let count = side.pow(D as u32);
        let mut cells = vec![None; count as usize];
        for index in 0..count {
            let mut cell = [0; D];
            cell.iter_mut().fold(index, |rest, axis| {
                *axis = rest % side;
                rest / side
            });
            cells[hilbert(cell) as usize] = Some(cell);
        }
        for pair in cells.windows(2) {
            let (a, b) = (pair[0].unwrap(), pair[1].unwrap());
            assert_eq!((0..D).map(|i| a[i].abs_diff(b[i])).sum::<u32>(), 1);
        }
    }

    #[test]
    fn the_curve_visits_every_cell_by_steps_of_one() {
        check::<3>(8);
        check::<4>(4);
        check::<4>(8);
    }
}
