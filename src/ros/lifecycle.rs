//! A [`Lifecycle`] on the graph: its five services and `~/transition_event`.

use anyhow::{Context as _, Result};
use r2r::lifecycle_msgs::{msg, srv};
use r2r::{Node, Publisher, QosProfile, ServiceRequest};

use super::services::{Answers, Requests};
use super::shell::RosClock;
use crate::lifecycle::{Lifecycle, Outcome, State, Step, TRANSITIONS, Transition};

/// The life of a node, as launch files and `ros2 lifecycle` lead it.
pub(super) struct LifecycleServer {
    life: Lifecycle,
    clock: RosClock,
    events: Publisher<msg::TransitionEvent>,
    change: Requests<srv::ChangeState::Service>,
    state: Requests<srv::GetState::Service>,
    states: Requests<srv::GetAvailableStates::Service>,
    transitions: Requests<srv::GetAvailableTransitions::Service>,
    graph: Requests<srv::GetAvailableTransitions::Service>,
}

impl LifecycleServer {
    /// # Errors
    /// If a service cannot be offered.
    pub(super) fn new(node: &mut Node, clock: RosClock, answers: &Answers) -> Result<Self> {
        let quality = QosProfile::default();
        let events = node.create_publisher("~/transition_event", quality);
        Ok(Self {
            life: Lifecycle::default(),
            clock,
            events: events.context("~/transition_event")?,
            change: Requests::new(node, "~/change_state", answers)?,
            state: Requests::new(node, "~/get_state", answers)?,
            states: Requests::new(node, "~/get_available_states", answers)?,
            transitions: Requests::new(node, "~/get_available_transitions", answers)?,
            graph: Requests::new(node, "~/get_transition_graph", answers)?,
        })
    }

    pub(super) fn state(&self) -> State {
        self.life.state()
    }

    /// Answers every question that has come in.
    pub(super) fn serve(&mut self) {
        while let Some(request) = self.state.next() {
            self.state.answer(
                request,
                srv::GetState::Response { current_state: state(self.life.state()) },
            );
        }
        while let Some(request) = self.states.next() {
            let available_states = State::ALL.map(state).to_vec();
            self.states.answer(request, srv::GetAvailableStates::Response { available_states });
        }
        let describe = |transitions: &mut dyn Iterator<Item = Transition>| {
            let available_transitions = transitions.map(described).collect();
            srv::GetAvailableTransitions::Response { available_transitions }
        };
        while let Some(request) = self.transitions.next() {
            self.transitions.answer(request, describe(&mut self.life.available()));
        }
        while let Some(request) = self.graph.next() {
            self.graph.answer(request, describe(&mut TRANSITIONS.into_iter()));
        }
    }

    /// The next step that somebody asks for and that can be taken from here, and who is to hear how
    /// it went; what cannot be taken is refused.
    pub(super) fn asked(&mut self) -> Option<(Asker, Step)> {
        while let Some(request) = self.change.next() {
            let wanted = &request.message.transition;
            match self.life.wanted(wanted.id, &wanted.label) {
                Some(step) => return Some((Asker(request), step)),
                None => self.change.answer(request, srv::ChangeState::Response { success: false }),
            }
        }
        None
    }

    /// Sets out on a step that can be taken from here.
    pub(super) fn begin(&mut self, step: Step) {
        let way = self.life.begin(step);
        self.tell(way);
    }

    /// Arrives, or goes back.
    pub(super) fn end(&mut self, outcome: Outcome) {
        let way = self.life.end(outcome);
        self.tell(way);
    }

    /// Says how the step went that `asker` had asked for.
    pub(super) fn answer(&mut self, asker: Asker, outcome: Outcome) {
        let success = outcome == Outcome::Success;
        self.change.answer(asker.0, srv::ChangeState::Response { success });
    }

    fn tell(&self, way: Transition) {
        let timestamp = u64::try_from(self.clock.now().0).unwrap_or(0);
        let event = msg::TransitionEvent {
            timestamp,
            transition: msg::Transition { id: way.id, label: way.label.to_owned() },
            start_state: state(way.start),
            goal_state: state(way.goal),
        };
        // Nobody may be there to hear it.
        let _ = self.events.publish(&event);
    }
}

/// Whoever asked for a step.
pub(super) struct Asker(ServiceRequest<srv::ChangeState::Service>);

fn state(state: State) -> msg::State {
    msg::State { id: state.id(), label: state.label().to_owned() }
}

fn described(way: Transition) -> msg::TransitionDescription {
    msg::TransitionDescription {
        transition: msg::Transition { id: way.id, label: way.label.to_owned() },
        start_state: state(way.start),
        goal_state: state(way.goal),
    }
}
