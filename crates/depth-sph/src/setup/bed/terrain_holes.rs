//! Cells without data inside a terrain raster, into which a flow would vanish.

use colluvium_case::{Case, Warning};
use colluvium_points::Raster;

/// Warning for nodes without data that are enclosed by others with data, with their number and the place of one of them.
pub(super) fn warning(case: &Case, raster: &Raster) -> Option<Warning> {
    let holes = enclosed_nodes(raster);
    let first = *holes.first()?;
    let place = raster.node_position(first % raster.columns, first / raster.columns);
    let on_map: Vec<String> =
        place.iter().zip(case.origin()).map(|(x, origin)| format!("{:.2}", x + origin)).collect();
    Some(Warning::new(
        "terrain-holes",
        format!(
            "obstacles: {} nodes inside the terrain have no data, one of them at ({}) m. Flow that reaches them is \
             removed. Fill them in a GIS",
            holes.len(),
            on_map.join(", ")
        ),
    ))
}

/// Nodes without data that no path of such nodes connects with the edge of the raster.
fn enclosed_nodes(raster: &Raster) -> Vec<usize> {
    let (columns, rows) = (raster.columns, raster.rows);
    let is_missing = |node: usize| !raster.values[node].is_finite();
    let is_edge = |node: usize| {
        let (column, row) = (node % columns, node / columns);
        column == 0 || row == 0 || column + 1 == columns || row + 1 == rows
    };
    let mut is_outside = vec![false; raster.values.len()];
    let mut open: Vec<usize> =
        (0..raster.values.len()).filter(|node| is_edge(*node) && is_missing(*node)).collect();
    open.iter().for_each(|node| is_outside[*node] = true);
    while let Some(node) = open.pop() {
        let (column, row) = (node % columns, node / columns);
        for next_row in row.saturating_sub(1)..(row + 2).min(rows) {
            for next_column in column.saturating_sub(1)..(column + 2).min(columns) {
                let next = next_row * columns + next_column;
                if is_missing(next) && !is_outside[next] {
                    is_outside[next] = true;
                    open.push(next);
                }
            }
        }
    }
    (0..raster.values.len()).filter(|node| is_missing(*node) && !is_outside[*node]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enclosed_nodes_are_holes_and_those_joined_to_the_edge_are_not() {
        // Missing nodes: a corner with a diagonal neighbour, and one in the middle.
        let missing = [(0, 0), (1, 1), (4, 3)];
        let value = |x: f64, y: f64| {
            if missing.contains(&(x as usize, y as usize)) { f64::NAN } else { 1.0 }
        };
        let raster = Raster::from_function([7, 6], [0.0, 0.0], [1.0, 1.0], value);
        assert_eq!(enclosed_nodes(&raster), [3 * 7 + 4]);
    }
}
