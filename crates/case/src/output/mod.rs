//! What a run writes: frames for ParaView, tables, summaries.

mod blocks;
mod dataset;
mod derived;
mod files;
mod frame;
mod grid_frame;
mod names;
mod npz;
mod seal;
mod table;
mod xml;

pub use dataset::{file_ending, write_dataset};
pub use derived::{DERIVED, DerivedFiles};
pub use files::{OutputError, create_folder, read_json, write_atomically, write_in_place, write_through};
pub use frame::{Collection, Written, read_frame, read_lines, write_frame};
pub use grid_frame::{averages, grid_nodes};
pub use names::{PLAIN, is_plain, named_file};
pub use npz::{Array, Values, frame_arrays, read_npz, table_arrays, write_npz};
pub use seal::{Seal, Sealed};
pub use table::{Table, TableFile, heading};
