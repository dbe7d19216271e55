//! Extended PIC (Hammerquist & Nairn 2017; MPM sheet §2.6).
//!
//! With `S⁺` from points to grid and `S` back, XPIC(m) takes from the points what `m` sweeps cannot represent:
//! `V ← V - (I - S S⁺)^m V + Δt S a`. The first sweep is the grid's velocity at the start of the step, which the
//! momentum solve leaves behind; each further order is one sweep over points and grid.

use colluvium_grid::{Basis, Lanes, Support};

use crate::points::{Ground, PointDomain, PointSet, for_each_point, ground};
use crate::solver::MpmSolver;

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Takes `(I - S S⁺)^m V` from the velocities of the points; the update with `Δt S a` is that of FLIP.
    pub(crate) fn filter_velocities(&mut self, dt: f64) {
        let (layout, nodes_per_field, ground) = (&self.layout, self.layout.len(), ground!(self));
        for set in &mut self.sets {
            set.scratch.copy_from_slice(&set.velocity);
            let nodes = &self.nodes[set.field * nodes_per_field..];
            let strides = layout.strides();
            // The velocity at the start of the step, walls included.
            let start = |node: &colluvium_grid::Node| node.motion - node.force * dt;
            subtract::<D, S, B, P>(set, &ground, |stencil| stencil.interpolate(nodes, &strides, start));
        }
        for _ in 1..self.options.xpic_order {
            self.sweep();
        }
        for set in &mut self.sets {
            let velocities = set.velocity.as_flattened_mut().iter_mut();
            velocities.zip(set.scratch.as_flattened()).for_each(|(velocity, rest)| *velocity -= rest);
        }
    }

    /// `R ← R - S S⁺ R` for the rest `R` in the scratch of the points. Components that a wall or a patch holds have no
    /// part in it: there the grid's velocity is theirs.
    fn sweep(&mut self) {
        self.reset_remapped();
        let strides = self.layout.strides();
        let (sets, ground, walls) = (&self.sets, ground!(self), &self.walls);
        let of_field = |field: usize| sets.iter().filter(move |set| set.field == field);
        let (layout, row_length) = (&self.layout, strides[0]);
        let fields = self.remapped.chunks_exact_mut(self.layout.len());
        for (field, (rest, nodes)) in fields.zip(self.nodes.chunks_exact(self.layout.len())).enumerate() {
            self.layout.scatter(rest, |slab, window, offset| {
                for set in of_field(field) {
                    for p in set.slabs[slab]..set.slabs[slab + 1] {
                        let stencil = set.domain[p].support::<S, B>(&ground, &set.position[p], &set.extent);
                        let at = |c: usize| if c < D { set.mass[p] * set.scratch[p][c] } else { 0.0 };
                        let momentum = Lanes::new([at(0), at(1), at(2), 0.0]);
                        stencil.deposit_motion(window, offset, &strides, momentum);
                    }
                }
            });
            self.layout.fold(rest, |sum, node| *sum += *node);
            self.layout.each(rest, |row, active, line| {
                for number in active {
                    let mass = nodes[row * row_length + number].motion.as_array()[3];
                    line[number] *= if mass > 0.0 { 1.0 / mass } else { 0.0 };
                    let [x, y, z] = walls.free_components(&layout.index(row, number));
                    line[number] *= Lanes::new([x, y, z, 1.0]);
                }
            });
        }
        self.clear_patches();
        let ground = ground!(self);
        for set in &mut self.sets {
            let nodes = &self.remapped[set.field * self.layout.len()..];
            subtract::<D, S, B, P>(set, &ground, |stencil| {
                stencil.interpolate(nodes, &strides, |node| *node)
            });
        }
    }
}

/// Takes from the scratch of every point what `read` finds with its stencil.
fn subtract<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    set: &mut PointSet<D, P>,
    ground: &Ground<'_, D>,
    read: impl Fn(&P::Support<S>) -> Lanes + Sync,
) {
    let extent = &set.extent;
    for_each_point(&mut set.scratch, &set.position, &set.domain, |rest, position, domain| {
        let read = read(&domain.support::<S, B>(ground, position, extent)).to_array();
        for c in 0..D {
            rest[c] -= read[c];
        }
    });
}
