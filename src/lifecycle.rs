//! The life of a managed node: which states there are, and which ways lead from one to another.
//!
//! States, transitions, their numbers and labels are those of `lifecycle_msgs` and `rcl_lifecycle`
//! (design.ros2.org, "Managed nodes"), so that `ros2 lifecycle` and launch files know them. Needs no
//! ROS: whoever owns the life says how a transition went, and tells the graph.

/// A state, its number that of `lifecycle_msgs/msg/State`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum State {
    Unconfigured = 1,
    Inactive = 2,
    Active = 3,
    Finalized = 4,
    Configuring = 10,
    CleaningUp = 11,
    ShuttingDown = 12,
    Activating = 13,
    Deactivating = 14,
    ErrorProcessing = 15,
}

impl State {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Unconfigured,
        Self::Inactive,
        Self::Active,
        Self::Finalized,
        Self::Configuring,
        Self::CleaningUp,
        Self::ShuttingDown,
        Self::Activating,
        Self::Deactivating,
        Self::ErrorProcessing,
    ];

    /// The number on the wire.
    pub fn id(self) -> u8 {
        self as u8
    }

    /// The label on the wire.
    pub fn label(self) -> &'static str {
        match self {
            Self::Unconfigured => "unconfigured",
            Self::Inactive => "inactive",
            Self::Active => "active",
            Self::Finalized => "finalized",
            Self::Configuring => "configuring",
            Self::CleaningUp => "cleaningup",
            Self::ShuttingDown => "shuttingdown",
            Self::Activating => "activating",
            Self::Deactivating => "deactivating",
            Self::ErrorProcessing => "errorprocessing",
        }
    }
}

/// A way from one state to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transition {
    /// The number on the wire.
    pub id: u8,
    /// The label on the wire.
    pub label: &'static str,
    /// Where it begins.
    pub start: State,
    /// Where it ends.
    pub goal: State,
}

/// What somebody on the graph may ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Load what is needed.
    Configure,
    /// Give it up.
    CleanUp,
    /// Begin to work.
    Activate,
    /// Stop working.
    Deactivate,
    /// End.
    ShutDown,
}

/// How a step went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done.
    Success,
    /// Not done; all is as before.
    Failure,
}

/// Every transition there is, in the order of their numbers.
pub const TRANSITIONS: [Transition; 25] = {
    use State::*;
    const fn to(id: u8, label: &'static str, start: State, goal: State) -> Transition {
        Transition { id, label, start, goal }
    }
    [
        to(1, "configure", Unconfigured, Configuring),
        to(2, "cleanup", Inactive, CleaningUp),
        to(3, "activate", Inactive, Activating),
        to(4, "deactivate", Active, Deactivating),
        to(5, "shutdown", Unconfigured, ShuttingDown),
        to(6, "shutdown", Inactive, ShuttingDown),
        to(7, "shutdown", Active, ShuttingDown),
        to(10, "transition_success", Configuring, Inactive),
        to(11, "transition_failure", Configuring, Unconfigured),
        to(12, "transition_error", Configuring, ErrorProcessing),
        to(20, "transition_success", CleaningUp, Unconfigured),
        to(21, "transition_failure", CleaningUp, Inactive),
        to(22, "transition_error", CleaningUp, ErrorProcessing),
        to(30, "transition_success", Activating, Active),
        to(31, "transition_failure", Activating, Inactive),
        to(32, "transition_error", Activating, ErrorProcessing),
        to(40, "transition_success", Deactivating, Inactive),
        to(41, "transition_failure", Deactivating, Active),
        to(42, "transition_error", Deactivating, ErrorProcessing),
        to(50, "transition_success", ShuttingDown, Finalized),
        to(51, "transition_failure", ShuttingDown, Finalized),
        to(52, "transition_error", ShuttingDown, ErrorProcessing),
        to(60, "transition_success", ErrorProcessing, Unconfigured),
        to(61, "transition_failure", ErrorProcessing, Finalized),
        to(62, "transition_error", ErrorProcessing, Finalized),
    ]
};

/// A node's life.
///
/// ```
/// use handover_mesh::lifecycle::{Lifecycle, Outcome, State};
/// let mut life = Lifecycle::default();
/// let configure = life.wanted(1, "").unwrap();
/// assert_eq!(life.begin(configure).goal, State::Configuring);
/// assert_eq!(life.end(Outcome::Success).label, "transition_success");
/// assert_eq!(life.state(), State::Inactive);
/// assert!(life.wanted(1, "").is_none(), "it is configured");
/// ```
#[derive(Debug, Clone)]
pub struct Lifecycle {
    state: State,
}

impl Default for Lifecycle {
    /// Unconfigured.
    fn default() -> Self {
        Self { state: State::Unconfigured }
    }
}

impl Lifecycle {
    /// The state now.
    pub fn state(&self) -> State {
        self.state
    }

    /// The ways out of the state now.
    pub fn available(&self) -> impl Iterator<Item = Transition> {
        let state = self.state;
        TRANSITIONS.into_iter().filter(move |transition| transition.start == state)
    }

    /// What is asked for, if it may be from here: by its label where one is given, else by its
    /// number.
    pub fn wanted(&self, id: u8, label: &str) -> Option<Step> {
        let is_meant = |transition: &Transition| {
            if label.is_empty() { transition.id == id } else { transition.label == label }
        };
        match self.available().find(is_meant)?.id {
            1 => Some(Step::Configure),
            2 => Some(Step::CleanUp),
            3 => Some(Step::Activate),
            4 => Some(Step::Deactivate),
            5..=7 => Some(Step::ShutDown),
            _ => None,
        }
    }

    /// Sets out on a step.
    ///
    /// # Panics
    /// If it cannot be taken from here: [`Self::wanted`] says so.
    pub fn begin(&mut self, step: Step) -> Transition {
        let label = match step {
            Step::Configure => "configure",
            Step::CleanUp => "cleanup",
            Step::Activate => "activate",
            Step::Deactivate => "deactivate",
            Step::ShutDown => "shutdown",
        };
        self.go(label)
    }

    /// Arrives, or goes back.
    ///
    /// # Panics
    /// If nothing was begun.
    pub fn end(&mut self, outcome: Outcome) -> Transition {
        self.go(match outcome {
            Outcome::Success => "transition_success",
            Outcome::Failure => "transition_failure",
        })
    }

    fn go(&mut self, label: &str) -> Transition {
        let way = self.available().find(|transition| transition.label == label);
        let Some(way) = way else { panic!("no '{label}' from {}", self.state.label()) };
        self.state = way.goal;
        way
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_lives_from_unconfigured_to_finalized() {
        let mut life = Lifecycle::default();
        let walk = [
            (1, Outcome::Failure, State::Unconfigured),
            (1, Outcome::Success, State::Inactive),
            (3, Outcome::Success, State::Active),
            (4, Outcome::Success, State::Inactive),
            (2, Outcome::Success, State::Unconfigured),
            (5, Outcome::Success, State::Finalized),
        ];
        for (id, outcome, state) in walk {
            let step = life.wanted(id, "").unwrap();
            assert_eq!(life.begin(step).id, id);
            assert_eq!(life.end(outcome).goal, state);
        }
        assert_eq!(life.available().count(), 0);
    }

    #[test]
    fn what_cannot_be_asked_for_here_is_nothing() {
        let life = Lifecycle::default();
        assert_eq!(life.wanted(3, ""), None, "not configured");
        assert_eq!(life.wanted(10, ""), None);
        assert_eq!(life.wanted(0, "shutdown"), Some(Step::ShutDown));
        assert_eq!(life.wanted(1, "dance"), None, "the label counts");
        let from = |state: State| TRANSITIONS.iter().filter(|t| t.start == state).count();
        assert_eq!(State::ALL.map(from), [2, 3, 2, 0, 3, 3, 3, 3, 3, 3]);
    }
}
