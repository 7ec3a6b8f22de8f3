//! One person's motion as an AMC file has it: the root apart from the joint angles.

use std::num::NonZeroU32;

use super::read_motion;
use super::skeleton::Asf;
use crate::formats::ReadError;
use crate::geometry::{Point, Vector};
use crate::time::Stamp;

/// Where the root is in one frame, in the file's axes (y up).
///
/// ```
/// use handover_mesh::{Vector, formats::amc::Root};
/// let standing = Root { translation: Vector::new(0.0, 0.9, 0.0), ..Root::default() };
/// assert_eq!(standing.rotation, [0.0; 3]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Root {
    /// From the skeleton's own place `[m]`.
    pub translation: Vector,
    /// About x, y and z `[rad]`, in the order that the skeleton tells.
    pub rotation: [f64; 3],
}

/// The motion of one person: in every frame the root's place, and an angle for each degree of
/// freedom of the skeleton.
///
/// ```
/// use handover_mesh::formats::amc::{Asf, Motion};
/// # let skeleton = ":units\n length 1\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n\
/// #   position 0 0 0\n orientation 0 0 0\n:bonedata\n begin\n name arm\n direction 1 0 0\n\
/// #   length 10\n axis 0 0 0 XYZ\n dof rz\n limits (-90 90)\n end\n\
/// #   :hierarchy\n begin\n root arm\n end\n";
/// let skeleton = Asf::read(skeleton.as_bytes())?; // an arm of 0.254 m along x, turning about z
/// let text = ":FULLY-SPECIFIED\n:DEGREES\n\
///     80\nroot 0 40 0 0 0 0\narm 0\n\
///     81\nroot 0 40 0 0 0 0\narm 90\n";
/// let motion = Motion::read(text.as_bytes(), &skeleton)?;
/// assert_eq!((motion.len(), motion.first_number()), (2, 80));
/// assert_eq!(motion.stamp(1).0, 8_333_333); // 120 Hz
/// assert_eq!(motion.angles(1), [90_f64.to_radians()]);
/// let end = motion.positions(1)[0]; // the file's y is up, here z
/// assert!((end.z - 50.0 * 0.0254).abs() < 1e-12 && end.x.abs() < 1e-12);
/// # Ok::<(), handover_mesh::formats::ReadError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    pub(super) skeleton: Asf,
    pub(super) rate: NonZeroU32,
    pub(super) first_number: u64,
    pub(super) roots: Vec<Root>,
    /// Frame by frame.
    pub(super) angles: Vec<f64>,
}

impl Motion {
    /// Frames a second `[Hz]` of the CMU database; the format does not hold the rate.
    pub const USUAL_RATE: NonZeroU32 = NonZeroU32::new(120).expect("not zero");

    /// Reads an AMC file of this skeleton, at 120 Hz.
    ///
    /// Frames may start at any number. Angles come out in radians, lengths in metres.
    ///
    /// # Errors
    /// [`ReadError`] lists every violation: no frames, frame numbers that do not rise by one,
    /// bones that are unknown, missing or given twice, wrong counts of values, what is no finite
    /// number, an end of the file amid a frame or a line.
    pub fn read(bytes: &[u8], skeleton: &Asf) -> Result<Self, ReadError> {
        Self::read_at(bytes, skeleton, Self::USUAL_RATE)
    }

    /// As [`Motion::read`], at `rate` frames a second `[Hz]`.
    ///
    /// # Errors
    /// As those of [`Motion::read`].
    pub fn read_at(bytes: &[u8], skeleton: &Asf, rate: NonZeroU32) -> Result<Self, ReadError> {
        read_motion::read(bytes, skeleton, rate)
    }

    /// The skeleton that moves.
    pub fn skeleton(&self) -> &Asf {
        &self.skeleton
    }

    /// Frames a second `[Hz]`.
    pub fn rate(&self) -> NonZeroU32 {
        self.rate
    }

    /// How many frames there are, at least one.
    #[expect(clippy::len_without_is_empty, reason = "a motion has frames")]
    pub fn len(&self) -> usize {
        self.roots.len()
    }

    /// The number that the file gives the first frame; the others follow one by one.
    pub fn first_number(&self) -> u64 {
        self.first_number
    }

    /// When the frame is, to the nearest nanosecond; the first is at 0.
    pub fn stamp(&self, frame: usize) -> Stamp {
        let rate = i128::from(self.rate.get());
        let nearest = (frame as i128 * 1_000_000_000 + rate / 2) / rate;
        Stamp(i64::try_from(nearest).unwrap_or(i64::MAX))
    }

    /// When each frame is.
    pub fn stamps(&self) -> impl ExactSizeIterator<Item = Stamp> {
        (0..self.len()).map(|frame| self.stamp(frame))
    }

    /// The frame's joint angles `[rad]`, as the file has them, one for each of
    /// [`Motion::channel_names`].
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn angles(&self, frame: usize) -> &[f64] {
        assert!(frame < self.len(), "frame {frame} of {}", self.len());
        let channels = self.skeleton.channel_count();
        &self.angles[frame * channels..][..channels]
    }

    /// Where the root is in the frame.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn root(&self, frame: usize) -> &Root {
        &self.roots[frame]
    }

    /// What each angle is: `lfemur.rx`; the skeleton's [`Asf::channel_names`].
    pub fn channel_names(&self) -> Vec<String> {
        self.skeleton.channel_names()
    }

    /// Where every bone ends in the frame `[m]`, z up, in the order of [`Asf::bones`].
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn positions(&self, frame: usize) -> Vec<Point> {
        self.skeleton.positions(self.root(frame), self.angles(frame))
    }

    /// As [`Motion::positions`] with the root taken out: at the origin, not turned.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn positions_in_root(&self, frame: usize) -> Vec<Point> {
        self.skeleton.positions_in_root(self.angles(frame))
    }
}
