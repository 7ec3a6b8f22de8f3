//! A trace → figures.

use handover_mesh::demonstration::Hands;
use handover_mesh::geometry::yaw_isometry;
use handover_mesh::safety::HoldReason;
use handover_mesh::{JointId, Part, Point, Role, Skeleton, Vector};

use super::stage::{PARTNER, ROBOT};
use super::{Learnt, Stage, Step, Trace};
use crate::scenario::Figure;

/// Within this long of the scene's contact hands may meet `[s]`, as in the library's evaluation.
const CONTACT_WINDOW: f64 = 0.25;
/// A hand this near to where it belongs has come `[m]`.
const CAME: f64 = 0.1;
/// A reach is done when this part of it is.
const DONE: f64 = 0.9;
/// Below this speed of every joint a target stands `[m/s]`.
const STANDS: f64 = 0.01;
/// The end of a trial `[s]`.
const LAST: f64 = 0.5;

/// How far a hand is from where demonstrations had theirs `[m]`: `‖gap − ḡ‖`, the gap in the
/// partner's heading frame, as the library's evaluation has it.
///
/// - `partner`: `[m]` in the world, in the skeleton's order.
/// - `mean_gap`: ḡ `[m]`, in the partner's heading frame.
pub fn gap_error(
    skeleton: &Skeleton,
    partner: &[Point],
    partner_hand: JointId,
    robot_hand: Point,
    mean_gap: Vector,
) -> f64 {
    let heading_from_world = yaw_isometry(-skeleton.heading(partner), Vector::zeros());
    let gap = robot_hand - partner[partner_hand.index()];
    (heading_from_world * gap - mean_gap).norm()
}

/// Every figure of a trial, by its name.
pub(super) fn measure(
    stage: &Stage,
    trace: &Trace,
    learnt: &Learnt,
) -> impl Fn(Figure) -> Option<f64> {
    let measured = Measured { stage, trace, hand: stage.hand(ROBOT).index() };
    let side = |role: Role| stage.scene().config().person(role).hand;
    let hands = Hands { robot: side(ROBOT), partner: side(PARTNER) };
    let values = measured.all(learnt.mean_gap(hands), learnt.separation());
    move |figure| values[figure as usize]
}

struct Measured<'a> {
    stage: &'a Stage,
    trace: &'a Trace,
    /// The robot's active hand.
    hand: usize,
}

impl Measured<'_> {
    /// In [`Figure::ALL`]'s order.
    fn all(&self, mean_gap: Vector, separation: f64) -> [Option<f64>; Figure::ALL.len()] {
        let [gap, at_contact, timing, after] = self.meeting(mean_gap);
        let [speed, acceleration] = self.fastest_targets();
        let [separation, crept] = self.nearness(separation);
        let steps = &self.trace.steps;
        let is_held = |step: &&Step| step.reason.is_some() || step.target.is_none();
        let held = steps.iter().filter(is_held).count() as f64 / steps.len() as f64;
        [
            gap,
            at_contact,
            timing,
            after,
            self.lag(),
            Some(self.reach()),
            self.early(),
            Some(held),
            Some(self.held_apart()),
            speed,
            acceleration,
            self.bone(),
            Some(separation),
            Some(crept),
            self.disturbed(),
            self.stands_after(),
            steps.last().map(|step| self.distance_to_rest(step)),
            Some(self.end_speed()),
        ]
    }

    fn steps(&self) -> impl DoubleEndedIterator<Item = &Step> + Clone {
        self.trace.steps.iter()
    }

    fn reached(&self, step: &Step) -> f64 {
        (step.robot[self.hand] - self.stage.rest()[self.hand]).norm()
    }

    /// Gap, gap at contact, timing, first contact.
    fn meeting(&self, mean_gap: Vector) -> [Option<f64>; 4] {
        let Some(contact) = self.stage.contact() else { return [None; 4] };
        let hand = self.stage.hand(PARTNER);
        let since = |step: &Step| step.seconds - contact;
        let error = |step: &Step| {
            let partner = self.stage.partner(step.seconds).positions;
            gap_error(self.stage.skeleton(), &partner, hand, step.robot[self.hand], mean_gap)
        };
        let near = self.steps().filter(|step| since(step).abs() <= CONTACT_WINDOW);
        let best = near.min_by(|a, b| error(a).total_cmp(&error(b)));
        let at_contact = self.steps().min_by(|a, b| since(a).abs().total_cmp(&since(b).abs()));
        let mut from_there = self.steps().filter(|step| since(step) >= -CONTACT_WINDOW);
        [
            best.map(|step| 100.0 * error(step)),
            at_contact.map(|step| 100.0 * error(step)),
            best.map(|step| 1000.0 * since(step)),
            from_there.find(|step| error(step) <= CAME).map(since),
        ]
    }

    /// How far the hand gets before the human giver's does anything.
    fn early(&self) -> Option<f64> {
        let sets_out = self.stage.giver_sets_out()?;
        let before = self.steps().filter(|step| step.seconds <= sets_out);
        Some(largest(before.map(|step| self.reached(step))))
    }

    /// How long the partner's nearness held the robot `[s]`.
    fn held_apart(&self) -> f64 {
        let is_held = |step: &&Step| step.reason == Some(HoldReason::Separation);
        self.steps().filter(is_held).count() as f64 * self.trace.period
    }

    /// How much later than the giver the hand has done most of its way out: undefined if it never
    /// goes half as far.
    fn lag(&self) -> Option<f64> {
        let until = self.stage.contact()? + CONTACT_WINDOW;
        let there = self.steps().filter(|step| step.seconds <= until);
        let farthest = there.clone().map(|step| self.reached(step)).fold(0.0, f64::max);
        let whole = self.giver_reach();
        if farthest < 0.5 * whole {
            return None;
        }
        let robot = there.clone().find(|step| self.reached(step) >= DONE * farthest)?;
        let mut giver = there.filter(|step| self.giver_reached(step.seconds) >= DONE * whole);
        Some(1000.0 * (robot.seconds - giver.next()?.seconds))
    }

    fn giver_reached(&self, seconds: f64) -> f64 {
        let [there, start] = [seconds, 0.0].map(|s| self.stage.giver(s).positions[self.hand]);
        (there - start).norm()
    }

    /// How far the human giver reaches in the scene as planned `[m]`.
    fn giver_reach(&self) -> f64 {
        let scene = self.stage.scene();
        let [there, start] =
            [scene.moments().contact, 0.0].map(|s| scene.pose(ROBOT, s).positions[self.hand]);
        (there - start).norm()
    }

    /// How much nearer the hand gets to where the giver's is at the planned contact than it rests.
    fn reach(&self) -> f64 {
        let scene = self.stage.scene();
        let there = scene.pose(ROBOT, scene.moments().contact).positions[self.hand];
        let left = |hand: Point| (there - hand).norm();
        let nearest = self.steps().map(|step| left(step.robot[self.hand]));
        1.0 - nearest.fold(f64::INFINITY, f64::min) / left(self.stage.rest()[self.hand])
    }

    /// How far the hand is from where it was at the start or, if that is nearer, from where the
    /// giver's hand rests with nothing in it, at the planned end.
    fn distance_to_rest(&self, step: &Step) -> f64 {
        let scene = self.stage.scene();
        let done = scene.pose(ROBOT, scene.moments().end).positions[self.hand];
        f64::min(self.reached(step), (step.robot[self.hand] - done).norm())
    }

    /// Speed and acceleration of any joint's target, by differences of neighbouring ticks.
    fn fastest_targets(&self) -> [Option<f64>; 2] {
        let period = self.trace.period;
        let targets = || self.steps().map(|step| step.target.as_deref());
        let [first, second, third] = [0, 1, 2].map(|skipped| targets().skip(skipped));
        let speed = first.clone().zip(second.clone()).filter_map(|(a, b)| {
            Some(largest(a?.iter().zip(b?).map(|(a, b)| (b - a).norm())) / period)
        });
        let acceleration = first.zip(second).zip(third).filter_map(|((a, b), c)| {
            let three = a?.iter().zip(b?).zip(c?);
            let bends = three.map(|((a, b), c)| ((c - b) - (b - a)).norm());
            Some(largest(bends) / (period * period))
        });
        [speed.reduce(f64::max), acceleration.reduce(f64::max)]
    }

    /// The worst bone of any target `[mm]`.
    fn bone(&self) -> Option<f64> {
        let rest = self.stage.rest();
        let lengths = |joints: &[Point]| -> Vec<f64> {
            let bones = self.stage.skeleton().bones();
            let length = |a: JointId, b: JointId| (joints[a.index()] - joints[b.index()]).norm();
            bones.map(|bone| length(bone.parent, bone.child)).collect()
        };
        let own = lengths(rest);
        let worst = self.steps().filter_map(|step| {
            let found = lengths(step.target.as_deref()?);
            Some(largest(found.iter().zip(&own).map(|(found, own)| (found - own).abs())))
        });
        worst.reduce(f64::max).map(|worst| 1000.0 * worst)
    }

    /// How near either hand comes to the partner, and how much of that within `separation` is the
    /// robot's own doing.
    fn nearness(&self, separation: f64) -> [f64; 2] {
        let skeleton = self.stage.skeleton();
        let hands = [handover_mesh::Side::Left, handover_mesh::Side::Right]
            .map(|side| skeleton.part(Part::Hand(side)));
        let (mut least, mut crept) = (f64::INFINITY, 0.0);
        let mut before: Option<&Step> = None;
        for step in self.steps() {
            let partner = self.stage.partner(step.seconds).positions;
            for hand in hands.iter().flatten() {
                let distance = |step: &Step| from_body(&partner, step.robot[hand.index()]);
                let now = distance(step);
                least = f64::min(least, now);
                // Against where they were a tick ago with the partner as they are now.
                let nearer = before.map_or(0.0, |before| distance(before) - now);
                if now < separation {
                    crept += f64::max(0.0, nearer);
                }
            }
            before = Some(step);
        }
        [least, crept]
    }

    /// How far the hand gets while something is wrong, from where it was as that began.
    fn disturbed(&self) -> Option<f64> {
        let [start, end] = self.stage.disturbed()?;
        let mut during =
            self.steps().filter(|step| (start..=end).contains(&step.seconds)).map(|s| &s.robot);
        let first = during.next()?[self.hand];
        Some(during.map(|robot| (robot[self.hand] - first).norm()).fold(0.0, f64::max))
    }

    /// How long after the last message the target stands for good.
    fn stands_after(&self) -> Option<f64> {
        let last = self.stage.last_message()?;
        let pairs = self.trace.steps.windows(2).rev();
        let moves = |pair: &[Step]| match (&pair[0].target, &pair[1].target) {
            (Some(a), Some(b)) => {
                largest(a.iter().zip(b).map(|(a, b)| (b - a).norm())) > STANDS * self.trace.period
            }
            _ => false,
        };
        let moved = pairs.into_iter().find(|pair| moves(pair));
        Some(f64::max(0.0, moved.map_or(0.0, |pair| pair[1].seconds - last)))
    }

    /// The robot's hand at the end.
    fn end_speed(&self) -> f64 {
        let from = self.stage.end() - LAST;
        let ends = self.trace.steps.windows(2).filter(|pair| pair[0].seconds >= from);
        let hand = |step: &Step| step.robot[self.hand];
        largest(ends.map(|pair| (hand(&pair[1]) - hand(&pair[0])).norm())) / self.trace.period
    }
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// From a point to the lines head–neck–torso of a person `[m]`.
fn from_body(person: &[Point; 15], point: Point) -> f64 {
    let [head, neck, torso] = [person[0], person[1], person[2]];
    let from_line = |a: Point, b: Point| {
        let along = b - a;
        let part = (point - a).dot(&along) / along.norm_squared();
        (point - (a + along * part.clamp(0.0, 1.0))).norm()
    };
    f64::min(from_line(head, neck), from_line(neck, torso))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hand_is_as_far_from_a_person_as_from_the_nearest_of_their_lines() {
        let mut person = [Point::origin(); 15];
        (person[0], person[1]) = (Point::new(0.0, 0.0, 0.7), Point::new(0.0, 0.0, 0.5));
        let from = |x: f64, z: f64| from_body(&person, Point::new(x, 0.0, z));
        assert!((from(0.3, 0.2) - 0.3).abs() < 1e-12);
        assert!((from(0.0, 1.0) - 0.3).abs() < 1e-12);
        assert!((from(0.3, -0.4) - 0.5).abs() < 1e-12);
    }
}
