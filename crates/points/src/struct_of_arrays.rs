//! Structures of arrays: one list of columns defines sorting, removal, memory and checkpoints.
//!
//! [`struct_of_arrays!`](crate::struct_of_arrays!) declares a struct whose fields are vectors with one entry per point. A column that a
//! problem does not use is empty, and remains so in every operation.
//!
//! ```
//! use colluvium_points::{ScratchBuffers, struct_of_arrays};
//!
//! struct_of_arrays! {
//!     /// Grains.
//!     pub struct Grains<const D: usize> {
//!         /// Ids.
//!         pub id: u32,
//!         /// Centres (m).
//!         pub position: [f64; D],
//!         /// Spins (rad/s); empty without rotation.
//!         pub spin: f64,
//!     }
//! }
//!
//! let mut grains = Grains::<2> { id: vec![7, 8, 9], position: vec![[0.0; 2], [1.0; 2], [2.0; 2]], ..Grains::default() };
//! grains.reorder(&[2, 0], &mut ScratchBuffers::default());
//! assert_eq!((grains.id.as_slice(), grains.spin.len()), ([9, 7].as_slice(), 0));
//!
//! let mut bytes = Vec::new();
//! grains.write(&mut bytes)?;
//! let mut again = Grains::<2>::default();
//! again.read(&mut bytes.as_slice())?;
//! assert_eq!(again, grains);
//! # Ok::<(), std::io::Error>(())
//! ```

use std::any::Any;
use std::io::{self, Read, Write};
use std::ops::Range;

/// Bytes per read or write.
const IO_CHUNK_BYTES: usize = 1 << 16;

/// Value with a fixed number of bytes, little-endian in a file.
pub trait FixedBytes: Copy + Send + 'static {
    /// Number of bytes of a value.
    const BYTE_COUNT: usize;

    /// Appends the bytes of the value.
    fn append_bytes(self, out: &mut Vec<u8>);

    /// Reads a value from [`FixedBytes::BYTE_COUNT`] bytes.
    fn from_bytes(bytes: &[u8]) -> Self;
}

macro_rules! fixed_bytes_of_number {
    ($($number:ty),+) => {$(
        impl FixedBytes for $number {
            const BYTE_COUNT: usize = size_of::<$number>();

            fn append_bytes(self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }

            fn from_bytes(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$number>()];
                own.copy_from_slice(bytes);
                Self::from_le_bytes(own)
            }
        }
    )+};
}
fixed_bytes_of_number!(f64, u8, u16, u32, u64, i32, i64);

impl FixedBytes for bool {
    const BYTE_COUNT: usize = 1;

    fn append_bytes(self, out: &mut Vec<u8>) {
        out.push(u8::from(self));
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        bytes[0] != 0
    }
}

impl<T: FixedBytes, const N: usize> FixedBytes for [T; N] {
    const BYTE_COUNT: usize = N * T::BYTE_COUNT;

    fn append_bytes(self, out: &mut Vec<u8>) {
        self.into_iter().for_each(|value| value.append_bytes(out));
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        std::array::from_fn(|i| T::from_bytes(&bytes[i * T::BYTE_COUNT..(i + 1) * T::BYTE_COUNT]))
    }
}

/// Buffers that permutations of columns reuse, one for each type of column, so that repeated sorting allocates no memory.
#[derive(Default)]
pub struct ScratchBuffers {
    buffers: Vec<Box<dyn Any + Send + Sync>>,
}

impl ScratchBuffers {
    /// Buffer of a type, made at its first use.
    fn buffer<T: Send + Sync + 'static>(&mut self) -> &mut Vec<T> {
        let number = self.buffers.iter().position(|buffer| buffer.is::<Vec<T>>()).unwrap_or_else(|| {
            self.buffers.push(Box::new(Vec::<T>::new()));
            self.buffers.len() - 1
        });
        match self.buffers[number].downcast_mut() {
            Some(buffer) => buffer,
            None => unreachable!("the buffer was found by its type"),
        }
    }
}

/// Permutes the entries of `range`: entry `i` becomes the old entry `order[i]`. Entries that `order` does not name are removed. An empty
/// column remains empty.
pub fn reorder_entries<T: Copy + Send + Sync + 'static>(
    column: &mut Vec<T>,
    range: Range<usize>,
    order: &[u32],
    spare: &mut ScratchBuffers,
) {
    if column.is_empty() {
        return;
    }
    let old = spare.buffer::<T>();
    old.clear();
    old.extend_from_slice(&column[range.clone()]);
    let gone = range.len() - order.len();
    for (value, &from) in column[range.start..].iter_mut().zip(order) {
        *value = old[from as usize];
    }
    column.drain(range.end - gone..range.end);
}

/// Retains the entries of a column that are `kept`, in their order. An empty column remains empty.
pub fn retain_entries<T>(column: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    column.retain(|_| kept.next() == Some(&true));
}

/// Replaces a column by copies of the entries `indices` of another one. It becomes empty where that is empty.
pub fn copy_entries<T: Copy>(column: &mut Vec<T>, from: &[T], indices: &[u32]) {
    column.clear();
    if !from.is_empty() {
        column.extend(indices.iter().map(|&i| from[i as usize]));
    }
}

/// Overwrites entry `indices[k]` of a column by entry `k` of another one. It is unchanged where that is empty.
pub fn overwrite_entries<T: Copy>(column: &mut [T], from: &[T], indices: &[u32]) {
    indices.iter().zip(from).for_each(|(&i, value)| column[i as usize] = *value);
}

/// Replaces a column by copies of the entries `(part, number)` of several columns. It becomes empty where these are empty.
pub fn gather_entries<'a, T: Copy + 'a>(
    column: &mut Vec<T>,
    part: impl Fn(usize) -> &'a [T],
    parts: usize,
    picks: &[(u32, u32)],
) {
    column.clear();
    if (0..parts).any(|number| !part(number).is_empty()) {
        column.extend(picks.iter().map(|&(number, k)| part(number as usize)[k as usize]));
    }
}

/// Writes a column: its number of entries, then their bytes.
///
/// # Errors
/// When writing to `out` fails.
pub fn write_column<T: Copy, R: FixedBytes>(
    column: &[T],
    raw: impl Fn(T) -> R,
    out: &mut dyn Write,
) -> io::Result<()> {
    out.write_all(&(column.len() as u64).to_le_bytes())?;
    let mut bytes = Vec::with_capacity(IO_CHUNK_BYTES + R::BYTE_COUNT);
    for value in column {
        raw(*value).append_bytes(&mut bytes);
        if bytes.len() >= IO_CHUNK_BYTES {
            out.write_all(&bytes)?;
            bytes.clear();
        }
    }
    out.write_all(&bytes)
}

/// Replaces a column by one that [`write_column`] has written. A number of entries beyond the bytes that follow allocates no memory for
/// them.
///
/// # Errors
/// When `input` ends early or reading fails.
pub fn read_column<T, R: FixedBytes>(
    column: &mut Vec<T>,
    value: impl Fn(R) -> T,
    input: &mut dyn Read,
) -> io::Result<()> {
    let mut count = [0; 8];
    input.read_exact(&mut count)?;
    let mut left = u64::from_le_bytes(count);
    column.clear();
    let at_once = (IO_CHUNK_BYTES / R::BYTE_COUNT.max(1)).max(1) as u64;
    let mut bytes = Vec::new();
    while left > 0 {
        let now = left.min(at_once);
        bytes.resize(now as usize * R::BYTE_COUNT, 0);
        input.read_exact(&mut bytes)?;
        column.reserve(now as usize);
        column.extend(
            (0..now as usize)
                .map(|i| value(R::from_bytes(&bytes[i * R::BYTE_COUNT..(i + 1) * R::BYTE_COUNT]))),
        );
        left -= now;
    }
    Ok(())
}

/// Error for bytes that are no valid columns.
#[must_use]
pub fn invalid_data(problem: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem)
}

/// Declares a structure of arrays (see the [module](mod@crate::struct_of_arrays)). The first column has an entry for every point; each
/// other column has as many, or none. A column whose type is not [`FixedBytes`] names a type for its bytes, with conversions both ways:
/// `pub stress: SymTensor as [f64; 6]`.
#[macro_export]
macro_rules! struct_of_arrays {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident $(<$(const $d:ident : usize),+>)? {
            $(#[$first_meta:meta])*
            $first_vis:vis $first:ident : $first_type:ty,
            $($(#[$column_meta:meta])* $column_vis:vis $column:ident : $type:ty $(as $raw:ty)?,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, Default, PartialEq)]
        $vis struct $name $(<$(const $d: usize),+>)? {
            $(#[$first_meta])*
            $first_vis $first: Vec<$first_type>,
            $($(#[$column_meta])* $column_vis $column: Vec<$type>,)*
        }

        #[allow(dead_code, reason = "not every store uses every operation")]
        impl $(<$(const $d: usize),+>)? $name $(<$($d),+>)? {
            /// Names of the columns.
            pub const COLUMNS: &'static [&'static str] = &[stringify!($first) $(, stringify!($column))*];

            /// Number of points.
            #[must_use]
            pub fn len(&self) -> usize {
                self.$first.len()
            }

            /// Whether there is no point.
            #[must_use]
            pub fn is_empty(&self) -> bool {
                self.$first.is_empty()
            }

            /// Memory of the entries (bytes).
            #[must_use]
            pub fn bytes(&self) -> usize {
                size_of_val(&self.$first[..]) $(+ size_of_val(&self.$column[..]))*
            }

            /// Name of the first column that is neither empty nor has an entry per point.
            #[must_use]
            pub fn uneven(&self) -> Option<&'static str> {
                let counts: &[usize] = &[self.$first.len() $(, self.$column.len())*];
                let uneven = counts.iter().position(|&count| count != 0 && count != self.len());
                uneven.map(|number| Self::COLUMNS[number])
            }

            /// Whether the same columns are in use as in `other`; true without points.
            #[must_use]
            pub fn uses_columns_of(&self, other: &Self) -> bool {
                let alike: &[bool] = &[$(self.$column.is_empty() == other.$column.is_empty()),*];
                self.is_empty() || other.is_empty() || alike.iter().all(|alike| *alike)
            }

            /// Permutes the points: point `i` becomes the old point `order[i]`. Points that `order` does not name are removed.
            pub fn reorder(&mut self, order: &[u32], spare: &mut $crate::ScratchBuffers) {
                self.reorder_range(0..self.len(), order, spare);
            }

            /// Permutes the points of `range` as `reorder`, with numbers relative to its start.
            pub fn reorder_range(&mut self, range: std::ops::Range<usize>, order: &[u32], spare: &mut $crate::ScratchBuffers) {
                $crate::struct_of_arrays::reorder_entries(&mut self.$first, range.clone(), order, spare);
                $($crate::struct_of_arrays::reorder_entries(&mut self.$column, range.clone(), order, spare);)*
            }

            /// Replaces all points by copies of the points `indices` of `from`.
            pub fn gather_from(&mut self, from: &Self, indices: &[u32]) {
                $crate::struct_of_arrays::copy_entries(&mut self.$first, &from.$first, indices);
                $($crate::struct_of_arrays::copy_entries(&mut self.$column, &from.$column, indices);)*
            }

            /// Overwrites point `indices[k]` by point `k` of `from`.
            pub fn scatter_from(&mut self, from: &Self, indices: &[u32]) {
                $crate::struct_of_arrays::overwrite_entries(&mut self.$first, &from.$first, indices);
                $($crate::struct_of_arrays::overwrite_entries(&mut self.$column, &from.$column, indices);)*
            }

            /// Replaces all points by copies of the points `(part, number)` of several `parts`.
            pub fn gather(&mut self, parts: &[&Self], picks: &[(u32, u32)]) {
                $crate::struct_of_arrays::gather_entries(&mut self.$first, |part| &parts[part].$first, parts.len(), picks);
                $($crate::struct_of_arrays::gather_entries(&mut self.$column, |part| &parts[part].$column, parts.len(), picks);)*
            }

            /// Retains the points whose number `keep` accepts, in their order; returns their number.
            pub fn retain(&mut self, keep: impl Fn(usize) -> bool) -> usize {
                let kept: Vec<bool> = (0..self.len()).map(keep).collect();
                $crate::struct_of_arrays::retain_entries(&mut self.$first, &kept);
                $($crate::struct_of_arrays::retain_entries(&mut self.$column, &kept);)*
                self.len()
            }

            /// Moves all points of `other` to the end. Both must use the same columns.
            pub fn append(&mut self, other: &mut Self) {
                self.$first.append(&mut other.$first);
                $(self.$column.append(&mut other.$column);)*
                debug_assert_eq!(self.uneven(), None);
            }

            /// Retains the first `count` points.
            pub fn truncate(&mut self, count: usize) {
                self.$first.truncate(count);
                $(self.$column.truncate(count);)*
            }

            /// Writes all columns, with their names.
            ///
            /// # Errors
            /// When writing to `out` fails.
            pub fn write(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
                let names = Self::COLUMNS.join(",");
                $crate::struct_of_arrays::write_column(names.as_bytes(), std::convert::identity, out)?;
                $crate::struct_of_arrays::write_column(&self.$first, std::convert::identity, out)?;
                $($crate::write_field!(self.$column, out $(, $raw)?);)*
                Ok(())
            }

            /// Reads columns written by `write`, in place of the contents.
            ///
            /// # Errors
            /// When the bytes are those of other columns, or end early; the contents are then invalid.
            pub fn read(&mut self, input: &mut dyn std::io::Read) -> std::io::Result<()> {
                let mut names: Vec<u8> = Vec::new();
                $crate::struct_of_arrays::read_column(&mut names, std::convert::identity, input)?;
                if names != Self::COLUMNS.join(",").as_bytes() {
                    return Err($crate::struct_of_arrays::invalid_data(concat!("not the columns of ", stringify!($name))));
                }
                $crate::struct_of_arrays::read_column(&mut self.$first, std::convert::identity, input)?;
                $($crate::read_field!(self.$column, input $(, $raw)?);)*
                match self.uneven() {
                    Some(column) => Err($crate::struct_of_arrays::invalid_data(&format!("column {column} does not have one entry per point"))),
                    None => Ok(()),
                }
            }
        }
    };
}

/// Writes one column of [`struct_of_arrays!`](crate::struct_of_arrays!). It has no closures: each would be compiled anew for every column.
#[doc(hidden)]
#[macro_export]
macro_rules! write_field {
    ($column:expr, $out:expr) => {
        $crate::struct_of_arrays::write_column(&$column, std::convert::identity, $out)?
    };
    ($column:expr, $out:expr, $raw:ty) => {
        $crate::struct_of_arrays::write_column(&$column, <$raw>::from, $out)?
    };
}

/// Reads one column of [`struct_of_arrays!`](crate::struct_of_arrays!).
#[doc(hidden)]
#[macro_export]
macro_rules! read_field {
    ($column:expr, $input:expr) => {
        $crate::struct_of_arrays::read_column(&mut $column, std::convert::identity, $input)?
    };
    ($column:expr, $input:expr, $raw:ty) => {
        $crate::struct_of_arrays::read_column(&mut $column, <$raw>::into, $input)?
    };
}
