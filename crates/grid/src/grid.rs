//! Structured background grid: a box of equal cells.

use thiserror::Error;

/// Reason why a grid cannot be built.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GridError {
    /// The cell size is not positive and finite.
    #[error("cell size: {0} must be finite and positive (m)")]
    CellSize(f64),
    /// The domain is not a whole number of cells wide.
    #[error(
        "along {} the domain is {width} m wide, {cells} cells of {cell} m: not a whole number; {}",
        ["x", "y", "z"][*axis],
        suggestion_text(*suggestion)
    )]
    NotDivisible {
        /// Axis, 0 to 2.
        axis: usize,
        /// Width of the domain (m).
        width: f64,
        /// Width over cell size.
        cells: f64,
        /// Cell size (m).
        cell: f64,
        /// Cell size near the given one that divides the widths along all axes (m); `None` if there is none.
        suggestion: Option<f64>,
    },
    /// More nodes than can be addressed.
    #[error(
        "the grid would have {0:.3e} nodes, more than 2^28 (16 GiB): use larger cells or a smaller domain"
    )]
    TooLarge(f64),
}

impl GridError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::CellSize(_) => "cell-size",
            Self::NotDivisible { .. } => "domain-not-divisible",
            Self::TooLarge(_) => "too-many-nodes",
        }
    }
}

/// Largest number of cells along the first axis that is tried for a common cell size.
const MAX_TRIED_CELLS: f64 = 1e5;

/// Whether a width is a whole number of cells, at least one; `count` is their ratio.
fn is_whole(count: f64) -> bool {
    let whole = count.round();
    whole >= 1.0 && (count - whole).abs() <= 1e-6 * whole
}

/// Cell size (m) closest to `cell` that divides all widths (m).
fn common_cell(widths: &[f64], cell: f64) -> Option<f64> {
    let count = (4.0 * widths[0] / cell + 20.0).min(MAX_TRIED_CELLS) as u32;
    let ratio = |size: &f64| (size / cell).ln().abs();
    (1..=count)
        .map(|number| widths[0] / f64::from(number))
        .filter(|size| widths.iter().all(|width| is_whole(width / size)))
        .min_by(|a, b| ratio(a).total_cmp(&ratio(b)))
}

/// Advice on the cell size.
fn suggestion_text(suggestion: Option<f64>) -> String {
    suggestion.map_or_else(
        || "no cell size near it divides all axes: change the domain".to_owned(),
        |size| format!("choose a cell size that divides all axes, e.g. {size}"),
    )
}

/// Box of equal cells with edge length [`Grid::cell`] in `D` dimensions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid<const D: usize> {
    /// Lower corner (m).
    pub origin: [f64; D],
    /// Edge length of a cell (m).
    pub cell: f64,
    /// Cells per axis.
    pub cells: [usize; D],
}

impl<const D: usize> Grid<D> {
    /// Grid of cells with an edge length over the box from `min` to `max` (m).
    ///
    /// # Errors
    /// When the box is not a whole number of cells wide (to 10⁻⁶ of a cell), or too large.
    pub fn new(min: [f64; D], max: [f64; D], cell: f64) -> Result<Self, GridError> {
        if !(cell.is_finite() && cell > 0.0) {
            return Err(GridError::CellSize(cell));
        }
        let mut cells = [0; D];
        let mut total = 1.0;
        for axis in 0..D {
            let width = max[axis] - min[axis];
            let count = width / cell;
            let whole = count.round();
            if !is_whole(count) {
                let suggestion = common_cell(&std::array::from_fn::<f64, D, _>(|c| max[c] - min[c]), cell);
                return Err(GridError::NotDivisible { axis, width, cells: count, cell, suggestion });
            }
            total *= whole + 5.0;
            if total > 2f64.powi(28) {
                return Err(GridError::TooLarge(total));
            }
            cells[axis] = whole as usize;
        }
        Ok(Self { origin: min, cell, cells })
    }

    /// Position relative to the lower corner, in cells.
    #[inline]
    pub fn local(&self, position: &[f64; D]) -> [f64; D] {
        let inverse = 1.0 / self.cell;
        std::array::from_fn(|a| (position[a] - self.origin[a]) * inverse)
    }

    /// Cell that contains `position`, clamped to the grid. A point on a face belongs to the upper cell.
    #[inline]
    pub fn cell_of(&self, position: &[f64; D]) -> [usize; D] {
        let local = self.local(position);
        std::array::from_fn(|a| (local[a].max(0.0) as usize).min(self.cells[a] - 1))
    }

    /// Whether `position` lies in the box.
    #[inline]
    pub fn contains(&self, position: &[f64; D]) -> bool {
        let local = self.local(position);
        (0..D).all(|a| local[a] >= 0.0 && local[a] <= self.cells[a] as f64)
    }

    /// Upper corner (m).
    pub fn upper(&self) -> [f64; D] {
        std::array::from_fn(|a| self.origin[a] + self.cells[a] as f64 * self.cell)
    }
}
