//! The methods, and what they learn once per set of motions.

use rayon::prelude::*;

use super::examples::Examples;
use super::fields::{Fields, Search};
use super::mixture::{EXPERTS, Mixture, Sums};
use super::{ForecastSettings, Moment};
use crate::geometry::{Point, Vector};
use crate::motion::{MotionError, Neighbourhood};
use crate::skeleton::{JointId, Sequence};

/// Ways to say where a person will be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ForecastMethod {
    /// Nothing moves.
    ZeroVelocity,
    /// Every joint keeps its velocity.
    ConstantVelocity,
    /// Velocities die away: over a time `t` a joint moves by `T (1 − e^(−t/T)) v`.
    DampedVelocity,
    /// Ridge regression of the displacements on the moment's features.
    Ridge,
    /// The mean displacement of the nearest demonstrated moments, by weights `1/D²`.
    Knn,
    /// That of the corners of the simplex that holds the moment.
    Delaunay,
    /// That of both together.
    KDelaunay,
    /// Constant velocity, ridge, nearest moments and simplex, each as much as recordings that were
    /// held out say it is to be trusted over each horizon.
    Mixed,
}

impl ForecastMethod {
    /// All of them, in the order tables show them.
    pub const ALL: [Self; 8] = [
        Self::ZeroVelocity,
        Self::ConstantVelocity,
        Self::DampedVelocity,
        Self::Ridge,
        Self::Knn,
        Self::Delaunay,
        Self::KDelaunay,
        Self::Mixed,
    ];

    /// The name in tables, files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::ZeroVelocity => "zero_velocity",
            Self::ConstantVelocity => "constant_velocity",
            Self::DampedVelocity => "damped_velocity",
            Self::Ridge => "ridge",
            Self::Knn => "knn",
            Self::Delaunay => "delaunay",
            Self::KDelaunay => "k_delaunay",
            Self::Mixed => "mixed",
        }
    }
}

/// Why there is no forecaster.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ForecastError {
    /// Settings that cannot be meant.
    #[error("{setting} is {value}, must be {bound}")]
    Setting {
        /// Which of [`ForecastSettings`].
        setting: &'static str,
        /// What it is.
        value: String,
        /// What it may be.
        bound: &'static str,
    },
    /// Nothing to learn from.
    #[error("no motion long enough to learn from: none lasts {least} s")]
    NoMoments {
        /// The past that a velocity takes and the nearest horizon together `[s]`.
        least: f64,
    },
    /// A motion's joints are not the first one's.
    #[error("motion {motion} has other joints than the first one")]
    Skeleton {
        /// Which motion, counted from 0.
        motion: usize,
    },
    /// What is expected of the moments differs along too few directions for simplices.
    #[error(
        "what comes after the {moments} moments spans {rank} dimension(s), and simplices take at \
         least 2 (hint: more, and more different motions)"
    )]
    Alike {
        /// How many moments there are.
        moments: usize,
        /// Dimensions that the features or what is expected of them span.
        rank: usize,
    },
    /// Moments without a latent space.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

/// Motions and what was learned from them; immutable, shared between threads.
///
/// ```
/// use handover_mesh::forecast::{ForecastMethod, ForecastSettings, Forecaster, Moment};
/// use handover_mesh::{Frame, Point, Sequence, Skeleton, Stamp};
/// // Somebody waves, faster and slower.
/// let wave = |speed: f64| {
///     let frame = |k: i64| {
///         let t = k as f64 / 30.0;
///         let place = |j: usize| {
///             let off = if j == 8 { (speed * t).sin() } else { 0.1 * (speed * t + j as f64).cos() };
///             Point::new(0.1 * j as f64, off, (j * j) as f64 % 1.7)
///         };
///         let positions = (0..15).map(place).collect();
///         Frame { stamp: Stamp(k * 33_333_333), positions }
///     };
///     Sequence::new(Skeleton::nite(), (0..120).map(frame).collect()).unwrap()
/// };
/// let (slow, fast, between) = (wave(2.0), wave(2.4), wave(2.2));
/// let root = Skeleton::nite().root();
/// let settings = ForecastSettings::default();
/// let forecaster = Forecaster::fit(&[(&slow, 0), (&fast, 1)], root, settings)?;
///
/// let mut moment = Moment::new(between.skeleton(), root);
/// moment.observe(between.skeleton(), &between.frames()[..60], 0.1);
/// let mut workspace = forecaster.workspace();
/// let joints = forecaster.forecast(ForecastMethod::Mixed, &moment, &mut workspace);
/// // The hand 0.2 s later.
/// let error = (joints[15 + 8] - between.frames()[65].positions[8]).norm();
/// assert!(error < 0.1, "{error}");
/// # Ok::<(), handover_mesh::forecast::ForecastError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Forecaster {
    fields: Fields,
    mixture: Mixture,
    root: JointId,
    /// Numbers in one horizon's displacement: three a joint.
    joints: usize,
    settings: ForecastSettings,
}

/// What forecasts compute in; may be dropped at any time.
#[derive(Debug, Clone)]
pub struct Workspace {
    features: Vec<f64>,
    search: Search,
    /// What the mixed methods say, `horizons × joints` each.
    said: [Vec<f64>; EXPERTS],
    displacement: Vec<f64>,
    positions: Vec<Point>,
}

/// Into how many parts recordings are dealt to find out how much each method is to be trusted.
const PARTS: u32 = 3;

/// Moments whose sums are taken by one thread: a fixed number, so that threads change no rounding.
const HEARD_TOGETHER: usize = 256;

/// Constant velocity, ridge, nearest, simplex: with a single recording nothing can be held out, and
/// the demonstrations nearest are taken at their word.
const UNTRIED: [f64; EXPERTS] = [0.0, 0.0, 1.0, 0.0];

impl Forecaster {
    /// Learns from motions of people of one skeleton.
    ///
    /// - `motions`: each with its group; motions of one group (one recording) are held out together.
    /// - `root`: the joint a person's place is taken by.
    ///
    /// # Errors
    /// [`ForecastError`]: settings out of bounds, skeletons that differ, motions too short, or poses
    /// all alike.
    pub fn fit(
        motions: &[(&Sequence, u32)],
        root: JointId,
        settings: ForecastSettings,
    ) -> Result<Self, ForecastError> {
        settings.check()?;
        let least = settings.velocity_window + settings.horizons.first().copied().unwrap_or(0.0);
        let (first, _) = motions.first().ok_or(ForecastError::NoMoments { least })?;
        let skeleton = first.skeleton();
        let mut examples = Examples::new(skeleton.own());
        for (at, (motion, group)) in motions.iter().enumerate() {
            if motion.skeleton() != skeleton {
                return Err(ForecastError::Skeleton { motion: at });
            }
            examples.add(motion, root, *group, &settings);
        }
        if examples.reach.iter().all(|reach| *reach == 0) {
            return Err(ForecastError::NoMoments { least });
        }
        let horizons = settings.horizons.len();
        let joints = examples.joints;
        let fields = Fields::fit(&examples, &settings, true)?;
        let mut forecaster =
            Self { fields, mixture: Sums::new(horizons).solve(0, UNTRIED), root, joints, settings };
        forecaster.mixture = forecaster.trust(&examples);
        Ok(forecaster)
    }

    /// How much each method is to be trusted, by what it says of moments it did not learn from.
    fn trust(&self, examples: &Examples) -> Mixture {
        let horizons = self.settings.horizons.len();
        let mut sums = Sums::new(horizons);
        let mut groups = examples.group.clone();
        groups.dedup();
        groups.sort_unstable();
        groups.dedup();
        let parts = PARTS.min(groups.len() as u32);
        if parts < 2 {
            return sums.solve(0, UNTRIED);
        }
        let part_of = |group: u32| groups.partition_point(|known| *known < group) as u32 % parts;
        for part in 0..parts {
            let learned = examples.part(|group| part_of(group) != part);
            let held_out = examples.part(|group| part_of(group) == part);
            // What is left may teach nothing, as where one recording alone is long enough.
            let Ok(fields) = Fields::fit(&learned, &self.settings, false) else { continue };
            let moments: Vec<usize> = (0..held_out.len()).collect();
            let heard = moments.par_chunks(HEARD_TOGETHER).map(|moments| {
                let mut workspace = self.workspace_of(&fields);
                let mut sums = Sums::new(horizons);
                for &moment in moments {
                    self.ask(&fields, held_out.features_of(moment), &mut workspace);
                    for horizon in 0..held_out.reach[moment] as usize {
                        let at = horizon * self.joints;
                        let said = workspace.said.each_ref().map(|d| &d[at..][..self.joints]);
                        let truth = held_out.displacement_of(moment, horizon, horizons);
                        sums.add(horizon, self.root.index(), said, truth);
                    }
                }
                sums
            });
            // In order, whoever was first.
            heard.collect::<Vec<_>>().iter().for_each(|heard| sums.merge(heard));
        }
        sums.solve(groups.len(), UNTRIED)
    }

    /// How far ahead forecasts go `[s]`, rising.
    pub fn horizons(&self) -> &[f64] {
        &self.settings.horizons
    }

    /// The past over which a moment's velocities are to be taken `[s]`.
    pub fn velocity_window(&self) -> f64 {
        self.settings.velocity_window
    }

    /// Room for forecasts, so that none of them allocates.
    pub fn workspace(&self) -> Workspace {
        self.workspace_of(&self.fields)
    }

    fn workspace_of(&self, fields: &Fields) -> Workspace {
        let outputs = self.settings.horizons.len() * self.joints;
        Workspace {
            features: vec![0.0; Moment::feature_count(self.joints / 3)],
            search: fields.search(),
            said: std::array::from_fn(|_| vec![0.0; outputs]),
            displacement: vec![0.0; outputs],
            positions: vec![Point::origin(); outputs / 3],
        }
    }

    /// Where the person's own joints will be: `[m]` in the world, `horizons × joints`.
    ///
    /// Without allocation.
    ///
    /// - `workspace`: from [`Self::workspace`].
    ///
    /// # Panics
    /// If the moment is of another skeleton or root: the caller's bug.
    pub fn forecast<'w>(
        &self,
        method: ForecastMethod,
        moment: &Moment,
        workspace: &'w mut Workspace,
    ) -> &'w [Point] {
        assert_eq!((moment.positions().len(), moment.root()), (self.joints / 3, self.root));
        let mut features = std::mem::take(&mut workspace.features);
        moment.features(self.settings.velocity_weight, &mut features);
        self.displace(method, &features, workspace);
        workspace.features = features;
        let world_from_root = moment.root_from_world().rotation.inverse();
        let moves = workspace.displacement.chunks_exact(3).map(Vector::from_column_slice);
        let places = moment.positions().iter().cycle();
        for ((position, moved), place) in workspace.positions.iter_mut().zip(moves).zip(places) {
            *position = place + world_from_root * moved;
        }
        &workspace.positions
    }

    /// Displacements over all horizons by one method, in the person's own frame.
    fn displace(&self, method: ForecastMethod, features: &[f64], workspace: &mut Workspace) {
        let fields = &self.fields;
        let field = |neighbourhood, workspace: &mut Workspace| {
            let Workspace { said, search, displacement, .. } = workspace;
            fields.regression.predict(features, &mut said[1]);
            fields.predict(neighbourhood, features, &said[1], search, displacement);
        };
        match method {
            ForecastMethod::ZeroVelocity => workspace.displacement.fill(0.0),
            ForecastMethod::ConstantVelocity => {
                self.carry(features, |t| [t, t], &mut workspace.displacement);
            }
            ForecastMethod::DampedVelocity => {
                let ForecastSettings { joint_damping, root_damping, .. } = self.settings;
                let damped = |t: f64, time: f64| time * (1.0 - (-t / time).exp());
                let reach = |t| [damped(t, root_damping), damped(t, joint_damping)];
                self.carry(features, reach, &mut workspace.displacement);
            }
            ForecastMethod::Ridge => {
                fields.regression.predict(features, &mut workspace.displacement)
            }
            ForecastMethod::Knn => field(Neighbourhood::Knn, workspace),
            ForecastMethod::Delaunay => field(Neighbourhood::Delaunay, workspace),
            ForecastMethod::KDelaunay => field(Neighbourhood::KDelaunay, workspace),
            ForecastMethod::Mixed => {
                self.ask(fields, features, workspace);
                let Workspace { said, displacement, .. } = workspace;
                for (horizon, mixed) in displacement.chunks_exact_mut(self.joints).enumerate() {
                    let of = said.each_ref().map(|d| &d[horizon * self.joints..][..self.joints]);
                    self.mixture.mix(horizon, self.root.index(), of, mixed);
                }
            }
        }
    }

    /// What the mixed methods say of a moment.
    fn ask(&self, fields: &Fields, features: &[f64], workspace: &mut Workspace) {
        let [constant, ridge, nearest, simplex] = &mut workspace.said;
        let search = &mut workspace.search;
        self.carry(features, |t| [t, t], constant);
        fields.regression.predict(features, ridge);
        fields.predict(Neighbourhood::Knn, features, ridge, search, nearest);
        fields.predict(Neighbourhood::Delaunay, features, ridge, search, simplex);
    }

    /// Velocities carried on: over a time `t` the root for `reach(t)[0]` `[s]`, the others' relative
    /// to it for `reach(t)[1]`.
    fn carry(&self, features: &[f64], reach: impl Fn(f64) -> [f64; 2], displacement: &mut [f64]) {
        let joints = self.joints / 3;
        let velocities = &features[3 * (joints - 1)..];
        let velocity = |at: usize| {
            Vector::from_column_slice(&velocities[3 * at..][..3]) / self.settings.velocity_weight
        };
        let root_velocity = velocity(joints - 1);
        let rows = displacement.chunks_exact_mut(self.joints);
        for (row, &horizon) in rows.zip(&self.settings.horizons) {
            let [root, others] = reach(horizon);
            let mut other = 0;
            for (joint, moved) in row.chunks_exact_mut(3).enumerate() {
                let mut sum = root_velocity * root;
                if joint != self.root.index() {
                    sum += velocity(other) * others;
                    other += 1;
                }
                moved.copy_from_slice(sum.as_slice());
            }
        }
    }
}
