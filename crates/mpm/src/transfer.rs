//! The transfers from points to grid.

use std::ops::Range;

use colluvium_constitutive::{BLOCK, SymTensor};
use colluvium_grid::{Affine, Deposit, Lanes, Window};

use crate::Transfer;
use crate::averages::Averages;
use crate::background::Background;
use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::clock::Clock;
use crate::driven::hold_patches_again;
use crate::dual::{pull_with_nodes, share, share_stresses};
use crate::loads::apply_loads;
use crate::mixed::{average_stresses, pull_with_cells};
use crate::nodal::load_nodes;
use crate::nodes::Nodes;
use crate::points::PointSet;
use crate::pressing::press;
use crate::rigid::hold_loose_again;
use crate::touch::{scatter_surfaces, touch_again};
use crate::vectors::{lanes, three};

/// What a scatter carries to the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scatter {
    /// Mass, momentum and forces.
    Everything,
    /// Mass and momentum.
    Motion,
    /// Forces.
    Forces,
}

/// `columns[j] = -V σ e_j`.
#[inline(always)]
pub fn force_columns<const D: usize>(stress: &SymTensor, volume: f64) -> [Lanes; D] {
    let s = &stress.0;
    let columns = [
        Lanes::new([s[0], s[3], s[5], 0.0]),
        Lanes::new([s[3], s[1], s[4], 0.0]),
        Lanes::new([s[5], s[4], s[2], 0.0]),
    ];
    let mut mask = [0.0; 4];
    mask[..D].fill(-volume);
    let scale = Lanes::new(mask);
    std::array::from_fn(|j| columns[j] * scale)
}

/// Adds to the nodes of a field the momenta of its bodies, `N` times mass times the velocities (m/s) that `of` finds, and what the affine fields
/// of `transfer` add to them.
pub fn deposit_momenta<const D: usize>(
    background: &Background<D>,
    sets: &[PointSet<D>],
    field: usize,
    nodes: &mut [Lanes],
    of: fn(&PointSet<D>) -> &[[f64; D]],
    transfer: Transfer,
) {
    let ground = background.ground();
    background.layout.scatter(nodes, |slab, window, offset| {
        let mut values = [Lanes::ZERO; BLOCK];
        for set in sets.iter().filter(|set| set.field == field) {
            for block in set.blocks_of(slab) {
                let values = &mut values[..block.len()];
                let points = of(set)[block.clone()].iter().zip(&set.points.mass[block.clone()]);
                for (value, (velocity, mass)) in values.iter_mut().zip(points) {
                    *value = lanes(velocity, 0.0) * *mass;
                }
                let to = Window { nodes: &mut *window, first: offset };
                let affine = affine_of(transfer, set, block.clone());
                background.sweeps.deposit_values(&ground, &set.places().range(block), to, values, affine);
            }
        }
    });
}

/// What a block of points gives to the nodes in one phase.
struct Given<const D: usize> {
    motion: [Lanes; BLOCK],
    columns: [[Lanes; D]; BLOCK],
    body: [Lanes; BLOCK],
}

impl<const D: usize> Given<D> {
    const NOTHING: Self =
        Self { motion: [Lanes::ZERO; BLOCK], columns: [[Lanes::ZERO; D]; BLOCK], body: [Lanes::ZERO; BLOCK] };
}

/// Parts that the points of a set carry of the affine velocity fields around them, where their transfer asks for it.
fn affine_of<const D: usize>(
    transfer: Transfer,
    set: &PointSet<D>,
    points: Range<usize>,
) -> Option<Affine<'_, D>> {
    let fields = || &set.points.affine[points.clone()];
    let moments = transfer == Transfer::Apic;
    (!set.points.affine.is_empty()).then(|| Affine {
        moments,
        fields: fields(),
        mass: &set.points.mass[points.clone()],
    })
}

/// Point to grid (step 1), slab by slab.
pub fn scatter<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut Nodes,
    boundary: &mut Boundary<D>,
    averages: &mut Averages<D>,
    what: Scatter,
) {
    apply_loads(clock, bodies, &boundary.load_starts);
    if what != Scatter::Motion {
        press(clock, background, bodies, &mut boundary.rocks);
        average_stresses(clock, background, bodies, &mut averages.stresses);
    }
    let fields = nodes.fields(&background.layout);
    share_stresses(background, bodies, fields, &mut averages.dual);
    if what != Scatter::Forces {
        scatter_surfaces(background, bodies, &boundary.walls, &mut boundary.contacts);
    }
    let Averages { stresses, dual, .. } = &*averages;
    let Background { layout, sweeps, axisymmetric, grid, .. } = background;
    let (sets, ground, axisymmetric) = (&bodies.sets, background.ground(), *axisymmetric);
    let (transfer, cells) = (clock.options.transfer, background.cell_layout().len());
    let shared = dual.is_used();
    let of_field = |field: usize| sets.iter().filter(move |set| set.field == field);
    for (field, nodes) in nodes.solved.chunks_exact_mut(layout.len()).enumerate() {
        let full = stresses.full_cells(field, cells);
        layout.scatter(nodes, |slab, window, offset| {
            let mut given = Given::NOTHING;
            for set in of_field(field) {
                let domain = set.domain.as_slice();
                let loaded = !set.points.traction.is_empty() && what != Scatter::Motion;
                let pressed = !set.points.pressed.is_empty() && what != Scatter::Motion;
                for block in set.blocks_of(slab) {
                    for (k, p) in block.clone().enumerate() {
                        let mass = if what == Scatter::Forces { 0.0 } else { set.points.mass[p] };
                        given.motion[k] = lanes(&set.points.velocity[p], 1.0) * mass;
                        let left_to_cell =
                            full.is_some_and(|full| full[domain.cell(p, &ground, &set.points.position[p])]);
                        let pulls = what != Scatter::Motion && !left_to_cell;
                        let volume = if pulls { set.points.volume[p] } else { 0.0 };
                        let own = if shared { share(grid, &set.points.position[p]) } else { 1.0 };
                        given.columns[k] = force_columns::<D>(&set.points.stress[p], own * volume);
                        if axisymmetric {
                            let hoop = -volume * set.points.stress[p][2] / set.points.position[p][0];
                            given.body[k] = Lanes::new([hoop, 0.0, 0.0, 0.0]);
                        } else {
                            given.body[k] = Lanes::ZERO;
                        }
                        if loaded {
                            given.body[k] += lanes(&set.points.traction[p], 0.0);
                        }
                        if pressed {
                            given.body[k] += lanes(&set.points.pressed[p].force, 0.0);
                        }
                    }
                    let count = block.len();
                    let deposit = Deposit {
                        motion: &given.motion[..count],
                        columns: &given.columns[..count],
                        body: if axisymmetric || loaded || pressed { &given.body[..count] } else { &[] },
                        affine: affine_of(transfer, set, block.clone()).filter(|_| what != Scatter::Forces),
                    };
                    let to = Window { nodes: &mut *window, first: offset };
                    sweeps.deposit(&ground, &set.places().range(block), to, &deposit);
                }
            }
        });
        layout.fold(nodes, |sum, node| {
            if what != Scatter::Forces {
                sum.motion += node.motion;
            }
            if what != Scatter::Motion {
                sum.force += node.force;
            }
        });
    }
    if what != Scatter::Motion {
        pull_with_cells(background, stresses, &mut nodes.solved);
        pull_with_nodes(background, dual, &mut nodes.solved);
        load_nodes(clock, background, bodies, &mut nodes.solved, &boundary.nodal, &boundary.load_starts);
    }
}

/// Maps the updated velocities of the points back to the nodes (MUSL, step 6), walls included.
pub fn remap<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    nodes: &mut Nodes,
    boundary: &mut Boundary<D>,
) {
    nodes.reset_remapped(&background.layout);
    let transfer = clock.options.transfer;
    let len = background.layout.len();
    for (field, nodes) in nodes.remapped.chunks_exact_mut(len).enumerate() {
        deposit_momenta(background, &bodies.sets, field, nodes, |set| &set.points.velocity, transfer);
        background.layout.fold(nodes, |sum, node| *sum += *node);
    }
    velocities_of_remapped(clock, background, bodies, nodes, boundary, false);
}

/// Velocities at the start of the step (USF), walls included.
pub fn start_velocities<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    nodes: &mut Nodes,
    boundary: &mut Boundary<D>,
) {
    for (velocity, node) in nodes.remapped.iter_mut().zip(&nodes.solved) {
        *velocity = node.motion;
    }
    velocities_of_remapped(clock, background, bodies, nodes, boundary, true);
}

/// Divides re-mapped momenta by mass and applies the walls. With `start` the nodes still hold
/// momenta, else they hold the solved velocities; mass is in their fourth lane either way.
fn velocities_of_remapped<const D: usize>(
    clock: &Clock,
    background: &Background<D>,
    bodies: &Bodies<D>,
    nodes: &mut Nodes,
    boundary: &mut Boundary<D>,
    start: bool,
) {
    let Nodes { solved, remapped, .. } = &mut *nodes;
    let (walls, layout) = (&boundary.walls, &background.layout);
    let row_length = layout.strides()[0];
    let fields = remapped.chunks_exact_mut(layout.len()).zip(solved.chunks_exact(layout.len()));
    for (remapped, nodes) in fields {
        layout.each(remapped, |row, active, line| {
            for number in active {
                let node = &nodes[row * row_length + number];
                let mass = node.motion.as_array()[3];
                if mass <= 0.0 {
                    line[number] = Lanes::ZERO;
                    continue;
                }
                line[number] *= 1.0 / mass;
                let solved = if start { Lanes::splat(f64::NAN) } else { node.motion };
                let mut velocity = three(line[number]);
                walls.constrain_again(&layout.index(row, number), &three(solved), &mut velocity);
                line[number] = lanes(&velocity, 0.0);
            }
        });
    }
    hold_loose_again(background, &boundary.driven, &boundary.contacts, &mut nodes.remapped);
    if !start {
        touch_again(clock, background, bodies.light(clock), nodes, boundary);
    }
    let Boundary { driven, contacts, .. } = &*boundary;
    hold_patches_again(clock, background, driven, contacts, &mut nodes.remapped);
}
