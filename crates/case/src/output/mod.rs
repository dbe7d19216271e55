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

pub use dataset::{file_extension, write_dataset};
pub use derived::{DERIVED, DerivedFiles};
pub use files::{
    OutputError, create_folder, read_json, write_atomically, write_in_place, write_stream_atomically,
};
pub use frame::{Collection, WriteOptions, read_frame, read_lines, write_frame};
pub use grid_frame::{averages, grid_nodes};
pub use names::{PLAIN_NAME_RULE, is_plain, named_file};
pub use npz::{NpzArray, NpzValues, frame_arrays, read_npz, table_arrays, write_npz};
pub use seal::{ChecksumWriter, FileChecksum};
pub use table::{Table, TableFile, column_heading};
