//! Extended PIC (Hammerquist & Nairn 2017; sheet: mpm §2.6), and FLIP whose unseen velocities decay.
//!
//! With `S⁺` from points to grid and `S` back, XPIC(m) takes from the points what `m` sweeps cannot represent:
//! `V ← V - (I - S S⁺)^m V + Δt S a`. The first sweep is the grid's velocity at the start of the step, which the
//! momentum solve leaves behind; each further order is one sweep over points and grid.
//!
//! Taken in every step, that dissipates with the number of steps. With a `residual_time` `τ` a step takes the share
//! `1 - exp(-Δt/τ)` of it, the blend of FLIP and a filtered transfer by the step (Nairn & Hammerquist 2021): as much in the
//! same time with any step. FLIP with a `residual_time` is the same.

use colluvium_grid::{Lanes, Points};

use crate::Transfer;
use crate::background::Background;
use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::clock::Clock;
use crate::driven::clear_patches;
use crate::nodes::Nodes;
use crate::points::{CHUNK, PointSet, in_chunks};
use crate::transfer::deposit_momenta;

/// Takes `(I - S S⁺)^m V`, or the share of it that goes in the step, from the velocities of the points; the update with `Δt S a` is that of FLIP.
pub fn filter_velocities<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut Nodes,
    boundary: &Boundary<D>,
) {
    let (len, ground, sweeps) = (background.layout.len(), background.ground(), background.sweeps);
    for set in &mut bodies.sets {
        set.points.scratch.copy_from_slice(&set.points.velocity);
        let nodes = &nodes.solved[set.field * len..];
        // The velocity at the start of the step, walls included.
        subtract(set, &|points, out| sweeps.interpolate_start(&ground, points, nodes, clock.dt, out));
    }
    for _ in 1..clock.options.xpic_order {
        sweep(clock, background, bodies, nodes, boundary);
    }
    let share = clock.residual_share();
    for set in &mut bodies.sets {
        let velocities = set.points.velocity.as_flattened_mut().iter_mut();
        velocities
            .zip(set.points.scratch.as_flattened())
            .for_each(|(velocity, rest)| *velocity -= share * rest);
    }
}

/// `R ← R - S S⁺ R` for the rest `R` in the scratch of the points. Components that a wall or a patch holds have no
/// part in it: there the grid's velocity is theirs.
fn sweep<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut Nodes,
    boundary: &Boundary<D>,
) {
    nodes.reset_remapped(&background.layout);
    let (layout, walls) = (&background.layout, &boundary.walls);
    let row_length = layout.strides()[0];
    let fields = nodes.remapped.chunks_exact_mut(layout.len());
    for (field, (rest, nodes)) in fields.zip(nodes.solved.chunks_exact(layout.len())).enumerate() {
        deposit_momenta(background, &bodies.sets, field, rest, |set| &set.points.scratch, Transfer::Xpic);
        layout.fold(rest, |sum, node| *sum += *node);
        layout.each(rest, |row, active, line| {
            for number in active {
                let mass = nodes[row * row_length + number].motion.as_array()[3];
                line[number] *= if mass > 0.0 { 1.0 / mass } else { 0.0 };
                let [x, y, z] = walls.free_components(&layout.index(row, number));
                line[number] *= Lanes::new([x, y, z, 1.0]);
            }
        });
    }
    clear_patches(clock, background, &boundary.driven, &boundary.contacts, &mut nodes.remapped);
    let (len, ground, sweeps) = (background.layout.len(), background.ground(), background.sweeps);
    for set in &mut bodies.sets {
        let nodes = &nodes.remapped[set.field * len..];
        subtract(set, &|points, out| sweeps.interpolate(&ground, points, nodes, out));
    }
}

/// Takes from the scratch of every point what `read` finds at it.
fn subtract<const D: usize>(set: &mut PointSet<D>, read: &(dyn Fn(&Points<'_, D>, &mut [Lanes]) + Sync)) {
    let points =
        Points { position: &set.points.position, domain: set.domain.as_slice(), extent: &set.extent };
    in_chunks(&mut set.points.scratch, &points, &|rest, points| {
        let mut all = [Lanes::ZERO; CHUNK];
        let found = &mut all[..rest.len()];
        read(points, found);
        for (rest, found) in rest.iter_mut().zip(found) {
            (0..D).for_each(|c| rest[c] -= found.as_array()[c]);
        }
    });
}
