//! The filter over (demonstration, frame).

use nalgebra::{Complex, UnitComplex};

use super::library::{RATES, Who, bearing, squared_distance};
use super::{Belief, Followed, Library};
use crate::demonstration::Hands;
use crate::forecast::Moment;
use crate::geometry::Point;
use crate::time::{Span, Stamp};

/// Time that passes between two looks counts up to this `[s]`: after a longer pause the past says
/// little.
const LONGEST_STEP: f64 = 0.5;

/// Rows this much less likely than the likeliest are taken for impossible `[-]`.
const NEGLIGIBLE: f64 = 1e-6;

/// What a look at one demonstration says.
struct Seen {
    /// Expected frame.
    frame: f64,
    /// Expected distance `[m]`.
    distance: f64,
    /// Distance of the nearest row that can be come to `[m]`.
    nearest: f64,
}

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

/// Before anything is seen.
const UNKNOWN: State = State { cost: 0.0, frame: 0.0, tempo: 1.0, turn: [0.0; 2] };

impl State {
    /// How the demonstration is turned to lie on the interaction; not at all where nothing tells.
    fn turn(&self) -> UnitComplex<f64> {
        let [cosine, sine] = self.turn;
        let turn = UnitComplex::try_new(Complex::new(cosine, sine), 0.0);
        turn.unwrap_or_else(UnitComplex::identity)
    }
}

/// Follows one interaction; all it needs it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracker {
    /// `P(f|d)` of all demonstrations one after another.
    chances: Vec<f64>,
    /// Where an interaction begins that was not seen beginning, and where one that is: of all
    /// demonstrations one after another.
    starts: Vec<f64>,
    restarts: Vec<f64>,
    /// How likely each row is come to at each rate.
    arrived: Vec<[f64; RATES.len()]>,
    /// Squared distance of the partner's moment to each row, gone through at each rate.
    distances: Vec<[f64; RATES.len()]>,
    states: Vec<State>,
    order: Vec<usize>,
    features: Vec<f64>,
    point: Vec<f64>,
    last: Option<Stamp>,
    /// The part of a frame of the grid that has not been stepped yet `[s]`.
    rest: f64,
    /// In which direction the partner has the robot, of late: `(cos, sin)`.
    bearing: [f64; 2],
    belief: Belief,
}

impl Tracker {
    /// Nothing has been seen.
    pub fn new(library: &Library) -> Self {
        let rows = library.points()[0].len();
        let count = library.exemplars().len();
        let hands = library.exemplars()[0].hands;
        let most = library.settings().demonstrations.min(count);
        let mut tracker = Self {
            chances: vec![0.0; rows],
            starts: starts(library, library.settings().start),
            restarts: starts(library, library.settings().restart),
            arrived: vec![[0.0; RATES.len()]; rows],
            distances: vec![[0.0; RATES.len()]; rows],
            states: vec![UNKNOWN; count],
            order: (0..count).collect(),
            features: vec![0.0; library.feature_count()],
            point: vec![0.0; library.points()[0].width()],
            last: None,
            rest: 0.0,
            bearing: [0.0; 2],
            belief: Belief {
                followed: Vec::with_capacity(most),
                hands,
                tempo: 1.0,
                distance: f64::INFINITY,
                turned: 0.0,
                is_familiar: false,
                contact: 0.0,
            },
        };
        tracker.reset();
        tracker
    }

    /// Forgets everything: the next interaction may be anywhere in any demonstration.
    pub fn reset(&mut self) {
        self.last = None;
        self.rest = 0.0;
        self.chances.copy_from_slice(&self.starts);
        self.belief.followed.clear();
        self.belief.distance = f64::INFINITY;
        self.bearing = [0.0; 2];
        self.belief.turned = 0.0;
        self.belief.is_familiar = false;
        self.belief.tempo = 1.0;
        self.states.fill(UNKNOWN);
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
            turn: state.turn(),
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
        // Two looks a frame tell no more than one: what is off is off in both.
        let looks = if is_first { 1.0 } else { (elapsed / grid).min(1.0) };
        let precision = 0.5 * looks / (settings.spread * settings.spread);
        let forgotten = if is_first { 1.0 } else { 1.0 - (-elapsed / settings.memory).exp() };
        let paced = 1.0 - (-elapsed / settings.pace_memory).exp();
        let partner_base = moment.positions()[moment.root().index()];
        let mut nearest = f64::INFINITY;
        for at in 0..library.exemplars().len() {
            for _ in 1..whole as usize {
                self.step(library, at);
            }
            let seen = self.look(library, at, whole > 0.0, precision);
            nearest = nearest.min(seen.nearest);
            let state = &mut self.states[at];
            if whole > 0.0 && !is_first {
                let went = ((seen.frame - state.frame) / whole).clamp(0.0, 2.0);
                state.tempo += paced * (went - state.tempo);
            }
            state.frame = seen.frame;
            state.cost += forgotten * (seen.distance - state.cost);
            let place = |who| library.position(at, who, state.frame, library.base(who));
            let there = place(Who::Partner) - place(Who::Robot);
            let here = partner_base - robot_base;
            let turn = [there.x * here.x + there.y * here.y, there.x * here.y - there.y * here.x];
            for (kept, new) in state.turn.iter_mut().zip(turn) {
                *kept += forgotten * (new - *kept);
            }
        }
        self.choose(library, nearest, forgotten);
        self.judge(library, moment, robot_base, forgotten.max(0.1));
        &self.belief
    }

    /// One frame of the grid passes in one demonstration, unseen.
    fn step(&mut self, library: &Library, at: usize) {
        self.arrive(library, at);
        let rows = library.exemplars()[at].rows.clone();
        for (chance, arrived) in self.chances[rows.clone()].iter_mut().zip(&self.arrived[rows]) {
            *chance = arrived.iter().sum();
        }
    }

    /// How likely each row of a demonstration is come to in one frame of the grid, at each of
    /// [`RATES`].
    fn arrive(&mut self, library: &Library, at: usize) {
        let rows = library.exemplars()[at].rows.clone();
        let leap = library.settings().leap;
        let [pause, go, hurry] = shares(library).map(|share| (1.0 - leap) * share);
        let (chances, restarts) = (&self.chances[rows.clone()], &self.restarts[rows.clone()]);
        let last = chances.len() - 1;
        // What runs over the end stays there, still.
        let over =
            (go + hurry) * chances[last] + last.checked_sub(1).map_or(0.0, |k| hurry * chances[k]);
        for (frame, arrived) in self.arrived[rows].iter_mut().enumerate() {
            let from = |back: usize| frame.checked_sub(back).map_or(0.0, |from| chances[from]);
            let stays = if frame == last { over } else { 0.0 };
            let anew = leap * restarts[frame];
            *arrived = [pause * from(0) + anew + stays, go * from(1), hurry * from(2)];
        }
    }

    /// Weighs one demonstration's rows by what is seen.
    ///
    /// - `passes`: whether a frame of the grid passes.
    /// - `precision`: of squared distances `[1/m²]`.
    fn look(&mut self, library: &Library, at: usize, passes: bool, precision: f64) -> Seen {
        let rows = library.exemplars()[at].rows.clone();
        if passes {
            self.arrive(library, at);
        } else {
            let shares = shares(library);
            for row in rows.clone() {
                self.arrived[row] = shares.map(|share| share * self.chances[row]);
            }
        }
        // Rows that hardly anything leads to are left out: most of them, once something is seen.
        let arrived = self.arrived[rows.clone()].iter().flatten();
        let least = NEGLIGIBLE * arrived.fold(0.0, |most: f64, chance| most.max(*chance));
        // From the nearest on, so that no exponential underflows for all of them.
        let mut nearest = f64::INFINITY;
        for row in rows.clone() {
            for rate in 0..RATES.len() {
                if self.arrived[row][rate] > least {
                    let distance = squared_distance(&self.point, library.points()[rate].row(row));
                    self.distances[row][rate] = distance;
                    nearest = nearest.min(distance);
                }
            }
        }
        let (mut total, mut distances) = (0.0, 0.0);
        for row in rows.clone() {
            let mut sum = 0.0;
            for rate in 0..RATES.len() {
                let arrived = self.arrived[row][rate];
                if arrived > least {
                    let distance = self.distances[row][rate];
                    let chance = arrived * (-precision * (distance - nearest)).exp();
                    distances += chance * distance.sqrt();
                    sum += chance;
                }
            }
            self.chances[row] = sum;
            total += sum;
        }
        let chances = &mut self.chances[rows];
        chances.iter_mut().for_each(|chance| *chance /= total);
        let around = (library.settings().stretch / library.step().seconds()).round() as usize;
        let frame = likeliest(chances, around);
        Seen { frame, distance: distances / total, nearest: nearest.sqrt() }
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
            let (frame, turn) = (states[*at].frame, states[*at].turn());
            belief.followed.push(Followed { exemplar: *at, weight: weight(*at), frame, turn });
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
    }

    /// Whether this is an interaction as demonstrated: like one of them, and towards the robot.
    ///
    /// - `share`: of what is new in what is known of late `[-]`.
    fn judge(&mut self, library: &Library, moment: &Moment, robot_base: Point, share: f64) {
        if let Some(bearing) = bearing(moment, robot_base) {
            for (kept, new) in self.bearing.iter_mut().zip([bearing.re, bearing.im]) {
                *kept += share * (new - *kept);
            }
        }
        let [cosine, sine] = self.bearing;
        let bearing = UnitComplex::try_new(Complex::new(cosine, sine), 0.0);
        let belief = &mut self.belief;
        belief.turned = bearing.map_or(0.0, |bearing| library.turned_by(bearing));
        belief.is_familiar =
            belief.distance <= library.familiar() && belief.turned <= library.turned();
    }
}

/// The mean frame of the likeliest stretch of time, of `around` frames before and after its middle.
fn likeliest(chances: &[f64], around: usize) -> f64 {
    let ahead = &chances[around.min(chances.len())..];
    let (mut sum, mut best) = (chances.iter().take(around).sum::<f64>(), (f64::NEG_INFINITY, 0));
    for middle in 0..chances.len() {
        sum += ahead.get(middle).copied().unwrap_or(0.0);
        if let Some(left) = middle.checked_sub(around + 1) {
            sum -= chances[left];
        }
        if sum > best.0 {
            best = (sum, middle);
        }
    }
    let first = best.1.saturating_sub(around);
    let stretch = chances.iter().enumerate().skip(first).take(best.1 + around + 1 - first);
    let (total, frames) = stretch.fold((0.0, 0.0), |(total, frames), (frame, chance)| {
        (total + chance, frames + chance * frame as f64)
    });
    frames / total
}

/// How likely a frame of the grid takes a demonstration on at each of [`RATES`].
fn shares(library: &Library) -> [f64; RATES.len()] {
    let settings = library.settings();
    [settings.pause, 1.0 - settings.pause - settings.hurry, settings.hurry]
}

/// How likely an interaction begins at each row: falling by `exp(−t/time)` within a demonstration.
fn starts(library: &Library, time: f64) -> Vec<f64> {
    let fall = (-library.step().seconds() / time).exp();
    let mut starts = vec![0.0; library.points()[0].len()];
    for exemplar in library.exemplars() {
        let starts = &mut starts[exemplar.rows.clone()];
        let mut chance = 1.0;
        for start in &mut *starts {
            *start = chance;
            chance *= fall;
        }
        let total: f64 = starts.iter().sum();
        starts.iter_mut().for_each(|start| *start /= total);
    }
    starts
}
