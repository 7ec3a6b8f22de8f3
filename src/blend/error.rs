//! What cannot be blended.

/// Why shapes cannot be blended; vertices, triangles and tetrahedra count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BlendError {
    /// A corner is no vertex, or two corners are the same.
    #[error("{what} {at} has the corners {corners:?}: distinct ones below {vertices} are needed")]
    Corners {
        /// `triangle` or `tetrahedron`.
        what: &'static str,
        /// Which.
        at: usize,
        /// Its corners.
        corners: Vec<u32>,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More vertices and ghosts than can be numbered.
    #[error("{vertices} vertices and those to be added are more than {}", u32::MAX)]
    TooMany {
        /// How many vertices there are.
        vertices: usize,
    },
    /// Nothing to put a shape together from.
    #[error(
        "no tetrahedron has a volume and the same orientation in every shape (of sizes from 1e-50 to \
         1e50)"
    )]
    Empty,
    /// A shape has not one place for each vertex.
    #[error("shape {shape} has {places} places for {vertices} vertices")]
    Shape {
        /// Which, 0 being the reference.
        shape: usize,
        /// How many places it has.
        places: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// There is no shape at all.
    #[error("no shape to begin with")]
    NoShape,
    /// A place is NaN or infinite.
    #[error("shape {shape}, vertex {vertex}: not finite")]
    NotFinite {
        /// Which shape, 0 being the reference.
        shape: usize,
        /// Which vertex.
        vertex: usize,
    },
    /// A weight is negative, NaN or infinite, or there is not one for each tetrahedron.
    #[error("tetrahedron {tetrahedron}: a weight is finite and ≥ 0, and each has one")]
    Weight {
        /// Which tetrahedron.
        tetrahedron: usize,
    },
    /// Triangles that are no surface with or without a border.
    #[error("{}", not_manifold(.edges, .vertices))]
    NotManifold {
        /// Edges of more than two triangles, or of two that go around them the same way.
        edges: Vec<[u32; 2]>,
        /// Vertices whose triangles are more than one fan.
        vertices: Vec<u32>,
    },
    /// A vertex to be pinned is none.
    #[error("vertex {vertex} cannot be pinned: there are {vertices}")]
    Pin {
        /// Which.
        vertex: usize,
        /// How many there are.
        vertices: usize,
    },
    /// A number among the settings is out of bounds.
    #[error(transparent)]
    Settings(#[from] crate::settings::OutOfBounds),
    /// Triangles or tetrahedra that join nearly everything with everything.
    #[error("the vertices hang together too closely: a factor of {values} numbers")]
    Entangled {
        /// How many numbers it would have.
        values: usize,
    },
    /// Tetrahedra so flat, so small or so large that nothing holds a vertex.
    #[error(
        "the tetrahedra do not determine where the vertices are: some are too flat or too small"
    )]
    Undetermined,
}

/// How many faults of a kind are named; the rest is counted.
const NAMED: usize = 5;

fn not_manifold(edges: &[[u32; 2]], vertices: &[u32]) -> String {
    let edges: Vec<String> = edges.iter().map(|[a, b]| format!("{a}-{b}")).collect();
    let vertices: Vec<String> = vertices.iter().map(u32::to_string).collect();
    let some = |what: &str, all: &[String]| {
        let rest = all.len().saturating_sub(NAMED);
        let rest = if rest > 0 { format!(" and {rest} more") } else { String::new() };
        format!("{what} {}{rest}", all[..all.len().min(NAMED)].join(", "))
    };
    let edges = (!edges.is_empty()).then(|| {
        some("more than two triangles, or two that go around it the same way, at edge", &edges)
    });
    let vertices = (!vertices.is_empty()).then(|| some("more than one fan at vertex", &vertices));
    let faults: Vec<String> = edges.into_iter().chain(vertices).collect();
    format!("the triangles are no surface: {}", faults.join("; "))
}
