//! Where the robot's joints belong, by our mesh and by what it is compared with.
//!
//! The path of the data: demonstrations → [`Predictor::fit`]; an observation →
//! [`Predictor::align`] (each demonstration on its time and place, the nearest ones' mean) →
//! [`Predictor::predict`] by one [`Method`] → the robot's joints, frame by frame. Every method
//! gets the same alignment, so that they differ in what is their own.

mod aligned;
mod attach;
mod edges;
mod method;
mod problem;
mod promp;
mod ridge;
mod settings;
mod shapes;

pub use aligned::{Aligned, Alignment};
pub use attach::lead_hand;
pub use edges::{EdgesError, LearnedEdge, LearnedEdges, edge_for_hands, phase};
pub use method::{Method, PredictError, Predictor};
pub use problem::Problem;
pub use settings::{KnownJoints, PredictSettings, ReferenceBlend};
pub(crate) use shapes::mean_turn;
pub use shapes::{Shapes, ShapesWorkspace};
