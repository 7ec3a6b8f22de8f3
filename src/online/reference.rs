//! The demonstrations followed, on the places of now: what the window's mesh is made of.
//!
//! `r_k = Σ_d w_d (Y_d (x_d(f_d + k·tempo) − base_d) + base)`: each demonstration `d` at the frame
//! where it is believed to be, turned by `Y_d` about the vertical and shifted so that the bases are
//! where the people's are. Near the moment at which the hands are to meet the robot's hand is
//! brought to the gap that the demonstrations had at theirs.

use super::OnlineModel;
use super::model::between;
use crate::blend::Apart;
use crate::geometry::{Point, Vector, yaw_isometry};
use crate::kinematics::minimum_jerk;
use crate::predict::{Shapes, ShapesWorkspace, mean_turn};
use crate::skeleton::Part;
use crate::track::{Belief, Followed, Library, Who};

/// Where the two people are over the window: the partner seen and forecast, the robot's base.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The partner's joints `[m]`, `frames × joints`, the window's past first.
    pub partner: Vec<Point>,
    /// Where the robot's base is `[m]`.
    pub robot_base: Point,
}

impl Scene {
    /// Where the partner's joints are now: `[m]`.
    pub fn now(&self, model: &OnlineModel) -> &[Point] {
        let joints = model.library.skeleton(Who::Partner).len();
        &self.partner[model.settings.past * joints..][..joints]
    }
}

/// The reference over the window: `[m]`, `frames × joints`, the window's past first.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The robot role's joints.
    pub robot: Vec<Point>,
    /// The partner's joints.
    pub partner: Vec<Point>,
    /// Room to blend, where the reference is a blend.
    workspace: Option<ShapesWorkspace>,
}

impl Reference {
    /// Room for a window.
    pub fn new(model: &OnlineModel) -> Self {
        let frames = model.settings.past + 1 + model.settings.future;
        let room = |who| vec![Point::origin(); frames * model.library.skeleton(who).len()];
        let workspace = model.shapes.as_ref().map(|(shapes, _)| shapes.workspace());
        Self { robot: room(Who::Robot), partner: room(Who::Partner), workspace }
    }

    /// Lays the demonstrations followed on where the partner and the robot's base are.
    ///
    /// Without allocation.
    pub fn fill(&mut self, model: &OnlineModel, belief: &Belief, scene: &Scene, holds_gap: bool) {
        let library = &model.library;
        let [robot_joints, partner_joints] =
            [Who::Robot, Who::Partner].map(|who| library.skeleton(who).len());
        let partner_base = library.base(Who::Partner).index();
        let rows = self.robot.chunks_exact_mut(robot_joints);
        let rows = rows.zip(self.partner.chunks_exact_mut(partner_joints));
        let seen = scene.partner.chunks_exact(partner_joints);
        for (at, ((robot, partner), seen)) in rows.zip(seen).enumerate() {
            let ahead = ahead(model, belief, at);
            mean_pose(&model.library, &belief.followed, Who::Robot, ahead, scene.robot_base, robot);
            mean_pose(
                &model.library,
                &belief.followed,
                Who::Partner,
                ahead,
                seen[partner_base],
                partner,
            );
            if let (Some((shapes, apart)), Some(workspace)) = (&model.shapes, &mut self.workspace) {
                blend(library, shapes, apart, &belief.followed, ahead, [robot, partner], workspace);
            }
            if holds_gap {
                hold_gap(model, belief, ahead, seen, robot, partner);
            }
        }
    }
}

/// How far a frame of the window is from where the demonstrations followed are believed to be, in
/// frames of theirs: those to come pass at the interaction's tempo.
pub(super) fn ahead(model: &OnlineModel, belief: &Belief, frame: usize) -> f64 {
    let ahead = frame as f64 - model.settings.past as f64;
    if ahead > 0.0 { ahead * belief.tempo } else { ahead }
}

/// The weighted mean of the demonstrations followed, `ahead` frames of the grid from where they are
/// believed to be, the base at `base`: `[m]`, one per joint, overwritten.
pub fn mean_pose(
    library: &Library,
    followed: &[Followed],
    who: Who,
    ahead: f64,
    base: Point,
    pose: &mut [Point],
) {
    pose.fill(base);
    for followed in followed {
        let there = library.pose(followed.exemplar, who, followed.frame + ahead);
        let base = there.position(library.base(who));
        for (joint, place) in library.skeleton(who).joints().zip(&mut *pose) {
            *place += followed.weight * followed.turned(there.position(joint) - base);
        }
    }
}

/// Brings the mean poses of both people to where the blend of the demonstrations followed is.
fn blend(
    library: &Library,
    shapes: &Shapes,
    apart: &[Vec<Apart>],
    followed: &[Followed],
    ahead: f64,
    [robot, partner]: [&mut [Point]; 2],
    workspace: &mut ShapesWorkspace,
) {
    let here_from_shape = mean_turn(followed.iter().map(|followed| {
        (followed.turn * shapes.turn(followed.exemplar).inverse(), followed.weight)
    }));
    let between = followed.iter().map(|followed| {
        let there = between(library, followed.exemplar, followed.frame + ahead);
        followed.weight * followed.turned(there)
    });
    let between = between.sum();
    // A pose between two frames is as much of each as it is near.
    let poses = followed.iter().flat_map(|followed| {
        let frames = &apart[followed.exemplar];
        let frame = (followed.frame + ahead).clamp(0.0, (frames.len() - 1) as f64);
        [(1.0 - frame.fract(), frame.floor()), (frame.fract(), frame.ceil())]
            .map(|(part, frame)| (part * followed.weight, &frames[frame as usize]))
    });
    shapes.blend(poses, here_from_shape, between, robot, partner, workspace);
}

/// Near the reference's contact, brings its hands to the gap that the demonstrations had at theirs.
fn hold_gap(
    model: &OnlineModel,
    belief: &Belief,
    ahead: f64,
    seen: &[Point],
    robot: &mut [Point],
    partner: &[Point],
) {
    let [robot_skeleton, partner_skeleton] =
        [Who::Robot, Who::Partner].map(|who| model.library.skeleton(who));
    let (Some(robot_hand), Some(partner_hand)) = (
        robot_skeleton.part(Part::Hand(belief.hands.robot)),
        partner_skeleton.part(Part::Hand(belief.hands.partner)),
    ) else {
        return;
    };
    let seconds = (belief.contact - ahead) * model.library.step().seconds();
    let off = (seconds.abs() - model.settings.contact_hold).max(0.0);
    let share = minimum_jerk(1.0 - off / model.predict.contact_fade);
    let world_from_heading = yaw_isometry(partner_skeleton.heading(seen), Vector::zeros());
    let gap = world_from_heading * model.gap(belief.hands);
    let goal = partner[partner_hand.index()] + gap;
    let by = (goal - robot[robot_hand.index()]) * share;
    robot_skeleton.shift_with_riders(robot_hand, by, robot);
}
