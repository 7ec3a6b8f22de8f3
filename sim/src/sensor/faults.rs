//! Runs of frames in which the tracker is wrong: joints held, left and right mistaken.

use handover_mesh::{JointId, Part, Point, Skeleton};
use rand::Rng;
use rand_distr::{Distribution, Exp1};

use super::SensorConfig;

/// Something that starts at random and lasts a while.
#[derive(Clone, Copy, Default)]
pub(super) struct Run {
    /// Time left, `[s]`.
    left: f64,
}

impl Run {
    /// Whether it goes on after `elapsed` `[s]`, or starts anew.
    ///
    /// - `rate`: starts a second, while it is not on.
    /// - `duration`: how long on average, `[s]`.
    pub(super) fn next(
        &mut self,
        elapsed: f64,
        rate: f64,
        duration: f64,
        random: &mut impl Rng,
    ) -> RunState {
        // Drawn whether needed or not: one fault more must not change all later noise.
        let (chance, length): (f64, f64) = (random.random(), Exp1.sample(random));
        self.left -= elapsed;
        if self.left > 0.0 {
            return RunState::On;
        }
        if chance >= 1.0 - (-rate * elapsed).exp() {
            return RunState::Off;
        }
        self.left = duration * length;
        RunState::Started
    }
}

/// What a [`Run`] does in a frame.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum RunState {
    Off,
    Started,
    On,
}

/// The faults of one person's tracking, from frame to frame.
pub(super) struct Faults {
    swap: Run,
    whole_body: bool,
    holds: Vec<Run>,
    last: Option<Vec<Point>>,
}

/// What was wrong in one frame of one person.
#[derive(Default)]
pub(super) struct FaultsInFrame {
    pub(super) swapped: bool,
    pub(super) held_joints: usize,
}

impl Faults {
    pub(super) fn of(joints: usize) -> Self {
        Self {
            swap: Run::default(),
            whole_body: false,
            holds: vec![Run::default(); joints],
            last: None,
        }
    }

    /// Spoils one frame's `points`, `elapsed` `[s]` after the frame before.
    pub(super) fn apply(
        &mut self,
        config: &SensorConfig,
        skeleton: &Skeleton,
        elapsed: f64,
        points: &mut [Point],
        random: &mut impl Rng,
    ) -> FaultsInFrame {
        let whole_body = random.random::<f64>() < config.whole_body_swaps;
        let swap = self.swap.next(elapsed, config.swap_rate, config.swap_duration, random);
        if swap == RunState::Started {
            self.whole_body = whole_body;
        }
        let mut faults = FaultsInFrame { swapped: swap != RunState::Off, held_joints: 0 };
        if faults.swapped {
            swap_sides(skeleton, self.whole_body, points);
        }
        for (at, hold) in self.holds.iter_mut().enumerate() {
            let state = hold.next(elapsed, config.hold_rate, config.hold_duration, random);
            // A joint that has never been seen has nothing to hold on to.
            if let (true, Some(last)) = (state != RunState::Off, &self.last) {
                points[at] = last[at];
                faults.held_joints += 1;
            }
        }
        self.last = Some(points.to_vec());
        faults
    }
}

/// Exchanges left and right: the arms, or every joint that has another side.
pub(super) fn swap_sides(skeleton: &Skeleton, whole_body: bool, points: &mut [Point]) {
    let of_arm = |joint: JointId| {
        matches!(
            skeleton.part_of(joint),
            Some(Part::Shoulder(_) | Part::Elbow(_) | Part::Hand(_) | Part::Clavicle(_))
        )
    };
    for joint in skeleton.joints().filter(|joint| whole_body || of_arm(*joint)) {
        let other = skeleton.mirrored_joint(joint);
        // Each pair once.
        if joint < other {
            points.swap(joint.index(), other.index());
        }
    }
}
