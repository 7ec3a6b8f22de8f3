//! The handover node: its life, its parameters, what it hears.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow, bail};
use r2r::Node;
use serde_json::{Value, json};

use super::context::{ArgumentsError, context};
use super::inbox::Inbox;
use super::lifecycle::LifecycleServer;
use super::parameters::{ParameterServer, ParameterServerError};
use super::shell::{RosClock, Stop};
use super::subscriptions::Subscriptions;
use super::ticker::{Command, Publishers, Ticker, Ticking};
use super::triggers::{Asked, Triggers};
use crate::config::{Config, ConfigError, Kind, NodeSettings};
use crate::lifecycle::{Outcome, State, Step};
use crate::live::Live;
use crate::model::Model;
use crate::online::OnlineModel;
use crate::parameters::{Parameter, ParameterValue};
use crate::predict::Predictor;
use crate::time::Span;

/// The node's name, if nothing else is said.
const NAME: &str = "handover";

/// What may change at any time.
const ALWAYS: [&str; 6] = [
    "node.partner",
    "node.start_zone",
    "node.approach",
    "node.contact_distance",
    "node.markers_rate",
    "node.diagnostics_rate",
];

/// Sections of parameters that a model was learned with and that the tick reads.
const OF_THE_TICK: [&str; 6] =
    ["robot.", "observation.", "reference.", "mesh.", "retarget.", "forecast."];

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
        handover.spin(&mut node, &stop);
        Ok(())
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
    given: BTreeSet<String>,
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
        let given: BTreeSet<String> = {
            let given = node.params.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            given.keys().cloned().collect()
        };
        let parameters = ParameterServer::new(node, declared()?)?;
        let settings = settings(&parameters, &given)?.1;
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

    fn spin(&mut self, node: &mut Node, stop: &Stop) {
        while !stop.is_set() && self.lifecycle.state() != State::Finalized {
            node.spin_once(IDLE);
            if self.subscriptions.drain(&self.inbox, &self.logger) {
                self.ticker.wake();
            }
            self.serve(node);
        }
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
        let state = self.lifecycle.state();
        let (logger, given) = (&self.logger, &self.given);
        let table = self.parameters.table().clone();
        self.parameters.serve(node, |changes| {
            let fixed = changes.iter().find(|(name, _)| !ALWAYS.contains(&name.as_str()));
            if let Some((name, _)) = fixed.filter(|_| state != State::Unconfigured) {
                return Err(format!(
                    "{name} cannot change while the node is {}: it is read when the node is \
                     configured (hint: clean it up first)",
                    state.label()
                ));
            }
            // Also what only together is wrong.
            let mut values = values(&table, given);
            values.extend(changes.iter().map(|(name, value)| (name.clone(), to_json(value))));
            let defaults = (Config::default(), NodeSettings::default());
            defaults.0.with_values(&defaults.1, values).map(|_| ()).map_err(|e| e.to_string())
        });
        let changes = self.parameters.take_changes();
        if changes.is_empty() {
            return;
        }
        for (name, value) in changes {
            r2r::log_info!(logger, "{name} is now {value}");
            self.given.insert(name);
        }
        if let (Some(configured), Ok((_, settings))) =
            (&mut self.configured, settings(&self.parameters, &self.given))
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
                self.ticker.tell(Command::Stop);
                if step != Step::Deactivate {
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
        let (_, settings) = settings(&self.parameters, &self.given)?;
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
        let config = self.over_model(model.config())?;
        let predictor = Predictor::fit(model.demonstrations().to_vec(), config.predict.clone());
        let predictor = predictor.with_context(|| shown.to_string())?;
        let predictor = predictor.with_edges(model.edges().clone());
        let online = OnlineModel::new(&predictor, config.online.clone());
        let online = Arc::new(online.with_context(|| shown.to_string())?);
        // What cannot be ticked with is said now, not when the node is made active.
        Live::new(online.clone(), settings.clone()).with_context(|| shown.to_string())?;
        for (name, value) in config.values() {
            let kind = self.parameters.table().value(&name).clone();
            let value = to_value(&value, &kind);
            if value != kind {
                self.parameters.put(node, &name, value)?;
            }
        }
        let count = model.demonstrations().len();
        r2r::log_info!(&self.logger, "{shown}: the robot is {role}, {count} demonstrations");
        self.configured = Some(Configured { model: online, node: settings });
        Ok(())
    }

    /// The model's parameters, with those given over them that are the robot's.
    fn over_model(&self, model: &Config) -> Result<Config> {
        let given = values(self.parameters.table(), &self.given);
        let (robots, models): (Vec<_>, Vec<_>) =
            given.into_iter().partition(|(key, _)| Config::is_of_the_robot(key));
        let node = NodeSettings::default();
        let models = models.into_iter().filter(|(key, _)| !key.starts_with("node."));
        let changes = model.with_values(&node, models)?.2;
        let counts = |key: &str| OF_THE_TICK.iter().any(|section| key.starts_with(section));
        for change in changes.iter().filter(|change| counts(&change.key)) {
            r2r::log_warn!(
                &self.logger,
                "{} is {}, with which the model was learned; {} counts for nothing",
                change.key,
                change.default,
                change.value
            );
        }
        Ok(model.with_values(&node, robots)?.0)
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

/// Every parameter as the graph sees it.
fn declared() -> Result<Vec<Parameter>> {
    let parameters = Config::default().parameters(&NodeSettings::default());
    parameters.into_iter().map(parameter).collect()
}

fn parameter(from: crate::config::Parameter) -> Result<Parameter> {
    let crate::config::Parameter { key, kind, value, description } = from;
    let empty = match &kind {
        Kind::Flag => ParameterValue::Bool(false),
        Kind::Real { .. } => ParameterValue::Double(0.0),
        Kind::Whole { .. } => ParameterValue::Integer(0),
        Kind::Text | Kind::Choice(_) => ParameterValue::Text(String::new()),
        Kind::Reals => ParameterValue::Doubles(Vec::new()),
        Kind::Texts => ParameterValue::Texts(Vec::new()),
    };
    let declared = Parameter::new(key.clone(), to_value(&value, &empty), description);
    let declared = match kind {
        Kind::Real { low, high } => declared.numbers(low, high),
        Kind::Whole { low, high } => declared.whole(low, high),
        Kind::Choice(words) => declared.one_of(words),
        Kind::Flag | Kind::Text | Kind::Reals | Kind::Texts => declared,
    };
    Ok(match key.as_str() {
        "node.source" => declared.read_only("topics are subscribed to at the start"),
        "node.autostart" => declared.read_only("it counts at the start"),
        key if key.starts_with("node.") || Config::is_of_the_robot(key) => declared,
        _ => declared.read_only("it belongs to the model, which was learned with it"),
    })
}

/// What was given, as the parameters' reader takes it.
fn values(
    table: &crate::parameters::ParameterTable,
    given: &BTreeSet<String>,
) -> BTreeMap<String, Value> {
    let given = given.iter().filter(|name| *name != "use_sim_time");
    given.filter_map(|name| Some((name.clone(), to_json(&table.get(name)?.value)))).collect()
}

/// What the parameters are, on top of the defaults.
///
/// # Errors
/// All that is wrong with them.
fn settings(
    parameters: &ParameterServer,
    given: &BTreeSet<String>,
) -> Result<(Config, NodeSettings)> {
    let values = values(parameters.table(), given);
    let (config, node, _) = Config::default().with_values(&NodeSettings::default(), values)?;
    Ok((config, node))
}

fn to_json(value: &ParameterValue) -> Value {
    match value {
        ParameterValue::NotSet => Value::Null,
        ParameterValue::Bool(value) => json!(value),
        ParameterValue::Integer(value) => json!(value),
        ParameterValue::Double(value) => json!(value),
        ParameterValue::Text(value) => json!(value),
        ParameterValue::Bytes(value) => json!(value),
        ParameterValue::Bools(value) => json!(value),
        ParameterValue::Integers(value) => json!(value),
        ParameterValue::Doubles(value) => json!(value),
        ParameterValue::Texts(value) => json!(value),
    }
}

/// A value of the kind that `like` is; itself where it is of no such kind.
fn to_value(value: &Value, like: &ParameterValue) -> ParameterValue {
    let list = || value.as_array().into_iter().flatten();
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let found = match like {
        ParameterValue::Bool(_) => value.as_bool().map(Into::into),
        ParameterValue::Integer(_) => value.as_i64().map(Into::into),
        ParameterValue::Double(_) => value.as_f64().map(Into::into),
        ParameterValue::Text(_) => text(value).map(Into::into),
        ParameterValue::Doubles(_) => {
            Some(ParameterValue::Doubles(list().filter_map(Value::as_f64).collect()))
        }
        ParameterValue::Texts(_) => Some(ParameterValue::Texts(list().filter_map(text).collect())),
        _ => None,
    };
    found.unwrap_or_else(|| like.clone())
}
