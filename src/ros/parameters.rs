//! A node's [`ParameterTable`] on the graph: the six parameter services and `/parameter_events`.
//!
//! Whatever spins the node calls [`ParameterServer::serve`] after it; nothing here waits.

use anyhow::{Context, Result};
use r2r::rcl_interfaces::{msg, srv};
use r2r::{Node, Publisher, QosProfile};

use super::services::{Answers, Requests};
use super::shell::{RosClock, TimeSource};
use crate::messages::Time;
use crate::parameters::{Bound, Parameter, ParameterTable, ParameterValue, Refusal, Refusals};

/// What every node has: whether its time is that of `/clock`.
const SIMULATED_TIME: &str = "use_sim_time";

/// Parameters that whoever is on the graph may read, and change where they are not read-only.
///
/// `use_sim_time` is declared too, and heeded.
pub struct ParameterServer {
    table: ParameterTable,
    changes: Vec<(String, ParameterValue)>,
    /// What somebody set, be it to what it was.
    set_names: Vec<String>,
    time: TimeSource,
    node_name: String,
    answers: Answers,
    events: Publisher<msg::ParameterEvent>,
    get: Requests<srv::GetParameters::Service>,
    types: Requests<srv::GetParameterTypes::Service>,
    describe: Requests<srv::DescribeParameters::Service>,
    list: Requests<srv::ListParameters::Service>,
    set: Requests<srv::SetParameters::Service>,
    set_atomically: Requests<srv::SetParametersAtomically::Service>,
}

/// What nodes can not be started with, or why they can not be started.
#[derive(Debug, thiserror::Error)]
pub enum ParameterServerError {
    /// Parameters that it was started with: all that is wrong with them.
    #[error(transparent)]
    Refused(#[from] Refusals),
    /// No service, publisher or clock could be had.
    #[error(transparent)]
    Graph(#[from] anyhow::Error),
}

impl ParameterServer {
    /// Declares `parameters`, takes what the node was started with (`--params-file`, `-p`), and
    /// offers them on the graph.
    ///
    /// # Errors
    /// [`ParameterServerError`]; nothing has been offered then.
    ///
    /// # Panics
    /// As [`ParameterTable::new`], and if `use_sim_time` is among `parameters`.
    pub fn new(
        node: &mut Node,
        mut parameters: Vec<Parameter>,
    ) -> Result<Self, ParameterServerError> {
        parameters.push(
            Parameter::new(SIMULATED_TIME, false, "Whether time is that of the topic /clock")
                .read_only("time cannot jump while a node runs"),
        );
        let mut table = ParameterTable::new(parameters);
        table.start(started_with(node))?;
        let time = TimeSource::new(node, table.is_true(SIMULATED_TIME))?;
        Ok(Self::offer(node, table, time)?)
    }

    fn offer(node: &mut Node, table: ParameterTable, time: TimeSource) -> Result<Self> {
        let events = node
            .create_publisher("/parameter_events", QosProfile::parameter_events())
            .context("/parameter_events")?;
        let answers = Answers::default();
        let server = Self {
            changes: Vec::new(),
            set_names: Vec::new(),
            time,
            node_name: node.fully_qualified_name()?,
            events,
            get: Requests::new(node, "~/get_parameters", &answers)?,
            types: Requests::new(node, "~/get_parameter_types", &answers)?,
            describe: Requests::new(node, "~/describe_parameters", &answers)?,
            list: Requests::new(node, "~/list_parameters", &answers)?,
            set: Requests::new(node, "~/set_parameters", &answers)?,
            set_atomically: Requests::new(node, "~/set_parameters_atomically", &answers)?,
            table,
            answers,
        };
        let declared = server.table.all().iter();
        let declared = declared.map(|parameter| (parameter.name.clone(), parameter.value.clone()));
        let new_parameters = declared.map(to_message).collect();
        server.tell(node, msg::ParameterEvent { new_parameters, ..Default::default() });
        Ok(server)
    }

    /// Where answers of the node's other services wait.
    pub(super) fn answers(&self) -> &Answers {
        &self.answers
    }

    /// What time it is to the node.
    pub fn clock(&self) -> RosClock {
        self.time.clock()
    }

    /// Hears what time it is, if it is simulated; says whether that has changed.
    pub fn hear_time(&mut self) -> bool {
        self.time.hear()
    }

    /// The parameters as they are.
    pub fn table(&self) -> &ParameterTable {
        &self.table
    }

    /// What has been changed since this was asked last, in order.
    pub fn take_changes(&mut self) -> Vec<(String, ParameterValue)> {
        std::mem::take(&mut self.changes)
    }

    /// The names of what has been set since this was asked last, be it to what it was before.
    pub fn take_set_names(&mut self) -> Vec<String> {
        std::mem::take(&mut self.set_names)
    }

    /// Answers every request that has come in, and those that were not heard yet.
    ///
    /// - `may_set`: asked before a change is taken, with the table as it is, and names and values as
    ///   they will be, one or those of an atomic change; an error is the reason that whoever asked is
    ///   told.
    pub fn serve(
        &mut self,
        node: &Node,
        mut may_set: impl FnMut(&ParameterTable, &[(String, ParameterValue)]) -> Result<(), String>,
    ) {
        self.answers.tell();
        while let Some(request) = self.get.next() {
            let values = request.message.names.iter().map(|name| self.value(name)).collect();
            self.get.answer(request, srv::GetParameters::Response { values });
        }
        while let Some(request) = self.types.next() {
            let types = request.message.names.iter().map(|name| self.value(name).type_).collect();
            self.types.answer(request, srv::GetParameterTypes::Response { types });
        }
        while let Some(request) = self.describe.next() {
            let names = request.message.names.iter();
            let descriptors = names.map(|name| self.description(name)).collect();
            self.describe.answer(request, srv::DescribeParameters::Response { descriptors });
        }
        while let Some(request) = self.list.next() {
            let srv::ListParameters::Request { prefixes, depth } = &request.message;
            let listed = self.table.list(prefixes, *depth);
            let result =
                msg::ListParametersResult { names: listed.names, prefixes: listed.prefixes };
            self.list.answer(request, srv::ListParameters::Response { result });
        }
        while let Some(request) = self.set.next() {
            let changes = request.message.parameters.iter().map(from_message);
            let results =
                changes.map(|change| self.change(node, &[change], &mut may_set)).collect();
            self.set.answer(request, srv::SetParameters::Response { results });
        }
        while let Some(request) = self.set_atomically.next() {
            let changes: Vec<_> = request.message.parameters.iter().map(from_message).collect();
            let result = self.change(node, &changes, &mut may_set);
            self.set_atomically.answer(request, srv::SetParametersAtomically::Response { result });
        }
    }

    /// Changes a parameter as the node itself wants it, read-only or not, and tells the graph.
    ///
    /// # Errors
    /// [`Refusals`] if it may not be that.
    pub fn put(
        &mut self,
        node: &Node,
        name: &str,
        value: impl Into<ParameterValue>,
    ) -> Result<(), Refusals> {
        let change = (name.to_owned(), value.into());
        self.table.start([change.clone()])?;
        let changed_parameters = vec![to_message(change)];
        self.tell(node, msg::ParameterEvent { changed_parameters, ..Default::default() });
        Ok(())
    }

    fn change(
        &mut self,
        node: &Node,
        changes: &[(String, ParameterValue)],
        may_set: &mut impl FnMut(&ParameterTable, &[(String, ParameterValue)]) -> Result<(), String>,
    ) -> msg::SetParametersResult {
        let changed = match self.table.set(changes, may_set) {
            Ok(changed) => changed,
            Err(refusal) => return refused(&refusal),
        };
        if !changed.is_empty() {
            let changed_parameters = changed.iter().cloned().map(to_message).collect();
            self.tell(node, msg::ParameterEvent { changed_parameters, ..Default::default() });
        }
        self.changes.extend(changed);
        self.set_names.extend(changes.iter().map(|(name, _)| name.clone()));
        msg::SetParametersResult { successful: true, reason: String::new() }
    }

    fn value(&self, name: &str) -> msg::ParameterValue {
        let value = self.table.get(name).map_or(ParameterValue::NotSet, |p| p.value.clone());
        to_value_message(value)
    }

    fn description(&self, name: &str) -> msg::ParameterDescriptor {
        let Some(parameter) = self.table.get(name) else {
            return msg::ParameterDescriptor { name: name.to_owned(), ..Default::default() };
        };
        let mut description = msg::ParameterDescriptor {
            name: name.to_owned(),
            type_: parameter.value.type_number(),
            description: parameter.description.clone(),
            read_only: parameter.read_only.is_some(),
            ..Default::default()
        };
        match &parameter.bound {
            Bound::None => {}
            Bound::Numbers(low, high) => {
                let (from_value, to_value) = (*low, *high);
                let range = msg::FloatingPointRange { from_value, to_value, step: 0.0 };
                description.floating_point_range.push(range);
            }
            Bound::Whole(low, high) => {
                let (from_value, to_value) = (*low, *high);
                let range = msg::IntegerRange { from_value, to_value, step: 1 };
                description.integer_range.push(range);
            }
            Bound::OneOf(_) | Bound::Filled => {
                description.additional_constraints = parameter.allowed()
            }
        }
        if parameter.length.is_some() {
            description.additional_constraints = parameter.allowed();
        }
        description
    }

    /// Nobody may be there to hear it.
    fn tell(&self, node: &Node, event: msg::ParameterEvent) {
        let Time { sec, nanosec } = Time::of(self.clock().now());
        let stamp = r2r::builtin_interfaces::msg::Time { sec, nanosec };
        let event = msg::ParameterEvent { stamp, node: self.node_name.clone(), ..event };
        if let Err(error) = self.events.publish(&event) {
            r2r::log_warn!(node.logger(), "/parameter_events: {error}");
        }
    }
}

fn refused(refusal: &Refusal) -> msg::SetParametersResult {
    msg::SetParametersResult { successful: false, reason: refusal.to_string() }
}

/// What `--params-file` and `-p` say, in a fixed order.
pub fn started_with(node: &Node) -> Vec<(String, ParameterValue)> {
    let given = node.params.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let given = given.iter();
    given.map(|(name, parameter)| (name.clone(), from_r2r(&parameter.value))).collect()
}

fn from_r2r(value: &r2r::ParameterValue) -> ParameterValue {
    match value.clone() {
        r2r::ParameterValue::NotSet => ParameterValue::NotSet,
        r2r::ParameterValue::Bool(value) => value.into(),
        r2r::ParameterValue::Integer(value) => value.into(),
        r2r::ParameterValue::Double(value) => value.into(),
        r2r::ParameterValue::String(value) => value.into(),
        r2r::ParameterValue::BoolArray(value) => value.into(),
        r2r::ParameterValue::ByteArray(value) => value.into(),
        r2r::ParameterValue::IntegerArray(value) => value.into(),
        r2r::ParameterValue::DoubleArray(value) => value.into(),
        r2r::ParameterValue::StringArray(value) => value.into(),
    }
}

fn from_message(parameter: &msg::Parameter) -> (String, ParameterValue) {
    let value = parameter.value.clone();
    let value = match value.type_ {
        1 => value.bool_value.into(),
        2 => value.integer_value.into(),
        3 => value.double_value.into(),
        4 => value.string_value.into(),
        5 => value.byte_array_value.into(),
        6 => value.bool_array_value.into(),
        7 => value.integer_array_value.into(),
        8 => value.double_array_value.into(),
        9 => value.string_array_value.into(),
        _ => ParameterValue::NotSet,
    };
    (parameter.name.clone(), value)
}

fn to_message((name, value): (String, ParameterValue)) -> msg::Parameter {
    msg::Parameter { name, value: to_value_message(value) }
}

fn to_value_message(value: ParameterValue) -> msg::ParameterValue {
    let mut message =
        msg::ParameterValue { type_: value.type_number(), ..msg::ParameterValue::default() };
    match value {
        ParameterValue::NotSet => {}
        ParameterValue::Bool(value) => message.bool_value = value,
        ParameterValue::Integer(value) => message.integer_value = value,
        ParameterValue::Double(value) => message.double_value = value,
        ParameterValue::Text(value) => message.string_value = value,
        ParameterValue::Bytes(value) => message.byte_array_value = value,
        ParameterValue::Bools(value) => message.bool_array_value = value,
        ParameterValue::Integers(value) => message.integer_array_value = value,
        ParameterValue::Doubles(value) => message.double_array_value = value,
        ParameterValue::Texts(value) => message.string_array_value = value,
    }
    message
}
