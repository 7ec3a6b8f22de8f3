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
    /// The number of phases is out of bounds.
    #[error("{phases} phases, must be 1 to {most}", most = LearnedEdges::MOST_PHASES)]
    PhaseCount {
        /// How many there are.
        phases: usize,
    },
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
    /// A factor is negative, NaN or too large.
    #[error("edge {a}-{b}, phase {phase}: factor {value} must be from 0 to {most}", most = LearnedEdges::MOST_FACTOR)]
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
/// edges: see [`edge_for_hands`].
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedEdges {
    hands: Hands,
    phases: usize,
    edges: Vec<LearnedEdge>,
}

impl LearnedEdges {
    /// More phases than this no interaction has: it would take hours of frames.
    pub const MOST_PHASES: usize = 1 << 20;

    /// A factor above this is no learned one: weights would drown everything else.
    pub const MOST_FACTOR: f64 = 1e12;

    /// The only way in; sorts the edges.
    ///
    /// - `hands`: the active hands that the edges are named for.
    /// - `phases`: how many factors an edge has, 1 to [`Self::MOST_PHASES`]; see [`phase`].
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
        if phases == 0 || phases > Self::MOST_PHASES {
            return Err(EdgesError::PhaseCount { phases });
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
            let bad = |factor: &f64| !(0.0..=Self::MOST_FACTOR).contains(factor);
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

    /// The same edges where other hands are active: see [`edge_for_hands`].
    pub fn for_hands(&self, pair: &Pair, robot: Role, hands: Hands) -> Self {
        let mut edges: Vec<LearnedEdge> = self.edges.clone();
        for learned in &mut edges {
            learned.edge = edge_for_hands(learned.edge, pair, robot, self.hands, hands);
        }
        edges.sort_by_key(|learned| learned.edge);
        Self { hands, phases: self.phases, edges }
    }
}

/// An edge named for some active hands → the same edge where others are active: whoever uses the
/// other hand has left and right exchanged.
pub fn edge_for_hands(edge: Edge, pair: &Pair, robot: Role, from: Hands, to: Hands) -> Edge {
    let [a, b] = edge.ends().map(|vertex| {
        let side = |hands: Hands| {
            if pair.role(vertex) == robot { hands.robot } else { hands.partner }
        };
        if side(from) == side(to) { vertex } else { pair.mirrored(vertex) }
    });
    Edge::new(a, b)
}

/// Which of `phases` parts of the interaction a frame belongs to.
///
/// The way from the first frame to the contact and the way from there to the last are each half
/// of the interaction; its parts are equal, so that an odd number of them has the contact in the
/// middle one.
///
/// - `frame`: fractional; those before the first belong to its part, those after the last to its.
/// - `contact`: the frame (fractional) at which the hands meet.
pub fn phase(phases: usize, frame: f64, contact: f64, frames: usize) -> usize {
    let last = frames.saturating_sub(1) as f64;
    let share = if frame < contact {
        0.5 * frame / contact
    } else if last > contact {
        0.5 + 0.5 * (frame - contact) / (last - contact)
    } else {
        0.5
    };
    ((share * phases as f64) as usize).min(phases.saturating_sub(1))
}
