//! What a run writes: frames for ParaView, tables, summaries.

mod files;
mod frame;
mod grid_frame;
mod names;
mod npz;
mod seal;
mod table;

pub use files::{OutputError, read_json, write_atomically, write_through};
pub use frame::{Collection, read_frame, write_frame, write_lines};
pub use grid_frame::{GridFrame, grid_nodes, write_grid};
pub use names::{PLAIN, is_plain, named_file};
pub use npz::{Array, Values, frame_arrays, read_npz, table_arrays, write_npz};
pub use seal::{Seal, Sealed};
pub use table::{Table, TableFile, heading};
