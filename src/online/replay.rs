//! A recording, put to a pipeline by its own clock.

use super::TickInput;
use crate::demonstration::Observation;
use crate::filter::Sighting;
use crate::geometry::Point;
use crate::skeleton::Frame;
use crate::time::{Span, Stamp};

/// More ticks than this between two frames are not made: a recording may pause for hours.
const MOST_BETWEEN: i64 = 10_000;

/// The ticks of a recording: at each frame the partner is sighted as recorded there; between
/// frames that are farther apart, as many ticks without a sighting as come nearest to the rate.
///
/// What the robot says of its joints is no measurement: it is the pose of the first frame, shifted
/// at every tick to where the base of the person in its role was recorded.
#[derive(Debug, Clone)]
pub struct Replay<'a> {
    observation: &'a Observation,
    period: Span,
    robot: Vec<Point>,
    /// The next frame, and how many ticks before it are still to be made.
    frame: usize,
    before: i64,
}

impl<'a> Replay<'a> {
    /// - `tick_rate`: ticks a second `[Hz]`, > 0.
    pub fn new(observation: &'a Observation, tick_rate: f64) -> Self {
        let period = Span::from_seconds(1.0 / tick_rate).unwrap_or(Span(1)).max(Span(1));
        let robot = observation.first_pose.clone();
        Self { observation, period, robot, frame: 0, before: 0 }
    }

    /// The next tick's input, and the frame that it is of, if of one; none after the last frame.
    pub fn next_tick(&mut self) -> Option<(Option<usize>, TickInput<'_>)> {
        let frames = self.observation.partner.frames();
        let Frame { stamp, positions } = frames.get(self.frame)?;
        let base = self.observation.robot_base.index();
        let seen = if self.before == 0 { self.frame } else { self.frame - 1 };
        let moved = self.observation.base[seen] - self.robot[base];
        self.robot.iter_mut().for_each(|place| *place += moved);
        let robot = Some(self.robot.as_slice());
        if self.before > 0 {
            let now = Stamp(stamp.0 - self.before_next(*stamp));
            self.before -= 1;
            return Some((None, TickInput { now, sighting: None, robot }));
        }
        let at = self.frame;
        self.frame += 1;
        self.before = frames.get(self.frame).map_or(0, |next| self.between(*stamp, next.stamp));
        let sighting = Sighting { stamp: *stamp, body: None, positions, confidences: &[] };
        Some((Some(at), TickInput { now: *stamp, sighting: Some(sighting), robot }))
    }

    /// How long before the next frame the tick is, of those that are left evenly `[ns]`.
    fn before_next(&self, stamp: Stamp) -> i64 {
        let last = self.observation.partner.frames()[self.frame - 1].stamp;
        let all = self.between(last, stamp);
        let whole = i128::from((stamp - last).0);
        (whole * i128::from(self.before) / i128::from(all + 1)) as i64
    }

    /// Ticks between two frames.
    fn between(&self, last: Stamp, next: Stamp) -> i64 {
        let ticks = (next - last).0 as f64 / self.period.0 as f64;
        (ticks.round() as i64 - 1).clamp(0, MOST_BETWEEN)
    }
}
