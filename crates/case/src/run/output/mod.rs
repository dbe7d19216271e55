//! Files of a run: the recorder of measures and frames, the folder and its lock, the summary, and messages to the user.

pub(crate) mod measure_row;
pub(crate) mod messages;
pub(crate) mod recorder;
pub(crate) mod run_folder;
pub(crate) mod summary;
