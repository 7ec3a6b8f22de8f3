//! Where frames are in the world.

use crate::config::NodeSettings;
use crate::frames::{FrameTree, bare};
use crate::geometry::Isometry;
use crate::time::Stamp;

/// A frame that nobody has said where it is.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "frame '{frame}' is neither the world ('{world}') nor the sensor's ('{sensor}'), and not known \
     from /tf at that time (hint: node.sensor_frame and node.world_from_sensor)"
)]
pub struct UnknownFrame {
    /// The frame.
    pub frame: String,
    /// The world's name.
    pub world: String,
    /// The sensor's frame, if one is named.
    pub sensor: String,
}

/// The frames that parameters name.
#[derive(Debug, Clone)]
pub(super) struct Frames {
    world: String,
    sensor: String,
    world_from_sensor: Isometry,
}

impl Frames {
    /// - `node`: the names of world and sensor, and where the sensor is.
    pub(super) fn new(node: &NodeSettings) -> Self {
        Self {
            world: bare(&node.world_frame).to_owned(),
            sensor: bare(&node.sensor_frame).to_owned(),
            world_from_sensor: node.world_from_sensor,
        }
    }

    /// `world_from_frame` `[m]`: by the parameters, else by the tree. No frame at all is the world.
    ///
    /// - `when`: the moment that is asked about, and now: see [`FrameTree::between`].
    ///
    /// # Errors
    /// [`UnknownFrame`].
    pub(super) fn world_from(
        &self,
        frame: &str,
        tree: &FrameTree,
        when: [Stamp; 2],
    ) -> Result<Isometry, UnknownFrame> {
        let Self { world, sensor, world_from_sensor } = self;
        let found = if !sensor.is_empty() && tree.is_below(frame, sensor, when) {
            // What the parameter says of the sensor counts before what the tree says.
            let sensor_from_frame = tree.between(sensor, frame, when);
            sensor_from_frame.map(|sensor_from_frame| world_from_sensor * sensor_from_frame)
        } else {
            tree.between(world, frame, when)
        };
        found.ok_or_else(|| UnknownFrame {
            frame: bare(frame).to_owned(),
            world: world.clone(),
            sensor: sensor.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Vector, yaw_isometry};
    use crate::messages::{Header, Transform, TransformStamped, TransformTree, Vector3};

    fn edge(parent: &str, child: &str, x: f64) -> TransformStamped {
        let translation = Vector3 { x, y: 0.0, z: 0.0 };
        TransformStamped {
            header: Header { frame_id: parent.to_owned(), ..Header::default() },
            child_frame_id: child.to_owned(),
            transform: Transform { translation, ..Transform::default() },
        }
    }

    #[test]
    fn the_sensors_place_is_the_parameters_wherever_the_tree_has_it() {
        let world_from_sensor = yaw_isometry(1.0, Vector::new(0.0, 0.0, 2.0));
        let node = NodeSettings {
            sensor_frame: "/camera".into(),
            world_from_sensor,
            ..NodeSettings::default()
        };
        let frames = Frames::new(&node);
        let mut tree = FrameTree::default();
        let transforms = vec![
            edge("world", "camera", 9.0),
            edge("camera", "depth", 0.2),
            edge("world", "base", 1.0),
        ];
        let here = |frame: &str, tree: &FrameTree| frames.world_from(frame, tree, [Stamp(0); 2]);
        assert_eq!(here("camera", &tree).unwrap(), world_from_sensor);
        assert!(here("depth", &tree).is_err());
        tree.fix(&TransformTree { transforms });
        assert_eq!(here("camera", &tree).unwrap(), world_from_sensor);
        let depth = world_from_sensor * Isometry::translation(0.2, 0.0, 0.0);
        assert!((here("depth", &tree).unwrap().inverse() * depth).translation.vector.norm() < 1e-9);
        for frame in ["", "world", "/world"] {
            assert_eq!(here(frame, &tree).unwrap(), Isometry::identity());
        }
        assert_eq!(here("base", &tree).unwrap(), Isometry::translation(1.0, 0.0, 0.0));
        let error = here("elsewhere", &tree).unwrap_err().to_string();
        assert!(error.contains("frame 'elsewhere'") && error.contains("('world')"), "{error}");
    }
}
