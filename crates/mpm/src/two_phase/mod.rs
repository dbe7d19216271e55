//! Saturated bodies: skeleton and pore fluid move apart on one set of points, which follow the skeleton
//! (sheet: mpm §2.3, §3.4; "v–w" formulation with a single point set).
//!
//! A node holds both phases. The liquid's equation is per volume of liquid, the other one that of the mixture:
//!
//! ```text
//! M_L a_L = f_L - Q (v_L - v_S)          M_S a_S = f - M̄_L a_L
//! ```
//!
//! with `M_L = Σ N ρ_L Ω`, `M̄_L = Σ N n ρ_L Ω`, `M_S = Σ N m_S` and the drag `Q = Σ N n ρ_L g / k Ω`.
//! Here pore pressure is compression-positive, `p_w = -p_L` of the sheet.

mod bear;
mod damping;
mod momentum;
mod report;
mod setup;
mod strain;
mod transfer;

use std::sync::Arc;

use colluvium_case::{Equilibrium, Scales, SolverError};
use colluvium_constitutive::BLOCK;
use colluvium_grid::{Faces, Gathered, Lanes, Layout, Node, Points, Walls};

pub use momentum::PhaseSums;
pub use setup::{cleared, of_liquid, pore_set, two_phase};

use crate::averages::Averages;
use crate::background::Background;
use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::clock::Clock;
use crate::config::StressScheme;
use crate::driven::{hold_phases, mark_held};
use crate::loads::follow_surfaces;
use crate::momentum::RowSums;
use crate::nodal::{nodal_squares, work_on_phase_nodes};
use crate::nodes::Velocities::{Remapped, Solved};
use crate::nodes::{Nodes, Velocities};
use crate::points::PointSet;
use crate::pore::SOLID;
use crate::solver::{MpmSolver, work_of_loads};
use crate::stopping::{Stopping, with_mass};
use crate::update::PointUpdate;
use crate::vectors::{power, square_sum};
use bear::bear_phases;
use damping::Damping;
use momentum::PhaseSolve;
use strain::share_phase_strains;
use transfer::{remap_phases, scatter_phases, update_phases};

/// What a solver with pore fluid holds beside its points.
pub struct TwoPhase {
    nodes: Vec<[Node; 2]>,
    remapped: Vec<[Lanes; 2]>,
    row_sums: Vec<PhaseSums>,
    /// Components of velocity that patches hold, one bit an axis; empty where nothing asks for them.
    held: Vec<[u8; 2]>,
    pub(crate) sums: PhaseSums,
    /// Walls of the liquid.
    pub(crate) walls: Walls,
    /// Obstacles on the nodes, as the liquid meets them.
    pub(crate) faces: Arc<Faces>,
    /// Largest liquid mass of a point (kg).
    pub(crate) heaviest: f64,
}

impl TwoPhase {
    /// Memory of the nodes (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.remapped[..])
            + size_of_val(&self.row_sums[..])
            + size_of_val(&self.held[..])
    }

    /// What points read of the nodes of both phases, gradients among it.
    fn gather<const D: usize>(
        &self,
        of: Velocities,
        background: &Background<D>,
        points: &Points<'_, D>,
        reads: &mut [[Gathered<D>; 2]],
    ) {
        let (ground, sweeps) = (background.ground(), background.sweeps);
        match of {
            Solved => sweeps.gather_phases(&ground, points, &self.nodes, reads),
            Remapped => sweeps.gather_velocities(&ground, points, &self.remapped, reads),
        }
    }

    /// Clears the active nodes.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        layout.reset(&mut self.nodes);
        layout.reset(&mut self.remapped);
    }
}

impl TwoPhase {
    /// Finds the largest liquid mass of a point.
    pub fn find_heaviest<const D: usize>(&mut self, bodies: &Bodies<D>) {
        let masses = bodies.sets.iter().flat_map(|set| (0..set.len()).map(|p| set.liquid_mass(p)));
        self.heaviest = masses.fold(0.0, f64::max);
    }
}

/// Steps 1 to 9 of both phases (sheet: mpm §3.4); the numbers are those of the sheet. Returns the largest move of a point along
/// an axis (m).
pub fn step_phases<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut Nodes,
    boundary: &mut Boundary<D>,
    averages: &mut Averages<D>,
    phases: &mut TwoPhase,
) -> Result<f64, SolverError> {
    background.layout.reset(&mut phases.nodes); // 0
    let (all, velocity, stress) = (PointUpdate::ALL, PointUpdate::VELOCITY, PointUpdate::STRESS);
    let moved = match clock.options.stress_update {
        StressScheme::Usl => {
            scatter_phases(clock, background, bodies, boundary, averages, phases); // 1
            solve_phases(clock, background, bodies, nodes, boundary, phases); // 2–4
            share_phase_strains(clock, background, bodies, &mut averages.strains, (phases, Solved)); // 7
            follow_phases(clock, background, bodies, (phases, Solved));
            update_phases(clock, background, bodies, boundary, averages, (phases, Solved), all) // 5, 7–9
        }
        StressScheme::Musl => {
            scatter_phases(clock, background, bodies, boundary, averages, phases); // 1
            solve_phases(clock, background, bodies, nodes, boundary, phases); // 2–4
            update_phases(clock, background, bodies, boundary, averages, (phases, Solved), velocity)?; // 5
            remap_phases(clock, background, bodies, boundary, phases, false); // 6
            stop_remapped(clock, background, bodies, boundary, phases);
            share_phase_strains(clock, background, bodies, &mut averages.strains, (phases, Remapped)); // 7
            follow_phases(clock, background, bodies, (phases, Remapped));
            let rest = PointUpdate { position: true, ..stress };
            update_phases(clock, background, bodies, boundary, averages, (phases, Remapped), rest) // 7–9
        }
        StressScheme::Usf => {
            remap_phases(clock, background, bodies, boundary, phases, true); // 1, momenta and masses
            share_phase_strains(clock, background, bodies, &mut averages.strains, (phases, Remapped)); // 7
            update_phases(clock, background, bodies, boundary, averages, (phases, Remapped), stress)?; // 7, 8
            scatter_phases(clock, background, bodies, boundary, averages, phases); // 1
            solve_phases(clock, background, bodies, nodes, boundary, phases); // 2–4
            follow_phases(clock, background, bodies, (phases, Solved));
            let rest = PointUpdate { position: true, ..velocity };
            update_phases(clock, background, bodies, boundary, averages, (phases, Solved), rest) // 5, 9
        }
    };
    phases.walls.set_off(false);
    moved
}

/// Loads that follow the surface, from the velocity of the skeleton.
fn follow_phases<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    (phases, read): (&TwoPhase, Velocities),
) {
    follow_surfaces(clock, background, bodies, &|_, points, out| {
        let mut all = [[Gathered::ZERO; 2]; BLOCK];
        let reads = &mut all[..points.len()];
        phases.gather(read, background, points, reads);
        out.iter_mut().zip(&*reads).for_each(|(out, read)| *out = read[SOLID]);
    });
}

fn solve_phases<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    nodes: &mut Nodes,
    boundary: &mut Boundary<D>,
    phases: &mut TwoPhase,
) {
    let Boundary {
        walls: own_walls, driven, contacts, nodal, load_starts, absorbing, bearing, rocks, ..
    } = boundary;
    let (stage, dt) = (clock.stage(), clock.dt);
    let audit = stage.equilibrium.is_some();
    let factors = stage.damping_of_axes();
    let damped = factors != [0.0; 3];
    phases.held.clear();
    if (audit || damped) && !clock.case.patches.is_empty() {
        phases.held.resize(phases.nodes.len(), [0; 2]);
        mark_held(clock, background, driven, contacts, &mut phases.held);
    }
    let TwoPhase { nodes: of_phases, row_sums, walls, heaviest, sums, held, .. } = phases;
    let cutoff = clock.options.mass_cutoff();
    let solve = PhaseSolve {
        dt,
        gravity: clock.gravity_at_end(),
        keep_start: clock.keeps_start(),
        inertia: clock.options.mass_scaling,
        light: [bodies.light(clock), cutoff * *heaviest],
        audit,
        held,
        walls: [&*own_walls, &*walls],
        layout: &background.layout,
    };
    if let Some(bearing) = bearing {
        bear_phases(bearing, &solve, background, of_phases);
    }
    background.layout.rows(of_phases, row_sums, |row, active, line| solve.row(row, active, line));
    absorbing.absorb_phases(clock, of_phases, [&*own_walls, &*walls]);
    hold_phases(clock, background, driven, contacts, of_phases);
    let stopping = Stopping { clock, background, bodies, walls: own_walls, takes: true };
    let slow = |node: &mut [Node; 2], change| node[SOLID].change_velocity(change, dt);
    stopping.stop(rocks, of_phases, |_, node| node[SOLID].motion, slow);
    if damped {
        let PhaseSolve { light, held, walls, layout, .. } = solve;
        let damping = Damping { dt, factors, light, held, walls, layout };
        layout.each(of_phases, |row, active, line| damping.row(row, active, line));
        stopping.stop(rocks, of_phases, |_, node| node[SOLID].motion, slow);
    }
    if audit {
        *sums = PhaseSums::default();
        row_sums.iter().for_each(|row| sums.add(row));
        nodes.external_work +=
            sums.mixture.work + work_of_loads(bodies, driven, dt) + work_of_pore_loads(bodies, dt);
        nodes.external_work += work_on_phase_nodes(clock, bodies, nodal, load_starts, of_phases);
    }
}

/// Stops points by the re-mapped velocities of the skeleton, by which they change place.
fn stop_remapped<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    boundary: &mut Boundary<D>,
    phases: &mut TwoPhase,
) {
    let Boundary { walls, rocks, .. } = boundary;
    let TwoPhase { nodes, remapped, .. } = phases;
    let stopping = Stopping { clock, background, bodies, walls, takes: false };
    let of = |number: usize, own: &[Lanes; 2]| with_mass(own[SOLID], nodes[number][SOLID].motion);
    stopping.stop(rocks, remapped, of, |node, change| node[SOLID] += change);
}

/// Work in the step (J) of prescribed pore pressures on the fluid beyond what they do on the mixture.
fn work_of_pore_loads<const D: usize>(bodies: &Bodies<D>, dt: f64) -> f64 {
    let of_set = |set: &PointSet<D>| -> f64 {
        let Some(pore) = &set.pore else { return 0.0 };
        let seepage =
            |p: usize| std::array::from_fn(|c| pore.points.velocity[p][c] - set.points.velocity[p][c]);
        set.pore_loads().map(|(p, force)| power(&[force], &[seepage(p)])).sum()
    };
    dt * bodies.sets.iter().map(of_set).sum::<f64>()
}

impl<const D: usize> MpmSolver<D> {
    /// Distance from equilibrium: the larger one of mixture and liquid (sheet: mpm §2.14); the energy of the mixture is that of
    /// both phases. `traction` is the sum of the squares of the tractions (N²).
    pub(crate) fn phase_equilibrium(&self, phases: &TwoPhase, traction: f64, scales: Scales) -> Equilibrium {
        let PhaseSums { mixture, liquid } = &phases.sums;
        let of_mixture = (mixture.external + traction).sqrt();
        let pore_loads = self.bodies.sets.iter().flat_map(PointSet::pore_loads);
        let pore_loads: f64 = pore_loads.map(|(_, force)| square_sum(&[force])).sum();
        let Boundary { nodal, load_starts, .. } = &self.boundary;
        let [_, on_nodes] = nodal_squares(&self.clock, &self.bodies, nodal, load_starts);
        let mut of_liquid = (liquid.external + pore_loads + on_nodes).sqrt();
        if of_liquid == 0.0 {
            // Without weight and pressures the liquid has no external force of its own.
            of_liquid = of_mixture;
        }
        let unbalanced = |sums: &RowSums, external| scales.force_ratio(sums.unbalanced.sqrt(), external);
        Equilibrium {
            unbalanced_force: unbalanced(mixture, of_mixture).max(unbalanced(liquid, of_liquid)),
            kinetic_ratio: scales.energy_ratio(mixture.kinetic, self.nodes.external_work),
            kinetic: mixture.kinetic,
        }
    }
}
