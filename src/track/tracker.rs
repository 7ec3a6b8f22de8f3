//! The filter over (demonstration, frame).

use super::library::{Who, squared_distance};
use super::{Belief, Followed, Library};
use crate::demonstration::Hands;
use crate::forecast::Moment;
use crate::geometry::Point;
use crate::time::{Span, Stamp};

/// Time that passes between two looks counts up to this `[s]`: after a longer pause the past says
/// little.
const LONGEST_STEP: f64 = 0.5;

/// A frame less likely than the likeliest by `exp(−this)` has no chance: leaps give it one again.
const HOPELESS: f64 = 50.0;

/// What one demonstration is believed to be.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    /// Distance of late `[m]`.
    cost: f64,
    /// Expected frame.
    frame: f64,
    /// How fast that goes, as a multiple of the demonstration's tempo.
    tempo: f64,
    /// `(cos, sin)` of the turn, weighted by the square of the people's distance.
    turn: [f64; 2],
}

impl State {
    /// How much the demonstration is turned to lie on the interaction `[rad]`.
    fn yaw(&self) -> f64 {
        let [cosine, sine] = self.turn;
        sine.atan2(cosine)
    }
}

/// Follows one interaction; all it needs it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracker {
    /// `P(f|d)` of all demonstrations one after another.
    chances: Vec<f64>,
    predicted: Vec<f64>,
    states: Vec<State>,
    order: Vec<usize>,
    features: Vec<f64>,
    point: Vec<f64>,
    last: Option<Stamp>,
    /// The part of a frame of the grid that has not been stepped yet `[s]`.
    rest: f64,
    belief: Belief,
}

impl Tracker {
    /// Nothing has been seen.
    pub fn new(library: &Library) -> Self {
        let rows = library.points().len();
        let count = library.exemplars().len();
        let hands = library.exemplars()[0].hands;
        let most = library.settings().demonstrations.min(count);
        let mut tracker = Self {
            chances: vec![0.0; rows],
            predicted: vec![0.0; rows],
            states: vec![State { cost: 0.0, frame: 0.0, tempo: 1.0, turn: [0.0; 2] }; count],
            order: (0..count).collect(),
            features: vec![0.0; library.feature_count()],
            point: vec![0.0; library.points().width()],
            last: None,
            rest: 0.0,
            belief: Belief {
                followed: Vec::with_capacity(most),
                hands,
                tempo: 1.0,
                distance: f64::INFINITY,
                is_familiar: false,
                contact: 0.0,
            },
        };
        tracker.reset(library);
        tracker
    }

    /// Forgets everything: the next interaction may be anywhere in any demonstration.
    pub fn reset(&mut self, library: &Library) {
        self.last = None;
        self.rest = 0.0;
        for exemplar in library.exemplars() {
            let share = 1.0 / exemplar.len() as f64;
            self.chances[exemplar.rows.clone()].fill(share);
        }
        self.belief.followed.clear();
        self.belief.distance = f64::INFINITY;
        self.belief.is_familiar = false;
        self.belief.tempo = 1.0;
    }

    /// What is believed; of nobody, before the first look.
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// Where the interaction is in every demonstration, in the library's order; all weigh the same.
    pub fn everywhere(&self) -> impl ExactSizeIterator<Item = Followed> + '_ {
        let weight = 1.0 / self.states.len() as f64;
        self.states.iter().enumerate().map(move |(exemplar, state)| Followed {
            exemplar,
            weight,
            frame: state.frame,
            yaw: state.yaw(),
        })
    }

    /// Takes in the partner as they are at `stamp`; stamps rise.
    ///
    /// Without allocation.
    ///
    /// - `robot_base`: where the robot's base is `[m]`.
    pub fn observe(
        &mut self,
        library: &Library,
        moment: &Moment,
        robot_base: Point,
        stamp: Stamp,
    ) -> &Belief {
        library.project(moment, robot_base, &mut self.features, &mut self.point);
        let is_first = self.last.is_none();
        let elapsed = self.last.map_or(Span(0), |last| stamp - last).seconds();
        let elapsed = elapsed.clamp(0.0, LONGEST_STEP);
        self.last = Some(stamp);
        let grid = library.step().seconds();
        let whole = ((self.rest + elapsed) / grid).round();
        self.rest += elapsed - whole * grid;
        let settings = library.settings();
        let precision = 0.5 / (settings.spread * settings.spread);
        let forgotten = if is_first { 1.0 } else { 1.0 - (-elapsed / settings.memory).exp() };
        let paced = 1.0 - (-elapsed / settings.pace_memory).exp();
        let partner_base = moment.positions()[moment.root().index()];
        let mut nearest = f64::INFINITY;
        for (at, exemplar) in library.exemplars().iter().enumerate() {
            let rows = exemplar.rows.clone();
            for _ in 0..whole as usize {
                self.step(library, at);
            }
            let (mut total, mut frames, mut distances) = (0.0, 0.0, 0.0);
            // The nearest place at all, so that no exponential underflows for all of them.
            let mut least = f64::INFINITY;
            for row in rows.clone() {
                let distance = squared_distance(&self.point, library.points().row(row));
                self.predicted[row] = distance;
                least = least.min(distance);
            }
            nearest = nearest.min(least);
            for (frame, row) in rows.clone().enumerate() {
                let distance = self.predicted[row];
                let unlikely = precision * (distance - least);
                if unlikely > HOPELESS {
                    self.chances[row] = 0.0;
                    continue;
                }
                let chance = self.chances[row] * (-unlikely).exp();
                self.chances[row] = chance;
                total += chance;
                frames += chance * frame as f64;
                distances += chance * distance.sqrt();
            }
            let state = &mut self.states[at];
            if total > 0.0 {
                self.chances[rows.clone()].iter_mut().for_each(|chance| *chance /= total);
                if whole > 0.0 && !is_first {
                    let went = ((frames / total - state.frame) / whole).clamp(0.0, 2.0);
                    state.tempo += paced * (went - state.tempo);
                }
                state.frame = frames / total;
                state.cost += forgotten * (distances / total - state.cost);
            } else {
                // Whatever was believed is impossible: anywhere, then.
                self.chances[rows.clone()].fill(1.0 / rows.len() as f64);
                state.cost += forgotten * (least.sqrt() - state.cost);
            }
            let place = |who| library.position(at, who, state.frame, library.base(who));
            let there = place(Who::Partner) - place(Who::Robot);
            let here = partner_base - robot_base;
            let turn = [there.x * here.x + there.y * here.y, there.x * here.y - there.y * here.x];
            for (kept, new) in state.turn.iter_mut().zip(turn) {
                *kept += forgotten * (new - *kept);
            }
        }
        self.choose(library, nearest.sqrt(), forgotten);
        &self.belief
    }

    /// One frame of the grid passes in one demonstration.
    fn step(&mut self, library: &Library, at: usize) {
        let settings = library.settings();
        let rows = library.exemplars()[at].rows.clone();
        let leap = settings.leap / rows.len() as f64;
        let (pause, hurry) = (settings.pause, settings.hurry);
        let go = 1.0 - pause - hurry;
        let chances = &mut self.chances[rows];
        let last = chances.len() - 1;
        // What runs over the end stays there: an interaction that is over is not another one.
        let over = chances[last] * (go + hurry)
            + last.checked_sub(1).map_or(0.0, |before| chances[before] * hurry);
        for frame in (0..=last).rev() {
            let from = |back: usize| frame.checked_sub(back).map_or(0.0, |from| chances[from]);
            let arrived = pause * from(0) + go * from(1) + hurry * from(2);
            chances[frame] = (1.0 - settings.leap) * arrived + leap;
        }
        chances[last] += (1.0 - settings.leap) * over;
    }

    /// Which demonstrations are followed, and what they say together.
    fn choose(&mut self, library: &Library, nearest: f64, forgotten: f64) {
        let Self { states, order, belief, .. } = self;
        let exemplars = library.exemplars();
        order.sort_unstable_by(|a, b| states[*a].cost.total_cmp(&states[*b].cost).then(a.cmp(b)));
        let most = library.settings().demonstrations.min(order.len());
        let weight = |at: usize| states[at].cost.max(1e-6).powi(-2);
        let votes = |hands: Hands| -> f64 {
            let voters = order[..most].iter().filter(|at| exemplars[**at].hands == hands);
            voters.map(|at| 1.0 / states[*at].cost.max(1e-6)).sum()
        };
        // Of equal votes the nearest demonstration's hands win.
        let mut hands = exemplars[order[0]].hands;
        for at in &order[..most] {
            if votes(exemplars[*at].hands) > votes(hands) {
                hands = exemplars[*at].hands;
            }
        }
        belief.hands = hands;
        belief.followed.clear();
        let agreeing = order.iter().filter(|at| exemplars[**at].hands == hands).take(most);
        for at in agreeing {
            let (frame, yaw) = (states[*at].frame, states[*at].yaw());
            belief.followed.push(Followed { exemplar: *at, weight: weight(*at), frame, yaw });
        }
        let total: f64 = belief.followed.iter().map(|followed| followed.weight).sum();
        (belief.contact, belief.tempo) = (0.0, 0.0);
        for followed in &mut belief.followed {
            followed.weight /= total;
            belief.contact +=
                followed.weight * (exemplars[followed.exemplar].contact - followed.frame);
            belief.tempo += followed.weight * states[followed.exemplar].tempo;
        }
        belief.distance = if belief.distance.is_finite() {
            belief.distance + forgotten.max(0.1) * (nearest - belief.distance)
        } else {
            nearest
        };
        belief.is_familiar = belief.distance <= library.familiar();
    }
}
