//! Neighbours of one position, kept for several sums (sheet: depth-sph §2.10).

use wide::f64x4;

use crate::kernel::Kernel;
use crate::neighbours::cell_sorted::{CellSorted, four_values, sum_lanes};
use crate::neighbours::kernel_sum::KernelSum;
use crate::neighbours::simd_neighbour_list;
use crate::neighbours::simd_neighbour_list::MARGIN;
use crate::points::phase_nodes::PlanVector;

/// Largest number of groups of four neighbours that are stored for a position.
const MAX_PACKS: usize = 32;

/// Neighbours of a position: distances (m) and volumes in groups of four nodes, up to `search_radius` (m).
pub struct NearbyNodes<'a, const D: usize> {
    sorted_nodes: &'a CellSorted<D>,
    x: PlanVector<D>,
    search_radius: f64,
    count: usize,
    distances: [f64x4; MAX_PACKS],
    volumes: [f64x4; MAX_PACKS],
    entries: [u32; MAX_PACKS],
}

impl<const D: usize> NearbyNodes<'_, D> {
    /// Moves to a position (m), without neighbours.
    #[inline]
    pub fn move_to(&mut self, x: PlanVector<D>) {
        (self.x, self.search_radius) = (x, 0.0);
    }

    /// Moves to a node and lists all neighbours that forces can need. Smoothing lengths may grow by the margin, up to `longest` (m).
    #[inline]
    pub fn list_neighbours(
        &mut self,
        kernel: Kernel,
        x: PlanVector<D>,
        length: f64,
        longest: f64,
    ) -> Option<&[u32]> {
        self.x = x;
        let half = 0.5 * (1.0 + MARGIN) * kernel.support();
        let packed = self.sorted_nodes;
        let own = f64x4::splat(length);
        self.collect_if(half * (length + longest.max(length)), |first| {
            let reach = (own + four_values(&packed.previous_length, first).fast_max(own)) * half;
            reach * reach
        });
        let fits = self.count <= MAX_PACKS;
        self.search_radius = if fits { 2.0 * half * length } else { 0.0 };
        fits.then(|| &self.entries[..self.count])
    }

    /// Kernel sum `Σ m W` for a smoothing length (m).
    #[inline]
    pub fn sum(&mut self, kernel: Kernel, length: f64) -> f64 {
        self.sum_of::<false>(kernel, length)
    }

    /// Kernel sum `Σ m W` for a smoothing length (m); with `CUBIC` the kernel is the cubic spline at compile time.
    #[inline]
    pub fn sum_of<const CUBIC: bool>(&mut self, kernel: Kernel, length: f64) -> f64 {
        let kernel = if CUBIC { Kernel::CubicSpline } else { kernel };
        let reach = kernel.support() * length;
        if reach > self.search_radius && !self.collect((1.0 + MARGIN) * reach) {
            return self.sorted_nodes.sum(kernel, &self.x, length);
        }
        let mut part = KernelSum::<D>::new(kernel, length);
        for (distance, volume) in self.distances[..self.count].iter().zip(&self.volumes) {
            part.add(kernel, *distance, *volume);
        }
        part.total()
    }

    /// Kernel sum `Σ m W` for a smoothing length (m), and its derivative with respect to that length.
    #[inline]
    pub fn sum_and_slope(&mut self, kernel: Kernel, length: f64) -> (f64, f64) {
        let reach = kernel.support() * length;
        let (inverse, mut total, mut change) = (1.0 / length, f64x4::ZERO, f64x4::ZERO);
        let mut add = |distance: f64x4, volume: f64x4| {
            let q = (distance * inverse).fast_max(f64x4::splat(1e-12));
            let volume = distance.simd_lt(f64x4::splat(reach)) & volume;
            let shape = kernel.profile_of_four::<D>(q);
            total += shape * volume;
            change += (shape * D as f64 + q * q * kernel.slope_of_four::<D>(q, f64x4::ONE / q)) * volume;
        };
        if reach <= self.search_radius || self.collect((1.0 + MARGIN) * reach) {
            for (distance, volume) in self.distances[..self.count].iter().zip(&self.volumes) {
                add(*distance, *volume);
            }
        } else {
            let packed = self.sorted_nodes;
            packed.for_each_neighbour(&self.x, reach, |first, _, square| {
                add(square.sqrt(), four_values(&packed.volume, first));
            });
        }
        let factor = kernel.factor::<D>() * inverse.powi(D as i32);
        (sum_lanes(total) * factor, -sum_lanes(change) * factor * inverse)
    }

    /// Stores the neighbours within `reach` (m); false if the buffer is too small for all of them.
    #[inline]
    fn collect(&mut self, reach: f64) -> bool {
        let within = f64x4::splat(reach * reach);
        self.collect_if(reach, |_| within);
        let fits = self.count <= MAX_PACKS;
        self.search_radius = if fits { reach } else { 0.0 };
        fits
    }

    /// Stores the groups of four nodes within `radius` (m) of which at least one node is closer than the root of `within` (m²).
    #[inline(always)]
    fn collect_if(&mut self, radius: f64, within: impl Fn(usize) -> f64x4) {
        let Self { sorted_nodes, x, count, distances, volumes, entries, .. } = self;
        *count = 0;
        // Without a branch for each pack: which are near cannot be predicted.
        sorted_nodes.for_each_neighbour(x, radius, |first, _, square| {
            let slot = (*count).min(MAX_PACKS - 1);
            (entries[slot], distances[slot]) = (first as u32, square);
            *count += usize::from(square.simd_lt(within(first)).any());
        });
        for k in 0..(*count).min(MAX_PACKS) {
            let (first, square) = (entries[k] as usize, distances[k]);
            entries[k] = simd_neighbour_list::pack_entry(first, square);
            (distances[k], volumes[k]) = (square.sqrt(), four_values(&sorted_nodes.volume, first));
        }
    }
}

impl<const D: usize> CellSorted<D> {
    /// Buffer for the neighbours of a position, from which several sums are computed.
    #[inline]
    pub fn nearby_nodes(&self) -> NearbyNodes<'_, D> {
        let none = [f64x4::ZERO; MAX_PACKS];
        NearbyNodes {
            sorted_nodes: self,
            x: [0.0; D],
            search_radius: 0.0,
            count: 0,
            distances: none,
            volumes: none,
            entries: [0; MAX_PACKS],
        }
    }
}
