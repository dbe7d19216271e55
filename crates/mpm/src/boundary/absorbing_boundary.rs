//! Absorbing boundaries: viscous dashpots and springs (Lysmer & Kuhlemeyer 1969; sheet: mpm §2.11).
//!
//! Dashpots `t_n = -a ρ c_P v_n`, `t_t = -b ρ c_S v_t` on the face, and springs `t = -(E/δ) u` against creep where the
//! case gives their length. With a pore fluid the skeleton's dashpot is that of the undrained mixture, `ρ c_1`, and the
//! liquid has its own, `n ρ_L √(K_L/ρ_L)`. Velocities are those at the end of the step: stable at any step.
//!
//! The area of a node is the share of the face of the points in the layer of cells behind it, at their initial positions.

use std::collections::BTreeMap;

use colluvium_case::description::{Boundary, Wall as CaseWall};
use colluvium_case::spatial;
use colluvium_constitutive::{BLOCK_SIZE, Motion};
use colluvium_grid::{BasisValues1d, Grid, NodalState, NodeWalls, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::points::pore_fluid::{LIQUID, SOLID};

/// Absorbing boundaries of a stage.
#[derive(Debug, Default)]
pub struct AbsorbingBoundaries {
    faces: Vec<AbsorbingFace>,
    /// Displacements of the nodes of each face (m), by the number of the boundary.
    pub displacements: BTreeMap<usize, Vec<[f64; 3]>>,
    /// Initial positions (m) of the points behind the faces of all stages, by id.
    initial_positions: BTreeMap<u32, [f64; 3]>,
    /// Wave impedances of the bodies of the case; empty without absorbing boundaries.
    impedances: Vec<Impedance>,
}

/// Absorbing face of the domain, with viscous dashpots at its nodes.
#[derive(Debug)]
struct AbsorbingFace {
    /// Index into `Case::boundaries`.
    number: usize,
    nodes: Vec<FaceNode>,
}

/// Dashpots and springs of a node of a face, component by component.
#[derive(Clone, Copy, Debug, Default)]
struct FaceNode {
    /// Number of the node.
    node: usize,
    index: [usize; 3],
    /// Dashpot coefficients of the skeleton or the single phase (N s/m).
    solid: [f64; 3],
    /// Dashpot coefficients of the liquid (N s/m).
    liquid: [f64; 3],
    /// Spring stiffnesses (N/m).
    spring: [f64; 3],
}

impl FaceNode {
    /// Adds the dashpots and springs of a part of the face with the area `share` (m²) to a node.
    fn add(&mut self, law: &DashpotLaw, impedance: &Impedance, share: f64) {
        for c in 0..3 {
            let (dashpot, modulus) = if c == law.axis {
                self.liquid[c] += law.normal * impedance.liquid * share;
                (law.normal * impedance.normal, impedance.modulus)
            } else {
                (law.tangential * impedance.shear, impedance.shear_modulus)
            };
            self.solid[c] += dashpot * share;
            if let Some(length) = law.spring_length {
                self.spring[c] += modulus / length * share;
            }
        }
    }
}

/// Wave impedances of a body's material: `ρ c_P`, `ρ c_S` (Pa s/m), P-wave and shear modulus (Pa), and the liquid's `n ρ_L c_L` (Pa s/m).
#[derive(Clone, Copy, Debug, Default)]
pub struct Impedance {
    normal: f64,
    shear: f64,
    modulus: f64,
    shear_modulus: f64,
    liquid: f64,
}

impl Impedance {
    /// Returns the impedances from the mean moduli of the points of a body at the start. Mass scaling `inertia` slows waves and is
    /// included.
    pub fn of_body<const D: usize>(set: &PointSet<D>, inertia: f64) -> Self {
        let (mut modulus, mut shear_modulus) = (0.0, 0.0);
        let share = 1.0 / set.points.stress.len() as f64;
        for (block, (stress, states)) in
            set.points.stress.chunks(BLOCK_SIZE).zip(set.states.blocks()).enumerate()
        {
            let mut moduli = [0.0; BLOCK_SIZE];
            set.material.wave_moduli(stress, states, &mut moduli[..stress.len()]);
            for (k, stress) in stress.iter().enumerate() {
                let p = block * BLOCK_SIZE + k;
                let density = set.points.mass[p] / set.points.volume[p];
                let motion = Motion { density, size: set.extent[0], ..Motion::AT_REST };
                modulus += share * moduli[k];
                let tangent = set.material.tangent(&motion, stress, states, k);
                shear_modulus += share * tangent.map_or(0.0, |tangent| tangent.0[3][3].max(0.0));
            }
        }
        let dry = set.points.mass[0] / set.points.volume[0];
        let fluid = set.pore.as_ref().and_then(|pore| pore.fluid);
        let (density, stiff, liquid) = fluid.map_or((dry, modulus, 0.0), |fluid| {
            let n = fluid.porosity;
            let own = n * (fluid.density * fluid.bulk_modulus).sqrt();
            (dry + n * fluid.density, modulus + fluid.bulk_modulus / n, own)
        });
        Self {
            normal: (inertia * density * stiff).sqrt(),
            shear: (inertia * density * shear_modulus).sqrt(),
            modulus,
            shear_modulus,
            liquid: inertia.sqrt() * liquid,
        }
    }
}

/// Dashpot parameters of a face from the case.
#[derive(Clone, Copy)]
struct DashpotLaw {
    axis: usize,
    is_upper: bool,
    /// Grid line of the face, counted in cells.
    face: usize,
    normal: f64,
    tangential: f64,
    spring_length: Option<f64>,
}

/// Dashpot parameters of a boundary; `None` if it is not absorbing.
fn dashpot_law<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    boundary: &Boundary,
) -> Option<DashpotLaw> {
    let CaseWall::Absorbing { normal, tangential, spring_length } = boundary.wall else { return None };
    let axis = boundary.side.axis();
    let line =
        (boundary.wall_coordinate(&clock.case.domain) - background.grid.origin[axis]) / background.grid.cell;
    let (face, is_upper) = (line.round() as usize, boundary.side.is_max());
    Some(DashpotLaw { axis, is_upper, face, normal, tangential, spring_length })
}

impl AbsorbingBoundaries {
    /// Returns the boundaries of no stage yet, with the wave impedances of the bodies of the case.
    pub fn new(impedances: Vec<Impedance>) -> Self {
        Self { impedances, ..Self::default() }
    }

    /// Stores the initial positions of the points in the cells at absorbing faces.
    pub fn store_initial_positions<const D: usize>(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &Bodies<D>,
    ) {
        let boundaries = clock.case.boundaries.iter();
        let laws: Vec<DashpotLaw> =
            boundaries.filter_map(|boundary| dashpot_law(clock, background, boundary)).collect();
        for set in &bodies.sets {
            for (id, x) in set.points.id.iter().zip(&set.points.position) {
                if laws.iter().any(|law| is_behind_face(&background.grid, law, x)) {
                    self.initial_positions.insert(*id, spatial(x));
                }
            }
        }
    }

    /// Sets the absorbing boundaries of a stage. Springs of faces that the previous stage also had keep their displacements.
    pub fn set_stage<const D: usize>(
        &mut self,
        clock: &Clock,
        background: &BackgroundGrid<D>,
        bodies: &Bodies<D>,
        stage: usize,
    ) {
        let mut faces = Vec::new();
        for (number, boundary) in clock.case.active_boundaries(stage) {
            let Some(law) = dashpot_law(clock, background, boundary) else { continue };
            faces.push(AbsorbingFace { number, nodes: self.face_nodes(background, bodies, &law) });
        }
        self.displacements.retain(|number, _| faces.iter().any(|face| face.number == *number));
        for face in &faces {
            let nodes = self.displacements.entry(face.number).or_default();
            if nodes.len() != face.nodes.len() {
                *nodes = vec![[0.0; 3]; face.nodes.len()];
            }
        }
        self.faces = faces;
    }

    /// Returns the nodes of a face with their dashpots, in ascending order of node number.
    fn face_nodes<const D: usize>(
        &self,
        background: &BackgroundGrid<D>,
        bodies: &Bodies<D>,
        law: &DashpotLaw,
    ) -> Vec<FaceNode> {
        let (grid, strides) = (&background.grid, background.layout.strides());
        let normal_index = background.basis_1d.face_node(law.face, grid.cells[law.axis]);
        let mut found: BTreeMap<usize, FaceNode> = BTreeMap::new();
        for (_, start, number, p) in self.points_behind(&background.grid, bodies, law) {
            let set = &bodies.sets[number];
            let impedance = &self.impedances[set.body as usize];
            let mut area = set.points.initial_volume[p] / grid.cell;
            if background.axisymmetric && law.axis == 0 {
                // The volume is per radian at the radius of the point.
                area *= (grid.origin[0] + grid.cell * law.face as f64) / start[0];
            }
            for_each_across(background, &start, &set.extent, law.axis, |mut index, weight| {
                index[law.axis] = normal_index;
                for index in background.layout.periodic_images(index) {
                    let place = (0..D).map(|axis| index[axis] * strides[axis]).sum();
                    let node =
                        found.entry(place).or_insert(FaceNode { node: place, index, ..FaceNode::default() });
                    node.add(law, impedance, area * weight);
                }
            });
        }
        found.into_values().collect()
    }

    /// Points in the cells at a face: id, initial position (m), set and index in the set. The order is by id, so that sums do not depend on
    /// the current sorting.
    fn points_behind<const D: usize>(
        &self,
        grid: &Grid<D>,
        bodies: &Bodies<D>,
        law: &DashpotLaw,
    ) -> Vec<(u32, [f64; D], usize, usize)> {
        let mut points = Vec::new();
        for (number, set) in bodies.sets.iter().enumerate() {
            for (p, id) in set.points.id.iter().enumerate() {
                let Some(start) = self.initial_positions.get(id) else { continue };
                let start: [f64; D] = std::array::from_fn(|c| start[c]);
                if is_behind_face(grid, law, &start) {
                    points.push((*id, start, number, p));
                }
            }
        }
        points.sort_unstable_by_key(|(id, ..)| *id);
        points
    }

    /// Applies dashpot and spring forces to the solved nodes of one phase.
    pub fn apply(&mut self, clock: &Clock, solved: &mut [NodalState], walls: &NodeWalls) {
        let (dt, inertia) = (clock.dt, clock.options.mass_scaling);
        for face in &self.faces {
            let Some(moved) = self.displacements.get_mut(&face.number) else { continue };
            for (at, moved) in face.nodes.iter().zip(moved) {
                let node = &mut solved[at.node];
                let mass = inertia * node.momentum_and_mass.as_array()[3];
                if mass > 0.0 {
                    let free = walls.free_components(&at.index);
                    dashpot_velocity(node, mass, &at.solid, &at.spring, moved, &free, dt);
                }
            }
        }
    }

    /// Applies dashpot and spring forces to the solved nodes of both phases, each with its walls.
    pub fn apply_to_phases(
        &mut self,
        clock: &Clock,
        nodes: &mut [[NodalState; 2]],
        [walls, walls_of_liquid]: [&NodeWalls; 2],
    ) {
        let (dt, inertia) = (clock.dt, clock.options.mass_scaling);
        for face in &self.faces {
            let Some(moved) = self.displacements.get_mut(&face.number) else { continue };
            for (at, moved) in face.nodes.iter().zip(moved) {
                let node = &mut nodes[at.node];
                let [solid, liquid] =
                    [SOLID, LIQUID].map(|phase| node[phase].momentum_and_mass.as_array()[3]);
                if solid <= 0.0 {
                    continue;
                }
                let free_solid = walls.free_components(&at.index);
                if liquid > 0.0 {
                    let before = node[LIQUID].momentum_and_mass;
                    let free = walls_of_liquid.free_components(&at.index);
                    let (moving, inert) = (&mut node[LIQUID], inertia * liquid);
                    dashpot_velocity(moving, inert, &at.liquid, &[0.0; 3], &mut [0.0; 3], &free, dt);
                    // The skeleton takes the part of the force on the mixture that the liquid no longer takes.
                    let [x, y, z] = free_solid;
                    let back = (before - node[LIQUID].momentum_and_mass)
                        * Vector4::new([x, y, z, 0.0])
                        * (liquid / solid);
                    node[SOLID].momentum_and_mass += back;
                    node[SOLID].force += back * (1.0 / dt);
                }
                dashpot_velocity(
                    &mut node[SOLID],
                    inertia * solid,
                    &at.solid,
                    &at.spring,
                    moved,
                    &free_solid,
                    dt,
                );
            }
        }
    }
}

/// Returns the velocity `v` (m/s) from `m (v - v*)/dt = -D v - k (u + dt v)`, with the velocity `v*` of the node without the dashpot.
fn dashpot_velocity(
    node: &mut NodalState,
    mass: f64,
    dashpot: &[f64; 3],
    spring: &[f64; 3],
    moved: &mut [f64; 3],
    free: &[f64; 3],
    dt: f64,
) {
    let (mut motion, mut rate) = (node.momentum_and_mass.to_array(), node.force.to_array());
    for c in 0..3 {
        if free[c] > 0.0 {
            let spring_impulse = dt * spring[c] * moved[c];
            let slower = (mass * motion[c] - spring_impulse) / (mass + dt * dashpot[c] + dt * dt * spring[c]);
            rate[c] += (slower - motion[c]) / dt;
            motion[c] = slower;
        }
        moved[c] += dt * motion[c];
    }
    node.momentum_and_mass = Vector4::new(motion);
    node.force = Vector4::new(rate);
}

/// Whether a position is in the layer of cells at a face.
fn is_behind_face<const D: usize>(grid: &Grid<D>, law: &DashpotLaw, position: &[f64; D]) -> bool {
    let place = (position[law.axis] - grid.origin[law.axis]) / grid.cell - law.face as f64;
    if law.is_upper { place > -1.0 && place < 0.0 } else { place > 0.0 && place < 1.0 }
}

/// Calls `visit` for the nodes in the plane at `position` along an axis (m), with their weights in the other directions.
pub fn for_each_across<const D: usize>(
    BackgroundGrid { grid, basis_1d: basis, .. }: &BackgroundGrid<D>,
    position: &[f64; D],
    extent: &[f64; D],
    axis: usize,
    mut visit: impl FnMut([usize; 3], f64),
) {
    let inverse = 1.0 / grid.cell;
    let on: [BasisValues1d; D] = std::array::from_fn(|axis| {
        let x = (position[axis] - grid.origin[axis]) * inverse;
        basis.evaluate(x, extent[axis] * inverse, grid.cells[axis])
    });
    let count = on[0].count;
    for number in 0..count.pow(D as u32 - 1) {
        let (mut rest, mut index, mut weight) = (number, [0; 3], 1.0);
        for other in (0..D).filter(|other| *other != axis) {
            index[other] = on[other].first + rest % count;
            weight *= on[other].weights()[rest % count];
            rest /= count;
        }
        if weight > 0.0 {
            visit(index, weight);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::setup::tests::initial_solver;
    use colluvium_case::Case;

    #[test]
    fn a_mantle_has_the_area_of_its_own_radius() {
        // 0.3 m high, per radian; ρ c_P = √(1000 · 1e6) Pa s/m.
        for (low, radius) in [(0.0, 0.5), (0.0, 1.0), (0.5, 1.0)] {
            let text = serde_json::json!({
                "title": "ring", "space": "axisymmetric", "domain": { "min": [low, 0], "max": [1, 0.3] }, "gravity": [0, 0],
                "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [low, 0], "max": [radius, 0.3] } }],
                "boundaries": [{ "side": "x-max", "position": radius, "wall": { "kind": "absorbing" } }],
                "stages": [{ "name": "s", "duration": 1 }],
                "methods": { "mpm": { "cell_size": 0.1, "shape": "linear" } }
            });
            let case = Case::from_json(&text.to_string()).unwrap();
            let solver = initial_solver::<2>(&case);
            let dashpot: f64 =
                solver.boundary.absorbing.faces[0].nodes.iter().map(|node| node.solid[0]).sum();
            let exact = 1e9f64.sqrt() * 0.3 * radius;
            assert!((dashpot / exact - 1.0).abs() < 1e-12, "{low}, {radius}: {dashpot} for {exact}");
        }
    }
}
