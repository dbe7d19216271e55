//! Active nodes, and the order in which points scatter to them.

mod cell_sort;
mod mesh_layout;

use std::ops::Range;

use rayon::prelude::*;

pub use crate::layout::cell_sort::sort_by_cell;

use crate::{Basis, Basis1d, Grid};

/// Order of nodes in memory, and division of the points into slabs for transfers to the nodes.
///
/// Points are kept sorted by cell. The grid is cut into slabs of a few cells along its first axis;
/// all points of a slab scatter one after another, and slabs of the same colour (every other one)
/// touch different nodes. So slabs of one colour run in parallel without locks, and the order in
/// which a node receives its contributions is fixed by the data alone.
///
/// Slabs keep a margin of one cell: the sort stays valid until some point has moved by that much
/// along an axis.
#[derive(Clone, Debug)]
pub struct Layout<const D: usize> {
    grid: Grid<D>,
    nodes: [usize; D],
    strides: [usize; D],
    ghosts: usize,
    nodes_below: usize,
    nodes_above: usize,
    slab_cells: usize,
    active_nodes: Vec<Range<usize>>,
    /// First entry of the node range of each slab of a mesh; empty on a structured grid.
    window_starts: Vec<usize>,
    /// Period in nodes along periodic axes; zero along others.
    period: [usize; D],
}

/// Function that is called for a row of nodes: with its number, its active nodes and the row.
type RowVisitor<'a, T, R> = dyn Fn(usize, Range<usize>, &mut [T]) -> R + Sync + 'a;
/// Function that is called for the same row of two node arrays, with the result of the row.
type RowPairVisitor<'a, T, R> = dyn Fn(usize, Range<usize>, [&mut [T]; 2], &mut R) + Sync + 'a;

/// Cells a point may move along an axis before the points must be sorted again.
const SORT_MARGIN: usize = 1;

impl<const D: usize> Layout<D> {
    /// Returns the layout of the nodes of `basis` on `grid`, without points.
    pub fn new<const S: usize, B: Basis<S>>(grid: &Grid<D>) -> Self {
        Self::with_basis(grid, &Basis1d::from_basis::<S, B>())
    }

    /// Layout for a basis that is selected at run time.
    pub fn with_basis(grid: &Grid<D>, basis: &Basis1d) -> Self {
        let nodes = std::array::from_fn(|axis| basis.nodes(grid.cells[axis]));
        let mut strides = [1; D];
        for axis in (0..D - 1).rev() {
            strides[axis] = strides[axis + 1] * nodes[axis + 1];
        }
        let slab_cells = (basis.nodes_above + basis.nodes_below + 2 * SORT_MARGIN).max(4);
        Self {
            grid: *grid,
            nodes,
            strides,
            ghosts: basis.ghosts,
            nodes_below: basis.nodes_below,
            nodes_above: basis.nodes_above,
            slab_cells,
            active_nodes: vec![0..0; nodes[0]],
            window_starts: Vec::new(),
            period: [0; D],
        }
    }

    /// Layout with the slabs of another one on the same grid, whose shape functions have at least the same support.
    #[must_use]
    pub fn with_slabs_of(mut self, other: &Self) -> Self {
        self.slab_cells = other.slab_cells;
        self
    }

    /// Layout with periodic axes. `None` if the grid has too few cells, or if nodes at both ends differ (splines with open knots).
    #[must_use]
    pub fn periodic(self, periodic: [bool; D]) -> Option<Self> {
        let cells = self.grid.cells;
        let ends_alike = |axis: usize| self.nodes[axis] == cells[axis] + 1 + 2 * self.ghosts;
        if (0..D).any(|axis| periodic[axis] && !ends_alike(axis)) {
            return None;
        }
        self.with_period(std::array::from_fn(|axis| if periodic[axis] { cells[axis] } else { 0 }))
    }

    /// Layout with a period in nodes (zero for axes that are not periodic), for a grid that extends beyond its period at both ends. Points
    /// lie within the period, so far from the ends of the grid that shape functions are the same everywhere. `None` where a node would have
    /// more than one image.
    #[must_use]
    pub fn with_period(mut self, period: [usize; D]) -> Option<Self> {
        self.period = period;
        let fits = |axis: usize| self.periodic_image_count(axis) <= period[axis];
        (0..D).all(fits).then_some(self)
    }

    /// Number of nodes along an axis that are the periodic image of a node of lower index.
    fn periodic_image_count(&self, axis: usize) -> usize {
        if self.period[axis] == 0 { 0 } else { self.nodes[axis].saturating_sub(self.period[axis]) }
    }

    /// Whether the grid is periodic along an axis.
    pub fn is_periodic(&self, axis: usize) -> bool {
        self.period[axis] > 0
    }

    /// Assigns the sum over all images to each node of a periodic grid; `add` adds to a node.
    pub fn sum_periodic_images<T: Copy>(&self, nodes: &mut [T], add: impl Fn(&mut T, &T)) {
        for axis in (0..D).filter(|axis| self.is_periodic(*axis)) {
            let (stride, period) = (self.strides[axis], self.period[axis]);
            let line = stride * self.nodes[axis];
            for block in nodes.chunks_exact_mut(line) {
                for place in 0..self.periodic_image_count(axis) * stride {
                    let mut sum = block[place];
                    add(&mut sum, &block[place + period * stride]);
                    block[place] = sum;
                    block[place + period * stride] = sum;
                }
            }
        }
    }

    /// Returns the node at `index` and its images in a periodic grid.
    #[must_use]
    pub fn periodic_images(&self, index: [usize; 3]) -> Vec<[usize; 3]> {
        let mut images = vec![index];
        for axis in (0..D).filter(|axis| self.is_periodic(*axis)) {
            let period = self.period[axis];
            let other = match index[axis] {
                near if near < self.periodic_image_count(axis) => near + period,
                far if far >= period => far - period,
                _ => continue,
            };
            for number in 0..images.len() {
                let mut image = images[number];
                image[axis] = other;
                images.push(image);
            }
        }
        images
    }

    /// Whether a node is the periodic image of a node of lower index, which sums over nodes omit.
    #[inline]
    pub fn is_periodic_image(&self, index: &[usize; 3]) -> bool {
        (0..D).any(|axis| self.is_periodic(axis) && index[axis] >= self.period[axis])
    }

    /// Activates the images of active nodes.
    fn activate_images(&mut self) {
        if (1..D).any(|axis| self.is_periodic(axis)) {
            let whole = 0..self.strides[0];
            self.active_nodes
                .iter_mut()
                .filter(|range| range.start < range.end)
                .for_each(|range| *range = whole.clone());
        }
        if self.is_periodic(0) {
            for row in 0..self.periodic_image_count(0) {
                let image = row + self.period[0];
                let (a, b) = (self.active_nodes[row].clone(), self.active_nodes[image].clone());
                let both = match (Range::is_empty(&a), Range::is_empty(&b)) {
                    (true, _) => b,
                    (_, true) => a,
                    _ => a.start.min(b.start)..a.end.max(b.end),
                };
                self.active_nodes[row] = both.clone();
                self.active_nodes[image] = both;
            }
        }
    }

    /// Layers of nodes outside the domain.
    pub fn ghosts(&self) -> usize {
        self.ghosts
    }

    /// Whether the nodes are those of an unstructured mesh.
    fn is_mesh(&self) -> bool {
        !self.window_starts.is_empty()
    }

    /// Nodes per axis, ghosts included.
    pub fn nodes(&self) -> [usize; D] {
        self.nodes
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.iter().product()
    }

    /// Always false: a grid has at least one cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Distance in memory between neighbouring nodes along each axis.
    pub fn strides(&self) -> [usize; D] {
        self.strides
    }

    /// Number of slabs.
    pub fn slabs(&self) -> usize {
        self.grid.cells[0].div_ceil(self.slab_cells)
    }

    /// Removes all points.
    pub fn clear(&mut self) {
        if self.is_mesh() {
            return;
        }
        self.active_nodes.fill(0..0);
    }

    /// Adds a set of points sorted by cell ([`sort_by_cell`]). The nodes within their support are active until the next sort. Returns the
    /// bounds of the slabs within the set, one more than [`Layout::slabs`].
    pub fn add_points(&mut self, positions: &[[f64; D]]) -> Vec<usize> {
        let mut bounds = vec![0; self.slabs() + 1];
        let (below, above) = (self.nodes_below + SORT_MARGIN, self.nodes_above + SORT_MARGIN);
        let reach = |cell: usize, nodes: usize| {
            let node = cell + self.ghosts;
            node.saturating_sub(below)..(node + above + 1).min(nodes)
        };
        let plane = if D > 1 { self.strides[1] } else { 1 };
        for position in positions {
            let cell = self.grid.cell_of(position);
            bounds[cell[0] / self.slab_cells + 1] += 1;
            if self.is_mesh() {
                continue;
            }
            let across = if D > 1 { reach(cell[1], self.nodes[1]) } else { 0..1 };
            for row in reach(cell[0], self.nodes[0]) {
                let range = &mut self.active_nodes[row];
                let (start, end) = (across.start * plane, across.end * plane);
                *range = if range.start == range.end {
                    start..end
                } else {
                    range.start.min(start)..range.end.max(end)
                };
            }
        }
        self.activate_images();
        for slab in 1..bounds.len() {
            bounds[slab] += bounds[slab - 1];
        }
        bounds
    }

    /// Active nodes of a row, relative to its first node.
    pub fn active_nodes(&self, row: usize) -> Range<usize> {
        self.active_nodes[row].clone()
    }

    /// Index along the axes of node `number` of a row.
    #[inline]
    pub fn axis_indices(&self, row: usize, number: usize) -> [usize; 3] {
        match D {
            1 => [row, 0, 0],
            2 => [row, number, 0],
            _ => [row, number / self.nodes[D - 1], number % self.nodes[D - 1]],
        }
    }

    /// Calls `visit` in parallel for each row of nodes along the first axis with active nodes, and collects the results row by row. Its
    /// arguments are the row number, the range of active nodes and the row.
    pub fn for_each_row<T: Send, R: Send + Default>(
        &self,
        nodes: &mut [T],
        results: &mut [R],
        visit: impl Fn(usize, Range<usize>, &mut [T]) -> R + Sync,
    ) {
        visit_rows(nodes, self.strides[0], &self.active_nodes, results, &visit);
    }

    /// Calls `visit` like [`Layout::for_each_row`], without results.
    pub fn for_each_active_node_range<T: Send>(
        &self,
        nodes: &mut [T],
        visit: impl Fn(usize, Range<usize>, &mut [T]) + Sync,
    ) {
        visit_rows(nodes, self.strides[0], &self.active_nodes, &mut vec![(); self.nodes[0]], &visit);
    }

    /// Calls `visit` in parallel for the same rows of two node arrays, with row number, active nodes, both rows and the result of the row.
    /// The results are modified in place.
    pub fn for_each_row_pair<T: Send, R: Send>(
        &self,
        [first, second]: [&mut [T]; 2],
        results: &mut [R],
        visit: &RowPairVisitor<'_, T, R>,
    ) {
        let row = self.strides[0];
        let lines = first.par_chunks_mut(row).zip(second.par_chunks_mut(row)).zip(results).enumerate();
        lines.for_each(|(row, ((first, second), result))| {
            visit(row, self.active_nodes[row].clone(), [first, second], result);
        });
    }

    /// Resets the active nodes to their default.
    pub fn reset<T: Send + Default + Clone>(&self, nodes: &mut [T]) {
        reset(nodes, self.strides[0], &self.active_nodes);
    }

    /// Calls `scatter` for each slab, the even ones in parallel and then the odd ones. Its arguments are the slab, its range of nodes and
    /// the number of the first of these. The range contains all nodes in the support of the points of the slab.
    pub fn for_each_slab<T: Send>(&self, nodes: &mut [T], scatter: impl Fn(usize, &mut [T], usize) + Sync) {
        let slabs = self.slabs();
        for colour in 0..2.min(slabs) {
            let start = if colour == 0 { 0 } else { self.window_start(1) };
            let windows = SlabWindows { numbers: 0..(slabs - colour).div_ceil(2), start };
            let slab = |window: usize| colour + 2 * window;
            let first = |window: usize| self.window_start(slab(window));
            let each = |window: usize, nodes: &mut [T], start: usize| scatter(slab(window), nodes, start);
            scatter_windows(&mut nodes[start..], windows, &first, &each);
        }
    }

    /// First node of the range of a slab, limited to the grid.
    fn window_start(&self, slab: usize) -> usize {
        if self.is_mesh() {
            return self.window_starts[slab];
        }
        let row = (slab * self.slab_cells + self.ghosts).saturating_sub(self.nodes_below + SORT_MARGIN);
        row.min(self.nodes[0]) * self.strides[0]
    }
}

// Loops independent of the dimension and of the function of a row: the cost of a call per row is negligible.

/// Visits the active nodes of each row in parallel; the result of a row without active nodes is the default.
fn visit_rows<T: Send, R: Send + Default>(
    nodes: &mut [T],
    row: usize,
    active: &[Range<usize>],
    results: &mut [R],
    visit: &RowVisitor<'_, T, R>,
) {
    nodes.par_chunks_mut(row).zip(results).enumerate().for_each(|(row, (line, result))| {
        let active = active[row].clone();
        *result = if active.start == active.end { R::default() } else { visit(row, active, line) };
    });
}

/// Sets the active nodes of each row to their default value.
fn reset<T: Send + Default + Clone>(nodes: &mut [T], row: usize, active: &[Range<usize>]) {
    nodes.par_chunks_mut(row).zip(active).for_each(|(line, active)| {
        line[active.clone()].fill(T::default());
    });
}

/// Node ranges of the slabs of one colour, that is of every other slab; the first range starts at node `start`.
struct SlabWindows {
    numbers: Range<usize>,
    start: usize,
}

/// Calls `scatter` in parallel for the node range of each slab of one colour, with its first node. The ranges are halved recursively, which
/// allocates no memory. `first` gives the first node of a range.
fn scatter_windows<T: Send>(
    nodes: &mut [T],
    SlabWindows { numbers, start }: SlabWindows,
    first: &(dyn Fn(usize) -> usize + Sync),
    scatter: &(dyn Fn(usize, &mut [T], usize) + Sync),
) {
    if numbers.len() == 1 {
        return scatter(numbers.start, nodes, start);
    }
    let middle = numbers.start + numbers.len() / 2;
    let cut = first(middle);
    let (lower, upper) = nodes.split_at_mut(cut - start);
    let half = |nodes: &mut [T], numbers: Range<usize>, start: usize| {
        scatter_windows(nodes, SlabWindows { numbers, start }, first, scatter);
    };
    rayon::join(|| half(lower, numbers.start..middle, start), || half(upper, middle..numbers.end, cut));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NodeSupport;
    use crate::{
        ContiguousGimpBasis, CubicSpline, GimpBasis, LinearBasis, NodalState, QuadraticSpline, Stencil,
    };
    use proptest::prelude::*;

    fn mass_is_conserved<const S: usize, B: Basis<S>>(points: &[[f64; 2]], drift: f64) {
        let grid = Grid::new([0.0, 0.0], [2.3, 0.9], 0.1).unwrap();
        let order = sort_by_cell(&grid, points);
        let sorted: Vec<_> = order.iter().map(|&i| points[i as usize]).collect();
        let mut layout = Layout::new::<S, B>(&grid);
        let bounds = layout.add_points(&sorted);
        let moved: Vec<_> =
            sorted.iter().map(|p| [(p[0] + drift).clamp(0.0, 2.3), (p[1] - drift).clamp(0.0, 0.9)]).collect();
        let mut nodes = vec![NodalState::default(); layout.len()];
        let strides = layout.strides();
        layout.for_each_slab(&mut nodes, |slab, window, offset| {
            for x in &moved[bounds[slab]..bounds[slab + 1]] {
                let stencil = Stencil::<2, S>::new::<B>(&grid, x, &[0.05; 2]);
                let zero = crate::Vector4::ZERO;
                stencil.p2g(window, offset, &strides, crate::Vector4::ONE, &[zero; 2], None);
            }
        });
        let everywhere: f64 = nodes.iter().map(|n| n.momentum_and_mass.to_array()[3]).sum();
        let mut sums = vec![0.0; layout.nodes()[0]];
        layout.for_each_row(&mut nodes, &mut sums, |_, active, row| {
            row[active].iter().map(|n| n.momentum_and_mass.to_array()[3]).sum()
        });
        let active: f64 = sums.iter().sum();
        let exact = points.len() as f64;
        assert!((everywhere - exact).abs() < 1e-11 * exact, "{}: {everywhere}", B::NAME);
        assert!((active - exact).abs() < 1e-11 * exact, "{}: active nodes hold {active}", B::NAME);
        layout.reset(&mut nodes);
        assert!(nodes.iter().all(|n| *n == NodalState::default()), "reset clears everything touched");
    }

    #[test]
    fn a_periodic_grid_gives_images_the_sum_of_both() {
        let grid = Grid::new([0.0; 2], [0.5, 0.3], 0.1).unwrap();
        assert!(Layout::new::<3, QuadraticSpline>(&grid).periodic([true, false]).is_none());
        assert!(
            Layout::new::<4, ContiguousGimpBasis>(&grid).periodic([false, true]).is_none(),
            "too few cells"
        );
        let layout = Layout::new::<3, GimpBasis>(&grid);
        let mut layout = layout.periodic([true, true]).unwrap();
        let points = [[0.01, 0.02], [0.26, 0.29]];
        let bounds = layout.add_points(&points);
        let mut nodes = vec![NodalState::default(); layout.len()];
        let strides = layout.strides();
        layout.for_each_slab(&mut nodes, |slab, window, offset| {
            for x in &points[bounds[slab]..bounds[slab + 1]] {
                let stencil = Stencil::<2, 3>::new::<GimpBasis>(&grid, x, &[0.05; 2]);
                stencil.p2g(window, offset, &strides, crate::Vector4::ONE, &[crate::Vector4::ZERO; 2], None);
            }
        });
        layout.sum_periodic_images(&mut nodes, |sum, node| sum.momentum_and_mass += node.momentum_and_mass);
        // Nodes -1 to 6 along x and -1 to 4 along y: -1, 0, 1 are 4, 5, 6 and 2, 3, 4.
        let mass = |i: usize, j: usize| nodes[i * strides[0] + j].momentum_and_mass.to_array()[3];
        for i in 0..8 {
            assert!((0..3).all(|j| mass(i, j) == mass(i, j + 3)), "{i}");
        }
        assert!((0..6).all(|j| (0..3).all(|i| mass(i, j) == mass(i + 5, j))));
        let mut images = layout.periodic_images([6, 0, 0]);
        images.sort_unstable();
        assert_eq!(images, [[1, 0, 0], [1, 3, 0], [6, 0, 0], [6, 3, 0]]);
        assert_eq!(layout.periodic_images([3, 1, 0]), [[3, 1, 0], [3, 4, 0]]);
        let each_once: f64 = (1..6).flat_map(|i| (1..4).map(move |j| (i, j))).map(|(i, j)| mass(i, j)).sum();
        assert!((each_once - 2.0).abs() < 1e-14, "{each_once}");
        layout.reset(&mut nodes);
        assert!(nodes.iter().all(|node| *node == NodalState::default()), "images are active");
    }

    proptest! {
        #[test]
        fn every_slab_window_holds_the_nodes_its_points_touch(
            points in proptest::collection::vec((0.0..2.3f64, 0.0..0.9f64), 1..200),
            drift in -0.1..0.1f64,
        ) {
            let points: Vec<_> = points.into_iter().map(|(x, y)| [x, y]).collect();
            mass_is_conserved::<2, LinearBasis>(&points, drift);
            mass_is_conserved::<3, GimpBasis>(&points, drift);
            mass_is_conserved::<4, ContiguousGimpBasis>(&points, drift);
            mass_is_conserved::<3, QuadraticSpline>(&points, drift);
            mass_is_conserved::<4, CubicSpline>(&points, drift);
        }

        #[test]
        fn sorting_is_a_stable_permutation_by_cell(
            points in proptest::collection::vec((0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64), 0..300),
        ) {
            let grid = Grid::new([0.0; 3], [1.0; 3], 0.25).unwrap();
            let points: Vec<_> = points.into_iter().map(|(x, y, z)| [x, y, z]).collect();
            let order = sort_by_cell(&grid, &points);
            let cell = |i: u32| grid.cell_of(&points[i as usize]);
            prop_assert!(order.windows(2).all(|w| (cell(w[0]), w[0]) < (cell(w[1]), w[1])));
            let mut all = order.clone();
            all.sort_unstable();
            prop_assert!(all.into_iter().eq(0..points.len() as u32));
        }
    }
}
