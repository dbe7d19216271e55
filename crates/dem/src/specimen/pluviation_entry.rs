//! Entry of grains by pluviation: time, position, and energy.

use colluvium_case::spatial;
use rand::RngExt;

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::controlled_cell::ControlledCell;
use crate::boundary::periodic_cell::{PeriodicCell, apply, inverse};
use crate::boundary::walls::RigidWall;
use crate::clock::Clock;
use crate::neighbours::grain_neighbours::GrainNeighbours;
use crate::output::records::Records;
use crate::points::grain_extremes::GrainExtremes;
use crate::points::grains::{Grains, volume};
use crate::points::vector::{difference, dot};
use crate::specimen::pluviation::{EnteredGrains, GrainSource, contains_ball};
use crate::specimen::specimen_preparation::SpecimenPreparation;
use colluvium_case::Warning;

/// Number of random positions for a grain in a step, after which it waits for the next step.
const DRAWS: usize = 100;

/// Waiting mass over entered mass above which there is a warning.
const REPORTED_BACKLOG: f64 = 0.02;

/// Adds the grains that are due.
pub fn add_entering_grains<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &ControlledCell<D>,
    boundary: &mut BoundaryConditions<D>,
    (grains, extremes): (&mut Grains<D, R>, &mut GrainExtremes),
    neighbours: &mut GrainNeighbours<D, R>,
    specimen: &mut SpecimenPreparation,
    records: &mut Records,
) {
    let SpecimenPreparation { sources, next_id, .. } = specimen;
    for source in sources {
        if clock.case.is_removed(&clock.case.bodies[source.body as usize].name, clock.stage) {
            continue;
        }
        while let Some((x, radius)) = next_grain(clock, &cell.geometry, &boundary.walls, grains, source) {
            let last = push_grain(clock, grains, source, (x, radius));
            grains.id[last] = *next_id;
            *next_id += 1;
            let square = dot(&grains.velocity[last], &grains.velocity[last]);
            if records.energy_balance.start.is_some() {
                let rotation = 0.5 * grains.inertia(last) * dot(&grains.spin[last], &grains.spin[last]);
                records.energy_balance.inflow +=
                    0.5 * (source.density * volume(D, radius)) * square + rotation;
            }
            extremes.max_speed = extremes.max_speed.max(square.sqrt());
            extremes.radii = (extremes.radii.0.min(radius), extremes.radii.1.max(radius));
            boundary.membranes.clear();
            neighbours.since_build.cell = None;
        }
    }
}

/// Position (m) and radius (m) of the next grain of a source, if it is due and there is space. It then counts as entered.
fn next_grain<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &PeriodicCell<D>,
    walls: &[RigidWall<D>],
    grains: &Grains<D, R>,
    source: &mut GrainSource,
) -> Option<([f64; D], f64)> {
    let waiting_mass = source.mass_by(clock.time) - source.entered_grains.mass;
    let radius = source.radius(D, clock.options.seed);
    let mass = source.density * volume(D, radius);
    let position = if waiting_mass < mass {
        None
    } else {
        free_position(clock, cell, walls, grains, (&*source, radius))
    };
    source.entered_grains.waiting_mass = if waiting_mass < mass { 0.0 } else { waiting_mass };
    let x = position?;
    source.entered_grains = EnteredGrains {
        count: source.entered_grains.count + 1,
        mass: source.entered_grains.mass + mass,
        waiting_mass,
    };
    Some((x, radius))
}

/// Adds a grain of a source and returns its index.
fn push_grain<const D: usize, const R: usize>(
    clock: &Clock,
    g: &mut Grains<D, R>,
    source: &GrainSource,
    (x, radius): ([f64; D], f64),
) -> usize {
    let velocity = clock.case.bodies[source.body as usize].velocity.velocity_at(spatial(&x));
    g.push(source.body, source.kind, x, radius, source.density);
    let last = g.len() - 1;
    g.velocity[last] = std::array::from_fn(|c| velocity[c]);
    g.spin[last] = std::array::from_fn(|c| source.spin.get(c).copied().unwrap_or(0.0));
    if clock.options.orientation {
        g.orientation.push(if D == 2 { [0.0; 4] } else { [1.0, 0.0, 0.0, 0.0] });
    }
    last
}

/// Random position in the shape of a source without a contact; `None` if none is found.
fn free_position<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &PeriodicCell<D>,
    walls: &[RigidWall<D>],
    grains: &Grains<D, R>,
    (source, radius): (&GrainSource, f64),
) -> Option<[f64; D]> {
    let mut random = source.random_draws(clock.options.seed, clock.step + 1);
    let (low, high) = source.shape.bounds(D);
    let (unit, _) = inverse(&cell.h);
    let near = nearby_grains(cell, grains, (&low, &high), radius);
    (0..DRAWS).find_map(|_| {
        let x: [f64; D] = std::array::from_fn(|c| low[c] + (high[c] - low[c]) * random.random::<f64>());
        let is_free = contains_ball(&source.shape, &x, radius)
            && is_clear_of_walls(walls, &x, radius)
            && near.iter().all(|i| is_clear_of_grain((cell, &unit), grains, *i, &x, radius));
        is_free.then_some(x)
    })
}

/// Grains that can be in contact with a grain of a radius (m) in a box (m). In a periodic cell these are all grains, because of images.
pub fn nearby_grains<const D: usize, const R: usize>(
    cell: &PeriodicCell<D>,
    g: &Grains<D, R>,
    (low, high): (&[f64], &[f64]),
    radius: f64,
) -> Vec<usize> {
    let beside = |i: &usize| {
        let (x, reach) = (&g.position[*i], radius + g.radius[*i]);
        (0..D).all(|c| x[c] > low[c] - reach && x[c] < high[c] + reach)
    };
    (0..g.len()).filter(|i| cell.is_periodic() || beside(i)).collect()
}

/// Whether a grain at `x` (m) would be in contact with no wall.
fn is_clear_of_walls<const D: usize>(walls: &[RigidWall<D>], x: &[f64; D], radius: f64) -> bool {
    walls.iter().all(|wall| match wall.current_surface() {
        None => wall.distance(x).0 > radius,
        Some(surface) => !surface.contains(x) && surface.gap(x, radius).is_none(),
    })
}

/// Whether a grain at `x` (m) would have no contact with grain `i`; the inverse of the cell matrix is given.
fn is_clear_of_grain<const D: usize, const R: usize>(
    cell: (&PeriodicCell<D>, &[[f64; D]; D]),
    g: &Grains<D, R>,
    i: usize,
    x: &[f64; D],
    radius: f64,
) -> bool {
    distance_in_cell(cell, x, &g.position[i]) > radius + g.radius[i]
}

/// Distance of two positions (m), or of the nearest of their images in a periodic cell; the inverse of the cell matrix is given.
pub fn distance_in_cell<const D: usize>(
    (cell, unit): (&PeriodicCell<D>, &[[f64; D]; D]),
    a: &[f64; D],
    b: &[f64; D],
) -> f64 {
    let mut apart = difference(a, b);
    if cell.is_periodic() {
        let mut s = apply(unit, &apart);
        for c in (0..D).filter(|&c| cell.periodic[c]) {
            s[c] -= s[c].round();
        }
        apart = apply(&cell.h, &s);
    }
    dot(&apart, &apart).sqrt()
}

/// Warning for a source whose grains find no space in time.
pub fn full_source_warning(clock: &Clock, specimen: &SpecimenPreparation) -> Option<Warning> {
    let is_behind = |source: &&GrainSource| {
        source.entered_grains.waiting_mass > REPORTED_BACKLOG * source.entered_grains.mass
    };
    let source = specimen.sources.iter().find(is_behind)?;
    Some(Warning::new(
        "grain-source-full",
        format!(
            "t = {:.4e} s: {:.3e} kg of body {:?} cannot enter, because its shape is full of grains: make the shape larger, its \
         velocity higher, or rain.rate smaller",
            clock.time, source.entered_grains.waiting_mass, clock.case.bodies[source.body as usize].name
        ),
    ))
}
