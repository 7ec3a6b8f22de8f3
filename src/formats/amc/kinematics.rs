//! Joint angles → where every bone ends, by forward kinematics.
//!
//! `M_i = M_parent · C_i R_i C_i⁻¹`, `p_i = p_parent + M_i d_i l_i`: `C_i` is the frame of the
//! bone's `axis` (for the order XYZ `C = R_z R_y R_x`), `R_i` the turns by its angles, the first
//! degree of freedom first, `d_i` and `l_i` its direction and length at rest. The root is a bone
//! without length: it turns in the frame of its `orientation`, about its own place, in the order
//! in which its values come.
//!
//! Worked out in the file's axes, y up; what comes out is z up, by `(x, y, z) → (x, −z, y)`.

use nalgebra::{Translation3, UnitQuaternion};

use super::axes;
use super::motion::Root;
use super::skeleton::Asf;
use crate::formats::UpAxis;
use crate::geometry::{Isometry, Point, Vector};

impl Asf {
    /// Where every bone ends `[m]`, z up, in the order of [`Asf::bones`].
    ///
    /// - `angles`: `[rad]`, one for each of [`Asf::channel_names`].
    ///
    /// # Panics
    /// If there are not as many angles as channels.
    pub fn positions(&self, root: &Root, angles: &[f64]) -> Vec<Point> {
        self.forward(&self.file_from_root(root), angles)
    }

    /// As [`Asf::positions`] with the root taken out: at the origin, not turned.
    ///
    /// # Panics
    /// If there are not as many angles as channels.
    pub fn positions_in_root(&self, angles: &[f64]) -> Vec<Point> {
        self.forward(&Isometry::identity(), angles)
    }

    /// Where the root is and how it is turned: takes a point of [`Asf::positions_in_root`] to
    /// that of [`Asf::positions`], `[m]`, z up.
    pub fn world_from_root(&self, root: &Root) -> Isometry {
        let up = UnitQuaternion::from_axis_angle(&Vector::x_axis(), std::f64::consts::FRAC_PI_2);
        up * self.file_from_root(root) * up.inverse()
    }

    /// The root's motion in the file's axes.
    fn file_from_root(&self, root: &Root) -> Isometry {
        let frame = self.root.frame;
        let turned = frame * self.root.turns.rotation(&root.rotation) * frame.inverse();
        Isometry::from_parts(Translation3::from(self.root.position + root.translation), turned)
    }

    fn forward(&self, root: &Isometry, angles: &[f64]) -> Vec<Point> {
        assert_eq!(angles.len(), self.channel_count(), "one angle for each channel");
        let mut ends = vec![*root; self.bones.len()];
        for &id in &self.outwards {
            let bone = &self[id];
            let start = bone.parent.map_or(root, |parent| &ends[parent.index()]);
            let turns = bone.dofs.iter().map(|dof| dof.axis).zip(&angles[bone.channels()]);
            let turned = axes::rotation(turns.map(|(axis, angle)| (axis, *angle)));
            let rotation = start.rotation * (bone.frame * turned * bone.frame.inverse());
            let end = start.translation.vector + rotation * (bone.direction * bone.length);
            ends[id.index()] = Isometry::from_parts(Translation3::from(end), rotation);
        }
        let point = |end: &Isometry| UpAxis::Y.to_z_up(Point::from(end.translation.vector));
        ends.iter().map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    /// An arm along x that turns in a frame of its own, and a hand behind it; decimetres.
    fn skeleton(axis: &str) -> Asf {
        let text = format!(
            ":units\nlength 0.254\nangle rad\n:root\norder TX TY TZ RZ RY RX\naxis XYZ\n\
             position 0 10 0\norientation 0 0 0\n:bonedata\n\
             begin\nname hand\ndirection 0 0 5\nlength 1\naxis 0 0 0 XYZ\nend\n\
             begin\nname arm\ndirection 3 0 0\nlength 2\naxis {axis}\ndof rx ry rz\nend\n\
             :hierarchy\nbegin\nroot arm\narm hand\nend\n",
        );
        Asf::read(text.as_bytes()).unwrap()
    }

    #[track_caller]
    fn check(axis: &str, angles: [f64; 3], arm: [f64; 3], hand: [f64; 3]) {
        let found = skeleton(axis).positions_in_root(&angles);
        for (found, expected) in found.iter().zip([hand, arm]) {
            assert!((found - Point::from(expected)).norm() < 1e-12, "{found}, not {expected:?}");
        }
    }

    #[test]
    fn angles_turn_a_bone_in_its_own_frame_and_all_behind_it() {
        const Q: f64 = FRAC_PI_2;
        // The file's z points to −y where z is up.
        check("0 0 0 XYZ", [0.0; 3], [0.2, 0.0, 0.0], [0.2, -0.1, 0.0]);
        // About the file's z the arm rises, and the hand, which points along z, keeps pointing.
        check("0 0 0 XYZ", [0.0, 0.0, Q], [0.0, 0.0, 0.2], [0.0, -0.1, 0.2]);
        // About x first: the hand turns to −y, then by the turn about z to x.
        check("0 0 0 XYZ", [Q, 0.0, Q], [0.0, 0.0, 0.2], [0.1, 0.0, 0.2]);
        // In a frame turned about z by a quarter, its x is the file's y.
        check("0 0 1.5707963267948966 XYZ", [Q, 0.0, 0.0], [0.0, 0.2, 0.0], [0.1, 0.2, 0.0]);
        // In a frame turned about x and then y, its z is the file's −y.
        let frame = "1.5707963267948966 1.5707963267948966 0 XYZ";
        check(frame, [0.0, 0.0, Q], [0.0, -0.2, 0.0], [-0.1, -0.2, 0.0]);
    }

    #[test]
    fn the_root_moves_and_turns_everything() {
        let skeleton = skeleton("0.3 0.2 -0.7 ZXY");
        // This file's root turns about z first: x comes to y (up), and stays there by the turn
        // about y.
        let root = Root {
            translation: Vector::new(1.0, 0.5, 0.25),
            rotation: [0.0, FRAC_PI_2, FRAC_PI_2],
        };
        let world_from_root = skeleton.world_from_root(&root);
        let up = world_from_root * Point::new(1.0, 0.0, 0.0);
        assert!((up - Point::new(1.0, -0.25, 2.5)).norm() < 1e-12, "{up}");
        let angles = [0.4, -0.9, 2.0];
        let in_root = skeleton.positions_in_root(&angles);
        for (in_world, in_root) in skeleton.positions(&root, &angles).iter().zip(&in_root) {
            assert!((in_world - world_from_root * in_root).norm() < 1e-12);
        }
        assert!(((in_root[0] - in_root[1]).norm() - 0.1).abs() < 1e-12);
    }
}
