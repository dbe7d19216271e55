//! Contact substep: corrects nodal velocities by the laws of [`crate::contact::contact_law`] (sheet: mpm §3.6).

use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::{Basis1d, Mesh, NodalState, NodeRange, NodeWalls, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::contact::contact_gap::ZERO_WIDTH;
use crate::contact::contact_law::{ContactImpulse, FieldContacts, FieldPair, RowContact};
use crate::contact::nodal_contact::{ContactNode, contact_node};
use crate::contact::rigid_contact::{ContactContext, ContactSet, solve_rigid_contact};
use crate::momentum::driven_object::DrivenObject;
use crate::momentum::velocity_fields::VelocityFields;
use crate::obstacles::state::PenaltyObstacle;
use crate::points::bodies::Bodies;

/// Maximum number of iterations over the pairs of three or more bodies, whose contacts interact.
const MAX_SWEEPS: usize = 30;

/// Empty contact sums of each row of nodes for each pair of fields. Impulses per node are stored only for laws with a bound on force or
/// strength and several iterations.
pub fn row_contacts(contacts: &FieldContacts, count: usize, length: usize) -> Vec<RowContact> {
    let row = |pair: &FieldPair| {
        let lasts = pair.law.is_some_and(|law| law.penalty.is_some() || law.adhesion > 0.0);
        let nodes = if lasts && contacts.fields() > 2 { length } else { 0 };
        RowContact { impulses: vec![ContactImpulse::default(); nodes], ..RowContact::default() }
    };
    contacts.pairs.iter().flat_map(|pair| std::iter::repeat_n(row(pair), count)).collect()
}

/// Mutable nodes of two velocity fields, each with `len` nodes.
fn two_fields<T>(nodes: &mut [T], len: usize, [first, second]: [usize; 2]) -> [&mut [T]; 2] {
    let (low, high) = nodes.split_at_mut(second * len);
    [&mut low[first * len..(first + 1) * len], &mut high[..len]]
}

/// Adds the surface integrals `Σ_p Ω_p ∇N_i` of the bodies, for normals, areas and distances. In axisymmetry they are those of the section.
pub fn scatter_surfaces<const D: usize>(
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    walls: &NodeWalls,
    contacts: &mut FieldContacts,
) {
    let BackgroundGrid { layout, transfers, axisymmetric, .. } = background;
    let (view, length) = (background.grid_view(), layout.strides()[0]);
    for (field, nodes) in contacts.surfaces.chunks_exact_mut(layout.len()).enumerate() {
        layout.reset(nodes);
        layout.for_each_slab(nodes, |slab, window, offset| {
            let (mut volumes, mut sections) = ([Vector4::ZERO; BLOCK_SIZE], [Vector4::ZERO; BLOCK_SIZE]);
            for set in bodies.sets.iter().filter(|set| set.field == field) {
                let domain = set.domain.as_slice();
                for block in set.blocks_of(slab) {
                    for (k, p) in block.clone().enumerate() {
                        let section = set.points.volume[p]
                            / if *axisymmetric { set.points.position[p][0] } else { 1.0 };
                        sections[k] = Vector4::splat(section);
                        volumes[k] = Vector4::new([0.0, 0.0, 0.0, section / domain.spacing(p, &view)]);
                    }
                    let (volumes, sections) = (&volumes[..block.len()], &sections[..block.len()]);
                    let to = NodeRange { nodes: &mut *window, first: offset };
                    transfers.p2g_moments(&view, &set.point_slice().range(block), to, volumes, sections);
                }
            }
        });
        background.layout.sum_periodic_images(nodes, |sum, node| *sum += *node);
        // A face on a wall cannot touch another body: the body counts as continued behind the wall.
        for (place, node) in nodes.iter_mut().enumerate().filter(|(_, node)| **node != Vector4::ZERO) {
            let index = background.layout.axis_indices(place / length, place % length);
            let bare = |axis: usize| if walls.wall_at(axis, &index).is_some() { 0.0 } else { 1.0 };
            let keep = std::array::from_fn(|c| if c < D { bare(c) } else { 1.0 });
            *node *= Vector4::new(keep);
        }
    }
}

/// Distances of the nodes from the axis of rotation (m); zero for nodes beyond the axis.
pub fn radii<const D: usize>(background: &BackgroundGrid<D>) -> Vec<f64> {
    let (layout, row) = (&background.layout, background.layout.strides()[0]);
    let radius = |node: usize| background.node_at(node, &layout.axis_indices(node / row, node % row))[0];
    (0..layout.len()).map(|node| radius(node).max(0.0)).collect()
}

/// Corrects the solved velocities for contact, pair after pair. The contacts of three and more bodies at a node interact: sweeps are
/// repeated until no velocity changes. Every impulse obeys the contact law and acts on both bodies.
pub fn correct_velocities<const D: usize>(
    context: &ContactContext<'_, D>,
    solved: &mut [NodalState],
    driven: &mut [DrivenObject],
    row_contacts: &mut [RowContact],
    (rigid_contacts, obstacles): (&mut ContactSet, &mut [PenaltyObstacle<D>]),
) {
    let ContactContext { clock, background, mass_cutoff, walls, contacts, .. } = *context;
    row_contacts.iter_mut().for_each(|row| row.impulses.fill(ContactImpulse::default()));
    let count = background.layout.nodes()[0];
    for _ in 0..MAX_SWEEPS {
        let mut changed = false;
        for (number, pair) in contacts.pairs.iter().enumerate() {
            let rigid = pair.fields.map(|field| contacts.rigid[field]);
            let is_free = |number: &Option<usize>| {
                number.is_some_and(|number| driven[number].free_rigid_body.is_some())
            };
            if rigid.iter().all(Option::is_some) || rigid.iter().any(is_free) {
                continue;
            }
            let rows = &mut row_contacts[number * count..][..count];
            let contact = contact_node(clock, background, mass_cutoff, walls, contacts, pair, clock.dt);
            correct_pair(background, &contact, pair, solved, rows);
            changed |= rows.iter().any(|row| row.has_changed);
            record_rigid_impulses(driven, contacts, pair, rows, clock.dt);
        }
        let rigid = (&mut *rigid_contacts, &mut *obstacles);
        changed |= solve_rigid_contact(context, solved, driven, row_contacts, rigid);
        if !changed || contacts.fields() < 3 {
            break;
        }
    }
}

/// Corrects the velocities of two fields at their contact nodes and records impulses per row of nodes.
fn correct_pair<const D: usize>(
    background: &BackgroundGrid<D>,
    contact: &ContactNode<'_>,
    pair: &FieldPair,
    solved: &mut [NodalState],
    rows: &mut [RowContact],
) {
    let (len, row_length) = (background.layout.len(), background.layout.strides()[0]);
    background.layout.for_each_row_pair(
        two_fields(solved, len, pair.fields),
        rows,
        &|row, active, [a, b], result| {
            (result.has_changed, result.impulse) = (false, [0.0; 3]);
            for number in active {
                let index = background.layout.axis_indices(row, number);
                let mut alone = ContactImpulse::default();
                let accumulated = result.impulses.get_mut(number).unwrap_or(&mut alone);
                let nodes = [&mut a[number], &mut b[number]];
                let corrected =
                    contact.correct_velocities(row * row_length + number, &index, nodes, accumulated);
                let Some((changed, impulse)) = corrected else { continue };
                result.has_changed |= changed;
                if !background.layout.is_periodic_image(&index) {
                    (0..3).for_each(|c| result.impulse[c] += impulse[c]);
                }
            }
        },
    );
}

/// Adds the impulses of a pair to its rigid body, if one of the fields is one.
fn record_rigid_impulses(
    driven: &mut [DrivenObject],
    contacts: &FieldContacts,
    pair: &FieldPair,
    rows: &[RowContact],
    dt: f64,
) {
    for (side, field) in pair.fields.into_iter().enumerate() {
        if let Some(number) = contacts.rigid[field] {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            rows.iter().for_each(|row| driven[number].add_impulse(row.impulse.map(|i| sign * i), dt));
        }
    }
}

/// Corrects the re-mapped velocities for contact.
pub fn correct_remapped<const D: usize>(
    context: &ContactContext<'_, D>,
    nodes: &mut VelocityFields,
    row_contacts: &mut [RowContact],
) {
    let ContactContext { clock, background, mass_cutoff, walls, contacts, .. } = *context;
    let (len, row_length) = (background.layout.len(), background.layout.strides()[0]);
    let VelocityFields { nodal_states, remapped_velocities, .. } = nodes;
    for pair in &contacts.pairs {
        let contact = contact_node(clock, background, mass_cutoff, walls, contacts, pair, 1.0);
        let [first, second] = pair.fields;
        let both = two_fields(remapped_velocities, len, pair.fields);
        background.layout.for_each_row_pair(both, row_contacts, &|row, active, [a, b], _| {
            for number in active {
                let place = row * row_length + number;
                let nodal_states = [&nodal_states[first * len + place], &nodal_states[second * len + place]];
                contact.correct_remapped(place, nodal_states, [&mut a[number], &mut b[number]]);
            }
        });
    }
}

/// Volumes over the cell size (m²) above which a rigid body constrains grid nodes: the volume that a corner node of a body has, minus a
/// tolerance. At the sides of the domain the value is smaller, as the support of a node is.
pub fn rigid_volume_thresholds<const D: usize>(
    BackgroundGrid { grid, layout, basis_1d: basis, .. }: &BackgroundGrid<D>,
    points: usize,
) -> Vec<f64> {
    let corner = ROUND_OFF_FACTOR * 0.5f64.powi(D as i32) * grid.cell.powi(D as i32 - 1);
    let shares: [Vec<f64>; D] = std::array::from_fn(|axis| {
        if layout.is_periodic(axis) {
            vec![1.0; layout.nodes()[axis]]
        } else {
            integrals(basis, grid.cells[axis], points)
        }
    });
    let strides = layout.strides();
    let share = |node: usize| -> f64 {
        let mut rest = node;
        (0..D)
            .map(|axis| {
                let index = rest / strides[axis];
                rest %= strides[axis];
                shares[axis][index]
            })
            .product()
    };
    (0..layout.len()).map(|node| corner * share(node)).collect()
}

/// Integrals of the shape functions along an axis of `cells` cells, in cells, by the quadrature of the `points` of a cell.
fn integrals(basis: &Basis1d, cells: usize, points: usize) -> Vec<f64> {
    let mut sums = vec![0.0; basis.nodes(cells)];
    let weight = 1.0 / points as f64;
    for cell in 0..cells {
        for k in 0..points {
            let on = basis.evaluate(cell as f64 + weight * (k as f64 + 0.5), ZERO_WIDTH, cells);
            for (sum, own) in sums[on.first..].iter_mut().zip(on.weights()) {
                *sum += weight * own;
            }
        }
    }
    sums
}

/// Volumes above which a rigid body constrains mesh nodes: the share of the smallest element at each node.
pub fn rigid_volume_thresholds_on_mesh<const D: usize>(mesh: &Mesh<D>, nodes: usize) -> Vec<f64> {
    let share = |element: &u32| {
        let element = &mesh.elements()[*element as usize];
        element.volume / (element.height * (D + 1) as f64)
    };
    let smallest = |node: u32| mesh.elements_around(node).iter().map(share).fold(f64::INFINITY, f64::min);
    let mut filled: Vec<f64> =
        (0..mesh.nodes().len() as u32).map(|node| ROUND_OFF_FACTOR * smallest(node)).collect();
    filled.resize(nodes, f64::INFINITY);
    filled
}

/// Factor on volume thresholds, one minus the tolerance for round-off.
const ROUND_OFF_FACTOR: f64 = 1.0 - 1e-6;
