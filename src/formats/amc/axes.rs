//! Axes by their letters, and turns about them one after the other.

use nalgebra::{UnitQuaternion, UnitVector3};

use crate::geometry::Vector;

/// An axis of a right-handed frame.
///
/// ```
/// use handover_mesh::{Vector, formats::amc::Axis};
/// assert_eq!(Vector::new(1.0, 2.0, 3.0)[Axis::Y.index()], 2.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

impl Axis {
    /// The axis's place in `(x, y, z)`.
    pub fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }

    /// `x`, `y` or `z`.
    pub(super) fn letter(self) -> char {
        match self {
            Self::X => 'x',
            Self::Y => 'y',
            Self::Z => 'z',
        }
    }

    /// Of a letter of either case.
    pub(super) fn from_letter(letter: char) -> Option<Self> {
        match letter.to_ascii_lowercase() {
            'x' => Some(Self::X),
            'y' => Some(Self::Y),
            'z' => Some(Self::Z),
            _ => None,
        }
    }

    fn unit(self) -> UnitVector3<f64> {
        match self {
            Self::X => Vector::x_axis(),
            Self::Y => Vector::y_axis(),
            Self::Z => Vector::z_axis(),
        }
    }
}

/// All three axes, each once: which is turned about first, second and last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Order(pub(super) [Axis; 3]);

impl Order {
    /// Of three letters such as `XYZ`.
    pub(super) fn from_letters(letters: &str) -> Option<Self> {
        let mut axes = letters.chars().map(Axis::from_letter);
        let order = [axes.next()??, axes.next()??, axes.next()??];
        let [a, b, c] = order;
        (axes.next().is_none() && a != b && b != c && a != c).then_some(Self(order))
    }

    /// The turn by `angles` `[rad]` about x, y and z, taken in this order.
    pub(super) fn rotation(self, angles: &[f64; 3]) -> UnitQuaternion<f64> {
        rotation(self.0.into_iter().map(|axis| (axis, angles[axis.index()])))
    }
}

/// Turns `[rad]` about axes that stay where they are, the first first: for x, y, z it is
/// `R = R_z R_y R_x`.
pub(super) fn rotation(turns: impl Iterator<Item = (Axis, f64)>) -> UnitQuaternion<f64> {
    turns.fold(UnitQuaternion::identity(), |before, (axis, angle)| {
        UnitQuaternion::from_axis_angle(&axis.unit(), angle) * before
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[track_caller]
    fn check(letters: &str, expected: [f64; 3]) {
        // A quarter turn about x and one about y tell every order of the two apart.
        let order = Order::from_letters(letters).unwrap();
        let turned = order.rotation(&[FRAC_PI_2, FRAC_PI_2, 0.0]) * Vector::z();
        assert!((turned - Vector::from(expected)).norm() < 1e-15, "{letters}: {turned}");
    }

    #[test]
    fn the_first_letter_turns_first() {
        // About x first z becomes −y, which stays; about y first it becomes x, which stays.
        check("XYZ", [0.0, -1.0, 0.0]);
        check("zxy", [0.0, -1.0, 0.0]);
        check("YXZ", [1.0, 0.0, 0.0]);
        check("ZYX", [1.0, 0.0, 0.0]);
    }

    #[test]
    fn what_names_not_every_axis_once_is_no_order() {
        for letters in ["", "XY", "XXY", "XYX", "XYZX", "XYW", "X Z", "é"] {
            assert_eq!(Order::from_letters(letters), None, "{letters}");
        }
    }
}
