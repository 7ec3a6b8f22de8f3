//! The safetensors container: a length, a JSON header, numbers.

use std::collections::BTreeMap;

use safetensors::Dtype;
use safetensors::tensor::Metadata;
use serde_json::error::Category;
use serde_json::json;

use super::error::{shortened_name, shortened_reason};
use super::{Model, ModelError, TensorFault};
use crate::formats::shortened_to;

/// What the metadata says the file is.
pub(super) const FORMAT: &str = "handover_mesh model";
/// Of positions and of stamps.
pub(super) const UNITS: &str = "m, ns";
/// Bytes of the header's length.
const LENGTH: usize = 8;

/// A tensor's name, type and shape.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub(super) name: String,
    pub(super) dtype: Dtype,
    pub(super) shape: Vec<usize>,
}

impl Layout {
    /// All tensors of a model, in the order of their numbers in the file: the one place that
    /// knows them.
    ///
    /// - `frames`: of each demonstration.
    pub(super) fn of_model(
        frames: impl Iterator<Item = usize>,
        joints: usize,
        edges: usize,
        phases: usize,
    ) -> Vec<Self> {
        let one = |name: String, dtype, shape: &[usize]| Self { name, dtype, shape: shape.into() };
        let mut all = Vec::new();
        for (n, frames) in frames.enumerate() {
            let positions = format!("demonstration.{n}.positions");
            all.push(one(positions, Dtype::F64, &[frames, joints, 3]));
            all.push(one(format!("demonstration.{n}.stamps"), Dtype::I64, &[frames]));
        }
        all.push(one("edges".to_owned(), Dtype::I64, &[edges, 2]));
        all.push(one("weights".to_owned(), Dtype::F64, &[edges, phases]));
        all
    }
}

/// The header's length and the header, keys sorted, padded so that the numbers are aligned.
///
/// The crate writes metadata in the order of a hash map, another one in every run; hence by hand.
pub(super) fn header(metadata: BTreeMap<&str, String>, tensors: &[Layout]) -> Vec<u8> {
    let mut entries = BTreeMap::from([("__metadata__", json!(metadata))]);
    let mut start = 0;
    for Layout { name, dtype, shape } in tensors {
        let end = start + shape.iter().product::<usize>() * dtype.bitsize() / 8;
        let entry = json!({ "data_offsets": [start, end], "dtype": dtype, "shape": shape });
        entries.insert(name, entry);
        start = end;
    }
    let mut text = json!(entries).to_string().into_bytes();
    text.resize(text.len().next_multiple_of(LENGTH), b' ');
    let mut header = (text.len() as u64).to_le_bytes().to_vec();
    header.append(&mut text);
    header
}

/// A file whose header tells of exactly the bytes that follow it.
pub(super) struct Container<'a> {
    header: Metadata,
    data: &'a [u8],
}

impl<'a> Container<'a> {
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, ModelError> {
        let not_safetensors = || {
            let start = String::from_utf8_lossy(&bytes[..bytes.len().min(24)]);
            ModelError::NotSafetensors { start: shortened_to(24, &start) }
        };
        let (length, rest) = bytes.split_first_chunk().ok_or_else(not_safetensors)?;
        // The format has no magic number, but a JSON object starts in only one way.
        if rest.first() != Some(&b'{') {
            return Err(not_safetensors());
        }
        let header = u64::from_le_bytes(*length);
        if header > Model::MOST_HEADER as u64 {
            return Err(ModelError::HeaderTooLarge { bytes: header, most: Model::MOST_HEADER });
        }
        let Some((text, data)) = rest.split_at_checked(header as usize) else {
            return Err(ModelError::HeaderBeyondFile { header, file: rest.len() });
        };
        let header: Metadata = serde_json::from_slice(text).map_err(|error| {
            let reason = shortened_reason(&error);
            match error.classify() {
                Category::Data => ModelError::Header { reason },
                _ => ModelError::HeaderNotJson { reason },
            }
        })?;
        let (expected, got) = (header.data_len(), data.len());
        if expected != got {
            return Err(ModelError::DataLength { expected, got });
        }
        Ok(Self { header, data })
    }

    /// An entry of `__metadata__`.
    pub(super) fn metadata(&self, key: &'static str) -> Result<&str, ModelError> {
        let value = self.header.metadata().as_ref().and_then(|metadata| metadata.get(key));
        value.map(String::as_str).ok_or(ModelError::MissingMetadata { key })
    }

    /// Checks that these tensors are there and no others.
    pub(super) fn check(&self, expected: &[Layout]) -> Result<(), ModelError> {
        let mut faults: Vec<TensorFault> =
            expected.iter().filter_map(|layout| self.fault(layout)).collect();
        let mut names = self.header.offset_keys();
        names.sort_unstable();
        let mut known: Vec<&str> = expected.iter().map(|layout| layout.name.as_str()).collect();
        known.sort_unstable();
        let unknown = names.iter().filter(|name| known.binary_search(&name.as_str()).is_err());
        faults.extend(unknown.map(|name| TensorFault::Unknown { name: shortened_name(name) }));
        if faults.is_empty() {
            return Ok(());
        }
        let more = faults.len().saturating_sub(ModelError::MOST);
        faults.truncate(ModelError::MOST);
        Err(ModelError::Tensors { faults, more })
    }

    fn fault(&self, expected: &Layout) -> Option<TensorFault> {
        let name = expected.name.clone();
        let Some(found) = self.header.info(&name) else {
            return Some(TensorFault::Missing { name });
        };
        if found.dtype != expected.dtype {
            let (expected, got) = (expected.dtype.to_string(), found.dtype.to_string());
            return Some(TensorFault::Type { name, expected, got });
        }
        if found.shape != expected.shape {
            // Some shape of a hostile header may have a million sides.
            let sides: Vec<_> = found.shape.iter().take(10).map(ToString::to_string).collect();
            let end = if found.shape.len() > sides.len() { ", …]" } else { "]" };
            let got = format!("[{}{end}", sides.join(", "));
            return Some(TensorFault::Shape { name, expected: expected.shape.clone(), got });
        }
        None
    }

    /// The bytes of a tensor that [`Self::check`] has found, 8 for each number.
    pub(super) fn numbers(&self, layout: &Layout) -> impl Iterator<Item = [u8; 8]> + '_ {
        let range = self.header.info(&layout.name).map_or((0, 0), |info| info.data_offsets);
        // The crate has checked that each tensor's range lies within the data.
        let bytes = self.data.get(range.0..range.1).unwrap_or(&[]);
        bytes.as_chunks().0.iter().copied()
    }
}
