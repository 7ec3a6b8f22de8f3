//! Shapes for viewers: fixed numbers, so that each replaces its last, and a lifetime, so that what is
//! no more said is no more shown.

use super::super::state::HandTarget;
use crate::geometry::Point;
use crate::messages::{Color, Duration, Header, Marker, MarkerArray, Point3, Vector3};
use crate::online::{OnlineModel, Tick};
use crate::skeleton::Skeleton;
use crate::time::Span;
use crate::track::Who;

const LIFETIME: Span = Span(500_000_000);
const PARTNER: Color = Color { r: 0.2, g: 0.5, b: 1.0, a: 1.0 };
const ROBOT: Color = Color { r: 1.0, g: 0.55, b: 0.1, a: 1.0 };
const SOLVED: Color = Color { r: 1.0, g: 0.8, b: 0.5, a: 0.4 };
const EDGE: Color = Color { r: 0.3, g: 0.8, b: 0.3, a: 0.6 };
const HAND: Color = Color { r: 0.9, g: 0.1, b: 0.3, a: 1.0 };

/// The partner as known, the robot as it is to be and as it was solved before the gate, the edges
/// between them, where the robot's hand is to be.
pub(super) fn markers(
    model: &OnlineModel,
    tick: Option<&Tick<'_>>,
    hand: Option<&HandTarget>,
    header: &Header,
) -> MarkerArray {
    let mut markers = Vec::new();
    let mut show =
        |namespace: &str, id: i32, kind: i32, width: f64, color: Color, points: Vec<Point3>| {
            if !points.is_empty() {
                markers.push(Marker {
                    header: header.clone(),
                    ns: namespace.to_owned(),
                    id,
                    kind,
                    scale: Vector3 { x: width, y: width, z: width },
                    color,
                    lifetime: Duration::of(LIFETIME),
                    points,
                    ..Marker::default()
                });
            }
        };
    let Some(tick) = tick else { return MarkerArray::default() };
    let library = model.library();
    let [own, other] = [Who::Robot, Who::Partner].map(|who| library.skeleton(who));
    let partner = tick.partner.unwrap_or_default();
    let robot = tick.target.map(|target| target.positions()).unwrap_or_default();
    show("partner", 0, Marker::SPHERE_LIST, 0.05, PARTNER, joints(partner));
    show("partner", 1, Marker::LINE_LIST, 0.02, PARTNER, bones(other, partner));
    show("robot", 2, Marker::SPHERE_LIST, 0.05, ROBOT, joints(robot));
    show("robot", 3, Marker::LINE_LIST, 0.02, ROBOT, bones(own, robot));
    if let Some(solved) = &tick.solved {
        show("solved", 4, Marker::LINE_LIST, 0.01, SOLVED, bones(own, &solved.poses[..own.len()]));
    }
    if !robot.is_empty() && !partner.is_empty() && !tick.belief.followed.is_empty() {
        let ends = model.edges_for(tick.belief.hands).flat_map(|[robot_joint, partner_joint]| {
            [robot[robot_joint.index()], partner[partner_joint.index()]].map(Point3::from)
        });
        show("edges", 5, Marker::LINE_LIST, 0.01, EDGE, ends.collect());
    }
    if let Some(hand) = hand {
        show("hand", 6, Marker::SPHERE_LIST, 0.09, HAND, vec![hand.place.into()]);
    }
    MarkerArray { markers }
}

fn joints(places: &[Point]) -> Vec<Point3> {
    places.iter().map(|place| (*place).into()).collect()
}

fn bones(skeleton: &Skeleton, places: &[Point]) -> Vec<Point3> {
    if places.is_empty() {
        return Vec::new();
    }
    let ends = skeleton.bones().flat_map(|bone| [bone.parent, bone.child]);
    ends.map(|joint| places[joint.index()].into()).collect()
}
