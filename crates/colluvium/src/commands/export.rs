//! `colluvium export`.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use colluvium::case::output::{
    Collection, OutputError, Table, frame_arrays, table_arrays, write_atomically, write_npz,
};
use colluvium::case::{Case, GrainColumns, PointList, Role, Snapshot};
use colluvium::depth_sph::hand_over::stacks;
use colluvium::pictures::frame;

use super::{Failure, a_run};

/// Name of the folder of the archives.
const FOLDER: &str = "npz";

#[derive(Args)]
pub struct Arguments {
    /// Folder of a run.
    folder: PathBuf,
    /// Write the last frame as `points.csv` instead: places, volumes, velocities, stresses and pore pressures that `bodies.points` of
    /// another case takes, by the same method or another one. Columns of depth-integrated flow become stacks of points.
    #[arg(long)]
    points: bool,
}

/// Name of the list of points.
const POINTS: &str = "points.csv";

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let from = &arguments.folder;
    a_run(from)?;
    if arguments.points {
        return points(from);
    }
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

/// Writes the last frame as a list of points.
fn points(from: &Path) -> Result<(), Failure> {
    let path = from.join("case.json");
    let case = Case::load(&path).map_err(|errors| OutputError::new(&path, errors.first()))?;
    let frames = Collection::read(&from.join("frames.pvd"))?.of_points();
    let last = frames.last().ok_or_else(|| OutputError::new(from, "holds no frame"))?;
    let snapshot = frame(from, last)?;
    let to = from.join(POINTS);
    let list = if snapshot.amounts(Role::Bed).is_some() {
        stacks(&case, &snapshot).map_err(|error| OutputError::new(&to, error))?
    } else {
        let problem = "the points of this run have no volume, velocity and stress";
        list(&snapshot).ok_or_else(|| OutputError::new(&to, problem))?
    };
    let text = table(&list, case.dimension());
    write_atomically(&to, text.as_bytes())?;
    say!("wrote the {} points at {} s to {}", list.positions.len(), snapshot.time, to.display());
    Ok(())
}

/// The points of a frame, as they are.
fn list(snapshot: &Snapshot) -> Option<PointList> {
    // Dry points have no pressure in their pores.
    let pressures = |all: &[f64]| all.iter().map(|p| if p.is_nan() { 0.0 } else { *p }).collect();
    Some(PointList {
        positions: snapshot.positions.clone(),
        volumes: snapshot.scalars("volume")?.to_vec(),
        velocities: Some(snapshot.vectors("velocity")?.to_vec()),
        stresses: Some(snapshot.tensors("stress")?.to_vec()),
        pore_pressures: snapshot.scalars(PointList::PORE_PRESSURE).map(pressures),
        grains: GrainColumns {
            radii: snapshot.scalars("radius").map(<[f64]>::to_vec),
            ..GrainColumns::default()
        },
    })
}

/// A list of points as a table with a head.
fn table(list: &PointList, dimension: usize) -> String {
    let axes = &["x", "y", "z"][..dimension];
    let mut heads: Vec<String> = axes.iter().map(|axis| format!("{axis} (m)")).collect();
    heads.push("volume (m3)".to_owned());
    let names =
        |names: &[&str], unit: &str| names.iter().map(|name| format!("{name} ({unit})")).collect::<Vec<_>>();
    heads.extend(list.velocities.iter().flat_map(|_| names(&PointList::VELOCITY[..dimension], "m/s")));
    heads.extend(list.stresses.iter().flat_map(|_| names(&PointList::STRESS, "Pa")));
    heads.extend(list.pore_pressures.iter().flat_map(|_| names(&[PointList::PORE_PRESSURE], "Pa")));
    heads.extend(list.grains.radii.iter().flat_map(|_| names(&["radius"], "m")));
    let mut text = heads.join(",") + "\n";
    for (i, x) in list.positions.iter().enumerate() {
        let mut row = x[..dimension].to_vec();
        row.push(list.volumes[i]);
        row.extend(list.velocities.iter().flat_map(|all| all[i][..dimension].to_vec()));
        row.extend(list.stresses.iter().flat_map(|all| all[i].0));
        row.extend(list.pore_pressures.iter().map(|all| all[i]));
        row.extend(list.grains.radii.iter().map(|all| all[i]));
        let row: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
        text += &(row.join(",") + "\n");
    }
    text
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
