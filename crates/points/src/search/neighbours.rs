//! Cell-linked lists and neighbour lists, identical on any number of threads.

use std::ops::Range;

use rayon::prelude::*;
use thiserror::Error;

/// Error in the construction of a search.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SearchError {
    /// Point with a coordinate that is not finite.
    #[error("point {0} has a coordinate that is not finite")]
    NotFinite(usize),
    /// Radius or cell edge that is not a length.
    #[error("search radius {0} must be finite and positive (m)")]
    Radius(f64),
    /// Number of cells, and the point farthest from the others, where the cells would take more memory than the points.
    #[error(
        "the points spread over {0:.2e} cells of the search radius, because point {1} has moved far away \
         from the others. Use smaller steps or a stiffer floor, or remove points that leave the domain \
         (`remove_outside`)"
    )]
    TooSpread(f64, usize),
}

impl SearchError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::NotFinite(_) => "state-not-finite",
            Self::Radius(_) => "out-of-range",
            Self::TooSpread(..) => "points-spread",
        }
    }
}

/// Relative tolerance that a search adds to its radius.
const ROUND_OFF: f64 = 1e-9;
/// Least number of points per task of a thread, for operations that are cheap per point.
const MIN_POINTS_PER_TASK: usize = 1024;

/// Largest number of cells of a search among that many points, so that cells use at most 400 MB and as much again for each million points.
#[must_use]
pub fn max_cells(points: usize) -> f64 {
    1e8 + 100.0 * points as f64
}

/// Index of the position farthest from the mean of all positions.
#[must_use]
pub fn farthest_from_mean<const D: usize>(positions: &[[f64; D]]) -> usize {
    let mean: [f64; D] =
        std::array::from_fn(|axis| positions.iter().map(|x| x[axis]).sum::<f64>() / positions.len() as f64);
    let away = |x: &[f64; D]| (0..D).map(|axis| (x[axis] - mean[axis]).powi(2)).sum::<f64>();
    let largest = positions.iter().enumerate().max_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)));
    largest.map_or(0, |(point, _)| point)
}

/// Cell-linked list: cells of a grid around all points, each with the list of its points.
#[derive(Clone, Debug, Default)]
pub struct CellList<const D: usize> {
    low: Vec<f64>,
    edge: f64,
    cells: Vec<usize>,
    cell_offsets: Vec<u32>,
    order: Vec<u32>,
    keys: Vec<u32>,
}

impl<const D: usize> CellList<D> {
    /// Empty list, whose buffers grow on the first build and are then reused.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sorts `positions` (m) into cells of edge `edge` (m) by a counting sort. Within a cell points keep their order.
    ///
    /// # Errors
    /// When a coordinate is not finite or the cells would be too many.
    pub fn build(&mut self, positions: &[[f64; D]], edge: f64) -> Result<(), SearchError> {
        if !(edge.is_finite() && edge > 0.0) {
            return Err(SearchError::Radius(edge));
        }
        if let Some(lost) = positions.iter().position(|x| x.iter().any(|c| !c.is_finite())) {
            return Err(SearchError::NotFinite(lost));
        }
        let fold = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| {
            positions.iter().map(|x| x[axis]).fold(start, pick)
        };
        self.edge = edge;
        self.low = (0..D).map(|axis| fold(axis, f64::INFINITY, f64::min)).collect();
        let mut total = 1.0;
        self.cells.clear();
        for axis in 0..D {
            let high = fold(axis, f64::NEG_INFINITY, f64::max);
            let count = ((high - self.low[axis]) / edge).floor().max(0.0) + 1.0;
            total *= count;
            self.cells.push(if count < 1e9 { count as usize } else { usize::MAX });
        }
        if total > max_cells(positions.len()) {
            return Err(SearchError::TooSpread(total, farthest_from_mean(positions)));
        }
        let (low, cells) = (&self.low, &self.cells);
        let key = |x: &[f64; D]| {
            (0..D).fold(0usize, |key, axis| {
                let cell = ((x[axis] - low[axis]) / edge) as usize;
                key * cells[axis] + cell.min(cells[axis] - 1)
            }) as u32
        };
        (0..positions.len())
            .into_par_iter()
            .with_min_len(MIN_POINTS_PER_TASK)
            .map(|i| key(&positions[i]))
            .collect_into_vec(&mut self.keys);
        self.cell_offsets.clear();
        self.cell_offsets.resize(total as usize + 1, 0);
        for &key in &self.keys {
            self.cell_offsets[key as usize + 1] += 1;
        }
        for cell in 1..self.cell_offsets.len() {
            self.cell_offsets[cell] += self.cell_offsets[cell - 1];
        }
        self.order.clear();
        self.order.resize(positions.len(), 0);
        let mut next = std::mem::take(&mut self.cell_offsets);
        for (point, &key) in self.keys.iter().enumerate() {
            let slot = &mut next[key as usize];
            self.order[*slot as usize] = point as u32;
            *slot += 1;
        }
        // Each start has become the start of the next cell.
        next.rotate_right(1);
        next[0] = 0;
        self.cell_offsets = next;
        Ok(())
    }

    /// Points sorted by cell.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Calls `visit` for every point in the cells that a ball with a radius of one cell edge around `x` may overlap.
    pub fn visit(&self, x: &[f64; D], mut visit: impl FnMut(u32)) {
        self.ranges_of_rows(x, |line| self.order[line].iter().for_each(|&point| visit(point)));
    }

    /// Calls `visit` for every point in the cells that a ball of any `radius` (m) around `x` may overlap.
    pub fn visit_within(&self, x: &[f64; D], radius: f64, mut visit: impl FnMut(u32)) {
        self.ranges_within(x, radius, |line| self.order[line].iter().for_each(|&point| visit(point)));
    }

    /// Calls `visit` with the range in [`CellList::order`] of each row of cells that a ball of one cell edge around `x` may overlap.
    fn ranges_of_rows(&self, x: &[f64; D], visit: impl FnMut(Range<usize>)) {
        self.ranges_across(x, 1, visit);
    }

    /// Calls `visit` with the ranges in [`CellList::order`] of the points that [`CellList::visit_within`] visits.
    #[inline]
    pub fn ranges_within(&self, x: &[f64; D], radius: f64, visit: impl FnMut(Range<usize>)) {
        // A small margin, so that round-off loses no point at the radius.
        let reach = radius / self.edge + ROUND_OFF;
        self.ranges_between(x, |cell| [cell - reach, cell + reach], visit);
    }

    /// Ranges in [`CellList::order`] of the rows of cells that are at most `reach` cells away.
    fn ranges_across(&self, x: &[f64; D], reach: i64, visit: impl FnMut(Range<usize>)) {
        let reach = reach as f64;
        self.ranges_between(x, |cell| [cell.floor() - reach, cell.floor() + reach], visit);
    }

    /// Ranges in [`CellList::order`] of the rows of cells in a window. `window` returns the ends of the window along an axis (cells) for a
    /// position (cells).
    #[inline]
    fn ranges_between(
        &self,
        x: &[f64; D],
        window: impl Fn(f64) -> [f64; 2],
        mut visit: impl FnMut(Range<usize>),
    ) {
        if self.order.is_empty() {
            return;
        }
        let span = |axis: usize| {
            let ends = window((x[axis] - self.low[axis]) / self.edge);
            let last = self.cells[axis] as i64 - 1;
            let [first, end] = ends.map(|end| (end.floor() as i64).clamp(0, last) as usize);
            (first, end)
        };
        let spans: [(usize, usize); D] = std::array::from_fn(span);
        let lines: usize = spans[..D - 1].iter().map(|(a, b)| b - a + 1).product();
        for line in 0..lines {
            let mut rest = line;
            let mut index = [0; D];
            for axis in (0..D - 1).rev() {
                let (a, b) = spans[axis];
                index[axis] = a + rest % (b - a + 1);
                rest /= b - a + 1;
            }
            let key = |last: usize| {
                (0..D).fold(0, |key, axis| {
                    key * self.cells[axis] + if axis == D - 1 { last } else { index[axis] }
                })
            };
            // Cells along the last axis are consecutive in memory.
            let (a, b) = spans[D - 1];
            visit(self.cell_offsets[key(a)] as usize..self.cell_offsets[key(b) + 1] as usize);
        }
    }
}

/// Number of points of a [`NeighbourBlock`]: enough work for a task, and few enough to distribute tasks among threads.
pub const BLOCK_POINTS: usize = 256;

/// Neighbours of up to [`BLOCK_POINTS`] consecutive points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NeighbourBlock {
    row_ends: Vec<u32>,
    indices: Vec<u32>,
}

impl NeighbourBlock {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.row_ends.len()
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.row_ends.is_empty()
    }

    /// Range in [`NeighbourBlock::indices`] of the neighbours of the `k`-th point of the block.
    #[inline]
    pub fn range(&self, k: usize) -> Range<usize> {
        let start = if k == 0 { 0 } else { self.row_ends[k - 1] };
        start as usize..self.row_ends[k] as usize
    }

    /// Neighbours of the `k`-th point of the block, ascending.
    #[inline]
    pub fn neighbours(&self, k: usize) -> &[u32] {
        &self.indices[self.range(k)]
    }

    /// Neighbours of all points of the block, in the order of the points.
    pub fn indices(&self) -> &[u32] {
        &self.indices
    }
}

/// Neighbours of every point within a radius, ascending. They are stored in blocks of [`BLOCK_POINTS`] points.
#[derive(Clone, Debug, Default)]
pub struct NeighbourList<const D: usize> {
    cells: CellList<D>,
    /// Positions in the order of the cells, axis by axis, for contiguous reads of a row of cells (m).
    cell_sorted_positions: Vec<Vec<f64>>,
    blocks: Vec<NeighbourBlock>,
    len: usize,
}

impl<const D: usize> NeighbourList<D> {
    /// Empty list, whose buffers grow on the first build and are then reused.
    pub fn new() -> Self {
        Self::default()
    }

    /// Finds, for every point, all others at a distance of at most `radius` (m).
    ///
    /// # Errors
    /// See [`CellList::build`].
    pub fn build(&mut self, positions: &[[f64; D]], radius: f64) -> Result<(), SearchError> {
        self.build_where(positions, positions.len(), radius, |i, j| i != j)
    }

    /// Finds neighbours as [`NeighbourList::build`], for the first `count` points only, of those that `keep(point, other)` accepts. Points
    /// after these contribute to sums without having sums of their own, such as walls and mirror images.
    ///
    /// # Errors
    /// See [`CellList::build`].
    pub fn build_first(
        &mut self,
        positions: &[[f64; D]],
        count: usize,
        radius: f64,
        keep: impl Fn(u32, u32) -> bool + Sync,
    ) -> Result<(), SearchError> {
        self.build_where(positions, count, radius, |i, j| i != j && keep(i, j))
    }

    /// Finds, for each of the first `count` points, the others within `radius` (m) that
    /// `keep(point, other)` accepts.
    fn build_where(
        &mut self,
        positions: &[[f64; D]],
        count: usize,
        radius: f64,
        keep: impl Fn(u32, u32) -> bool + Sync,
    ) -> Result<(), SearchError> {
        let targets = &positions[..count.min(positions.len())];
        self.build_between(targets, |_| radius, positions, radius, keep)
    }

    /// Finds, for each of `targets`, the `sources` at a distance of at most `radius(target)` (m) that `keep(target, source)` accepts,
    /// ascending. `edge` is the edge of the search cells (m), best the usual radius. For points of different radii, and for neighbours in
    /// another set of points.
    ///
    /// # Errors
    /// See [`CellList::build`].
    pub fn build_between(
        &mut self,
        targets: &[[f64; D]],
        radius: impl Fn(usize) -> f64 + Sync,
        sources: &[[f64; D]],
        edge: f64,
        keep: impl Fn(u32, u32) -> bool + Sync,
    ) -> Result<(), SearchError> {
        self.cells.build(sources, edge)?;
        self.len = targets.len();
        self.cell_sorted_positions.resize_with(D, Vec::new);
        for (axis, places) in self.cell_sorted_positions.iter_mut().enumerate() {
            let place = |&point: &u32| sources[point as usize][axis];
            (0..self.cells.order.len())
                .into_par_iter()
                .with_min_len(MIN_POINTS_PER_TASK)
                .map(|i| place(&self.cells.order[i]))
                .collect_into_vec(places);
        }
        self.blocks.resize_with(self.len.div_ceil(BLOCK_POINTS), NeighbourBlock::default);
        let (cells, places) = (&self.cells, &self.cell_sorted_positions);
        let points = targets.par_chunks(BLOCK_POINTS);
        self.blocks.par_iter_mut().zip(points).enumerate().for_each(|(number, (rows, points))| {
            rows.row_ends.clear();
            rows.indices.clear();
            for (k, x) in points.iter().enumerate() {
                let (i, first) = (number * BLOCK_POINTS + k, rows.indices.len());
                let radius = radius(i);
                cells.ranges_within(x, radius, |line| {
                    let places = std::array::from_fn(|axis| &places[axis][line.clone()]);
                    let near = |j: u32| keep(i as u32, j);
                    select_within(
                        x,
                        radius * radius,
                        places,
                        &cells.order[line.clone()],
                        near,
                        &mut rows.indices,
                    );
                });
                rows.indices[first..].sort_unstable();
                rows.row_ends.push(rows.indices.len() as u32);
            }
        });
        Ok(())
    }

    /// Neighbours of point `i`, ascending.
    #[inline]
    pub fn neighbours(&self, i: usize) -> &[u32] {
        self.blocks[i / BLOCK_POINTS].neighbours(i % BLOCK_POINTS)
    }

    /// Blocks of the list; block `b` begins with point `b` × [`BLOCK_POINTS`].
    pub fn blocks(&self) -> &[NeighbourBlock] {
        &self.blocks
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}

/// Appends to `found` those of `points` whose squared distance from `x` is at most `square` (m²) and which `keep` accepts. `places` are
/// their positions. Distances are computed and compared in batches; most are too large.
fn select_within<const D: usize>(
    x: &[f64; D],
    square: f64,
    places: [&[f64]; D],
    points: &[u32],
    keep: impl Fn(u32) -> bool,
    found: &mut Vec<u32>,
) {
    /// Number of points whose distances from `x` are computed together.
    const NEIGHBOURS_PER_CHUNK: usize = 64;
    for (number, points) in points.chunks(NEIGHBOURS_PER_CHUNK).enumerate() {
        let mut distances = [0.0; NEIGHBOURS_PER_CHUNK];
        let distances = &mut distances[..points.len()];
        for axis in 0..D {
            let places = &places[axis][number * NEIGHBOURS_PER_CHUNK..][..points.len()];
            for (distance, place) in distances.iter_mut().zip(places) {
                *distance += (x[axis] - place).powi(2);
            }
        }
        // One bit per point of the batch.
        let mut near = 0u64;
        for (k, &distance) in distances.iter().enumerate() {
            near |= u64::from(distance <= square) << k;
        }
        while near != 0 {
            let point = points[near.trailing_zeros() as usize];
            if keep(point) {
                found.push(point);
            }
            near &= near - 1;
        }
    }
}

/// Neighbour list in which each pair of points within a radius occurs once, under the smaller index. For symmetric pair forces.
#[derive(Clone, Debug, Default)]
pub struct HalfNeighbourList<const D: usize> {
    list: NeighbourList<D>,
}

impl<const D: usize> HalfNeighbourList<D> {
    /// Empty list, whose buffers grow on the first build and are then reused.
    pub fn new() -> Self {
        Self::default()
    }

    /// Finds all pairs at a distance of at most `radius` (m).
    ///
    /// # Errors
    /// See [`CellList::build`].
    pub fn build(&mut self, positions: &[[f64; D]], radius: f64) -> Result<(), SearchError> {
        self.list.build_where(positions, positions.len(), radius, |i, j| i < j)
    }

    /// Neighbours of point `i` with larger indices, ascending.
    pub fn neighbours(&self, i: usize) -> &[u32] {
        self.list.neighbours(i)
    }

    /// All pairs, ascending by their first point, then by their second.
    pub fn pairs(&self) -> impl Iterator<Item = (u32, u32)> {
        (0..self.list.len()).flat_map(|i| self.neighbours(i).iter().map(move |&j| (i as u32, j)))
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.list.blocks.iter().map(|rows| rows.indices.len()).sum()
    }

    /// Whether there are no pairs.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
