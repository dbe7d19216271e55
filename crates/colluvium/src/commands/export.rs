//! `colluvium export`.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use colluvium::case::output::{Collection, OutputError, Table, frame_arrays, table_arrays, write_npz};
use colluvium::pictures::frame;

use super::{Failure, a_run};

/// Name of the folder of the archives.
const FOLDER: &str = "npz";

#[derive(Args)]
pub struct Arguments {
    /// Folder of a run.
    folder: PathBuf,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let from = &arguments.folder;
    a_run(from)?;
    let to = from.join(FOLDER);
    fs::create_dir_all(&to).map_err(|error| OutputError::new(&to, error))?;
    clear(&to)?;
    let mut written = 0;
    for name in tables(from)? {
        let table = Table::read(&from.join(&name))?;
        write_npz(&to.join(&name).with_extension("npz"), &table_arrays(&table))?;
        written += 1;
    }
    let collection = from.join("frames.pvd");
    let frames = if collection.exists() { Collection::read(&collection)?.frames } else { Vec::new() };
    for (number, shown) in frames.iter().enumerate() {
        let archive = to.join(format!("frame-{number:05}.npz"));
        write_npz(&archive, &frame_arrays(&frame(from, shown)?))?;
        written += 1;
    }
    say!("wrote {written} archives to {}", to.display());
    Ok(())
}

/// Removes the archives of an earlier export.
fn clear(folder: &Path) -> Result<(), OutputError> {
    let archives = names(folder)?.into_iter().filter(|name| name.ends_with(".npz"));
    archives
        .map(|name| folder.join(name))
        .try_for_each(|file| fs::remove_file(&file).map_err(|error| OutputError::new(&file, error)))
}

/// Names of what is in a folder, in order.
fn names(folder: &Path) -> Result<Vec<String>, OutputError> {
    let fail = |error| OutputError::new(folder, error);
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        names.push(entry.map_err(fail)?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Names of the tables in the folder of a run.
fn tables(folder: &Path) -> Result<Vec<String>, OutputError> {
    let is_table = |name: &String| {
        let kinds = ["profile-", "trials-"];
        name == "measures.csv" || (name.ends_with(".csv") && kinds.iter().any(|kind| name.starts_with(kind)))
    };
    Ok(names(folder)?.into_iter().filter(is_table).collect())
}
