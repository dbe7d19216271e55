//! Checksums: length and hash of a file, which show later whether the file has changed.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::OutputError;

/// Length (bytes) and FNV-1a hash (64 bits) of a file. They detect damage and edits, not forgery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileChecksum {
    /// Number of bytes.
    pub bytes: u64,
    /// Hash of the bytes (FNV-1a, 64 bits).
    pub fnv1a: u64,
}

impl Default for FileChecksum {
    fn default() -> Self {
        Self { bytes: 0, fnv1a: 0xcbf2_9ce4_8422_2325 }
    }
}

impl FileChecksum {
    /// Computes the checksum of bytes.
    pub fn of_bytes(bytes: &[u8]) -> Self {
        let mut checksum = Self::default();
        checksum.add(bytes);
        checksum
    }

    /// Computes the checksum of a file, or of its first `length` bytes.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn of_file(path: &Path, length: Option<u64>) -> Result<Self, OutputError> {
        let mut writer = ChecksumWriter { writer: io::sink(), checksum: Self::default() };
        File::open(path)
            .and_then(|file| io::copy(&mut file.take(length.unwrap_or(u64::MAX)), &mut writer))
            .map_err(|error| OutputError::new(path, error))?;
        Ok(writer.checksum)
    }

    /// Adds bytes to the checksum.
    pub fn add(&mut self, bytes: &[u8]) {
        self.bytes += bytes.len() as u64;
        let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        self.fnv1a = bytes.iter().fold(self.fnv1a, step);
    }
}

/// Writer that computes the checksum of its output.
pub struct ChecksumWriter<W> {
    /// Target of the output.
    pub writer: W,
    /// Checksum of the bytes written so far.
    pub checksum: FileChecksum,
}

impl<W: Write> Write for ChecksumWriter<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.writer.write(bytes)?;
        self.checksum.add(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_published_test_vectors() {
        // Test values of the authors of the hash (Fowler, Noll and Vo): empty, "a", "foobar".
        let known =
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)];
        for (text, fnv1a) in known {
            assert_eq!(
                FileChecksum::of_bytes(text.as_bytes()),
                FileChecksum { bytes: text.len() as u64, fnv1a }
            );
        }
    }

    #[test]
    fn checksums_of_a_file_and_of_its_first_bytes_match_those_bytes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("f");
        std::fs::write(&path, "foobar").unwrap();
        assert_eq!(FileChecksum::of_file(&path, None).unwrap(), FileChecksum::of_bytes(b"foobar"));
        assert_eq!(FileChecksum::of_file(&path, Some(3)).unwrap(), FileChecksum::of_bytes(b"foo"));
        assert_eq!(FileChecksum::of_file(&path, Some(99)).unwrap(), FileChecksum::of_bytes(b"foobar"));
        assert!(FileChecksum::of_file(&dir.path().join("none"), None).is_err());
    }
}
