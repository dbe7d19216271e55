//! Loads on nodes, as in finite elements (sheet: mpm §2.11): on sides along grid lines, or on facets of a mesh, at fixed positions.
//!
//! The force of a node is `∫ N_i t dS` over the initial side. Nodes without material have no load.

use std::collections::BTreeMap;

use colluvium_case::description::LoadTarget;
use colluvium_case::{Case, CaseError};
use colluvium_grid::{NodalState, Vector4};

use crate::MpmOptions;
use crate::background_grid::BackgroundGrid;
use crate::boundary::absorbing_boundary::for_each_across;
use crate::boundary::mesh_loads;
use crate::boundary::point_loads;
use crate::boundary::point_loads::factor;
use crate::clock::Clock;
use crate::config::ShapeFunctions;
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::points::pore_fluid::{LIQUID, SOLID};
use crate::points::vectors::vector4;
use colluvium_case::CaseErrorKind;

/// Load of a case on grid nodes, with its nodes.
#[derive(Debug)]
pub struct NodalLoad {
    /// Index into `Case::loads`.
    number: usize,
    /// Index of the loaded body; a node without material of this body has no load.
    body: u32,
    field: usize,
    /// Initial porosity, for a load on the pore fluid alone.
    porosity: Option<f64>,
    nodes: Vec<LoadedNode>,
}

/// Node with its share of a nodal load.
#[derive(Debug)]
struct LoadedNode {
    node: usize,
    /// Force at the full load (N).
    force: Vector4,
    /// Whether the node is an image of another one in a periodic grid.
    is_periodic_image: bool,
}

/// Returns the loads of a case that act on nodes.
pub fn nodal_loads<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    background: &BackgroundGrid<D>,
    sets: &[PointSet<D>],
) -> Result<Vec<NodalLoad>, CaseError> {
    let of_nodes = |number: &usize| case.loads[*number].applied_to() == LoadTarget::Nodes;
    let mut found = Vec::new();
    for number in (0..case.loads.len()).filter(of_nodes) {
        if matches!(options.shape, ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2) {
            let problem = "nodes is not available with cpdi and cpdi2, because their point domains extend \
                           beyond the side: use points";
            return Err(CaseError::new(
                format!("loads[{number}].applied_to"),
                CaseErrorKind::coded("incompatible-options", problem),
            ));
        }
        let set = &sets[point_loads::loaded_set(case, number, sets)?];
        let areas = if background.is_meshed() {
            mesh_loads::loaded_nodes(case, number, &background.mesh, set)?
        } else {
            loaded_grid_nodes(case, number, background, set)?
        };
        let layout = &background.layout;
        let per_area = vector4(&case.loads[number].per_area::<D>(), 0.0);
        let nodes = areas.into_iter().map(|(node, area)| {
            let row = layout.strides()[0];
            let repeated = layout.is_periodic_image(&layout.axis_indices(node / row, node % row));
            LoadedNode { node, force: per_area * area, is_periodic_image: repeated }
        });
        let fluid = set.pore.as_ref().and_then(|pore| pore.fluid);
        found.push(NodalLoad {
            number,
            body: set.body,
            field: set.field,
            porosity: fluid.filter(|_| case.loads[number].is_of_fluid()).map(|fluid| fluid.porosity),
            nodes: nodes.collect(),
        });
    }
    Ok(found)
}

/// Numbers and areas of the nodes on a loaded surface that is a grid line or plane.
fn loaded_grid_nodes<const D: usize>(
    case: &Case,
    number: usize,
    background: &BackgroundGrid<D>,
    set: &PointSet<D>,
) -> Result<BTreeMap<usize, f64>, CaseError> {
    let BackgroundGrid { grid, layout, basis_1d: basis, .. } = background;
    let load = &case.loads[number];
    let refuse = |problem: String| Err(CaseError::new(format!("loads[{number}].applied_to"), problem));
    let Some(side) = load.loaded_side() else { return Ok(BTreeMap::new()) };
    let (axis, sign) = (side.axis(), if side.is_max() { 1.0 } else { -1.0 });
    let outermost = set.points.position.iter().map(|x| sign * x[axis]).fold(f64::NEG_INFINITY, f64::max);
    let line = (sign * (outermost + 0.5 * set.extent[axis]) - grid.origin[axis]) / grid.cell;
    if (line - line.round()).abs() > 1e-6 {
        return refuse(format!(
            "the side lies {line:.6} cells from the side of the domain: loads on nodes need a side on a grid \
             line"
        ));
    }
    let line = line.round() as usize;
    if (1..grid.cells[axis]).contains(&line) && !basis.allows_interior_walls {
        return refuse(format!(
            "with {} shape functions, loads on nodes are available only on the sides of the domain",
            basis.name
        ));
    }
    let on_side = basis.face_node(line, grid.cells[axis]);
    let mut areas = BTreeMap::new();
    for (x, area) in set
        .points
        .position
        .iter()
        .zip(point_loads::loaded_areas(case, load, set))
        .filter(|(_, area)| *area != 0.0)
    {
        for_each_across(background, x, &set.extent, axis, |mut index, weight| {
            index[axis] = on_side;
            for index in layout.periodic_images(index) {
                let place: usize = (0..D).map(|axis| index[axis] * layout.strides()[axis]).sum();
                *areas.entry(place).or_insert(0.0) += area * weight;
            }
        });
    }
    Ok(areas)
}

/// Factor of a load at `time` (s).
fn load_factor<const D: usize>(
    clock: &Clock,
    bodies: &Bodies<D>,
    starts: &[f64],
    load: &NodalLoad,
    time: f64,
) -> f64 {
    let stands = bodies.sets.iter().any(|set| set.body == load.body);
    if stands { factor(&clock.case, load.number, starts, time) } else { 0.0 }
}

/// Adds the nodal loads at the end of the step to the forces on the nodes of one phase.
pub fn apply_nodal_loads<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    solved: &mut [NodalState],
    loads: &[NodalLoad],
    starts: &[f64],
) {
    for load in loads {
        let share = load_factor(clock, bodies, starts, load, clock.time + clock.dt);
        let nodes = &mut solved[load.field * background.layout.len()..];
        for at in &load.nodes {
            add_load(&mut nodes[at.node], at, share);
        }
    }
}

/// Adds the nodal loads at the end of the step to the forces on the nodes of both phases.
pub fn apply_phase_nodal_loads<const D: usize>(
    clock: &Clock,
    bodies: &Bodies<D>,
    loads: &[NodalLoad],
    starts: &[f64],
    nodes: &mut [[NodalState; 2]],
) {
    for load in loads {
        let share = load_factor(clock, bodies, starts, load, clock.time + clock.dt);
        let phase = if load.porosity.is_some() { LIQUID } else { SOLID };
        for at in &load.nodes {
            add_load(&mut nodes[at.node][phase], at, share);
        }
    }
}

/// Sums of the squared loads on the mixture and on the fluid, the latter weighted by its volume fraction (N²).
pub fn nodal_load_squares<const D: usize>(
    clock: &Clock,
    bodies: &Bodies<D>,
    loads: &[NodalLoad],
    starts: &[f64],
) -> [f64; 2] {
    let mut squares = [0.0; 2];
    for load in loads {
        let share = load.porosity.unwrap_or(1.0) * load_factor(clock, bodies, starts, load, clock.time);
        let own = load.nodes.iter().filter(|at| !at.is_periodic_image).map(|at| dot(at.force, at.force));
        squares[usize::from(load.porosity.is_some())] += share * share * own.sum::<f64>();
    }
    squares
}

/// Work of the nodal loads in the step on the nodes of one phase (J).
pub fn nodal_load_work<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    solved: &[NodalState],
    loads: &[NodalLoad],
    starts: &[f64],
) -> f64 {
    let len = background.layout.len();
    work_with(clock, bodies, loads, starts, |load, place| solved[load.field * len + place].momentum_and_mass)
}

/// Work of the nodal loads in the step on the nodes of both phases (J). For loads on the fluid it is the work that exceeds that on the
/// mixture.
pub fn phase_nodal_load_work<const D: usize>(
    clock: &Clock,
    bodies: &Bodies<D>,
    loads: &[NodalLoad],
    starts: &[f64],
    nodes: &[[NodalState; 2]],
) -> f64 {
    work_with(clock, bodies, loads, starts, |load, place| {
        let [solid, liquid] = [SOLID, LIQUID].map(|phase| nodes[place][phase].momentum_and_mass);
        load.porosity.map_or(solid, |n| (liquid - solid) * n)
    })
}

/// Work of the nodal loads in a step (J), with the velocities of the loaded nodes.
fn work_with<const D: usize>(
    clock: &Clock,
    bodies: &Bodies<D>,
    loads: &[NodalLoad],
    starts: &[f64],
    velocity: impl Fn(&NodalLoad, usize) -> Vector4,
) -> f64 {
    let of_load = |load: &NodalLoad| {
        let own = load.nodes.iter().filter(|at| !at.is_periodic_image);
        let power: f64 = own.map(|at| dot(at.force, velocity(load, at.node))).sum();
        load_factor(clock, bodies, starts, load, clock.time + clock.dt) * power
    };
    clock.dt * loads.iter().map(of_load).sum::<f64>()
}

/// Adds a fraction of a load to the force on a node, if the node has mass.
fn add_load(node: &mut NodalState, at: &LoadedNode, share: f64) {
    if node.momentum_and_mass.as_array()[3] > 0.0 {
        node.force += at.force * share;
    }
}

/// Scalar product of the first three lanes, of which the fourth of `force` is zero.
fn dot(force: Vector4, other: Vector4) -> f64 {
    force.as_array().iter().zip(other.as_array()).map(|(a, b)| a * b).sum()
}
