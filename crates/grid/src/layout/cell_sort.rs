//! Sorting of points by cell.

use rayon::prelude::*;

use crate::Grid;

/// Order that sorts points by cell (last axis fastest). Points of one cell keep their relative order.
pub fn sort_by_cell<const D: usize>(grid: &Grid<D>, positions: &[[f64; D]]) -> Vec<u32> {
    let key = |position: &[f64; D]| {
        let cell = grid.cell_of(position);
        (0..D).fold(0usize, |key, axis| key * grid.cells[axis] + cell[axis])
    };
    let cells: usize = grid.cells.iter().product();
    let keyed = positions.par_iter().enumerate().with_min_len(1024).map(|(i, x)| (key(x), i as u32));
    counting_sort(keyed.collect(), cells)
}

/// Counting sort of point numbers by `cells` cell numbers.
fn counting_sort(mut keys: Vec<(usize, u32)>, cells: usize) -> Vec<u32> {
    if cells > 32 * keys.len() {
        keys.par_sort_unstable();
        return keys.into_iter().map(|(_, i)| i).collect();
    }
    let mut starts = vec![0u32; cells + 1];
    for (key, _) in &keys {
        starts[key + 1] += 1;
    }
    for cell in 0..cells {
        starts[cell + 1] += starts[cell];
    }
    let mut order = vec![0; keys.len()];
    for (key, i) in keys {
        order[starts[key] as usize] = i;
        starts[key] += 1;
    }
    order
}
