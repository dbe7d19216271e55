//! The contact substep: what the laws of [`crate::contact`] do to the nodes (sheet: mpm §3.6).

use colluvium_constitutive::BLOCK;
use colluvium_grid::{Axis, Lanes, Mesh, Node, Walls, Window};

use crate::background::Background;
use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::clock::Clock;
use crate::contact::{ContactLaw, Contacts, Given, Interface, Pair, RowTouch};
use crate::driven::Driven;
use crate::gap::{SurfaceDistance, THIN};
use crate::nodes::Nodes;
use crate::vectors::{dot, norm, three};

/// Most sweeps over the pairs of three or more bodies, whose contacts act on each other.
const SWEEPS: usize = 30;
/// Change of velocity over velocity below which a sweep changes nothing.
const SETTLED: f64 = 1e-12;

/// Room for what the rows of nodes report, pair after pair. Only where bodies are gone through more than once does a
/// force or a strength have to last for all sweeps.
pub fn rows(contacts: &Contacts, count: usize, length: usize) -> Vec<RowTouch> {
    let row = |pair: &Pair| {
        let lasts = pair.law.is_some_and(|law| law.penalty.is_some() || law.adhesion > 0.0);
        let nodes = if lasts && contacts.fields() > 2 { length } else { 0 };
        RowTouch { given: vec![Given::default(); nodes], ..RowTouch::default() }
    };
    contacts.pairs.iter().flat_map(|pair| std::iter::repeat_n(row(pair), count)).collect()
}

/// Two fields of `len` nodes each, borrowed together.
fn two<T>(nodes: &mut [T], len: usize, [first, second]: [usize; 2]) -> [&mut [T]; 2] {
    let (low, high) = nodes.split_at_mut(second * len);
    [&mut low[first * len..(first + 1) * len], &mut high[..len]]
}

/// What the contact of a pair of fields needs at every node.
struct Touch<'a> {
    law: Option<ContactLaw>,
    /// Fields of rigid bodies.
    rigid: [bool; 2],
    /// Surface integrals of the two fields, node by node.
    surfaces: [&'a [Lanes]; 2],
    distance: &'a SurfaceDistance,
    walls: &'a Walls,
    keep_start: bool,
    light: f64,
    inertia: f64,
    /// Volume over the cell size (m²) from which a rigid body holds a node, node by node.
    filled: &'a [f64],
    /// Radii of the nodes (m) in axisymmetry; empty elsewhere.
    radii: &'a [f64],
    cell: f64,
    dt: f64,
}

impl Touch<'_> {
    /// Inertias (kg) of the two sides: infinite for a rigid body.
    fn inertias(&self, masses: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|side| if self.rigid[side] { f64::INFINITY } else { self.inertia * masses[side] })
    }

    /// Whether there is enough of both bodies at the node.
    fn present(&self, place: usize, masses: [f64; 2]) -> bool {
        let filled = |side: usize| self.surfaces[side][place].as_array()[3] >= self.filled[place];
        masses.iter().all(|mass| *mass > self.light) && (0..2).all(|side| !self.rigid[side] || filled(side))
    }

    /// The interface at a node, by a law.
    fn interface(&self, place: usize, law: &ContactLaw) -> Option<Interface> {
        let surface = law.surface(self.surfaces.map(|surfaces| surfaces[place]), self.distance)?;
        // Of the section until here.
        let around = self.radii.get(place).copied().unwrap_or(1.0);
        Some(Interface { area: around * surface.area, ..surface })
    }

    /// Lets two solved nodes act on each other; says whether that changes anything, and which impulse (N s) the first
    /// one takes.
    fn solved(
        &self,
        place: usize,
        index: &[usize; 3],
        pair: [&mut Node; 2],
        given: &mut Given,
    ) -> Option<(bool, [f64; 3])> {
        let masses = [pair[0].motion.as_array()[3], pair[1].motion.as_array()[3]];
        if !self.present(place, masses) {
            return None;
        }
        let ends = [three(pair[0].motion), three(pair[1].motion)];
        let inertias = self.inertias(masses);
        let touched = self.velocities(place, inertias, [&ends[0], &ends[1]], given)?;
        let side = usize::from(self.rigid[0]);
        let moved: [f64; 3] = std::array::from_fn(|c| touched[side][c] - ends[side][c]);
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let impulse = moved.map(|v| sign * inertias[side] * v);
        let changed = norm(&moved) > SETTLED * norm(&ends[side]).max(norm(&touched[side]));
        for (side, node) in pair.into_iter().enumerate().filter(|(side, _)| !self.rigid[*side]) {
            let rate = three(node.force);
            let mut start: [f64; 3] = std::array::from_fn(|c| ends[side][c] - self.dt * rate[c]);
            let mut end = touched[side];
            self.walls.constrain(index, &mut start, &mut end, self.keep_start);
            node.motion = Lanes::new([end[0], end[1], end[2], masses[side]]);
            let rate = |c: usize| (end[c] - start[c]) / self.dt;
            node.force = Lanes::new([rate(0), rate(1), rate(2), 0.0]);
        }
        Some((changed, impulse))
    }

    /// Velocities after contact; `None` without it.
    fn velocities(
        &self,
        place: usize,
        inertias: [f64; 2],
        ends: [&[f64; 3]; 2],
        given: &mut Given,
    ) -> Option<[[f64; 3]; 2]> {
        let common = together(inertias, ends);
        let Some(law) = &self.law else { return Some([common; 2]) };
        let surface = self.interface(place, law)?;
        let impulse = law.impulse(inertias, ends, surface, [self.cell, self.dt], given)?;
        let moved = |side: usize, sign: f64| -> [f64; 3] {
            std::array::from_fn(|c| ends[side][c] + sign * impulse[c] / inertias[side])
        };
        let touched = [moved(0, 1.0), moved(1, -1.0)];
        // What sticks has the same velocity to the last bit: re-mapping asks for it.
        let relative: [f64; 3] = std::array::from_fn(|c| touched[0][c] - touched[1][c]);
        let before: [f64; 3] = std::array::from_fn(|c| ends[0][c] - ends[1][c]);
        Some(if norm(&relative) <= 1e-12 * norm(&before) { [common; 2] } else { touched })
    }

    /// Re-mapped velocities: no approach; what touched does not part, or the force between the bodies would do work; and
    /// what stuck sticks.
    fn again(&self, place: usize, solved: [&Node; 2], pair: [&mut Lanes; 2]) {
        let masses = [solved[0].motion.as_array()[3], solved[1].motion.as_array()[3]];
        if !self.present(place, masses) {
            return;
        }
        let velocities = [three(*pair[0]), three(*pair[1])];
        let common = together(self.inertias(masses), [&velocities[0], &velocities[1]]);
        let ends = [three(solved[0].motion), three(solved[1].motion)];
        let apart: [f64; 3] = std::array::from_fn(|c| ends[0][c] - ends[1][c]);
        let slight = 1e-9 * norm(&ends[0]);
        let stuck = norm(&apart) <= slight;
        let mut after = [common; 2];
        if let Some(law) = &self.law {
            // A penalty is a force like others, and has acted.
            if law.penalty.is_some() {
                return;
            }
            let Some(Interface { normal, .. }) = self.interface(place, law) else { return };
            let relative: [f64; 3] = std::array::from_fn(|c| velocities[0][c] - velocities[1][c]);
            let touched = dot(&apart, &normal).abs() <= slight;
            if !(touched || dot(&relative, &normal) > 0.0) {
                return;
            }
            if !stuck {
                for side in 0..2 {
                    let excess: [f64; 3] = std::array::from_fn(|c| velocities[side][c] - common[c]);
                    let into = dot(&excess, &normal);
                    after[side] = std::array::from_fn(|c| velocities[side][c] - into * normal[c]);
                }
            }
        }
        for (velocity, after) in pair.into_iter().zip(after) {
            *velocity = Lanes::new([after[0], after[1], after[2], 0.0]);
        }
    }
}

/// The velocity of two masses together, one of which may be infinite.
fn together(masses: [f64; 2], velocities: [&[f64; 3]; 2]) -> [f64; 3] {
    let inverse = masses.map(f64::recip);
    let sum = inverse[0] + inverse[1];
    std::array::from_fn(|c| (inverse[1] * velocities[0][c] + inverse[0] * velocities[1][c]) / sum)
}

/// Surface integrals `Σ_p Ω_p ∇N_i` of the bodies, for normals, areas and distances. In axisymmetry they are those
/// of the section.
pub fn scatter_surfaces<const D: usize>(
    background: &Background<D>,
    bodies: &Bodies<D>,
    walls: &Walls,
    contacts: &mut Contacts,
) {
    let Background { layout, sweeps, axisymmetric, .. } = background;
    let (ground, length) = (background.ground(), layout.strides()[0]);
    for (field, nodes) in contacts.surfaces.chunks_exact_mut(layout.len()).enumerate() {
        layout.reset(nodes);
        layout.scatter(nodes, |slab, window, offset| {
            let (mut volumes, mut columns) = ([Lanes::ZERO; BLOCK], [[Lanes::ZERO; D]; BLOCK]);
            for set in bodies.sets.iter().filter(|set| set.field == field) {
                let domain = set.domain.as_slice();
                for block in set.blocks_of(slab) {
                    for (k, p) in block.clone().enumerate() {
                        let section = set.points.volume[p]
                            / if *axisymmetric { set.points.position[p][0] } else { 1.0 };
                        columns[k] = std::array::from_fn(|j| {
                            let at = |i: usize| if i == j { section } else { 0.0 };
                            Lanes::new([at(0), at(1), at(2), 0.0])
                        });
                        volumes[k] = Lanes::new([0.0, 0.0, 0.0, section / domain.spacing(p, &ground)]);
                    }
                    let (volumes, columns) = (&volumes[..block.len()], &columns[..block.len()]);
                    let to = Window { nodes: &mut *window, first: offset };
                    sweeps.deposit_slopes(&ground, &set.places().range(block), to, volumes, columns);
                }
            }
        });
        background.layout.fold(nodes, |sum, node| *sum += *node);
        // A face that lies on a wall is none that another body can touch: as if the body went on behind it.
        for (place, node) in nodes.iter_mut().enumerate().filter(|(_, node)| **node != Lanes::ZERO) {
            let index = background.layout.index(place / length, place % length);
            let bare = |axis: usize| if walls.at(axis, &index).is_some() { 0.0 } else { 1.0 };
            let keep = std::array::from_fn(|c| if c < D { bare(c) } else { 1.0 });
            *node *= Lanes::new(keep);
        }
    }
}

/// Radii of the nodes (m); none on the other side of the axis.
pub fn radii<const D: usize>(background: &Background<D>) -> Vec<f64> {
    let radius = |node: usize| match background.is_meshed() {
        true => background.mesh.nodes().get(node).map_or(0.0, |x| x[0]),
        false => {
            let row = node / background.layout.strides()[0];
            let Background { grid, axis, .. } = background;
            grid.origin[0] + grid.cell * axis.coordinate(row, grid.cells[0])
        }
    };
    (0..background.layout.len()).map(|node| radius(node).max(0.0)).collect()
}

fn touching<'a, const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    light: f64,
    walls: &'a Walls,
    contacts: &'a Contacts,
    pair: &Pair,
    dt: f64,
) -> Touch<'a> {
    let len = background.layout.len();
    Touch {
        law: pair.law,
        surfaces: pair.fields.map(|field| &contacts.surfaces[field * len..(field + 1) * len]),
        rigid: pair.fields.map(|field| contacts.rigid[field].is_some()),
        distance: &contacts.distance,
        walls,
        keep_start: clock.keeps_start(),
        light,
        inertia: clock.options.mass_scaling,
        filled: &contacts.filled,
        radii: &contacts.radii,
        cell: background.grid.cell,
        dt,
    }
}

/// Contact of the solved velocities, pair after pair. The contacts of three and more bodies at a node act on each
/// other: they are gone through until none changes anything. Every impulse is one that the law allows, and it
/// acts on both bodies.
pub fn touch<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    light: f64,
    solved: &mut [Node],
    boundary: &mut Boundary<D>,
) {
    let Boundary { walls, driven, contacts, touched, .. } = boundary;
    touched.iter_mut().for_each(|row| row.given.fill(Given::default()));
    let count = background.layout.nodes()[0];
    for _ in 0..SWEEPS {
        let mut changed = false;
        for (number, pair) in contacts.pairs.iter().enumerate() {
            if pair.fields.iter().all(|field| contacts.is_rigid(*field)) {
                continue;
            }
            let rows = &mut touched[number * count..][..count];
            let touch = touching(clock, background, light, walls, contacts, pair, clock.dt);
            touch_pair(background, &touch, pair, solved, rows);
            changed |= rows.iter().any(|row| row.changed);
            react(driven, contacts, pair, rows, clock.dt);
        }
        if !changed || contacts.fields() < 3 {
            break;
        }
    }
}

fn touch_pair<const D: usize>(
    background: &Background<D>,
    touch: &Touch<'_>,
    pair: &Pair,
    solved: &mut [Node],
    rows: &mut [RowTouch],
) {
    let (len, row_length) = (background.layout.len(), background.layout.strides()[0]);
    background.layout.two_rows(two(solved, len, pair.fields), rows, &|row, active, [a, b], result| {
        (result.changed, result.impulse) = (false, [0.0; 3]);
        for number in active {
            let index = background.layout.index(row, number);
            let mut alone = Given::default();
            let given = result.given.get_mut(number).unwrap_or(&mut alone);
            let nodes = [&mut a[number], &mut b[number]];
            let touched = touch.solved(row * row_length + number, &index, nodes, given);
            let Some((changed, impulse)) = touched else { continue };
            result.changed |= changed;
            if !background.layout.is_repeated(&index) {
                (0..3).for_each(|c| result.impulse[c] += impulse[c]);
            }
        }
    });
}

/// Books the impulses of a pair on the rigid body in it, if there is one.
fn react(driven: &mut [Driven], contacts: &Contacts, pair: &Pair, rows: &[RowTouch], dt: f64) {
    for (side, field) in pair.fields.into_iter().enumerate() {
        if let Some(number) = contacts.rigid[field] {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            rows.iter().for_each(|row| driven[number].take(row.impulse.map(|i| sign * i), dt));
        }
    }
}

/// Contact of the re-mapped velocities.
pub fn touch_again<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    light: f64,
    nodes: &mut Nodes,
    boundary: &mut Boundary<D>,
) {
    let (len, row_length) = (background.layout.len(), background.layout.strides()[0]);
    let Boundary { walls, contacts, touched, .. } = boundary;
    let Nodes { solved, remapped, .. } = nodes;
    for pair in &contacts.pairs {
        let touch = touching(clock, background, light, walls, contacts, pair, 1.0);
        let [first, second] = pair.fields;
        let both = two(remapped, len, pair.fields);
        background.layout.two_rows(both, touched, &|row, active, [a, b], _| {
            for number in active {
                let place = row * row_length + number;
                let solved = [&solved[first * len + place], &solved[second * len + place]];
                touch.again(place, solved, [&mut a[number], &mut b[number]]);
            }
        });
    }
}

/// Volumes over the cell size (m²) from which a rigid body holds the nodes of a grid: what there is of a body at its
/// corners where they are nodes, less what round-off takes. At the sides of the domain that is less, because there is
/// less of a node.
pub fn filled<const D: usize>(
    Background { grid, layout, axis: basis, .. }: &Background<D>,
    points: usize,
) -> Vec<f64> {
    let corner = ALMOST * 0.5f64.powi(D as i32) * grid.cell.powi(D as i32 - 1);
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

/// Integrals of the shape functions along an axis of `cells` cells, in cells, as the `points` of a cell find them.
fn integrals(basis: &Axis, cells: usize, points: usize) -> Vec<f64> {
    let mut sums = vec![0.0; basis.nodes(cells)];
    let weight = 1.0 / points as f64;
    for cell in 0..cells {
        for k in 0..points {
            let on = basis.evaluate(cell as f64 + weight * (k as f64 + 0.5), THIN, cells);
            for (sum, own) in sums[on.first..].iter_mut().zip(on.weights()) {
                *sum += weight * own;
            }
        }
    }
    sums
}

/// The same of a mesh: as much as the smallest of the elements at the node holds of it.
pub fn filled_on_mesh<const D: usize>(mesh: &Mesh<D>, nodes: usize) -> Vec<f64> {
    let share = |element: &u32| {
        let element = &mesh.elements()[*element as usize];
        element.volume / (element.height * (D + 1) as f64)
    };
    let least = |node: u32| mesh.elements_around(node).iter().map(share).fold(f64::INFINITY, f64::min);
    let mut filled: Vec<f64> = (0..mesh.nodes().len() as u32).map(|node| ALMOST * least(node)).collect();
    filled.resize(nodes, f64::INFINITY);
    filled
}

/// One, less what round-off takes.
const ALMOST: f64 = 1.0 - 1e-6;
