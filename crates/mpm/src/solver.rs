//! The solver: its data and one step.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use colluvium_case::{Case, SolverError, TimeStep, spatial};
use colluvium_grid::{Faces, Lanes, Node, Walls};
use rayon::prelude::*;

use crate::absorbing::{Absorbing, Impedance};
use crate::background::Background;
use crate::blocks::{Block, BlockReport, OfSet};
use crate::config::{StressScheme, Transfer};
use crate::consistent::ConsistentMass;
use crate::contact::Contacts;
use crate::driven::Driven;
use crate::dual::DualNodes;
use crate::free_surface::FreeSurface;
use crate::mixed::CellStresses;
use crate::momentum::{Audit, MomentumSolve, RowSums, damp};
use crate::nodal::NodalLoad;
use crate::obstacles::rocks::Rocks;
use crate::points::PointSet;
use crate::strain::CellStrains;
use crate::transfer::{PointUpdate, REMAPPED, SOLVED, Scatter};
use crate::two_phase::TwoPhase;
use crate::vectors::{power, three};
use crate::{Manufactured, MpmOptions};

/// Steps between re-evaluations of the critical time step.
pub(crate) const STEPS_PER_TIME_STEP: u64 = 10;

/// Explicit MPM in `D` dimensions.
pub struct MpmSolver<const D: usize> {
    pub(crate) case: Arc<Case>,
    pub(crate) options: MpmOptions,
    /// Share of FLIP in the stage.
    pub(crate) flip: f64,
    pub(crate) background: Background<D>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) remapped: Vec<Lanes>,
    pub(crate) row_sums: Vec<RowSums>,
    pub(crate) sets: Vec<PointSet<D>>,
    pub(crate) contacts: Contacts,
    /// When the loads of the case begin (s); infinite as long as their stage has not.
    pub(crate) load_starts: Vec<f64>,
    /// Loads on nodes.
    pub(crate) nodal: Vec<NodalLoad>,
    /// Rigid bodies and patches of prescribed velocity.
    pub(crate) driven: Vec<Driven>,
    pub(crate) strains: CellStrains,
    pub(crate) stresses: CellStresses,
    pub(crate) dual: DualNodes,
    pub(crate) consistent: ConsistentMass,
    pub(crate) walls: Walls,
    /// Obstacles on the nodes.
    pub(crate) faces: Arc<Faces>,
    /// Obstacles on the points; `None` where they are on the nodes.
    pub(crate) rocks: Option<Box<Rocks<D>>>,
    /// Whether a wall stands on the lower and on the upper side of the domain, per axis.
    pub(crate) closed: [[bool; 2]; D],
    pub(crate) gravity: [f64; 3],
    pub(crate) stage: usize,
    pub(crate) stage_start: f64,
    pub(crate) time: f64,
    pub(crate) step: u64,
    /// Sum over the steps since the last sort of the largest move along an axis (m).
    pub(crate) travel: f64,
    /// Whether points have left in the step that are to be taken away; they have no place (NaN). Boxed, so that what a step
    /// reads of the solver is known not to change.
    pub(crate) left: Box<AtomicBool>,
    pub(crate) heaviest: f64,
    pub(crate) limit: Option<TimeStep>,
    pub(crate) limit_age: u64,
    pub(crate) sums: RowSums,
    pub(crate) external_work: f64,
    /// Both phases of the nodes; `None` in a case without pore fluid.
    pub(crate) two_phase: Option<Box<TwoPhase>>,
    /// A solution to verify against, whose force acts on the points.
    pub(crate) manufactured: Option<Arc<Manufactured>>,
    pub(crate) free_surface: Option<Box<FreeSurface<D>>>,
    pub(crate) absorbing: Absorbing,
    /// Of the bodies of the case; empty without absorbing boundaries.
    pub(crate) impedances: Vec<Impedance>,
}

impl<const D: usize> MpmSolver<D> {
    /// One step (sheet: mpm §3.3); the numbers are those of the sheet.
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        self.check_fixed_step()?;
        if self.two_phase.is_some() {
            return self.advance_two_phase(dt);
        }
        // 0: cells, weights, empty grid.
        self.sort_if_moved();
        self.reset_nodes();
        self.drive(dt);
        self.push_manufactured();
        self.free_surface();
        let moved = match self.options.stress_update {
            StressScheme::Usl => {
                self.scatter(Scatter::Everything, dt); // 1
                self.solve_momentum(dt)?; // 2–4
                self.share_strain_if_asked::<SOLVED>(dt); // 7
                self.follow_loads::<SOLVED>(dt);
                // 5, 7–9
                self.update_points::<SOLVED>(
                    dt,
                    PointUpdate { velocity: true, stress: true, position: true },
                )?
            }
            StressScheme::Musl => {
                self.scatter(Scatter::Everything, dt); // 1
                self.solve_momentum(dt)?; // 2–4
                self.update_points::<SOLVED>(dt, PointUpdate { velocity: true, ..PointUpdate::NONE })?; // 5
                self.remap(); // 6
                self.share_strain_if_asked::<REMAPPED>(dt); // 7
                self.follow_loads::<REMAPPED>(dt);
                // 7–9
                self.update_points::<REMAPPED>(
                    dt,
                    PointUpdate { velocity: false, stress: true, position: true },
                )?
            }
            StressScheme::Usf => {
                self.scatter(Scatter::Motion, dt); // 1, momentum and mass
                self.start_velocities();
                self.share_strain_if_asked::<REMAPPED>(dt); // 7
                self.update_points::<REMAPPED>(dt, PointUpdate { stress: true, ..PointUpdate::NONE })?; // 7–8
                self.free_surface();
                self.scatter(Scatter::Forces, dt); // 1, forces
                self.solve_momentum(dt)?; // 2–4
                self.follow_loads::<SOLVED>(dt);
                // 5, 9
                self.update_points::<SOLVED>(
                    dt,
                    PointUpdate { velocity: true, stress: false, position: true },
                )?
            }
        };
        self.end_step(moved, dt) // 10
    }

    /// Moves what is driven, and counts (step 10); `moved` is the largest move of a point along an axis (m).
    pub(crate) fn end_step(&mut self, moved: f64, dt: f64) -> Result<(), SolverError> {
        self.travel += moved.max(self.move_driven(dt)?);
        self.drop_those_that_left();
        self.wrap();
        self.walls.set_off(false);
        self.time += dt;
        self.step += 1;
        self.limit_age += 1;
        Ok(())
    }

    /// Takes the walls of a stage.
    pub(crate) fn set_walls(&mut self, walls: Walls) {
        let (nodes, ghosts) = (self.background.layout.nodes(), self.background.axis.ghosts);
        let stands = |axis: usize, index: usize| walls.has_wall(axis, index);
        let sides = |axis: usize| [stands(axis, ghosts), stands(axis, nodes[axis] - 1 - ghosts)];
        self.closed = std::array::from_fn(sides);
        self.walls = walls;
    }

    pub(crate) fn sort_if_moved(&mut self) {
        if self.travel < self.background.grid.cell {
            return;
        }
        self.sort();
    }

    /// Takes away points that have left, of bodies that let them.
    fn drop_those_that_left(&mut self) {
        if std::mem::take(self.left.get_mut()) {
            self.keep_points(|x| !x[0].is_nan());
            self.sort();
        }
    }

    /// Takes away all points but those at places (m) that `keep` names, and bodies without any left.
    pub(crate) fn keep_points(&mut self, keep: impl Fn(&[f64; D]) -> bool) {
        self.sets.iter_mut().for_each(|set| set.retain(&keep));
        self.sets.retain(|set| set.len() > 0);
    }

    /// Brings points back that left through a periodic side, on the other one.
    pub(crate) fn wrap(&mut self) {
        if self.background.periodic == [false; D] {
            return;
        }
        let (low, high, periodic) =
            (self.background.grid.origin, self.background.upper, self.background.periodic);
        let mut wrapped = false;
        for set in &mut self.sets {
            wrapped |= wrap([&low, &high], &periodic, &mut set.position, &mut set.origin);
        }
        if wrapped {
            // They are in other slabs now.
            self.travel = f64::INFINITY;
        }
    }

    /// Sorts all points by cell and finds the active nodes.
    pub(crate) fn sort(&mut self) {
        // Nodes outside the new active region would keep what they hold.
        self.reset_nodes();
        self.reset_remapped();
        let cells = self.background.cell_layout();
        self.strains.reset([&self.background.layout, cells]);
        self.stresses.reset(cells);
        self.dual.reset(&self.background.layout);
        self.consistent.reset(&self.background.layout);
        if let Some(phases) = &mut self.two_phase {
            phases.reset(&self.background.layout);
        }
        for set in &mut self.sets {
            set.sort(&self.background.grid);
        }
        self.travel = 0.0;
        self.find_active_nodes();
    }

    /// Active nodes and slab bounds from the sorted points.
    pub(crate) fn find_active_nodes(&mut self) {
        self.background.layout.clear();
        for set in &mut self.sets {
            set.slabs = self.background.layout.add_points(&set.anchors());
        }
        self.heaviest = self.sets.iter().flat_map(|s| &s.mass).fold(0.0, |a: f64, &b| a.max(b));
        if let Some(phases) = &mut self.two_phase {
            let masses = self.sets.iter().flat_map(|set| (0..set.len()).map(|p| set.liquid_mass(p)));
            phases.heaviest = masses.fold(0.0, f64::max);
        }
    }

    /// Empties the active nodes of all velocity fields.
    fn reset_nodes(&mut self) {
        for nodes in self.nodes.chunks_exact_mut(self.background.layout.len()) {
            self.background.layout.reset(nodes);
        }
    }

    /// Empties the active nodes of what re-mapping and XPIC sum up.
    pub(crate) fn reset_remapped(&mut self) {
        for nodes in self.remapped.chunks_exact_mut(self.background.layout.len()) {
            self.background.layout.reset(nodes);
        }
    }

    fn follow_loads<const FROM_SOLVED: bool>(&mut self, dt: f64) {
        self.follow_surfaces(dt, &|solver, field, points, reads| {
            let Background { layout, sweeps, .. } = &solver.background;
            let (ground, first) = (solver.background.ground(), field * layout.len());
            if FROM_SOLVED {
                sweeps.gather(&ground, points, &solver.nodes[first..], reads);
            } else {
                sweeps.gather_velocity(&ground, points, &solver.remapped[first..], reads);
            }
        });
    }

    fn solve_momentum(&mut self, dt: f64) -> Result<(), SolverError> {
        if self.consistent.is_used() {
            return self.solve_consistent(dt);
        }
        let stage = &self.case.stages[self.stage];
        let solve = MomentumSolve {
            dt,
            gravity: self.gravity_at(dt),
            rayleigh: stage.rayleigh_damping,
            keep_start: self.options.fixed_nodes == crate::FixedNodes::Momentum,
            inertia: self.options.mass_scaling,
            light: self.options.node_mass_cutoff * self.heaviest,
            walls: &self.walls,
            layout: &self.background.layout,
        };
        for nodes in self.nodes.chunks_exact_mut(self.background.layout.len()) {
            self.background.layout.each(nodes, |row, active, line| solve.row(row, active, line));
        }
        self.absorb(dt);
        self.hold_rigid();
        self.touch(dt);
        self.hold_patches(dt, true);
        self.damp(dt);
        if self.case.stages[self.stage].equilibrium.is_some() {
            self.audit(dt);
        }
        match self.options.transfer {
            Transfer::Flip => {}
            Transfer::Xpic => self.filter_velocities(dt),
            Transfer::Apic | Transfer::Tpic => self.gather_affine(),
        }
        Ok(())
    }

    /// Local damping. It goes by the forces out of balance: those of walls, of other bodies and of what is driven are in
    /// balance with others, and so it comes last. What is held stays held.
    fn damp(&mut self, dt: f64) {
        let damping = self.case.stages[self.stage].damping_of_axes();
        if damping == [0.0; 3] {
            return;
        }
        let (layout, walls) = (&self.background.layout, &self.walls);
        for nodes in self.nodes.chunks_exact_mut(layout.len()) {
            layout.each(nodes, |row, active, line| {
                for number in active {
                    let node = &mut line[number];
                    let held = walls.holding(&layout.index(row, number), &three(node.motion));
                    damp(node, &damping, held, dt);
                }
            });
        }
        self.hold_patches(dt, false);
    }

    /// Measures of equilibrium from the solved nodes, contacts included (sheet: mpm §2.14).
    fn audit(&mut self, dt: f64) {
        let stage = &self.case.stages[self.stage];
        let audit = Audit {
            dt,
            gravity: self.gravity_at(dt),
            damping: stage.damping_of_axes(),
            rayleigh: stage.rayleigh_damping,
            inertia: self.options.mass_scaling,
            light: self.options.node_mass_cutoff * self.heaviest,
            walls: &self.walls,
            layout: &self.background.layout,
        };
        let mut sums = RowSums::default();
        for (field, nodes) in self.nodes.chunks_exact_mut(self.background.layout.len()).enumerate() {
            if self.contacts.rigid.get(field).is_some_and(Option::is_some) {
                continue;
            }
            self.background
                .layout
                .rows(nodes, &mut self.row_sums, |row, active, line| audit.row(row, active, line));
            self.row_sums.iter().for_each(|row| sums.add(row));
        }
        sums.work += self.work_of_loads(dt) + self.work_on_nodes(dt);
        self.external_work += sums.work;
        self.sums = sums;
    }

    /// Updates every block of every body that deforms; returns the largest move along an axis (m).
    pub(crate) fn update_blocks(
        &mut self,
        update: impl Fn(&Self, &OfSet<'_, D>, &mut Block<'_, D>) -> BlockReport + Sync,
    ) -> Result<f64, SolverError> {
        let mut sets = std::mem::take(&mut self.sets);
        let mut moved = Ok(0f64);
        for (number, set) in sets.iter_mut().enumerate().filter(|(_, set)| set.rigid.is_none()) {
            let material = set.material.clone();
            let of_set = OfSet {
                material: &*material,
                extent: set.extent,
                body: set.body,
                field: set.field,
                anchored: set.domain.are_anchored(),
                fluid: set.pore.as_ref().and_then(|pore| pore.fluid),
                drop_outside: self.case.bodies[set.body as usize].drop_outside,
            };
            let solver = &*self;
            match set.whole().update(&|block| update(solver, &of_set, block)) {
                Ok(m) => moved = moved.map(|moved: f64| moved.max(m)),
                Err(failure) => {
                    moved = Err((number, failure));
                    break;
                }
            }
        }
        self.sets = sets;
        moved.map_err(|(number, failure)| self.failed(number, failure.index, failure.reason))
    }

    /// The error of a point that cannot be followed.
    pub(crate) fn failed(&self, set: usize, index: usize, reason: String) -> SolverError {
        let set = &self.sets[set];
        SolverError::Point {
            step: self.step,
            time: self.time,
            point: u64::from(set.id[index]),
            position: spatial(&set.position[index]),
            reason,
        }
    }

    /// Work of tractions and prescribed motions in the step (J).
    pub(crate) fn work_of_loads(&self, dt: f64) -> f64 {
        let mut work = 0.0;
        for set in &self.sets {
            work += dt * power(&set.traction, &set.velocity);
        }
        for driven in &self.driven {
            let velocity = driven.rigid_velocity();
            work -= (0..3).map(|c| driven.state.force[c] * velocity[c] * dt).sum::<f64>();
        }
        work
    }

    /// Gravity at the end of a step of `dt` (m/s²).
    pub(crate) fn gravity_at(&self, dt: f64) -> [f64; 3] {
        let factor = self.case.stages[self.stage].gravity_factor(self.time + dt - self.stage_start);
        self.gravity.map(|g| g * factor)
    }

    /// Refuses to go on with a step that the case fixes and the state no longer allows.
    fn check_fixed_step(&self) -> Result<(), SolverError> {
        match self.limit.as_ref().and_then(|limit| limit.too_long(self.options.time_step)) {
            Some(problem) => {
                let reason = format!("methods.mpm.time_step: {problem}");
                Err(SolverError::Step { step: self.step, time: self.time, reason })
            }
            None => Ok(()),
        }
    }

    /// The largest stable step from the current state (sheet: mpm §2.10).
    pub(crate) fn critical_step(&mut self) -> TimeStep {
        if self.limit.is_none() || self.limit_age >= STEPS_PER_TIME_STEP {
            let fixed = self.options.time_step;
            let courant = if fixed.is_some() { 1.0 } else { self.options.courant };
            self.limit = Some(self.wave_limit(courant).or_fixed(fixed));
            self.limit_age = 0;
        }
        self.limit.expect("set above")
    }
}

/// Moves points beyond the corners `low` and `high` (m) of a box to its other side along the axes that are periodic,
/// and what displacement is counted from with them; says whether there were any.
fn wrap<const D: usize>(
    [low, high]: [&[f64; D]; 2],
    periodic: &[bool; D],
    positions: &mut [[f64; D]],
    origins: &mut [[f64; D]],
) -> bool {
    let points = positions.par_iter_mut().zip(origins).map(|(position, origin)| {
        let mut any = false;
        for axis in (0..D).filter(|axis| periodic[*axis]) {
            let shift = match position[axis] {
                x if x < low[axis] => high[axis] - low[axis],
                x if x >= high[axis] => low[axis] - high[axis],
                _ => continue,
            };
            position[axis] = (position[axis] + shift).clamp(low[axis], high[axis]);
            origin[axis] += shift;
            any = true;
        }
        any
    });
    points.reduce(|| false, |a, b| a | b)
}
