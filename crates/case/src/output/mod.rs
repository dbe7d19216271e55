//! Output files of a run: frames for ParaView, tables, arrays, checksums.

mod atomic_files;
#[cfg(feature = "output")]
mod dataset_files;
#[cfg(feature = "output")]
mod derived_files;
mod file_names;
mod grid_averages;
#[cfg(feature = "output")]
mod npz;
pub(crate) mod plan_rasters;
mod table;
#[cfg(feature = "output")]
pub(crate) mod vtk;

pub use crate::error::OutputError;
pub use crate::files::checksum::{ChecksumWriter, FileChecksum};
pub use crate::output::atomic_files::{
    create_folder, read_json, write_atomically, write_in_place, write_stream_atomically,
};
#[cfg(feature = "output")]
pub use crate::output::dataset_files::{file_extension, write_dataset};
#[cfg(feature = "output")]
pub use crate::output::derived_files::{DERIVED, DerivedFiles};
pub use crate::output::file_names::{PLAIN_NAME_RULE, is_plain, named_file};
pub use crate::output::grid_averages::averages;
#[cfg(feature = "output")]
pub use crate::output::vtk::frames::{Collection, WriteOptions, read_frame, read_lines, write_frame};
#[cfg(feature = "output")]
pub use npz::{NpzArray, NpzValues, frame_arrays, read_npz, table_arrays, write_npz};
pub use table::{Table, TableFile, column_heading};
