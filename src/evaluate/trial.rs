//! One recording put to the methods: each sees the partner, the figures see the truth. The same
//! recording under a [`Condition`] has no truth, and a type of its own.

use std::sync::Arc;

use super::causal;
use super::{Condition, Figures, KnownScene, Scene};
use crate::demonstration::{Demonstration, Hands, Observation};
use crate::geometry::{Point, Vector};
use crate::learn::LearnError;
use crate::online::{OnlineError, OnlineModel};
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
    pub fn find(skeleton: &Skeleton, names: &[String]) -> Result<Vec<JointId>, Self> {
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
    /// The demonstrations' hands are not there.
    #[error("the {:?} hand of the robot's role or the {:?} one of its partner is not there", hands.robot, hands.partner)]
    NoHand {
        /// The hands that would meet.
        hands: Hands,
    },
    /// The method failed.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// The demonstrations cannot be followed tick by tick.
    #[error(transparent)]
    Online(#[from] OnlineError),
    /// No edges could be learned.
    #[error("the edges of mesh: {0} (hint: --methods leaves mesh out)")]
    Learn(#[from] LearnError),
}

/// An observation, aligned once for all methods.
#[derive(Debug, Clone)]
struct Question<'a> {
    predictor: &'a Predictor,
    /// Where methods know the past alone.
    online: Option<&'a Arc<OnlineModel>>,
    observation: Observation,
    alignment: Alignment,
}

impl<'a> Question<'a> {
    fn new(
        predictor: &'a Predictor,
        online: Option<&'a Arc<OnlineModel>>,
        observation: Observation,
    ) -> Result<Self, PredictError> {
        let alignment = predictor.align(&observation)?;
        Ok(Self { predictor, online, observation, alignment })
    }

    /// The hands that will meet, as the demonstrations have it, and their mean gap `[m]`.
    fn meeting(&self) -> (Hands, Vector) {
        let hands = self.alignment.hands;
        (hands, self.predictor.mean_gap(hands))
    }

    /// - `seen`: the observation as it was seen, not smoothed.
    fn answer(&self, method: Method, seen: &Observation) -> Result<Vec<Point>, TrialError> {
        match self.online {
            Some(model) => Ok(causal::predict(self.predictor, model, method, seen)?),
            None => Ok(self.predictor.predict(method, &self.observation, &self.alignment)?),
        }
    }
}

/// A recording, seen and aligned once for all methods.
#[derive(Debug, Clone)]
pub struct Trial<'a> {
    question: Question<'a>,
    scene: KnownScene<'a>,
    truth: &'a Demonstration,
    ignored: Vec<JointId>,
}

impl<'a> Trial<'a> {
    /// - `truth`: the recording, the robot role's motion in it read by the figures only.
    /// - `online`: where methods are to know the past alone; else they know the whole motion.
    /// - `ignored`: joints of the robot, by name, that no figure counts.
    ///
    /// # Errors
    /// [`TrialError`] on an unknown joint, or people unlike the demonstrations'.
    pub fn new(
        truth: &'a Demonstration,
        predictor: &'a Predictor,
        online: Option<&'a Arc<OnlineModel>>,
        ignored: &[String],
    ) -> Result<Self, TrialError> {
        let ignored = UnknownJoint::find(truth.robot().skeleton(), ignored)?;
        let question = Question::new(predictor, online, predictor.observe(truth))?;
        let (hands, gap) = question.meeting();
        let scene = KnownScene::new(truth, hands, gap, &ignored);
        let scene = scene.ok_or(TrialError::NoHand { hands })?;
        Ok(Self { question, scene, truth, ignored })
    }

    /// The robot's joints by a method (`[m]`, `frames × joints`), and how far they are off.
    ///
    /// # Errors
    /// [`TrialError`] of the method.
    pub fn run(&self, method: Method) -> Result<(Vec<Point>, Figures), TrialError> {
        let predicted = self.question.answer(method, self.scene.scene().observation())?;
        let figures = self.figures(&predicted);
        Ok((predicted, figures))
    }

    /// How far any motion of the robot's joints is off: `[m]`, `frames × joints`.
    ///
    /// # Panics
    /// If it has not one position per frame and joint.
    pub fn figures(&self, predicted: &[Point]) -> Figures {
        self.scene.figures(predicted)
    }

    /// The figures of what the human in the robot's role did, by the hands that really met: a
    /// wrong guess of the hands is no scatter of the human's.
    pub fn human(&self) -> Figures {
        let hands = self.truth.contact().hands;
        let gap = self.question.predictor.mean_gap(hands);
        let did = self.truth.robot().frames().iter().flat_map(|f| f.positions.iter().copied());
        KnownScene::new(self.truth, hands, gap, &self.ignored)
            .map(|scene| scene.figures(&did.collect::<Vec<_>>()))
            .unwrap_or_default()
    }

    /// The same recording under a condition: aligned anew, its hands chosen anew.
    ///
    /// Directions are taken at the true contact of this trial's hands; the moment that figures are
    /// measured at is the true contact of the condition's own.
    ///
    /// # Errors
    /// [`TrialError`] if it cannot be aligned.
    pub fn under(&self, condition: Condition) -> Result<ChangedTrial<'a>, TrialError> {
        let recorded = self.scene.scene();
        let displacement = condition.displacement(recorded.observation(), recorded.contact());
        let change = |observation| condition.apply(observation, displacement);
        // Smoothing a moved motion and moving a smoothed one are the same.
        let observation = change(self.question.observation.clone());
        let question = Question::new(self.question.predictor, self.question.online, observation)?;
        let (hands, gap) = question.meeting();
        let scene = Scene::new(self.truth, hands, gap).ok_or(TrialError::NoHand { hands })?;
        Ok(ChangedTrial { question, scene: scene.changed(change), displacement })
    }
}

/// A recording in which something is not as it was: nobody knows what a human would have done.
#[derive(Debug, Clone)]
pub struct ChangedTrial<'a> {
    question: Question<'a>,
    scene: Scene,
    displacement: Vector,
}

impl ChangedTrial<'_> {
    /// By what the partner is moved `[m]`, in the world.
    pub fn displacement(&self) -> Vector {
        self.displacement
    }

    /// What predictions are measured against.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The robot's joints by a method (`[m]`, `frames × joints`), and how far they are off; joint,
    /// hand and contact error are undefined.
    ///
    /// # Errors
    /// [`TrialError`] of the method.
    pub fn run(&self, method: Method) -> Result<(Vec<Point>, Figures), TrialError> {
        let predicted = self.question.answer(method, self.scene.observation())?;
        let figures = self.scene.figures(&predicted);
        Ok((predicted, figures))
    }
}
