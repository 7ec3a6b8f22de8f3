//! One recording put to the methods: each sees the partner, the figures see the truth.

use super::{Figures, Scene};
use crate::demonstration::{Demonstration, Observation};
use crate::geometry::Point;
use crate::learn::LearnError;
use crate::predict::{Alignment, Method, PredictError, Predictor};
use crate::skeleton::{JointId, Skeleton};

/// A joint to be ignored that nobody has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("evaluate.ignored_joints: the robot's role has no joint '{name}', only {}", known.join(" "))]
pub struct UnknownJoint {
    /// The name.
    pub name: String,
    /// The names there are.
    pub known: Vec<String>,
}

impl UnknownJoint {
    /// The joints of these names.
    ///
    /// # Errors
    /// The first name that the skeleton lacks.
    pub(super) fn find(skeleton: &Skeleton, names: &[String]) -> Result<Vec<JointId>, Self> {
        let find = |name: &String| {
            let known = || skeleton.names().to_vec();
            skeleton.joint(name).ok_or_else(|| Self { name: name.clone(), known: known() })
        };
        names.iter().map(find).collect()
    }
}

/// Why a recording could not be put to a method.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrialError {
    /// A joint to be ignored does not exist.
    #[error(transparent)]
    Joint(#[from] UnknownJoint),
    /// The method failed.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// No edges could be learned.
    #[error("learning: {0}")]
    Learn(#[from] LearnError),
}

/// A recording, seen and aligned once for all methods.
#[derive(Debug, Clone)]
pub struct Trial<'a> {
    predictor: &'a Predictor,
    observation: Observation,
    alignment: Alignment,
    scene: Option<Scene<'a>>,
    truth: &'a Demonstration,
    ignored: Vec<JointId>,
}

impl<'a> Trial<'a> {
    /// - `truth`: the recording, the robot role's motion in it read by the figures only.
    /// - `ignored`: joints of the robot, by name, that no figure counts.
    ///
    /// # Errors
    /// [`TrialError`] on an unknown joint, or people unlike the demonstrations'.
    pub fn new(
        truth: &'a Demonstration,
        predictor: &'a Predictor,
        ignored: &[String],
    ) -> Result<Self, TrialError> {
        let ignored = UnknownJoint::find(truth.robot().skeleton(), ignored)?;
        let observation = predictor.observe(truth);
        let alignment = predictor.align(&observation)?;
        let gap = predictor.mean_gap(alignment.hands);
        let scene = Scene::new(truth, alignment.hands, gap, &ignored);
        Ok(Self { predictor, observation, alignment, scene, truth, ignored })
    }

    /// The robot's joints by a method (`[m]`, `frames × joints`), and how far they are off.
    ///
    /// # Errors
    /// [`PredictError`] of the method.
    pub fn run(&self, method: Method) -> Result<(Vec<Point>, Figures), PredictError> {
        let predicted = self.predictor.predict(method, &self.observation, &self.alignment)?;
        let figures = self.figures(&predicted);
        Ok((predicted, figures))
    }

    /// How far any motion of the robot's joints is off: `[m]`, `frames × joints`.
    ///
    /// # Panics
    /// If it has not one position per frame and joint.
    pub fn figures(&self, predicted: &[Point]) -> Figures {
        self.scene.as_ref().map(|scene| scene.figures(predicted)).unwrap_or_default()
    }

    /// The figures of what the human in the robot's role did, by the hands that really met: a
    /// wrong guess of the hands is no scatter of the human's.
    pub fn human(&self) -> Figures {
        let hands = self.truth.contact().hands;
        let gap = self.predictor.mean_gap(hands);
        let did = self.truth.robot().frames().iter().flat_map(|f| f.positions.iter().copied());
        Scene::new(self.truth, hands, gap, &self.ignored)
            .map(|scene| scene.figures(&did.collect::<Vec<_>>()))
            .unwrap_or_default()
    }
}
