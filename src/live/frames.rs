//! Where frames are in the world.

use std::collections::BTreeMap;

use crate::config::NodeSettings;
use crate::geometry::Isometry;
use crate::messages::{Transform, TransformTree};

/// A frame that nobody has said where it is.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "frame '{frame}' is neither the world ('{world}') nor the sensor's ('{sensor}'), and not known from \
     /tf (hint: node.sensor_frame and node.world_from_sensor)"
)]
pub struct UnknownFrame {
    /// The frame.
    pub frame: String,
    /// The world's name.
    pub world: String,
    /// The sensor's frame, if one is named.
    pub sensor: String,
}

/// The world, the sensor, and the newest edges of the tree of frames, whatever their stamps.
#[derive(Debug, Clone)]
pub struct Frames {
    world: String,
    sensor: String,
    world_from_sensor: Isometry,
    /// Parent and `parent_from_child` of a child.
    edges: BTreeMap<String, (String, Isometry)>,
}

impl Frames {
    /// No tree has so many frames; more are not kept.
    const MOST: usize = 4096;
    /// No frame is so deep in the tree; a ring ends here.
    const DEEPEST: usize = 64;

    /// - `node`: the names of world and sensor, and where the sensor is.
    pub fn new(node: &NodeSettings) -> Self {
        Self {
            world: bare(&node.world_frame).to_owned(),
            sensor: bare(&node.sensor_frame).to_owned(),
            world_from_sensor: node.world_from_sensor,
            edges: BTreeMap::new(),
        }
    }

    /// Takes in some edges; one that is no rigid motion is left out.
    pub fn take(&mut self, tree: &TransformTree) {
        for edge in &tree.transforms {
            let (parent, child) = (bare(&edge.header.frame_id), bare(&edge.child_frame_id));
            let Some(motion) = rigid(&edge.transform) else { continue };
            let has_room = self.edges.len() < Self::MOST;
            match self.edges.get_mut(child) {
                Some(known) if known.0 == parent => known.1 = motion,
                Some(known) => *known = (parent.to_owned(), motion),
                None if has_room => {
                    self.edges.insert(child.to_owned(), (parent.to_owned(), motion));
                }
                None => {}
            }
        }
    }

    /// `world_from_frame` `[m]`. No frame at all is the world.
    ///
    /// # Errors
    /// [`UnknownFrame`].
    pub fn world_from(&self, frame: &str) -> Result<Isometry, UnknownFrame> {
        let frame = bare(frame);
        if frame.is_empty() || frame == self.world {
            return Ok(Isometry::identity());
        }
        if frame == self.sensor {
            return Ok(self.world_from_sensor);
        }
        let unknown = || UnknownFrame {
            frame: frame.to_owned(),
            world: self.world.clone(),
            sensor: self.sensor.clone(),
        };
        if !self.edges.contains_key(frame) {
            return Err(unknown());
        }
        let above_world: Vec<(&str, Isometry)> = self.above(&self.world).collect();
        self.above(frame)
            .find_map(|(ancestor, ancestor_from_frame)| {
                if ancestor == self.sensor {
                    return Some(self.world_from_sensor * ancestor_from_frame);
                }
                let (_, ancestor_from_world) =
                    above_world.iter().find(|(name, _)| *name == ancestor)?;
                Some(ancestor_from_world.inverse() * ancestor_from_frame)
            })
            .ok_or_else(unknown)
    }

    /// A frame and those above it, each with `that_from_frame`.
    fn above<'a>(&'a self, frame: &'a str) -> impl Iterator<Item = (&'a str, Isometry)> {
        let up = |(name, from_frame): &(&'a str, Isometry)| {
            let (parent, parent_from_child) = self.edges.get(*name)?;
            Some((parent.as_str(), parent_from_child * from_frame))
        };
        std::iter::successors(Some((frame, Isometry::identity())), up).take(Self::DEEPEST)
    }
}

/// Without the slash that frames of ROS 1 begin with.
fn bare(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}

/// The motion, if it is one.
fn rigid(transform: &Transform) -> Option<Isometry> {
    let q = transform.rotation;
    let turn = nalgebra::Quaternion::new(q.w, q.x, q.y, q.z);
    let turn = nalgebra::UnitQuaternion::try_new(turn, 1e-6)?;
    let shift: crate::geometry::Vector = transform.translation.into();
    let is_finite = shift.iter().chain(turn.coords.iter()).all(|value| value.is_finite());
    is_finite.then(|| Isometry::from_parts(shift.into(), turn))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Point, Vector, yaw_isometry};
    use crate::messages::{Header, Quaternion, TransformStamped};

    fn edge(parent: &str, child: &str, motion: &Isometry) -> TransformStamped {
        let q = motion.rotation.coords;
        TransformStamped {
            header: Header { frame_id: parent.to_owned(), ..Header::default() },
            child_frame_id: child.to_owned(),
            transform: Transform {
                translation: motion.translation.vector.into(),
                rotation: Quaternion { x: q.x, y: q.y, z: q.z, w: q.w },
            },
        }
    }

    #[test]
    fn frames_are_found_up_and_down_the_tree() {
        let mount = yaw_isometry(0.7, Vector::new(1.0, 2.0, 3.0));
        let lens = Isometry::new(Vector::new(0.0, 0.1, 0.0), Vector::new(1.2, -0.3, 0.4));
        let world = yaw_isometry(-0.4, Vector::new(5.0, 0.0, 0.0));
        let mut frames = Frames::new(&NodeSettings::default());
        frames.take(&TransformTree {
            transforms: vec![
                edge("/map", "world", &world),
                edge("map", "/camera", &mount),
                edge("camera", "depth", &lens),
            ],
        });
        let expected = world.inverse() * mount * lens;
        let found = frames.world_from("/depth").unwrap();
        let p = Point::new(0.3, -0.2, 1.4);
        assert!((found * p - expected * p).norm() < 1e-12);
        assert_eq!(frames.world_from("").unwrap(), Isometry::identity());
        let error = frames.world_from("elsewhere").unwrap_err().to_string();
        assert!(error.contains("frame 'elsewhere'") && error.contains("('world')"), "{error}");
    }

    #[test]
    fn the_sensors_place_is_the_parameters_and_rings_end() {
        let world_from_sensor = yaw_isometry(1.0, Vector::new(0.0, 0.0, 2.0));
        let node = NodeSettings {
            sensor_frame: "camera".into(),
            world_from_sensor,
            ..NodeSettings::default()
        };
        let mut frames = Frames::new(&node);
        assert_eq!(frames.world_from("camera").unwrap(), world_from_sensor);
        let lens = yaw_isometry(0.2, Vector::x());
        let mut tree = TransformTree { transforms: vec![edge("camera", "depth", &lens)] };
        tree.transforms.extend([edge("a", "b", &lens), edge("b", "a", &lens)]);
        let mut nothing = edge("camera", "broken", &lens);
        nothing.transform.rotation.w = f64::NAN;
        tree.transforms.push(nothing);
        frames.take(&tree);
        assert_eq!(frames.world_from("depth").unwrap(), world_from_sensor * lens);
        assert!(frames.world_from("a").is_err() && frames.world_from("broken").is_err());
    }
}
