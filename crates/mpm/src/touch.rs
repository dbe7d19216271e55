//! The contact substep: what the laws of [`crate::contact`] do to the nodes (sheet: mpm §3.6).

use colluvium_constitutive::BLOCK;
use colluvium_grid::{Axis, Lanes, Mesh, Node, Walls, Window};

use crate::at_node::{Touch, touching};
use crate::background::Background;
use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::clock::Clock;
use crate::contact::{Contacts, Given, Pair, RowTouch};
use crate::driven::Driven;
use crate::gap::THIN;
use crate::meet::{Around, meet};
use crate::nodes::Nodes;

/// Most sweeps over the pairs of three or more bodies, whose contacts act on each other.
const SWEEPS: usize = 30;

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
            let (mut volumes, mut sections) = ([Lanes::ZERO; BLOCK], [Lanes::ZERO; BLOCK]);
            for set in bodies.sets.iter().filter(|set| set.field == field) {
                let domain = set.domain.as_slice();
                for block in set.blocks_of(slab) {
                    for (k, p) in block.clone().enumerate() {
                        let section = set.points.volume[p]
                            / if *axisymmetric { set.points.position[p][0] } else { 1.0 };
                        sections[k] = Lanes::splat(section);
                        volumes[k] = Lanes::new([0.0, 0.0, 0.0, section / domain.spacing(p, &ground)]);
                    }
                    let (volumes, sections) = (&volumes[..block.len()], &sections[..block.len()]);
                    let to = Window { nodes: &mut *window, first: offset };
                    sweeps.deposit_gradients(&ground, &set.places().range(block), to, volumes, sections);
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
    let (layout, row) = (&background.layout, background.layout.strides()[0]);
    let radius = |node: usize| background.node_at(node, &layout.index(node / row, node % row))[0];
    (0..layout.len()).map(|node| radius(node).max(0.0)).collect()
}

/// Contact of the solved velocities, pair after pair. The contacts of three and more bodies at a node act on each
/// other: they are gone through until none changes anything. Every impulse is one that the law allows, and it
/// acts on both bodies.
pub fn touch<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    solved: &mut [Node],
    boundary: &mut Boundary<D>,
) {
    let Boundary { walls, driven, contacts, touched, grips, rocks, .. } = boundary;
    let light = bodies.light(clock);
    let around = Around { clock, background, bodies, light, walls, contacts };
    let rocks = rocks.as_deref_mut().map_or(&mut [][..], |rocks| &mut rocks.rocks[..]);
    touched.iter_mut().for_each(|row| row.given.fill(Given::default()));
    let count = background.layout.nodes()[0];
    for _ in 0..SWEEPS {
        let mut changed = false;
        for (number, pair) in contacts.pairs.iter().enumerate() {
            let rigid = pair.fields.map(|field| contacts.rigid[field]);
            let loose = |number: &Option<usize>| number.is_some_and(|number| driven[number].loose.is_some());
            if rigid.iter().all(Option::is_some) || rigid.iter().any(loose) {
                continue;
            }
            let rows = &mut touched[number * count..][..count];
            let touch = touching(clock, background, light, walls, contacts, pair, clock.dt);
            touch_pair(background, &touch, pair, solved, rows);
            changed |= rows.iter().any(|row| row.changed);
            react(driven, contacts, pair, rows, clock.dt);
        }
        changed |= meet(&around, solved, driven, touched, (&mut *grips, &mut *rocks));
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
