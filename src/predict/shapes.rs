//! Demonstrations as shapes: several poses of both people → one, each part turned and stretched as
//! little as possible.
//!
//! The interaction mesh's Delaunay tetrahedra, of both people together, are the structure, the
//! demonstrations' poses its shapes (Kaji 2015, with `Blend_C` and `E_T`). A person's place is where
//! it is whatever the blend: both bases are pinned. Shapes are seen from one side: each
//! demonstration is turned about the vertical so that its people stand along the same line.

use nalgebra::{Complex, UnitComplex};

use crate::blend::{Apart, BlendError, DenseBlender, DenseWorkspace, Structure};
use crate::delaunay::{DelaunayError, delaunay};
use crate::demonstration::Demonstration;
use crate::geometry::{Point, Vector};
use crate::mesh::MeshError;

/// What the demonstrations' poses are shapes of.
#[derive(Debug, Clone)]
pub struct Shapes {
    blender: DenseBlender,
    /// How many joints the robot has; its partner's come behind them.
    robot_joints: usize,
    /// The two bases among all joints, the robot's first.
    bases: [usize; 2],
    /// `shape_from_demonstration` of each demonstration, about the vertical.
    turns: Vec<UnitComplex<f64>>,
}

/// Room to blend poses.
#[derive(Debug, Clone)]
pub struct ShapesWorkspace {
    pose: Vec<Point>,
    dense: DenseWorkspace,
}

impl Shapes {
    /// The structure of demonstrations: the tetrahedra of their mean pose at contact.
    ///
    /// None where that spans no volume, or nothing is to be blended.
    ///
    /// # Errors
    /// [`MeshError::Delaunay`] where a place is out of range for exact tetrahedra.
    pub fn new<'a>(
        demonstrations: impl Iterator<Item = &'a Demonstration> + Clone,
    ) -> Result<Option<Self>, MeshError> {
        let Some(first) = demonstrations.clone().next() else { return Ok(None) };
        let robot_joints = first.robot().skeleton().len();
        let joints = robot_joints + first.partner().skeleton().len();
        let bases = [first.robot_base().index(), robot_joints + first.partner_base().index()];
        let (mut rest, mut turns) = (vec![Vector::zeros(); joints], Vec::new());
        for demonstration in demonstrations.clone() {
            let turn = line_from(demonstration);
            let frame = demonstration.contact().frame;
            let people = [demonstration.robot(), demonstration.partner()];
            let both = people.iter().flat_map(|person| person.frames()[frame].positions.iter());
            let base = people[1].position(frame, demonstration.partner_base());
            for (sum, place) in rest.iter_mut().zip(both) {
                *sum += turned(turn, place - base);
            }
            turns.push(turn);
        }
        let count = turns.len() as f64;
        let rest: Vec<Point> = rest.into_iter().map(|sum| Point::from(sum / count)).collect();
        let tetrahedra = match delaunay(&rest) {
            Ok(found) => found.tetrahedra().to_vec(),
            Err(DelaunayError::Flat { .. } | DelaunayError::TooFew { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        // Of a sliver the map is hardly known: each counts by its volume.
        let volume = |corners: &[u32; 4]| {
            let [a, b, c, d] = corners.map(|corner| rest[corner as usize]);
            (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0
        };
        let volumes = tetrahedra.iter().map(volume).collect();
        let blender = Structure::new(joints, tetrahedra)
            .and_then(|structure| structure.weighted(volumes))
            .and_then(|structure| DenseBlender::new(&structure, &rest, &bases));
        match blender {
            Ok(blender) => Ok(Some(Self { blender, robot_joints, bases, turns })),
            // Of tetrahedra that are all but flat there is nothing to blend.
            Err(BlendError::Empty | BlendError::Undetermined) => Ok(None),
            Err(error) => unreachable!("tetrahedra of finite points: {error}"),
        }
    }

    /// `shape_from_demonstration` of a demonstration, about the vertical.
    pub fn turn(&self, demonstration: usize) -> UnitComplex<f64> {
        self.turns[demonstration]
    }

    /// A pose of both people taken apart.
    ///
    /// - `shape_from_here`: about the vertical.
    /// - `between`: from the partner's base to the robot's `[m]`, as they stood to each other.
    /// - `robot`, `partner`: `[m]`, wherever the two are.
    pub fn apart(
        &self,
        shape_from_here: UnitComplex<f64>,
        between: Vector,
        robot: &[Point],
        partner: &[Point],
    ) -> Apart {
        let mut pose = vec![Point::origin(); self.blender.vertices()];
        self.lay(shape_from_here, self.origins(between, robot, partner), robot, partner, &mut pose);
        self.blender.apart(&pose)
    }

    /// What of the robot and of the partner is at the shape's origin, their bases so far apart.
    fn origins(&self, between: Vector, robot: &[Point], partner: &[Point]) -> [Point; 2] {
        let [robot_base, partner_base] = self.bases;
        [robot[robot_base] - between, partner[partner_base - self.robot_joints]]
    }

    /// Both people as one shape.
    fn lay(
        &self,
        shape_from_here: UnitComplex<f64>,
        origins: [Point; 2],
        robot: &[Point],
        partner: &[Point],
        pose: &mut [Point],
    ) {
        let (own, other) = pose.split_at_mut(self.robot_joints);
        for (places, here, origin) in [(own, robot, origins[0]), (other, partner, origins[1])] {
            for (place, here) in places.iter_mut().zip(here) {
                *place = Point::from(turned(shape_from_here, here - origin));
            }
        }
    }

    /// Room for [`Self::blend`].
    pub fn workspace(&self) -> ShapesWorkspace {
        let pose = vec![Point::origin(); self.blender.vertices()];
        ShapesWorkspace { pose, dense: self.blender.workspace() }
    }

    /// Brings the weighted mean of poses to where their blend is; without allocation.
    ///
    /// - `poses`: weights `[-]`, together 1, and what they are of.
    /// - `here_from_shape`: the weighted mean of the poses' turns, about the vertical.
    /// - `between`: from the partner's base to the robot's `[m]`, the weighted mean of the poses, as
    ///   they are turned here.
    /// - `robot`, `partner`: `[m]`, one place a joint: the weighted means with their bases where
    ///   they are, overwritten.
    pub fn blend<'a>(
        &self,
        poses: impl Iterator<Item = (f64, &'a Apart)> + Clone,
        here_from_shape: UnitComplex<f64>,
        between: Vector,
        robot: &mut [Point],
        partner: &mut [Point],
        workspace: &mut ShapesWorkspace,
    ) {
        let ShapesWorkspace { pose, dense } = workspace;
        let origins = self.origins(between, robot, partner);
        self.lay(here_from_shape.inverse(), origins, robot, partner, pose);
        self.blender.blend(poses, pose, dense);
        let (own, other) = pose.split_at(self.robot_joints);
        for (places, here, origin) in [(own, robot, origins[0]), (other, partner, origins[1])] {
            for (place, here) in places.iter().zip(here) {
                *here = origin + turned(here_from_shape, place.coords);
            }
        }
    }
}

/// The weighted mean of turns about the vertical; none where they cancel out.
pub(crate) fn mean_turn(turns: impl Iterator<Item = (UnitComplex<f64>, f64)>) -> UnitComplex<f64> {
    let sum: Complex<f64> = turns.map(|(turn, weight)| turn.into_inner() * weight).sum();
    UnitComplex::try_new(sum, 1e-9).unwrap_or_else(UnitComplex::identity)
}

/// The turn about the vertical that lays the line from the partner to the robot along x: that of
/// the mean over the demonstration.
fn line_from(demonstration: &Demonstration) -> UnitComplex<f64> {
    let (robot, partner) = (demonstration.robot(), demonstration.partner());
    let line: Vector = (0..robot.len())
        .map(|frame| {
            robot.position(frame, demonstration.robot_base())
                - partner.position(frame, demonstration.partner_base())
        })
        .sum();
    let line = Complex::new(line.x, -line.y);
    UnitComplex::try_new(line, 1e-9).unwrap_or_else(UnitComplex::identity)
}

fn turned(turn: UnitComplex<f64>, vector: Vector) -> Vector {
    let turned = turn * vector.xy();
    Vector::new(turned.x, turned.y, vector.z)
}
