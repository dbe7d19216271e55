//! Nodes with a small mass at the surface of a body (sheet: mpm §3.2, pitfall P-02).
//!
//! A point at `ξ` of its cell gives the far node the mass `ξ m` and a force `V σ/h` independent of `ξ`. With stress last the velocity of
//! that node strains the point in the same step by `-C²/ξ` times the strain that makes the force. Below `ξ = C²/2`, with the Courant number
//! `C` of the step, that grows; in a corner of a nearly incompressible body, where the `D` axes add up, below `D C²/2`. The nodes on the
//! near side add `-C²/(1 - ξ)`.

use std::ops::Range;

use colluvium_constitutive::BLOCK_SIZE;
use colluvium_grid::{NodalState, NodeRange, Vector4};

use crate::MpmOptions;
use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::momentum::velocity_fields::VelocityFields;
use crate::points::bodies::Bodies;

/// Reduces the force on nodes with little material in reach, by the square of the extension of material into the cell over
/// [`MpmOptions::min_reach`]. The additional strain then decreases continuously with the extension. Weight and walls are not reduced. The
/// reach along an axis is the mass of the node over `h Σ m |∂N/∂x|`: `ξ` at a plane surface, for any number and mass of the points, and
/// about a half within material.
pub fn rescale_small_mass_forces<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
) {
    let VelocityFields { nodal_states, mass_gradients: slopes, .. } = nodes;
    if slopes.is_empty() {
        return;
    }
    let BackgroundGrid { layout, transfers, .. } = background;
    let view = background.grid_view();
    let min_reach = MpmOptions::min_reach(clock.courant, D);
    let row_length = layout.strides()[0];
    let fields = slopes.chunks_exact_mut(layout.len()).zip(nodal_states.chunks_exact_mut(layout.len()));
    for (field, (slopes, nodes)) in fields.enumerate() {
        layout.reset(slopes);
        mark_small_mass_nodes(background, min_reach, nodes, slopes);
        layout.for_each_slab(slopes, |slab, window, offset| {
            let mut moments = [Vector4::ZERO; BLOCK_SIZE];
            for set in bodies.sets.iter().filter(|set| set.field == field) {
                let position = &set.points.position;
                for block in set.blocks_of(slab) {
                    let mut rest = block;
                    while let Some(run) = next_range(&mut rest, |p| {
                        reaches_marked_node(background, &position[p], window, offset)
                    }) {
                        for (moments, p) in moments.iter_mut().zip(run.clone()) {
                            let cell = set.domain.as_slice().spacing(p, &view);
                            *moments = gradient_moments(background, &position[p], set.points.mass[p] * cell);
                        }
                        let to = NodeRange { nodes: &mut *window, first: offset };
                        let (values, moments) =
                            (&[Vector4::ZERO; BLOCK_SIZE][..run.len()], &moments[..run.len()]);
                        transfers.p2g_moments(&view, &set.point_slice().range(run), to, values, moments);
                    }
                }
            }
        });
        layout.sum_periodic_images(slopes, |sum, node| *sum += *node);
        let slopes = &*slopes;
        layout.for_each_active_node_range(nodes, |row, active, line| {
            for number in active {
                let [slopes @ .., mark] = slopes[row * row_length + number].to_array();
                if mark == 0.0 {
                    continue;
                }
                let mass = line[number].momentum_and_mass.as_array()[3];
                let wanted =
                    min_reach * slopes[..D].iter().fold(0.0, |largest: f64, slope| largest.max(slope.abs()));
                if mass < wanted {
                    line[number].force *= (mass / wanted).powi(2);
                }
            }
        });
    }
}

/// Marks the nodes that may need the reduction, in the fourth component of their mass gradients. On a grid these are nodes with less than
/// that fraction of the mass of themselves and their neighbours along some axis. Nodes within material are not marked, and need no sum.
fn mark_small_mass_nodes<const D: usize>(
    background: &BackgroundGrid<D>,
    min_reach: f64,
    nodes: &[NodalState],
    slopes: &mut [Vector4],
) {
    /// Mark of a small-mass node, in the fourth component.
    const MARK: Vector4 = Vector4::new([0.0, 0.0, 0.0, 1.0]);
    let layout = &background.layout;
    let (strides, counts) = (layout.strides(), layout.nodes());
    let mass = |number: usize| nodes[number].momentum_and_mass.as_array()[3];
    layout.for_each_active_node_range(slopes, |row, active, line| {
        for number in active {
            let (index, node) = (layout.axis_indices(row, number), row * strides[0] + number);
            let is_light = |axis: usize| {
                let [first, last] = [index[axis] == 0, index[axis] + 1 == counts[axis]];
                let below = if first { 0.0 } else { mass(node - strides[axis]) };
                let above = if last { 0.0 } else { mass(node + strides[axis]) };
                // With a tolerance for round-off, and an image of the neighbour beyond a periodic side.
                mass(node) < (1.0 + 1e-9) * min_reach * (below + mass(node) + above)
                    || (layout.is_periodic(axis) && (first || last))
            };
            if background.is_meshed() || (0..D).any(is_light) {
                line[number] = MARK;
            }
        }
    });
}

/// Whether a point contributes to a marked node.
#[inline(always)]
fn reaches_marked_node<const D: usize>(
    background: &BackgroundGrid<D>,
    position: &[f64; D],
    window: &[Vector4],
    offset: usize,
) -> bool {
    if background.is_meshed() {
        return true;
    }
    let (cell, strides) = (background.grid.cell_of(position), background.layout.strides());
    let first: usize = (0..D).map(|axis| cell[axis] * strides[axis]).sum::<usize>() - offset;
    (0..1 << D).any(|corner| {
        let node: usize = (0..D).map(|axis| (corner >> axis & 1) * strides[axis]).sum();
        window[first + node].as_array()[3] != 0.0
    })
}

/// Next range of points that satisfy a condition; the start of `rest` moves to its end.
#[inline(always)]
fn next_range(rest: &mut Range<usize>, wanted: impl Fn(usize) -> bool) -> Option<Range<usize>> {
    let last = rest.end;
    let start = rest.find(|p| wanted(*p))?;
    Some(start..rest.find(|p| !wanted(*p)).unwrap_or(last))
}

/// Contribution of a point with mass times cell size `moment` (kg m) to the mass gradient of a node, one axis per component. On a grid its
/// sign alternates from cell to cell, as that of the derivative at a node: there magnitudes are summed.
fn gradient_moments<const D: usize>(
    background: &BackgroundGrid<D>,
    position: &[f64; D],
    moment: f64,
) -> Vector4 {
    let cell = (!background.is_meshed()).then(|| background.grid.cell_of(position));
    let mut lanes = [0.0; 4];
    for axis in 0..D {
        let turned = cell.is_some_and(|cell| cell[axis] % 2 == 1);
        lanes[axis] = if turned { -moment } else { moment };
    }
    Vector4::new(lanes)
}
