//! Solver: its data and one step (sheet: dem §3.1).

mod critical_step;

use std::sync::Arc;

use colluvium_case::{Advance, Case, ObstacleLaws, SolverError, spatial};
use colluvium_points::Surface;
use colluvium_points::surface::ContactQuery;

pub(crate) use crate::output::stress_control_check::ControlledStress;

use crate::boundary::periodic_cell::{PeriodicCell, inverse, product};
use crate::boundary::walls::{RigidWall, WallList, WallListView, WallReaction};
use crate::config::{ContactVelocity, DemOptions, GrainStage, LeverArm};
use crate::contact::contact_histories::HistoryColumns;
use crate::contact::{ContactEnergies, PairLaw};
use crate::force_loop::{
    ContactInput, ForceKernel, ForceTorque, GrainRecords, Virial, grain_records, scatter_forces,
};
use crate::momentum::time_integration::{ExternalActions, GrainSums, integrate_grains, rotate};
use crate::neighbours::VerletLists;
use crate::output::energy_balance::{BrokenBond, EnergyBalance};
use crate::points::grains::Grains;
use crate::points::vector::{add, dot};
use crate::specimen::Specimen;
use crate::specimen::pluviation::GrainSource;

/// Overlap over the smaller radius beyond which a run stops (sheet: dem §3.5).
const MAX_OVERLAP: f64 = 0.3;

/// Properties of a kind of grains.
#[derive(Clone, Debug, PartialEq)]
pub struct KindProperties {
    /// Name.
    pub name: String,
    /// Density of the grains (kg/m³).
    pub density: f64,
}

/// Contact laws of a stage.
#[derive(Clone, Debug, PartialEq)]
pub struct StageLaws {
    /// Laws of each pair of kinds, row by row.
    pub pairs: Vec<PairLaw>,
    /// Laws of each kind with each boundary of the case.
    pub walls: Vec<Vec<PairLaw>>,
    /// Stable step of contacts (s), and the upper bound of stable steps (s).
    pub step: [f64; 2],
    /// Overlap over the radius to the power 5/2 in a head-on impact of two of the smallest elastic spheres, over the square of the
    /// speed of each (s²/m²); zero without elastic spheres.
    pub impact: f64,
    /// Largest rupture distance of the contacts (m).
    pub rupture_distance: f64,
}

/// Buffers of a step.
#[derive(Default)]
pub struct StepBuffers<const D: usize, const R: usize> {
    pub tallies: Vec<(ContactEnergies, Virial<D>)>,
    pub reactions: Vec<WallReaction<D>>,
    pub shifts: Vec<([f64; D], [f64; D])>,
    pub sums: Vec<GrainSums<D>>,
    /// Predicted velocities, extrapolated by half a step.
    pub velocity: Vec<[f64; D]>,
    pub spin: Vec<[f64; R]>,
    pub records: GrainRecords,
    pub received: Vec<ForceTorque>,
    /// Facets in contact with a grain.
    pub facets: ContactQuery<D>,
}

/// Changes since the last list build.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SinceListBuild<const D: usize> {
    /// Cell vectors at the list build (m).
    pub cell: Option<[[f64; D]; D]>,
    /// Largest displacement of a grain (m).
    pub grain_travel: f64,
    /// Displacement of the fastest wall, plus growth of the largest radius (m).
    pub wall_travel: f64,
}

/// Origin of the grains and contacts in a specimen file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpecimenSource {
    /// Whether the grains of each body of the case are from the file.
    pub bodies: Vec<bool>,
    /// Whether contacts were bonded, or cohesive from the start on.
    pub bonded: bool,
    /// Largest overlap over the smaller radius.
    pub overlap: f64,
    /// Notes on the specimen for the user.
    pub notes: Vec<String>,
}

impl SpecimenSource {
    /// Whether the grains of body number `body` are from the file.
    pub fn has(&self, body: usize) -> bool {
        self.bodies.get(body).is_some_and(|given| *given)
    }
}

/// DEM solver of grains in `D` dimensions with rotations of `R` components.
pub struct DemSolver<const D: usize, const R: usize> {
    pub(crate) case: Arc<Case>,
    pub(crate) options: DemOptions,
    pub(crate) kinds: Vec<KindProperties>,
    pub(crate) laws: StageLaws,
    pub(crate) columns: HistoryColumns,
    pub(crate) grains: Grains<D, R>,
    pub(crate) cell: PeriodicCell<D>,
    pub(crate) lists: VerletLists<D, R>,
    pub(crate) wall_list: WallList<R>,
    /// Bodies that are membranes in some stage, and the indices of their grains in the order of ids; empty where grains have been reordered
    /// since the last list build.
    pub(crate) membranes: Vec<(u32, Vec<usize>)>,
    pub(crate) walls: Vec<RigidWall<D>>,
    /// Surfaces of the obstacles of the case, and their laws.
    pub(crate) obstacles: Vec<(Arc<dyn Surface<D>>, ObstacleLaws)>,
    pub(crate) scratch: StepBuffers<D, R>,
    pub(crate) since_list_build: SinceListBuild<D>,
    pub(crate) stage: usize,
    pub(crate) stage_start: f64,
    pub(crate) time: f64,
    pub(crate) step: u64,
    /// Length of the last step, zero at the start (s).
    pub(crate) last_step: f64,
    /// Speed of the fastest grain (m/s).
    pub(crate) max_speed: f64,
    /// Factor on the last step by deep Hertz contacts.
    pub(crate) deep_share: f64,
    /// Smallest and largest radius (m).
    pub(crate) radii: (f64, f64),
    pub(crate) energy_balance: EnergyBalance,
    /// Stress times volume of the last step (J): contact and kinetic part.
    pub(crate) virial: [Virial<D>; 2],
    /// Thickness of the Verlet skin (m).
    pub(crate) skin: f64,
    /// Imposed velocity gradient of the cell (1/s), in place of that of the stage.
    pub(crate) imposed_gradient: Option<[[f64; D]; D]>,
    /// Whether the scalar kernel is used even where a SIMD kernel could be.
    pub(crate) scalar_only: bool,
    /// Bodies whose grains enter during the run.
    pub(crate) sources: Vec<GrainSource>,
    /// Id of the next grain that enters.
    pub(crate) next_id: u32,
    /// Reports on the filling of bodies.
    pub(crate) specimens: Vec<Specimen>,
    /// Origin of the specimen from a file.
    pub(crate) specimen_source: SpecimenSource,
    /// Broken bonds: time (s) and ids of the grains.
    pub(crate) broken_bonds: Vec<BrokenBond>,
    /// Controlled stresses of the entries of the cell, row by row, and then of walls.
    pub(crate) controlled_stresses: Vec<ControlledStress>,
}

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Options of the present stage, if there are any.
    pub(crate) fn stage(&self) -> Option<&GrainStage> {
        self.options.stages.get(&self.case.stages[self.stage].name)
    }

    /// Options of the present stage, or the defaults.
    pub(crate) fn stage_options(&self) -> GrainStage {
        self.stage().cloned().unwrap_or_default()
    }

    /// Selects the scalar contact kernel, which the solver always uses for grains with attraction or bonds. The forces are
    /// equal to the last bit; sums over contacts of all grains are equal to round-off.
    pub fn use_scalar_contacts(&mut self) {
        self.scalar_only = true;
    }

    /// Selects the search in uniform cells, whatever the sizes of grains. The lists are equal.
    pub fn use_uniform_cells(&mut self) {
        self.lists.uniform_cells = true;
    }

    /// Takes a step of at most `at_most` (s).
    pub(crate) fn take_step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.critical_step();
        let dt = limit.limited_to(at_most);
        self.advance(dt)?;
        Ok(Advance { dt, limit: limit.limit })
    }

    /// Advances by a step of `dt` (s).
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        self.deep_share = self.deep_contact_factor();
        self.add_entering_grains();
        if self.is_stale() {
            self.build_lists()?;
        }
        self.impose_body_velocities(dt);
        self.find_forces(dt);
        self.check_overlap()?;
        let change = self.control(dt);
        self.update_servo_walls(dt);
        self.record_controlled_stresses(dt);
        self.move_grains(dt, change)?;
        self.move_boundaries(dt);
        self.time += dt;
        self.step += 1;
        self.last_step = dt;
        Ok(())
    }

    /// Imposes the velocities of rigid bodies that the stage prescribes.
    fn impose_body_velocities(&mut self, dt: f64) {
        let case = Arc::clone(&self.case);
        if !case.bodies.iter().any(|body| body.rigid) {
            return;
        }
        let elapsed = self.time + 0.5 * dt - self.stage_start;
        let motions = &case.stages[self.stage].motions;
        for (velocity, body) in self.grains.velocity.iter_mut().zip(&self.grains.body) {
            let body = &case.bodies[*body as usize];
            if body.rigid {
                let motion = motions.iter().find(|motion| motion.target == body.name);
                let prescribed = motion.map_or([None; 3], |motion| motion.velocity_at(elapsed));
                *velocity = std::array::from_fn(|c| prescribed[c].unwrap_or(0.0));
            }
        }
    }

    /// Computes the forces of all contacts from positions and the velocities half a step behind, before a step of `next` (s).
    pub(crate) fn find_forces(&mut self, next: f64) {
        let rate = self.stage_growth();
        self.find_facets();
        self.predict_velocities();
        self.cell.shifts(&mut self.scratch.shifts);
        // Unused lanes read the first grain.
        let single = self.grains.mass.is_empty() || self.scalar_only;
        let way = if single { ForceKernel::Scalar } else { ForceKernel::of(self.laws.pairs.iter()) };
        match way {
            ForceKernel::Scalar => self.lists.clear_active(),
            _ => self.select_active_pairs(),
        }
        let slabs = self.lists.slab_count();
        let StepBuffers { tallies, reactions, shifts, velocity, spin, records: lines, received, .. } =
            &mut self.scratch;
        tallies.clear();
        tallies.resize(slabs + 1, (ContactEnergies::default(), [[0.0; D]; D]));
        reactions.clear();
        reactions.resize(slabs * self.walls.len(), WallReaction::NONE);
        let (grains, (force, torque)) = self.grains.view_and_forces();
        let mut scene = ContactInput::new(grains, &self.laws.pairs, self.kinds.len());
        (scene.shifts, scene.growth) = (shifts, rate);
        (scene.dt, scene.next) = (self.last_step, next);
        scene.radii = self.options.lever_arm == LeverArm::Radius;
        if self.options.velocity == ContactVelocity::Predicted {
            (scene.velocity, scene.spin) = (velocity, spin);
        }
        scene.kernel = way;
        if !single {
            scene.plane_kernel = ForceKernel::of(self.walls.iter().flat_map(|wall| &wall.laws));
        }
        grain_records(grains, (scene.velocity, scene.spin), (&mut *lines, &mut *received));
        scene.records = (&lines.place, &lines.motion);
        scene.contacts(&mut self.lists, received, tallies);
        scatter_forces(received, grains.radius, (&mut *force, &mut *torque));
        let WallList { grain, wall, slabs: of_slabs, memory, facet, .. } = &mut self.wall_list;
        if !grain.is_empty() {
            let view = WallListView { grain, wall, slabs: of_slabs, facet };
            let list = (&view, self.lists.slabs.as_slice());
            scene.wall_forces(
                &self.walls,
                list,
                memory.view(),
                (force, torque),
                &mut tallies[..slabs],
                reactions,
            );
        }
        self.sum_up();
    }

    /// Adds up the sums of all slabs, in their order.
    fn sum_up(&mut self) {
        let (mut tally, mut virial) = (ContactEnergies::default(), [[0.0; D]; D]);
        for (own, part) in &self.scratch.tallies {
            tally.add(own);
            for (row, more) in virial.iter_mut().zip(part) {
                add(row, 1.0, more);
            }
        }
        self.virial[0] = virial;
        let count = self.walls.len();
        for (number, wall) in self.walls.iter_mut().enumerate() {
            let (mut force, mut moment) = ([0.0; D], [0.0; 3]);
            for part in self.scratch.reactions.iter().skip(number).step_by(count) {
                add(&mut force, 1.0, &part.force);
                add(&mut moment, 1.0, &part.moment);
            }
            wall.moment = moment;
            let before = std::mem::replace(&mut wall.reaction[0], force);
            // Mean of the forces at both ends of the displacement. Its sum is that of the kicks, over half of the steps before and after.
            let mean: [f64; D] = std::array::from_fn(|c| 0.5 * (before[c] + force[c]));
            if wall.surface.is_none() {
                tally.boundary -= dot(&mean, &wall.velocity) * self.last_step;
            }
            add(&mut wall.reaction[1], self.last_step, &mean);
        }
        self.energy_balance.add_contacts(&tally);
        if tally.bonds_broken > 0 {
            self.record_broken_bonds();
        }
    }

    /// Records the bonds that broke.
    fn record_broken_bonds(&mut self) {
        for pairs in [&mut self.lists.slab_pairs, &mut self.lists.periodic_pairs] {
            for i in 0..self.grains.len() {
                for k in pairs.starts[i] as usize..pairs.starts[i + 1] as usize {
                    let bond = &mut pairs.histories.bond[k];
                    if bond.strength < 0.0 {
                        bond.strength = 0.0;
                        let (grains, other) = (&self.grains, pairs.other[k] as usize);
                        let across = pairs.image.get(k).is_some_and(|image| *image != 0);
                        let (x, y) = (&grains.position[i], &grains.position[if across { i } else { other }]);
                        self.broken_bonds.push(BrokenBond {
                            time: self.time,
                            ids: [grains.id[i], grains.id[other]],
                            place: spatial(&std::array::from_fn::<f64, D, _>(|c| 0.5 * (x[c] + y[c]))),
                        });
                    }
                }
            }
        }
    }

    /// Predicts velocities half a step ahead with the last forces.
    fn predict_velocities(&mut self) {
        if self.options.velocity != ContactVelocity::Predicted {
            return;
        }
        let (gravity, applied) = (self.gravity_at(0.0), self.applied());
        let (half, grains) = (0.5 * self.last_step, &self.grains);
        self.scratch.velocity.clone_from(&grains.velocity);
        self.scratch.spin.clone_from(&grains.spin);
        for i in (0..grains.len()).filter(|&i| !grains.held[i]) {
            add(&mut self.scratch.velocity[i], half / grains.mass[i], &grains.force[i]);
            add(&mut self.scratch.velocity[i], half, &gravity);
            if let Some(applied) = applied.get(i) {
                add(&mut self.scratch.velocity[i], half / grains.mass[i], applied);
            }
            add(&mut self.scratch.spin[i], half / grains.inertia(i), &grains.torque[i]);
        }
    }

    fn check_overlap(&self) -> Result<(), SolverError> {
        if self.energy_balance.overlap <= MAX_OVERLAP {
            return Ok(());
        }
        let deepest =
            self.scratch.tallies.iter().find(|(tally, _)| tally.overlap == self.energy_balance.overlap);
        let grain = deepest.map_or(0, |(tally, _)| tally.max_overlap_grain as usize);
        let reason = format!(
            "overlaps another grain or a wall by {:.2} of the smaller radius, more than {MAX_OVERLAP}: make contacts stiffer or \
             speeds smaller",
            self.energy_balance.overlap
        );
        Err(self.grain_error(grain, reason))
    }

    /// Gravity at time `ahead` from now (m/s²).
    pub(crate) fn gravity_at(&self, ahead: f64) -> [f64; D] {
        let stage = &self.case.stages[self.stage];
        let own = self.stage();
        let gravity = spatial(own.and_then(|options| options.gravity.as_ref()).unwrap_or(&self.case.gravity));
        let elapsed = self.time + ahead - self.stage_start;
        let factor = stage.gravity_factor(elapsed);
        let mut gravity: [f64; D] = std::array::from_fn(|c| factor * gravity[c]);
        if let Some(shaking) = own.and_then(|options| options.shaking.as_ref()) {
            let shaken: [f64; D] = std::array::from_fn(|c| shaking.acceleration[c]);
            add(&mut gravity, shaking.factor(elapsed, stage.duration), &shaken);
        }
        gravity
    }

    fn move_grains(&mut self, dt: f64, change: [[f64; D]; D]) -> Result<(), SolverError> {
        let stage = &self.case.stages[self.stage];
        let options = self.stage();
        let moves = self.cell.is_periodic() && (self.cell.is_deforming() || change != [[0.0; D]; D]);
        let mut next = self.cell;
        for (row, more) in next.velocity_gradient.iter_mut().zip(&change) {
            add(row, 1.0, more);
        }
        let rate = self.cell.velocity_gradient;
        next.advance(dt);
        let carried = self
            .since_list_build
            .cell
            .filter(|_| moves)
            .map(|then| (product(&next.h, &inverse(&then).0), self.cell.origin));
        let applied = self.applied();
        let drive = ExternalActions {
            dt,
            last_step: self.last_step,
            gravity: self.gravity_at(0.0),
            applied: &applied,
            damping: stage.damping_of_axes(),
            form: options.map_or_else(Default::default, |options| options.damping_form),
            viscous: stage.rayleigh_damping,
            rate: moves.then_some(rate),
            cell_map: carried,
            gradient_change: moves.then_some((change, self.cell.origin)),
        };
        let sums = integrate_grains(&mut self.grains, &drive, &mut self.scratch.sums);
        if let Some(grain) = sums.lost {
            return Err(self.grain_error(grain as usize, "its place or velocity is not finite".to_owned()));
        }
        for (orientation, spin) in self.grains.orientation.iter_mut().zip(&self.grains.spin) {
            rotate(orientation, spin, dt);
        }
        let kick = 0.5 * (self.last_step + dt);
        self.energy_balance.add_grains(&sums, 0.5 * self.last_step / kick);
        self.virial[1] = sums.kinetic_stress.map(|row| row.map(|value| -value));
        self.max_speed = sums.max_speed_squared.sqrt();
        self.since_list_build.grain_travel = sums.max_travel_squared.sqrt();
        self.cell = next;
        self.grow(dt);
        Ok(())
    }

    fn move_boundaries(&mut self, dt: f64) {
        let mut fastest = 0.0f64;
        for wall in &mut self.walls {
            let speed = wall.velocity[wall.axis];
            wall.position += speed * dt;
            fastest = fastest.max(speed.abs());
        }
        let mut way = fastest * dt;
        for moving in self.walls.iter_mut().filter_map(|wall| wall.moving.as_mut()) {
            way = way.max(moving.max_displacement(self.time, self.time + dt));
            moving.move_to(self.time + dt);
            moving.set_mean_velocity(self.time + dt, dt);
        }
        self.since_list_build.wall_travel += way;
    }

    fn stage_growth(&self) -> f64 {
        let Some(options) = self.stage() else { return 0.0 };
        let stops = options.growth != 0.0 && options.grow_until.is_some_and(|most| self.pressure() >= most);
        if stops { 0.0 } else { options.growth }
    }

    /// Grows radii and masses in a step of `dt` (s).
    fn grow(&mut self, dt: f64) {
        let rate = self.stage_growth();
        if rate == 0.0 {
            return;
        }
        let factor = 1.0 + rate * dt;
        let Grains { radius, mass, held, .. } = &mut self.grains;
        for ((radius, mass), _) in radius.iter_mut().zip(mass).zip(held).filter(|(_, held)| !**held) {
            *radius *= factor;
            *mass *= factor.powi(D as i32);
        }
        self.radii = self.grains.radii();
        self.since_list_build.wall_travel += 2.0 * rate.abs() * dt * self.radii.1;
    }

    pub(crate) fn grain_error(&self, grain: usize, reason: String) -> SolverError {
        SolverError::Point {
            step: self.step,
            time: self.time,
            point: u64::from(self.grains.id.get(grain).copied().unwrap_or(0)),
            position: self.grains.position.get(grain).map_or([0.0; 3], |x| spatial(x)),
            reason,
        }
    }
}
