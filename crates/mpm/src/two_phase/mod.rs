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

mod momentum;
mod report;
mod setup;
mod strain;
mod transfer;

use colluvium_case::{Equilibrium, Scales, SolverError};
use colluvium_constitutive::BLOCK;
use colluvium_grid::{Gathered, Lanes, Layout, Node, Walls};

pub use momentum::PhaseSums;
pub use setup::{cleared, of_liquid, pore_set, two_phase};

use crate::config::StressScheme;
use crate::momentum::RowSums;
use crate::points::PointSet;
use crate::pore::SOLID;
use crate::solver::MpmSolver;
use crate::transfer::{PointUpdate, REMAPPED, SOLVED};
use crate::vectors::{power, square_sum};
use momentum::PhaseSolve;

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

    /// Clears the active nodes.
    pub fn reset<const D: usize>(&mut self, layout: &Layout<D>) {
        layout.reset(&mut self.nodes);
        layout.reset(&mut self.remapped);
    }
}

impl<const D: usize> MpmSolver<D> {
    /// One step of both phases (sheet: mpm §3.4); the numbers are those of the sheet.
    pub(crate) fn advance_two_phase(&mut self, dt: f64) -> Result<(), SolverError> {
        self.sort_if_moved();
        let Some(mut phases) = self.two_phase.take() else { return Ok(()) };
        self.drive(dt);
        let moved = self.step_phases(&mut phases, dt);
        phases.walls.set_off(false);
        self.two_phase = Some(phases);
        self.end_step(moved?, dt)
    }

    fn step_phases(&mut self, phases: &mut TwoPhase, dt: f64) -> Result<f64, SolverError> {
        self.background.layout.reset(&mut phases.nodes); // 0
        let velocity = PointUpdate { velocity: true, ..PointUpdate::NONE };
        let stress = PointUpdate { stress: true, ..PointUpdate::NONE };
        let position = PointUpdate { position: true, ..PointUpdate::NONE };
        match self.options.stress_update {
            StressScheme::Usl => {
                self.scatter_phases(phases, dt); // 1
                self.solve_phases(phases, dt); // 2–4
                self.share_phase_strains::<SOLVED>(phases, dt); // 7
                self.follow_phases::<SOLVED>(phases, dt);
                // 5, 7–9
                self.update_phases::<SOLVED>(
                    phases,
                    dt,
                    PointUpdate { velocity: true, position: true, ..stress },
                )
            }
            StressScheme::Musl => {
                self.scatter_phases(phases, dt); // 1
                self.solve_phases(phases, dt); // 2–4
                self.update_phases::<SOLVED>(phases, dt, velocity)?; // 5
                self.remap_phases(phases, false); // 6
                self.share_phase_strains::<REMAPPED>(phases, dt); // 7
                self.follow_phases::<REMAPPED>(phases, dt);
                self.update_phases::<REMAPPED>(phases, dt, PointUpdate { position: true, ..stress }) // 7–9
            }
            StressScheme::Usf => {
                self.remap_phases(phases, true); // 1, momenta and masses
                self.share_phase_strains::<REMAPPED>(phases, dt); // 7
                self.update_phases::<REMAPPED>(phases, dt, stress)?; // 7, 8
                self.scatter_phases(phases, dt); // 1
                self.solve_phases(phases, dt); // 2–4
                self.follow_phases::<SOLVED>(phases, dt);
                self.update_phases::<SOLVED>(phases, dt, PointUpdate { velocity: true, ..position }) // 5, 9
            }
        }
    }

    /// Loads that follow the surface, from the velocity of the skeleton.
    fn follow_phases<const FROM_SOLVED: bool>(&mut self, phases: &TwoPhase, dt: f64) {
        self.follow_surfaces(dt, &|solver, _, points, out| {
            let (ground, sweeps) = (solver.background.ground(), solver.background.sweeps);
            let mut all = [[Gathered::ZERO; 2]; BLOCK];
            let reads = &mut all[..points.len()];
            if FROM_SOLVED {
                sweeps.gather_phases(&ground, points, &phases.nodes, reads);
            } else {
                sweeps.gather_velocities(&ground, points, &phases.remapped, reads);
            }
            out.iter_mut().zip(&*reads).for_each(|(out, read)| *out = read[SOLID]);
        });
    }

    fn solve_phases(&mut self, phases: &mut TwoPhase, dt: f64) {
        let stage = &self.case.stages[self.stage];
        let audit = stage.equilibrium.is_some();
        phases.held.clear();
        if (audit || stage.damping > 0.0) && !self.case.patches.is_empty() {
            phases.held.resize(phases.nodes.len(), [0; 2]);
            self.mark_held(&mut phases.held);
        }
        let TwoPhase { nodes, row_sums, walls, heaviest, sums, held, .. } = phases;
        let cutoff = self.options.node_mass_cutoff;
        let solve = PhaseSolve {
            dt,
            gravity: self.gravity_at(dt),
            damping: stage.damping,
            keep_start: self.options.fixed_nodes == crate::FixedNodes::Momentum,
            inertia: self.options.mass_scaling,
            light: [cutoff * self.heaviest, cutoff * *heaviest],
            audit,
            held,
            walls: [&self.walls, walls],
            layout: &self.background.layout,
        };
        self.background.layout.rows(nodes, row_sums, |row, active, line| solve.row(row, active, line));
        self.absorb_phases(nodes, walls, dt);
        self.hold_phases(nodes, dt);
        if audit {
            *sums = PhaseSums::default();
            row_sums.iter().for_each(|row| sums.add(row));
            self.external_work += sums.mixture.work + self.work_of_loads(dt) + self.work_of_pore_loads(dt);
            self.external_work += self.work_on_phase_nodes(nodes, dt);
        }
    }

    /// Distance from equilibrium: the larger one of mixture and liquid (sheet: mpm §2.14); the energy of the mixture is that of
    /// both phases. `traction` is the sum of the squares of the tractions (N²).
    pub(crate) fn phase_equilibrium(&self, phases: &TwoPhase, traction: f64, scales: Scales) -> Equilibrium {
        let PhaseSums { mixture, liquid } = &phases.sums;
        let of_mixture = (mixture.external + traction).sqrt();
        let pore_loads = self.sets.iter().flat_map(PointSet::pore_loads);
        let pore_loads: f64 = pore_loads.map(|(_, force)| square_sum(&[force])).sum();
        let [_, on_nodes] = self.nodal_squares();
        let mut of_liquid = (liquid.external + pore_loads + on_nodes).sqrt();
        if of_liquid == 0.0 {
            // Without weight and pressures the liquid has no external force of its own.
            of_liquid = of_mixture;
        }
        let unbalanced = |sums: &RowSums, external| scales.force_ratio(sums.unbalanced.sqrt(), external);
        Equilibrium {
            unbalanced_force: unbalanced(mixture, of_mixture).max(unbalanced(liquid, of_liquid)),
            kinetic_ratio: scales.energy_ratio(mixture.kinetic, self.external_work),
            kinetic: mixture.kinetic,
        }
    }

    /// Work in the step (J) of prescribed pore pressures on the fluid beyond what they do on the mixture.
    fn work_of_pore_loads(&self, dt: f64) -> f64 {
        let of_set = |set: &PointSet<D>| -> f64 {
            let Some(pore) = &set.pore else { return 0.0 };
            let seepage = |p: usize| std::array::from_fn(|c| pore.velocity[p][c] - set.velocity[p][c]);
            set.pore_loads().map(|(p, force)| power(&[force], &[seepage(p)])).sum()
        };
        dt * self.sets.iter().map(of_set).sum::<f64>()
    }
}
