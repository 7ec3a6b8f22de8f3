//! The methods, and what they learn once per set of demonstrations.

use std::sync::Arc;

use super::aligned::{Alignment, align, choose, features};
use super::{LearnedEdges, PredictSettings, Problem, ReferenceBlend, Shapes, attach, promp, ridge};
use crate::demonstration::{Demonstration, Hands, Observation};
use crate::geometry::{Point, Vector};
use crate::mesh::MeshError;
use crate::retarget::RetargetError;
use crate::skeleton::joint_differences;

/// Ways to say where the robot's joints belong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Method {
    /// The robot's first pose, kept on its base.
    Hold,
    /// The nearest demonstration, moved to the base.
    Replay,
    /// The weighted mean of the nearest demonstrations.
    Knn,
    /// Ridge regression of the robot's pose on the partner's.
    Ridge,
    /// Interaction probabilistic movement primitives (Maeda et al. 2014), ridge-regularised.
    Promp,
    /// The nearest demonstration, its hand led by two-bone inverse kinematics to the partner's
    /// hand plus the mean gap.
    Attach,
    /// Laplacian retargeting without interperson edges.
    None,
    /// Laplacian retargeting with the interaction mesh.
    Mesh,
}

impl Method {
    /// All of them, in the order tables show them.
    pub const ALL: [Self; 8] = [
        Self::Hold,
        Self::Replay,
        Self::Knn,
        Self::Ridge,
        Self::Promp,
        Self::Attach,
        Self::None,
        Self::Mesh,
    ];

    /// The name in tables, files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Replay => "replay",
            Self::Knn => "knn",
            Self::Ridge => "ridge",
            Self::Promp => "promp",
            Self::Attach => "attach",
            Self::None => "none",
            Self::Mesh => "mesh",
        }
    }
}

/// Why there is no prediction.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PredictError {
    /// Nothing to learn from.
    #[error("no demonstrations")]
    NoDemonstrations,
    /// A demonstration's skeletons are not the observation's.
    #[error("other joints than in demonstration {demonstration}: {difference}")]
    Skeleton {
        /// The demonstration's name.
        demonstration: String,
        /// Which of the observation's joints are missing or extra.
        difference: String,
    },
    /// The robot takes one role in a demonstration and another here.
    #[error("{demonstration} names its people in another order than the recording at hand")]
    Role {
        /// The demonstration's name.
        demonstration: String,
    },
    /// The reference makes no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The mesh could not be solved.
    #[error(transparent)]
    Retarget(#[from] RetargetError),
}

/// Demonstrations and what was fitted to them; immutable, shared between threads.
#[derive(Debug, Clone)]
pub struct Predictor {
    demonstrations: Vec<Arc<Demonstration>>,
    features: Vec<Vec<Vec<f64>>>,
    ridge: ridge::Ridge,
    edges: LearnedEdges,
    /// Where the reference is a blend.
    shapes: Option<Shapes>,
    settings: PredictSettings,
}

impl Predictor {
    /// Smooths a set of demonstrations and fits everything to them.
    ///
    /// # Errors
    /// [`PredictError`] if there are none, or their skeletons or roles differ.
    pub fn fit(
        demonstrations: Vec<Arc<Demonstration>>,
        settings: PredictSettings,
    ) -> Result<Self, PredictError> {
        let first = demonstrations.first().ok_or(PredictError::NoDemonstrations)?.observation();
        for demonstration in &demonstrations {
            check_same(demonstration, &first)?;
        }
        let smooth = |d: Arc<Demonstration>| Arc::new(d.smoothed(settings.smoothing));
        let demonstrations: Vec<_> = demonstrations.into_iter().map(smooth).collect();
        let features = demonstrations.iter().map(|demonstration| {
            let robot = demonstration.robot();
            features(
                demonstration.partner(),
                demonstration.partner_base(),
                |frame| robot.position(frame, demonstration.robot_base()),
                settings.distance_weight,
            )
        });
        let features = features.collect();
        let ridge = ridge::Ridge::fit(&demonstrations, settings.ridge_penalty);
        let edges = LearnedEdges::none(demonstrations[0].contact().hands);
        let shapes = match settings.blend {
            ReferenceBlend::Mean => None,
            ReferenceBlend::Rigid => Shapes::new(demonstrations.iter().map(|d| &**d))?,
        };
        Ok(Self { demonstrations, features, ridge, edges, shapes, settings })
    }

    /// The same with edges between the people for [`Method::Mesh`], which has none otherwise.
    pub fn with_edges(self, edges: LearnedEdges) -> Self {
        Self { edges, ..self }
    }

    /// The demonstrations, smoothed, in the order given.
    pub fn demonstrations(&self) -> &[Arc<Demonstration>] {
        &self.demonstrations
    }

    /// The edges between the people.
    pub fn edges(&self) -> &LearnedEdges {
        &self.edges
    }

    /// What the demonstrations are shapes of, where the reference is their blend.
    pub fn shapes(&self) -> Option<&Shapes> {
        self.shapes.as_ref()
    }

    /// How predictions are made.
    pub fn settings(&self) -> &PredictSettings {
        &self.settings
    }

    /// What the methods may know of an interaction, smoothed as the demonstrations are.
    pub fn observe(&self, interaction: &Demonstration) -> Observation {
        Observation {
            // Smoothing may shorten a bone; the robot's own do not change.
            bone_lengths: interaction.robot().bone_lengths(),
            ..interaction.smoothed(self.settings.smoothing).observation()
        }
    }

    /// Lays all demonstrations on an observation's time and place.
    ///
    /// # Errors
    /// [`PredictError::Skeleton`], [`PredictError::Role`] if the observation has other people.
    pub fn align(&self, observation: &Observation) -> Result<Alignment, PredictError> {
        self.align_to(observation, None, |_| true)
    }

    /// Lays some of the demonstrations on an observation's time and place.
    ///
    /// - `hands`: the hands that meet, where they are known; else the demonstrations vote.
    /// - `allowed`: which demonstrations take part, by their place in [`Self::demonstrations`].
    ///
    /// # Errors
    /// As [`Self::align`]; [`PredictError::NoDemonstrations`] if none is left.
    pub fn align_to(
        &self,
        observation: &Observation,
        hands: Option<Hands>,
        allowed: impl Fn(usize) -> bool,
    ) -> Result<Alignment, PredictError> {
        check_same(&self.demonstrations[0], observation)?;
        let observed = features(
            &observation.partner,
            observation.partner_base,
            |frame| observation.base[frame],
            self.settings.distance_weight,
        );
        let all = self.demonstrations.iter().zip(&self.features).enumerate();
        let all = all.filter(|(index, _)| allowed(*index));
        let all = all.filter_map(|(index, (demonstration, demonstrated))| {
            let warp = self.settings.warp;
            align(observation, &observed, index, demonstration, demonstrated, warp)
        });
        choose(all.collect(), hands, &self.settings).ok_or(PredictError::NoDemonstrations)
    }

    /// The mean gap `[m]` of the demonstrations in which these hands met (in all, where none
    /// agrees), in the partner's heading frame at their contact: the ḡ of the evaluation.
    pub fn mean_gap(&self, hands: Hands) -> Vector {
        self.mean_gap_of(hands, |_| true)
    }

    /// The mean gap of some of the demonstrations, by their places.
    fn mean_gap_of(&self, hands: Hands, allowed: impl Fn(usize) -> bool) -> Vector {
        let of = |agreeing: bool| -> Vec<Vector> {
            let some = self.demonstrations.iter().enumerate().filter(|(at, _)| allowed(*at));
            let contacts = some.map(|(_, demonstration)| demonstration.contact());
            contacts.filter(|c| !agreeing || c.hands == hands).map(|c| c.gap).collect()
        };
        let agreeing = of(true);
        let gaps = if agreeing.is_empty() { of(false) } else { agreeing };
        gaps.iter().sum::<Vector>() / gaps.len().max(1) as f64
    }

    /// What [`Method::Mesh`] solves: the reference holds the mean gap at its contact.
    pub fn problem(&self, observation: &Observation, alignment: &Alignment) -> Problem {
        let gap = self.mean_gap(alignment.hands);
        Problem::new(observation, alignment, self.shapes(), Some(gap), &self.settings)
    }

    /// One of the demonstrations, retargeted from one of the others as [`Self::problem`] is.
    ///
    /// - `at`, `from`: their places in [`Self::demonstrations`].
    /// - `allowed`: which demonstrations may be known, by their places.
    ///
    /// # Errors
    /// [`PredictError::NoDemonstrations`] if one cannot be laid on the other.
    pub fn practice(
        &self,
        at: usize,
        from: usize,
        allowed: impl Fn(usize) -> bool,
    ) -> Result<Problem, PredictError> {
        let (observation, hands) =
            (self.demonstrations[at].observation(), self.demonstrations[at].contact().hands);
        let alignment = self.align_to(&observation, Some(hands), |other| other == from)?;
        let gap = self.mean_gap_of(hands, allowed);
        Ok(Problem::new(&observation, &alignment, self.shapes(), Some(gap), &self.settings))
    }

    /// The demonstrations retargeted as they are: no gap is held at contact.
    ///
    /// - `hands`: the hands that meet.
    ///
    /// # Errors
    /// As [`Self::align_to`].
    pub fn plain_problem(
        &self,
        observation: &Observation,
        hands: Hands,
    ) -> Result<Problem, PredictError> {
        let alignment = self.align_to(observation, Some(hands), |_| true)?;
        Ok(Problem::new(observation, &alignment, self.shapes(), None, &self.settings))
    }

    /// The robot's joints by a method that needs no alignment, at each frame from the past alone:
    /// `[m]`, `frames × joints`. `None` of methods that need one.
    pub fn predict_causally(
        &self,
        method: Method,
        observation: &Observation,
    ) -> Option<Vec<Point>> {
        match method {
            Method::Hold => Some(hold(observation)),
            Method::Ridge => Some(self.ridge.predict_causally(observation)),
            _ => None,
        }
    }

    /// The robot's joints by one method: `[m]`, `frames × joints`.
    ///
    /// # Errors
    /// [`PredictError::Mesh`], [`PredictError::Retarget`] of the mesh methods.
    pub fn predict(
        &self,
        method: Method,
        observation: &Observation,
        alignment: &Alignment,
    ) -> Result<Vec<Point>, PredictError> {
        Ok(match method {
            Method::Hold => hold(observation),
            Method::Replay => alignment.all[alignment.nearest[0].0].robot.clone(),
            Method::Knn => alignment.mean_robot(),
            Method::Ridge => self.ridge.predict(observation),
            Method::Promp => promp::predict(observation, alignment, &self.settings),
            Method::Attach => {
                let gap = self.mean_gap(alignment.hands);
                attach::predict(observation, alignment, gap, self.settings.attach_fade)
            }
            Method::None => {
                let shapes = self.shapes();
                let problem = Problem::new(observation, alignment, shapes, None, &self.settings);
                let no_edges = LearnedEdges::none(alignment.hands);
                problem.solve(&no_edges, observation, &self.settings)?
            }
            Method::Mesh => {
                let problem = self.problem(observation, alignment);
                problem.solve(&self.edges, observation, &self.settings)?
            }
        })
    }
}

/// The first pose, moved along with the base.
fn hold(observation: &Observation) -> Vec<Point> {
    let start = observation.first_pose[observation.robot_base.index()];
    let frames = observation.base.iter().map(|base| base - start);
    frames.flat_map(|shift| observation.first_pose.iter().map(move |p| p + shift)).collect()
}

fn check_same(
    demonstration: &Demonstration,
    observation: &Observation,
) -> Result<(), PredictError> {
    let name = || demonstration.recording().name().to_owned();
    if demonstration.robot_role() != observation.robot_role {
        return Err(PredictError::Role { demonstration: name() });
    }
    let (role, recording) = (demonstration.robot_role(), demonstration.recording());
    let person = |role| recording.person(role).name.as_str();
    let different = joint_differences([
        (person(role), &observation.robot_skeleton, demonstration.robot().skeleton()),
        (
            person(role.partner()),
            observation.partner.skeleton(),
            demonstration.partner().skeleton(),
        ),
    ]);
    match different {
        None => Ok(()),
        Some(difference) => Err(PredictError::Skeleton { demonstration: name(), difference }),
    }
}
