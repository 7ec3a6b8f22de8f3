//! Who neighbours whom in a frame: the symbolic half of a mesh, the same in every frame.

use std::sync::Arc;

use super::{MeshError, Pair, Vertex};
use crate::delaunay::{DelaunayError, delaunay};
use crate::geometry::Point;
use crate::skeleton::Role;

/// A spatial edge between two joints of a pair, the lower one first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Edge(Vertex, Vertex);

impl Edge {
    /// The edge between two joints, in either order.
    pub fn new(a: Vertex, b: Vertex) -> Self {
        Self(a.min(b), a.max(b))
    }

    /// Both ends, the lower one first.
    pub fn ends(self) -> [Vertex; 2] {
        [self.0, self.1]
    }

    /// `person/joint` of both ends, by the names of the people.
    pub fn names(self, pair: &Pair, people: [&str; 2]) -> [String; 2] {
        self.ends().map(|end| pair.name(end, people))
    }

    /// Whether it joins the two people.
    pub fn is_interperson(self, pair: &Pair) -> bool {
        pair.role(self.0) != pair.role(self.1)
    }
}

/// Which edges a mesh starts with; the bones are always among them (Thai 2014, 3.3.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InitialEdges {
    /// Delaunay tetrahedra of each person alone: no interperson edge.
    EachPerson,
    /// Delaunay tetrahedra of both people's joints together.
    BothPeople,
}

/// Spatial edges of a pair, in order and without repetition, bones included.
///
/// ```
/// use handover_mesh::{Role, Skeleton, mesh::{Edge, Pair, Topology}};
/// let skeleton = Skeleton::nite();
/// let pair = Pair::new([skeleton.clone(), skeleton.clone()]);
/// let hand = |role| pair.vertex(role, skeleton.joint("right_hand").unwrap());
/// let handshake = Edge::new(hand(Role::First), hand(Role::Second));
/// let topology = Topology::new(pair.clone().into(), [handshake])?;
/// assert_eq!(topology.edges().len(), 14 + 14 + 1);
/// # Ok::<(), handover_mesh::mesh::MeshError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topology {
    pair: Arc<Pair>,
    edges: Box<[Edge]>,
    /// Compressed rows: the neighbours of vertex `i` are at `offsets[i]..offsets[i + 1]`.
    offsets: Box<[u32]>,
    /// `(neighbour, edge)`, rising by neighbour within a row.
    neighbours: Box<[(Vertex, u32)]>,
}

impl Topology {
    /// These edges and the bones; repeated ones count once.
    ///
    /// # Errors
    /// [`MeshError::Edge`] if an edge's ends are the same joint or not in the pair.
    pub fn new(pair: Arc<Pair>, edges: impl IntoIterator<Item = Edge>) -> Result<Self, MeshError> {
        let vertices = pair.len();
        let bones = pair.bones().map(|[parent, child]| Edge::new(parent, child));
        let mut edges: Vec<Edge> = bones.chain(edges).collect();
        edges.sort_unstable();
        edges.dedup();
        if let Some(Edge(a, b)) = edges.iter().find(|e| e.0 == e.1 || e.1.index() >= vertices) {
            return Err(MeshError::Edge { a: a.index(), b: b.index(), vertices });
        }
        let mut rows = vec![Vec::new(); vertices];
        for (at, edge) in edges.iter().enumerate() {
            rows[edge.0.index()].push((edge.1, at as u32));
            rows[edge.1.index()].push((edge.0, at as u32));
        }
        let mut offsets = vec![0u32];
        let mut neighbours = Vec::with_capacity(2 * edges.len());
        for mut row in rows {
            row.sort_unstable();
            neighbours.extend(row);
            offsets.push(neighbours.len() as u32);
        }
        Ok(Self {
            pair,
            edges: edges.into(),
            offsets: offsets.into(),
            neighbours: neighbours.into(),
        })
    }

    /// The edges of the Delaunay tetrahedra of one frame, with the bones.
    ///
    /// - `positions`: `[m]`, both people's joints of the frame.
    ///
    /// People whose joints span no volume get their bones alone.
    ///
    /// # Errors
    /// [`MeshError::Shape`] if `positions` is not one frame, [`MeshError::Delaunay`] if a
    /// coordinate is not finite or too large or small for exact predicates.
    pub fn initial(
        pair: Arc<Pair>,
        positions: &[Point],
        edges: InitialEdges,
    ) -> Result<Self, MeshError> {
        if positions.len() != pair.len() {
            let (got, vertices) = (positions.len(), pair.len());
            return Err(MeshError::Shape { got, frames: 1, vertices });
        }
        let everyone: Vec<Vec<Vertex>> = match edges {
            InitialEdges::EachPerson => {
                [Role::First, Role::Second].map(|role| pair.vertices(role).collect()).into()
            }
            InitialEdges::BothPeople => {
                vec![pair.vertices(Role::First).chain(pair.vertices(Role::Second)).collect()]
            }
        };
        let mut found = Vec::new();
        for vertices in everyone {
            let points: Vec<Point> = vertices.iter().map(|v| positions[v.index()]).collect();
            match delaunay(&points) {
                Ok(tetrahedra) => {
                    let edges = tetrahedra.edges().into_iter();
                    found.extend(edges.map(|[a, b]| Edge::new(vertices[a], vertices[b])));
                }
                // Flat people (all joints in one plane) have no tetrahedra: their bones remain.
                Err(DelaunayError::Flat { .. } | DelaunayError::TooFew { .. }) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Self::new(pair, found)
    }

    /// The same mesh with further edges.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with(&self, edges: impl IntoIterator<Item = Edge>) -> Result<Self, MeshError> {
        Self::new(self.pair.clone(), self.edges.iter().copied().chain(edges))
    }

    /// The two skeletons.
    pub fn pair(&self) -> &Arc<Pair> {
        &self.pair
    }

    /// All edges, in order.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// An edge's place among [`Self::edges`], if it is there.
    pub fn find(&self, edge: Edge) -> Option<usize> {
        self.edges.binary_search(&edge).ok()
    }

    /// The neighbours of a vertex with the edge to each, rising.
    pub fn neighbours(&self, vertex: usize) -> impl ExactSizeIterator<Item = (usize, usize)> + '_ {
        let row = self.offsets[vertex] as usize..self.offsets[vertex + 1] as usize;
        self.neighbours[row].iter().map(|(vertex, edge)| (vertex.index(), *edge as usize))
    }
}
