//! Maps of the rasters of a run.

use std::path::Path;

use colluvium_points::{Outline, Raster, Shape};
use serde_json::Value;

use crate::case::output::OutputError;
use crate::case::{Case, CaseError};
use crate::output::rigid_geometry::case_of_run;
use crate::output::run_pictures::read_case_value;
use crate::plots::{MapCells, TerrainMap};

/// Name of the folder of rasters in that of a run.
pub(crate) const RASTER_FOLDER: &str = "rasters";

/// Rasters of which maps are drawn, in the order of priority, with the labels of their colours.
const MAPPED_RASTERS: [(&str, &str); 8] = [
    ("peak_thickness_vertical", "peak thickness (m)"),
    ("peak_thickness_normal", "peak thickness (m)"),
    ("final_thickness_vertical", "final thickness (m)"),
    ("final_thickness_normal", "final thickness (m)"),
    ("peak_velocity", "peak velocity (m/s)"),
    ("peak_dynamic_pressure", "peak dynamic pressure (Pa)"),
    ("arrival_time", "arrival time (s)"),
    ("bed_change", "change of the bed (m)"),
];

/// Quantity of a raster of results with its unit, such as `peak velocity (m/s)`; `None` for other names.
pub fn raster_label(name: &str) -> Option<&'static str> {
    let mapped = MAPPED_RASTERS.into_iter().find(|(own, _)| *own == name).map(|(_, label)| label);
    mapped.or((name == "final_velocity").then_some("final velocity (m/s)"))
}

/// Maps of the rasters in the folder of a run, by the name of the raster. They show shaded terrain, the raster in colours, and outlines of
/// layers and of the observed event. Outlines are missing where the files of the case have changed since the run. Empty without rasters.
///
/// # Errors
/// When a raster or the case of the run cannot be read.
pub fn raster_maps(folder: &Path) -> Result<Vec<(String, TerrainMap)>, OutputError> {
    let file = |name: &str| folder.join(RASTER_FOLDER).join(format!("{name}.asc"));
    let there: Vec<_> = MAPPED_RASTERS.into_iter().filter(|(name, _)| file(name).exists()).collect();
    if there.is_empty() {
        return Ok(Vec::new());
    }
    let title = value_text(&read_case_value(folder)?["title"]);
    let case = case_of_run(folder).ok();
    let heights = case.as_ref().and_then(|case| terrain_heights(case).ok().flatten());
    let outlines = case.as_ref().map(release_outlines).unwrap_or_default();
    let mapped = case.as_ref().map(observed_outlines).unwrap_or_default();
    let map = |(name, label): (&str, &str)| {
        let path = file(name);
        let raster = colluvium_terrain::read_raster(&path);
        let raster = raster.map_err(|error| OutputError::new(&path, error.problem))?;
        let map = TerrainMap {
            title: map_title(label, &title),
            label: label.to_owned(),
            heights: heights.clone(),
            cells: raster_cells(raster, &[0.0; 3]),
            outlines: outlines.clone(),
            mapped_outlines: mapped.clone(),
        };
        Ok((name.to_owned(), map))
    };
    there.into_iter().map(map).collect()
}

/// Text of a JSON string; empty for another value.
fn value_text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// Title of the map of a quantity (a label with a unit) of a case.
fn map_title(label: &str, case: &str) -> String {
    let quantity = label.split(" (").next().unwrap_or(label);
    if case.is_empty() { quantity.to_owned() } else { format!("{quantity}: {case}") }
}

/// Map of a raster of a case.
///
/// # Errors
/// When the terrain of the case cannot be read.
pub fn raster_map(case: &Case, raster: Raster, title: &str, label: &str) -> Result<TerrainMap, CaseError> {
    Ok(TerrainMap {
        title: map_title(label, title),
        // The condition of a share is in the title.
        label: label.split(" with ").next().unwrap_or(label).to_owned(),
        heights: terrain_heights(case)?,
        cells: raster_cells(raster, &[0.0; 3]),
        outlines: release_outlines(case),
        mapped_outlines: observed_outlines(case),
    })
}

/// Cells of a raster with their position on the map.
fn raster_cells(raster: Raster, origin: &[f64; 3]) -> MapCells {
    let place = [raster.origin[0] + origin[0], raster.origin[1] + origin[1]];
    MapCells {
        counts: [raster.columns, raster.rows],
        origin: place,
        spacing: raster.spacing,
        values: raster.values,
    }
}

/// Heights of the terrain (m), in map coordinates.
fn terrain_heights(case: &Case) -> Result<Option<MapCells>, CaseError> {
    for number in 0..case.obstacles.len() {
        if let Some(raster) = case.heights(number)? {
            return Ok(Some(raster_cells(raster, &case.origin())));
        }
    }
    Ok(None)
}

/// Outlines of a case in map coordinates (m): those of the layers of its bodies, and those of the observed event.
pub fn case_outlines(case: &Case) -> [Vec<Ring>; 2] {
    [release_outlines(case), observed_outlines(case)]
}

/// Closed line in plan (m).
pub type Ring = Vec<[f64; 2]>;

/// Outlines of the layers of the bodies (m), in map coordinates.
fn release_outlines(case: &Case) -> Vec<Vec<[f64; 2]>> {
    let origin = case.origin();
    let mut rings = Vec::new();
    for body in &case.bodies {
        let mut shape = body.shape.clone();
        for (_, layer) in shape.layers_mut(String::new()) {
            let Shape::Layer { laid, .. } = layer else { continue };
            rings
                .extend(laid.layer().into_iter().flat_map(|layer| map_coordinates(layer.outline(), &origin)));
        }
    }
    rings
}

/// Outlines of the observed event (m), in map coordinates; empty where its file is missing.
fn observed_outlines(case: &Case) -> Vec<Vec<[f64; 2]>> {
    let file = case.output.rasters.as_ref().and_then(|rasters| rasters.mapped_outline.as_ref());
    let outline = file.and_then(|file| case.outline(file).ok());
    outline.map_or_else(Vec::new, |outline| map_coordinates(&outline, &case.origin()))
}

/// Rings of an outline in map coordinates (m).
fn map_coordinates(outline: &Outline, origin: &[f64; 3]) -> Vec<Vec<[f64; 2]>> {
    let ring = |ring: &Vec<[f64; 2]>| ring.iter().map(|[x, y]| [x + origin[0], y + origin[1]]).collect();
    outline.rings().map(ring).collect()
}
