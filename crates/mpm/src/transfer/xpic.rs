//! Extended PIC (Hammerquist & Nairn 2017; sheet: mpm §2.6), and FLIP with decay of null-space velocities.
//!
//! With `S⁺` from points to grid and `S` back, XPIC(m) removes from the points the velocities that `m` sweeps cannot represent:
//! `V ← V - (I - S S⁺)^m V + Δt S a`. The first sweep is the grid's velocity at the start of the step, which the momentum solve provides;
//! each further order is one sweep over points and grid.
//!
//! If all is removed in every step, the dissipation grows with the number of steps. With a `residual_time` `τ` a step removes the share
//! `1 - exp(-Δt/τ)`, the blend of FLIP and a filtered transfer by the step (Nairn & Hammerquist 2021): the same in the same time with any
//! step. FLIP with a `residual_time` is identical.

use colluvium_grid::{PointSlice, Vector4};

use crate::VelocityTransfer;
use crate::background_grid::BackgroundGrid;
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::prescribed_motion::clear_patch_components;
use crate::clock::Clock;
use crate::momentum::velocity_fields::VelocityFields;
use crate::points::bodies::Bodies;
use crate::points::point_set::{CHUNK_POINTS, PointSet, par_for_each_chunk};
use crate::transfer::p2g::p2g_momenta;

/// Removes null-space velocities `(I - S S⁺)^m V`, or a fraction of them, from the velocities of the points. The update with `Δt S a` is
/// that of FLIP.
pub fn filter_velocities<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &BoundaryConditions<D>,
) {
    let (len, view, transfers) = (background.layout.len(), background.grid_view(), background.transfers);
    for set in &mut bodies.sets {
        set.points.scratch.copy_from_slice(&set.points.velocity);
        let nodes = &nodes.nodal_states[set.field * len..];
        // The velocity at the start of the step, walls included.
        subtract(set, &|points, out| transfers.g2p_start_velocity(&view, points, nodes, clock.dt, out));
    }
    for _ in 1..clock.options.xpic_order {
        filter_once(clock, background, bodies, nodes, boundary);
    }
    let share = clock.residual_share();
    for set in &mut bodies.sets {
        let velocities = set.points.velocity.as_flattened_mut().iter_mut();
        velocities
            .zip(set.points.scratch.as_flattened())
            .for_each(|(velocity, rest)| *velocity -= share * rest);
    }
}

/// Computes `R ← R - S S⁺ R` for the residual `R` in the scratch of the points. Components that a wall or a patch prescribes are excluded:
/// there the velocity is that of the grid.
fn filter_once<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &BoundaryConditions<D>,
) {
    nodes.reset_remapped(&background.layout);
    let (layout, walls) = (&background.layout, &boundary.walls);
    let row_length = layout.strides()[0];
    let fields = nodes.remapped_velocities.chunks_exact_mut(layout.len());
    for (field, (rest, nodes)) in fields.zip(nodes.nodal_states.chunks_exact(layout.len())).enumerate() {
        p2g_momenta(background, &bodies.sets, field, rest, |set| &set.points.scratch, VelocityTransfer::Xpic);
        layout.sum_periodic_images(rest, |sum, node| *sum += *node);
        layout.for_each_active_node_range(rest, |row, active, line| {
            for number in active {
                let mass = nodes[row * row_length + number].momentum_and_mass.as_array()[3];
                line[number] *= if mass > 0.0 { 1.0 / mass } else { 0.0 };
                let [x, y, z] = walls.free_components(&layout.axis_indices(row, number));
                line[number] *= Vector4::new([x, y, z, 1.0]);
            }
        });
    }
    clear_patch_components(
        clock,
        background,
        &boundary.driven,
        &boundary.contacts,
        &mut nodes.remapped_velocities,
    );
    let (len, view, transfers) = (background.layout.len(), background.grid_view(), background.transfers);
    for set in &mut bodies.sets {
        let nodes = &nodes.remapped_velocities[set.field * len..];
        subtract(set, &|points, out| transfers.g2p_values(&view, points, nodes, out));
    }
}

/// Subtracts the values of `read` from the scratch of every point.
fn subtract<const D: usize>(
    set: &mut PointSet<D>,
    read: &(dyn Fn(&PointSlice<'_, D>, &mut [Vector4]) + Sync),
) {
    let points =
        PointSlice { position: &set.points.position, domain: set.domain.as_slice(), extent: &set.extent };
    par_for_each_chunk(&mut set.points.scratch, &points, &|rest, points| {
        let mut all = [Vector4::ZERO; CHUNK_POINTS];
        let found = &mut all[..rest.len()];
        read(points, found);
        for (rest, found) in rest.iter_mut().zip(found) {
            (0..D).for_each(|c| rest[c] -= found.as_array()[c]);
        }
    });
}
