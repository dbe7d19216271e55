//! Pressure, artificial viscosity, gradients of porosity and the reaction of the bed (sheet: depth-sph §2.5, §2.9, §2.10).

use colluvium_points::NeighbourList;
use rayon::prelude::*;
use wide::f64x4;

use crate::bed::BedPoint;
use crate::config::choices::{Phases, PressureForceForm};
use crate::config::settings::FlowSettings;
use crate::neighbours::cell_sorted::{CellSorted, FIELDS, four_values, sum_lanes};
use crate::neighbours::kernel::Kernel;
use crate::neighbours::max_smoothing_length::MaxSmoothingLength;
use crate::neighbours::simd_neighbour_list;
use crate::neighbours::simd_neighbour_list::PackedNeighbours;
use crate::phases::phase::{PhaseSet, TASK};
use crate::phases::phase_nodes::{NeighbourData, PhaseNodes, PlanVector, dot};

/// Determinant below which the correction of gradients is left out (sheet: depth-sph §2.10).
const ILL_CONDITIONED: f64 = 1e-3;
/// Term that keeps the viscosity finite for coincident nodes, in squares of the smoothing length.
const SOFTENING: f64 = 0.01;

/// Phase of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhaseRole {
    /// Single phase.
    Single,
    /// Grains of a mixture.
    Solid,
    /// Pore fluid of a mixture.
    Fluid,
    /// Avalanche below water.
    Lower,
    /// Water above an avalanche.
    Upper,
}

/// Sums over the neighbours of a node.
pub(crate) struct ForceSums<const D: usize> {
    /// `Σ m (p_I + p_J) ∇W`, the pressure force over `-g_*`.
    pub(crate) pressure_gradient: PlanVector<D>,
    /// `-Σ m Π ∇W` (m/s²).
    pub(crate) viscous: PlanVector<D>,
    /// `Σ (m/h) (f_J - f_I) ∇W` of the fields.
    pub(crate) field_gradients: [PlanVector<D>; FIELDS],
    /// `Σ (m/h) (x_J - x_I) ⊗ ∇W`.
    pub(crate) moment: [PlanVector<D>; D],
}

/// Solution `A⁻¹ b` in one or two dimensions; `b` where `A` is ill-conditioned.
pub fn corrected<const D: usize>(matrix: &[PlanVector<D>; D], vector: &PlanVector<D>) -> PlanVector<D> {
    let mut result = *vector;
    if D == 1 {
        if matrix[0][0] > ILL_CONDITIONED {
            result[0] = vector[0] / matrix[0][0];
        }
        return result;
    }
    let determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
    if determinant > ILL_CONDITIONED {
        result[0] = (matrix[1][1] * vector[0] - matrix[0][1] * vector[1]) / determinant;
        result[1] = (matrix[0][0] * vector[1] - matrix[1][0] * vector[0]) / determinant;
    }
    result
}

/// Force sums between the nodes of one set, with the data that they read.
pub(crate) struct PairForces<'a, const D: usize> {
    pub(crate) settings: &'a FlowSettings<D>,
    pub(crate) nodes: &'a PhaseNodes<D>,
    pub(crate) neighbour_data: &'a NeighbourData<D>,
    pub(crate) cell_sorted: &'a CellSorted<D>,
    pub(crate) max_smoothing_length: &'a MaxSmoothingLength<D>,
    pub(crate) packed_neighbours: &'a PackedNeighbours,
    pub(crate) bed: &'a [BedPoint<D>],
    pub(crate) reaction: &'a [f64],
    pub(crate) across: &'a NeighbourList<D>,
}

/// Force sums in lanes of four neighbours.
struct SimdForceSums<const D: usize> {
    push: [f64x4; D],
    viscous: [f64x4; D],
    slopes: [[f64x4; D]; FIELDS],
    moment: [[f64x4; D]; D],
}

impl<const D: usize> SimdForceSums<D> {
    const NONE: Self = Self {
        push: [f64x4::ZERO; D],
        viscous: [f64x4::ZERO; D],
        slopes: [[f64x4::ZERO; D]; FIELDS],
        moment: [[f64x4::ZERO; D]; D],
    };

    /// Adds the terms of four neighbours, `-(m/h) W'/r`, to the gradients of the fields, whose values at the node are `here`.
    #[inline(always)]
    fn add_slopes(
        &mut self,
        near: &CellSorted<D>,
        first: usize,
        share: f64x4,
        here: &[f64x4; FIELDS],
        apart: &[f64x4; D],
    ) {
        for (f, slope) in self.slopes.iter_mut().enumerate() {
            let column = if f == 0 { &near.partial_thickness } else { &near.fields[f] };
            let change = share * (four_values(column, first) - here[f]);
            for c in 0..D {
                slope[c] += change * apart[c];
            }
        }
        for c in 0..D {
            for k in 0..D {
                self.moment[c][k] -= share * apart[c] * apart[k];
            }
        }
    }

    #[inline(always)]
    fn sums(self) -> ForceSums<D> {
        ForceSums {
            pressure_gradient: self.push.map(sum_lanes),
            viscous: self.viscous.map(sum_lanes),
            field_gradients: self.slopes.map(|slope| slope.map(sum_lanes)),
            moment: self.moment.map(|row| row.map(sum_lanes)),
        }
    }
}

impl<const D: usize> PairForces<'_, D> {
    /// Sums over the neighbours of node `i` with the smoothing length of each for its pressure (sheet: depth-sph §3.4).
    #[inline]
    fn variational(&self, i: usize) -> ForceSums<D> {
        let numerics = &self.settings.numerics;
        let kernel = numerics.kernel;
        let support = kernel.support();
        let (nodes, seen, near) = (self.nodes, self.neighbour_data, self.cell_sorted);
        let (x, length) = (&nodes.position[i], nodes.length[i]);
        let viscosity = ArtificialViscosity::of(
            numerics.viscosity,
            nodes.effective_gravity[i],
            nodes.depth[i],
            nodes.partial_thickness[i],
        );
        let factor = f64x4::splat(kernel.factor::<D>());
        let mut sums = SimdForceSums::NONE;
        near.for_each_neighbour(
            x,
            support * self.max_smoothing_length.at(x).max(length),
            |first, apart, square| {
                let (own, theirs) = (f64x4::splat(length), four_values(&near.length, first));
                let volumes = four_values(&near.volume, first);
                let weigh = |length: f64x4| {
                    let reach = length * support;
                    square.simd_lt(reach * reach)
                        & (kernel_slopes::<D>(kernel, factor, square, length) * volumes)
                };
                let (here, there) = (weigh(own), weigh(theirs));
                let push = here * seen.pressure[i] + there * four_values(&near.pressure, first);
                let mut closing = f64x4::ZERO;
                for c in 0..D {
                    sums.push[c] += push * apart[c];
                    closing += (f64x4::splat(nodes.velocity[i][c]) - four_values(&near.velocity[c], first))
                        * apart[c];
                }
                let approaching = closing.simd_lt(f64x4::ZERO) & (here + there).simd_ne(f64x4::ZERO);
                if approaching.any() {
                    let (mean, heights) = ((own + theirs) * 0.5, four_values(&near.partial_thickness, first));
                    let strength = viscosity.over_kernel(
                        closing,
                        square,
                        mean,
                        four_values(&near.depth, first),
                        heights,
                    );
                    let strength = approaching & (strength * (here + there) * 0.5);
                    for c in 0..D {
                        sums.viscous[c] -= strength * apart[c];
                    }
                }
            },
        );
        sums.sums()
    }

    /// Sums over the neighbours of node `i`; gradients only where they are needed.
    #[inline]
    fn sums<const GRADIENTS: bool>(&self, i: usize, spare: &mut Vec<u32>) -> ForceSums<D> {
        let listed = self.packed_neighbours.are_complete();
        if !listed {
            let (x, length, near) = (&self.nodes.position[i], self.nodes.length[i], self.cell_sorted);
            let half = 0.5 * self.settings.numerics.kernel.support();
            spare.clear();
            near.for_each_neighbour(
                x,
                half * (length + self.max_smoothing_length.at(x).max(length)),
                |first, _, square| {
                    spare.push(simd_neighbour_list::pack_entry(first, square));
                },
            );
        }
        let entries = if listed { self.packed_neighbours.entries(i) } else { spare };
        // For the cubic spline the compiler makes a loop of its own.
        match self.settings.numerics.kernel {
            Kernel::CubicSpline => self.sums_over::<GRADIENTS, true>(i, entries),
            _ => self.sums_over::<GRADIENTS, false>(i, entries),
        }
    }

    /// Sums over packed neighbours.
    #[inline]
    fn sums_over<const GRADIENTS: bool, const CUBIC: bool>(&self, i: usize, entries: &[u32]) -> ForceSums<D> {
        let numerics = &self.settings.numerics;
        let kernel = if CUBIC { Kernel::CubicSpline } else { numerics.kernel };
        let product = numerics.momentum == PressureForceForm::Product;
        let half_support = 0.5 * kernel.support();
        let (nodes, seen, near) = (self.nodes, self.neighbour_data, self.cell_sorted);
        let (x, length) = (&nodes.position[i], nodes.length[i]);
        let (pressure, height) = (f64x4::splat(seen.pressure[i]), f64x4::splat(nodes.partial_thickness[i]));
        let mut velocity = [f64x4::ZERO; D];
        for c in 0..D {
            velocity[c] = f64x4::splat(nodes.velocity[i][c]);
        }
        let viscosity = ArtificialViscosity::of(
            numerics.viscosity,
            nodes.effective_gravity[i],
            nodes.depth[i],
            nodes.partial_thickness[i],
        );
        let mut here = [f64x4::ZERO; FIELDS];
        if GRADIENTS {
            here = gradient_fields(seen, i).map(f64x4::splat);
        }
        let factor = f64x4::splat(kernel.factor::<D>());
        let mut sums = SimdForceSums::NONE;
        near.for_each_listed(x, entries, |first, apart, square| {
            let both = four_values(&near.length, first) + length;
            let reach = both * half_support;
            let inside = square.simd_lt(reach * reach);
            if !inside.any() {
                return;
            }
            let mean = both * 0.5;
            let weight = inside
                & (kernel_slopes::<D>(kernel, factor, square, mean) * four_values(&near.volume, first));
            let (heights, pressures) =
                (four_values(&near.partial_thickness, first), four_values(&near.pressure, first));
            let pair = if product {
                // (P_I + P_J)/(h_I h_J), from pressures given as P/h².
                inside & (pressure * height / heights + pressures * heights / height)
            } else {
                pressure + pressures
            };
            let push = pair * weight;
            let mut closing = f64x4::ZERO;
            for c in 0..D {
                sums.push[c] += push * apart[c];
                closing += (velocity[c] - four_values(&near.velocity[c], first)) * apart[c];
            }
            let approaching = inside & closing.simd_lt(f64x4::ZERO);
            if approaching.any() {
                let strength =
                    viscosity.over_kernel(closing, square, mean, four_values(&near.depth, first), heights);
                let strength = approaching & (strength * weight);
                for c in 0..D {
                    sums.viscous[c] -= strength * apart[c];
                }
            }
            if GRADIENTS {
                sums.add_slopes(near, first, inside & (weight / heights), &here, &apart);
            }
        });
        sums.sums()
    }
}

/// `(∂W/∂r)/r` of four neighbours, from the squares of their distances and their mean smoothing lengths.
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

/// Artificial viscosity of a node against four neighbours.
struct ArtificialViscosity {
    linear: f64x4,
    quadratic: f64x4,
    half_effective_gravity: f64x4,
    depth: f64x4,
    height: f64x4,
}

impl ArtificialViscosity {
    fn of((linear, quadratic): (f64, f64), pull: f64, depth: f64, height: f64) -> Self {
        Self {
            linear: f64x4::splat(linear),
            quadratic: f64x4::splat(quadratic),
            half_effective_gravity: f64x4::splat(0.5 * pull),
            depth: f64x4::splat(depth),
            height: f64x4::splat(height),
        }
    }

    /// `Π` (m/s² over `m ∇W`) of approaching neighbours: `closing` is the scalar product of relative velocity and relative position.
    #[inline(always)]
    fn over_kernel(
        &self,
        closing: f64x4,
        square: f64x4,
        mean: f64x4,
        depths: f64x4,
        heights: f64x4,
    ) -> f64x4 {
        let soft = square + mean * mean * SOFTENING;
        let both = self.height + heights;
        let inverse = f64x4::ONE / (soft * both);
        let rate = mean * closing * both * inverse;
        let celerity = (self.half_effective_gravity * (self.depth + depths)).sqrt();
        (self.quadratic * rate - self.linear * celerity) * rate * soft * inverse * 2.0
    }
}

/// Fields whose gradients are computed; those that a problem does not have are zero.
#[inline]
fn gradient_fields<const D: usize>(seen: &NeighbourData<D>, i: usize) -> [f64; FIELDS] {
    let of = |column: &[f64]| column.get(i).copied().unwrap_or(0.0);
    [seen.height[i], of(&seen.partner), of(&seen.porosity), of(&seen.excess), of(&seen.level)]
}

impl<const D: usize> PhaseSet<D> {
    /// Step 4: accelerations of the nodes without drag and the resistance of the bed. `weak(i)` is whether drag is weak
    /// at a node, `other` is the other set of two layers.
    pub fn accelerate(
        &mut self,
        settings: &FlowSettings<D>,
        role: PhaseRole,
        weak: impl Fn(usize) -> bool + Sync,
        other: Option<&NeighbourData<D>>,
    ) {
        let form = settings.numerics.momentum;
        let plain = settings.phases != Phases::Two
            && form != PressureForceForm::Node
            && !settings.numerics.surface_gradient;
        self.gather_force_data(settings.numerics.kernel.support(), !plain);
        let Self {
            nodes,
            neighbour_data: seen,
            cell_sorted: packed,
            max_smoothing_length: around,
            packed_neighbours: fours,
            bed,
            reaction,
            other_phase_neighbours: across,
            acceleration,
            viscous,
            ..
        } = self;
        acceleration.resize(nodes.len(), [0.0; D]);
        viscous.resize(nodes.len(), [0.0; D]);
        let pairs = PairForces {
            settings,
            nodes,
            neighbour_data: seen,
            cell_sorted: packed,
            max_smoothing_length: around,
            packed_neighbours: fours,
            bed,
            reaction,
            across,
        };
        let columns = acceleration.par_iter_mut().zip(viscous).enumerate();
        columns.with_min_len(TASK).for_each_init(Vec::new, |spare, (i, (a, viscous))| {
            let (sums, mut force) = if plain {
                let sums = if form == PressureForceForm::Variational {
                    pairs.variational(i)
                } else {
                    pairs.sums::<false>(i, spare)
                };
                let pull = pairs.nodes.effective_gravity[i];
                let force = sums.pressure_gradient.map(|push| -pull * push);
                (sums, force)
            } else {
                let sums = pairs.sums::<true>(i, spare);
                let by_differences = match form {
                    PressureForceForm::Node => true,
                    PressureForceForm::Automatic => settings.phases == Phases::Two && weak(i),
                    PressureForceForm::Symmetric
                    | PressureForceForm::Product
                    | PressureForceForm::Variational => false,
                };
                let force = pairs.pressure_force(
                    role,
                    i,
                    &sums,
                    by_differences || settings.numerics.surface_gradient,
                );
                (sums, force)
            };
            let mut gradient = pairs.depth_gradient(i, &sums, plain);
            if let Some(other) = other {
                pairs.add_layer(role, i, other, &mut force, &mut gradient);
            }
            let share = pairs.slope_reduction(i, &gradient);
            *viscous = pairs.along_bed(i, &sums.viscous, share);
            *a = pairs.with_bed(i, &pairs.along_bed(i, &force, share), viscous);
        });
    }
}

impl<const D: usize> PairForces<'_, D> {
    /// Pressure force of node `i` of two phases, or by differences (m/s²).
    fn pressure_force(
        &self,
        role: PhaseRole,
        i: usize,
        sums: &ForceSums<D>,
        by_differences: bool,
    ) -> PlanVector<D> {
        let (seen, settings) = (self.neighbour_data, self.settings);
        let pull = self.nodes.effective_gravity[i];
        let [height, partner, porosity, excess, _] = gradient_fields(seen, i);
        let slopes = sums.field_gradients.map(|slope| corrected(&sums.moment, &slope));
        let [height_slope, partner_slope, porosity_slope, excess_slope, level_slope] = slopes;
        let densities = &settings.material.densities;
        let ratio = densities.fluid / densities.grain;
        let depth = seen.depth[i];
        std::array::from_fn(|c| {
            let own = match (role, by_differences) {
                (PhaseRole::Solid, true) => {
                    let buoyant = 0.5 * (1.0 - ratio) * partner / height * height_slope[c];
                    let weight = height_slope[c] + 0.5 * (1.0 + ratio) * partner_slope[c] + buoyant;
                    porosity / (densities.grain * height) * excess_slope[c] - weight
                }
                (PhaseRole::Fluid, true) => {
                    -(height_slope[c] + partner_slope[c]) - excess_slope[c] / (densities.fluid * depth)
                }
                (_, true) => -height_slope[c],
                (PhaseRole::Solid, false) => {
                    let force = 0.5 * ratio * depth * depth + excess / densities.grain;
                    -sums.pressure_gradient[c] - force / height * porosity_slope[c]
                }
                (PhaseRole::Fluid, false) => {
                    let force = 0.5 * depth * depth + excess / densities.fluid;
                    force / height * porosity_slope[c] - sums.pressure_gradient[c]
                }
                (_, false) => -sums.pressure_gradient[c],
            };
            // For the gradient of the free surface, the slope of the bed by differences of the neighbours, in place of its own.
            let level = if settings.numerics.surface_gradient { level_slope[c] } else { 0.0 };
            pull * (own - level)
        })
    }

    /// Adds the weight of the other layer to a force (m/s²), and its depth to the gradient (sheet: depth-sph §2.11).
    fn add_layer(
        &self,
        role: PhaseRole,
        i: usize,
        other: &NeighbourData<D>,
        force: &mut PlanVector<D>,
        gradient: &mut PlanVector<D>,
    ) {
        let densities = &self.settings.material.densities;
        let factor = if role == PhaseRole::Lower { densities.fluid / densities.grain } else { 1.0 };
        let kernel = self.settings.numerics.kernel;
        let seen = self.neighbour_data;
        let (x, length) = (&seen.position[i], seen.length[i]);
        for &j in self.across.neighbours(i) {
            let j = j as usize;
            let apart: PlanVector<D> = std::array::from_fn(|c| x[c] - other.position[j][c]);
            let distance = dot(&apart, &apart).sqrt();
            if distance >= kernel.support() * length {
                continue;
            }
            let weight = other.volume[j] * kernel.gradient::<D>(distance, length);
            for c in 0..D {
                force[c] -= factor * self.nodes.effective_gravity[i] * weight * apart[c];
                gradient[c] += weight * apart[c];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::settings::Mixture;
    use crate::phases::interphase_drag::MixtureDensities;
    use crate::phases::phase_nodes::NewNode;

    /// V20: both forms of the pressure force agree for any heights and excess pressure, and their sum is that of the mixture.
    #[test]
    fn node_form_and_symmetric_form_are_one() {
        let densities = MixtureDensities { grain: 2650.0, fluid: 1000.0, gravity: 9.81 };
        let mut settings = FlowSettings::<1>::plain(1000.0);
        settings.phases = Phases::Two;
        settings.material = Mixture { densities, porosity: 0.4, saturated: true };
        let (rho_s, rho_w, pull) = (densities.grain, densities.fluid, 9.81);
        // Heights of grains and fluid and depth times excess pressure over gravity, each with its slope.
        let states = [
            ([0.6, 0.4, 900.0], [0.3, -0.2, 150.0]),
            ([1.7, 0.2, -40.0], [-0.8, 0.5, 700.0]),
            ([0.05, 2.0, 0.0], [0.0, 0.01, 0.0]),
        ];
        for ([solid, fluid, excess], [solid_slope, fluid_slope, excess_slope]) in states {
            let (depth, depth_slope) = (solid + fluid, solid_slope + fluid_slope);
            let porosity = fluid / depth;
            let porosity_slope = (fluid_slope * depth - fluid * depth_slope) / (depth * depth);
            let share_slope = porosity_slope * excess + porosity * excess_slope;
            let slopes_of = |own: f64, other: f64| [[own], [other], [porosity_slope], [excess_slope], [0.0]];
            let force = |role: PhaseRole, by_differences: bool| {
                let [own, partner] = if role == PhaseRole::Solid { [solid, fluid] } else { [fluid, solid] };
                let mut set = PhaseSet::<1>::default();
                set.nodes.push(
                    0,
                    &NewNode {
                        body: 0,
                        position: [0.0],
                        velocity: [0.0],
                        volume: own,
                        length: 1.0,
                        scale: 1.0,
                    },
                );
                set.nodes.effective_gravity[0] = pull;
                set.neighbour_data.height = vec![own];
                set.neighbour_data.partner = vec![partner];
                set.neighbour_data.porosity = vec![porosity];
                set.neighbour_data.excess = vec![excess];
                set.neighbour_data.depth = vec![depth];
                let weight = |own: f64, slope: f64| 0.5 * (slope * depth + own * depth_slope);
                let (push, slopes) = if role == PhaseRole::Solid {
                    let pressure = weight(solid, solid_slope) - share_slope / rho_s;
                    (pressure / solid, slopes_of(solid_slope, fluid_slope))
                } else {
                    let pressure = weight(fluid, fluid_slope) + share_slope / rho_w;
                    (pressure / fluid, slopes_of(fluid_slope, solid_slope))
                };
                let sums = ForceSums {
                    pressure_gradient: [push],
                    viscous: [0.0],
                    field_gradients: slopes,
                    moment: [[1.0]],
                };
                let PhaseSet {
                    nodes,
                    neighbour_data: seen,
                    cell_sorted: packed,
                    max_smoothing_length: around,
                    packed_neighbours: fours,
                    bed,
                    reaction,
                    other_phase_neighbours: across,
                    ..
                } = &set;
                let settings = &settings;
                let pairs = PairForces {
                    settings,
                    nodes,
                    neighbour_data: seen,
                    cell_sorted: packed,
                    max_smoothing_length: around,
                    packed_neighbours: fours,
                    bed,
                    reaction,
                    across,
                };
                pairs.pressure_force(role, 0, &sums, by_differences)[0]
            };
            let near = |a: f64, b: f64, size: f64| assert!((a - b).abs() < 1e-10 * size, "{a} {b}");
            let [of_solid, of_fluid] = [PhaseRole::Solid, PhaseRole::Fluid].map(|role| force(role, true));
            near(of_solid, force(PhaseRole::Solid, false), pull);
            near(of_fluid, force(PhaseRole::Fluid, false), pull);
            let sum = rho_s * solid * of_solid + rho_w * fluid * of_fluid;
            let mass = rho_s * solid + rho_w * fluid;
            let mass_slope = rho_s * solid_slope + rho_w * fluid_slope;
            near(sum, -0.5 * pull * (mass_slope * depth + mass * depth_slope), mass * pull);
        }
    }
}
