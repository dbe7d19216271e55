//! Folder of a run: the names of its files, and the removal of files of an earlier run.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io::{BufReader, Read, Seek, Write};
use std::path::{Path, PathBuf};

use crate::SolverError;
use crate::output::{
    ChecksumWriter, Collection, FileChecksum, OutputError, TableFile, create_folder, write_stream_atomically,
};
use crate::run::RunError;

/// File name of the case.
pub(crate) const CASE: &str = "case.json";
/// File name of the checkpoint.
pub(crate) const CHECKPOINT: &str = "checkpoint.bin";
/// File name of the summary.
pub(crate) const SUMMARY: &str = "summary.json";
/// File name of the table of measures.
pub(crate) const MEASURES: &str = "measures.csv";
/// File name of the ParaView collection of the frames.
pub(crate) const COLLECTION: &str = "frames.pvd";
/// Name of the folder of frames.
pub(crate) const FRAMES: &str = "frames";
/// Name of the folder of rasters.
pub(crate) const RASTERS: &str = "rasters";
/// Name of the map in the folder of rasters.
pub(crate) const MAP: &str = "map.png";

/// Conventions of the columns, at the top of each table.
const TABLE_CONVENTIONS: &str = "SI units; stress tension-positive, pressure compression-positive; per metre of thickness in \
                     plane strain, per radian in axisymmetry";

/// Name of the file of frame `number` of a dataset.
pub(crate) fn frame(dataset: &str, number: usize, ending: &str) -> String {
    format!("{FRAMES}/{dataset}-{number:05}.{ending}")
}

/// Dataset and number in the name of a frame file.
pub(crate) fn parse_frame_name(file: &str) -> Option<(&str, usize)> {
    let (stem, _) = file.strip_prefix(FRAMES)?.strip_prefix('/')?.split_once('.')?;
    let (dataset, number) = stem.rsplit_once('-')?;
    Some((dataset, number.parse().ok()?))
}

/// File name of the ParaView collection of a further dataset: any but the first one of the frames.
pub(crate) fn collection_file_name(dataset: &str) -> String {
    format!("{dataset}.pvd")
}

/// Names of the lists of frame files in a folder.
pub(crate) fn collections(out: &Path) -> Result<Vec<String>, OutputError> {
    let mut names = names(out)?;
    names.retain(|name| {
        let listed = || Collection::read(&out.join(name)).map(|collection| collection.frames);
        let of_run = |(_, file): &(f64, String)| parse_frame_name(file).is_some();
        name == COLLECTION
            || name.ends_with(".pvd")
                && listed().is_ok_and(|files| !files.is_empty() && files.iter().all(of_run))
    });
    Ok(names)
}

/// Name of the file of a profile.
pub(crate) fn profile(name: &str) -> String {
    format!("profile-{name}.csv")
}

/// Name of the table of the trials of a search for a factor of safety.
pub(crate) fn trials(name: &str) -> String {
    format!("trials-{name}.csv")
}

/// Name of the file of points at the end of the last failing trial of a search.
pub(crate) fn failing_points_file(name: &str) -> String {
    format!("failing-{name}.vtu")
}

/// Name of the file with the state of the solver at the end of stage `stage`.
pub(crate) fn state(stage: usize) -> String {
    format!("state-{stage}.bin")
}

/// Whether a file belongs to a search for the factor of safety.
fn is_of_search(name: &str) -> bool {
    is_trials(name) || is_failing(name) || is_state(name)
}

/// Whether a file is the table of the trials of a search.
pub(crate) fn is_trials(name: &str) -> bool {
    name.starts_with("trials-") && name.ends_with(".csv")
}

/// Whether a file is a frame of the failing bodies of a search.
pub(crate) fn is_failing(name: &str) -> bool {
    name.starts_with("failing-") && name.ends_with(".vtu")
}

/// Whether a file is a state at the end of a stage.
fn is_state(name: &str) -> bool {
    name.starts_with("state-") && name.ends_with(".bin")
}

/// Whether a file is a table of surface profiles.
fn is_profile(name: &str) -> bool {
    name.starts_with("profile-") && name.ends_with(".csv")
}

/// Names of the entries of a folder; none where it does not exist.
pub(crate) fn names(folder: &Path) -> Result<Vec<String>, OutputError> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let fail = |error| OutputError::new(folder, error);
    let entries: Result<Vec<_>, _> = fs::read_dir(folder).map_err(fail)?.collect();
    Ok(entries.map_err(fail)?.iter().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect())
}

/// Name of a file in the folder that may belong to a run; `None` without one.
pub(crate) fn existing_run_file(out: &Path) -> Result<Option<String>, OutputError> {
    let own = [CASE, MEASURES, FRAMES, RASTERS];
    let is_own = |name: &String| {
        own.contains(&name.as_str()) || name.ends_with(".pvd") || is_profile(name) || is_of_search(name)
    };
    Ok(names(out)?.into_iter().find(is_own))
}

/// Removes a file where it exists.
fn remove(file: &Path) -> Result<(), OutputError> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(OutputError::new(file, error)),
        _ => Ok(()),
    }
}

/// Creates the folder of a run with its folder of frames.
pub(crate) fn create(out: &Path) -> Result<(), OutputError> {
    create_folder(&out.join(FRAMES))
}

/// Writes a state with its checksum, which [`read_state`] verifies.
pub(crate) fn write_state(
    path: &Path,
    state: impl FnOnce(&mut dyn Write) -> Result<(), SolverError>,
) -> Result<(), RunError> {
    let mut failed = None;
    let written = write_stream_atomically(path, |file| {
        let mut writer = ChecksumWriter { writer: file, checksum: FileChecksum::default() };
        if let Err(error) = state(&mut writer) {
            failed = Some(error);
            return Err(std::io::Error::other("not written"));
        }
        let checksum = writer.checksum.fnv1a.to_le_bytes();
        writer.writer.write_all(&checksum)
    });
    match failed {
        Some(error) => Err(error.into()),
        None => Ok(written?),
    }
}

/// Opens a file with the state of a solver after the verification of its checksum.
///
/// # Errors
/// When the file cannot be read or is damaged.
pub(crate) fn read_state(path: &Path) -> Result<impl Read + use<>, OutputError> {
    let fail = |error| OutputError::new(path, error);
    let damaged = || OutputError::coded(path, "checkpoint-damaged", "is damaged: run the case anew");
    let mut file = File::open(path).map_err(fail)?;
    let length = file.metadata().map_err(fail)?.len();
    let length = length.checked_sub(size_of::<u64>() as u64).ok_or_else(damaged)?;
    let mut writer = ChecksumWriter { writer: std::io::sink(), checksum: FileChecksum::default() };
    std::io::copy(&mut (&file).take(length), &mut writer).map_err(fail)?;
    let mut checksum = [0; size_of::<u64>()];
    file.read_exact(&mut checksum).map_err(fail)?;
    if u64::from_le_bytes(checksum) != writer.checksum.fnv1a {
        return Err(damaged());
    }
    file.rewind().map_err(fail)?;
    Ok(BufReader::new(file.take(length)))
}

/// Creates the folder where it is missing, and locks it for this run as long as the returned file is open. `None` where folders cannot be
/// locked.
///
/// # Errors
/// When the folder cannot be created, or another run has locked it.
pub(crate) fn lock(out: &Path) -> Result<Option<File>, OutputError> {
    create_folder(out)?;
    let Ok(folder) = File::open(out) else { return Ok(None) };
    match folder.try_lock() {
        Ok(()) => Ok(Some(folder)),
        Err(TryLockError::WouldBlock) => {
            Err(OutputError::coded(out, "folder-in-use", "another run is writing here"))
        }
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

/// Reserved space on the disk (bytes) for the summary of a run that fails because the disk is full.
const RESERVED_BYTES: usize = 1 << 16;

/// Reserves space on the disk for a summary and for `text`, by a nameless file, until the returned file is closed.
pub(crate) fn reserve_space(out: &Path, text: &str) -> Option<File> {
    let mut file = tempfile::tempfile_in(out).ok()?;
    file.write_all(&vec![1; RESERVED_BYTES + 2 * text.len()]).and_then(|()| file.sync_all()).ok()?;
    Some(file)
}

/// Whether a file in the folder of rasters has the name of a raster of a method.
pub(crate) fn is_map(name: &str) -> bool {
    let name = name.strip_suffix(".tmp").unwrap_or(name);
    if name == MAP {
        return true;
    }
    let Some((stem, "asc" | "tif" | "prj")) = name.rsplit_once('.') else { return false };
    stem.starts_with("peak_") || stem.starts_with("final_") || ["arrival_time", "bed_change"].contains(&stem)
}

/// Whether a file in the folder of frames is a frame, complete or partial.
pub(crate) fn is_frame(name: &str) -> bool {
    let name = name.strip_suffix(".tmp").unwrap_or(name);
    let ending = [".vtu", ".vtr"].iter().any(|ending| name.ends_with(ending));
    ending && parse_frame_name(&format!("{FRAMES}/{name}")).is_some()
}

/// Removes a folder if it is empty.
fn remove_empty(folder: &Path) -> Result<(), OutputError> {
    if !folder.is_dir() || !names(folder)?.is_empty() {
        return Ok(());
    }
    fs::remove_dir(folder).map_err(|error| OutputError::new(folder, error))
}

/// Removes a run with its folder. Files that are not of a run remain.
///
/// # Errors
/// When a file cannot be removed.
pub fn remove_run(out: &Path) -> Result<(), OutputError> {
    clear(out)?;
    [CASE, SUMMARY].iter().try_for_each(|name| remove(&out.join(name)))?;
    remove_empty(out)
}

/// Removes all files of a run except its case and its summary. Files that are not of a run remain.
pub(crate) fn clear(out: &Path) -> Result<(), OutputError> {
    for name in collections(out)?.iter().map(String::as_str).chain([CHECKPOINT, MEASURES]) {
        remove(&out.join(name))?;
    }
    keep_profiles(out, &[])?;
    names(out)?.iter().filter(|name| is_of_search(name)).try_for_each(|name| remove(&out.join(name)))?;
    remove_partial_files(out)?;
    for (name, is_own) in [(FRAMES, is_frame as fn(&str) -> bool), (RASTERS, is_map)] {
        let folder = out.join(name);
        let own = names(&folder)?.into_iter().filter(|name| is_own(name));
        own.map(|name| folder.join(name)).try_for_each(|file| remove(&file))?;
        remove_empty(&folder)?;
    }
    Ok(())
}

/// Removes all tables of surface profiles except those with the names `kept`.
pub(crate) fn keep_profiles(out: &Path, kept: &[&str]) -> Result<(), OutputError> {
    let stale = |name: &&String| is_profile(name) && !kept.contains(&name.as_str());
    names(out)?.iter().filter(stale).try_for_each(|name| remove(&out.join(name)))
}

/// Removes partial files of a killed run.
pub(crate) fn remove_partial_files(out: &Path) -> Result<(), OutputError> {
    for name in [CASE, CHECKPOINT, SUMMARY] {
        remove(&out.join(format!("{name}.tmp")))?;
    }
    let torn = |name: &&String| name.ends_with(".pvd.tmp");
    names(out)?.iter().filter(torn).try_for_each(|name| remove(&out.join(name)))?;
    let frames = out.join(FRAMES);
    let torn = |name: &&String| name.ends_with(".vtu.tmp") || name.ends_with(".vtr.tmp");
    names(&frames)?.iter().filter(torn).try_for_each(|name| remove(&frames.join(name)))
}

/// Tables of a run on disk, by file name; empty without a folder.
#[derive(Debug, Default)]
pub(crate) struct Tables {
    folder: Option<PathBuf>,
    files: BTreeMap<String, TableFile>,
}

impl Tables {
    /// Creates an empty set of tables in a folder.
    pub(crate) fn new(folder: Option<PathBuf>) -> Self {
        Self { folder, files: BTreeMap::new() }
    }

    /// Adds rows to a table, which is created at its first rows.
    pub(crate) fn append(
        &mut self,
        name: &str,
        columns: &[(String, String)],
        rows: &[Vec<f64>],
    ) -> Result<(), OutputError> {
        let Some(out) = &self.folder else { return Ok(()) };
        if !self.files.contains_key(name) {
            self.files
                .insert(name.to_owned(), TableFile::create(&out.join(name), TABLE_CONVENTIONS, columns)?);
        }
        self.files.get_mut(name).map_or(Ok(()), |file| file.append(rows))
    }

    /// Synchronises all rows to the disk; returns name and checksum of each table.
    pub(crate) fn sync(&self) -> Result<Vec<(String, FileChecksum)>, OutputError> {
        self.files.iter().map(|(name, file)| Ok((name.clone(), file.sync()?))).collect()
    }

    /// Reopens the tables at the lengths of their checksums. None is changed where one of them cannot be opened.
    pub(crate) fn resume(&mut self, checksums: &[(String, FileChecksum)]) -> Result<(), OutputError> {
        let Some(out) = &self.folder else { return Ok(()) };
        let mut files = BTreeMap::new();
        for (name, checksum) in checksums {
            files.insert(name.clone(), TableFile::open(&out.join(name), *checksum)?);
        }
        files.values_mut().try_for_each(TableFile::truncate)?;
        self.files = files;
        Ok(())
    }
}
