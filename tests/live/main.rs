//! The live robot from outside: bodies in, messages out, without ROS.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

#[allow(dead_code, reason = "shared with tests and benches that use other parts")]
#[path = "../common/handovers.rs"]
mod handovers;
mod hostile;
mod meeting;

use std::sync::{Arc, OnceLock};

use handover_mesh::bodies::Body;
use handover_mesh::live::{Inputs, Live};
use handover_mesh::messages::MultiDofTrajectory;
use handover_mesh::online::{OnlineModel, OnlineSettings};
use handover_mesh::retarget::Transform;
use handover_mesh::{NodeSettings, Point, Skeleton, Stamp};

/// Stamps count from here, as clocks on robots do.
const EPOCH: i64 = 1_750_000_000_000_000_000;

/// Six handovers, learned once for all tests.
fn model() -> Arc<OnlineModel> {
    static MODEL: OnceLock<Arc<OnlineModel>> = OnceLock::new();
    let made = || {
        handovers::model(handovers::demonstrations(6), Transform::None, OnlineSettings::default())
    };
    MODEL.get_or_init(made).clone()
}

fn live(node: NodeSettings) -> Live {
    Live::new(model(), node).unwrap()
}

/// Joints in the skeleton's order, as somebody says them.
fn body(stamp: Stamp, id: Option<u32>, places: &[Point]) -> Body {
    let names = Skeleton::nite();
    let joints = names.names().iter().cloned().zip(places.iter().copied()).collect();
    Body { stamp, frame: "world".to_owned(), id, joints }
}

/// One body is seen, and the robot says where it is.
fn inputs(partner: Option<Body>, robot: Body) -> Inputs {
    Inputs { bodies: partner.into_iter().collect(), robot: Some(robot), ..Inputs::default() }
}

/// Where a trajectory's joints are to be at its start `[m]`.
fn first(trajectory: &MultiDofTrajectory) -> Vec<Point> {
    trajectory.points[0].transforms.iter().map(|place| place.translation.into()).collect()
}
