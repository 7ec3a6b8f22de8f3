//! A simple arm: joints that follow their targets late and not too fast.
//!
//! Each joint goes the part `1 − exp(−Δt/T)` of its way to its target (first-order lag `T`), the
//! whole body slowed together where a joint would be too fast; then every bone gets its length
//! again. No masses, no forces: what a position-controlled arm does of what it is told.

use std::sync::Arc;

use handover_mesh::retarget::project_bones;
use handover_mesh::{Point, Skeleton};

/// The robot as it is.
#[derive(Debug, Clone)]
pub struct Plant {
    skeleton: Arc<Skeleton>,
    lengths: Vec<f64>,
    joints: Vec<Point>,
    lag: f64,
    speed: f64,
}

impl Plant {
    /// A robot at rest.
    ///
    /// - `joints`: `[m]` in the world, in the skeleton's order.
    /// - `lag`: `[s]`, ≥ 0.
    /// - `speed`: of any joint at most `[m/s]`, > 0.
    ///
    /// # Panics
    /// If there is not one place for each joint: the caller's bug.
    pub fn new(skeleton: Arc<Skeleton>, joints: Vec<Point>, lag: f64, speed: f64) -> Self {
        assert_eq!(joints.len(), skeleton.len(), "one place for each joint");
        let place = |joint: handover_mesh::JointId| joints[joint.index()];
        let lengths = skeleton.bones().map(|bone| (place(bone.child) - place(bone.parent)).norm());
        Self { lengths: lengths.collect(), skeleton, joints, lag, speed }
    }

    /// Where the joints are: `[m]` in the world.
    pub fn joints(&self) -> &[Point] {
        &self.joints
    }

    /// The bones' lengths `[m]`, in the skeleton's order.
    pub fn bone_lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// Goes on for `seconds` towards a target: `[m]` in the world. Without one it stands.
    pub fn follow(&mut self, target: Option<&[Point]>, seconds: f64) {
        let Some(target) = target else { return };
        let part = if self.lag > 0.0 { 1.0 - (-seconds / self.lag).exp() } else { 1.0 };
        let ways = self.joints.iter().zip(target).map(|(joint, goal)| (goal - joint).norm());
        let longest = part * ways.fold(0.0, f64::max);
        let most = self.speed * seconds;
        let part = if longest > most { part * most / longest } else { part };
        for (joint, goal) in self.joints.iter_mut().zip(target) {
            *joint += (goal - *joint) * part;
        }
        project_bones(&self.skeleton, &self.lengths, &mut self.joints);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;
    use crate::scene::{Scene, SceneConfig};
    use handover_mesh::{Role, Side, Vector};

    fn person(seconds: f64) -> Vec<Point> {
        Scene::new(SceneConfig::default()).unwrap().pose(Role::First, seconds).positions.to_vec()
    }

    #[test]
    fn joints_come_as_near_as_their_lag_says() {
        let [rest, reached] = [0.0, 2.0].map(person);
        let mut plant = Plant::new(Skeleton::nite(), rest.clone(), 0.1, 100.0);
        let hand = Skeleton::nite().arm(Side::Right).unwrap()[2].index();
        for _ in 0..10 {
            plant.follow(Some(&reached), 0.01);
        }
        let left = (plant.joints()[hand] - reached[hand]).norm();
        let whole = (rest[hand] - reached[hand]).norm();
        // Bones are kept on the way, which costs a little.
        assert!((left / whole - (-1.0_f64).exp()).abs() < 0.05, "{}", left / whole);
        let body = Body::of_stature(1.75);
        let elbow = plant.joints()[hand - 1];
        assert!(((plant.joints()[hand] - elbow).norm() - body.forearm()).abs() < 1e-9);
    }

    #[test]
    fn no_joint_is_faster_than_it_can() {
        let [rest, reached] = [0.0, 2.0].map(person);
        let mut plant = Plant::new(Skeleton::nite(), rest.clone(), 0.0, 0.5);
        for _ in 0..20 {
            let before = plant.joints().to_vec();
            plant.follow(Some(&reached), 0.02);
            let moved = plant.joints().iter().zip(&before).map(|(a, b)| (a - b).norm());
            let fastest = moved.fold(0.0, f64::max) / 0.02;
            assert!(fastest < 0.55, "{fastest}");
        }
        plant.follow(None, 1.0);
        let there = plant.joints().to_vec();
        plant.follow(Some(&there), 0.1);
        let off = plant.joints().iter().zip(&there).map(|(a, b): (&Point, &Point)| a - b);
        assert!(off.map(|v: Vector| v.norm()).fold(0.0, f64::max) < 1e-9);
    }
}
