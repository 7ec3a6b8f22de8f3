//! What the robot knows: handovers made up from another seed, seen by the same kind of sensor.

use std::sync::Arc;

use handover_mesh::demonstration::{Demonstration, DemonstrationError, Hands};
use handover_mesh::mesh::{Edge, Pair};
use handover_mesh::online::{OnlineError, OnlineModel, Pipeline};
use handover_mesh::predict::{EdgesError, LearnedEdge, LearnedEdges, PredictError, Predictor};
use handover_mesh::{Config, Part, Role, Side, Skeleton, Vector};

use super::Stage;
use super::stage::ROBOT;
use crate::check::Violations;
use crate::scene::GIVER;
use crate::sensor::{Sensor, SensorConfig};
use crate::{GenerateError, generate};

/// Why nothing could be learned.
#[derive(Debug, thiserror::Error)]
pub enum LearnError {
    /// The sensor's parameters.
    #[error(transparent)]
    Sensor(#[from] Violations),
    /// A handover could not be made.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// A handover demonstrates nothing.
    #[error(transparent)]
    Demonstration(#[from] DemonstrationError),
    /// The demonstrations do not fit together.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// The edge is none.
    #[error(transparent)]
    Edges(#[from] EdgesError),
    /// They cannot be followed tick by tick, or not by this robot.
    #[error(transparent)]
    Online(#[from] OnlineError),
}

/// What was learned once, for all trials: a robot in the giver's role.
#[derive(Debug, Clone)]
pub struct Learnt {
    model: Arc<OnlineModel>,
}

impl Learnt {
    /// The seed of the handovers learned from; scenarios take others.
    pub const SEED: u64 = 1_000_003;

    /// How many handovers are learned from, if nothing else is said.
    pub const DEMONSTRATIONS: u64 = 12;

    /// Learns from so many made-up handovers: their motions, and the one edge between the people
    /// that learning always ends with, that of the hands that meet.
    ///
    /// - `config`: the product's parameters; those of the tick and of predictions count.
    ///
    /// # Errors
    /// [`LearnError`]: none for two demonstrations or more.
    pub fn new(demonstrations: u64, config: &Config) -> Result<Self, LearnError> {
        let sensor = Sensor::new(SensorConfig::kinect(30.0))?;
        let clip = |index: u64| -> Result<Arc<Demonstration>, LearnError> {
            let name = format!("demonstration_{index}");
            let measured = generate(Self::SEED, index, &name, &sensor)?.view.measured;
            Ok(Arc::new(Demonstration::new(Arc::new(measured), GIVER, &config.base_joint)?))
        };
        let clips = (0..demonstrations).map(clip).collect::<Result<_, _>>()?;
        let predictor = Predictor::fit(clips, config.predict.clone())?;
        let predictor = predictor.with_edges(hands_edge()?);
        Ok(Self { model: Arc::new(OnlineModel::new(&predictor, config.online.clone())?) })
    }

    /// The mean gap of the demonstrations `[m]`: the robot's hand minus the partner's, in the
    /// partner's heading frame.
    pub fn mean_gap(&self, hands: Hands) -> Vector {
        self.model.gap(hands)
    }

    /// How near the partner's head, neck and torso the gate lets the robot `[m]`.
    pub fn separation(&self) -> f64 {
        self.model.settings().safety.separation
    }

    /// The product's tick, for the robot of a stage.
    ///
    /// # Errors
    /// [`LearnError::Online`].
    pub fn pipeline(&self, stage: &Stage) -> Result<Pipeline, LearnError> {
        let place = |joint: handover_mesh::JointId| stage.rest()[joint.index()];
        let bones = stage.skeleton().bones();
        let lengths: Vec<f64> =
            bones.map(|bone| (place(bone.child) - place(bone.parent)).norm()).collect();
        Ok(Pipeline::new(Arc::clone(&self.model), &lengths, true)?)
    }
}

/// Right hand to right hand; other hands exchange the sides.
fn hands_edge() -> Result<LearnedEdges, EdgesError> {
    let skeleton = Skeleton::nite();
    let pair = Pair::new([Arc::clone(&skeleton), Arc::clone(&skeleton)]);
    let hands = Hands { robot: Side::Right, partner: Side::Right };
    let hand = skeleton.part(Part::Hand(Side::Right)).unwrap_or_else(|| skeleton.root());
    let ends = [ROBOT, ROBOT.partner()].map(|role: Role| pair.vertex(role, hand));
    let edge = LearnedEdge { edge: Edge::new(ends[0], ends[1]), factors: vec![1.0] };
    LearnedEdges::new(&pair, hands, 1, vec![edge])
}
