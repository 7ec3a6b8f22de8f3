//! One person's joints over time.

use std::sync::Arc;

use super::{JointId, Skeleton};
use crate::geometry::{Isometry, Point, is_finite};
use crate::time::Stamp;

/// One person's joints at one instant: positions `[m]` in the world, in skeleton order.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// When.
    pub stamp: Stamp,
    /// Where, one point per joint.
    pub positions: Box<[Point]>,
}

/// Frames of one skeleton: at least one, equal joint counts, finite coordinates, rising stamps.
///
/// ```
/// use handover_mesh::{Frame, Point, Sequence, Skeleton, Stamp};
/// let skeleton = Skeleton::nite();
/// let frame = |k: i64| Frame { stamp: Stamp(k), positions: vec![Point::origin(); 15].into() };
/// assert!(Sequence::new(skeleton.clone(), vec![frame(0), frame(1)]).is_ok());
/// assert!(Sequence::new(skeleton, vec![frame(1), frame(1)]).is_err());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    skeleton: Arc<Skeleton>,
    frames: Vec<Frame>,
}

/// Why some frames are no sequence; frames count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SequenceError {
    /// Nothing to hold.
    #[error("no frames")]
    Empty,
    /// A frame does not fit the skeleton.
    #[error("frame {frame} has {got} joints, the skeleton {expected}")]
    JointCount {
        /// Which frame.
        frame: usize,
        /// The skeleton's joints.
        expected: usize,
        /// The frame's joints.
        got: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("frame {frame}, joint '{joint}': position is not finite")]
    NotFinite {
        /// Which frame.
        frame: usize,
        /// Which joint.
        joint: String,
    },
    /// Time stands still or runs back.
    #[error(transparent)]
    Stamps(#[from] StampsError),
}

/// Two neighbouring stamps that do not rise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("frame {frame} at {stamp} is not after the one before it at {before}")]
pub struct StampsError {
    /// The later of the two frames, counted from 0.
    pub frame: usize,
    /// Its stamp.
    pub stamp: Stamp,
    /// The stamp it should be after.
    pub before: Stamp,
}

impl StampsError {
    /// Checks that stamps rise strictly.
    pub(super) fn check(stamps: impl Iterator<Item = Stamp>) -> Result<(), Self> {
        let mut last = None;
        for (frame, stamp) in stamps.enumerate() {
            if let Some(before) = last.replace(stamp).filter(|before| *before >= stamp) {
                return Err(Self { frame, stamp, before });
            }
        }
        Ok(())
    }
}

impl Sequence {
    /// The only way in: whoever holds a `Sequence` never checks it again.
    ///
    /// # Errors
    /// [`SequenceError`] names the first frame at fault.
    pub fn new(skeleton: Arc<Skeleton>, frames: Vec<Frame>) -> Result<Self, SequenceError> {
        if frames.is_empty() {
            return Err(SequenceError::Empty);
        }
        let expected = skeleton.len();
        for (at, frame) in frames.iter().enumerate() {
            let got = frame.positions.len();
            if got != expected {
                return Err(SequenceError::JointCount { frame: at, expected, got });
            }
            if let Some(joint) = frame.positions.iter().position(|p| !is_finite(p)) {
                let joint = skeleton.names()[joint].clone();
                return Err(SequenceError::NotFinite { frame: at, joint });
            }
        }
        StampsError::check(frames.iter().map(|frame| frame.stamp))?;
        Ok(Self { skeleton, frames })
    }

    /// The joints' names and bones.
    pub fn skeleton(&self) -> &Arc<Skeleton> {
        &self.skeleton
    }

    /// All frames, in time.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// The number of frames, at least 1.
    #[expect(clippy::len_without_is_empty, reason = "a sequence has frames")]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// All stamps, rising.
    pub fn stamps(&self) -> impl ExactSizeIterator<Item = Stamp> + '_ {
        self.frames.iter().map(|frame| frame.stamp)
    }

    /// Where `joint` is at frame `frame`: `[m]` in the world.
    ///
    /// # Panics
    /// If there is no such frame or joint: the caller's bug.
    pub fn position(&self, frame: usize, joint: JointId) -> Point {
        self.frames[frame].positions[joint.index()]
    }

    /// Every frame with its points changed by `change` (finite stays finite: the caller's duty).
    pub(crate) fn map_frames(&self, mut change: impl FnMut(usize, &mut [Point])) -> Self {
        let mut frames = self.frames.clone();
        for (at, frame) in frames.iter_mut().enumerate() {
            change(at, &mut frame.positions);
        }
        Self { skeleton: self.skeleton.clone(), frames }
    }

    /// The same motion seen from another frame: `world_from_here` applied to every point.
    pub fn transformed(&self, world_from_here: &Isometry) -> Self {
        self.map_frames(|_, points| points.iter_mut().for_each(|p| *p = world_from_here * *p))
    }

    /// The same motion at other instants, by linear interpolation; held before the first frame
    /// and after the last.
    ///
    /// # Errors
    /// [`SequenceError`] if `stamps` is empty or does not rise.
    pub fn resampled(&self, stamps: &[Stamp]) -> Result<Self, SequenceError> {
        let frames = stamps.iter().map(|&stamp| self.at(stamp)).collect();
        Self::new(self.skeleton.clone(), frames)
    }

    /// The pose at `stamp`, between the two frames around it.
    fn at(&self, stamp: Stamp) -> Frame {
        let after = self.frames.partition_point(|frame| frame.stamp < stamp);
        let before = &self.frames[after.saturating_sub(1)];
        let after = &self.frames[after.min(self.frames.len() - 1)];
        let step = (after.stamp - before.stamp).seconds();
        let part = if step > 0.0 {
            ((stamp - before.stamp).seconds() / step).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let between = before.positions.iter().zip(&after.positions);
        let positions = between.map(|(a, b)| a + (b - a) * part).collect();
        Frame { stamp, positions }
    }

    /// Median length `[m]` of each bone, in the skeleton's bone order; robust to lost tracking.
    pub fn bone_lengths(&self) -> Vec<f64> {
        let lengths = self.skeleton.bones().map(|bone| {
            let lengths = self.frames.iter().map(|frame| {
                (frame.positions[bone.child.index()] - frame.positions[bone.parent.index()]).norm()
            });
            crate::statistics::median(lengths.collect()).unwrap_or(0.0)
        });
        lengths.collect()
    }
}
