//! The robot: where it is, as far as it has said, and its pipeline, once it has said all.

use std::sync::Arc;

use crate::geometry::Point;
use crate::online::{OnlineError, OnlineModel, Pipeline, Tick, TickInput};
use crate::skeleton::{Riders, Skeleton};
use crate::time::Stamp;
use crate::track::Who;

/// Why the robot's joints are not known.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum ReportError {
    /// The first report has to be whole.
    #[error("without {}", .0.join(", "))]
    Missing(Vec<String>),
    /// Its bones are none.
    #[error(transparent)]
    Online(#[from] OnlineError),
}

/// The robot.
#[derive(Debug, Clone)]
pub(super) struct Robot {
    model: Arc<OnlineModel>,
    edges: bool,
    /// Made when the first whole report has said how long the bones are.
    pipeline: Option<Pipeline>,
    /// Where the joints are `[m]` in the world: as said last, or as told last.
    pose: Vec<Point>,
    /// How what rides on the joints sits on them.
    riders: Riders,
    /// Whether the pose is what the robot says, or what it was told.
    is_reported: bool,
    /// When it was said last.
    heard: Option<Stamp>,
    /// Where it will stand if nothing more is said `[m]`, and from when on.
    standstill: Option<(Vec<Point>, Stamp)>,
}

impl Robot {
    /// What is reported holds for so long without another report, where the robot has to be known
    /// anew `[s]`.
    const FRESH: f64 = 0.2;

    /// One that is still to say where it is.
    pub(super) fn unknown(model: &Arc<OnlineModel>, edges: bool) -> Self {
        let (riders, model, pose) = (model.library().riders(Who::Robot), model.clone(), Vec::new());
        let (pipeline, heard, standstill) = (None, None, None);
        Self { model, edges, pipeline, pose, riders, is_reported: true, heard, standstill }
    }

    /// One that is to be [placed](Self::place), and from then on is where it is told to be.
    ///
    /// # Errors
    /// [`OnlineError`] on bones out of range.
    pub(super) fn told(
        model: &Arc<OnlineModel>,
        edges: bool,
        bone_lengths: &[f64],
    ) -> Result<Self, OnlineError> {
        let pipeline = Some(Self::pipeline(model, bone_lengths, edges)?);
        Ok(Self { pipeline, is_reported: false, ..Self::unknown(model, edges) })
    }

    /// Puts it somewhere: `[m]` in the world, one place for each joint; any other number is not
    /// taken, nor what a robot that reports is told.
    pub(super) fn place(&mut self, pose: &[Point]) {
        if !self.is_reported && pose.len() == self.model.library().skeleton(Who::Robot).len() {
            self.pose = pose.to_vec();
        }
    }

    /// Whether anybody has said where it is.
    pub(super) fn is_placed(&self) -> bool {
        !self.pose.is_empty()
    }

    /// How long ago it said where it is `[s]`.
    pub(super) fn age(&self, now: Stamp) -> Option<f64> {
        self.heard.map(|heard| (now - heard).seconds())
    }

    pub(super) fn standstill(&self) -> Option<(Vec<Point>, Stamp)> {
        self.standstill.clone()
    }

    /// Room for a robot of such bones.
    ///
    /// # Errors
    /// [`OnlineError`] on bones or settings out of range.
    pub(super) fn pipeline(
        model: &Arc<OnlineModel>,
        bone_lengths: &[f64],
        edges: bool,
    ) -> Result<Pipeline, OnlineError> {
        Pipeline::new(model.clone(), bone_lengths, edges)
    }

    pub(super) fn pipeline_mut(&mut self) -> Option<&mut Pipeline> {
        self.pipeline.as_mut()
    }

    /// Where the base is `[m]`, if known.
    pub(super) fn base(&self) -> Option<Point> {
        self.pose.get(self.model.library().base(Who::Robot).index()).copied()
    }

    /// Takes in what the robot says: by a joint's name its place `[m]` in the world.
    ///
    /// # Errors
    /// [`ReportError`] if the first report lacks a joint; later ones may.
    pub(super) fn report(
        &mut self,
        now: Stamp,
        place: impl Fn(&str) -> Option<Point>,
    ) -> Result<(), ReportError> {
        let skeleton: Arc<Skeleton> = self.model.library().skeleton(Who::Robot).clone();
        if self.pose.is_empty() {
            // What rides on a joint is known by the joint.
            let own = &skeleton.names()[..skeleton.own()];
            let missing = own.iter().filter(|name| place(name).is_none());
            let missing: Vec<String> = missing.cloned().collect();
            if !missing.is_empty() {
                return Err(ReportError::Missing(missing));
            }
        }
        let mut pose = self.pose.clone();
        pose.resize(skeleton.len(), Point::origin());
        for (joint, known) in skeleton.joints().zip(&mut pose[..skeleton.own()]) {
            if let Some(place) = place(skeleton.name(joint)) {
                *known = place;
            }
        }
        self.riders.place(&mut pose);
        if self.pipeline.is_none() {
            let place = |joint: crate::skeleton::JointId| pose[joint.index()];
            let bones =
                skeleton.bones().map(|bone| (place(bone.child) - place(bone.parent)).norm());
            let lengths: Vec<f64> = bones.collect();
            self.pipeline = Some(Self::pipeline(&self.model, &lengths, self.edges)?);
        }
        self.pose = pose;
        self.heard = Some(now);
        Ok(())
    }

    /// What comes next is a new interaction: who reports, has to do so again.
    pub(super) fn reset(&mut self) {
        if let Some(pipeline) = &mut self.pipeline {
            pipeline.reset();
        }
        if self.is_reported {
            self.pose.clear();
            self.heard = None;
        }
    }

    /// A tick of a robot whose bones are known; none before they are.
    ///
    /// - `input`: without the robot.
    pub(super) fn tick(&mut self, input: &TickInput<'_>) -> Option<Tick<'_>> {
        let Self { pipeline, pose, is_reported, heard, standstill, .. } = self;
        let now = input.now;
        // An old report is no place to begin at, and a base that was known stays known without it.
        let is_known = if *is_reported {
            heard.is_some_and(|heard| (now - heard).seconds().abs() <= Self::FRESH)
        } else {
            !pose.is_empty()
        };
        let robot = is_known.then_some(pose.as_slice());
        let tick = pipeline.as_mut()?.tick(&TickInput { robot, ..*input });
        if let Some(target) = tick.target {
            if !*is_reported {
                pose.copy_from_slice(target.positions());
            }
            let mut stand =
                standstill.take().map_or_else(|| target.positions().to_vec(), |(stand, _)| stand);
            target.positions_at(target.stands_in(), &mut stand);
            *standstill = Some((stand, now + target.stands_in()));
        }
        Some(tick)
    }
}
