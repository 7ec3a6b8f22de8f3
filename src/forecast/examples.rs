//! Motions → what each of their moments looked like, and where everything went from there.

use super::{ForecastSettings, Moment};
use crate::geometry::Vector;
use crate::skeleton::{JointId, Sequence};
use crate::time::Span;

/// Moments of motions: features before, displacements after.
#[derive(Debug, Clone, Default)]
pub(super) struct Examples {
    /// Numbers in a moment's features.
    pub(super) width: usize,
    /// Numbers in one horizon's displacement: three a joint.
    pub(super) joints: usize,
    /// `count × width`.
    pub(super) features: Vec<f64>,
    /// `count × horizons × joints` `[m]`, in the person's frame at the moment; 0 beyond
    /// [`Self::reach`].
    pub(super) displacements: Vec<f64>,
    /// Per moment, how many of the horizons its motion reaches.
    pub(super) reach: Vec<u32>,
    /// Per moment, whose it is: moments of one group are held out together.
    pub(super) group: Vec<u32>,
}

impl Examples {
    pub(super) fn new(joints: usize) -> Self {
        Self { width: Moment::feature_count(joints), joints: 3 * joints, ..Self::default() }
    }

    /// The number of moments.
    pub(super) fn len(&self) -> usize {
        self.reach.len()
    }

    /// Features of a moment.
    pub(super) fn features_of(&self, moment: usize) -> &[f64] {
        &self.features[moment * self.width..][..self.width]
    }

    /// Where everything goes from a moment over one horizon.
    pub(super) fn displacement_of(&self, moment: usize, horizon: usize, horizons: usize) -> &[f64] {
        &self.displacements[(moment * horizons + horizon) * self.joints..][..self.joints]
    }

    /// Adds a motion's moments, from the first one with a velocity's past on.
    pub(super) fn add(
        &mut self,
        motion: &Sequence,
        root: JointId,
        group: u32,
        settings: &ForecastSettings,
    ) {
        let frames = motion.frames();
        let smooth = motion.smoothed(settings.smoothing);
        let (first, last) = (frames[0].stamp, frames[frames.len() - 1].stamp);
        let mut moment = Moment::new(motion.skeleton(), root);
        let mut features = vec![0.0; self.width];
        for (at, frame) in frames.iter().enumerate() {
            // A frame early is as good as in time.
            if (frame.stamp - first).seconds() < settings.velocity_window - 1e-3 {
                continue;
            }
            moment.observe(motion.skeleton(), &frames[..=at], settings.velocity_window);
            moment.features(settings.velocity_weight, &mut features);
            let turn = moment.root_from_world().rotation;
            let mut reach = 0;
            for &horizon in &settings.horizons {
                let then = Span::from_seconds(horizon).map(|span| frame.stamp + span);
                let then = then
                    .filter(|then| *then <= last)
                    .and_then(|then| smooth.resampled(&[then]).ok());
                let Some(then) = then else {
                    self.displacements.resize(self.displacements.len() + self.joints, 0.0);
                    continue;
                };
                reach += 1;
                let now = &smooth.frames()[at].positions;
                let moved = then.frames()[0].positions.iter().zip(now).take(self.joints / 3);
                let moved = moved.map(|(then, now)| -> Vector { turn * (then - now) });
                self.displacements.extend(moved.flat_map(|d| [d.x, d.y, d.z]));
            }
            self.features.extend_from_slice(&features);
            self.reach.push(reach);
            self.group.push(group);
        }
    }

    /// The moments that are, or are not, of some groups.
    pub(super) fn part(&self, keep: impl Fn(u32) -> bool) -> Self {
        let mut part = Self { width: self.width, joints: self.joints, ..Self::default() };
        let all = self.displacements.len() / self.len().max(1);
        for moment in (0..self.len()).filter(|moment| keep(self.group[*moment])) {
            part.features.extend_from_slice(self.features_of(moment));
            part.displacements.extend_from_slice(&self.displacements[moment * all..][..all]);
            part.reach.push(self.reach[moment]);
            part.group.push(self.group[moment]);
        }
        part
    }
}
