//! Reader of numbers of a mesh file, text or binary.

use std::str::FromStr;

use crate::mesh::msh::MshError;

/// Byte order of binary files, and the length of a size.
#[derive(Clone, Copy)]
struct BinaryFormat {
    is_big_endian: bool,
    size: usize,
}

/// Reader of a mesh file, with its position in the file. In text a number is a word and a row a line; in binary all numbers are
/// consecutive.
pub(super) struct MshReader<'a> {
    bytes: &'a [u8],
    offset: usize,
    /// Number of the current line, from 1; of text.
    line: usize,
    /// End of the current line of words; of text.
    row_end: Option<usize>,
    binary: Option<BinaryFormat>,
}

impl<'a> MshReader<'a> {
    /// Reader at the start of a file; a byte-order mark is skipped.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let offset = if bytes.starts_with(&[0xef, 0xbb, 0xbf]) { 3 } else { 0 };
        Self { bytes, offset, line: 0, row_end: None, binary: None }
    }

    /// Whether the file is in the binary format.
    pub(super) fn is_binary(&self) -> bool {
        self.binary.is_some()
    }

    /// Error at the current location of the file.
    pub(super) fn error<T>(&self, problem: impl Into<String>) -> Result<T, MshError> {
        Err(self.error_at(self.location(), problem.into()))
    }

    /// Number of the current line, or of the bytes that have been read in a binary section.
    pub(super) fn location(&self) -> usize {
        if self.is_binary() { self.offset } else { self.line }
    }

    /// Error at an earlier position.
    pub(super) fn error_at(&self, place: usize, problem: String) -> MshError {
        match self.binary {
            Some(_) => MshError::Binary { byte: place, problem },
            None => MshError::Syntax { line: place, problem },
        }
    }

    /// Remaining part of the current line without its line end; the reader advances to the next line.
    fn take_line(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.offset..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|byte| *byte == b'\n');
        self.offset += length.map_or(rest.len(), |length| length + 1);
        self.line += 1;
        self.row_end = None;
        Some(rest[..length.unwrap_or(rest.len())].trim_ascii())
    }

    /// Next line as text.
    pub(super) fn line(&mut self) -> Result<String, MshError> {
        match self.take_line() {
            Some(line) => Ok(String::from_utf8_lossy(line).into_owned()),
            None => {
                self.line += 1;
                self.error("the file ends in the middle of a section")
            }
        }
    }

    /// Header of the next section; `None` at the end of the file.
    pub(super) fn next_section(&mut self) -> Result<Option<String>, MshError> {
        while let Some(line) = self.take_line() {
            if line.is_empty() {
                continue;
            }
            let line = String::from_utf8_lossy(line).into_owned();
            if line.starts_with('$') {
                return Ok(Some(line));
            }
            let start: String = line.chars().take(20).collect();
            return self.error(format!("{start:?} is outside of any section"));
        }
        Ok(None)
    }

    /// Skips lines up to and including `end`.
    pub(super) fn skip_past(&mut self, end: &str) -> Result<(), MshError> {
        while self.line()? != end {}
        Ok(())
    }

    /// Reads the end of a section, before which binary files may have a line end.
    pub(super) fn read_section_end(&mut self, end: &str) -> Result<(), MshError> {
        let mut line = self.line()?;
        if self.is_binary() && line.is_empty() {
            line = self.line()?;
        }
        if line == end { Ok(()) } else { self.error(format!("{line:?} is in the place of {end}")) }
    }

    /// Begins the binary part of a file: determines the byte order from the test number that follows the header. `size` is the number of
    /// bytes of a size.
    pub(super) fn begin_binary_part(&mut self, size: usize) -> Result<(), MshError> {
        if size != 4 && size != 8 {
            return self.error(format!("has sizes of {size} bytes: only 4 and 8 are supported"));
        }
        let one: [u8; 4] = self.take_bytes("the number one")?;
        let is_big_endian = match (i32::from_le_bytes(one), i32::from_be_bytes(one)) {
            (1, _) => false,
            (_, 1) => true,
            _ => return self.error("is a binary mesh with an unknown order of bytes"),
        };
        self.binary = Some(BinaryFormat { is_big_endian, size });
        Ok(())
    }

    /// Next `N` bytes; `what` describes them in the message if the file ends before.
    fn take_bytes<const N: usize>(&mut self, what: &str) -> Result<[u8; N], MshError> {
        let found = self.bytes.get(self.offset..self.offset + N).and_then(|bytes| bytes.try_into().ok());
        let Some(found) = found else { return self.error(format!("the file ends before {what}")) };
        self.offset += N;
        Ok(found)
    }

    /// Next word of the row.
    fn next_word<T: FromStr<Err: std::fmt::Display>>(&mut self) -> Result<T, MshError> {
        if self.row_end.is_none() {
            let rest = self.bytes.get(self.offset..).filter(|rest| !rest.is_empty());
            self.line += 1;
            let Some(rest) = rest else { return self.error("the file ends in the middle of a section") };
            let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
            self.row_end = Some(self.offset + length);
        }
        let end = self.row_end.unwrap_or(self.offset);
        let row = &self.bytes[self.offset.min(end)..end];
        let begin = row.iter().position(|byte| !byte.is_ascii_whitespace());
        let Some(begin) = begin else { return self.error("has too few numbers") };
        let length = row[begin..].iter().position(u8::is_ascii_whitespace).unwrap_or(row.len() - begin);
        let word = String::from_utf8_lossy(&row[begin..begin + length]);
        self.offset += begin + length;
        word.parse().or_else(|error: T::Err| self.error(format!("{word:?}: {error}")))
    }

    /// Skips the remaining part of a row of text.
    pub(super) fn end_row(&mut self) {
        if let Some(end) = self.row_end.take() {
            self.offset = (end + 1).min(self.bytes.len());
        }
    }

    /// Next signed integer.
    pub(super) fn int(&mut self) -> Result<i64, MshError> {
        let Some(binary) = self.binary else { return self.next_word() };
        let bytes: [u8; 4] = self.take_bytes("a number")?;
        Ok(if binary.is_big_endian { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) }.into())
    }

    /// Next count that is stored as a signed integer.
    pub(super) fn size_of_int(&mut self) -> Result<u64, MshError> {
        let value = self.int()?;
        u64::try_from(value).or_else(|_| self.error(format!("{value} is not a count")))
    }

    /// Tag of a node or an element of version 2.
    pub(super) fn read_tag(&mut self) -> Result<u64, MshError> {
        if self.is_binary() { self.size_of_int() } else { self.next_word() }
    }

    /// Next count, or tag of a node or element in format version 4.
    pub(super) fn size(&mut self) -> Result<u64, MshError> {
        match self.binary {
            None => self.next_word(),
            Some(BinaryFormat { is_big_endian, size: 8 }) => {
                let bytes = self.take_bytes("a count")?;
                Ok(if is_big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
            }
            Some(BinaryFormat { is_big_endian, .. }) => {
                let bytes = self.take_bytes("a count")?;
                Ok(u64::from(if is_big_endian {
                    u32::from_be_bytes(bytes)
                } else {
                    u32::from_le_bytes(bytes)
                }))
            }
        }
    }

    /// Next floating-point number, in the text or binary format.
    pub(super) fn double(&mut self) -> Result<f64, MshError> {
        let Some(binary) = self.binary else { return self.next_word() };
        let bytes = self.take_bytes("a coordinate")?;
        Ok(if binary.is_big_endian { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) })
    }

    /// Next count of a section that is text also in binary files.
    pub(super) fn count_in_text(&mut self) -> Result<u64, MshError> {
        let line = self.line()?;
        let word = line.split_whitespace().next().unwrap_or_default();
        match word.parse() {
            Ok(count) => Ok(count),
            Err(_) if word.is_empty() => self.error("has too few numbers"),
            Err(error) => self.error(format!("{word:?}: {error}")),
        }
    }
}
