//! Step 4: accelerations of a set by pressure, artificial viscosity, gradients of porosity and the reaction of the bed (sheet: depth-sph
//! §2.5, §2.9 to §2.11).

use rayon::prelude::*;

use crate::config::choices::{Phases, PressureForceForm};
use crate::config::settings::{FlowSettings, PhaseRole};
use crate::momentum::force_sums::{ForceSums, gradient_fields, solve_or_copy};
use crate::momentum::pair_forces::PairForces;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::{NeighbourData, PlanVector, dot};

/// Whether forces follow from pressures alone, without gradients of fields.
fn is_plain<const D: usize>(settings: &FlowSettings<D>) -> bool {
    settings.phases != Phases::Two
        && settings.numerics.momentum != PressureForceForm::Node
        && !settings.numerics.surface_gradient
}

impl<const D: usize> PhaseSet<D> {
    /// Step 4: accelerations of the nodes of a set without drag and bed resistance. `weak(i)` is true
    /// where drag is weak at node `i`; `other` is the other set of a two-layer flow.
    pub fn accelerate(
        &mut self,
        settings: &FlowSettings<D>,
        role: PhaseRole,
        weak: impl Fn(usize) -> bool + Sync,
        other: Option<&NeighbourData<D>>,
    ) {
        let plain = is_plain(settings);
        self.gather_force_data(settings.numerics.kernel.support(), !plain);
        let mut acceleration = std::mem::take(&mut self.acceleration);
        let mut viscous = std::mem::take(&mut self.viscous);
        let mut relative_speed = std::mem::take(&mut self.nodes.relative_speed);
        let mut path_curvature = std::mem::take(&mut self.nodes.path_curvature);
        acceleration.resize(self.nodes.len(), [0.0; D]);
        viscous.resize(self.nodes.len(), [0.0; D]);
        let pairs = PairForces::for_set(settings, self);
        let columns = acceleration.par_iter_mut().zip(&mut viscous);
        let columns = columns.zip(&mut relative_speed).zip(&mut path_curvature).enumerate();
        let columns = columns.with_min_len(MIN_NODES_PER_TASK);
        columns.for_each_init(Vec::new, |spare, (i, (((a, viscous), relative), path))| {
            let (sums, mut force) = pairs.sums_and_pressure(role, i, plain, &weak, spare);
            *relative = sums.relative_speed;
            *path = pairs.bed[i].path_curvature(&pairs.nodes.velocity[i]);
            let mut gradient = pairs.depth_gradient(i, &sums, plain);
            if let Some(other) = other {
                pairs.add_layer(role, i, other, &mut force, &mut gradient);
            }
            let share = pairs.slope_reduction(i, &gradient);
            *viscous = pairs.along_bed(i, &sums.viscous, share);
            *a = pairs.with_bed(i, &pairs.along_bed(i, &force, share), viscous);
        });
        (self.acceleration, self.viscous) = (acceleration, viscous);
        (self.nodes.relative_speed, self.nodes.path_curvature) = (relative_speed, path_curvature);
    }
}

impl<const D: usize> PairForces<'_, D> {
    /// Force sums over the neighbours of node `i` and its pressure force (m/s²); `plain` is [`is_plain`].
    #[inline]
    fn sums_and_pressure(
        &self,
        role: PhaseRole,
        i: usize,
        plain: bool,
        weak: impl Fn(usize) -> bool,
        spare: &mut Vec<u32>,
    ) -> (ForceSums<D>, PlanVector<D>) {
        let settings = self.settings;
        let form = settings.numerics.momentum;
        if plain {
            let sums = if form == PressureForceForm::Variational {
                self.variational_sums(i)
            } else {
                self.sums::<false>(i, spare)
            };
            let gravity = self.nodes.effective_gravity[i];
            let force = sums.pressure_gradient.map(|gradient| -gravity * gradient);
            return (sums, force);
        }
        let sums = self.sums::<true>(i, spare);
        let by_differences = match form {
            PressureForceForm::Node => true,
            PressureForceForm::Automatic => settings.phases == Phases::Two && weak(i),
            PressureForceForm::Symmetric | PressureForceForm::Product | PressureForceForm::Variational => {
                false
            }
        };
        let by_differences = by_differences || settings.numerics.surface_gradient;
        let force = self.pressure_force(role, i, &sums, by_differences);
        (sums, force)
    }

    /// Pressure force of node `i` of two phases, or by differences (m/s²).
    fn pressure_force(
        &self,
        role: PhaseRole,
        i: usize,
        sums: &ForceSums<D>,
        by_differences: bool,
    ) -> PlanVector<D> {
        let (data, settings) = (self.neighbour_data, self.settings);
        let gravity = self.nodes.effective_gravity[i];
        let [height, partner, porosity, excess, _] = gradient_fields(data, i);
        let slopes = sums.field_gradients.map(|slope| solve_or_copy(&sums.moment, &slope));
        let [height_slope, partner_slope, porosity_slope, excess_slope, level_slope] = slopes;
        let densities = &settings.material.densities;
        let ratio = densities.fluid / densities.grain;
        let depth = data.depth[i];
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
            gravity * (own - level)
        })
    }

    /// Adds the weight of the other layer to the force (m/s²), and its depth to the gradient (sheet: depth-sph §2.11).
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
        let data = self.neighbour_data;
        let (x, length) = (&data.position[i], data.length[i]);
        for &j in self.other_phase_neighbours.neighbours(i) {
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
    use crate::laws::interphase_drag::MixtureDensities;
    use crate::points::phase_nodes::NewNode;

    const DENSITIES: MixtureDensities = MixtureDensities { grain: 2650.0, fluid: 1000.0, gravity: 9.81 };
    const GRAVITY: f64 = 9.81;

    /// Heights of grains and fluid and depth times excess pressure over gravity, and their slopes.
    type State = ([f64; 3], [f64; 3]);

    /// Depth, its slope, porosity, and its slope.
    fn depth_and_porosity(([solid, fluid, _], [solid_slope, fluid_slope, _]): State) -> [f64; 4] {
        let (depth, depth_slope) = (solid + fluid, solid_slope + fluid_slope);
        let porosity = fluid / depth;
        let porosity_slope = (fluid_slope * depth - fluid * depth_slope) / (depth * depth);
        [depth, depth_slope, porosity, porosity_slope]
    }

    /// A node of one phase in this state.
    fn node_of(role: PhaseRole, state: State) -> PhaseSet<1> {
        let ([solid, fluid, excess], _) = state;
        let [depth, _, porosity, _] = depth_and_porosity(state);
        let [own, partner] = if role == PhaseRole::Solid { [solid, fluid] } else { [fluid, solid] };
        let mut set = PhaseSet::<1>::default();
        set.nodes.push(
            0,
            &NewNode { body: 0, position: [0.0], velocity: [0.0], volume: own, length: 1.0, scale: 1.0 },
        );
        set.nodes.effective_gravity[0] = GRAVITY;
        set.neighbour_data.height = vec![own];
        set.neighbour_data.partner_height = vec![partner];
        set.neighbour_data.porosity = vec![porosity];
        set.neighbour_data.excess = vec![excess];
        set.neighbour_data.depth = vec![depth];
        set
    }

    /// Sums over the neighbours of such a node.
    fn sums_of(role: PhaseRole, state: State) -> ForceSums<1> {
        let ([solid, fluid, excess], [solid_slope, fluid_slope, excess_slope]) = state;
        let [depth, depth_slope, porosity, porosity_slope] = depth_and_porosity(state);
        let share_slope = porosity_slope * excess + porosity * excess_slope;
        let slopes_of = |own: f64, other: f64| [[own], [other], [porosity_slope], [excess_slope], [0.0]];
        let weight = |own: f64, slope: f64| 0.5 * (slope * depth + own * depth_slope);
        let (push, slopes) = if role == PhaseRole::Solid {
            let pressure = weight(solid, solid_slope) - share_slope / DENSITIES.grain;
            (pressure / solid, slopes_of(solid_slope, fluid_slope))
        } else {
            let pressure = weight(fluid, fluid_slope) + share_slope / DENSITIES.fluid;
            (pressure / fluid, slopes_of(fluid_slope, solid_slope))
        };
        ForceSums {
            pressure_gradient: [push],
            viscous: [0.0],
            field_gradients: slopes,
            moment: [[1.0]],
            relative_speed: 0.0,
        }
    }

    /// V20: both forms of the pressure force agree for any heights and excess pressure, and their sum is that of the mixture.
    #[test]
    fn node_form_and_symmetric_form_are_one() {
        let mut settings = FlowSettings::<1>::single_phase(1000.0);
        settings.phases = Phases::Two;
        settings.material = Mixture { densities: DENSITIES, porosity: 0.4, is_saturated: true };
        let (rho_s, rho_w, gravity) = (DENSITIES.grain, DENSITIES.fluid, GRAVITY);
        let states = [
            ([0.6, 0.4, 900.0], [0.3, -0.2, 150.0]),
            ([1.7, 0.2, -40.0], [-0.8, 0.5, 700.0]),
            ([0.05, 2.0, 0.0], [0.0, 0.01, 0.0]),
        ];
        for state in states {
            let ([solid, fluid, _], [solid_slope, fluid_slope, _]) = state;
            let [depth, depth_slope, ..] = depth_and_porosity(state);
            let force = |role: PhaseRole, by_differences: bool| {
                let set = node_of(role, state);
                let pairs = PairForces::for_set(&settings, &set);
                pairs.pressure_force(role, 0, &sums_of(role, state), by_differences)[0]
            };
            let near = |a: f64, b: f64, size: f64| assert!((a - b).abs() < 1e-10 * size, "{a} {b}");
            let [of_solid, of_fluid] = [PhaseRole::Solid, PhaseRole::Fluid].map(|role| force(role, true));
            near(of_solid, force(PhaseRole::Solid, false), gravity);
            near(of_fluid, force(PhaseRole::Fluid, false), gravity);
            let sum = rho_s * solid * of_solid + rho_w * fluid * of_fluid;
            let mass = rho_s * solid + rho_w * fluid;
            let mass_slope = rho_s * solid_slope + rho_w * fluid_slope;
            near(sum, -0.5 * gravity * (mass_slope * depth + mass * depth_slope), mass * gravity);
        }
    }
}
