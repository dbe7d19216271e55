//! `colluvium export`.

use std::fs;
use std::path::{Path, PathBuf};

use crate::case::description::Space;
use crate::case::output::{
    Collection, DerivedFiles, OutputError, Table, create_folder, frame_arrays, read_json, table_arrays,
    write_atomically, write_npz,
};
use crate::case::{Case, FieldRole, GrainColumns, PointList, Snapshot};
use crate::depth_sph::point_stacks;
use crate::output::run_pictures::read_collection_frame;
use clap::Args;

use super::{
    CommandError, LibraryArguments, check_run_folder, or_default_with_warning, print_note, print_warning,
};
use crate::case::Warning;

/// Name of the folder of the archives.
const ARCHIVE_FOLDER: &str = "npz";

#[derive(Args)]
#[command(after_help = "Usual calls:\n  colluvium export slope-mpm\n  colluvium export slope-mpm --points")]
pub struct ExportArguments {
    /// Folder of a run.
    folder: PathBuf,
    /// Write the last frame as `points.csv` instead: positions, volumes, masses, velocities, stresses and pore pressures for `bodies.points`
    /// of another case, with the same method or another one; of grains also radius, kind, spin, id and held. Columns of depth-integrated
    /// flow become stacks of points.
    #[arg(long)]
    points: bool,
    /// Name of the body whose points are written; all bodies by default.
    #[arg(long, requires = "points")]
    body: Option<String>,
    /// Replace files of equal names, even those that colluvium did not write.
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Name of the table of the measures.
const MEASURES_FILE: &str = "measures.csv";
/// Name of the list of points.
const POINTS_FILE: &str = "points.csv";

/// Writes the frames and tables of a run as NPZ archives, or its last frame as a list of points.
pub fn run(arguments: &ExportArguments) -> Result<(), CommandError> {
    let from = &arguments.folder;
    check_run_folder(from)?;
    if arguments.points {
        return write_point_list(from, arguments);
    }
    let to = from.join(ARCHIVE_FOLDER);
    create_folder(&to)?;
    let mut files = DerivedFiles::open(&to, arguments.overwrite)?;
    remove_earlier_archives(&to, &files)?;
    let mut written = 0;
    for name in table_names(from)? {
        let table = or_default_with_warning(Table::read(&from.join(&name)), "it is not exported");
        if table.columns.is_empty() {
            continue;
        }
        let archive = name.replace(".csv", ".npz");
        files.write(&archive, |file| write_npz(file, &table_arrays(&table)))?;
        written += 1;
    }
    let frames =
        or_default_with_warning(Collection::read(&from.join("frames.pvd")), "no frames are exported").frames;
    for (number, shown) in frames.iter().enumerate() {
        let arrays = frame_arrays(&read_collection_frame(from, shown)?);
        files.write(&format!("frame-{number:05}.npz"), |file| write_npz(file, &arrays))?;
        written += 1;
    }
    if written == 0 {
        return Err(OutputError::new(from, "has no tables or frames to export").into());
    }
    print_line!("wrote {written} archives to {}", to.display());
    Ok(())
}

/// Writes the last frame as a list of points: all of them, or those of one body.
fn write_point_list(from: &Path, arguments: &ExportArguments) -> Result<(), CommandError> {
    let mut files = DerivedFiles::open(from, arguments.overwrite)?;
    files.check(POINTS_FILE)?;
    let path = from.join("case.json");
    let case = match Case::from_file(&path) {
        Ok(case) => case,
        Err(errors) => {
            let case = Case::load_without_files(&path);
            let case = case.map_err(|errors| OutputError::new(&path, errors.first()))?;
            print_warning(&Warning::new(
                "results-missing",
                format!("{}: the points are exported without the files of the case", errors.first()),
            ));
            case
        }
    };
    let frames = Collection::read(&from.join("frames.pvd"))?.of_points();
    let last = frames.last().ok_or_else(|| OutputError::new(from, "has no frame"))?;
    let snapshot = read_collection_frame(from, last)?;
    let to = from.join(POINTS_FILE);
    let list = if snapshot.role_values(FieldRole::Bed).is_some() {
        point_stacks(&case, &snapshot).map_err(|error| OutputError::new(&to, error))?
    } else {
        if read_json(&from.join("summary.json"))?["method"] == "dem" {
            check_grain_columns(&case, &snapshot).map_err(|problem| OutputError::new(&to, problem))?;
        }
        let problem = "the points of this run have no volume, velocity and stress";
        point_list(&case, &snapshot).ok_or_else(|| OutputError::new(&to, problem))?
    };
    let kept = match &arguments.body {
        Some(name) => point_indices_of_body(&case, &snapshot, &list, name)?,
        None => (0..list.positions.len()).collect(),
    };
    let text = point_table(&list, case.dimension(), &kept);
    files.write(POINTS_FILE, |file| write_atomically(file, text.as_bytes()))?;
    print_line!("wrote the {} points at {} s to {}", kept.len(), snapshot.time, to.display());
    if let Some([point_mass, whole]) = mass_mismatch(&snapshot, &list) {
        print_note(&Warning::new(
            "fluid-without-grains",
            format!(
                "the mass of the points is {point_mass:.6e} kg, and that of the flow {whole:.6e} kg: the points represent the grains with the fluid around them, \
             and {:.4e} kg of fluid have no grains nearby",
                whole - point_mass
            ),
        ));
    }
    Ok(())
}

/// Masses of a list of points and of its frame (kg) where they differ. For grains and fluid, points represent the grains.
fn mass_mismatch(snapshot: &Snapshot, list: &PointList) -> Option<[f64; 2]> {
    let outside = snapshot.scalars("outside");
    let inside = |node: usize| outside.is_none_or(|outside| outside[node] == 0.0);
    let own = snapshot.scalars(PointList::MASS)?.iter().enumerate().filter(|(node, _)| inside(*node));
    let masses = [list.masses.as_ref()?.iter().sum::<f64>(), own.map(|(_, mass)| mass).sum()];
    ((masses[0] / masses[1] - 1.0).abs() > 1e-9).then_some(masses)
}

/// Reports an error for a frame without the fields of grains that another case needs.
fn check_grain_columns(case: &Case, snapshot: &Snapshot) -> Result<(), String> {
    let Some(written) = &case.output.fields else { return Ok(()) };
    let of_bodies = case.methods.get("dem").and_then(|options| options.get("bodies")?.as_object());
    let held = of_bodies.is_some_and(|bodies| bodies.values().any(|own| own["held"] == true))
        || case.bodies.iter().any(|body| body.rigid || body.points.is_some());
    let wanted = ["radius", "kind", "spin"].into_iter().chain(held.then_some("held"));
    let missing: Vec<&str> = wanted
        .filter(|name| snapshot.field(name).is_none() && !written.iter().any(|own| own == name))
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(format!(
        "the frames of this run have no field {}: output.fields does not contain it",
        missing.join(", ")
    ))
}

/// Indices of the points of a body.
fn point_indices_of_body(
    case: &Case,
    snapshot: &Snapshot,
    list: &PointList,
    name: &str,
) -> Result<Vec<usize>, CommandError> {
    let number = case.bodies.iter().position(|body| body.name == name).map(|number| number as u32);
    let own = |i: &usize| snapshot.bodies.get(*i).copied() == number;
    let kept: Vec<usize> = (0..list.positions.len()).filter(own).collect();
    // Points stacked over the depth have no bodies.
    if number.is_none() || kept.is_empty() || list.positions.len() != snapshot.bodies.len() {
        let known: Vec<&str> = case.bodies.iter().map(|body| body.name.as_str()).collect();
        let problem = format!(
            "--body {name}: has no points in the last frame; there are the bodies {}",
            known.join(", ")
        );
        return Err(CommandError::usage("wrong-usage", problem));
    }
    Ok(kept)
}

/// List of the points of a frame.
fn point_list(case: &Case, snapshot: &Snapshot) -> Option<PointList> {
    // Dry points have zero pore pressure.
    let pressures = |all: &[f64]| all.iter().map(|p| if p.is_nan() { 0.0 } else { *p }).collect();
    let (volumes, at) = (snapshot.scalars("volume")?, &snapshot.positions);
    // In axisymmetry the volumes of a list are areas.
    let turn = |x: &[f64; 3]| if case.space == Space::Axisymmetric { x[0] } else { 1.0 };
    Some(PointList {
        positions: at.clone(),
        volumes: volumes.iter().zip(at).map(|(volume, x)| volume / turn(x)).collect(),
        masses: snapshot.scalars(PointList::MASS).map(<[f64]>::to_vec),
        velocities: Some(snapshot.vectors("velocity")?.to_vec()),
        stresses: Some(snapshot.tensors("stress")?.to_vec()),
        pore_pressures: snapshot.scalars(PointList::PORE_PRESSURE).map(pressures),
        grains: grain_columns(case, snapshot),
    })
}

/// Columns of a frame with grain data; for other methods only the radii, if any.
fn grain_columns(case: &Case, snapshot: &Snapshot) -> GrainColumns {
    let radii = snapshot.scalars("radius").map(<[f64]>::to_vec);
    let known = crate::dem::kinds(case).unwrap_or_default();
    let Some(kinds) = snapshot.scalars("kind").filter(|_| !known.is_empty()) else {
        return GrainColumns { radii, ..GrainColumns::default() };
    };
    let name = |kind: &f64| known.get(*kind as usize).cloned().unwrap_or_default();
    let about_z = |spins: &[f64]| spins.iter().map(|spin| [0.0, 0.0, *spin]).collect();
    GrainColumns {
        radii,
        grain_types: Some(kinds.iter().map(name).collect()),
        spins: snapshot.vectors("spin").map(<[_]>::to_vec).or(snapshot.scalars("spin").map(about_z)),
        is_held: snapshot.scalars("held").map(|held| held.iter().map(|own| *own == 1.0).collect()),
        ids: Some(snapshot.ids.iter().map(|id| *id as u32).collect()),
    }
}

/// CSV text of the `kept` points of a list, with a header.
fn point_table(list: &PointList, dimension: usize, kept: &[usize]) -> String {
    let (axes, of_grains) = (&["x", "y", "z"][..dimension], &list.grains);
    let turning = if dimension == 3 { 0 } else { 2 };
    let mut heads: Vec<String> = axes.iter().map(|axis| format!("{axis} (m)")).collect();
    heads.push("volume (m3)".to_owned());
    heads.extend(list.masses.iter().map(|_| "mass (kg)".to_owned()));
    let names =
        |names: &[&str], unit: &str| names.iter().map(|name| format!("{name} ({unit})")).collect::<Vec<_>>();
    heads.extend(list.velocities.iter().flat_map(|_| names(&PointList::VELOCITY[..dimension], "m/s")));
    heads.extend(list.stresses.iter().flat_map(|_| names(&PointList::STRESS, "Pa")));
    heads.extend(list.pore_pressures.iter().flat_map(|_| names(&[PointList::PORE_PRESSURE], "Pa")));
    heads.extend(of_grains.radii.iter().flat_map(|_| names(&["radius"], "m")));
    heads.extend(of_grains.spins.iter().flat_map(|_| names(&GrainColumns::SPIN[turning..], "rad/s")));
    heads.extend(of_grains.grain_types.iter().map(|_| "kind".to_owned()));
    heads.extend(of_grains.is_held.iter().map(|_| "held".to_owned()));
    heads.extend(of_grains.ids.iter().map(|_| "id".to_owned()));
    let mut text = heads.join(",") + "\n";
    for &i in kept {
        let mut row = list.positions[i][..dimension].to_vec();
        row.push(list.volumes[i]);
        row.extend(list.masses.iter().map(|all| all[i]));
        row.extend(list.velocities.iter().flat_map(|all| all[i][..dimension].to_vec()));
        row.extend(list.stresses.iter().flat_map(|all| all[i].0));
        row.extend(list.pore_pressures.iter().map(|all| all[i]));
        row.extend(of_grains.radii.iter().map(|all| all[i]));
        row.extend(of_grains.spins.iter().flat_map(|all| all[i][turning..].to_vec()));
        let mut row: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
        row.extend(of_grains.grain_types.iter().map(|all| all[i].clone()));
        row.extend(of_grains.is_held.iter().map(|all| u8::from(all[i]).to_string()));
        row.extend(of_grains.ids.iter().map(|all| all[i].to_string()));
        text += &(row.join(",") + "\n");
    }
    text
}

/// Removes the archives that an earlier export wrote.
fn remove_earlier_archives(folder: &Path, files: &DerivedFiles) -> Result<(), OutputError> {
    for name in file_names(folder)?.into_iter().filter(|name| name.ends_with(".npz")) {
        if files.is_own(&name)? {
            let file = folder.join(name);
            fs::remove_file(&file).map_err(|error| OutputError::new(&file, error))?;
        }
    }
    Ok(())
}

/// Sorted names of the entries of a folder.
fn file_names(folder: &Path) -> Result<Vec<String>, OutputError> {
    let fail = |error| OutputError::new(folder, error);
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        names.push(entry.map_err(fail)?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// Names of the tables in the folder of a run; always with that of the measures.
fn table_names(folder: &Path) -> Result<Vec<String>, OutputError> {
    let is_table = |name: &String| {
        let kinds = ["profile-", "trials-"];
        name.ends_with(".csv") && kinds.iter().any(|kind| name.starts_with(kind))
    };
    let mut names = file_names(folder)?;
    names.retain(is_table);
    names.insert(0, MEASURES_FILE.to_owned());
    Ok(names)
}
