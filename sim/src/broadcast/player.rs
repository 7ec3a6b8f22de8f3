//! The time → what is due.

use handover_mesh::bodies::{Body, to_joint_state, to_markers, to_transforms};
use handover_mesh::formats::bag::ROBOT;
use handover_mesh::messages::{Clock, Header, Pose, PoseStamped, Time};
use handover_mesh::{Frame, Point, Role, Skeleton, Span, Stamp};

use super::source::Take;
use super::{Outgoing, Settings, Source};
use crate::check::Violations;
use crate::scene::RecordError;

/// Time that goes on by more than this, or back, was set: nothing is made up for it.
const LONGEST_STEP: Span = Span(1_000_000_000);
/// Simulated time starts here where a recording starts earlier: 0 means that nobody knows the time.
const EARLIEST: Stamp = Stamp(1_000_000_000);
/// At least this is between the end and the next beginning, however short the recording.
const SHORTEST_PAUSE: Span = Span(1_000_000);

/// Why nothing can be played.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BroadcastError {
    /// Nobody is called so.
    #[error("role is {name:?}, must be {} or {}", .names[0], .names[1])]
    Role {
        /// Whom the robot should stand in for.
        name: String,
        /// Who there is.
        names: [String; 2],
    },
    /// A scene drawn out of range, or a sensor that is.
    #[error(transparent)]
    Scene(#[from] Violations),
    /// What a sensor made of it is no recording.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Plays a source by whatever clock it is told.
///
/// ```
/// use handover_mesh::Stamp;
/// use handover_sim::broadcast::{Outgoing, Player, Settings, Source};
/// let settings = Settings { start_delay: handover_mesh::Span(0), ..Settings::default() };
/// let mut player = Player::new(Source::generated(1)?, settings)?;
/// let sent = player.advance(Stamp(5_000_000_000));
/// let skeleton = sent.iter().find_map(|sent| match sent {
///     Outgoing::Skeleton(skeleton) => Some(skeleton),
///     _ => None,
/// });
/// let skeleton = skeleton.unwrap();
/// assert_eq!((skeleton.joint_names.len(), skeleton.header.stamp.sec), (15, 5));
/// # Ok::<(), handover_sim::broadcast::BroadcastError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Player {
    source: Source,
    settings: Settings,
    role: Role,
    /// When it was asked last, and what time that was to those who hear it.
    last: Option<(Stamp, Stamp)>,
    take: Take,
    repetition: u64,
    phase: Phase,
}

/// What it is doing; instants are those that stamps are in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Waiting for the time to begin.
    Waiting { until: Option<Stamp> },
    /// At `since` it was `from` after the first frame; `next` is the next frame of the truth.
    Playing { since: Stamp, from: Span, next: usize },
    /// Done.
    Over { at: Stamp },
}

impl Player {
    /// Waits for the first call of [`Self::advance`], and from then on for the start.
    ///
    /// # Errors
    /// [`BroadcastError`].
    pub fn new(source: Source, settings: Settings) -> Result<Self, BroadcastError> {
        let role = match &settings.role {
            Some(name) => source.role(name)?,
            None => source.role(ROBOT).unwrap_or(Role::First),
        };
        let take = source.take(&settings, 0)?;
        let phase = Phase::Waiting { until: None };
        Ok(Self { source, settings, role, last: None, take, repetition: 0, phase })
    }

    /// How it is played.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What the two are called in what is played: whom the robot stands in for, its partner.
    pub fn names(&self) -> [&str; 2] {
        [self.role, self.role.partner()].map(|role| self.take.truth.person(role).name.as_str())
    }

    /// Whether all has been played and nothing more comes.
    pub fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over { .. })
    }

    /// Plays on with other speed, sensor, paused or looped or not; of other settings these alone are
    /// taken. The time is that of the last [`Self::advance`].
    ///
    /// Another sensor sees this repetition anew, from now on.
    ///
    /// # Errors
    /// [`BroadcastError`] if the sensor is out of its ranges; then nothing has changed.
    pub fn change(&mut self, settings: &Settings) -> Result<(), BroadcastError> {
        let mut changed = self.settings.clone();
        changed.sensor.clone_from(&settings.sensor);
        changed.speed = settings.speed;
        changed.is_paused = settings.is_paused;
        changed.is_looped = settings.is_looped;
        let retaken = if changed.sensor == self.settings.sensor {
            None
        } else {
            Some(self.source.take(&changed, self.repetition)?)
        };
        if let (Phase::Playing { since, from, next }, Some((_, now))) = (&mut self.phase, self.last)
        {
            let elapsed = scaled(now - *since, self.settings.timeline_speed());
            (*since, *from) = (now, Span(from.0.saturating_add(elapsed.0)));
            if let Some(take) = &retaken {
                // Its instants may be others; what has been is not sent again.
                let first = first_stamp(take);
                *next = take.truth.stamps().take_while(|stamp| *stamp - first <= *from).count();
            }
        }
        if let Some(take) = retaken {
            self.take = take;
        }
        self.settings = changed;
        Ok(())
    }

    /// What is due while nothing may begin yet: with a clock of our own the time, which stands still
    /// at its start until [`Self::advance`] is called. Whoever waits for the time before listening
    /// would else be waited for in vain.
    ///
    /// - `now`: as of [`Self::advance`].
    pub fn stand_by(&mut self, now: Stamp) -> Option<Outgoing> {
        self.settings.has_clock.then(|| {
            let start = self.start();
            self.last = Some((now, start));
            Outgoing::Clock(Clock { clock: Time::of(start) })
        })
    }

    /// All that has become due until `now`, in order, each message with its own stamp.
    ///
    /// - `now`: of the clock that stamps are in, e.g. since 1970; with a clock of our own, of any
    ///   clock that goes on.
    ///
    /// A clock that goes back, or on by more than a second, has been set: playing goes on where it
    /// was.
    pub fn advance(&mut self, now: Stamp) -> Vec<Outgoing> {
        let mut sent = Vec::new();
        let now = self.time(now);
        loop {
            match self.phase {
                Phase::Waiting { until: None } => {
                    self.phase = Phase::Waiting { until: Some(now + self.settings.start_delay) };
                    sent.push(Outgoing::Finished(false));
                }
                Phase::Waiting { until: Some(until) }
                    if until <= now && !self.settings.is_paused =>
                {
                    self.phase = Phase::Playing { since: until, from: Span(0), next: 0 };
                }
                Phase::Playing { since, from, next } if next < self.take.truth.len() => {
                    let due = self.due(since, from, next);
                    if due > now || self.settings.is_paused {
                        break;
                    }
                    self.frame(next, due, &mut sent);
                    self.phase = Phase::Playing { since, from, next: next + 1 };
                }
                Phase::Playing { since, from, next } => {
                    let end = self.due(since, from, next.saturating_sub(1));
                    if self.settings.is_looped {
                        self.repeat(end);
                    } else {
                        self.phase = Phase::Over { at: end };
                        sent.push(Outgoing::Finished(true));
                    }
                }
                // Somebody wants more after all.
                Phase::Over { at } if self.settings.is_looped => {
                    self.repeat(at);
                    sent.push(Outgoing::Finished(false));
                    if let Phase::Waiting { until: Some(until) } = &mut self.phase {
                        *until = (*until).max(now);
                    }
                }
                Phase::Waiting { .. } | Phase::Over { .. } => break,
            }
        }
        if self.settings.has_clock {
            sent.push(Outgoing::Clock(Clock { clock: Time::of(now) }));
        }
        sent
    }

    /// How long it is until something is due, by the clock that [`Self::advance`] is told; none while
    /// nothing will be.
    pub fn wait(&self) -> Option<Span> {
        let (_, now) = self.last?;
        let due = match self.phase {
            Phase::Waiting { until } => until?,
            Phase::Playing { since, from, next } => self.due(since, from, next),
            Phase::Over { .. } => return None,
        };
        let left = due - now;
        let speed = if self.settings.has_clock { self.settings.speed } else { 1.0 };
        (!self.settings.is_paused).then(|| scaled(left, 1.0 / speed))
    }

    /// The time that stamps are in. A pause, and a clock that was set, move all that is to come.
    fn time(&mut self, now: Stamp) -> Stamp {
        let settings = &self.settings;
        let Some((asked, time)) = self.last else {
            let time = if settings.has_clock { self.start() } else { now };
            self.last = Some((now, time));
            return time;
        };
        let elapsed = now - asked;
        let is_set = elapsed < Span(0) || elapsed > LONGEST_STEP;
        let time = if settings.has_clock {
            let runs = !is_set && !settings.is_paused;
            let elapsed = if runs { scaled(elapsed, settings.speed) } else { Span(0) };
            time + elapsed
        } else {
            if is_set || settings.is_paused {
                self.shift(elapsed);
            }
            now
        };
        self.last = Some((now, time));
        time
    }

    /// Where simulated time starts.
    fn start(&self) -> Stamp {
        let own = self.source.first_stamp().max(EARLIEST);
        self.settings.clock_start.map_or(own, |start| Stamp(0) + start)
    }

    fn shift(&mut self, by: Span) {
        match &mut self.phase {
            Phase::Waiting { until } => *until = until.map(|until| until + by),
            Phase::Playing { since, .. } => *since = *since + by,
            Phase::Over { at } => *at = *at + by,
        }
    }

    /// When a frame is due; the one after the last is when the last is.
    fn due(&self, since: Stamp, from: Span, frame: usize) -> Stamp {
        let stamps = &self.take.truth;
        let at = frame.min(stamps.len() - 1);
        let played = stamps.person(self.role).motion.frames()[at].stamp - first_stamp(&self.take);
        let left = Span(played.0.saturating_sub(from.0));
        since + scaled(left, 1.0 / self.settings.timeline_speed())
    }

    /// Waits for the next time through.
    fn repeat(&mut self, end: Stamp) {
        self.repetition += 1;
        // What could be seen once can be seen again; were it not so, it is seen as before.
        if let Ok(take) = self.source.take(&self.settings, self.repetition) {
            self.take = take;
        }
        self.phase = Phase::Waiting { until: Some(end + self.settings.pause.max(SHORTEST_PAUSE)) };
    }

    /// The messages of one frame, stamped with when it is due.
    fn frame(&self, at: usize, due: Stamp, sent: &mut Vec<Outgoing>) {
        let settings = &self.settings;
        let Take { truth, measured } = &self.take;
        let robot = &truth.person(self.role).motion;
        let stamp = robot.frames()[at].stamp;
        if settings.has_clock {
            sent.push(Outgoing::Clock(Clock { clock: Time::of(due) }));
        }
        if settings.sends_robot {
            let body =
                self.body(due, robot.skeleton(), &stood(robot.frames(), at, robot.skeleton()));
            sent.push(Outgoing::RobotSkeleton(to_joint_state(&body)));
        }
        let object = measured.object().filter(|_| settings.sends_object);
        // A pose says where one point is: the first.
        let place = object.and_then(|object| object.points.first()?.place(stamp));
        if let Some(place) = place {
            let header = Header { stamp: Time::of(due), frame_id: settings.world_frame.clone() };
            let pose = Pose { position: place.into(), ..Pose::default() };
            sent.push(Outgoing::ObjectPose(PoseStamped { header, pose }));
        }
        let partner = &measured.person(self.role.partner()).motion;
        let Ok(seen) = partner.frames().binary_search_by_key(&stamp, |frame| frame.stamp) else {
            return; // The sensor lost it.
        };
        let body = self.body(due, partner.skeleton(), &partner.frames()[seen].positions);
        if settings.sends_skeleton {
            sent.push(Outgoing::Skeleton(to_joint_state(&body)));
        }
        if settings.sends_transforms {
            sent.push(Outgoing::Transforms(to_transforms(&body)));
        }
        if settings.sends_markers {
            sent.push(Outgoing::Markers(to_markers(&body)));
        }
    }

    fn body(&self, stamp: Stamp, skeleton: &Skeleton, places: &[Point]) -> Body {
        Body {
            stamp,
            frame: self.settings.world_frame.clone(),
            id: Some(self.settings.body),
            joints: skeleton.names().iter().cloned().zip(places.iter().copied()).collect(),
        }
    }
}

impl Settings {
    /// How fast frames follow each other by their stamps: simulated time goes faster itself.
    fn timeline_speed(&self) -> f64 {
        if self.has_clock { 1.0 } else { self.speed }
    }
}

/// The robot as a replay has it: the pose of the first frame, shifted to where the base of the
/// person in its role is now.
fn stood(frames: &[Frame], at: usize, skeleton: &Skeleton) -> Vec<Point> {
    let base = skeleton.root().index();
    let shift = frames[at].positions[base] - frames[0].positions[base];
    frames[0].positions.iter().map(|place| place + shift).collect()
}

fn first_stamp(take: &Take) -> Stamp {
    // A recording has a frame.
    take.truth.stamps().next().unwrap_or_default()
}

/// To the nanosecond; exact where the factor is 1.
fn scaled(span: Span, factor: f64) -> Span {
    if factor == 1.0 { span } else { Span((span.0 as f64 * factor).round() as i64) }
}
