//! Affine transfers, APIC and TPIC (sheet: mpm §2.6): points carry the moment or the gradient of the velocity, at their evaluation
//! positions: the initial ones in the total-Lagrangian form.

use colluvium_grid::PointSlice;

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::config::VelocityTransfer;
use crate::momentum::velocity_fields::VelocityFields;
use crate::points::bodies::Bodies;
use crate::points::point_set::{PointSet, par_for_each_chunk};

/// Sets moments or gradients of the initial velocities by differences over a cell.
pub fn initialise_affine<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
) {
    let view = background.grid_view();
    let cell = view.grid.cell;
    for set in bodies.sets.iter_mut().filter(|set| !set.points.affine_velocity.is_empty()) {
        let field = &clock.case.bodies[set.body as usize].velocity;
        let mut moments = vec![[0.0; D]; set.points.affine_velocity.len()];
        background.transfers.second_moments(&view, &set.point_slice(), &mut moments);
        for ((affine, squares), position) in
            set.points.affine_velocity.iter_mut().zip(&moments).zip(&set.points.position)
        {
            for j in 0..D {
                let at = |shift: f64| {
                    let place = |c: usize| position.get(c).copied().unwrap_or(0.0);
                    field.velocity_at(std::array::from_fn(|c| place(c) + if c == j { shift } else { 0.0 }))
                };
                let (above, below) = (at(0.5 * cell), at(-0.5 * cell));
                let scale = if clock.options.transfer == VelocityTransfer::Apic { squares[j] } else { 1.0 };
                for i in 0..D {
                    affine[i][j] = scale * (above[i] - below[i]) / cell;
                }
            }
        }
    }
}

/// Computes moments (APIC) or gradients (TPIC) of the solved velocities for the points of rigid bodies. Those of other bodies are computed
/// with their velocities.
pub fn g2p_affine_of_rigid<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    nodes: &VelocityFields,
) {
    let (view, transfers) = (background.grid_view(), background.transfers);
    let moments = clock.options.transfer == VelocityTransfer::Apic;
    let carrying = |set: &&mut PointSet<D>| set.rigid.is_some() && !set.points.affine_velocity.is_empty();
    for set in bodies.sets.iter_mut().filter(carrying) {
        let nodes = &nodes.nodal_states[set.field * background.layout.len()..];
        let points =
            PointSlice { position: &set.points.position, domain: set.domain.as_slice(), extent: &set.extent };
        par_for_each_chunk(&mut set.points.affine_velocity, &points, &|affine, points| {
            transfers.g2p_affine(&view, points, nodes, moments, affine);
        });
    }
}

/// Kinetic energy of the affine velocity fields of points along each axis (J), `½ m C D Cᵀ` with the second moments `D` of the shape
/// functions and the gradient `C` (sheet: snow-mpm §2.11). It is in addition to the energy of the point velocities. It is the energy of
/// rotation and stretch within points.
pub fn affine_energies<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
) -> [f64; D] {
    let (view, mut energies) = (background.grid_view(), [0.0; D]);
    let carrying =
        bodies.sets.iter().filter(|set| set.rigid.is_none() && !set.points.affine_velocity.is_empty());
    for set in carrying {
        let mut moments = vec![[0.0; D]; set.len()];
        background.transfers.second_moments(&view, &set.point_slice(), &mut moments);
        for ((affine, squares), mass) in set.points.affine_velocity.iter().zip(&moments).zip(&set.points.mass)
        {
            for (energy, row) in energies.iter_mut().zip(affine) {
                let each = row.iter().zip(squares).map(|(c, square)| match clock.options.transfer {
                    VelocityTransfer::Apic => c * c / square,
                    _ => c * c * square,
                });
                *energy += 0.5 * mass * each.sum::<f64>();
            }
        }
    }
    energies
}
