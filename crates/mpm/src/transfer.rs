//! The transfers between points and grid, and what happens at the points in between.

use std::sync::atomic::Ordering;

use colluvium_case::SolverError;
use colluvium_constitutive::{BLOCK, Motion, SymTensor};
use colluvium_grid::{Basis, Corners, Lanes, Support};

use crate::affine::{affine_momentum, momentum};
use crate::blocks::{Block, BlockReport, Failure, OfSet};
use crate::config::Formulation;
use crate::contact::three;
use crate::dual::share;
use crate::points::{LEAST_VOLUME, PointDomain, ground};
use crate::solver::MpmSolver;
use crate::strain::set_volumetric;
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

/// A vector and a fourth number.
#[inline(always)]
pub fn lanes<const D: usize>(vector: &[f64; D], fourth: f64) -> Lanes {
    let at = |c: usize| if c < D { vector[c] } else { 0.0 };
    Lanes::new([at(0), at(1), at(2), fourth])
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

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Point to grid (step 1), slab by slab.
    pub(crate) fn scatter(&mut self, what: Scatter, dt: f64) {
        self.apply_loads(dt);
        if what != Scatter::Motion {
            self.average_stresses();
        }
        self.share_stresses();
        if what != Scatter::Forces {
            self.scatter_surfaces();
        }
        let strides = self.layout.strides();
        let (sets, ground, axisymmetric) = (&self.sets, ground!(self), self.axisymmetric);
        let (transfer, cells) = (self.options.transfer, self.cell_layout().len());
        // Of linear functions only.
        let dual = S == 2 && self.dual.is_used();
        let affine = self.options.transfer.is_affine() && what != Scatter::Forces;
        let of_field = |field: usize| sets.iter().filter(move |set| set.field == field);
        for (field, nodes) in self.nodes.chunks_exact_mut(self.layout.len()).enumerate() {
            let full = self.stresses.full_cells(field, cells);
            self.layout.scatter(nodes, |slab, window, offset| {
                for set in of_field(field) {
                    for p in set.slabs[slab]..set.slabs[slab + 1] {
                        let stencil = set.domain[p].support::<S, B>(&ground, &set.position[p], &set.extent);
                        let mass = if what == Scatter::Forces { 0.0 } else { set.mass[p] };
                        let motion = lanes(&set.velocity[p], 1.0) * mass;
                        let left_to_cell = full.is_some_and(|full| {
                            full[set.domain[p].cell::<S, B>(&ground, &strides, &set.position[p])]
                        });
                        let pulls = what != Scatter::Motion && !left_to_cell;
                        let volume = if pulls { set.volume[p] } else { 0.0 };
                        let own = if dual { share(ground.grid, &set.position[p]) } else { 1.0 };
                        let columns = force_columns::<D>(&set.stress[p], own * volume);
                        let mut body = None;
                        if axisymmetric {
                            let hoop = -volume * set.stress[p][2] / set.position[p][0];
                            body = Some(Lanes::new([hoop, 0.0, 0.0, 0.0]));
                        }
                        if !set.traction.is_empty() && what != Scatter::Motion {
                            body = Some(body.unwrap_or(Lanes::ZERO) + lanes(&set.traction[p], 0.0));
                        }
                        stencil.deposit(window, offset, &strides, motion, &columns, body);
                        if affine {
                            let (moments, columns) =
                                affine_momentum::<D, S, B, P>(transfer, ground.grid, set, p, &stencil);
                            moments.deposit_slopes(window, offset, &strides, Lanes::ZERO, &columns, momentum);
                        }
                    }
                }
            });
            self.layout.fold(nodes, |sum, node| {
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
        let strides = self.layout.strides();
        let (sets, ground, transfer) = (&self.sets, ground!(self), self.options.transfer);
        let of_field = |field: usize| sets.iter().filter(move |set| set.field == field);
        for (field, nodes) in self.remapped.chunks_exact_mut(self.layout.len()).enumerate() {
            self.layout.scatter(nodes, |slab, window, offset| {
                for set in of_field(field) {
                    for p in set.slabs[slab]..set.slabs[slab + 1] {
                        let stencil = set.domain[p].support::<S, B>(&ground, &set.position[p], &set.extent);
                        let momentum = lanes(&set.velocity[p], 0.0) * set.mass[p];
                        stencil.deposit_motion(window, offset, &strides, momentum);
                        if transfer.is_affine() {
                            let (moments, columns) =
                                affine_momentum::<D, S, B, P>(transfer, ground.grid, set, p, &stencil);
                            moments
                                .deposit_slopes(window, offset, &strides, Lanes::ZERO, &columns, |node| node);
                        }
                    }
                }
            });
            self.layout.fold(nodes, |sum, node| *sum += *node);
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
        let (nodes, walls, layout) = (&self.nodes, &self.walls, &self.layout);
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

    #[inline]
    fn update_block<const FROM_SOLVED: bool>(
        &self,
        set: &OfSet<'_, D>,
        block: &mut Block<'_, D, P>,
        dt: f64,
        what: PointUpdate,
    ) -> BlockReport {
        let (strides, ground, extent) = (self.layout.strides(), ground!(self), &set.extent);
        let flip = self.flip;
        let first_node = set.field * self.layout.len();
        let mut moves = [Moved::default(); BLOCK];
        let mut motions = [still(dt, extent[0]); BLOCK];
        let n = block.position.len();
        let dual = S == 2 && what.stress && self.dual.is_used();
        for p in 0..n {
            let stencil = block.domain[p].support::<S, B>(&ground, &block.position[p], extent);
            let mut read = if FROM_SOLVED {
                stencil.gather(&self.nodes[first_node..], &strides)
            } else {
                stencil.gather_velocity(&self.remapped[first_node..], &strides)
            };
            if dual {
                self.dual.blend(set.field, &self.grid, &self.layout, &block.position[p], &mut read.gradient);
            }
            let velocity = read.velocity.to_array();
            if what.velocity {
                let acceleration = read.acceleration.to_array();
                for c in 0..D {
                    let v = &mut block.velocity[p][c];
                    *v = flip * (*v + dt * acceleration[c]) + (1.0 - flip) * velocity[c];
                }
            }
            if what.stress {
                let radius = block.position[p][0];
                let mut motion = still(dt, extent[0]);
                self.set_gradient(&mut motion, &read.gradient, velocity[0], radius);
                if self.strains.is_shared() {
                    let shared = self.shared_strain(set.body, &block.domain[p], &block.position[p]);
                    set_volumetric(&mut motion, self.normal_strains(), shared[0]);
                }
                let stretch = motion.deformation.determinant();
                // Written so that NaN counts as a failure.
                if !(stretch > 0.0) {
                    let reason = format!("the step would turn it inside out (volume ratio {stretch})");
                    return Err(Failure { index: block.first + p, reason });
                }
                block.volume[p] *= stretch;
                motion.density = block.mass[p] / block.volume[p];
                let gradient: [[f64; D]; D] =
                    std::array::from_fn(|i| std::array::from_fn(|j| motion.gradient.0[i][j]));
                motions[p] = motion;
                block.stretch(p, &gradient);
                if let Some(reason) = block.domain[p].fault(extent, self.grid.cell) {
                    return Err(Failure { index: block.first + p, reason });
                }
            }
            if what.position {
                block.stretch_at_last(p);
                if P::CONVECTED {
                    let own = std::array::from_fn(|c| velocity[c]);
                    block.domain[p].convect(&block.position[p], extent, &own, dt, |place| {
                        let velocity = Corners::at(&self.grid, place, |number| {
                            if FROM_SOLVED {
                                self.nodes[first_node + number].motion
                            } else {
                                self.remapped[first_node + number]
                            }
                        });
                        std::array::from_fn(|c| velocity.as_array()[c])
                    });
                }
                moves[p] = self.move_point(block, p, &velocity, dt);
            }
        }
        let moved = if what.position { self.settle(set, block, &moves)? } else { 0.0 };
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
        if self.axisymmetric {
            let hoop = motion.dt * radial / radius;
            motion.gradient.0[2][2] = hoop;
            motion.deformation.0[2][2] = 1.0 + hoop;
        }
    }

    /// A point without stress does not grow beyond the cap, and none shrinks below a tenth (MPM sheet §2.8, pitfall P-09).
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
        block: &mut Block<'_, D, P>,
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
        block: &mut Block<'_, D, P>,
        moves: &[Moved],
    ) -> BlockReport {
        let ground = ground!(self);
        let mut moved = 0f64;
        let points = block.position.iter_mut().zip(block.domain.iter_mut());
        for (p, ((position, domain), Moved { step, radius })) in points.zip(moves).enumerate() {
            let fail = |reason| Failure { index: block.first + p, reason };
            // Written so that NaN counts as a failure.
            if !(*step <= 0.5 * domain.spacing(&ground)) {
                return Err(fail(format!(
                    "it would move {step:.3e} m in one step, more than half a cell or element: the run has become \
                     unstable (reduce courant or time_step)"
                )));
            }
            if self.axisymmetric && !P::ANCHORED {
                // Its domain does not reach over the axis, where its hoop strain has no bound (pitfall P-26).
                let least = 0.5 * domain.extent(&set.extent, self.grid.cell)[0];
                position[0] = position[0].max(least.min(*radius));
            }
            let settled = if P::MESHED {
                domain.settle(&ground, position)
            } else if !P::ANCHORED && !self.grid.contains(position) {
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
            moved = moved.max(if P::ANCHORED { 0.0 } else { *step });
        }
        Ok(moved)
    }

    /// Puts a point that is beyond walls on sides of the domain back onto them.
    fn put_back(&self, position: &mut [f64; D]) -> Result<(), String> {
        for axis in (0..D).filter(|axis| !self.periodic[*axis]) {
            let (low, high) = (self.grid.origin[axis], self.upper[axis]);
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
