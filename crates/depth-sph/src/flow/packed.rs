//! Nodes and their images in the order of cells, column by column: what lies around a place is a few runs of each column, read four
//! nodes at a time.

use colluvium_points::{CellList, SearchError};
use rayon::prelude::*;
use wide::f64x4;

use super::set::TASK;
use crate::kernel::Kernel;
use crate::nodes::{Plan, Seen};

/// Fields whose gradients are taken: height, that of the other phase, porosity, excess pressure, level of the bed.
pub const FIELDS: usize = 5;
/// Lanes that a run does not reach: not-a-number, which is nearer than nothing.
const BEYOND: [f64x4; 4] = {
    let no = f64::from_bits(u64::MAX);
    [
        f64x4::new([0.0; 4]),
        f64x4::new([0.0, no, no, no]),
        f64x4::new([0.0, 0.0, no, no]),
        f64x4::new([0.0, 0.0, 0.0, no]),
    ]
};

/// Columns of nodes and images in the order of cells.
#[derive(Debug)]
pub struct Packed<const D: usize> {
    cells: CellList<D>,
    place: [Vec<f64>; D],
    /// Velocity (m/s).
    pub velocity: [Vec<f64>; D],
    /// Volume (m³).
    pub volume: Vec<f64>,
    /// Smoothing length (m).
    pub length: Vec<f64>,
    /// Height of the phase (m).
    pub height: Vec<f64>,
    /// Total depth (m).
    pub depth: Vec<f64>,
    /// As in [`Seen`].
    pub pressure: Vec<f64>,
    /// Fields of which gradients are taken, so far as there are such; the first one is empty.
    pub fields: [Vec<f64>; FIELDS],
}

impl<const D: usize> Default for Packed<D> {
    fn default() -> Self {
        Self {
            cells: CellList::new(),
            place: std::array::from_fn(|_| Vec::new()),
            velocity: std::array::from_fn(|_| Vec::new()),
            volume: Vec::new(),
            length: Vec::new(),
            height: Vec::new(),
            depth: Vec::new(),
            pressure: Vec::new(),
            fields: std::array::from_fn(|_| Vec::new()),
        }
    }
}

/// Four values of a column; zero where it is empty.
#[inline(always)]
pub fn four(column: &[f64], first: usize) -> f64x4 {
    f64x4::new(column[first..].first_chunk().copied().unwrap_or_default())
}

/// Sum of the lanes, in this order on every machine.
#[inline(always)]
pub fn whole(lanes: f64x4) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

/// Puts what `value` is for each entry of `order` into a column, with three more that lanes may read.
fn gather(order: &[u32], column: &mut Vec<f64>, value: impl Fn(usize) -> f64 + Sync) {
    column.resize(order.len() + 3, 0.0);
    let pairs = column.par_iter_mut().zip(order);
    pairs.with_min_len(8 * TASK).for_each(|(entry, &j)| *entry = value(j as usize));
}

impl<const D: usize> Packed<D> {
    /// Sorts what is seen into cells of edge `edge` (m), and takes places and volumes.
    ///
    /// # Errors
    /// When a place is not finite.
    pub fn pack(&mut self, seen: &Seen<D>, edge: f64) -> Result<(), SearchError> {
        self.cells.build(&seen.position, edge)?;
        let order = self.cells.order();
        for (c, column) in self.place.iter_mut().enumerate() {
            gather(order, column, |j| seen.position[j][c]);
        }
        gather(order, &mut self.volume, |j| seen.volume[j]);
        Ok(())
    }

    /// Takes what forces are made of.
    pub fn fill(&mut self, seen: &Seen<D>, with_fields: bool) {
        let order = self.cells.order();
        for (c, column) in self.velocity.iter_mut().enumerate() {
            gather(order, column, |j| seen.velocity[j][c]);
        }
        gather(order, &mut self.length, |j| seen.length[j]);
        gather(order, &mut self.height, |j| seen.height[j]);
        gather(order, &mut self.depth, |j| seen.depth[j]);
        gather(order, &mut self.pressure, |j| seen.pressure[j]);
        if with_fields {
            let sources = [&seen.partner, &seen.porosity, &seen.excess, &seen.level];
            for (column, source) in self.fields[1..].iter_mut().zip(sources) {
                gather(order, column, |j| source.get(j).copied().unwrap_or(0.0));
            }
        }
    }

    /// Calls `visit` for four at a time of those in the cells that a ball of `radius` (m) around `x` can touch: the number of the first
    /// of them, vectors from each of them to `x` (m), and the squares of their lengths (m²), which are not-a-number for what is
    /// not to be counted.
    #[inline(always)]
    pub fn around(&self, x: &Plan<D>, radius: f64, mut visit: impl FnMut(usize, [f64x4; D], f64x4)) {
        let here = x.map(f64x4::splat);
        self.cells.runs_within(x, radius, |run| {
            let mut first = run.start;
            while first < run.end {
                let apart: [f64x4; D] = std::array::from_fn(|c| here[c] - four(&self.place[c], first));
                let mut square = apart[0] * apart[0];
                for c in 1..D {
                    square += apart[c] * apart[c];
                }
                let left = run.end - first;
                if left < 4 {
                    square |= BEYOND[left];
                }
                visit(first, apart, square);
                first += 4;
            }
        });
    }

    /// `Σ m W` at a place, with this smoothing length (m).
    #[inline]
    pub fn sum(&self, kernel: Kernel, x: &Plan<D>, length: f64) -> f64 {
        let inverse = 1.0 / length;
        let reach = kernel.support() * length;
        let within = f64x4::splat(reach * reach);
        let mut total = f64x4::ZERO;
        self.around(x, reach, |first, _, square| {
            let inside = square.simd_lt(within);
            let shape = kernel.shapes::<D>(square.sqrt() * inverse);
            total += (inside & shape) * four(&self.volume, first);
        });
        whole(total) * kernel.factor::<D>() * inverse.powi(D as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes at uneven places, in no order.
    fn seen<const D: usize>() -> Seen<D> {
        let mut seen = Seen::default();
        for k in 0..97u32 {
            let along = |c: u32| f64::from(k * (37 + 11 * c) % 97) * 0.05 + 0.002 * f64::from(k);
            seen.position.push(std::array::from_fn(|c| along(c as u32)));
            seen.volume.push(0.3 + 0.01 * f64::from(k));
        }
        seen
    }

    fn sums_count_each_node_once<const D: usize>() {
        let seen = seen::<D>();
        let mut packed = Packed::default();
        packed.pack(&seen, 0.4).unwrap();
        for kernel in [Kernel::CubicSpline, Kernel::WendlandC2, Kernel::QuinticSpline, Kernel::Gaussian] {
            for length in [0.1, 0.33, 1.7] {
                for x in &seen.position {
                    let of = |j: usize| {
                        let square: f64 = (0..D).map(|c| (x[c] - seen.position[j][c]).powi(2)).sum();
                        seen.volume[j] * kernel.value::<D>(square.sqrt(), length)
                    };
                    let plain: f64 = (0..seen.volume.len()).map(of).sum();
                    let found = packed.sum(kernel, x, length);
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
        sums_count_each_node_once::<1>();
        sums_count_each_node_once::<2>();
    }
}
