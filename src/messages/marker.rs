//! Shapes for viewers, and bodies of trackers that speak in shapes.

use serde::{Deserialize, Serialize};

use super::{Duration, Header, Message, Point3, Pose, Vector3};

/// `std_msgs/msg/ColorRGBA`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Color {
    /// Red, 0 to 1.
    pub r: f32,
    /// Green, 0 to 1.
    pub g: f32,
    /// Blue, 0 to 1.
    pub b: f32,
    /// Opacity, 0 to 1.
    pub a: f32,
}

/// `sensor_msgs/msg/CompressedImage`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// When, in which frame.
    pub header: Header,
    /// How it is compressed.
    pub format: String,
    /// The bytes.
    pub data: Vec<u8>,
}

/// `visualization_msgs/msg/UVCoordinate`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct UvCoordinate {
    /// From left.
    pub u: f32,
    /// From below.
    pub v: f32,
}

/// `visualization_msgs/msg/MeshFile`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshFile {
    /// The file's name.
    pub filename: String,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// `visualization_msgs/msg/Marker`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// When, in which frame.
    pub header: Header,
    /// With the id, what a later marker replaces.
    pub ns: String,
    /// With the namespace, what a later marker replaces.
    pub id: i32,
    /// One of [`Self::CUBE`] and the others.
    #[serde(rename = "type")]
    pub kind: i32,
    /// 0 adds, 2 deletes, 3 deletes all.
    pub action: i32,
    /// Of the shape.
    pub pose: Pose,
    /// `[m]`.
    pub scale: Vector3,
    /// Of all of it.
    pub color: Color,
    /// 0 for ever.
    pub lifetime: Duration,
    /// Whether it follows its frame.
    pub frame_locked: bool,
    /// `[m]`, of lines and lists.
    pub points: Vec<Point3>,
    /// One per point, or none.
    pub colors: Vec<Color>,
    /// Where the texture is.
    pub texture_resource: String,
    /// The texture.
    pub texture: CompressedImage,
    /// Of the texture.
    pub uv_coordinates: Vec<UvCoordinate>,
    /// Of text.
    pub text: String,
    /// Where the mesh is.
    pub mesh_resource: String,
    /// The mesh.
    pub mesh_file: MeshFile,
    /// Whether the mesh's colours count.
    pub mesh_use_embedded_materials: bool,
}

impl Marker {
    /// A box.
    pub const CUBE: i32 = 1;
    /// A ball.
    pub const SPHERE: i32 = 2;
    /// Lines between pairs of points.
    pub const LINE_LIST: i32 = 5;
    /// A ball at each point.
    pub const SPHERE_LIST: i32 = 7;
}

/// `visualization_msgs/msg/MarkerArray`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// The markers.
    pub markers: Vec<Marker>,
}

impl Message for MarkerArray {
    const TYPE: &'static str = "visualization_msgs/msg/MarkerArray";
}
