//! Pressure and artificial viscosity between the nodes of one set (sheet: depth-sph §2.5, §2.9, §2.10).

use colluvium_points::NeighbourList;
use wide::f64x4;

use crate::bed::BedPoint;
use crate::config::choices::PressureForceForm;
use crate::config::settings::FlowSettings;
use crate::kernel::Kernel;
use crate::momentum::artificial_viscosity::ArtificialViscosity;
use crate::momentum::force_sums::{ForceSums, SimdForceSums, gradient_fields};
use crate::neighbours::cell_sorted::{CellSorted, FIELDS, four_values};
use crate::neighbours::max_smoothing_length::MaxSmoothingLength;
use crate::neighbours::simd_neighbour_list;
use crate::neighbours::simd_neighbour_list::PackedNeighbours;
use crate::phases::phase::PhaseSet;
use crate::points::phase_nodes::{NeighbourData, PhaseNodes};

/// Force sums over pairs of nodes of one set, with the data that they need.
pub(crate) struct PairForces<'a, const D: usize> {
    /// Material, gravity and numerical parameters of the flow.
    pub(crate) settings: &'a FlowSettings<D>,
    /// Nodes of the set.
    pub(crate) nodes: &'a PhaseNodes<D>,
    /// Position, velocity and volume of the nodes as neighbours.
    pub(crate) neighbour_data: &'a NeighbourData<D>,
    /// Copy of the neighbour data in the order of the search cells.
    pub(crate) cell_sorted: &'a CellSorted<D>,
    /// Largest smoothing length around each cell (m).
    pub(crate) max_smoothing_length: &'a MaxSmoothingLength<D>,
    /// Neighbour list for SIMD sums.
    pub(crate) packed_neighbours: &'a PackedNeighbours,
    /// Bed below each node.
    pub(crate) bed: &'a [BedPoint<D>],
    /// Reaction of the bed over mass, per node (m/s²).
    pub(crate) reaction: &'a [f64],
    /// Neighbours of each node in the other phase.
    pub(crate) other_phase_neighbours: &'a NeighbourList<D>,
}

impl<'a, const D: usize> PairForces<'a, D> {
    /// Force sums of the nodes of a set.
    pub(super) fn for_set(settings: &'a FlowSettings<D>, set: &'a PhaseSet<D>) -> Self {
        Self {
            settings,
            nodes: &set.nodes,
            neighbour_data: &set.neighbour_data,
            cell_sorted: &set.cell_sorted,
            max_smoothing_length: &set.max_smoothing_length,
            packed_neighbours: &set.packed_neighbours,
            bed: &set.bed,
            reaction: &set.reaction,
            other_phase_neighbours: &set.other_phase_neighbours,
        }
    }

    /// Force sums of node `i` in the variational form: each pressure is weighted by the kernel gradient with the smoothing length of its
    /// own node (sheet: depth-sph §3.4).
    #[inline]
    pub(super) fn variational_sums(&self, i: usize) -> ForceSums<D> {
        let numerics = &self.settings.numerics;
        let kernel = numerics.kernel;
        let support = kernel.support();
        let (nodes, data, sorted) = (self.nodes, self.neighbour_data, self.cell_sorted);
        let (x, length) = (&nodes.position[i], nodes.length[i]);
        let viscosity = ArtificialViscosity::for_node(numerics, nodes, i);
        let factor = f64x4::splat(kernel.factor::<D>());
        let mut sums = SimdForceSums::ZERO;
        sorted.for_each_neighbour(
            x,
            support * self.max_smoothing_length.length_at(x).max(length),
            |first, apart, square| {
                let (own, theirs) = (f64x4::splat(length), four_values(&sorted.length, first));
                let volumes = four_values(&sorted.volume, first);
                let weigh = |length: f64x4| {
                    let reach = length * support;
                    square.simd_lt(reach * reach)
                        & (kernel_slopes::<D>(kernel, factor, square, length) * volumes)
                };
                let (here, there) = (weigh(own), weigh(theirs));
                let gradient = here * data.pressure[i] + there * four_values(&sorted.pressure, first);
                let (mut closing, mut relative) = (f64x4::ZERO, [f64x4::ZERO; D]);
                for c in 0..D {
                    sums.pressure_gradient[c] += gradient * apart[c];
                    relative[c] =
                        f64x4::splat(nodes.velocity[i][c]) - four_values(&sorted.velocity[c], first);
                    closing += relative[c] * apart[c];
                }
                let inside = (here + there).simd_ne(f64x4::ZERO);
                sums.include_relative_velocity(inside, &relative);
                let approaching = closing.simd_lt(f64x4::ZERO) & inside;
                if approaching.any() {
                    let (mean, heights) =
                        ((own + theirs) * 0.5, four_values(&sorted.partial_thickness, first));
                    let strength = viscosity.over_kernel(
                        closing,
                        square,
                        mean,
                        four_values(&sorted.depth, first),
                        heights,
                    );
                    let strength = approaching & (strength * (here + there) * 0.5);
                    sums.add_viscosity(strength, &apart);
                }
            },
        );
        sums.sums()
    }

    /// Force sums over the neighbours of node `i`; gradients of the fields only with `GRADIENTS`.
    #[inline]
    pub(super) fn sums<const GRADIENTS: bool>(&self, i: usize, spare: &mut Vec<u32>) -> ForceSums<D> {
        let listed = self.packed_neighbours.are_complete();
        if !listed {
            let (x, length, sorted) = (&self.nodes.position[i], self.nodes.length[i], self.cell_sorted);
            let half = 0.5 * self.settings.numerics.kernel.support();
            spare.clear();
            sorted.for_each_neighbour(
                x,
                half * (length + self.max_smoothing_length.length_at(x).max(length)),
                |first, _, square| {
                    spare.push(simd_neighbour_list::pack_entry(first, square));
                },
            );
        }
        let entries = if listed { self.packed_neighbours.entries(i) } else { spare };
        // For the cubic spline the compiler makes a loop of its own.
        match self.settings.numerics.kernel {
            Kernel::CubicSpline => self.pair_sums::<GRADIENTS, true>(i, entries),
            _ => self.pair_sums::<GRADIENTS, false>(i, entries),
        }
    }

    /// Force sums over the listed neighbours of node `i`.
    #[inline]
    fn pair_sums<const GRADIENTS: bool, const CUBIC: bool>(&self, i: usize, entries: &[u32]) -> ForceSums<D> {
        let numerics = &self.settings.numerics;
        let kernel = if CUBIC { Kernel::CubicSpline } else { numerics.kernel };
        let product = numerics.momentum == PressureForceForm::Product;
        let half_support = 0.5 * kernel.support();
        let (nodes, data, sorted) = (self.nodes, self.neighbour_data, self.cell_sorted);
        let (x, length) = (&nodes.position[i], nodes.length[i]);
        let (pressure, height) = (f64x4::splat(data.pressure[i]), f64x4::splat(nodes.partial_thickness[i]));
        let mut velocity = [f64x4::ZERO; D];
        for c in 0..D {
            velocity[c] = f64x4::splat(nodes.velocity[i][c]);
        }
        let viscosity = ArtificialViscosity::for_node(numerics, nodes, i);
        let mut here = [f64x4::ZERO; FIELDS];
        if GRADIENTS {
            here = gradient_fields(data, i).map(f64x4::splat);
        }
        let factor = f64x4::splat(kernel.factor::<D>());
        let mut sums = SimdForceSums::ZERO;
        sorted.for_each_listed(x, entries, |first, apart, square| {
            let both = four_values(&sorted.length, first) + length;
            let reach = both * half_support;
            let inside = square.simd_lt(reach * reach);
            if !inside.any() {
                return;
            }
            let mean = both * 0.5;
            let weight = inside
                & (kernel_slopes::<D>(kernel, factor, square, mean) * four_values(&sorted.volume, first));
            let (heights, pressures) =
                (four_values(&sorted.partial_thickness, first), four_values(&sorted.pressure, first));
            let pair = if product {
                // (P_I + P_J)/(h_I h_J), from pressures given as P/h².
                inside & (pressure * height / heights + pressures * heights / height)
            } else {
                pressure + pressures
            };
            let gradient = pair * weight;
            let (mut closing, mut relative) = (f64x4::ZERO, [f64x4::ZERO; D]);
            for c in 0..D {
                sums.pressure_gradient[c] += gradient * apart[c];
                relative[c] = velocity[c] - four_values(&sorted.velocity[c], first);
                closing += relative[c] * apart[c];
            }
            sums.include_relative_velocity(inside, &relative);
            let approaching = inside & closing.simd_lt(f64x4::ZERO);
            if approaching.any() {
                let strength =
                    viscosity.over_kernel(closing, square, mean, four_values(&sorted.depth, first), heights);
                let strength = approaching & (strength * weight);
                sums.add_viscosity(strength, &apart);
            }
            if GRADIENTS {
                sums.add_field_gradients(sorted, first, inside & (weight / heights), &here, &apart);
            }
        });
        sums.sums()
    }
}

/// Kernel factor `(∂W/∂r)/r` of four neighbours, from squared distances and mean smoothing lengths.
#[inline(always)]
fn kernel_slopes<const D: usize>(kernel: Kernel, factor: f64x4, square: f64x4, mean: f64x4) -> f64x4 {
    // For a node at the same position, the node itself above all, the vector is zero.
    let distance = square.sqrt().fast_max(mean * 1e-12);
    let inverses = f64x4::ONE / (mean * distance);
    let inverse = inverses * distance;
    let two = inverse * inverse;
    let power = if D == 1 { two * inverse } else { two * two };
    factor * power * kernel.slope_of_four::<D>(distance * inverse, mean * mean * inverses)
}
