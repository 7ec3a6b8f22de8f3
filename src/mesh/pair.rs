//! Two skeletons as one set of vertices: the first person's joints, then the second's.

use std::sync::Arc;

use crate::geometry::Point;
use crate::skeleton::{JointId, Recording, Role, Skeleton};

/// A joint of a [`Pair`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Vertex(u16);

impl Vertex {
    /// Its place among both people's joints.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// The two skeletons of an interaction.
///
/// ```
/// use handover_mesh::{Role, Skeleton, mesh::Pair};
/// let pair = Pair::new([Skeleton::nite(), Skeleton::nite()]);
/// let hand = Skeleton::nite().joint("right_hand").unwrap();
/// assert_eq!(pair.vertex(Role::Second, hand).index(), 15 + 8);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pair {
    skeletons: [Arc<Skeleton>; 2],
}

impl Pair {
    /// Takes the first and the second person's skeleton.
    pub fn new(skeletons: [Arc<Skeleton>; 2]) -> Self {
        Self { skeletons }
    }

    /// The skeletons of a recording's two people.
    pub fn of(recording: &Recording) -> Self {
        Self::new(
            [Role::First, Role::Second].map(|r| recording.person(r).motion.skeleton().clone()),
        )
    }

    /// One person's skeleton.
    pub fn skeleton(&self, role: Role) -> &Arc<Skeleton> {
        &self.skeletons[role as usize]
    }

    /// Joints of both people together.
    #[expect(clippy::len_without_is_empty, reason = "skeletons have joints")]
    pub fn len(&self) -> usize {
        self.skeletons[0].len() + self.skeletons[1].len()
    }

    /// The first of a person's vertices.
    fn offset(&self, role: Role) -> usize {
        match role {
            Role::First => 0,
            Role::Second => self.skeletons[0].len(),
        }
    }

    /// A person's joint as a vertex of the pair.
    pub fn vertex(&self, role: Role, joint: JointId) -> Vertex {
        Vertex((self.offset(role) + joint.index()) as u16)
    }

    /// All of a person's vertices, in joint order.
    pub fn vertices(&self, role: Role) -> impl DoubleEndedIterator<Item = Vertex> + ExactSizeIterator + Clone + use<> {
        let first = self.offset(role) as u16;
        (first..first + self.skeletons[role as usize].len() as u16).map(Vertex)
    }

    /// A person's joint on the other side of the body; itself for the spine.
    pub fn mirrored(&self, vertex: Vertex) -> Vertex {
        let role = self.role(vertex);
        let joint = vertex.index() - self.offset(role);
        let joint = self.skeletons[role as usize].joints().nth(joint);
        joint.map_or(vertex, |joint| {
            self.vertex(role, self.skeletons[role as usize].mirrored_joint(joint))
        })
    }

    /// `person/joint`, by the names of the people.
    pub fn name(&self, vertex: Vertex, people: [&str; 2]) -> String {
        let role = self.role(vertex);
        let joint = vertex.index() - self.offset(role);
        format!("{}/{}", people[role as usize], self.skeletons[role as usize].names()[joint])
    }

    /// Whose joint a vertex is.
    pub fn role(&self, vertex: Vertex) -> Role {
        if vertex.index() < self.offset(Role::Second) { Role::First } else { Role::Second }
    }

    /// Bones of both people as `[parent, child]`, the first person's before the second's, each
    /// root outwards.
    pub fn bones(&self) -> impl Iterator<Item = [Vertex; 2]> + '_ {
        [Role::First, Role::Second].into_iter().flat_map(move |role| {
            let bones = self.skeletons[role as usize].bones();
            bones.map(move |bone| [self.vertex(role, bone.parent), self.vertex(role, bone.child)])
        })
    }

    /// Both people's positions of a recording, frame by frame, `[m]`: `frames × len()` points.
    pub fn positions(&self, recording: &Recording) -> Vec<Point> {
        let [first, second] = recording.people();
        let frames = first.motion.frames().iter().zip(second.motion.frames());
        frames.flat_map(|(a, b)| a.positions.iter().chain(&b.positions).copied()).collect()
    }
}
