//! Affine transfers, APIC and TPIC (MPM sheet §2.6): points carry the moment or the gradient of the velocity, over the
//! places from which they look at the grid: those of the start in the total-Lagrangian form.

use colluvium_grid::{Basis, Grid, Lanes, Node, Support};

use crate::config::Transfer;
use crate::points::{PointDomain, PointSet, for_each_point, ground};
use crate::solver::MpmSolver;

/// Where a node keeps its momentum, later its velocity.
pub fn momentum(node: &mut Node) -> &mut Lanes {
    &mut node.motion
}

/// What point `p` of a set adds to the momentum of its nodes beyond `N m v`: the stencil of moments and the columns
/// `m C e_j`, with the affine velocity `C` (1/s).
#[inline(always)]
pub fn affine_momentum<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>>(
    transfer: Transfer,
    grid: &Grid<D>,
    set: &PointSet<D, P>,
    p: usize,
    stencil: &P::Support<S>,
) -> (P::Support<S>, [Lanes; D]) {
    let (moments, squares) = stencil.moments::<S, B>(grid, &set.domain[p].anchor(&set.position[p]));
    let columns = std::array::from_fn(|j| {
        let scale = set.mass[p] * if transfer == Transfer::Apic { 1.0 / squares[j] } else { 1.0 };
        let at = |i: usize| if i < D { scale * set.affine[p][i][j] } else { 0.0 };
        Lanes::new([at(0), at(1), at(2), 0.0])
    });
    (moments, columns)
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Moments or gradients of the initial velocities, from differences over a cell.
    pub(crate) fn start_affine(&mut self) {
        let (ground, half) = (ground!(self), 0.5 * self.grid.cell);
        let grid = ground.grid;
        for set in self.sets.iter_mut().filter(|set| !set.affine.is_empty()) {
            let field = &self.case.bodies[set.body as usize].velocity;
            for p in 0..set.affine.len() {
                let stencil = set.domain[p].support::<S, B>(&ground, &set.position[p], &set.extent);
                let (_, squares) = stencil.moments::<S, B>(grid, &set.position[p]);
                for j in 0..D {
                    let at = |shift: f64| {
                        let place = |c: usize| set.position[p].get(c).copied().unwrap_or(0.0);
                        field.at(std::array::from_fn(|c| place(c) + if c == j { shift } else { 0.0 }))
                    };
                    let (above, below) = (at(half), at(-half));
                    let scale = if self.options.transfer == Transfer::Apic { squares[j] } else { 1.0 };
                    for i in 0..D {
                        set.affine[p][i][j] = scale * (above[i] - below[i]) / grid.cell;
                    }
                }
            }
        }
    }

    /// Moments (APIC) or gradients (TPIC) of the solved velocities, at the positions at the start of the step.
    pub(crate) fn gather_affine(&mut self) {
        let strides = self.layout.strides();
        let (ground, transfer, nodes_per_field) = (ground!(self), self.options.transfer, self.layout.len());
        for set in &mut self.sets {
            let nodes = &self.nodes[set.field * nodes_per_field..];
            let extent = &set.extent;
            for_each_point(&mut set.affine, &set.position, &set.domain, |affine, position, domain| {
                let stencil = domain.support::<S, B>(&ground, position, extent);
                let moments = match transfer {
                    Transfer::Apic => stencil.moments::<S, B>(ground.grid, &domain.anchor(position)).0,
                    _ => stencil.of_moments(),
                };
                let slopes = moments.gather(nodes, &strides);
                for (j, column) in slopes.gradient.iter().enumerate() {
                    let column = column.to_array();
                    for i in 0..D {
                        affine[i][j] = column[i];
                    }
                }
            });
        }
    }
}
