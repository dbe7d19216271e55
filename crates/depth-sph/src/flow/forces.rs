//! Pressure, artificial viscosity, gradients of porosity and the reaction of the bed (sheet: depth-sph §2.5, §2.9, §2.10).

use colluvium_points::NeighbourList;
use rayon::prelude::*;
use wide::f64x4;

use super::fours::{self, Fours};
use super::longest::Longest;
use super::packed::{FIELDS, Packed, four, whole};
use super::set::{Set, TASK};
use crate::bed::BedPoint;
use crate::choices::{Momentum, Phases};
use crate::kernel::Kernel;
use crate::nodes::{Nodes, Plan, Seen, dot};
use crate::settings::Settings;

/// Below this determinant the correction of gradients is left out (sheet: depth-sph §2.10).
const ILL_CONDITIONED: f64 = 1e-3;
/// Keeps the viscosity finite for nodes that meet, in squares of the smoothing length.
const SOFTENING: f64 = 0.01;

/// Which phase a set is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The only one.
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
pub(super) struct Sums<const D: usize> {
    /// `Σ m (p_I + p_J) ∇W`, the pressure force over `-g_*`.
    pub(super) push: Plan<D>,
    /// `-Σ m Π ∇W` (m/s²).
    pub(super) viscous: Plan<D>,
    /// `Σ (m/h) (f_J - f_I) ∇W` of the fields.
    pub(super) slopes: [Plan<D>; FIELDS],
    /// `Σ (m/h) (x_J - x_I) ⊗ ∇W`.
    pub(super) moment: [Plan<D>; D],
}

/// `A⁻¹ b` in one or two dimensions; `b` where `A` is ill-conditioned.
pub fn corrected<const D: usize>(matrix: &[Plan<D>; D], vector: &Plan<D>) -> Plan<D> {
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

/// The sums of the forces between the nodes of one set: what they read of it.
pub(super) struct Pairs<'a, const D: usize> {
    pub(super) settings: &'a Settings<D>,
    pub(super) nodes: &'a Nodes<D>,
    pub(super) seen: &'a Seen<D>,
    pub(super) packed: &'a Packed<D>,
    pub(super) around: &'a Longest<D>,
    pub(super) fours: &'a Fours,
    pub(super) bed: &'a [BedPoint<D>],
    pub(super) reaction: &'a [f64],
    pub(super) across: &'a NeighbourList<D>,
}

/// Sums as lanes of four neighbours.
struct Lanes<const D: usize> {
    push: [f64x4; D],
    viscous: [f64x4; D],
    slopes: [[f64x4; D]; FIELDS],
    moment: [[f64x4; D]; D],
}

impl<const D: usize> Lanes<D> {
    const NONE: Self = Self {
        push: [f64x4::ZERO; D],
        viscous: [f64x4::ZERO; D],
        slopes: [[f64x4::ZERO; D]; FIELDS],
        moment: [[f64x4::ZERO; D]; D],
    };

    /// Adds the shares of four neighbours, `-(m/h) W'/r`, in the slopes of the fields, which are `here` at the node.
    #[inline(always)]
    fn add_slopes(
        &mut self,
        near: &Packed<D>,
        first: usize,
        share: f64x4,
        here: &[f64x4; FIELDS],
        apart: &[f64x4; D],
    ) {
        for (f, slope) in self.slopes.iter_mut().enumerate() {
            let column = if f == 0 { &near.height } else { &near.fields[f] };
            let change = share * (four(column, first) - here[f]);
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
    fn sums(self) -> Sums<D> {
        Sums {
            push: self.push.map(whole),
            viscous: self.viscous.map(whole),
            slopes: self.slopes.map(|slope| slope.map(whole)),
            moment: self.moment.map(|row| row.map(whole)),
        }
    }
}

impl<const D: usize> Pairs<'_, D> {
    /// Sums over the neighbours of node `i` with the smoothing length of each for its pressure (sheet: depth-sph §3.4).
    #[inline]
    fn variational(&self, i: usize) -> Sums<D> {
        let numerics = &self.settings.numerics;
        let kernel = numerics.kernel;
        let support = kernel.support();
        let (nodes, seen, near) = (self.nodes, self.seen, self.packed);
        let (x, length) = (&nodes.position[i], nodes.length[i]);
        let viscosity = Viscosity::of(numerics.viscosity, nodes.pull[i], nodes.depth[i], nodes.height[i]);
        let factor = f64x4::splat(kernel.factor::<D>());
        let mut sums = Lanes::NONE;
        near.around(x, support * self.around.at(x).max(length), |first, apart, square| {
            let (own, theirs) = (f64x4::splat(length), four(&near.length, first));
            let volumes = four(&near.volume, first);
            let weigh = |length: f64x4| {
                let reach = length * support;
                square.simd_lt(reach * reach) & (slopes::<D>(kernel, factor, square, length) * volumes)
            };
            let (here, there) = (weigh(own), weigh(theirs));
            let push = here * seen.pressure[i] + there * four(&near.pressure, first);
            let mut closing = f64x4::ZERO;
            for c in 0..D {
                sums.push[c] += push * apart[c];
                closing += (f64x4::splat(nodes.velocity[i][c]) - four(&near.velocity[c], first)) * apart[c];
            }
            let approaching = closing.simd_lt(f64x4::ZERO) & (here + there).simd_ne(f64x4::ZERO);
            if approaching.any() {
                let (mean, heights) = ((own + theirs) * 0.5, four(&near.height, first));
                let strength =
                    viscosity.over_kernel(closing, square, mean, four(&near.depth, first), heights);
                let strength = approaching & (strength * (here + there) * 0.5);
                for c in 0..D {
                    sums.viscous[c] -= strength * apart[c];
                }
            }
        });
        sums.sums()
    }

    /// Sums over the neighbours of node `i`; gradients only where they are asked for.
    #[inline]
    fn sums<const GRADIENTS: bool>(&self, i: usize, spare: &mut Vec<u32>) -> Sums<D> {
        let listed = self.fours.are_complete();
        if !listed {
            let (x, length, near) = (&self.nodes.position[i], self.nodes.length[i], self.packed);
            let half = 0.5 * self.settings.numerics.kernel.support();
            spare.clear();
            near.around(x, half * (length + self.around.at(x).max(length)), |first, _, square| {
                spare.push(fours::entry(first, square));
            });
        }
        let entries = if listed { self.fours.of(i) } else { spare };
        // Of the usual kernel the compiler makes a loop of its own.
        match self.settings.numerics.kernel {
            Kernel::CubicSpline => self.sums_over::<GRADIENTS, true>(i, entries),
            _ => self.sums_over::<GRADIENTS, false>(i, entries),
        }
    }

    /// The same over fours that are listed.
    #[inline]
    fn sums_over<const GRADIENTS: bool, const CUBIC: bool>(&self, i: usize, entries: &[u32]) -> Sums<D> {
        let numerics = &self.settings.numerics;
        let kernel = if CUBIC { Kernel::CubicSpline } else { numerics.kernel };
        let product = numerics.momentum == Momentum::Product;
        let half_support = 0.5 * kernel.support();
        let (nodes, seen, near) = (self.nodes, self.seen, self.packed);
        let (x, length) = (&nodes.position[i], nodes.length[i]);
        let (pressure, height) = (f64x4::splat(seen.pressure[i]), f64x4::splat(nodes.height[i]));
        let mut velocity = [f64x4::ZERO; D];
        for c in 0..D {
            velocity[c] = f64x4::splat(nodes.velocity[i][c]);
        }
        let viscosity = Viscosity::of(numerics.viscosity, nodes.pull[i], nodes.depth[i], nodes.height[i]);
        let mut here = [f64x4::ZERO; FIELDS];
        if GRADIENTS {
            here = fields(seen, i).map(f64x4::splat);
        }
        let factor = f64x4::splat(kernel.factor::<D>());
        let mut sums = Lanes::NONE;
        near.listed(x, entries, |first, apart, square| {
            let both = four(&near.length, first) + length;
            let reach = both * half_support;
            let inside = square.simd_lt(reach * reach);
            if !inside.any() {
                return;
            }
            let mean = both * 0.5;
            let weight = inside & (slopes::<D>(kernel, factor, square, mean) * four(&near.volume, first));
            let (heights, pressures) = (four(&near.height, first), four(&near.pressure, first));
            let pair = if product {
                // (P_I + P_J)/(h_I h_J) of what is given as P/h².
                inside & (pressure * height / heights + pressures * heights / height)
            } else {
                pressure + pressures
            };
            let push = pair * weight;
            let mut closing = f64x4::ZERO;
            for c in 0..D {
                sums.push[c] += push * apart[c];
                closing += (velocity[c] - four(&near.velocity[c], first)) * apart[c];
            }
            let approaching = inside & closing.simd_lt(f64x4::ZERO);
            if approaching.any() {
                let strength =
                    viscosity.over_kernel(closing, square, mean, four(&near.depth, first), heights);
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

/// `(∂W/∂r)/r` of four neighbours, of the squares of their distances and their mean smoothing lengths.
#[inline(always)]
fn slopes<const D: usize>(kernel: Kernel, factor: f64x4, square: f64x4, mean: f64x4) -> f64x4 {
    // Of a node at the same place, the node itself above all, the vector is zero.
    let distance = square.sqrt().fast_max(mean * 1e-12);
    let inverses = f64x4::ONE / (mean * distance);
    let inverse = inverses * distance;
    let two = inverse * inverse;
    let power = if D == 1 { two * inverse } else { two * two };
    factor * power * kernel.slopes::<D>(distance * inverse, mean * mean * inverses)
}

/// Artificial viscosity of a node against four neighbours.
struct Viscosity {
    linear: f64x4,
    quadratic: f64x4,
    half_pull: f64x4,
    depth: f64x4,
    height: f64x4,
}

impl Viscosity {
    fn of((linear, quadratic): (f64, f64), pull: f64, depth: f64, height: f64) -> Self {
        Self {
            linear: f64x4::splat(linear),
            quadratic: f64x4::splat(quadratic),
            half_pull: f64x4::splat(0.5 * pull),
            depth: f64x4::splat(depth),
            height: f64x4::splat(height),
        }
    }

    /// `Π` (m/s² over `m ∇W`) of neighbours that come closer: `closing` is the scalar product of velocity and place against theirs.
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
        let celerity = (self.half_pull * (self.depth + depths)).sqrt();
        (self.quadratic * rate - self.linear * celerity) * rate * soft * inverse * 2.0
    }
}

/// The fields of which gradients are taken; those that a problem does not have are zero.
#[inline]
fn fields<const D: usize>(seen: &Seen<D>, i: usize) -> [f64; FIELDS] {
    let of = |column: &[f64]| column.get(i).copied().unwrap_or(0.0);
    [seen.height[i], of(&seen.partner), of(&seen.porosity), of(&seen.excess), of(&seen.level)]
}

impl<const D: usize> Set<D> {
    /// Step 4: accelerations of the nodes but for drag and the resistance of the bed. `weak(i)` tells whether drag is weak
    /// at a node, `other` is the other set of two layers.
    pub fn accelerate(
        &mut self,
        settings: &Settings<D>,
        role: Role,
        weak: impl Fn(usize) -> bool + Sync,
        other: Option<&Seen<D>>,
    ) {
        let form = settings.numerics.momentum;
        let plain =
            settings.phases != Phases::Two && form != Momentum::Node && !settings.numerics.surface_gradient;
        self.show_forces(settings.numerics.kernel.support(), !plain);
        let Self { nodes, seen, packed, around, fours, bed, reaction, across, acceleration, viscous, .. } =
            self;
        acceleration.resize(nodes.len(), [0.0; D]);
        viscous.resize(nodes.len(), [0.0; D]);
        let pairs = Pairs { settings, nodes, seen, packed, around, fours, bed, reaction, across };
        let columns = acceleration.par_iter_mut().zip(viscous).enumerate();
        columns.with_min_len(TASK).for_each_init(Vec::new, |spare, (i, (a, viscous))| {
            let (sums, mut force) = if plain {
                let sums = if form == Momentum::Variational {
                    pairs.variational(i)
                } else {
                    pairs.sums::<false>(i, spare)
                };
                let pull = pairs.nodes.pull[i];
                let force = sums.push.map(|push| -pull * push);
                (sums, force)
            } else {
                let sums = pairs.sums::<true>(i, spare);
                let by_differences = match form {
                    Momentum::Node => true,
                    Momentum::Automatic => settings.phases == Phases::Two && weak(i),
                    Momentum::Symmetric | Momentum::Product | Momentum::Variational => false,
                };
                let force = pairs.push(role, i, &sums, by_differences || settings.numerics.surface_gradient);
                (sums, force)
            };
            let mut gradient = pairs.depth_gradient(i, &sums, plain);
            if let Some(other) = other {
                pairs.add_layer(role, i, other, &mut force, &mut gradient);
            }
            let share = pairs.damping(i, &gradient);
            *viscous = pairs.along_bed(i, &sums.viscous, share);
            *a = pairs.with_bed(i, &pairs.along_bed(i, &force, share), viscous);
        });
    }
}

impl<const D: usize> Pairs<'_, D> {
    /// Pressure force of node `i` of two phases, or by differences (m/s²).
    fn push(&self, role: Role, i: usize, sums: &Sums<D>, by_differences: bool) -> Plan<D> {
        let (seen, settings) = (self.seen, self.settings);
        let pull = self.nodes.pull[i];
        let [height, partner, porosity, excess, _] = fields(seen, i);
        let slopes = sums.slopes.map(|slope| corrected(&sums.moment, &slope));
        let [height_slope, partner_slope, porosity_slope, excess_slope, level_slope] = slopes;
        let densities = &settings.material.densities;
        let ratio = densities.fluid / densities.grain;
        let depth = seen.depth[i];
        std::array::from_fn(|c| {
            let own = match (role, by_differences) {
                (Role::Solid, true) => {
                    let buoyant = 0.5 * (1.0 - ratio) * partner / height * height_slope[c];
                    let weight = height_slope[c] + 0.5 * (1.0 + ratio) * partner_slope[c] + buoyant;
                    porosity / (densities.grain * height) * excess_slope[c] - weight
                }
                (Role::Fluid, true) => {
                    -(height_slope[c] + partner_slope[c]) - excess_slope[c] / (densities.fluid * depth)
                }
                (_, true) => -height_slope[c],
                (Role::Solid, false) => {
                    let force = 0.5 * ratio * depth * depth + excess / densities.grain;
                    -sums.push[c] - force / height * porosity_slope[c]
                }
                (Role::Fluid, false) => {
                    let force = 0.5 * depth * depth + excess / densities.fluid;
                    force / height * porosity_slope[c] - sums.push[c]
                }
                (_, false) => -sums.push[c],
            };
            // Of the free surface: the slope of the bed by the same differences, in place of its own.
            let level = if settings.numerics.surface_gradient { level_slope[c] } else { 0.0 };
            pull * (own - level)
        })
    }

    /// Adds the weight of the other layer to a force (m/s²), and its depth to the gradient (sheet: depth-sph §2.11).
    fn add_layer(&self, role: Role, i: usize, other: &Seen<D>, force: &mut Plan<D>, gradient: &mut Plan<D>) {
        let densities = &self.settings.material.densities;
        let factor = if role == Role::Lower { densities.fluid / densities.grain } else { 1.0 };
        let kernel = self.settings.numerics.kernel;
        let seen = self.seen;
        let (x, length) = (&seen.position[i], seen.length[i]);
        for &j in self.across.of(i) {
            let j = j as usize;
            let apart: Plan<D> = std::array::from_fn(|c| x[c] - other.position[j][c]);
            let distance = dot(&apart, &apart).sqrt();
            if distance >= kernel.support() * length {
                continue;
            }
            let weight = other.volume[j] * kernel.gradient::<D>(distance, length);
            for c in 0..D {
                force[c] -= factor * self.nodes.pull[i] * weight * apart[c];
                gradient[c] += weight * apart[c];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drag::Densities;
    use crate::nodes::Node;
    use crate::settings::Mixture;

    /// V20: both forms of the pressure force are the same for any heights and excess pressure, and their sum is that of the mixture.
    #[test]
    fn node_form_and_symmetric_form_are_one() {
        let densities = Densities { grain: 2650.0, fluid: 1000.0, gravity: 9.81 };
        let mut settings = Settings::<1>::plain(1000.0);
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
            let force = |role: Role, by_differences: bool| {
                let [own, partner] = if role == Role::Solid { [solid, fluid] } else { [fluid, solid] };
                let mut set = Set::<1>::default();
                set.nodes.push(
                    0,
                    &Node { body: 0, position: [0.0], velocity: [0.0], volume: own, length: 1.0, scale: 1.0 },
                );
                set.nodes.pull[0] = pull;
                set.seen.height = vec![own];
                set.seen.partner = vec![partner];
                set.seen.porosity = vec![porosity];
                set.seen.excess = vec![excess];
                set.seen.depth = vec![depth];
                let weight = |own: f64, slope: f64| 0.5 * (slope * depth + own * depth_slope);
                let (push, slopes) = if role == Role::Solid {
                    let pressure = weight(solid, solid_slope) - share_slope / rho_s;
                    (pressure / solid, slopes_of(solid_slope, fluid_slope))
                } else {
                    let pressure = weight(fluid, fluid_slope) + share_slope / rho_w;
                    (pressure / fluid, slopes_of(fluid_slope, solid_slope))
                };
                let sums = Sums { push: [push], viscous: [0.0], slopes, moment: [[1.0]] };
                let Set { nodes, seen, packed, around, fours, bed, reaction, across, .. } = &set;
                let settings = &settings;
                let pairs = Pairs { settings, nodes, seen, packed, around, fours, bed, reaction, across };
                pairs.push(role, 0, &sums, by_differences)[0]
            };
            let near = |a: f64, b: f64, size: f64| assert!((a - b).abs() < 1e-10 * size, "{a} {b}");
            let [of_solid, of_fluid] = [Role::Solid, Role::Fluid].map(|role| force(role, true));
            near(of_solid, force(Role::Solid, false), pull);
            near(of_fluid, force(Role::Fluid, false), pull);
            let sum = rho_s * solid * of_solid + rho_w * fluid * of_fluid;
            let mass = rho_s * solid + rho_w * fluid;
            let mass_slope = rho_s * solid_slope + rho_w * fluid_slope;
            near(sum, -0.5 * pull * (mass_slope * depth + mass * depth_slope), mass * pull);
        }
    }
}
