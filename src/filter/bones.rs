//! Places seen → which joints are off, by how long their bones usually are on this person.
//!
//! A bone's usual length is the median of its last [`KEPT`] sightings, so a wrong minority moves
//! it little, and whoever measures differently for longer than that is believed.

use super::body::Body;
use super::{FilterSettings, seconds_since};
use crate::geometry::Point;
use crate::time::Stamp;

/// How many lengths of each bone are kept.
const KEPT: usize = 31;
/// From how many lengths on a bone is judged.
const ENOUGH: usize = 8;
/// Lengths are this far apart in time `[s]` at least: fast sensors repeat their errors.
const APART: f64 = 0.03;
/// How far off any bone may be `[m]`, however short.
const SLACK: f64 = 0.05;

/// One bone, named by its child.
#[derive(Debug, Clone)]
struct Lengths {
    kept: [f64; KEPT],
    count: usize,
    next: usize,
    usual: f64,
}

impl Lengths {
    const NONE: Self = Self { kept: [0.0; KEPT], count: 0, next: 0, usual: 0.0 };

    fn learn(&mut self, length: f64) {
        self.kept[self.next] = length;
        self.next = (self.next + 1) % KEPT;
        self.count = (self.count + 1).min(KEPT);
        let mut sorted = self.kept;
        let sorted = &mut sorted[..self.count];
        sorted.sort_unstable_by(f64::total_cmp);
        self.usual = sorted[self.count / 2];
    }
}

/// What the person's bones measure.
#[derive(Debug, Clone)]
pub(super) struct Bones {
    /// By child; the root's stays empty.
    lengths: Box<[Lengths]>,
    learned: Option<Stamp>,
    /// Which joints are off, by the last look.
    off: Box<[bool]>,
}

impl Bones {
    pub(super) fn new(joints: usize) -> Self {
        Self {
            lengths: vec![Lengths::NONE; joints].into(),
            learned: None,
            off: vec![false; joints].into(),
        }
    }

    pub(super) fn forget(&mut self) {
        self.lengths.fill(Lengths::NONE);
        self.learned = None;
        self.off.fill(false);
    }

    /// Forgets the bones that end at a joint.
    pub(super) fn forget_joint(&mut self, body: &Body, joint: usize) {
        for (child, lengths) in self.lengths.iter_mut().enumerate() {
            if child == joint || body.joints[child].parent == Some(joint) {
                *lengths = Lengths::NONE;
            }
        }
    }

    pub(super) fn is_off(&self, joint: usize) -> bool {
        self.off[joint]
    }

    /// Looks at a sighting: marks the joints that are off, then learns from all of it.
    ///
    /// Of the joints at the ends of bones of a wrong length, that with most such bones is off,
    /// among equals that with the greater share of its bones, then the outer one; and so on
    /// without it. A leg is never a reason to doubt the trunk.
    pub(super) fn look(
        &mut self,
        body: &Body,
        seen: &[Option<Point>],
        stamp: Stamp,
        settings: &FilterSettings,
    ) {
        self.off.fill(false);
        // Each round marks one joint.
        for _ in 0..body.len() {
            let mut worst: Option<((usize, f64), usize)> = None;
            for &joint in &body.order {
                let [wrong, all] = self.wrong_bones(body, seen, joint, settings);
                let blame = (wrong, wrong as f64 / all.max(1) as f64);
                if wrong > 0 && worst.is_none_or(|(most, _)| blame >= most) {
                    worst = Some((blame, joint));
                }
            }
            let Some((_, joint)) = worst else { break };
            self.off[joint] = true;
        }
        if self.learned.is_some_and(|before| seconds_since(stamp, before) < APART) {
            return;
        }
        self.learned = Some(stamp);
        for (child, joint) in body.joints.iter().enumerate() {
            if let (Some(place), Some(parent)) = (seen[child], joint.parent.and_then(|p| seen[p])) {
                self.lengths[child].learn((place - parent).norm());
            }
        }
    }

    /// How many of a joint's bones have a wrong length, and how many can be told.
    fn wrong_bones(
        &self,
        body: &Body,
        seen: &[Option<Point>],
        joint: usize,
        settings: &FilterSettings,
    ) -> [usize; 2] {
        let mut counts = [0, 0];
        if self.off[joint] {
            return counts;
        }
        for (child, other) in body.joints.iter().enumerate() {
            let Some(parent) = other.parent else { continue };
            let is_end = child == joint || parent == joint;
            let blames_trunk = other.is_leg && !body.joints[joint].is_leg;
            let lengths = &self.lengths[child];
            if !is_end || blames_trunk || lengths.count < ENOUGH {
                continue;
            }
            let ends = (seen[child], seen[parent]);
            let (Some(place), Some(from)) = ends else { continue };
            if self.off[child] || self.off[parent] {
                continue;
            }
            let error = ((place - from).norm() - lengths.usual).abs();
            counts[0] += usize::from(error > settings.bone_share * lengths.usual + SLACK);
            counts[1] += 1;
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vector;
    use crate::skeleton::Skeleton;

    fn pose() -> Vec<Option<Point>> {
        let place = |j: i32| {
            let side = f64::from(j / 3 % 2) - 0.5;
            Some(Point::new(0.3 * side, 0.0, 2.0 - 0.3 * f64::from(j % 3)))
        };
        (0..15).map(place).collect()
    }

    /// Which joints are off when `moved` is 1.2 m from its place.
    #[track_caller]
    fn check(moved: usize, expected: &[usize]) {
        let skeleton = Skeleton::nite();
        let body = Body::new(&skeleton, skeleton.root());
        let (mut bones, settings) = (Bones::new(15), FilterSettings::default());
        for k in 0..10 {
            bones.look(&body, &pose(), Stamp(k * 40_000_000), &settings);
            assert!((0..15).all(|joint| !bones.is_off(joint)));
        }
        let mut seen = pose();
        seen[moved] = seen[moved].map(|place| place + Vector::new(0.0, 1.2, 0.0));
        bones.look(&body, &seen, Stamp(1_000_000_000), &settings);
        let off: Vec<usize> = (0..15).filter(|joint| bones.is_off(*joint)).collect();
        assert_eq!(off, expected, "joint {moved} moved");
    }

    #[test]
    fn the_joint_that_moved_is_the_one_that_is_off() {
        check(1, &[1]); // neck
        check(4, &[4]); // elbow
        check(8, &[8]); // hand
        check(9, &[9]); // hip
    }
}
