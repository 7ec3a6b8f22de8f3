//! A file taken apart, so that tests can put it together wrongly.

use serde_json::{Value, json};

/// A length, a header and numbers.
#[derive(Debug, Clone)]
pub(crate) struct File {
    pub(crate) header: Value,
    pub(crate) data: Vec<u8>,
}

impl File {
    pub(crate) fn of(bytes: &[u8]) -> Self {
        let (length, rest) = bytes.split_first_chunk::<8>().unwrap();
        let (header, data) = rest.split_at(u64::from_le_bytes(*length) as usize);
        Self { header: serde_json::from_slice(header).unwrap(), data: data.to_vec() }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        put_together(self.header.to_string().as_bytes(), &self.data)
    }

    /// The text beside the tensors.
    pub(crate) fn model(&self) -> Value {
        serde_json::from_str(self.header["__metadata__"]["model"].as_str().unwrap()).unwrap()
    }

    /// Changes the text beside the tensors.
    pub(crate) fn change_model(&mut self, change: impl FnOnce(&mut Value)) {
        let mut model = self.model();
        change(&mut model);
        self.header["__metadata__"]["model"] = json!(model.to_string());
    }

    /// Where a tensor's numbers are.
    pub(crate) fn range(&self, tensor: &str) -> std::ops::Range<usize> {
        let at = |end: usize| self.header[tensor]["data_offsets"][end].as_u64().unwrap() as usize;
        at(0)..at(1)
    }

    /// Puts 8 bytes in the place of a tensor's `n`th number.
    pub(crate) fn set(&mut self, tensor: &str, n: usize, number: [u8; 8]) {
        let start = self.range(tensor).start + 8 * n;
        self.data[start..start + 8].copy_from_slice(&number);
    }
}

pub(crate) fn put_together(header: &[u8], data: &[u8]) -> Vec<u8> {
    let mut bytes = (header.len() as u64).to_le_bytes().to_vec();
    bytes.extend(header);
    bytes.extend(data);
    bytes
}
