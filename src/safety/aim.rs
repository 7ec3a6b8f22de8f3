//! Where a plan is to go: the proposal's poses, or a place on the way to one that is far.

use super::chain::Chain;
use super::partner::is_place;
use crate::geometry::{Point, Vector};
use crate::time::Span;

/// No bone is turned farther than this at once `[rad]`: 80°. What turns half round is aimed at by and
/// by, and a plan's directions never come near zero between their ends.
const WIDEST: f64 = 1.396;

/// Poses to follow, checked.
#[derive(Debug, Clone, Copy)]
pub(super) struct Poses<'a> {
    poses: &'a [Point],
    joints: usize,
    /// `[s]`
    step: f64,
}

impl<'a> Poses<'a> {
    /// None if they are no whole number of poses, not finite, or do not go on in time.
    pub(super) fn new(poses: &'a [Point], step: Span, joints: usize) -> Option<Self> {
        let whole = !poses.is_empty() && poses.len().is_multiple_of(joints);
        let sound = whole && step > Span(0) && poses.iter().all(is_place);
        sound.then_some(Self { poses, joints, step: step.seconds() })
    }

    fn last(&self) -> f64 {
        (self.poses.len() / self.joints - 1) as f64
    }

    /// Coordinates at `[s]` from now, between poses; the last one from its time on. A bone
    /// without length keeps the direction in `out`.
    pub(super) fn at(&self, chain: &Chain, time: f64, out: &mut [Vector]) {
        let place = (time / self.step).clamp(0.0, self.last());
        let (whole, part) = (place.floor(), place.fract());
        let first = whole as usize * self.joints;
        // At the last pose there is no next, and nothing is taken of it.
        let second = if part > 0.0 { first + self.joints } else { first };
        let joint = |joint: usize| {
            let (a, b) = (&self.poses[first + joint], &self.poses[second + joint]);
            a + (b - a) * part
        };
        chain.coordinates_of(joint, out);
    }

    /// Whether there are poses for so many steps before and after a time `[s]`.
    pub(super) fn reach_around(&self, time: f64, steps: f64) -> bool {
        let place = time / self.step;
        // Rounding must not lose the last pose.
        place >= steps && place + steps <= self.last() + 1e-6
    }
}

/// Aims at the pose at `[s]` from now, moving as the poses do there: by central differences, over
/// one step for velocity and, since noise counts more, two for acceleration. `false` where that is
/// too far for one plan.
///
/// - `state`: value and two derivatives of each coordinate now.
/// - `scratch`: coordinates, overwritten.
/// - `aims`: as `state`, overwritten.
pub(super) fn follow(
    poses: &Poses<'_>,
    chain: &Chain,
    time: f64,
    state: &[[Vector; 3]],
    scratch: &mut [Vec<Vector>; 3],
    aims: &mut [[Vector; 3]],
) -> bool {
    let [there, from, to] = scratch;
    for coordinates in [&mut *there, &mut *from, &mut *to] {
        coordinates.iter_mut().zip(state).for_each(|(own, now)| *own = now[0]);
    }
    let step = poses.step;
    poses.at(chain, time, there);
    let mut directions = there[1..].iter().zip(&state[1..]);
    if directions.any(|(there, now)| there.dot(&now[0]) < WIDEST.cos()) {
        return false;
    }
    for (aim, there) in aims.iter_mut().zip(&*there) {
        *aim = [*there, Vector::zeros(), Vector::zeros()];
    }
    if poses.reach_around(time, 1.0) {
        poses.at(chain, time - step, from);
        poses.at(chain, time + step, to);
        for ((aim, from), to) in aims.iter_mut().zip(&*from).zip(&*to) {
            aim[1] = (to - from) / (2.0 * step);
        }
    }
    if poses.reach_around(time, 2.0) {
        poses.at(chain, time - 2.0 * step, from);
        poses.at(chain, time + 2.0 * step, to);
        for ((aim, from), to) in aims.iter_mut().zip(&*from).zip(&*to) {
            aim[2] = (to - aim[0] * 2.0 + from) / (4.0 * step * step);
        }
    }
    for [place, velocity, acceleration] in &mut aims[1..] {
        // What keeps a unit vector one: it moves across itself, and is drawn inwards.
        *velocity -= *place * place.dot(velocity);
        *acceleration -= *place * (place.dot(acceleration) + velocity.norm_squared());
    }
    true
}

/// Aims at a place on the way to `goal`, to stand there: no joint's way is longer than `way` `[m]`,
/// and all coordinates go the same share of theirs.
///
/// - `ways`: scratch, one for each joint.
pub(super) fn towards(
    goal: &[Vector],
    chain: &Chain,
    way: f64,
    state: &[[Vector; 3]],
    ways: &mut [f64],
    aims: &mut [[Vector; 3]],
) {
    ways[chain.base()] = (goal[0] - state[0][0]).norm();
    let (mut longest, mut widest) = (ways[chain.base()], 0.0f64);
    for (at, link) in chain.links().iter().enumerate() {
        let angle = angle(&state[at + 1][0], &goal[at + 1]);
        ways[link.to] = ways[link.from] + link.length * angle;
        longest = longest.max(ways[link.to]);
        widest = widest.max(angle);
    }
    let share = (way / longest.max(1e-9)).min(WIDEST / widest.max(1e-9)).min(1.0);
    let rest = Vector::zeros();
    aims[0] = [state[0][0].lerp(&goal[0], share), rest, rest];
    for at in 1..aims.len() {
        aims[at] = [between(&state[at], &goal[at], share), rest, rest];
    }
}

fn angle(a: &Vector, b: &Vector) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// A direction on the great circle from where a bone points to `goal`, both of length 1.
fn between(state: &[Vector; 3], goal: &Vector, share: f64) -> Vector {
    let [from, velocity, _] = state;
    let angle = angle(from, goal);
    let sideways = |vector: &Vector| vector - from * from.dot(vector);
    let mut aside = sideways(goal);
    // Half round any way is as short as any other: the one it is turning already, if it is, or else
    // a fixed one.
    if angle > 3.0 && velocity.norm() > 1e-3 {
        aside = sideways(velocity);
    } else if angle > 3.0 && aside.norm() < 1e-6 {
        let flattest = from.iamin();
        aside = sideways(&Vector::ith(flattest, 1.0));
    }
    let length = aside.norm();
    if length < 1e-12 {
        return *from;
    }
    let turn = angle * share;
    (from * turn.cos() + aside * (turn.sin() / length)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_round_is_gone_in_steps() {
        let rest = Vector::zeros();
        for goal in [-Vector::x(), Vector::new(-1.0, 1e-9, 0.0).normalize(), Vector::y()] {
            let mut from = Vector::x();
            for _ in 0..100 {
                from = between(&[from, rest, rest], &goal, 0.1);
                assert!((from.norm() - 1.0).abs() < 1e-12);
            }
            assert!((from - goal).norm() < 1e-3, "{goal} {from}");
        }
    }

    #[test]
    fn poses_are_read_between_and_after_them() {
        let poses = [0.0, 1.0, 3.0].map(|x| Point::new(x, 0.0, 0.0));
        let skeleton = crate::skeleton::Skeleton::nite();
        let joints = skeleton.len();
        let all: Vec<Point> = poses.iter().flat_map(|p| vec![*p; joints]).collect();
        let chain = Chain::new(&skeleton, skeleton.root(), &[0.3; 14]).unwrap();
        let read = Poses::new(&all, Span(100_000_000), joints).unwrap();
        let mut out = vec![Vector::z(); joints];
        for (time, x) in [(-1.0, 0.0), (0.05, 0.5), (0.15, 2.0), (0.2, 3.0), (9.0, 3.0)] {
            read.at(&chain, time, &mut out);
            assert!((out[0].x - x).abs() < 1e-9, "{time}");
            assert_eq!(out[1], Vector::z(), "no direction: kept");
        }
        assert!(read.reach_around(0.1, 1.0));
        assert!(!read.reach_around(0.1, 2.0) && !read.reach_around(0.11, 1.0));
        assert!(Poses::new(&all[1..], Span(1), joints).is_none());
        assert!(Poses::new(&[], Span(1), joints).is_none());
        assert!(Poses::new(&all, Span(0), joints).is_none());
        let mut bad = all;
        bad[3].y = f64::NAN;
        assert!(Poses::new(&bad, Span(1), joints).is_none());
    }
}
