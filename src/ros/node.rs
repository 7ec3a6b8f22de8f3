//! The handover node: its life, its parameters, what it hears.

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow, bail};
use r2r::Node;

use super::context::{ArgumentsError, context};
use super::inbox::Inbox;
use super::lifecycle::LifecycleServer;
use super::parameters::{ParameterServer, ParameterServerError, started_with};
use super::shell::{RosClock, Stop};
use super::subscriptions::Subscriptions;
use super::ticker::{Command, Publishers, Ticker, Ticking};
use super::triggers::{Asked, Triggers};
use crate::config::given::{Given, declared, differences};
use crate::config::{Change, ConfigError, NodeSettings};
use crate::lifecycle::{Outcome, State, Step};
use crate::live::Live;
use crate::model::Model;
use crate::online::OnlineModel;
use crate::predict::Predictor;
use crate::time::Span;

/// The node's name, if nothing else is said.
const NAME: &str = "handover";

/// How long the node waits for something to do: as long as it takes to notice that it is to end.
const IDLE: Duration = Duration::from_millis(20);

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
    r2r::log_error!(NAME, "{error:#}");
    let refused = error.downcast_ref::<ParameterServerError>();
    let is_usage = matches!(refused, Some(ParameterServerError::Refused(_)))
        || error.is::<ArgumentsError>()
        || error.is::<ConfigError>();
    ExitCode::from(if is_usage { 2 } else { 1 })
}

/// The node's parts; the graph's node itself is the caller's, and outlives them.
struct Handover {
    logger: String,
    parameters: ParameterServer,
    /// What was given at the start or set since: all else is the model's.
    given: Given,
    lifecycle: LifecycleServer,
    triggers: Triggers,
    subscriptions: Subscriptions,
    inbox: Arc<Inbox>,
    ticker: Ticker,
    /// What is configured, until it is cleaned up.
    configured: Option<Configured>,
}

/// What configuring leaves.
struct Configured {
    model: Arc<OnlineModel>,
    node: NodeSettings,
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
            clock: RosClock::of(node),
            inbox: inbox.clone(),
            publishers,
            logger: logger.clone(),
            node_name: node.fully_qualified_name()?,
            is_simulated: parameters.table().is_true("use_sim_time"),
        };
        let ticker = Ticker::new(ticking)?;
        let mut handover = Self {
            lifecycle: LifecycleServer::new(node)?,
            triggers: Triggers::new(node)?,
            configured: None,
            logger,
            parameters,
            given,
            subscriptions,
            inbox,
            ticker,
        };
        if settings.autostart {
            for step in [Step::Configure, Step::Activate] {
                if handover.step(node, step) == Outcome::Failure {
                    break;
                }
            }
        }
        Ok(handover)
    }

    fn spin(&mut self, node: &mut Node, stop: &Stop) -> Result<()> {
        while !stop.is_set() && self.lifecycle.state() != State::Finalized {
            node.spin_once(IDLE);
            if self.ticker.is_dead() {
                bail!("the ticking thread has ended by a bug: see above");
            }
            if self.subscriptions.drain(&self.inbox, &self.logger) {
                self.ticker.wake();
            }
            self.serve(node);
        }
        Ok(())
    }

    fn serve(&mut self, node: &Node) {
        self.serve_parameters(node);
        self.lifecycle.serve();
        // The steps need all of the node but its life.
        while let Some((answer, step)) = self.lifecycle.asked() {
            let outcome = self.step(node, step);
            answer.give(outcome);
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

    /// Takes a step of the node's life.
    fn step(&mut self, node: &Node, step: Step) -> Outcome {
        self.lifecycle.begin(step);
        let outcome = match step {
            Step::Configure => self.configure(node),
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
        let outcome = match outcome {
            Ok(()) => Outcome::Success,
            Err(error) => {
                r2r::log_error!(&self.logger, "{error:#}");
                Outcome::Failure
            }
        };
        self.lifecycle.end(outcome);
        r2r::log_info!(&self.logger, "{}", self.lifecycle.state().label());
        outcome
    }

    /// Loads the model, and lays what was given over its parameters.
    fn configure(&mut self, node: &Node) -> Result<()> {
        let settings = self.given.node(self.parameters.table())?;
        if settings.model.is_empty() {
            bail!("node.model is not set (hint: -p node.model:=MODEL.safetensors)");
        }
        let path = Path::new(&settings.model);
        let shown = path.display();
        let bytes = fs::read(path).with_context(|| format!("node.model: {shown}"))?;
        let model = Model::from_bytes(&bytes).map_err(|error| anyhow!("{shown}: {error}"))?;
        let role = model.people()[model.robot_role() as usize];
        if !settings.role.is_empty() && settings.role != role {
            bail!("node.role is {}, but the robot of {shown} is {role}", settings.role);
        }
        let (config, differing) = self.given.over(model.config(), self.parameters.table())?;
        for Change { key, value, default } in differing {
            r2r::log_warn!(
                &self.logger,
                "{key} is {default}, with which the model was learned; {value} counts for nothing"
            );
        }
        let predictor = Predictor::fit(model.demonstrations().to_vec(), config.predict.clone());
        let predictor = predictor.with_context(|| shown.to_string())?;
        let predictor = predictor.with_edges(model.edges().clone());
        let online = OnlineModel::new(&predictor, config.online.clone());
        let online = Arc::new(online.with_context(|| shown.to_string())?);
        // What cannot be ticked with is said now, not when the node is made active.
        Live::new(online.clone(), settings.clone()).with_context(|| shown.to_string())?;
        for (name, value) in differences(&config, self.parameters.table()) {
            self.parameters.put(node, &name, value)?;
        }
        let count = model.demonstrations().len();
        r2r::log_info!(&self.logger, "{shown}: the robot is {role}, {count} demonstrations");
        self.configured = Some(Configured { model: online, node: settings });
        Ok(())
    }

    fn activate(&mut self) -> Result<()> {
        let Some(Configured { model, node }) = &self.configured else {
            bail!("nothing is configured");
        };
        let live = Live::new(model.clone(), node.clone())?;
        let period = Span::from_seconds(1.0 / node.rate).unwrap_or(Span(10_000_000));
        self.ticker.tell(Command::Start(Box::new(live), period));
        Ok(())
    }
}
