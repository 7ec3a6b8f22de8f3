//! Demonstrations on one grid of time, and their moments as places in a latent space.

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Complex, UnitComplex};

use super::TrackSettings;
use crate::demonstration::{Demonstration, Hands};
use crate::forecast::Moment;
use crate::geometry::{Point, Vector};
use crate::motion::{Dimensions, MotionError, Pca, Rows};
use crate::settings::OutOfBounds;
use crate::skeleton::{JointId, Riders, Sequence, SequenceError, Skeleton};
use crate::statistics::quantile;
use crate::time::{Span, Stamp};

/// A partner turned by less than this `[rad]` may be one whose shoulders were measured badly, and
/// by more than that turns their back: whatever the demonstrations.
const LEAST_TURN: f64 = PI / 3.0;
const MOST_TURN: f64 = 2.0 * PI / 3.0;

/// Demonstrations of more frames of the grid than this are not followed: an hour at 30 Hz.
const MOST_FRAMES: i64 = 108_000;

/// Why demonstrations make no library.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LibraryError {
    /// Nothing to follow.
    #[error("no demonstrations to follow")]
    Empty,
    /// A demonstration is of other joints or another role than the first.
    #[error("{demonstration} has other joints, or people in another order, than the first one")]
    Other {
        /// The demonstration's name.
        demonstration: String,
    },
    /// A demonstration cannot be laid on the grid.
    #[error("{demonstration}: {error}")]
    Sequence {
        /// The demonstration's name.
        demonstration: String,
        /// Why.
        error: SequenceError,
    },
    /// A demonstration, or a gap in it, is too long to be followed.
    #[error(
        "{demonstration} lasts {seconds} s, {frames} frames of track.rate: {MOST_FRAMES} at most"
    )]
    Long {
        /// The demonstration's name.
        demonstration: String,
        /// How long it is `[s]`.
        seconds: f64,
        /// How many frames of the grid that is.
        frames: i64,
    },
    /// A setting is out of its bounds.
    #[error(transparent)]
    Settings(#[from] OutOfBounds),
    /// Moments without a latent space.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

/// One demonstration on the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Exemplar {
    /// The hands that met.
    pub hands: Hands,
    /// When they did, in frames of the grid.
    pub contact: f64,
    /// Its moments' rows in the library.
    pub(super) rows: Range<usize>,
    /// The partner's joints `[m]`, `frames × joints`.
    partner: Vec<Point>,
    /// The robot role's joints `[m]`, `frames × joints`.
    robot: Vec<Point>,
}

impl Exemplar {
    /// The number of frames of the grid, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "a demonstration has frames")]
    pub fn len(&self) -> usize {
        self.rows.len()
    }
}

/// Whose joints of an exemplar are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Who {
    /// The robot's role.
    Robot,
    /// Its partner.
    Partner,
}

/// How fast a demonstration may be gone through from one frame of the grid to the next, as a
/// multiple of its own tempo: whoever pauses has its places, not its velocities.
pub(super) const RATES: [f64; 3] = [0.0, 1.0, 2.0];

/// Demonstrations to be followed: immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct Library {
    exemplars: Vec<Exemplar>,
    skeletons: [Arc<Skeleton>; 2],
    bases: [JointId; 2],
    pca: Pca,
    /// Of moments as they were, and of the same as they would be at another [`RATES`].
    points: [Rows; 3],
    step: Span,
    /// Farther from all moments than this `[m]` is no demonstrated interaction.
    familiar: f64,
    /// In which direction the partners have the robot, from the way they face.
    bearing: UnitComplex<f64>,
    /// Turned from that by more than this `[rad]` is no demonstrated interaction.
    turned: f64,
    settings: TrackSettings,
}

impl Library {
    /// Lays demonstrations on the grid; they are taken as smoothed as they are.
    ///
    /// # Errors
    /// [`LibraryError`] if there are none, if they differ in joints or roles, one is too long, all
    /// moments are alike, or a setting is out of bounds.
    pub fn new(
        demonstrations: &[Arc<Demonstration>],
        settings: TrackSettings,
    ) -> Result<Self, LibraryError> {
        settings.check()?;
        let first = demonstrations.first().ok_or(LibraryError::Empty)?;
        let skeletons = [first.robot().skeleton().clone(), first.partner().skeleton().clone()];
        let bases = [first.robot_base(), first.partner_base()];
        let step = Span((1e9 / settings.rate).round() as i64);
        let (mut exemplars, mut features, mut bearings) = (Vec::new(), Vec::new(), Vec::new());
        for demonstration in demonstrations {
            let name = || demonstration.recording().name().to_owned();
            let same = demonstration.robot_role() == first.robot_role()
                && *demonstration.robot().skeleton() == skeletons[0]
                && *demonstration.partner().skeleton() == skeletons[1];
            if !same {
                return Err(LibraryError::Other { demonstration: name() });
            }
            let frames = demonstration.partner().frames();
            let span = frames[frames.len() - 1].stamp - frames[0].stamp;
            let frames = span.0 / step.0;
            if frames > MOST_FRAMES {
                let (demonstration, seconds) = (name(), span.seconds());
                return Err(LibraryError::Long { demonstration, seconds, frames });
            }
            let start = exemplars.last().map_or(0, |last: &Exemplar| last.rows.end);
            let lay = |motion: &Sequence| {
                let error = |error| LibraryError::Sequence { demonstration: name(), error };
                on_grid(motion, step).map_err(error)
            };
            let (robot, partner) = (lay(demonstration.robot())?, lay(demonstration.partner())?);
            let contact = demonstration.contact();
            let since = demonstration.robot().frames()[contact.frame].stamp
                - demonstration.robot().frames()[0].stamp;
            let mut moment = Moment::new(&skeletons[1], bases[1]);
            for frame in 0..partner.len() {
                let past = &partner.frames()[..=frame];
                moment.observe(&skeletons[1], past, settings.velocity_window);
                let base = robot.position(frame, bases[0]);
                bearings.extend(bearing(&moment, base));
                let from = features.len();
                features.resize(from + feature_count(&skeletons[1]), 0.0);
                write_features(&moment, base, &settings, &mut features[from..]);
            }
            exemplars.push(Exemplar {
                hands: contact.hands,
                contact: since.0 as f64 / step.0 as f64,
                rows: start..start + partner.len(),
                partner: points(&partner),
                robot: points(&robot),
            });
        }
        let features = Rows::new(feature_count(&skeletons[1]), features)?;
        let pca = match Pca::fit(&features, Dimensions::Count(settings.dimensions)) {
            Err(MotionError::Rank { rank, .. }) if rank > 0 => {
                Pca::fit(&features, Dimensions::Count(rank))?
            }
            fitted => fitted?,
        };
        let at_rate = |rate: f64| -> Result<Rows, MotionError> {
            let mut paced = features.values().to_vec();
            for row in paced.chunks_exact_mut(features.width()) {
                let velocities = velocities(&skeletons[1]);
                row[velocities].iter_mut().for_each(|value| *value *= rate);
            }
            Ok(pca.project(&Rows::new(features.width(), paced)?))
        };
        let [still, usual, hurried] = RATES.map(at_rate);
        let points = [still?, usual?, hurried?];
        let sum: Complex<f64> = bearings.iter().map(|bearing| bearing.into_inner()).sum();
        let bearing = UnitComplex::try_new(sum, 0.0).unwrap_or_else(UnitComplex::identity);
        let off = bearings.iter().map(|other| bearing.angle_to(other).abs()).collect();
        let usual = quantile(off, 0.95).unwrap_or(0.0);
        let turned = (settings.strangeness * usual).clamp(LEAST_TURN, MOST_TURN);
        let mut library = Self {
            exemplars,
            skeletons,
            bases,
            pca,
            points,
            step,
            familiar: 0.0,
            bearing,
            turned,
            settings,
        };
        library.familiar = library.settings.strangeness * library.own_distance();
        Ok(library)
    }

    /// How far moments are from the nearest one of another demonstration `[m]`: 95 % are nearer.
    fn own_distance(&self) -> f64 {
        // Neighbours in time are alike: every few frames tell as much as all.
        const EVERY: usize = 5;
        let mut nearest: Vec<f64> = Vec::new();
        for exemplar in &self.exemplars {
            for row in exemplar.rows.clone().step_by(EVERY) {
                let here = self.points[1].row(row);
                let others = self.exemplars.iter().filter(|other| other.rows != exemplar.rows);
                let distances = others
                    .flat_map(|other| other.rows.clone())
                    .map(|other| squared_distance(here, self.points[1].row(other)));
                let least = distances.fold(f64::INFINITY, f64::min);
                if least.is_finite() {
                    nearest.push(least.sqrt());
                }
            }
        }
        // A single demonstration says nothing of how people differ: a hand's breadth.
        quantile(nearest, 0.95).unwrap_or(0.1)
    }

    /// All demonstrations, in the order given.
    pub fn exemplars(&self) -> &[Exemplar] {
        &self.exemplars
    }

    /// The joints of one of the two.
    pub fn skeleton(&self, who: Who) -> &Arc<Skeleton> {
        &self.skeletons[who as usize]
    }

    /// The joint that one's place is known by.
    pub fn base(&self, who: Who) -> JointId {
        self.bases[who as usize]
    }

    /// The time between two frames of the grid.
    pub fn step(&self) -> Span {
        self.step
    }

    /// How the partner is looked for.
    pub fn settings(&self) -> &TrackSettings {
        &self.settings
    }

    /// Latent places of all moments, the first demonstration's first, gone through at each of
    /// [`RATES`].
    pub(super) fn points(&self) -> &[Rows; 3] {
        &self.points
    }

    /// Farther from all moments than this `[m]` is no demonstrated interaction.
    pub(super) fn familiar(&self) -> f64 {
        self.familiar
    }

    /// How far a direction to the robot is from where the demonstrations' partners had it `[rad]`.
    pub(super) fn turned_by(&self, bearing: UnitComplex<f64>) -> f64 {
        self.bearing.angle_to(&bearing).abs()
    }

    /// Turned by more than this `[rad]` is no demonstrated interaction.
    pub(super) fn turned(&self) -> f64 {
        self.turned
    }

    /// The latent place of a moment.
    ///
    /// - `features`: room for [`Self::feature_count`] numbers.
    /// - `point`: one number per latent dimension, overwritten.
    pub(super) fn project(
        &self,
        moment: &Moment,
        robot_base: Point,
        features: &mut [f64],
        point: &mut [f64],
    ) {
        write_features(moment, robot_base, &self.settings, features);
        self.pca.project_pose(features, point);
    }

    /// How many numbers tell a moment.
    pub(super) fn feature_count(&self) -> usize {
        feature_count(&self.skeletons[1])
    }

    /// Where a joint is in a demonstration at a fractional frame, held before the first and after
    /// the last: `[m]`, as it was recorded.
    pub fn position(&self, exemplar: usize, who: Who, frame: f64, joint: JointId) -> Point {
        self.pose(exemplar, who, frame).position(joint)
    }

    /// Where all joints are: as [`Self::position`].
    pub fn pose(&self, exemplar: usize, who: Who, frame: f64) -> Between<'_> {
        let exemplar = &self.exemplars[exemplar];
        let joints = self.skeletons[who as usize].len();
        let points = match who {
            Who::Robot => &exemplar.robot,
            Who::Partner => &exemplar.partner,
        };
        let frame = frame.clamp(0.0, (exemplar.len() - 1) as f64);
        let [before, after] =
            [frame.floor(), frame.ceil()].map(|frame| &points[frame as usize * joints..][..joints]);
        Between { before, after, part: frame.fract() }
    }

    /// How what rides on a person's joints sits on them at the start of the first demonstration.
    pub fn riders(&self, who: Who) -> Riders {
        let skeleton = self.skeleton(who);
        let pose: Vec<Point> =
            skeleton.joints().map(|joint| self.position(0, who, 0.0, joint)).collect();
        Riders::new(skeleton, &pose)
    }

    /// From a person's base to a joint of theirs in a demonstration: `[m]`, as it was recorded.
    pub fn from_base(&self, exemplar: usize, who: Who, frame: f64, joint: JointId) -> Vector {
        let pose = self.pose(exemplar, who, frame);
        pose.position(joint) - pose.position(self.base(who))
    }
}

/// Joints between two frames.
#[derive(Debug, Clone, Copy)]
pub struct Between<'a> {
    before: &'a [Point],
    after: &'a [Point],
    part: f64,
}

impl Between<'_> {
    /// Where a joint is `[m]`.
    #[inline]
    pub fn position(&self, joint: JointId) -> Point {
        let [before, after] = [self.before, self.after].map(|joints| joints[joint.index()]);
        before + (after - before) * self.part
    }
}

/// Squared distance of two places.
#[inline]
pub(super) fn squared_distance(a: &[f64], b: &[f64]) -> f64 {
    /// Sums that do not wait for each other.
    const LANES: usize = 4;
    let square = |(a, b): (&f64, &f64)| (a - b) * (a - b);
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(square).sum();
    let mut sums = [0.0; LANES];
    for (a, b) in a.zip(b) {
        for lane in 0..LANES {
            sums[lane] += square((&a[lane], &b[lane]));
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Which of a moment's features are velocities.
fn velocities(partner: &Skeleton) -> Range<usize> {
    3 * (partner.own() - 1)..Moment::feature_count(partner.own())
}

fn feature_count(partner: &Skeleton) -> usize {
    Moment::feature_count(partner.own()) + 1
}

/// What a moment is known by: the partner's places and velocities in their own frame, and how far
/// the robot is. `[m]`, scaled so that the distance of two rows is a mean distance of a joint.
fn write_features(moment: &Moment, base: Point, settings: &TrackSettings, features: &mut [f64]) {
    let (last, pose) = match features.split_last_mut() {
        Some(parts) => parts,
        None => return,
    };
    moment.features(settings.velocity_weight.max(1e-9), pose);
    let scale = 1.0 / (moment.positions().len() as f64).sqrt();
    pose.iter_mut().for_each(|value| *value *= scale);
    let place = moment.positions()[moment.root().index()];
    *last = (base - place).xy().norm() * settings.distance_weight;
}

/// In which direction a person has the robot, from the way they face; none on the same spot.
pub(super) fn bearing(moment: &Moment, robot_base: Point) -> Option<UnitComplex<f64>> {
    let place = moment.root_from_world() * robot_base;
    UnitComplex::try_new(Complex::new(place.x, place.y), 1e-9)
}

fn on_grid(motion: &Sequence, step: Span) -> Result<Sequence, SequenceError> {
    let (first, last) = (motion.frames()[0].stamp, motion.frames()[motion.len() - 1].stamp);
    let frames = (last - first).0 / step.0;
    let stamps: Vec<Stamp> = (0..=frames).map(|k| first + Span(k * step.0)).collect();
    motion.resampled(&stamps)
}

fn points(motion: &Sequence) -> Vec<Point> {
    motion.frames().iter().flat_map(|frame| frame.positions.iter().copied()).collect()
}
