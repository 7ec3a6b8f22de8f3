//! A bag's files in memory, by whoever opens them.

use std::io;

use super::super::error::ReadError;
use super::super::input::{FileError, LARGEST, bytes_within};
use super::super::up::UpAxis;
use super::{File, Read, file_names, read};

/// Why a bag's files are not had.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// Its metadata are none, or name what is not in the folder.
    #[error(transparent)]
    Metadata(#[from] ReadError),
    /// A file that is there.
    #[error("{name}: {error}")]
    File {
        /// As the metadata name it.
        name: String,
        /// What is wrong.
        error: FileError,
    },
    /// Together they are larger than [`LARGEST`].
    #[error("its files together are larger than {} MiB", LARGEST >> 20)]
    TooLarge,
}

/// The files of a bag, in memory.
#[derive(Debug, Clone)]
pub struct Files {
    /// Those that are not there are none.
    files: Vec<(String, Option<Vec<u8>>)>,
    metadata: Option<String>,
}

impl Files {
    /// Those that a folder's metadata name; one that is not there is a loss, no error. Together they
    /// are not larger than [`LARGEST`].
    ///
    /// - `metadata`: the text of `metadata.yaml`.
    /// - `open`: opens the file of a name in the folder; what is no plain file is not there.
    ///
    /// # Errors
    /// [`FolderError`].
    pub fn of_folder<F: io::Read>(
        metadata: String,
        mut open: impl FnMut(&str) -> io::Result<F>,
    ) -> Result<Self, FolderError> {
        let (mut files, mut left) = (Vec::new(), LARGEST);
        for name in file_names(&metadata)? {
            let bytes = match open(&name) {
                Ok(file) => bytes_within(file, left).map(Some),
                Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
                Err(error) => Err(FileError::Unreadable(error)),
            };
            let bytes = match bytes {
                Ok(bytes) => bytes,
                Err(FileError::TooLarge) if left < LARGEST => return Err(FolderError::TooLarge),
                Err(error) => return Err(FolderError::File { name, error }),
            };
            left -= bytes.as_ref().map_or(0, Vec::len) as u64;
            files.push((name, bytes));
        }
        Ok(Self { files, metadata: Some(metadata) })
    }

    /// A bare file.
    pub fn of_file(name: String, bytes: Vec<u8>) -> Self {
        Self { files: vec![(name, Some(bytes))], metadata: None }
    }

    /// The recording, as [`read`] has it.
    ///
    /// - `name`: what the recording is called.
    ///
    /// # Errors
    /// As [`read`].
    pub fn read(&self, name: &str, up: UpAxis) -> Result<Read, ReadError> {
        let files: Vec<File<'_>> =
            self.files.iter().map(|(name, bytes)| File { name, bytes: bytes.as_deref() }).collect();
        read(&files, self.metadata.as_deref(), name, up)
    }

    /// What is in those that are there, in order.
    pub fn bytes(&self) -> impl Iterator<Item = &[u8]> {
        self.files.iter().filter_map(|(_, bytes)| bytes.as_deref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const METADATA: &str =
        "rosbag2_bagfile_information:\n  relative_file_paths: [a.mcap, b.mcap]\n";

    #[test]
    fn a_missing_file_is_a_loss_and_an_unreadable_one_says_why() {
        let open = |kind: io::ErrorKind| {
            Files::of_folder(METADATA.to_owned(), move |name| match name {
                "a.mcap" => Ok(&b"bytes"[..]),
                _ => Err(io::Error::from(kind)),
            })
        };
        let found = open(io::ErrorKind::NotFound).unwrap();
        assert_eq!(found.bytes().collect::<Vec<_>>(), [b"bytes"]);
        let error = open(io::ErrorKind::PermissionDenied).unwrap_err();
        assert_eq!(error.to_string(), "b.mcap: cannot be read: permission denied");
        let error = Files::of_folder(String::new(), |_| Ok(io::empty())).unwrap_err();
        assert!(matches!(error, FolderError::Metadata(_)), "{error}");
    }
}
