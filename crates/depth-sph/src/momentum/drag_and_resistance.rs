//! Drag between phases and resistance of the bed, which act on velocities beside the kick (sheet: depth-sph §3.4, steps 5
//! and 6, as amended).

use colluvium_constitutive::basal::BasalFlow;
use rayon::prelude::*;

use crate::bed::BedPoint;
use crate::config::choices::Phases;
use crate::config::settings::{BedZone, FlowSettings, FluidResistance};
use crate::flow_nodes::FlowNodes;
use crate::kernel::Kernel;
use crate::laws::implicit_resistance::implicit_speed;
use crate::laws::interphase_drag::relaxation_shares;
use crate::phases::limits::FlowLimits;
use crate::phases::phase::PhaseSet;
use crate::points::MIN_NODES_PER_TASK;
use crate::points::phase_nodes::{PhaseNodes, PlanVector, norm};
use crate::pore_pressure::pore_pressure_columns::PorePressureColumns;

/// Velocities before the step and their changes in the step, of each phase in the order of its cells.
type SortedVelocities = [[Vec<f64>; 4]; 2];

/// Masses per area of both phases at a node (kg/m²), and the shares of slip that drag removes in a step.
#[derive(Clone, Copy, Debug)]
struct DragCoupling {
    /// Mass per plan area of the grains and of the fluid (kg/m²).
    masses: [f64; 2],
    /// Share of the old slip that is lost, and of the slip that the forces of the step add.
    slip_shares: (f64, f64),
}

impl DragCoupling {
    /// Velocity per impulse on the grains (m²/kg).
    fn mobility(&self) -> f64 {
        let [solid, fluid] = self.masses;
        (1.0 - self.slip_shares.1 * fluid / (solid + fluid)) / solid
    }

    /// Velocity change of the other phase per impulse on the grains (m²/kg); impulses are per plan area.
    fn velocity_per_impulse(&self) -> f64 {
        self.slip_shares.1 / (self.masses[0] + self.masses[1])
    }

    /// Share of the slip by which drag changes the velocity of a phase towards the other one.
    fn slip_share(&self, role: usize) -> f64 {
        let [solid, fluid] = self.masses;
        if role == 0 { fluid / (solid + fluid) } else { -solid / (solid + fluid) }
    }
}

/// Columns on the bed, without their velocity.
struct ColumnsOnBed<'a, const D: usize> {
    settings: &'a FlowSettings<D>,
    pore_columns: &'a PorePressureColumns,
    partial_thickness: &'a [f64],
    depth: &'a [f64],
    effective_gravity: &'a [f64],
    bed: &'a [BedPoint<D>],
}

impl<'a, const D: usize> ColumnsOnBed<'a, D> {
    /// Splits a node set into its velocities, which may change, and the remaining data.
    fn split_set(
        settings: &'a FlowSettings<D>,
        pore_columns: &'a PorePressureColumns,
        set: &'a mut PhaseSet<D>,
    ) -> SplitPhase<'a, D> {
        let PhaseSet { nodes, bed, neighbour_data: data, .. } = set;
        let PhaseNodes { position, velocity, partial_thickness: height, depth, bed_gravity, .. } = nodes;
        let columns = Self {
            settings,
            pore_columns,
            partial_thickness: height,
            depth,
            effective_gravity: bed_gravity,
            bed,
        };
        SplitPhase { columns, position, porosity: &data.porosity, velocity }
    }

    /// Columns of a node set at the bed, with the pore pressure at their base.
    fn new(
        settings: &'a FlowSettings<D>,
        pore_columns: &'a PorePressureColumns,
        set: &'a PhaseSet<D>,
    ) -> Self {
        let PhaseNodes { partial_thickness: height, depth, bed_gravity, .. } = &set.nodes;
        Self {
            settings,
            pore_columns,
            partial_thickness: height,
            depth,
            effective_gravity: bed_gravity,
            bed: &set.bed,
        }
    }

    /// Basal flow of a column for the law of the bed, at the speed along the bed.
    fn basal(&self, i: usize, velocity: &PlanVector<D>, porosity: f64) -> BasalFlow {
        let settings = self.settings;
        // The base of a layer carries the layer's own weight; water above it is also in its pores.
        let depth = if settings.phases == Phases::Layers { self.partial_thickness[i] } else { self.depth[i] };
        let material = &settings.material;
        let densities = &material.densities;
        let (bed, bearing) = (&self.bed[i], self.effective_gravity[i]);
        let density = densities.mixture(porosity);
        let pore_pressure = if material.is_saturated {
            let excess = densities.submerged_density(porosity) * self.pore_columns.base_head(i);
            bearing * (densities.fluid * depth + excess)
        } else {
            0.0
        };
        BasalFlow {
            depth: depth / bed.steepness().sqrt(),
            speed: bed.speed(velocity),
            normal_stress: density * bearing * depth,
            pore_pressure,
            slope: 0.0,
            unit_weight: density * settings.total_gravity(),
        }
    }
}

/// Nodes of a set without their velocities.
struct SplitPhase<'a, const D: usize> {
    columns: ColumnsOnBed<'a, D>,
    position: &'a [PlanVector<D>],
    porosity: &'a [f64],
    velocity: &'a mut [PlanVector<D>],
}

/// Scales a velocity in plan so that its speed along the bed changes from `before` to `after` (m/s).
fn scale_speed<const D: usize>(velocity: &mut PlanVector<D>, before: f64, after: f64) {
    if before > 0.0 {
        let factor = after / before;
        velocity.iter_mut().for_each(|v| *v *= factor);
    }
}

/// Step 6 of a single phase: all of the resistance, implicit.
pub(super) fn apply_resistance_single<const D: usize>(
    settings: &FlowSettings<D>,
    nodes: &mut FlowNodes<D>,
    dt: f64,
) {
    let FlowNodes { sets, pore_columns, .. } = nodes;
    let SplitPhase { columns, position, velocity, .. } =
        ColumnsOnBed::split_set(settings, pore_columns, &mut sets[0]);
    let porosity = settings.material.porosity;
    let along = settings.numerics.friction_along_x;
    velocity.par_iter_mut().enumerate().with_min_len(MIN_NODES_PER_TASK).for_each(|(i, v)| {
        let Some(law) = &settings.zone(&position[i]).law else { return };
        let basal = columns.basal(i, v, porosity);
        let per_stress = dt / (settings.material.density() * basal.depth);
        if along {
            v[0] -= per_stress * law.static_shear_strength(&basal);
            return;
        }
        let after = law.speed_after_step(&basal, per_stress);
        scale_speed(v, basal.speed, after);
    });
}

/// Steps 5 and 6 of two phases: drag and resistance.
pub(super) fn apply_drag_and_resistance<const D: usize>(
    settings: &FlowSettings<D>,
    limits: &FlowLimits,
    nodes: &mut FlowNodes<D>,
    dt: f64,
) {
    let FlowNodes { sets, pore_columns, .. } = nodes;
    let velocities = sorted_velocities(sets);
    let couplings: Vec<Vec<Option<DragCoupling>>> =
        (0..2).map(|role| drag_couplings(settings, limits, sets, role, dt, &velocities)).collect();
    relax_slip(settings, sets, &couplings, SlipSelection::Total, &velocities);
    let impulses = apply_yield_resistance(settings, pore_columns, &mut sets[0], &couplings[0], dt);
    pass_impulses(settings.numerics.kernel, sets, &couplings[1], &impulses);
    // The part of the resistance that grows with the speed, for each phase by itself; the slip that it adds relaxes.
    for set in &mut *sets {
        set.start_velocity.clone_from(&set.nodes.velocity);
    }
    apply_rate_resistance(settings, pore_columns, &mut sets[0], 0, dt);
    apply_rate_resistance(settings, pore_columns, &mut sets[1], 1, dt);
    let velocities = sorted_velocities(sets);
    relax_slip(settings, sets, &couplings, SlipSelection::Increment, &velocities);
}

/// Masses and slip shares at the nodes of a phase; `None` for nodes without the other phase.
fn drag_couplings<const D: usize>(
    settings: &FlowSettings<D>,
    limits: &FlowLimits,
    sets: &[PhaseSet<D>],
    role: usize,
    dt: f64,
    velocities: &SortedVelocities,
) -> Vec<Option<DragCoupling>> {
    let set = &sets[role];
    let (kernel, densities) = (settings.numerics.kernel, &settings.material.densities);
    let coupling = |i: usize| {
        let (own, partner) = (set.nodes.partial_thickness[i], set.neighbour_data.partner_height[i]);
        if own < limits.min_partner_depth || partner < limits.min_partner_depth {
            return None;
        }
        let [solid, fluid] = if role == 0 { [own, partner] } else { [partner, own] };
        let porosity = fluid / (solid + fluid);
        let slip = if settings.drag.depends_on_slip() {
            slip_velocity(kernel, sets, role, i, velocities)
        } else {
            None
        };
        let slip = slip.map_or(0.0, |slip| norm(&slip[0]));
        let beta = settings.drag.relaxation(porosity, slip, densities);
        let masses = [densities.grain * solid, densities.fluid * fluid];
        Some(DragCoupling { masses, slip_shares: relaxation_shares(beta * dt) })
    };
    (0..set.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).map(coupling).collect::<Vec<_>>()
}

/// Velocities before the step and their changes in the step, of each phase in the order of its cells. The second axis of one dimension
/// stays zero.
fn sorted_velocities<const D: usize>(sets: &[PhaseSet<D>]) -> SortedVelocities {
    [0, 1].map(|role| {
        let set = &sets[role];
        set.cell_sorted.sorted_values(|j| {
            let number = set.number(j);
            let (old, new) = (set.start_velocity[number], set.nodes.velocity[number]);
            let added: PlanVector<D> = std::array::from_fn(|c| new[c] - old[c]);
            let image = j.checked_sub(set.len()).map(|image| &set.images[image]);
            let [old, added] = [old, added].map(|v| image.map_or(v, |image| image.transform_vector(&v)));
            std::array::from_fn(|c| match c % 2 {
                axis if axis >= D => 0.0,
                axis if c < 2 => old[axis],
                axis => added[axis],
            })
        })
    })
}

/// Slip velocity at a node: before the step, and the change by the step (m/s). Both phases are averaged at one position with one kernel.
fn slip_velocity<const D: usize>(
    kernel: Kernel,
    sets: &[PhaseSet<D>],
    role: usize,
    i: usize,
    velocities: &SortedVelocities,
) -> Option<[PlanVector<D>; 2]> {
    let nodes = &sets[role].nodes;
    let mean = |set: usize| {
        sets[set].cell_sorted.mean(kernel, &nodes.position[i], nodes.length[i], &velocities[set])
    };
    let (mine, theirs) = (mean(role)?, mean(1 - role)?);
    let sign = if role == 0 { 1.0 } else { -1.0 };
    Some([0, 2].map(|first| std::array::from_fn(|c| sign * (theirs[first + c] - mine[first + c]))))
}

/// Step 5: relaxation of the slip by drag, either of the total slip or of its change in the step.
fn relax_slip<const D: usize>(
    settings: &FlowSettings<D>,
    sets: &mut [PhaseSet<D>],
    couplings: &[Vec<Option<DragCoupling>>],
    which: SlipSelection,
    velocities: &SortedVelocities,
) {
    let kernel = settings.numerics.kernel;
    let changes: Vec<Vec<PlanVector<D>>> = (0..2)
        .map(|role| {
            let change = |i: usize| {
                let Some(coupling) = &couplings[role][i] else { return [0.0; D] };
                let (old, new) = coupling.slip_shares;
                let Some([before, added]) = slip_velocity(kernel, sets, role, i, velocities) else {
                    return [0.0; D];
                };
                let part = coupling.slip_share(role);
                let old = if which == SlipSelection::Total { old } else { 0.0 };
                std::array::from_fn(|c| part * (old * before[c] + new * added[c]))
            };
            (0..sets[role].len())
                .into_par_iter()
                .with_min_len(MIN_NODES_PER_TASK)
                .map(change)
                .collect::<Vec<_>>()
        })
        .collect();
    for (set, changes) in sets.iter_mut().zip(&changes) {
        for (v, change) in set.nodes.velocity.iter_mut().zip(changes) {
            for c in 0..D {
                v[c] += change[c];
            }
        }
    }
}

/// Step 6: yield part of the bed resistance on the grains, with a mobility that includes the drag. Returns impulses per plan area.
fn apply_yield_resistance<const D: usize>(
    settings: &FlowSettings<D>,
    pore_columns: &PorePressureColumns,
    solid: &mut PhaseSet<D>,
    couplings: &[Option<DragCoupling>],
    dt: f64,
) -> Vec<PlanVector<D>> {
    let set = &*solid;
    let above = ColumnsOnBed::new(settings, pore_columns, set);
    let densities = &settings.material.densities;
    let impulse = |i: usize| {
        let v = set.nodes.velocity[i];
        let Some(law) = &settings.zone(&set.nodes.position[i]).law else { return ([0.0; D], v) };
        let porosity = set.neighbour_data.porosity[i];
        let basal = above.basal(i, &v, porosity);
        let speed = norm(&v);
        if speed == 0.0 {
            return ([0.0; D], v);
        }
        let mobility = couplings[i]
            .map_or(1.0 / (densities.grain * set.nodes.partial_thickness[i]), |coupling| coupling.mobility());
        let cosine = 1.0 / set.bed[i].steepness().sqrt();
        let share = if basal.speed > 0.0 { speed / basal.speed } else { 1.0 };
        let yields = dt * law.static_shear_strength(&basal) / cosine * share;
        let size = yields.min(speed / mobility);
        let impulse: PlanVector<D> = std::array::from_fn(|c| size * v[c] / speed);
        // At the limit the node stops exactly.
        let left =
            if size < yields { [0.0; D] } else { std::array::from_fn(|c| v[c] - mobility * impulse[c]) };
        (impulse, left)
    };
    let found: Vec<(PlanVector<D>, PlanVector<D>)> =
        (0..set.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).map(impulse).collect();
    for (v, (_, left)) in solid.nodes.velocity.iter_mut().zip(&found) {
        *v = *left;
    }
    found.into_iter().map(|(impulse, _)| impulse).collect()
}

/// Transfers to the fluid its share of the impulses on the grains.
fn pass_impulses<const D: usize>(
    kernel: Kernel,
    sets: &mut [PhaseSet<D>],
    couplings: &[Option<DragCoupling>],
    impulses: &[PlanVector<D>],
) {
    let (solid, fluid) = (&sets[0], &sets[1]);
    let sorted_impulses = solid.cell_sorted.sorted_values(|j| {
        let sign = j.checked_sub(solid.len()).map_or([1.0; D], |image| solid.images[image].sign);
        let impulse = &impulses[solid.number(j)];
        std::array::from_fn::<f64, D, _>(|c| sign[c] * impulse[c])
    });
    let changes_of_fluid = |i: usize| {
        let Some(coupling) = &couplings[i] else { return [0.0; D] };
        let (x, length) = (&fluid.nodes.position[i], fluid.nodes.length[i]);
        let mean = solid.cell_sorted.mean(kernel, x, length, &sorted_impulses).unwrap_or([0.0; D]);
        std::array::from_fn(|c| coupling.velocity_per_impulse() * mean[c])
    };
    let changes_of_fluid: Vec<PlanVector<D>> =
        (0..fluid.len()).into_par_iter().with_min_len(MIN_NODES_PER_TASK).map(changes_of_fluid).collect();
    for (v, changes_of_fluid) in sets[1].nodes.velocity.iter_mut().zip(&changes_of_fluid) {
        for c in 0..D {
            v[c] -= changes_of_fluid[c];
        }
    }
}

/// Applies the rate-dependent part of the bed resistance to one phase.
fn apply_rate_resistance<const D: usize>(
    settings: &FlowSettings<D>,
    pore_columns: &PorePressureColumns,
    set: &mut PhaseSet<D>,
    role: usize,
    dt: f64,
) {
    let SplitPhase { columns, position, porosity, velocity } =
        ColumnsOnBed::split_set(settings, pore_columns, set);
    velocity.par_iter_mut().enumerate().with_min_len(MIN_NODES_PER_TASK).for_each(|(i, v)| {
        let speed = columns.bed[i].speed(v);
        if speed == 0.0 {
            return;
        }
        let zone = settings.zone(&position[i]);
        let after = if role == 0 {
            columns.resisted_solid_speed(zone, i, porosity[i], speed, dt)
        } else {
            columns.resisted_fluid_speed(zone.fluid, i, speed, dt)
        };
        scale_speed(v, speed, after);
    });
}

/// Part of the slip that drag relaxes: all of it, or its change in the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SlipSelection {
    /// Slip before the step, and slip added by the step.
    Total,
    /// Slip added since the velocities were last stored.
    Increment,
}

impl<const D: usize> ColumnsOnBed<'_, D> {
    /// Speed of the grains after the rate-dependent part of the bed resistance (m/s).
    fn resisted_solid_speed(&self, zone: &BedZone, i: usize, porosity: f64, speed: f64, dt: f64) -> f64 {
        let Some(law) = &zone.law else { return speed };
        let densities = &self.settings.material.densities;
        let (depth, steepness) = (self.depth[i], self.bed[i].steepness());
        let density = (1.0 - porosity) * densities.grain;
        let basal = BasalFlow {
            depth: depth / steepness.sqrt(),
            speed,
            normal_stress: density * self.effective_gravity[i] * depth,
            pore_pressure: 0.0,
            slope: 0.0,
            unit_weight: density * self.settings.total_gravity(),
        };
        law.speed_after_drag(&basal, dt / (density * basal.depth))
    }

    /// Speed of the fluid after its resistance (m/s).
    fn resisted_fluid_speed(&self, law: FluidResistance, i: usize, speed: f64, dt: f64) -> f64 {
        let settings = self.settings;
        if law == FluidResistance::None {
            return speed;
        }
        let depth = self.depth[i] / self.bed[i].steepness().sqrt();
        let density = settings.material.densities.fluid;
        // The area fraction n of the resistance and of the mass cancel.
        implicit_speed(speed, |v| dt / depth * law.over_density(depth, v, density, settings.total_gravity()))
    }
}
