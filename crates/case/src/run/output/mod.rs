//! Files of a run: the recorder of measures and frames, the folder and its lock, the summary, and warnings.

pub(crate) mod measure_row;
pub(crate) mod rasters;
pub(crate) mod recorder;
pub(crate) mod run_folder;
pub(crate) mod summary;
pub(crate) mod warnings;
