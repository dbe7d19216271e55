//! Nodes and their images sorted by cell, column by column: the neighbours of a position are a few ranges of each column, read four
//! nodes at a time.

use colluvium_points::{CellList, SearchError};
use rayon::prelude::*;
use wide::f64x4;

use crate::config::choices::SearchOrientation;
use crate::kernel::Kernel;
use crate::neighbours::kernel_average::NO_PARTNER;
use crate::neighbours::kernel_sum::KernelSum;
use crate::neighbours::search_axes::SearchAxes;
use crate::neighbours::simd_neighbour_list;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::{NeighbourData, PlanVector};

/// Number of fields whose gradients are computed: height, height of the other phase, porosity, excess pressure, bed level.
pub const FIELDS: usize = 5;
/// Masks of SIMD lanes after the end of a range: not-a-number, which no distance test accepts.
const EMPTY_LANES: [f64x4; 4] = {
    let no = f64::from_bits(u64::MAX);
    [
        f64x4::new([0.0; 4]),
        f64x4::new([0.0, no, no, no]),
        f64x4::new([0.0, 0.0, no, no]),
        f64x4::new([0.0, 0.0, 0.0, no]),
    ]
};

/// Columns of nodes and images sorted by cell.
#[derive(Debug)]
pub struct CellSorted<const D: usize> {
    cells: CellList<D>,
    axes: SearchAxes<D>,
    rotated_positions: Vec<PlanVector<D>>,
    position: [Vec<f64>; D],
    /// Smoothing length before heights are summed (m).
    pub(super) previous_length: Vec<f64>,
    /// Velocity (m/s).
    pub velocity: [Vec<f64>; D],
    /// Volume (m³).
    pub volume: Vec<f64>,
    /// Smoothing length (m).
    pub length: Vec<f64>,
    /// Height of the phase (m).
    pub partial_thickness: Vec<f64>,
    /// Total depth (m).
    pub depth: Vec<f64>,
    /// Pressure, see [`NeighbourData`].
    pub pressure: Vec<f64>,
    /// Fields whose gradients are computed, if the problem has them. The first is empty: that field is stored height itself.
    pub fields: [Vec<f64>; FIELDS],
}

impl<const D: usize> Default for CellSorted<D> {
    fn default() -> Self {
        Self {
            cells: CellList::new(),
            axes: SearchAxes::PLAN,
            rotated_positions: Vec::new(),
            position: std::array::from_fn(|_| Vec::new()),
            previous_length: Vec::new(),
            velocity: std::array::from_fn(|_| Vec::new()),
            volume: Vec::new(),
            length: Vec::new(),
            partial_thickness: Vec::new(),
            depth: Vec::new(),
            pressure: Vec::new(),
            fields: std::array::from_fn(|_| Vec::new()),
        }
    }
}

/// Four consecutive values of a column; zero for an empty column.
#[inline(always)]
pub fn four_values(column: &[f64], first: usize) -> f64x4 {
    match column.get(first..first + 4).and_then(|four| four.first_chunk()) {
        Some(four) => f64x4::new(*four),
        None => f64x4::ZERO,
    }
}

/// Sum of the lanes, in the same order on every machine.
#[inline(always)]
pub fn sum_lanes(lanes: f64x4) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

/// Fills a column with `value` for each entry of `order`, with three more that lanes may read.
fn gather_column(order: &[u32], column: &mut Vec<f64>, value: impl Fn(usize) -> f64 + Sync) {
    column.resize(order.len() + 3, 0.0);
    let pairs = column.par_iter_mut().zip(order);
    pairs.with_min_len(8 * MIN_NODES_PER_TASK).for_each(|(entry, &j)| *entry = value(j as usize));
}

impl<const D: usize> CellSorted<D> {
    /// Sorts the neighbour data into cells of edge `edge` (m), and copies positions and volumes.
    ///
    /// # Errors
    /// When a position is not finite.
    pub fn sort_into_cells(
        &mut self,
        data: &NeighbourData<D>,
        edge: f64,
        search: SearchOrientation,
    ) -> Result<(), SearchError> {
        let axes = if search == SearchOrientation::Turned {
            SearchAxes::along_longest_extent(&data.position)
        } else {
            SearchAxes::PLAN
        };
        if axes.are_those_of_the_plan() {
            self.cells.build(&data.position, edge)?;
        } else {
            let place = |i: usize| axes.to_axes(&data.position[i]);
            (0..data.position.len())
                .into_par_iter()
                .with_min_len(8 * MIN_NODES_PER_TASK)
                .map(place)
                .collect_into_vec(&mut self.rotated_positions);
            self.cells.build(&self.rotated_positions, edge)?;
        }
        self.axes = axes;
        let order = self.cells.order();
        for (c, column) in self.position.iter_mut().enumerate() {
            gather_column(order, column, |j| data.position[j][c]);
        }
        gather_column(order, &mut self.volume, |j| data.volume[j]);
        gather_column(order, &mut self.previous_length, |j| data.length[j]);
        Ok(())
    }

    /// Copies the heights of the phase.
    pub fn update_thickness(&mut self, data: &NeighbourData<D>) {
        gather_column(self.cells.order(), &mut self.partial_thickness, |j| data.height[j]);
    }

    /// Columns of values of the neighbour data, in the order of the cells.
    pub fn sorted_values<const N: usize>(&self, value: impl Fn(usize) -> [f64; N] + Sync) -> [Vec<f64>; N] {
        let order = self.cells.order();
        std::array::from_fn(|c| {
            let mut column = Vec::new();
            gather_column(order, &mut column, |j| value(j)[c]);
            column
        })
    }

    /// Kernel average `Σ (m/h) f W / Σ (m/h) W` of columns of values at a position, with this smoothing length (m); `None` without nodes.
    pub fn mean<const N: usize>(
        &self,
        kernel: Kernel,
        x: &PlanVector<D>,
        length: f64,
        columns: &[Vec<f64>; N],
    ) -> Option<[f64; N]> {
        let (inverse, reach) = (1.0 / length, kernel.support() * length);
        let within = f64x4::splat(reach * reach);
        let (mut weights, mut sums) = (f64x4::ZERO, [f64x4::ZERO; N]);
        self.for_each_neighbour(x, reach, |first, _, square| {
            let inside = square.simd_lt(within);
            if !inside.any() {
                return;
            }
            let share = four_values(&self.volume, first) / four_values(&self.partial_thickness, first);
            let weight = inside & (kernel.profile_of_four::<D>(square.sqrt() * inverse) * share);
            weights += weight;
            for (sum, column) in sums.iter_mut().zip(columns) {
                *sum += weight * four_values(column, first);
            }
        });
        let weights = sum_lanes(weights);
        let all = weights * kernel.factor::<D>() * inverse.powi(D as i32);
        (all > NO_PARTNER).then(|| sums.map(|sum| sum_lanes(sum) / weights))
    }

    /// Copies the data of the forces.
    pub fn gather_force_data(&mut self, data: &NeighbourData<D>, with_fields: bool) {
        let order = self.cells.order();
        for (c, column) in self.velocity.iter_mut().enumerate() {
            gather_column(order, column, |j| data.velocity[j][c]);
        }
        gather_column(order, &mut self.length, |j| data.length[j]);
        gather_column(order, &mut self.partial_thickness, |j| data.height[j]);
        gather_column(order, &mut self.depth, |j| data.depth[j]);
        gather_column(order, &mut self.pressure, |j| data.pressure[j]);
        if with_fields {
            let sources = [&data.partner_height, &data.porosity, &data.excess, &data.level];
            for (column, source) in self.fields[1..].iter_mut().zip(sources) {
                gather_column(order, column, |j| source.get(j).copied().unwrap_or(0.0));
            }
        }
    }

    /// Calls `visit` for groups of four nodes from the cells within `radius` of `x` (m). It receives the index of the first node, the
    /// vectors from the nodes to `x` (m) and the squared distances (m²), which are not-a-number for unused lanes.
    #[inline(always)]
    pub fn for_each_neighbour(
        &self,
        x: &PlanVector<D>,
        radius: f64,
        mut visit: impl FnMut(usize, [f64x4; D], f64x4),
    ) {
        let here = splat(x);
        self.cells.ranges_within(&self.axes.to_axes(x), radius, |run| {
            let mut first = run.start;
            while first < run.end {
                let left = run.end - first;
                let (apart, mut square) = self.separation(&here, first);
                if left < 4 {
                    square |= EMPTY_LANES[left];
                }
                visit(first, apart, square);
                first += 4;
            }
        });
    }

    /// Calls `visit` for the packed neighbours of a node.
    #[inline(always)]
    pub fn for_each_listed(
        &self,
        x: &PlanVector<D>,
        entries: &[u32],
        mut visit: impl FnMut(usize, [f64x4; D], f64x4),
    ) {
        let here = splat(x);
        for entry in entries {
            let (first, count) = simd_neighbour_list::unpack_entry(*entry);
            let (apart, mut square) = self.separation(&here, first);
            square |= EMPTY_LANES[count & 3];
            visit(first, apart, square);
        }
    }

    /// Vectors from four nodes to a position (m), and squared distances (m²).
    #[inline(always)]
    fn separation(&self, here: &[f64x4; D], first: usize) -> ([f64x4; D], f64x4) {
        let (mut apart, mut square) = ([f64x4::ZERO; D], f64x4::ZERO);
        for c in 0..D {
            apart[c] = here[c] - four_values(&self.position[c], first);
            square += apart[c] * apart[c];
        }
        (apart, square)
    }

    /// Kernel sum `Σ m W` at a position, for a smoothing length (m).
    #[inline]
    pub fn sum(&self, kernel: Kernel, x: &PlanVector<D>, length: f64) -> f64 {
        let reach = kernel.support() * length;
        let mut part = KernelSum::<D>::new(kernel, length);
        self.for_each_neighbour(x, reach, |first, _, square| {
            part.add(kernel, square.sqrt(), four_values(&self.volume, first));
        });
        part.total()
    }
}

/// Position in all lanes.
#[inline(always)]
fn splat<const D: usize>(x: &PlanVector<D>) -> [f64x4; D] {
    // A loop, not a closure over an array: that becomes a call with many codegen units.
    let mut here = [f64x4::ZERO; D];
    for c in 0..D {
        here[c] = f64x4::splat(x[c]);
    }
    here
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::simd_neighbour_list::MARGIN;

    /// Nodes at uneven positions, in no order.
    fn sample_nodes<const D: usize>() -> NeighbourData<D> {
        let mut nodes = NeighbourData::default();
        for k in 0..97u32 {
            let along = |c: u32| f64::from(k * (37 + 11 * c) % 97) * 0.05 + 0.002 * f64::from(k);
            nodes.position.push(std::array::from_fn(|c| along(c as u32)));
            nodes.volume.push(0.3 + 0.01 * f64::from(k));
            nodes.length.push(0.12 + 0.01 * f64::from(k % 9));
        }
        nodes
    }

    fn sums_count_each_node_once<const D: usize>(search: SearchOrientation) {
        let nodes = sample_nodes::<D>();
        let mut packed = CellSorted::default();
        packed.sort_into_cells(&nodes, 0.4, search).unwrap();
        for kernel in [Kernel::CubicSpline, Kernel::WendlandC2, Kernel::QuinticSpline, Kernel::Gaussian] {
            for length in [0.1, 0.33, 1.7] {
                for x in &nodes.position {
                    let of = |j: usize| {
                        let square: f64 = (0..D).map(|c| (x[c] - nodes.position[j][c]).powi(2)).sum();
                        nodes.volume[j] * kernel.value::<D>(square.sqrt(), length)
                    };
                    let plain: f64 = (0..nodes.volume.len()).map(of).sum();
                    let found = packed.sum(kernel, x, length);
                    let mut near = packed.nearby_nodes();
                    near.move_to(*x);
                    near.sum(kernel, 0.97 * length);
                    let again = near.sum(kernel, length);
                    assert!(
                        (again - found).abs() < 1e-12 * found,
                        "{kernel:?} {length} {x:?}: {again}, {found}"
                    );
                    assert!(
                        (found - plain).abs() < 1e-12 * plain,
                        "{kernel:?} {length} {x:?}: {found} for {plain}"
                    );
                }
            }
        }
    }

    #[test]
    fn sums_over_cells_are_those_over_all() {
        sums_count_each_node_once::<1>(SearchOrientation::Axes);
        sums_count_each_node_once::<2>(SearchOrientation::Axes);
        sums_count_each_node_once::<2>(SearchOrientation::Turned);
    }

    /// Lengths may grow by the margin after lists are made.
    #[test]
    fn lists_contain_all_neighbours_within_the_margin() {
        let nodes = sample_nodes::<2>();
        let mut packed = CellSorted::default();
        packed.sort_into_cells(&nodes, 0.3, SearchOrientation::Axes).unwrap();
        let longest = 0.2;
        let mut near = packed.nearby_nodes();
        for (x, length) in nodes.position.iter().zip(&nodes.length) {
            let entries = near
                .list_neighbours(Kernel::CubicSpline, *x, *length, longest)
                .expect("room for all")
                .to_vec();
            let mut listed = vec![0; nodes.volume.len()];
            packed.for_each_listed(x, &entries, |first, _, square| {
                for (lane, square) in
                    square.to_array().into_iter().enumerate().filter(|(_, square)| !square.is_nan())
                {
                    let j = packed.cells.order()[first + lane] as usize;
                    let apart = crate::neighbours::kernel_average::square(x, &nodes.position[j]);
                    assert!((square - apart).abs() < 1e-15, "{square} for {apart}");
                    listed[j] += 1;
                }
            });
            for (j, count) in listed.into_iter().enumerate() {
                let reach = (1.0 + MARGIN) * (length + nodes.length[j]);
                let is_near = crate::neighbours::kernel_average::square(x, &nodes.position[j])
                    < reach * reach * (1.0 - 1e-12);
                assert!(count <= 1 && (count == 1 || !is_near), "{x:?} {j}: {count}");
            }
        }
    }
}
