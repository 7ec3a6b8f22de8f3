//! What learning finds: which joints of the two people bind each other, how strongly and when.

use crate::demonstration::Hands;
use crate::mesh::{Edge, Pair, Vertex};
use crate::skeleton::Role;

/// An edge between the people and the factors of its weight.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedEdge {
    /// The joints it joins.
    pub edge: Edge,
    /// What the kernel's weight is multiplied by `[-]`, one per phase: finite, ≥ 0.
    pub factors: Vec<f64>,
}

/// Why edges are no learned edges.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EdgesError {
    /// There is at least one phase.
    #[error("no phases; an interaction has at least one")]
    NoPhases,
    /// An edge does not join the two people.
    #[error("edge {a}-{b} does not join the two people, who have {vertices} joints together")]
    NotInterperson {
        /// One end.
        a: usize,
        /// The other end.
        b: usize,
        /// Joints of both people.
        vertices: usize,
    },
    /// An edge is there twice.
    #[error("edge {a}-{b} is there twice")]
    Twice {
        /// One end.
        a: usize,
        /// The other end.
        b: usize,
    },
    /// An edge has not one factor per phase.
    #[error("edge {a}-{b} has {got} factors for {phases} phases")]
    Phases {
        /// One end.
        a: usize,
        /// The other end.
        b: usize,
        /// How many factors it has.
        got: usize,
        /// How many phases there are.
        phases: usize,
    },
    /// A factor is negative, NaN or infinite.
    #[error("edge {a}-{b}, phase {phase}: factor {value} must be finite and >= 0")]
    Factor {
        /// One end.
        a: usize,
        /// The other end.
        b: usize,
        /// The phase, counted from 0.
        phase: usize,
        /// The factor.
        value: f64,
    },
}

/// Interperson edges with weights, named for one pair of active hands.
///
/// Where a person uses the other hand, that person's left and right joints change places in the
/// edges: see [`Self::for_hands`].
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedEdges {
    hands: Hands,
    phases: usize,
    edges: Vec<LearnedEdge>,
}

impl LearnedEdges {
    /// The only way in; sorts the edges.
    ///
    /// - `hands`: the active hands that the edges are named for.
    /// - `phases`: how many factors an edge has, ≥ 1; see [`phase`].
    ///
    /// # Errors
    /// [`EdgesError`] on the first edge that does not join the two people, is there twice or has
    /// unusable factors.
    pub fn new(
        pair: &Pair,
        hands: Hands,
        phases: usize,
        mut edges: Vec<LearnedEdge>,
    ) -> Result<Self, EdgesError> {
        if phases == 0 {
            return Err(EdgesError::NoPhases);
        }
        edges.sort_by_key(|learned| learned.edge);
        let mut last = None;
        for learned in &edges {
            let [a, b] = learned.edge.ends().map(Vertex::index);
            if b >= pair.len() || !learned.edge.is_interperson(pair) {
                return Err(EdgesError::NotInterperson { a, b, vertices: pair.len() });
            }
            if last == Some(learned.edge) {
                return Err(EdgesError::Twice { a, b });
            }
            last = Some(learned.edge);
            if learned.factors.len() != phases {
                return Err(EdgesError::Phases { a, b, got: learned.factors.len(), phases });
            }
            let bad = |factor: &f64| !(factor.is_finite() && *factor >= 0.0);
            if let Some(phase) = learned.factors.iter().position(bad) {
                return Err(EdgesError::Factor { a, b, phase, value: learned.factors[phase] });
            }
        }
        Ok(Self { hands, phases, edges })
    }

    /// No edge between the people.
    pub fn none(hands: Hands) -> Self {
        Self { hands, phases: 1, edges: Vec::new() }
    }

    /// The active hands that the edges are named for.
    pub fn hands(&self) -> Hands {
        self.hands
    }

    /// How many factors each edge has, at least 1.
    pub fn phases(&self) -> usize {
        self.phases
    }

    /// The edges, in order.
    pub fn edges(&self) -> &[LearnedEdge] {
        &self.edges
    }

    /// The same edges where other hands are active: whoever uses the other hand has left and
    /// right exchanged.
    pub fn for_hands(&self, pair: &Pair, robot: Role, hands: Hands) -> Self {
        let swapped = |role: Role| {
            let side = |hands: Hands| if role == robot { hands.robot } else { hands.partner };
            side(self.hands) != side(hands)
        };
        let map = |vertex: Vertex| {
            if swapped(pair.role(vertex)) { pair.mirrored(vertex) } else { vertex }
        };
        let mut edges: Vec<LearnedEdge> = self.edges.clone();
        for learned in &mut edges {
            let [a, b] = learned.edge.ends().map(map);
            learned.edge = Edge::new(a, b);
        }
        edges.sort_by_key(|learned| learned.edge);
        Self { hands, phases: self.phases, edges }
    }
}

/// Which of `phases` parts of the interaction a frame belongs to.
///
/// The way from the first frame to the contact and the way from there to the last are each half
/// of the interaction; its parts are equal, so that an odd number of them has the contact in the
/// middle one.
///
/// - `contact`: the frame (fractional) at which the hands meet.
pub fn phase(phases: usize, frame: usize, contact: f64, frames: usize) -> usize {
    let (at, last) = (frame as f64, frames.saturating_sub(1) as f64);
    let share = if at < contact {
        0.5 * at / contact
    } else if last > contact {
        0.5 + 0.5 * (at - contact) / (last - contact)
    } else {
        0.5
    };
    ((share * phases as f64) as usize).min(phases.saturating_sub(1))
}
