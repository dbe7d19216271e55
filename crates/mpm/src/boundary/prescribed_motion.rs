//! Prescribed motion of rigid bodies and of patches of nodes (sheet: mpm §2.11: prescribed velocities, also on nodes without material).

use std::ops::Range;

use colluvium_case::Case;
use colluvium_case::description::Patch;
use colluvium_grid::{NodalState, Vector4};

use crate::MpmOptions;
use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::config::LagrangianFormulation;
use crate::contact::contact_law::FieldContacts;
use crate::momentum::driven_object::{DrivenObject, DrivenObjectState};
use crate::points::pore_fluid::{LIQUID, SOLID};

/// Tolerance for nodes on the surface of a patch, in cells or in least heights of mesh elements.
const SURFACE_TOLERANCE: f64 = 1e-6;

impl DrivenObject {
    /// Returns the patch at its current position; `None` for a rigid body. With points at fixed positions the patch is fixed too.
    fn placed_patch<'a>(&self, case: &'a Case, options: &MpmOptions) -> Option<PlacedPatch<'a>> {
        let patch = &case.patches[self.patch?];
        let moves = patch.moves && options.formulation != LagrangianFormulation::SmallDisplacement;
        let displacement = if moves { self.state.displacement } else { [0.0; 3] };
        Some(PlacedPatch { patch, bounds: self.bounds, displacement })
    }
}

/// Returns the rigid bodies and patches of the case.
pub fn driven_objects(case: &Case) -> Vec<DrivenObject> {
    let new = |name: &String, patch| DrivenObject {
        name: name.clone(),
        patch,
        bounds: patch.map_or([[0.0; 3]; 2], |patch: usize| {
            let (low, high) = case.patches[patch].region.bounds(case.dimension());
            [low, high].map(|corner| std::array::from_fn(|c| corner.get(c).copied().unwrap_or(0.0)))
        }),
        previous_velocity: [None; 3],
        free_rigid_body: None,
        state: DrivenObjectState::default(),
    };
    let bodies = case.bodies.iter().filter(|body| body.rigid).map(|body| new(&body.name, None));
    let patches = case.patches.iter().enumerate().map(|(number, patch)| new(&patch.name, Some(number)));
    bodies.chain(patches).collect()
}

/// Patch at its current position.
struct PlacedPatch<'a> {
    patch: &'a Patch,
    bounds: [[f64; 3]; 2],
    displacement: [f64; 3],
}

impl PlacedPatch<'_> {
    /// Corners of the bounding box of the patch (m).
    fn bounding_corners(&self) -> [[f64; 3]; 2] {
        self.bounds.map(|corner| std::array::from_fn(|c| corner[c] + self.displacement[c]))
    }

    /// Phases whose velocities the patch prescribes, out of `count`.
    fn phases(&self, count: usize) -> Range<usize> {
        SOLID..if self.patch.drained { LIQUID } else { count }
    }

    /// Whether the patch contains a position (m) in its bounding box, with a tolerance for round-off on the box.
    fn contains<const D: usize>(&self, x: &[f64; D]) -> bool {
        let [low, high] = self.bounds;
        let start: [f64; D] = std::array::from_fn(|c| (x[c] - self.displacement[c]).clamp(low[c], high[c]));
        self.patch.region.contains(&start)
    }

    /// Calls `visit` for each node of the patch, with its index in memory and whether it is the first of the periodic images of the node.
    /// Where the patch reaches a side of the domain, the nodes beyond that side belong to it.
    fn nodes<const D: usize>(
        &self,
        BackgroundGrid { grid, mesh, layout, basis_1d: basis, .. }: &BackgroundGrid<D>,
        mut visit: impl FnMut(usize, bool),
    ) {
        let [low, high] = self.bounding_corners();
        let slack = SURFACE_TOLERANCE * if mesh.is_empty() { grid.cell } else { mesh.height() };
        let inside = |axis: usize, x: f64| (low[axis] - slack..=high[axis] + slack).contains(&x);
        if !mesh.is_empty() {
            for (number, x) in mesh.nodes().iter().enumerate() {
                if (0..D).all(|axis| inside(axis, x[axis])) && self.contains(x) {
                    visit(number, true);
                }
            }
            return;
        }
        let (shape, strides, upper) = (layout.nodes(), layout.strides(), grid.upper());
        // Coordinate of a node in the box, in the domain or in its next image.
        let within = |axis: usize, index: usize| {
            let (low, high) = (grid.origin[axis], upper[axis]);
            let x = low + grid.cell * basis.coordinate(index, grid.cells[axis]);
            if layout.is_periodic(axis) {
                let width = high - low;
                return [x, x - width, x + width].into_iter().find(|x| inside(axis, *x));
            }
            Some(x.clamp(low, high)).filter(|x| inside(axis, *x))
        };
        // Nodes along each axis, from the first to the last in the box.
        let range: [Range<usize>; 3] = std::array::from_fn(|axis| {
            if axis >= D {
                return 0..1;
            }
            let mut indices = (0..shape[axis]).filter(|index| within(axis, *index).is_some());
            let first = indices.next().unwrap_or(0);
            first..indices.next_back().unwrap_or(first) + 1
        });
        let place = |index: &[usize; 3]| -> Option<[f64; D]> {
            let mut x = [0.0; D];
            for axis in 0..D {
                x[axis] = within(axis, index[axis])?;
            }
            Some(x)
        };
        for i in range[0].clone() {
            for j in range[1].clone() {
                for k in range[2].clone() {
                    let index = [i, j, k];
                    if place(&index).is_some_and(|x| self.contains(&x)) {
                        let number = (0..D).map(|axis| index[axis] * strides[axis]).sum();
                        visit(number, !layout.is_periodic_image(&index));
                    }
                }
            }
        }
    }
}

/// Numbers of the patches that contain no node at the start.
pub fn empty_patches<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
) -> Vec<usize> {
    let is_empty = |driven: &&DrivenObject| {
        let mut nodes = 0;
        let Some(place) = driven.placed_patch(&clock.case, &clock.options) else { return false };
        place.nodes(background, |_, _| nodes += 1);
        nodes == 0
    };
    driven.iter().filter(is_empty).filter_map(|driven| driven.patch).collect()
}

/// Imposes velocity and acceleration of the prescribed motion on the solved nodes of the patches, and adds the force to `books`. Components
/// whose prescription begins in the step start from the velocity of the node.
pub fn impose_patch_velocity<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &mut [DrivenObject],
    contacts: &FieldContacts,
    solved: &mut [NodalState],
    books: bool,
) {
    impose_on_solved(clock, background, driven, contacts, one_phase(solved), books);
}

/// Imposes the motion of the patches on the nodes of the skeleton, and of the pore fluid where the patch is impermeable.
pub fn impose_phase_patch_velocity<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &mut [DrivenObject],
    contacts: &FieldContacts,
    nodes: &mut [[NodalState; 2]],
) {
    impose_on_solved(clock, background, driven, contacts, nodes, true);
}

/// Prescribes the velocities of rigid bodies and patches at solved nodes and records their impulses.
fn impose_on_solved<const N: usize, const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &mut [DrivenObject],
    contacts: &FieldContacts,
    nodes: &mut [[NodalState; N]],
    books: bool,
) {
    let keep_start = clock.keeps_initial_velocity();
    let inertia = if books { clock.options.mass_scaling } else { 0.0 };
    for driven in driven {
        let mut total = [0.0; 3];
        for_nodes_of_patch(clock, background, contacts, driven, nodes, |node, first| {
            let impulse = driven.impose_on_node(node, keep_start, clock.dt);
            if first {
                (0..D).for_each(|c| total[c] += inertia * impulse[c]);
            }
        });
        driven.add_impulse(total, clock.dt);
    }
}

/// Marks the velocity components that patches prescribe, for both phases, one bit per axis.
pub fn mark_constrained<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    constrained: &mut [[u8; 2]],
) {
    for_patch_nodes(clock, background, driven, contacts, constrained, |driven, constrained| {
        let axes = (0..D).filter(|c| driven.state.velocity[*c].is_some());
        *constrained |= axes.map(|c| 1 << c).sum::<u8>();
    });
}

/// Imposes the velocity of the patches on their re-mapped nodes.
pub fn impose_patch_velocity_remapped<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    remapped: &mut [Vector4],
) {
    for_patch_nodes(clock, background, driven, contacts, one_phase(remapped), DrivenObject::impose_velocity);
}

/// Imposes the velocity of the patches on the re-mapped nodes of two phases.
pub fn impose_phase_patch_velocity_remapped<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    nodes: &mut [[Vector4; 2]],
) {
    for_patch_nodes(clock, background, driven, contacts, nodes, DrivenObject::impose_velocity);
}

/// Sets the re-mapped velocity components that patches prescribe to zero.
pub fn clear_patch_components<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    remapped: &mut [Vector4],
) {
    for_patch_nodes(clock, background, driven, contacts, one_phase(remapped), |driven, rest| {
        let free = driven.state.velocity.map(|v| f64::from(u8::from(v.is_none())));
        *rest *= Vector4::new([free[0], free[1], free[2], 1.0]);
    });
}

/// Applies an action to the nodes of each patch and rigid body.
fn for_patch_nodes<T, const N: usize, const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    driven: &[DrivenObject],
    contacts: &FieldContacts,
    nodes: &mut [[T; N]],
    act: impl Fn(&DrivenObject, &mut T),
) {
    for driven in driven {
        for_nodes_of_patch(clock, background, contacts, driven, nodes, |value, _| act(driven, value));
    }
}

/// Calls `act` for each node of a patch in all fields of deformable bodies and in the phases that the patch prescribes. Its arguments are
/// the value of the node and whether it is the first of its periodic images.
fn for_nodes_of_patch<T, const N: usize, const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    contacts: &FieldContacts,
    driven: &DrivenObject,
    nodes: &mut [[T; N]],
    mut act: impl FnMut(&mut T, bool),
) {
    let Some(place) = driven.placed_patch(&clock.case, &clock.options) else { return };
    let len = background.layout.len();
    for field in deformable_fields(nodes.len() / len, &contacts.rigid) {
        place.nodes(background, |number, first| {
            let values = &mut nodes[field * len + number][place.phases(N)];
            values.iter_mut().for_each(|value| act(value, first));
        });
    }
}

/// Nodes of one phase as arrays of length one, which is the layout for several phases.
fn one_phase<T>(nodes: &mut [T]) -> &mut [[T; 1]] {
    nodes.as_chunks_mut().0
}

/// Returns the velocity fields of deformable bodies.
fn deformable_fields(fields: usize, rigid: &[Option<usize>]) -> impl Iterator<Item = usize> {
    (0..fields).filter(|field| rigid.get(*field).is_none_or(Option::is_none))
}
