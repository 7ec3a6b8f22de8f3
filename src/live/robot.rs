//! The robot: where it is, as far as it has said, and its pipeline, once it has said all.

use std::sync::Arc;

use crate::geometry::Point;
use crate::online::{OnlineError, OnlineModel, Pipeline, Tick, TickInput};
use crate::skeleton::Skeleton;
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
    /// Whether the pose is what the robot says, or what it was told.
    is_reported: bool,
}

impl Robot {
    /// One that is still to say where it is.
    pub(super) fn unknown(model: &Arc<OnlineModel>, edges: bool) -> Self {
        let model = model.clone();
        Self { model, edges, pipeline: None, pose: Vec::new(), is_reported: true }
    }

    /// One that is where it is said to be, and from then on where it is told to be.
    ///
    /// # Errors
    /// [`OnlineError`] on bones out of range.
    pub(super) fn at(
        model: &Arc<OnlineModel>,
        edges: bool,
        pose: Vec<Point>,
        bone_lengths: &[f64],
    ) -> Result<Self, OnlineError> {
        let pipeline = Some(Self::pipeline(model, bone_lengths, edges)?);
        Ok(Self { model: model.clone(), edges, pipeline, pose, is_reported: false })
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
        place: impl Fn(&str) -> Option<Point>,
    ) -> Result<(), ReportError> {
        let skeleton: Arc<Skeleton> = self.model.library().skeleton(Who::Robot).clone();
        if self.pose.is_empty() {
            let missing = skeleton.names().iter().filter(|name| place(name).is_none());
            let missing: Vec<String> = missing.cloned().collect();
            if !missing.is_empty() {
                return Err(ReportError::Missing(missing));
            }
        }
        let mut pose = self.pose.clone();
        pose.resize(skeleton.len(), Point::origin());
        for (joint, known) in skeleton.joints().zip(&mut pose) {
            if let Some(place) = place(skeleton.name(joint)) {
                *known = place;
            }
        }
        if self.pipeline.is_none() {
            let place = |joint: crate::skeleton::JointId| pose[joint.index()];
            let bones =
                skeleton.bones().map(|bone| (place(bone.child) - place(bone.parent)).norm());
            let lengths: Vec<f64> = bones.collect();
            self.pipeline = Some(Self::pipeline(&self.model, &lengths, self.edges)?);
        }
        self.pose = pose;
        Ok(())
    }

    /// What comes next is a new interaction: who reports, has to do so again.
    pub(super) fn reset(&mut self) {
        if let Some(pipeline) = &mut self.pipeline {
            pipeline.reset();
        }
        if self.is_reported {
            self.pose.clear();
        }
    }

    /// A tick of a robot whose bones are known; none before they are.
    ///
    /// - `input`: without the robot.
    pub(super) fn tick(&mut self, input: &TickInput<'_>) -> Option<Tick<'_>> {
        let Self { pipeline, pose, is_reported, .. } = self;
        let robot = Some(pose.as_slice()).filter(|pose| !pose.is_empty());
        let tick = pipeline.as_mut()?.tick(&TickInput { robot, ..*input });
        if let Some(target) = tick.target.filter(|_| !*is_reported) {
            pose.copy_from_slice(target.positions());
        }
        Some(tick)
    }
}
