//! The transfers between points and grid, and what happens at the points in between.

use std::ops::Range;
use std::sync::atomic::Ordering;

use colluvium_case::SolverError;
use colluvium_constitutive::{BLOCK, Motion, SymTensor};
use colluvium_grid::{Affine, Deposit, Gathered, Lanes, Window};

use crate::Transfer;
use crate::background::Background;
use crate::blocks::{Block, BlockReport, Failure, OfSet};
use crate::config::Formulation;
use crate::dual::share;
use crate::points::{LEAST_VOLUME, PointSet};
use crate::solver::MpmSolver;
use crate::strain::set_volumetric;
use crate::vectors::{lanes, three};
use crate::work::Before;

/// What a scatter carries to the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scatter {
    /// Mass, momentum and forces.
    Everything,
    /// Mass and momentum.
    Motion,
    /// Forces.
    Forces,
}

/// Points read the solved nodes: velocity at the end of the step and acceleration.
pub const SOLVED: bool = true;
/// Points read re-mapped (or start-of-step) velocities.
pub const REMAPPED: bool = false;

/// What changes at the points in a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PointUpdate {
    /// Velocities.
    pub velocity: bool,
    /// Deformation, volume, stress and state.
    pub stress: bool,
    /// Positions.
    pub position: bool,
}

/// How a point has moved in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moved {
    /// Largest move along an axis (m).
    pub step: f64,
    /// First coordinate of where it was (m).
    pub radius: f64,
}

impl PointUpdate {
    /// Nothing changes.
    pub const NONE: Self = Self { velocity: false, stress: false, position: false };
}

/// `columns[j] = -V σ e_j`.
#[inline(always)]
pub fn force_columns<const D: usize>(stress: &SymTensor, volume: f64) -> [Lanes; D] {
    let s = &stress.0;
    let columns = [
        Lanes::new([s[0], s[3], s[5], 0.0]),
        Lanes::new([s[3], s[1], s[4], 0.0]),
        Lanes::new([s[5], s[4], s[2], 0.0]),
    ];
    let mut mask = [0.0; 4];
    mask[..D].fill(-volume);
    let scale = Lanes::new(mask);
    std::array::from_fn(|j| columns[j] * scale)
}

/// No motion of a point of some width (m) in a step (s).
#[inline(always)]
pub fn still(dt: f64, size: f64) -> Motion {
    Motion { dt, size, ..Motion::STILL }
}

/// Adds to the nodes of a field `N` times what `of` finds at each point of its bodies, and what the affine fields of `transfer`
/// add to momenta.
pub fn deposit_of<const D: usize>(
    background: &Background<D>,
    sets: &[PointSet<D>],
    field: usize,
    nodes: &mut [Lanes],
    of: &(dyn Fn(&PointSet<D>, usize) -> Lanes + Sync),
    transfer: Transfer,
) {
    let ground = background.ground();
    background.layout.scatter(nodes, |slab, window, offset| {
        let mut values = [Lanes::ZERO; BLOCK];
        for set in sets.iter().filter(|set| set.field == field) {
            for block in set.blocks_of(slab) {
                block.clone().zip(&mut values).for_each(|(p, value)| *value = of(set, p));
                let to = Window { nodes: &mut *window, first: offset };
                let affine = affine_of(transfer, set, block.clone());
                let values = &values[..block.len()];
                background.sweeps.deposit_values(&ground, &set.points().range(block), to, values, affine);
            }
        }
    });
}

/// What a block of points gives to the nodes in one phase.
struct Given<const D: usize> {
    motion: [Lanes; BLOCK],
    columns: [[Lanes; D]; BLOCK],
    body: [Lanes; BLOCK],
}

impl<const D: usize> Given<D> {
    const NOTHING: Self =
        Self { motion: [Lanes::ZERO; BLOCK], columns: [[Lanes::ZERO; D]; BLOCK], body: [Lanes::ZERO; BLOCK] };
}

/// What the points of a set carry of the affine velocity fields around them, where the transfer asks for it.
fn affine_of<const D: usize>(
    transfer: Transfer,
    set: &PointSet<D>,
    points: Range<usize>,
) -> Option<Affine<'_, D>> {
    let fields = || &set.affine[points.clone()];
    let moments = transfer == Transfer::Apic;
    transfer.is_affine().then(|| Affine { moments, fields: fields(), mass: &set.mass[points.clone()] })
}

impl<const D: usize> MpmSolver<D> {
    /// Point to grid (step 1), slab by slab.
    pub(crate) fn scatter(&mut self, what: Scatter, dt: f64) {
        self.apply_loads(dt);
        if what != Scatter::Motion {
            self.press(dt);
            self.average_stresses();
        }
        self.share_stresses();
        if what != Scatter::Forces {
            self.scatter_surfaces();
        }
        let Background { layout, sweeps, axisymmetric, grid, .. } = &self.background;
        let (sets, ground, axisymmetric) = (&self.sets, self.background.ground(), *axisymmetric);
        let (transfer, cells) = (self.options.transfer, self.background.cell_layout().len());
        let dual = self.dual.is_used();
        let of_field = |field: usize| sets.iter().filter(move |set| set.field == field);
        for (field, nodes) in self.nodes.chunks_exact_mut(layout.len()).enumerate() {
            let full = self.stresses.full_cells(field, cells);
            layout.scatter(nodes, |slab, window, offset| {
                let mut given = Given::NOTHING;
                for set in of_field(field) {
                    let domain = set.domain.as_slice();
                    let loaded = !set.traction.is_empty() && what != Scatter::Motion;
                    let pressed = !set.pressed.is_empty() && what != Scatter::Motion;
                    for block in set.blocks_of(slab) {
                        for (k, p) in block.clone().enumerate() {
                            let mass = if what == Scatter::Forces { 0.0 } else { set.mass[p] };
                            given.motion[k] = lanes(&set.velocity[p], 1.0) * mass;
                            let left_to_cell =
                                full.is_some_and(|full| full[domain.cell(p, &ground, &set.position[p])]);
                            let pulls = what != Scatter::Motion && !left_to_cell;
                            let volume = if pulls { set.volume[p] } else { 0.0 };
                            let own = if dual { share(grid, &set.position[p]) } else { 1.0 };
                            given.columns[k] = force_columns::<D>(&set.stress[p], own * volume);
                            if axisymmetric {
                                let hoop = -volume * set.stress[p][2] / set.position[p][0];
                                given.body[k] = Lanes::new([hoop, 0.0, 0.0, 0.0]);
                            } else {
                                given.body[k] = Lanes::ZERO;
                            }
                            if loaded {
                                given.body[k] += lanes(&set.traction[p], 0.0);
                            }
                            if pressed {
                                given.body[k] += lanes(&set.pressed[p].force, 0.0);
                            }
                        }
                        let count = block.len();
                        let deposit = Deposit {
                            motion: &given.motion[..count],
                            columns: &given.columns[..count],
                            body: if axisymmetric || loaded || pressed { &given.body[..count] } else { &[] },
                            affine: affine_of(transfer, set, block.clone())
                                .filter(|_| what != Scatter::Forces),
                        };
                        let to = Window { nodes: &mut *window, first: offset };
                        sweeps.deposit(&ground, &set.points().range(block), to, &deposit);
                    }
                }
            });
            layout.fold(nodes, |sum, node| {
                if what != Scatter::Forces {
                    sum.motion += node.motion;
                }
                if what != Scatter::Motion {
                    sum.force += node.force;
                }
            });
        }
        if what != Scatter::Motion {
            self.pull_with_cells();
            self.pull_with_nodes();
            self.load_nodes(dt);
        }
    }

    /// Maps the updated velocities of the points back to the nodes (MUSL, step 6), walls included.
    pub(crate) fn remap(&mut self) {
        self.reset_remapped();
        let transfer = self.options.transfer;
        let of = |set: &PointSet<D>, p: usize| lanes(&set.velocity[p], 0.0) * set.mass[p];
        let len = self.background.layout.len();
        for (field, nodes) in self.remapped.chunks_exact_mut(len).enumerate() {
            deposit_of(&self.background, &self.sets, field, nodes, &of, transfer);
            self.background.layout.fold(nodes, |sum, node| *sum += *node);
        }
        self.velocities_of_remapped(false);
    }

    /// Velocities at the start of the step (USF), walls included.
    pub(crate) fn start_velocities(&mut self) {
        for (velocity, node) in self.remapped.iter_mut().zip(&self.nodes) {
            *velocity = node.motion;
        }
        self.velocities_of_remapped(true);
    }

    /// Divides re-mapped momenta by mass and applies the walls. With `start` the nodes still hold
    /// momenta, else they hold the solved velocities; mass is in their fourth lane either way.
    fn velocities_of_remapped(&mut self, start: bool) {
        let (nodes, walls, layout) = (&self.nodes, &self.walls, &self.background.layout);
        let row_length = layout.strides()[0];
        let fields = self.remapped.chunks_exact_mut(layout.len()).zip(nodes.chunks_exact(layout.len()));
        for (remapped, nodes) in fields {
            layout.each(remapped, |row, active, line| {
                for number in active {
                    let node = &nodes[row * row_length + number];
                    let mass = node.motion.as_array()[3];
                    if mass <= 0.0 {
                        line[number] = Lanes::ZERO;
                        continue;
                    }
                    line[number] *= 1.0 / mass;
                    let solved = if start { Lanes::splat(f64::NAN) } else { node.motion };
                    let mut velocity = three(line[number]);
                    walls.constrain_again(&layout.index(row, number), &three(solved), &mut velocity);
                    line[number] = lanes(&velocity, 0.0);
                }
            });
        }
        if !start {
            self.touch_again();
        }
        self.hold_patches_again();
    }

    /// Grid to point (steps 5, 7–9); returns the largest move along an axis (m).
    pub(crate) fn update_points<const FROM_SOLVED: bool>(
        &mut self,
        dt: f64,
        what: PointUpdate,
    ) -> Result<f64, SolverError> {
        if what.stress {
            self.average_slopes::<FROM_SOLVED>();
        }
        self.update_blocks(|solver, set, block| solver.update_block::<FROM_SOLVED>(set, block, dt, what))
    }

    fn update_block<const FROM_SOLVED: bool>(
        &self,
        set: &OfSet<'_, D>,
        block: &mut Block<'_, D>,
        dt: f64,
        what: PointUpdate,
    ) -> BlockReport {
        let Background { grid, layout, sweeps, .. } = &self.background;
        let (ground, extent, n) = (self.background.ground(), &set.extent, block.position.len());
        let flip = self.flip;
        let first_node = set.field * layout.len();
        let mut all = [Gathered::ZERO; BLOCK];
        let reads = &mut all[..n];
        if FROM_SOLVED {
            sweeps.gather(&ground, &block.points(extent), &self.nodes[first_node..], reads);
        } else {
            sweeps.gather_velocity(&ground, &block.points(extent), &self.remapped[first_node..], reads);
        }
        if what.velocity {
            for (own, read) in block.velocity.iter_mut().zip(&*reads) {
                let (velocity, acceleration) = (read.velocity.as_array(), read.acceleration.as_array());
                for c in 0..D {
                    own[c] = flip * (own[c] + dt * acceleration[c]) + (1.0 - flip) * velocity[c];
                }
            }
        }
        if what.stress && self.dual.is_used() {
            for (read, position) in reads.iter_mut().zip(&*block.position) {
                self.dual.blend(set.field, grid, layout, position, &mut read.gradient);
            }
        }
        let mut motions = [still(dt, extent[0]); BLOCK];
        if what.stress {
            self.deform(set, block, reads, &mut motions[..n])?;
        }
        let moved = if what.position {
            block.stretch_at_last();
            let velocity = |p: usize| std::array::from_fn(|c| reads[p].velocity.as_array()[c]);
            block.domain.convect(&ground, block.position, extent, velocity, dt, |number| {
                if FROM_SOLVED {
                    self.nodes[first_node + number].motion
                } else {
                    self.remapped[first_node + number]
                }
            });
            let mut moves = [Moved::default(); BLOCK];
            for (p, read) in reads.iter().enumerate() {
                moves[p] = self.move_point(block, p, read.velocity.as_array(), dt);
            }
            self.settle(set, block, &moves)?
        } else {
            0.0
        };
        if what.stress {
            let before = (!block.work.is_empty()).then(|| Before::of(block.stress));
            set.material.update(&motions[..n], block.stress, &mut block.states[0]).map_err(|error| {
                Failure { index: block.first + error.index, reason: error.source.to_string() }
            })?;
            if let Some(before) = before {
                before.add_work(&motions[..n], block.stress, block.volume, block.work);
            }
            self.cap_volumes(block.volume, block.initial_volume, block.stress);
        }
        Ok(moved)
    }

    /// Motions, volumes and domains of a block from what its points have read (steps 7, 8).
    #[inline]
    fn deform(
        &self,
        set: &OfSet<'_, D>,
        block: &mut Block<'_, D>,
        reads: &[Gathered<D>],
        motions: &mut [Motion],
    ) -> Result<(), Failure> {
        let mut gradients = [[[0.0; D]; D]; BLOCK];
        let mut failure = None;
        for (p, (read, motion)) in reads.iter().zip(&mut *motions).enumerate() {
            let radius = block.position[p][0];
            self.set_gradient(motion, &read.gradient, read.velocity.as_array()[0], radius);
            if self.strains.is_shared() {
                let shared = self.shared_strain(set.body, &block.points(&set.extent), p);
                set_volumetric(motion, self.background.normal_strains(), shared[0]);
            }
            let stretch = motion.deformation.determinant();
            // Written so that NaN counts as a failure.
            if !(stretch > 0.0) {
                let reason = format!("the step would turn it inside out (volume ratio {stretch})");
                failure = Some(Failure { index: block.first + p, reason });
                break;
            }
            block.volume[p] *= stretch;
            motion.density = block.mass[p] / block.volume[p];
            gradients[p] = std::array::from_fn(|i| std::array::from_fn(|j| motion.gradient.0[i][j]));
        }
        block.stretch(&gradients[..reads.len()]);
        block.refuse(failure, &set.extent, self.background.grid.cell)
    }

    /// Motion of the step from the columns of the velocity gradient.
    #[inline(always)]
    pub(crate) fn set_gradient(&self, motion: &mut Motion, columns: &[Lanes; D], radial: f64, radius: f64) {
        for (j, column) in columns.iter().enumerate() {
            let column = (*column * motion.dt).to_array();
            for i in 0..D {
                motion.gradient.0[i][j] = column[i];
                motion.deformation.0[i][j] = column[i] + if i == j { 1.0 } else { 0.0 };
            }
        }
        if self.background.axisymmetric {
            let hoop = motion.dt * radial / radius;
            motion.gradient.0[2][2] = hoop;
            motion.deformation.0[2][2] = 1.0 + hoop;
        }
    }

    /// A point without stress does not grow beyond the cap, and none shrinks below a tenth (sheet: mpm §2.8, pitfall P-09).
    #[inline]
    pub(crate) fn cap_volumes(&self, volumes: &mut [f64], initial: &[f64], stresses: &[SymTensor]) {
        let cap = self.options.volume_cap;
        for ((volume, initial), stress) in volumes.iter_mut().zip(initial).zip(stresses) {
            let largest = cap * initial;
            if *volume > largest && stress.0 == [0.0; 6] {
                *volume = largest;
            }
            *volume = volume.max(LEAST_VOLUME * initial);
        }
    }

    /// Moves a point with `velocity` (m/s), or what its displacement is counted from where points keep their places.
    #[inline(always)]
    pub(crate) fn move_point(
        &self,
        block: &mut Block<'_, D>,
        p: usize,
        velocity: &[f64; 4],
        dt: f64,
    ) -> Moved {
        let step = velocity[..D].iter().fold(0f64, |step, v| step.max((dt * v).abs()));
        let radius = block.position[p][0];
        if self.options.formulation == Formulation::SmallDisplacement {
            (0..D).for_each(|c| block.origin[p][c] -= dt * velocity[c]);
        } else {
            (0..D).for_each(|c| block.position[p][c] += dt * velocity[c]);
        }
        Moved { step, radius }
    }

    /// Looks at where the points of a block have come: refuses moves that cannot be right, keeps them off the axis, puts back
    /// what round-off carried through a wall on a side of the domain, and leaves those without a place (NaN) that have left a
    /// body which lets them. Returns the largest move along an axis (m).
    #[inline(never)]
    pub(crate) fn settle(
        &self,
        set: &OfSet<'_, D>,
        block: &mut Block<'_, D>,
        moves: &[Moved],
    ) -> BlockReport {
        let (ground, cell) = (self.background.ground(), self.background.grid.cell);
        let mut moved = 0f64;
        for (p, (position, Moved { step, radius })) in block.position.iter_mut().zip(moves).enumerate() {
            let domain = block.domain.as_slice();
            let fail = |reason| Failure { index: block.first + p, reason };
            // Written so that NaN counts as a failure.
            if !(*step <= 0.5 * domain.spacing(p, &ground)) {
                return Err(fail(format!(
                    "it would move {step:.3e} m in one step, more than half a cell or element: the run has become \
                     unstable (reduce courant or time_step)"
                )));
            }
            if self.background.axisymmetric && !set.anchored {
                // Its domain does not reach over the axis, where its hoop strain has no bound (pitfall P-26).
                let least = 0.5 * domain.extent(p, &set.extent, cell)[0];
                position[0] = position[0].max(least.min(*radius));
            }
            let settled = if self.background.is_meshed() {
                block.domain.settle(p, &ground, position)
            } else if !set.anchored && !self.background.grid.contains(position) {
                self.put_back(position)
            } else {
                Ok(())
            };
            match settled {
                Err(_) if set.drop_outside => {
                    position.fill(f64::NAN);
                    self.left.store(true, Ordering::Relaxed);
                }
                settled => settled.map_err(fail)?,
            }
            moved = moved.max(if set.anchored { 0.0 } else { *step });
        }
        Ok(moved)
    }

    /// Puts a point that is beyond walls on sides of the domain back onto them.
    fn put_back(&self, position: &mut [f64; D]) -> Result<(), String> {
        for axis in (0..D).filter(|axis| !self.background.periodic[*axis]) {
            let (low, high) = (self.background.grid.origin[axis], self.background.upper[axis]);
            if (position[axis] < low && !self.closed[axis][0])
                || (position[axis] > high && !self.closed[axis][1])
            {
                let reason = "it left the domain: enlarge the domain, add a wall on that side or let the body drop_outside";
                return Err(reason.to_owned());
            }
            position[axis] = position[axis].clamp(low, high);
        }
        Ok(())
    }
}
