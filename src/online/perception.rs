//! The partner as known so far → where in the demonstrations, and where over the window.

use super::{OnlineModel, Scene, mean_pose};
use crate::forecast::{self, ForecastMethod, Moment};
use crate::geometry::{Point, Vector};
use crate::skeleton::{Frame, JointId, Riders};
use crate::time::{Span, Stamp};
use crate::track::{Belief, Followed, Tracker, Who};

/// More frames than this are not kept.
const RECENT: usize = 32;

/// What is made of the partner; all it needs it holds.
#[derive(Debug, Clone)]
pub struct Perception {
    /// The newest frames, the oldest first; those before `first` are room.
    recent: Vec<Frame>,
    first: usize,
    /// Frames are this far apart at least, but for the newest: so they last as long as velocities
    /// are taken over, however fast the sensor is.
    apart: Span,
    moment: Moment,
    tracker: Tracker,
    workspace: forecast::Workspace,
    /// From the places at the newest frame to those at the forecaster's horizons `[m]`, a zero
    /// horizon first.
    moves: Vec<Vector>,
    horizons: Vec<f64>,
    /// What is added to the places of joints that are not seen `[m]`.
    guesses: Vec<Vector>,
    pose: Vec<Point>,
    /// How what rides on the partner's joints sat on them in the newest frame.
    riders: Riders,
    scene: Scene,
}

impl Perception {
    /// Nobody has been seen.
    pub fn new(model: &OnlineModel) -> Self {
        let library = &model.library;
        let skeleton = library.skeleton(Who::Partner);
        let joints = skeleton.len();
        let horizons: Vec<f64> =
            [0.0].into_iter().chain(model.forecaster.horizons().iter().copied()).collect();
        let frames = model.settings.past + 1 + model.settings.future;
        let longest = model.forecaster.velocity_window().max(model.settings.track.velocity_window);
        let apart = Span((1e9 * longest) as i64 / (RECENT as i64 - 2));
        let blank = Frame { stamp: Stamp(0), positions: vec![Point::origin(); joints].into() };
        Self {
            recent: vec![blank; RECENT],
            first: RECENT,
            apart,
            moment: Moment::new(skeleton, library.base(Who::Partner)),
            tracker: Tracker::new(library),
            workspace: model.forecaster.workspace(),
            moves: vec![Vector::zeros(); horizons.len() * skeleton.own()],
            horizons,
            guesses: vec![Vector::zeros(); joints],
            pose: vec![Point::origin(); joints],
            riders: Riders::new(skeleton, &vec![Point::origin(); joints]),
            scene: Scene {
                partner: vec![Point::origin(); frames * joints],
                robot_base: Point::origin(),
            },
        }
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.first = RECENT;
        self.tracker.reset();
        self.moves.fill(Vector::zeros());
        self.guesses.fill(Vector::zeros());
    }

    /// Takes in the partner's joints at a stamp later than the last.
    ///
    /// - `positions`: `[m]` in the world.
    /// - `base`: where the robot's base is `[m]`.
    /// - `guessed`: how much of a joint's place is a guess, 0 to 1: as much is taken from the
    ///   demonstrations followed.
    pub fn see(
        &mut self,
        model: &OnlineModel,
        stamp: Stamp,
        positions: &[Point],
        base: Point,
        guessed: impl Fn(JointId) -> f64,
    ) {
        let elapsed = (stamp - self.recent[RECENT - 1].stamp).seconds();
        let [before, last] = [RECENT - 2, RECENT - 1].map(|at| self.recent[at].stamp);
        // In close succession the newest gives way.
        if self.first + 2 > RECENT || last - before >= self.apart {
            self.recent.rotate_left(1);
            self.first = self.first.saturating_sub(1);
        }
        let newest = &mut self.recent[RECENT - 1];
        newest.stamp = stamp;
        newest.positions.copy_from_slice(positions);
        self.riders.take(positions);
        let (library, belief) = (&model.library, self.tracker.belief());
        self.guesses.fill(Vector::zeros());
        let skeleton = library.skeleton(Who::Partner);
        let any = skeleton.joints().take(skeleton.own()).any(|joint| guessed(joint) > 0.0);
        if any && !belief.followed.is_empty() {
            let ahead = elapsed / library.step().seconds() * belief.tempo;
            let place = positions[library.base(Who::Partner).index()];
            mean_pose(library, &belief.followed, Who::Partner, ahead, place, &mut self.pose);
            let joints = skeleton.joints().take(skeleton.own());
            for joint in joints.filter(|joint| *joint != library.base(Who::Partner)) {
                let at = joint.index();
                self.guesses[at] = guessed(joint) * (self.pose[at] - positions[at]);
                newest.positions[at] += self.guesses[at];
            }
        }
        let past = &self.recent[self.first..];
        self.moment.observe(skeleton, past, model.settings.track.velocity_window);
        self.tracker.observe(&model.library, &self.moment, base, stamp);
        self.moment.observe(skeleton, past, model.forecaster.velocity_window());
        let method = ForecastMethod::Mixed;
        let forecast = model.forecaster.forecast(method, &self.moment, &mut self.workspace);
        let joints = skeleton.own();
        let places = self.moment.positions().iter().cycle();
        for ((moved, to), from) in self.moves[joints..].iter_mut().zip(forecast).zip(places) {
            *moved = to - from;
        }
    }

    /// What is believed.
    pub fn belief(&self) -> &Belief {
        self.tracker.belief()
    }

    /// The window as last laid out.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Where the interaction is in every demonstration.
    pub fn everywhere(&self) -> impl ExactSizeIterator<Item = Followed> + '_ {
        self.tracker.everywhere()
    }

    /// Lays out the window as of `now`.
    ///
    /// - `at`: the partner's joints at an instant up to now `[m]`.
    pub fn look(
        &mut self,
        model: &OnlineModel,
        now: Stamp,
        robot_base: Point,
        at: impl Fn(Stamp, &mut [Point]),
    ) -> &Scene {
        let skeleton = model.library.skeleton(Who::Partner);
        let (joints, own) = (skeleton.len(), skeleton.own());
        let (past, step) = (model.settings.past, model.library.step());
        let newest = self.recent[RECENT - 1].stamp;
        // Taken out while the rest is looked at; put back below.
        let mut partner = std::mem::take(&mut self.scene.partner);
        for frame in 0..=past {
            let stamp = now + Span((frame as i64 - past as i64) * step.0);
            let places = &mut partner[frame * joints..][..joints];
            at(stamp, places);
            places.iter_mut().zip(&self.guesses).for_each(|(place, guess)| *place += guess);
            self.riders.place(places);
        }
        let (known, future) = partner.split_at_mut((past + 1) * joints);
        let here = &known[past * joints..];
        let late = (now - newest).seconds();
        for (ahead, frame) in future.chunks_exact_mut(joints).enumerate() {
            let lead = (ahead + 1) as f64 * step.seconds();
            let share = (-lead / model.settings.trust).exp();
            let (from, to) = (self.place(late), self.place(late + lead));
            for (joint, place) in frame[..own].iter_mut().enumerate() {
                let forecast = self.moved(to, joint, own) - self.moved(from, joint, own);
                *place = here[joint] + share * forecast;
            }
            self.add_demonstrated(model, ahead + 1, 1.0 - share, &mut frame[..own]);
            self.riders.place(frame);
        }
        self.scene.partner = partner;
        self.scene.robot_base = robot_base;
        &self.scene
    }

    /// Moves the partner on as the demonstrations do, by a share of it.
    fn add_demonstrated(&self, model: &OnlineModel, ahead: usize, share: f64, frame: &mut [Point]) {
        let belief = self.tracker.belief();
        let ahead = ahead as f64 * belief.tempo;
        let library = &model.library;
        for followed in &belief.followed {
            let pose = |frame| library.pose(followed.exemplar, Who::Partner, frame);
            let [now, then] = [followed.frame, followed.frame + ahead].map(pose);
            for (joint, place) in library.skeleton(Who::Partner).joints().zip(&mut *frame) {
                let moved = then.position(joint) - now.position(joint);
                *place += share * followed.weight * followed.turned(moved);
            }
        }
    }

    /// `(horizon before, part of the way to the next)` of a lead time `[s]`.
    fn place(&self, lead: f64) -> (usize, f64) {
        let last = self.horizons.len() - 1;
        let after = self.horizons.partition_point(|horizon| *horizon <= lead).clamp(1, last);
        let (from, to) = (self.horizons[after - 1], self.horizons[after]);
        (after - 1, ((lead - from) / (to - from)).clamp(0.0, 1.0))
    }

    /// How far a joint will have moved at such a lead time `[m]`.
    fn moved(&self, (horizon, part): (usize, f64), joint: usize, joints: usize) -> Vector {
        let [before, after] = [horizon, horizon + 1].map(|h| self.moves[h * joints + joint]);
        before + (after - before) * part
    }
}
