//! Whether targets keep their promises, by other means than the gate's own.

use handover_mesh::safety::{PartnerBody, SafetySettings, Target};
use handover_mesh::{Point, Skeleton, Span, Stamp, Vector};

/// Places are compared to this `[m]`.
pub(crate) const ROUNDING: f64 = 1e-9;

/// Stamps farther apart say that the clock was set.
const LONGEST_STEP: Span = Span(60_000_000_000);

/// What held when a plan was made.
struct Planned {
    /// By the time that passed.
    stamp: Stamp,
    /// How long until it stands.
    stands_in: Span,
    robot: Vec<Point>,
    partner: PartnerBody,
}

/// Watches the targets of one gate since its start.
pub(crate) struct Watch {
    skeleton: std::sync::Arc<Skeleton>,
    lengths: Vec<f64>,
    settings: SafetySettings,
    /// The last target.
    last: Option<Target>,
    /// What is to be taken as passed where the clock was set.
    period: Span,
    /// By the time that passed since the start; newest last, at distinct times.
    past: Vec<(Stamp, Vec<Point>)>,
    /// Where the joints and the partner were when the plan followed now was made.
    planned: Option<Planned>,
    /// The largest share of each limit that was used.
    pub(crate) used: [f64; 3],
    /// How many plans were made.
    pub(crate) plans: usize,
    /// How many of them were stops that came too near all the same.
    pub(crate) near: usize,
}

impl Watch {
    pub(crate) fn new(
        skeleton: std::sync::Arc<Skeleton>,
        lengths: Vec<f64>,
        settings: SafetySettings,
    ) -> Self {
        let (past, planned) = (Vec::new(), None);
        Self {
            skeleton,
            lengths,
            settings,
            last: None,
            period: Span(0),
            past,
            planned,
            used: [0.0; 3],
            plans: 0,
            near: 0,
        }
    }

    /// The partner that the plan followed now was made with.
    pub(crate) fn planned_with(&self) -> PartnerBody {
        self.planned.as_ref().map(|planned| planned.partner).unwrap_or_default()
    }

    /// The time of a target by what passed since the start, and whether the clock was set.
    fn time(&mut self, stamp: Stamp) -> (Stamp, bool) {
        let now = self.past.last().map_or(Stamp(0), |(time, _)| *time);
        let Some(last) = &self.last else { return (now, false) };
        let step = stamp - last.stamp();
        if step == Span(0) || (step > Span(0) && step <= LONGEST_STEP) {
            if step > Span(0) {
                self.period = step.min(Span::from_seconds(self.settings.lead).unwrap());
            }
            return (now + step, false);
        }
        (now + self.period, true)
    }

    /// Checks a target that came for `now` with `partner` given.
    ///
    /// - `ahead`: some way into the published plan.
    #[track_caller]
    pub(crate) fn check(&mut self, target: &Target, partner: &PartnerBody, ahead: Span) {
        let positions = target.positions();
        assert!(positions.iter().all(|p| p.coords.iter().all(|c| c.is_finite())));
        self.check_bones(positions);
        let (now, clock_set) = self.time(target.stamp());
        assert!(!clock_set || target.reason().is_some(), "went on by a clock that was set");
        let fresh = self.past.last().is_none_or(|(time, _)| *time < now);
        if fresh {
            self.past.push((now, positions.to_vec()));
            if self.past.len() > 4 {
                self.past.remove(0);
            }
            let used = self.check_derivatives(&self.past);
            (0..3).for_each(|i| self.used[i] = self.used[i].max(used[i]));
        } else {
            let off =
                self.past.last().unwrap().1.iter().zip(positions).map(|(a, b)| (a - b).norm());
            let rounding =
                if clock_set { 1e-12 * positions[0].coords.amax().max(1.0) } else { 0.0 };
            assert!(off.fold(0.0, f64::max) <= rounding, "time stands: so does the target");
            self.past.last_mut().unwrap().1 = positions.to_vec();
        }
        let seen = [partner.head, partner.neck, partner.torso];
        let known = seen.iter().flatten().all(|p| p.coords.iter().all(|c| c.abs() <= 1e4));
        if fresh && target.followed_for() == Span(0) {
            self.plans += 1;
            // A partner at no place is taken to be where they were.
            let partner = if known { *partner } else { self.planned_with() };
            if !target.keeps_separation() {
                self.check_stop(target, &partner, now);
                self.near += 1;
            }
            self.planned = Some(Planned {
                stamp: now,
                stands_in: target.stands_in(),
                robot: positions.to_vec(),
                partner,
            });
        }
        self.check_places(target, now, positions);
        let mut later = positions.to_vec();
        target.positions_at(ahead, &mut later);
        self.check_bones(&later);
        self.check_places(target, now + ahead, &later);
        self.check_plan(target, ahead);
        self.last = Some(target.clone());
    }

    /// A stop that comes too near is compared to what was left of the plan it replaced.
    #[track_caller]
    fn check_stop(&self, target: &Target, partner: &PartnerBody, now: Stamp) {
        let last = self.last.as_ref().expect("the first plan is a standstill");
        let passed = now - self.past[self.past.len().saturating_sub(2)].0;
        let nearest = |plan: &Target, from: Span, left: f64| {
            let mut pose = plan.positions().to_vec();
            let moments = (0..Target::MOMENTS).map(|k| {
                let part = f64::from(k) / f64::from(Target::MOMENTS - 1);
                plan.positions_at(Span(from.0 + (left * part * 1e9) as i64), &mut pose);
                least_distance(&self.skeleton, &pose, partner)
            });
            moments.fold(f64::INFINITY, f64::min)
        };
        let stop = nearest(target, Span(0), target.stands_in().seconds());
        let left = (last.stands_in().seconds() - passed.seconds()).max(0.0);
        let replaced = nearest(last, passed, left);
        // Moments are rounded to nanoseconds.
        assert!(stop >= replaced - 1e-7, "{stop} m from the partner, {replaced} m before");
    }

    /// Some moments close to each other, where no tick may ever come.
    #[track_caller]
    fn check_plan(&self, target: &Target, ahead: Span) {
        const CLOSE: i64 = 400_000;
        let nodes: Vec<(Stamp, Vec<Point>)> = (0..4)
            .map(|k| {
                let (mut pose, ahead) = (target.positions().to_vec(), ahead.0 + k * CLOSE);
                target.positions_at(Span(ahead), &mut pose);
                (Stamp(ahead), pose)
            })
            .collect();
        for count in 2..=4 {
            self.check_derivatives(&nodes[..count]);
        }
        // What is said of velocities is what places do, to the square of the time between them.
        let mut said = target.velocities().to_vec();
        target.velocities_at(Span(nodes[1].0.0), &mut said);
        for (at, said) in said.iter().enumerate() {
            let done = (nodes[2].1[at] - nodes[0].1[at]) / (2e-9 * CLOSE as f64);
            assert!((said - done).norm() < 1e-3, "{said} m/s said, {done} m/s done");
        }
    }

    #[track_caller]
    fn check_bones(&self, positions: &[Point]) {
        for (bone, length) in self.skeleton.bones().zip(&self.lengths) {
            let along = positions[bone.child.index()] - positions[bone.parent.index()];
            let far = positions[0].coords.amax().max(1.0);
            assert!((along.norm() - length).abs() < 1e-12 * far + 1e-12);
        }
    }

    /// Divided differences: `k! f[t₀, …, tₖ]` is a mean of the k-th derivative, so no longer than
    /// the longest there is.
    ///
    /// Returns the share of each limit that is used by the newest of `past`.
    #[track_caller]
    fn check_derivatives(&self, past: &[(Stamp, Vec<Point>)]) -> [f64; 3] {
        let mut used = [0.0f64; 3];
        let limits = [self.settings.speed, self.settings.acceleration, self.settings.jerk];
        let mut factorial = 1.0;
        for order in 1..past.len().min(4) {
            factorial *= order as f64;
            let nodes = &past[past.len() - 1 - order..];
            for joint in 0..self.skeleton.len() {
                let (mut sum, mut rounding) = (Vector::zeros(), 0.0);
                for (i, (stamp, place)) in nodes.iter().enumerate() {
                    let others = nodes.iter().enumerate().filter(|(j, _)| *j != i);
                    let product: f64 =
                        others.map(|(_, (other, _))| (*stamp - *other).seconds()).product();
                    // Relative to one of them, so that large coordinates cancel exactly.
                    sum += (place[joint] - nodes[0].1[joint]) / product;
                    let far = place[joint].coords.amax().max(1.0);
                    rounding += 2e-15 * far / product.abs();
                }
                let (size, limit) = (factorial * sum.norm(), limits[order - 1]);
                let rounding = factorial * rounding;
                assert!(
                    size <= limit * (1.0 + 1e-9) + rounding,
                    "derivative {order} of joint {joint}: {size} > {limit} + {rounding}"
                );
                if rounding < 1e-3 * limit {
                    used[order - 1] = used[order - 1].max(size / limit);
                }
            }
        }
        used
    }

    /// Workspace and separation: no worse than when it was planned, with the partner as then.
    #[track_caller]
    fn check_places(&self, target: &Target, stamp: Stamp, positions: &[Point]) {
        let Some(planned) = &self.planned else { return };
        let then = &planned.robot;
        if let Some([low, high]) = self.settings.workspace {
            for (place, before) in positions.iter().zip(then) {
                for axis in 0..3 {
                    let least = low[axis].min(before[axis]) - ROUNDING;
                    let most = high[axis].max(before[axis]) + ROUNDING;
                    assert!((least..=most).contains(&place[axis]), "{place} outside");
                }
            }
        }
        if !target.keeps_separation() {
            return;
        }
        // A partner may be taken to come nearer for as long as the robot moves.
        let time = (stamp - planned.stamp).min(planned.stands_in).seconds();
        let bound = self.settings.separation + self.settings.partner_speed * time;
        for bone in self.skeleton.bones() {
            let ends = |pose: &[Point]| [pose[bone.parent.index()], pose[bone.child.index()]];
            for part in parts(&planned.partner) {
                if surely_farther(ends(positions), part, bound) {
                    continue;
                }
                let (now, before) = (distance(ends(positions), part), distance(ends(then), part));
                assert!(
                    now >= bound.min(before) - ROUNDING,
                    "{now} m from the partner, {before} m when planned {time} s before"
                );
            }
        }
    }
}

pub(crate) fn parts(partner: &PartnerBody) -> Vec<[Point; 2]> {
    let known: Vec<Point> =
        [partner.head, partner.neck, partner.torso].into_iter().flatten().collect();
    match known[..] {
        [] => vec![],
        [only] => vec![[only, only]],
        _ => known.windows(2).map(|pair| [pair[0], pair[1]]).collect(),
    }
}

fn surely_farther(a: [Point; 2], b: [Point; 2], bound: f64) -> bool {
    let reach = ((a[1] - a[0]).norm() + (b[1] - b[0]).norm()) / 2.0;
    let middle = |s: [Point; 2]| nalgebra::center(&s[0], &s[1]);
    (middle(a) - middle(b)).norm() - reach > bound + 1e-6
}

/// The distance of two segments, by narrowing down a convex function.
pub(crate) fn distance(a: [Point; 2], b: [Point; 2]) -> f64 {
    let to_b = |s: f64| {
        let p = a[0] + (a[1] - a[0]) * s;
        let along = b[1] - b[0];
        let t = (along.dot(&(p - b[0])) / along.norm_squared().max(1e-30)).clamp(0.0, 1.0);
        (p - (b[0] + along * t)).norm()
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..90 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if to_b(left) < to_b(right) { high = right } else { low = left }
    }
    to_b((low + high) / 2.0).min(to_b(0.0)).min(to_b(1.0))
}

/// The least distance of any bone to any part.
pub(crate) fn least_distance(skeleton: &Skeleton, pose: &[Point], partner: &PartnerBody) -> f64 {
    let pairs = skeleton.bones().flat_map(|bone| {
        let bone = [pose[bone.parent.index()], pose[bone.child.index()]];
        parts(partner).into_iter().map(move |part| distance(bone, part))
    });
    pairs.fold(f64::INFINITY, f64::min)
}
