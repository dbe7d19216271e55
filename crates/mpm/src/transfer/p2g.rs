//! Transfers from points to grid.

use std::ops::Range;

use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::{AffineFields, GridView, NodalState, NodeRange, P2gInput, Vector4};

use crate::VelocityTransfer;
use crate::background_grid::BackgroundGrid;
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::nodal_loads::apply_nodal_loads;
use crate::boundary::point_loads::apply_loads;
use crate::boundary::prescribed_motion::impose_patch_velocity_remapped;
use crate::boundary::rigid_bodies::impose_rigid_velocity_remapped;
use crate::clock::Clock;
use crate::contact::contact_correction::{correct_remapped, scatter_surfaces};
use crate::contact::rigid_contact::ContactContext;
use crate::momentum::velocity_fields::VelocityFields;
use crate::obstacles::obstacle_penalty::penalty_forces;
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::points::vectors::{first_three, vector4};
use crate::stress::averages::CellAverages;
use crate::stress::cell_integration::{add_cell_forces, average_stresses};
use crate::stress::dual_domain::{add_dual_forces, own_stress_share, share_stresses};
use crate::stress::force_columns::force_columns;

/// Quantities that are transferred to the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum P2gContent {
    /// Mass, momentum and forces.
    MassMomentumForces,
    /// Mass and momentum.
    Motion,
    /// Forces.
    Forces,
}

/// Adds point momenta to the nodes of a field, with the velocities of `of` (m/s) and the affine fields of `transfer`.
pub fn p2g_momenta<const D: usize>(
    background: &BackgroundGrid<D>,
    sets: &[PointSet<D>],
    field: usize,
    nodes: &mut [Vector4],
    of: fn(&PointSet<D>) -> &[[f64; D]],
    transfer: VelocityTransfer,
) {
    let view = background.grid_view();
    background.layout.for_each_slab(nodes, |slab, window, offset| {
        let mut values = [Vector4::ZERO; BLOCK_SIZE];
        for set in sets.iter().filter(|set| set.field == field) {
            for block in set.blocks_of(slab) {
                let values = &mut values[..block.len()];
                let points = of(set)[block.clone()].iter().zip(&set.points.mass[block.clone()]);
                for (value, (velocity, mass)) in values.iter_mut().zip(points) {
                    *value = vector4(velocity, 0.0) * *mass;
                }
                let to = NodeRange { nodes: &mut *window, first: offset };
                let affine = affine_of(transfer, set, block.clone());
                background.transfers.p2g_values(&view, &set.point_slice().range(block), to, values, affine);
            }
        }
    });
}

/// Contributions of a group of points to the nodes of one phase.
struct P2gBuffer<const D: usize> {
    motion: [Vector4; BLOCK_SIZE],
    columns: [[Vector4; D]; BLOCK_SIZE],
    body: [Vector4; BLOCK_SIZE],
}

impl<const D: usize> P2gBuffer<D> {
    /// Buffer without contributions.
    const EMPTY: Self = Self {
        motion: [Vector4::ZERO; BLOCK_SIZE],
        columns: [[Vector4::ZERO; D]; BLOCK_SIZE],
        body: [Vector4::ZERO; BLOCK_SIZE],
    };
}

/// Affine velocity fields of the points of a set, if the transfer has them.
fn affine_of<const D: usize>(
    transfer: VelocityTransfer,
    set: &PointSet<D>,
    points: Range<usize>,
) -> Option<AffineFields<'_, D>> {
    let fields = || &set.points.affine_velocity[points.clone()];
    let moments = transfer == VelocityTransfer::Apic;
    (!set.points.affine_velocity.is_empty()).then(|| AffineFields {
        moments,
        fields: fields(),
        mass: &set.points.mass[points.clone()],
    })
}

/// Contributions of points to the nodes of their velocity field.
struct PointScatter<'a, const D: usize> {
    background: &'a BackgroundGrid<D>,
    transfer: VelocityTransfer,
    content: P2gContent,
    /// Full cells of the field, whose internal force is not summed over their points.
    full_cells: Option<&'a [bool]>,
    /// Whether the nodes take a share of the stress (dual domains).
    has_dual_domains: bool,
}

impl<const D: usize> PointScatter<'_, D> {
    /// Adds the contributions of the bodies of a velocity field to its nodes, slab by slab.
    fn add_field(&self, sets: &[PointSet<D>], field: usize, nodes: &mut [NodalState]) {
        let BackgroundGrid { layout, transfers, axisymmetric, .. } = self.background;
        let view = self.background.grid_view();
        layout.for_each_slab(nodes, |slab, window, offset| {
            let mut buffer = P2gBuffer::EMPTY;
            for set in sets.iter().filter(|set| set.field == field) {
                let loaded = !set.points.traction.is_empty() && self.content != P2gContent::Motion;
                let pulled = !set.points.body_force.is_empty() && self.content != P2gContent::Motion;
                let pressed = !set.points.obstacle_contact.is_empty() && self.content != P2gContent::Motion;
                for block in set.blocks_of(slab) {
                    self.fill(&view, set, block.clone(), [loaded, pulled, pressed], &mut buffer);
                    let (count, affine) = (block.len(), affine_of(self.transfer, set, block.clone()));
                    let has_body_force = *axisymmetric || loaded || pulled || pressed;
                    let (moves, pushes) =
                        (self.content != P2gContent::Forces, self.content != P2gContent::Motion);
                    let input = P2gInput {
                        momentum_and_mass: &buffer.motion[..if moves { count } else { 0 }],
                        stress_columns: &buffer.columns[..if pushes { count } else { 0 }],
                        body_force: if has_body_force { &buffer.body[..count] } else { &[] },
                        affine_fields: affine.filter(|_| self.content != P2gContent::Forces),
                    };
                    let to = NodeRange { nodes: &mut *window, first: offset };
                    transfers.p2g(&view, &set.point_slice().range(block), to, &input);
                }
            }
        });
        layout.sum_periodic_images(nodes, |sum, node| {
            if self.content != P2gContent::Forces {
                sum.momentum_and_mass += node.momentum_and_mass;
            }
            if self.content != P2gContent::Motion {
                sum.force += node.force;
            }
        });
    }

    /// Computes the contributions of the points with indices `block`, with load and obstacle forces if there are any.
    #[inline(always)]
    fn fill(
        &self,
        view: &GridView<'_, D>,
        set: &PointSet<D>,
        block: Range<usize>,
        [loaded, pulled, pressed]: [bool; 3],
        buffer: &mut P2gBuffer<D>,
    ) {
        let (points, domain, full_cells) = (&set.points, set.domain.as_slice(), self.full_cells);
        if self.content != P2gContent::Forces {
            for (motion, p) in buffer.motion.iter_mut().zip(block.clone()) {
                *motion = vector4(&points.velocity[p], 1.0) * points.mass[p];
            }
        }
        if self.content == P2gContent::Motion {
            return;
        }
        for (k, p) in block.enumerate() {
            let is_in_full_cell =
                full_cells.is_some_and(|full| full[domain.cell(p, view, &points.position[p])]);
            let volume = if is_in_full_cell { 0.0 } else { points.volume[p] };
            let own_share =
                if self.has_dual_domains { own_stress_share(view.grid, &points.position[p]) } else { 1.0 };
            buffer.columns[k] = force_columns::<D>(&points.stress[p], own_share * volume);
            buffer.body[k] = if self.background.axisymmetric {
                let hoop = -volume * points.stress[p][2] / points.position[p][0];
                Vector4::new([hoop, 0.0, 0.0, 0.0])
            } else {
                Vector4::ZERO
            };
            if loaded {
                buffer.body[k] += vector4(&points.traction[p], 0.0);
            }
            if pulled {
                buffer.body[k] += vector4(&points.body_force[p], 0.0);
            }
            if pressed {
                buffer.body[k] += vector4(&points.obstacle_contact[p].force, 0.0);
            }
        }
    }
}

/// Point to grid (step 1).
pub fn p2g<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
    averages: &mut CellAverages<D>,
    content: P2gContent,
) {
    apply_loads(clock, bodies, &boundary.load_starts);
    if content != P2gContent::Motion {
        penalty_forces(clock, background, bodies, &mut boundary.penalty_obstacles);
        average_stresses(clock, background, bodies, &mut averages.stresses);
    }
    let fields = nodes.fields(&background.layout);
    share_stresses(background, bodies, fields, &mut averages.dual_domain);
    if content != P2gContent::Forces {
        scatter_surfaces(background, bodies, &boundary.walls, &mut boundary.contacts);
    }
    let CellAverages { stresses, dual_domain, .. } = &*averages;
    for (field, nodes) in nodes.nodal_states.chunks_exact_mut(background.layout.len()).enumerate() {
        let scatter = PointScatter {
            background,
            transfer: clock.options.transfer,
            content,
            full_cells: stresses.full_cells(field, background.cell_layout().len()),
            has_dual_domains: dual_domain.is_used(),
        };
        scatter.add_field(&bodies.sets, field, nodes);
    }
    if content != P2gContent::Motion {
        add_cell_forces(background, stresses, &mut nodes.nodal_states);
        add_dual_forces(background, dual_domain, &mut nodes.nodal_states);
        let BoundaryConditions { nodal_loads, load_starts, .. } = &*boundary;
        apply_nodal_loads(clock, background, bodies, &mut nodes.nodal_states, nodal_loads, load_starts);
    }
}

/// Maps the updated velocities of the points back to the nodes (MUSL, step 6), including walls.
pub fn remap<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
) {
    nodes.reset_remapped(&background.layout);
    let transfer = clock.options.transfer;
    let len = background.layout.len();
    for (field, nodes) in nodes.remapped_velocities.chunks_exact_mut(len).enumerate() {
        p2g_momenta(background, &bodies.sets, field, nodes, |set| &set.points.velocity, transfer);
        background.layout.sum_periodic_images(nodes, |sum, node| *sum += *node);
    }
    velocities_of_remapped(clock, background, bodies, nodes, boundary, false);
}

/// Computes velocities at the start of the step (USF), including walls.
pub fn start_velocities<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
) {
    for (velocity, node) in nodes.remapped_velocities.iter_mut().zip(&nodes.nodal_states) {
        *velocity = node.momentum_and_mass;
    }
    velocities_of_remapped(clock, background, bodies, nodes, boundary, true);
}

/// Divides re-mapped momenta by mass and applies the walls. With `start` the nodes contain momenta, otherwise solved velocities; mass is in
/// their fourth lane in both cases.
fn velocities_of_remapped<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
    start: bool,
) {
    let VelocityFields { nodal_states, remapped_velocities, .. } = &mut *nodes;
    let (walls, layout) = (&boundary.walls, &background.layout);
    let row_length = layout.strides()[0];
    let fields =
        remapped_velocities.chunks_exact_mut(layout.len()).zip(nodal_states.chunks_exact(layout.len()));
    for (remapped_velocities, nodes) in fields {
        layout.for_each_active_node_range(remapped_velocities, |row, active, line| {
            for number in active {
                let node = &nodes[row * row_length + number];
                let mass = node.momentum_and_mass.as_array()[3];
                if mass <= 0.0 {
                    line[number] = Vector4::ZERO;
                    continue;
                }
                line[number] *= 1.0 / mass;
                let nodal_states = if start { Vector4::splat(f64::NAN) } else { node.momentum_and_mass };
                let mut velocity = first_three(line[number]);
                walls.constrain_remapped(
                    &layout.axis_indices(row, number),
                    &first_three(nodal_states),
                    &mut velocity,
                );
                line[number] = vector4(&velocity, 0.0);
            }
        });
    }
    impose_rigid_velocity_remapped(
        background,
        &boundary.driven,
        &boundary.contacts,
        &mut nodes.remapped_velocities,
    );
    let BoundaryConditions { walls, driven, contacts, row_contacts, .. } = boundary;
    if !start {
        let mass_cutoff = bodies.mass_cutoff(clock);
        let context = ContactContext { clock, background, bodies, mass_cutoff, walls, contacts };
        correct_remapped(&context, nodes, row_contacts);
    }
    impose_patch_velocity_remapped(clock, background, driven, contacts, &mut nodes.remapped_velocities);
}
