//! What ticks have in common: immutable, shared between threads.

use std::sync::Arc;

use super::OnlineSettings;
use crate::blend::Apart;
use crate::demonstration::Hands;
use crate::forecast::{ForecastError, Forecaster};
use crate::geometry::Vector;
use crate::mesh::{MeshError, Pair, Vertex};
use crate::predict::{LearnedEdges, PredictSettings, Predictor, Shapes};
use crate::retarget::RetargetError;
use crate::safety::SafetyError;
use crate::settings::OutOfBounds;
use crate::skeleton::{JointId, Role, Sequence};
use crate::track::{Library, LibraryError, Who};

/// Why there is no online model.
#[derive(Debug, thiserror::Error, Clone, PartialEq)]
pub enum OnlineError {
    /// The demonstrations cannot be followed.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// The partner cannot be forecast.
    #[error("the partner cannot be forecast: {0}")]
    Forecast(#[from] ForecastError),
    /// The demonstrations make no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A setting is out of range.
    #[error(transparent)]
    Settings(#[from] OutOfBounds),
    /// A limit is out of range, or a bone has no length.
    #[error(transparent)]
    Safety(#[from] SafetyError),
    /// The mesh cannot be solved.
    #[error(transparent)]
    Retarget(#[from] RetargetError),
}

/// Demonstrations to follow, edges to keep, a partner to forecast.
#[derive(Debug, Clone)]
pub struct OnlineModel {
    pub(super) library: Library,
    pub(super) forecaster: Forecaster,
    pub(super) edges: LearnedEdges,
    pub(super) pair: Arc<Pair>,
    pub(super) robot: Role,
    pub(super) predict: PredictSettings,
    pub(super) settings: OnlineSettings,
    /// Per pair of hands, by [`Hands::index`].
    gaps: [Vector; 4],
    /// Where the reference is a blend: what the demonstrations are shapes of, and each frame of the
    /// grid of each taken apart.
    pub(super) shapes: Option<(Shapes, Vec<Vec<Apart>>)>,
}

impl OnlineModel {
    /// Makes ready for ticks what was learned.
    ///
    /// # Errors
    /// [`OnlineError`]: settings out of bounds, demonstrations too short to be forecast from or too
    /// long to be followed, or all alike.
    pub fn new(predictor: &Predictor, settings: OnlineSettings) -> Result<Self, OnlineError> {
        settings.check()?;
        let demonstrations = predictor.demonstrations();
        let library = Library::new(demonstrations, settings.track.clone())?;
        let motions: Vec<(&Sequence, u32)> =
            demonstrations.iter().map(|d| d.partner()).zip(0..).collect();
        let root = demonstrations[0].partner_base();
        let forecaster = Forecaster::fit(&motions, root, settings.forecast.clone())?;
        let mut gaps = [Vector::zeros(); 4];
        for hands in Hands::all() {
            gaps[hands.index()] = predictor.mean_gap(hands);
        }
        let shapes = predictor.shapes().map(|shapes| (shapes.clone(), apart(&library, shapes)));
        Ok(Self {
            shapes,
            library,
            forecaster,
            edges: predictor.edges().clone(),
            pair: Arc::new(Pair::of(demonstrations[0].recording())),
            robot: demonstrations[0].robot_role(),
            predict: predictor.settings().clone(),
            settings,
            gaps,
        })
    }

    /// The demonstrations on their grid.
    pub fn library(&self) -> &Library {
        &self.library
    }

    /// The mean gap of the demonstrations in which these hands met `[m]`: robot's hand minus
    /// partner's, in the partner's heading frame.
    pub fn gap(&self, hands: Hands) -> Vector {
        self.gaps[hands.index()]
    }

    /// The edges between the people where these hands are active: robot's joint, partner's joint.
    pub fn edges_for(&self, hands: Hands) -> impl Iterator<Item = [JointId; 2]> + '_ {
        let learned = self.edges.for_hands(&self.pair, self.robot, hands);
        let joint = |role: Role, vertex: Vertex| {
            let mut joints = self.pair.skeleton(role).joints();
            joints.find(|joint| self.pair.vertex(role, *joint) == vertex)
        };
        let ends = learned.edges().iter().map(|edge| edge.edge.ends()).collect::<Vec<_>>();
        ends.into_iter().filter_map(move |[a, b]| {
            let own = joint(self.robot, a).or_else(|| joint(self.robot, b))?;
            let other = self.robot.partner();
            Some([own, joint(other, a).or_else(|| joint(other, b))?])
        })
    }

    /// How demonstrations become predictions.
    pub fn predict_settings(&self) -> &PredictSettings {
        &self.predict
    }

    /// How the tick is done.
    pub fn settings(&self) -> &OnlineSettings {
        &self.settings
    }
}

/// All frames of all demonstrations taken apart.
fn apart(library: &Library, shapes: &Shapes) -> Vec<Vec<Apart>> {
    let exemplars = library.exemplars().iter().enumerate();
    let exemplars = exemplars.map(|(at, exemplar)| {
        let frames = (0..exemplar.len()).map(|frame| {
            let [robot, partner] = [Who::Robot, Who::Partner].map(|who| {
                let pose = library.pose(at, who, frame as f64);
                library.skeleton(who).joints().map(|joint| pose.position(joint)).collect::<Vec<_>>()
            });
            let between = between(library, at, frame as f64);
            shapes.apart(shapes.turn(at), between, &robot, &partner)
        });
        frames.collect()
    });
    exemplars.collect()
}

/// From the partner's base to the robot's in a demonstration `[m]`, as it was recorded.
pub(super) fn between(library: &Library, exemplar: usize, frame: f64) -> Vector {
    let [robot, partner] = [Who::Robot, Who::Partner]
        .map(|who| library.position(exemplar, who, frame, library.base(who)));
    robot - partner
}
