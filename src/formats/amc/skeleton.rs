//! A person's bones as an ASF file describes them, checked to be a tree.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::UnitQuaternion;

use super::axes::{Axis, Order};
use super::read_skeleton;
use crate::formats::ReadError;
use crate::geometry::Vector;

/// A bone of an [`Asf`]: its place in the file's order, which is that of [`Asf::bones`].
///
/// ```
/// # let text = ":units\n length 1\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n\
/// #   position 0 0 0\n orientation 0 0 0\n:bonedata\n begin\n name arm\n direction 1 0 0\n\
/// #   length 10\n axis 0 0 0 XYZ\n dof rz\n limits (-90 90)\n end\n\
/// #   :hierarchy\n begin\n root arm\n end\n";
/// use handover_mesh::formats::amc::Asf;
/// let skeleton = Asf::read(text.as_bytes())?;
/// let arm = skeleton.bone("arm").unwrap();
/// let end = skeleton.positions_in_root(&[0.0])[arm.index()];
/// assert!((end.x - skeleton[arm].length()).abs() < 1e-12);
/// # Ok::<(), handover_mesh::formats::ReadError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BoneId(pub(super) u16);

impl BoneId {
    /// The bone's place among [`Asf::bones`] and in a frame's positions.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// A degree of freedom: an axis that a bone may turn about.
///
/// ```
/// # let text = ":units\n length 1\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n\
/// #   position 0 0 0\n orientation 0 0 0\n:bonedata\n begin\n name arm\n direction 1 0 0\n\
/// #   length 10\n axis 0 0 0 XYZ\n dof rz\n limits (-90 90)\n end\n\
/// #   :hierarchy\n begin\n root arm\n end\n";
/// use handover_mesh::formats::amc::{Asf, Axis};
/// let skeleton = Asf::read(text.as_bytes())?;
/// let dof = skeleton.bones()[0].dofs()[0];
/// assert_eq!(dof.axis, Axis::Z);
/// assert_eq!(dof.limits, Some([-90_f64.to_radians(), 90_f64.to_radians()]));
/// # Ok::<(), handover_mesh::formats::ReadError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dof {
    /// The axis, in the bone's own frame.
    pub axis: Axis,
    /// The least and the greatest angle `[rad]` that the file allows, if it says so; ±∞ where it
    /// is open.
    pub limits: Option<[f64; 2]>,
}

/// A rigid bone: where it hangs, how long it is and which way it points, about what it turns.
///
/// ```
/// # let text = ":units\n length 1\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n\
/// #   position 0 0 0\n orientation 0 0 0\n:bonedata\n begin\n name arm\n direction 1 0 0\n\
/// #   length 10\n axis 0 0 0 XYZ\n dof rz\n limits (-90 90)\n end\n\
/// #   :hierarchy\n begin\n root arm\n end\n";
/// use handover_mesh::formats::amc::Asf;
/// let skeleton = Asf::read(text.as_bytes())?;
/// let arm = &skeleton.bones()[0];
/// assert_eq!((arm.name(), arm.parent(), arm.channels()), ("arm", None, 0..1));
/// assert!((arm.length() - 0.254).abs() < 1e-12); // ten inches
/// # Ok::<(), handover_mesh::formats::ReadError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Bone {
    pub(super) name: String,
    pub(super) id: Option<u64>,
    pub(super) parent: Option<BoneId>,
    pub(super) length: f64,
    /// In the file's axes, y up, at unit length.
    pub(super) direction: Vector,
    /// `C`: the frame that the bone turns in, from the file's axes.
    pub(super) frame: UnitQuaternion<f64>,
    pub(super) dofs: Box<[Dof]>,
    pub(super) first_channel: usize,
}

impl Bone {
    /// The bone's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number that the file gives the bone, if it gives any.
    pub fn id(&self) -> Option<u64> {
        self.id
    }

    /// The bone that this one starts at the end of; `None` if it starts at the root.
    pub fn parent(&self) -> Option<BoneId> {
        self.parent
    }

    /// Length `[m]`, ≥ 0.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Where the bone points when no angle is turned, at unit length, in the file's axes (y up).
    pub fn direction(&self) -> Vector {
        self.direction
    }

    /// What the bone turns about: the first turns first.
    pub fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    /// The places of the bone's angles among a frame's.
    pub fn channels(&self) -> Range<usize> {
        self.first_channel..self.first_channel + self.dofs.len()
    }
}

/// What the file says of the root at rest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RootAtRest {
    /// Each of the six values of a motion's `root` line, as it comes.
    pub(super) order: [RootChannel; 6],
    /// Which axis the root turns about first, second and last.
    pub(super) turns: Order,
    /// `[m]`, in the file's axes.
    pub(super) position: Vector,
    /// `C`: the frame that the root turns in, from the file's axes.
    pub(super) frame: UnitQuaternion<f64>,
}

/// One of the root's six values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RootChannel {
    Translation(Axis),
    Rotation(Axis),
}

/// A skeleton in the Acclaim format: the root, and bones that hang from it as a tree.
///
/// ```
/// use handover_mesh::formats::amc::Asf;
/// let text = "
/// :units
///   length 0.45
///   angle deg
/// :root
///   order TX TY TZ RX RY RZ
///   axis XYZ
///   position 0 0 0
///   orientation 0 0 0
/// :bonedata
///   begin
///     name thigh
///     direction 0 -1 0
///     length 7.2
///     axis 0 0 20 XYZ
///     dof rx rz
///     limits (-160 20)
///            (-70 70)
///   end
///   begin
///     name shin
///     direction 0 -1 0
///     length 8.1
///     axis 0 0 20 XYZ
///     dof rx
///   end
/// :hierarchy
///   begin
///     root thigh
///     thigh shin
///   end
/// ";
/// let skeleton = Asf::read(text.as_bytes())?;
/// assert_eq!(skeleton.channel_names(), ["thigh.rx", "thigh.rz", "shin.rx"]);
/// let shin = skeleton.bone("shin").unwrap();
/// assert_eq!(skeleton[shin].parent(), skeleton.bone("thigh"));
/// assert!((skeleton[shin].length() - 8.1 / 0.45 * 0.0254).abs() < 1e-12); // [m]
/// # Ok::<(), handover_mesh::formats::ReadError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Asf {
    pub(super) name: Option<String>,
    pub(super) metres_per_unit: f64,
    pub(super) mass: Option<f64>,
    pub(super) root: RootAtRest,
    pub(super) bones: Box<[Bone]>,
    pub(super) by_name: BTreeMap<String, BoneId>,
    /// Every bone after the one that it hangs from.
    pub(super) outwards: Box<[BoneId]>,
}

impl Asf {
    /// More bones than any skeleton has; files with more are refused.
    pub const MOST_BONES: usize = 1000;

    /// Reads an ASF file.
    ///
    /// Lengths are `value / (:units length) · 0.0254` metres: the unit is an inch scaled, as CMU
    /// defines it. Angles come in the unit that the file names.
    ///
    /// # Errors
    /// [`ReadError`] lists every violation: sections, keys and numbers, bones given twice, bones
    /// that are not placed exactly once below the root, degrees of freedom other than `rx`, `ry`
    /// and `rz`.
    pub fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        read_skeleton::read(bytes)
    }

    /// What the file calls the skeleton, if it names it.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// What one of the file's units of length is `[m]`.
    pub fn metres_per_unit(&self) -> f64 {
        self.metres_per_unit
    }

    /// What the file's masses are multiplied with, if it says so; no mass is read.
    pub fn mass(&self) -> Option<f64> {
        self.mass
    }

    /// The bones, in the file's order.
    pub fn bones(&self) -> &[Bone] {
        &self.bones
    }

    /// The bone of this name; the root is none.
    pub fn bone(&self, name: &str) -> Option<BoneId> {
        self.by_name.get(name).copied()
    }

    /// How many angles a frame has, the root's left out.
    pub fn channel_count(&self) -> usize {
        self.bones.last().map_or(0, |bone| bone.channels().end)
    }

    /// What each angle of a frame is: `lfemur.rx`, in the order of the bones and their degrees of
    /// freedom.
    pub fn channel_names(&self) -> Vec<String> {
        let of_bone = |bone: &Bone| {
            let name = |dof: &Dof| format!("{}.r{}", bone.name, dof.axis.letter());
            bone.dofs.iter().map(name).collect::<Vec<_>>()
        };
        self.bones.iter().flat_map(of_bone).collect()
    }
}

impl std::ops::Index<BoneId> for Asf {
    type Output = Bone;
    /// # Panics
    /// If the id is another skeleton's, which has more bones.
    fn index(&self, bone: BoneId) -> &Bone {
        &self.bones[bone.index()]
    }
}
