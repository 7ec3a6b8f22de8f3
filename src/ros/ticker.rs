//! The thread that ticks and publishes.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread::{self, JoinHandle, Thread};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use r2r::{Node, QosProfile};

use super::inbox::Inbox;
use super::shell::{Publisher, RosClock, now as instant};
use crate::config::NodeSettings;
use crate::geometry::Point;
use crate::live::{HandoverState, Inputs, Live, News, Outputs};
use crate::messages::{DiagnosticArray, MarkerArray, MultiDofTrajectory, PoseStamped, Text};
use crate::safety::HoldReason;
use crate::time::{Span, Stamp};

/// What the ticking thread is told.
pub(super) enum Command {
    /// Ticks with this, so often.
    Start(Box<Live>, Span),
    /// Ticks no more; says so when it does not. The next begins when the robot stands; one that only
    /// does as it is told, there.
    Stop(Sender<()>),
    /// What comes next is another robot.
    Forget,
    /// Calls the handover off.
    Cancel,
    /// Begins a new one.
    Reset,
    /// Changes what may change while it runs.
    Set(Box<NodeSettings>),
    /// Ends the thread.
    End,
}

/// Where outputs go.
pub(super) struct Publishers {
    targets: Publisher<MultiDofTrajectory>,
    hand: Publisher<PoseStamped>,
    markers: Publisher<MarkerArray>,
    state: Publisher<Text>,
    diagnostics: Publisher<DiagnosticArray>,
}

impl Publishers {
    /// # Errors
    /// If a topic cannot be published.
    pub(super) fn new(node: &mut Node) -> Result<Self> {
        let newest = QosProfile::default().keep_last(1);
        Ok(Self {
            targets: Publisher::new(node, "~/joint_targets", newest.clone())?,
            hand: Publisher::new(node, "~/hand_target", newest.clone())?,
            markers: Publisher::new(node, "~/markers", newest.clone().best_effort())?,
            state: Publisher::new(node, "~/handover_state", newest.clone().transient_local())?,
            diagnostics: Publisher::new(node, "/diagnostics", newest.keep_last(10))?,
        })
    }

    fn publish(&self, outputs: &Outputs) -> Result<()> {
        if let Some(targets) = &outputs.joint_targets {
            self.targets.publish(targets)?;
        }
        if let Some(hand) = &outputs.hand_target {
            self.hand.publish(hand)?;
        }
        self.state.publish(&outputs.state)?;
        if let Some(markers) = &outputs.markers {
            self.markers.publish(markers)?;
        }
        if let Some(diagnostics) = &outputs.diagnostics {
            self.diagnostics.publish(diagnostics)?;
        }
        Ok(())
    }
}

/// The ticking thread, as others see it.
pub(super) struct Ticker {
    commands: Sender<Command>,
    thread: Option<JoinHandle<()>>,
    handle: Thread,
}

impl Ticker {
    /// Starts the thread; it waits for a [`Command::Start`].
    ///
    /// # Errors
    /// If there is no room for a thread.
    pub(super) fn new(ticking: Ticking) -> Result<Self> {
        let (commands, receiver) = mpsc::channel();
        let thread = thread::Builder::new().name("tick".to_owned());
        let thread = thread.spawn(move || ticking.run(&receiver)).context("the ticking thread")?;
        Ok(Self { commands, handle: thread.thread().clone(), thread: Some(thread) })
    }

    /// Tells the thread.
    pub(super) fn tell(&self, command: Command) {
        // It listens as long as this is there.
        let _ = self.commands.send(command);
        self.wake();
    }

    /// Stops, and waits until nothing more is published.
    pub(super) fn stop(&self) {
        let (stopped, is_stopped) = mpsc::channel();
        self.tell(Command::Stop(stopped));
        // A thread that has died publishes nothing either.
        let _ = is_stopped.recv_timeout(Duration::from_secs(1));
    }

    /// Whether the thread has ended before it was told to: it panicked.
    pub(super) fn is_dead(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Somebody is seen.
    pub(super) fn wake(&self) {
        self.handle.unpark();
    }
}

impl Drop for Ticker {
    /// Waits for the last tick: publishers must not outlive the node.
    fn drop(&mut self) {
        self.tell(Command::End);
        if let Some(thread) = self.thread.take() {
            // A panic there was told there.
            let _ = thread.join();
        }
    }
}

/// What the thread works with.
pub(super) struct Ticking {
    pub(super) clock: RosClock,
    pub(super) inbox: Arc<Inbox>,
    pub(super) publishers: Publishers,
    pub(super) logger: String,
    /// Before the names of diagnostics.
    pub(super) node_name: String,
    /// Whether time is that of `/clock`.
    pub(super) is_simulated: bool,
}

impl Ticking {
    fn run(self, receiver: &Receiver<Command>) {
        let (mut running, mut inputs): (Option<Running>, _) = (None, Inputs::default());
        let mut standstill: Option<Standstill> = None;
        let (mut waits, mut is_warned) = (None, false);
        loop {
            while let Ok(command) = receiver.try_recv() {
                match (command, running.as_mut()) {
                    (Command::Start(mut live, period), _) => {
                        // Kept: it may be stopped again before it has ticked.
                        if let Some(standstill) = &standstill {
                            live.begin_at(&standstill.pose);
                        }
                        let brakes = standstill.as_ref().map(|standstill| standstill.brakes);
                        running = Some(Running::new(live, period, brakes));
                    }
                    (Command::Stop(stopped), _) => {
                        let stand = running.take().and_then(|running| running.live.standstill());
                        let now = self.clock.now();
                        let stand =
                            stand.map(|(pose, from)| Standstill { pose, brakes: [now, from] });
                        standstill = stand.or(standstill);
                        self.rest();
                        // Whoever asked may have given up.
                        let _ = stopped.send(());
                    }
                    // Another robot stands elsewhere, and this one may still brake.
                    (Command::Forget, _) => {
                        standstill.iter_mut().for_each(|standstill| standstill.pose.clear());
                    }
                    (Command::End, _) => return self.rest(),
                    (_, None) => {}
                    (Command::Cancel, Some(running)) => running.live.cancel(),
                    (Command::Reset, Some(running)) => running.live.reset(),
                    (Command::Set(node), Some(running)) => running.live.set(&node),
                }
            }
            let now = self.clock.now();
            let Some(running) = running.as_mut() else {
                // Frames are said once; of all else the old is of no use later.
                self.inbox.take(&mut inputs, now);
                thread::park_timeout(Duration::from_millis(20));
                continue;
            };
            if self.is_simulated && now == Stamp(0) {
                // Nobody has said what time it is.
                let waits = *waits.get_or_insert_with(instant);
                if !is_warned && waits.elapsed() > Duration::from_secs(5) {
                    r2r::log_warn!(&self.logger, "use_sim_time is set, but /clock says nothing");
                    is_warned = true;
                }
                self.inbox.take(&mut inputs, now);
                thread::park_timeout(Duration::from_millis(5));
                continue;
            }
            let wait = running.wait(now, self.inbox.has_body());
            if wait.0 > 0 {
                // Who hears what time it is wakes this thread; simulated time may also jump.
                let most = if self.is_simulated { 5_000_000 } else { i64::MAX };
                thread::park_timeout(Duration::from_nanos(wait.0.min(most).unsigned_abs()));
                continue;
            }
            self.inbox.take(&mut inputs, now);
            self.tick(running, &inputs, now);
        }
    }

    /// Whoever asks later is not told what was so while it ticked.
    fn rest(&self) {
        let state = Text { data: HandoverState::Idle.name().to_owned() };
        // Nobody may be there to hear it.
        let _ = self.publishers.state.publish(&state);
    }

    /// Lines of the log about the same state are this far apart at least.
    const APART: Duration = Duration::from_secs(1);

    fn tick(&self, running: &mut Running, inputs: &Inputs, now: Stamp) {
        let begun = instant();
        let mut outputs = running.live.tick(now, inputs, running.took);
        running.took = Some(begun.elapsed().as_nanos() as f64 / 1000.0);
        for status in outputs.diagnostics.iter_mut().flat_map(|array| &mut array.status) {
            status.name = format!("{}: {}", self.node_name, status.name);
        }
        if let Err(error) = self.publishers.publish(&outputs) {
            r2r::log_error!(&self.logger, "cannot publish: {error:#}");
        }
        if outputs.news.is_some() {
            running.news = outputs.news;
        }
        // What changes at every tick is not worth a line each time.
        let is_due = running.told.is_none_or(|told| told.elapsed() > Self::APART)
            || running.reason != Some(outputs.reason);
        if let Some(News { is_warning, text }) = running.news.take_if(|_| is_due) {
            let told = instant();
            (running.told, running.reason) = (Some(told), Some(outputs.reason));
            if is_warning {
                r2r::log_warn!(&self.logger, "{text}");
            } else {
                r2r::log_info!(&self.logger, "{text}");
            }
        }
        running.ticked(now);
    }
}

/// How a robot was left.
struct Standstill {
    /// Where it was told to stand; empty if that counts no more.
    pose: Vec<Point>,
    /// When it was left, and from when on it stands.
    brakes: [Stamp; 2],
}

/// What ticks.
struct Running {
    live: Box<Live>,
    period: Span,
    /// Between these the robot still brakes: no tick then.
    brakes: Option<[Stamp; 2]>,
    /// When the last tick was, and when the next is due.
    last: Option<(Stamp, Stamp)>,
    took: Option<f64>,
    /// What the log is still to be told.
    news: Option<News>,
    /// When, and with which reason, the log was told last.
    told: Option<Instant>,
    reason: Option<Option<HoldReason>>,
}

impl Running {
    fn new(live: Box<Live>, period: Span, brakes: Option<[Stamp; 2]>) -> Self {
        Self { live, period, brakes, last: None, took: None, news: None, told: None, reason: None }
    }

    /// How long until the next tick: a period after the last; if somebody is seen, a quarter of it.
    fn wait(&self, now: Stamp, is_seen: bool) -> Span {
        let Some((last, due)) = self.last else {
            // A clock that was set back since then makes nobody wait.
            let brakes = self.brakes.filter(|[left, _]| *left <= now);
            return brakes.map_or(Span(0), |[_, stands]| stands - now);
        };
        if now < last {
            // The clock was set back: the tick knows what to do.
            return Span(0);
        }
        let soonest = last + Span(self.period.0 / 4);
        let due = if is_seen { due.min(soonest) } else { due };
        due - now
    }

    fn ticked(&mut self, now: Stamp) {
        let due = self.last.map_or(now, |(_, due)| due);
        // Ticks keep their beat; one that came far too late or for somebody seen begins a new one.
        let kept = due + self.period;
        let is_kept = now >= due && kept > now;
        self.last = Some((now, if is_kept { kept } else { now + self.period }));
    }
}
