//! The solver: its owners, and one step (sheet: dem §3.1).

mod critical_step;
mod measures;
mod prescribed_motion;
mod program_access;

use colluvium_case::{Advance, SolverError, TimeStep};

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::cell_control::control_cell;
use crate::boundary::controlled_cell::ControlledCell;
use crate::clock::Clock;
use crate::contact::ContactEnergies;
use crate::contact::contact_laws::ContactLaws;
use crate::force_loop::contact_buffers::ContactBuffers;
use crate::force_loop::contact_forces::{find_forces, sum_contacts};
use crate::momentum::grain_motion::{grow_grains, impose_body_velocities, move_grains, predict_velocities};
use crate::momentum::time_integration::GrainSums;
use crate::momentum::wall_servo::update_servo_walls;
use crate::neighbours::grain_neighbours::{GrainNeighbours, SinceListBuild};
use crate::neighbours::list_build::build_lists;
use crate::output::packing_view::PackingView;
use crate::output::records::Records;
use crate::output::stress_control_check::record_controlled_stresses;
use crate::points::grain_extremes::GrainExtremes;
use crate::points::grains::Grains;
use crate::solver::critical_step::{critical_step, deep_contact_factor};
pub use crate::solver::prescribed_motion::DemWall;
pub use crate::solver::program_access::{DemContacts, DemGrains};
use crate::specimen::pluviation_entry::add_entering_grains;
use crate::specimen::specimen_preparation::SpecimenPreparation;

/// DEM solver of grains in `D` dimensions, with rotations of `R` components.
pub struct DemSolver<const D: usize, const R: usize> {
    /// Time, step, stage and options of the run.
    pub(crate) clock: Clock,
    /// Contact laws of all pairs of materials.
    pub(crate) laws: ContactLaws,
    /// Grains with their motion and forces.
    pub(crate) grains: Grains<D, R>,
    /// Smallest and largest radius and speed of the fastest grain.
    pub(crate) extremes: GrainExtremes,
    /// Periodic cell with the control of its stress or strain.
    pub(crate) cell: ControlledCell<D>,
    /// Walls, membranes and other boundary conditions.
    pub(crate) boundary: BoundaryConditions<D>,
    /// Lists of neighbouring grains and walls.
    pub(crate) neighbours: GrainNeighbours<D, R>,
    /// Energy balance and other records for the output.
    pub(crate) records: Records,
    /// Preparation of the specimen: grains that enter during the run, reports on filled bodies and origin from a file.
    pub(crate) specimen: SpecimenPreparation,
    /// Memory that a step reuses.
    pub(crate) workspace: Workspace<D, R>,
}

/// Buffers of a step.
#[derive(Default)]
pub struct Workspace<const D: usize, const R: usize> {
    /// Buffers of the contact forces.
    pub contacts: ContactBuffers<D, R>,
    /// Energy sums over each range of grains.
    pub grain_sums: Vec<GrainSums<D>>,
}

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Takes a step of at most `at_most` (s).
    pub(crate) fn take_step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.present_limit();
        let dt = limit.limited_to(at_most);
        self.advance(dt)?;
        Ok(Advance { dt, limit: limit.limit })
    }

    /// Advances the solver by a step of `dt` (s); step numbers in the code are those of the main loop (sheet: dem §3.1).
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        let Self { clock, laws, grains, extremes, cell, boundary, neighbours, records, specimen, workspace } =
            self;
        let Workspace { contacts, grain_sums } = workspace;
        boundary.body_force.update(clock, grains)?;
        clock.deep_contact_factor = deep_contact_factor(clock, laws, extremes, &records.energy_balance); // 1
        let count = grains.len();
        add_entering_grains(clock, cell, boundary, (grains, extremes), neighbours, specimen, records);
        if grains.len() != count {
            boundary.body_force.update(clock, grains)?;
        }
        if neighbours.is_stale(laws, cell, extremes) {
            let work = &mut records.energy_balance.boundary;
            build_lists(clock, laws, cell, (grains, extremes), boundary, neighbours, work)?; // 2
        }
        impose_body_velocities(clock, grains, &boundary.body_velocities, dt);
        let owners = (&mut *grains, &*extremes);
        let energies = contact_forces(clock, laws, cell, owners, boundary, neighbours, (contacts, dt)); // 3, 4
        records.add_contacts(clock, grains, &mut neighbours.pairs, &energies); // 4
        records.check_overlap(clock, grains, contacts)?;
        let change = control_cell(clock, cell, grains, dt); // 6
        update_servo_walls(clock, laws, cell, grains, &neighbours.walls, boundary, dt); // 6
        record_controlled_stresses(clock, cell, grains, boundary, &mut records.controlled_stresses, dt);
        let since_build = &mut neighbours.since_build;
        let owners = (&mut *grains, &mut *extremes);
        let sums = move_all(clock, cell, owners, boundary, since_build, grain_sums, (dt, change))?; // 5, 6
        records.energy_balance.add_grains(&sums, 0.5 * clock.last_step / (0.5 * (clock.last_step + dt)));
        clock.end(dt);
        Ok(())
    }

    /// Builds the lists of neighbours.
    pub(crate) fn build_lists(&mut self) -> Result<(), SolverError> {
        let Self { clock, laws, grains, extremes, cell, boundary, neighbours, records, .. } = self;
        let work = &mut records.energy_balance.boundary;
        build_lists(clock, laws, cell, (grains, extremes), boundary, neighbours, work)
    }

    /// Critical step at present, after changes of velocities by a program.
    pub(crate) fn present_limit(&mut self) -> TimeStep {
        self.extremes = self.extremes.with_changed_velocities(&self.grains);
        self.critical_step()
    }

    /// Critical step at present (sheet: dem §3.5).
    pub(crate) fn critical_step(&self) -> TimeStep {
        let Self { clock, laws, extremes, boundary, records, .. } = self;
        critical_step(clock, laws, extremes, &boundary.walls, &records.energy_balance)
    }

    /// View of the packing, for measures.
    pub(crate) fn view(&self) -> PackingView<'_, D, R> {
        let Self { clock, laws, grains, cell, boundary, neighbours, records, .. } = self;
        PackingView { clock, laws, grains, cell, boundary, neighbours, records }
    }
}

/// Computes the contact forces on grains, walls and cell before a step of `dt` (s). Returns the energies of the contacts.
fn contact_forces<const D: usize, const R: usize>(
    clock: &Clock,
    laws: &ContactLaws,
    cell: &mut ControlledCell<D>,
    (grains, extremes): (&mut Grains<D, R>, &GrainExtremes),
    boundary: &mut BoundaryConditions<D>,
    neighbours: &mut GrainNeighbours<D, R>,
    (buffers, dt): (&mut ContactBuffers<D, R>, f64),
) -> ContactEnergies {
    neighbours.find_facets(laws, grains, &boundary.walls);
    predict_velocities(clock, grains, &boundary.membranes, buffers);
    let walls = &mut boundary.walls;
    find_forces(clock, laws, cell, (grains, extremes), walls, neighbours, (&mut *buffers, dt));
    sum_contacts(clock, cell, walls, buffers)
}

/// Moves the grains, the cell, the walls and the obstacles by a step of `dt` (s), in which the velocity gradient of the cell changes by
/// `change` (1/s).
fn move_all<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &mut ControlledCell<D>,
    (grains, extremes): (&mut Grains<D, R>, &mut GrainExtremes),
    boundary: &mut BoundaryConditions<D>,
    since_build: &mut SinceListBuild<D>,
    buffer: &mut Vec<GrainSums<D>>,
    (dt, change): (f64, [[f64; D]; D]),
) -> Result<GrainSums<D>, SolverError> {
    let owners = (&mut *grains, &mut *extremes);
    let sums = move_grains(clock, cell, owners, &boundary.membranes, since_build, buffer, (dt, change))?;
    grow_grains(clock, cell, (grains, extremes), since_build, dt);
    since_build.wall_travel += boundary.advance(clock.time, dt);
    Ok(sums)
}
