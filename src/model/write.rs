//! A model → bytes, the same for the same model.

use std::collections::BTreeMap;

use super::Model;
use super::container::{self, FORMAT, Layout, UNITS};
use crate::mesh::Vertex;
use crate::skeleton::Role;

impl Model {
    fn layout(&self) -> Vec<Layout> {
        let frames = self.demonstrations().iter().map(|d| d.recording().len());
        let edges = self.edges();
        Layout::of_model(frames, self.pair().len(), edges.edges().len(), edges.phases())
    }

    /// The version of the format that it is written in: the oldest that holds it.
    pub fn format_version(&self) -> u64 {
        let skeletons = [Role::First, Role::Second].map(|role| self.pair().skeleton(role));
        if skeletons.iter().any(|skeleton| skeleton.attached().len() > 0) { 2 } else { 1 }
    }

    /// All before the numbers.
    pub(super) fn header(&self) -> Vec<u8> {
        let metadata = BTreeMap::from([
            ("format", FORMAT.to_owned()),
            ("format_version", self.format_version().to_string()),
            ("model", self.contents()),
            ("program_version", self.program_version().to_owned()),
            ("units", UNITS.to_owned()),
        ]);
        container::header(metadata, &self.layout())
    }
}

/// The header and, in the order of [`Layout::of_model`], the numbers.
pub(super) fn write(model: &Model) -> Vec<u8> {
    let mut bytes = model.header();
    let sizes = model.layout().into_iter().map(|l| 8 * l.shape.iter().product::<usize>());
    bytes.reserve_exact(sizes.sum());
    for demonstration in model.demonstrations() {
        let recording = demonstration.recording();
        let [first, second] = [Role::First, Role::Second].map(|r| &recording.person(r).motion);
        for (first, second) in first.frames().iter().zip(second.frames()) {
            for point in first.positions.iter().chain(&second.positions) {
                bytes.extend(point.iter().flat_map(|metres| metres.to_le_bytes()));
            }
        }
        bytes.extend(recording.stamps().flat_map(|stamp| stamp.0.to_le_bytes()));
    }
    let edges = model.edges().edges();
    let ends = edges.iter().flat_map(|learned| learned.edge.ends().map(Vertex::index));
    bytes.extend(ends.flat_map(|end| (end as i64).to_le_bytes()));
    let factors = edges.iter().flat_map(|learned| &learned.factors);
    bytes.extend(factors.flat_map(|factor| factor.to_le_bytes()));
    bytes
}
