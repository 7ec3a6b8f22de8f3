//! The handover node: its life, its parameters, what it hears.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use r2r::Node;

use super::context::{ArgumentsError, context};
use super::inbox::Inbox;
use super::lifecycle::{Asker, LifecycleServer};
use super::load::{Loaded, Loading};
use super::parameters::{ParameterServer, ParameterServerError, started_with};
use super::shell::{Stop, line, now};
use super::subscriptions::Subscriptions;
use super::ticker::{Command, Publishers, Ticker, Ticking};
use super::triggers::{Asked, Triggers};
use crate::config::given::{Given, declared, differences};
use crate::config::{Change, ConfigError};
use crate::lifecycle::{Outcome, State, Step};
use crate::live::Live;
use crate::time::Span;

/// The node's name, if nothing else is said.
const NAME: &str = "handover";

/// How long the node waits for something to do: as long as it takes to notice that it is to end.
const IDLE: Duration = Duration::from_millis(20);

/// How long the last answer has to reach whoever shut the node down.
const FAREWELL: Duration = Duration::from_millis(500);
/// After so long everybody has found a node, also on a busy machine.
const YOUTH: Duration = Duration::from_secs(5);
/// And so much later than the node hears somebody, they hear it.
const LISTENING: Duration = Duration::from_secs(1);

/// Runs the node until a signal ends it, or somebody shuts it down.
///
/// Exit codes: 0 ended as asked, 1 failed, 2 started with parameters that cannot be meant.
pub fn run() -> ExitCode {
    let run = || -> Result<()> {
        let stop = Stop::on_signals()?;
        let mut node = Node::create(context()?, NAME, "")?;
        let mut handover = Handover::new(&mut node)?;
        handover.spin(&mut node, &stop)
    };
    let Err(error) = run() else { return ExitCode::SUCCESS };
    r2r::log_error!(NAME, "{}", line(format_args!("{error:#}")));
    let refused = error.downcast_ref::<ParameterServerError>();
    let is_usage = matches!(refused, Some(ParameterServerError::Refused(_)))
        || error.is::<ArgumentsError>()
        || error.is::<ConfigError>();
    ExitCode::from(if is_usage { 2 } else { 1 })
}

/// The node's parts; the graph's node itself is the caller's, and outlives them.
struct Handover {
    began: Instant,
    logger: String,
    parameters: ParameterServer,
    /// What was given at the start or set since: all else is the model's.
    given: Given,
    lifecycle: LifecycleServer,
    triggers: Triggers,
    subscriptions: Subscriptions,
    inbox: Arc<Inbox>,
    ticker: Ticker,
    /// A model on its way, while the node is configuring.
    loading: Option<Loading>,
    /// What is configured, until it is cleaned up.
    configured: Option<Loaded>,
    /// Whether the node activates itself, once it is configured.
    autostart: bool,
}

impl Handover {
    fn new(node: &mut Node) -> Result<Self> {
        let logger = node.logger().to_owned();
        let given = Given::new(started_with(node).into_iter().map(|(name, _)| name));
        let parameters = ParameterServer::new(node, declared())?;
        let settings = given.node(parameters.table())?;
        let inbox = Arc::new(Inbox::default());
        let subscriptions = Subscriptions::new(node, settings.source)?;
        let publishers = Publishers::new(node)?;
        let ticking = Ticking {
            clock: parameters.clock(),
            inbox: inbox.clone(),
            publishers,
            logger: logger.clone(),
            node_name: node.fully_qualified_name()?,
            is_simulated: parameters.table().is_true("use_sim_time"),
        };
        let ticker = Ticker::new(ticking)?;
        let mut handover = Self {
            began: now(),
            lifecycle: LifecycleServer::new(node, parameters.clock(), parameters.answers())?,
            triggers: Triggers::new(node, parameters.answers())?,
            loading: None,
            configured: None,
            autostart: settings.autostart,
            logger,
            parameters,
            given,
            subscriptions,
            inbox,
            ticker,
        };
        if handover.autostart {
            handover.begin(Step::Configure, None);
        } else {
            handover.say_waiting();
        }
        Ok(handover)
    }

    fn spin(&mut self, node: &mut Node, stop: &Stop) -> Result<()> {
        while !stop.is_set() && self.lifecycle.state() != State::Finalized {
            node.spin_once(IDLE);
            if self.ticker.is_dead() {
                bail!("the ticking thread has ended by a bug: see above");
            }
            let [has_time, sees] =
                [self.parameters.hear_time(), self.subscriptions.drain(&self.inbox)];
            if has_time || sees {
                self.ticker.wake();
            }
            self.serve(node);
        }
        // Whoever asked for the end is to hear that it comes, before the node is gone.
        let end = now() + FAREWELL;
        while !stop.is_set() && (now() < end || self.parameters.answers().are_waiting()) {
            node.spin_once(IDLE);
            self.parameters.answers().tell();
        }
        Ok(())
    }

    fn serve(&mut self, node: &Node) {
        self.serve_parameters(node);
        self.lifecycle.serve();
        // The steps need all of the node but its life.
        while let Some((asker, step)) = self.lifecycle.asked() {
            self.begin(step, Some(asker));
        }
        if let Some(loading) = self.loading.take_if(|loading| loading.is_done()) {
            let (loaded, asker) = loading.end();
            let outcome = loaded.and_then(|loaded| self.configured(node, loaded));
            let is_configured = outcome.is_ok();
            self.end(outcome, asker);
            if is_configured && std::mem::take(&mut self.autostart) {
                self.begin(Step::Activate, None);
            }
        }
        let state = self.lifecycle.state();
        let ticker = &self.ticker;
        self.triggers.serve(|asked| match (asked, state) {
            (_, state) if state != State::Active => {
                Err(format!("the node is {}, not active", state.label()))
            }
            (Asked::Cancel, _) => {
                ticker.tell(Command::Cancel);
                Ok("the robot brakes, and stands until reset")
            }
            (Asked::Reset, _) => {
                ticker.tell(Command::Reset);
                Ok("what comes next is a new interaction")
            }
        });
    }

    fn serve_parameters(&mut self, node: &Node) {
        let is_configured = self.lifecycle.state() != State::Unconfigured;
        self.parameters.serve(node, |table, changes| Given::may_set(table, changes, is_configured));
        for name in self.parameters.take_set_names() {
            self.given.add(&name);
        }
        let changes = self.parameters.take_changes();
        if changes.is_empty() {
            return;
        }
        for (name, value) in changes {
            r2r::log_info!(&self.logger, "{name} is now {value}");
        }
        if let (Some(configured), Ok(settings)) =
            (&mut self.configured, self.given.node(self.parameters.table()))
        {
            configured.node = settings.clone();
            self.ticker.tell(Command::Set(Box::new(settings)));
        }
    }

    /// Takes a step of the node's life; configuring goes on by itself.
    fn begin(&mut self, step: Step, asker: Option<Asker>) {
        self.lifecycle.begin(step);
        let outcome = match step {
            Step::Configure => {
                let (given, table) = (self.given.clone(), self.parameters.table().clone());
                // Launch goes on by the event of it, and can be heard before it hears.
                let is_young = asker.is_some() && self.began.elapsed() < YOUTH;
                let least = if is_young { LISTENING } else { Duration::ZERO };
                self.loading = Some(Loading::begin(given, table, asker, least));
                return;
            }
            Step::Activate => self.activate(),
            Step::Deactivate | Step::CleanUp | Step::ShutDown => {
                // What was published last ends in a standstill: nothing is left to be said.
                self.ticker.stop();
                if step != Step::Deactivate {
                    self.ticker.tell(Command::Forget);
                    self.configured = None;
                }
                Ok(())
            }
        };
        self.end(outcome, asker);
    }

    /// Arrives or goes back, and says so.
    fn end(&mut self, outcome: Result<()>, asker: Option<Asker>) {
        let outcome = match outcome {
            Ok(()) => Outcome::Success,
            Err(error) => {
                r2r::log_error!(&self.logger, "{}", line(format_args!("{error:#}")));
                Outcome::Failure
            }
        };
        self.lifecycle.end(outcome);
        match self.lifecycle.state() {
            State::Unconfigured => self.say_waiting(),
            state => r2r::log_info!(&self.logger, "{}", state.label()),
        }
        if let Some(asker) = asker {
            self.lifecycle.answer(asker, outcome);
        }
    }

    fn say_waiting(&self) {
        let hint = "ros2 lifecycle set NODE configure, then activate, or node.autostart";
        r2r::log_info!(&self.logger, "unconfigured: waits for ~/change_state (hint: {hint})");
    }

    /// Shows what was loaded.
    fn configured(&mut self, node: &Node, mut loaded: Loaded) -> Result<()> {
        // Somebody may have set what may be set at any time meanwhile.
        loaded.node = self.given.node(self.parameters.table())?;
        for Change { key, value, default } in &loaded.differing {
            r2r::log_warn!(
                &self.logger,
                "{key} is {default}, with which the model was learned; {value} counts for nothing"
            );
        }
        for (name, value) in differences(&loaded.config, self.parameters.table()) {
            self.parameters.put(node, &name, value)?;
        }
        r2r::log_info!(&self.logger, "{}", line(&loaded.about));
        self.configured = Some(loaded);
        Ok(())
    }

    fn activate(&mut self) -> Result<()> {
        let Some(Loaded { model, node, .. }) = &self.configured else {
            bail!("nothing is configured");
        };
        let live = Live::new(model.clone(), node.clone())?;
        let period = Span::from_seconds(1.0 / node.rate).unwrap_or(Span(10_000_000));
        self.ticker.tell(Command::Start(Box::new(live), period));
        Ok(())
    }
}
