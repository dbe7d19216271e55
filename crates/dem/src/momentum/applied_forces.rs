//! Applied forces on grains: on bodies, on membranes, and by the body force of a program (sheet: dem §2.1).

use crate::boundary::membranes::Membranes;
use crate::clock::Clock;
use crate::config::{GrainStage, Membrane};
use crate::points::grains::Grains;
use crate::points::vector::{add, cross, difference, dot};

/// Applied forces on the grains, without gravity and contacts (N); empty where the stage has none.
pub fn applied_forces<const D: usize, const R: usize>(
    clock: &Clock,
    grains: &Grains<D, R>,
    membranes: &Membranes,
) -> Vec<[f64; D]> {
    let of_program = &grains.body_force;
    let Some(stage) =
        clock.stage_options().filter(|own| !(own.forces.is_empty() && own.membranes.is_empty()))
    else {
        return of_program.clone();
    };
    let mut applied = if of_program.is_empty() { vec![[0.0; D]; grains.len()] } else { of_program.clone() };
    add_body_forces(clock, grains, stage, &mut applied);
    for (name, membrane) in &stage.membranes {
        add_membrane_pressure(clock, grains, membranes, (name, membrane), &mut applied);
    }
    applied
}

/// Distributes forces on bodies among their grains by mass.
fn add_body_forces<const D: usize, const R: usize>(
    clock: &Clock,
    g: &Grains<D, R>,
    stage: &GrainStage,
    applied: &mut [[f64; D]],
) {
    for (name, force) in &stage.forces {
        let Some(body) = clock.body_index(name) else { continue };
        let own = || (0..g.len()).filter(|&i| g.body[i] == body);
        let mass: f64 = own().map(|i| g.mass[i]).sum();
        let force: [f64; D] = std::array::from_fn(|c| force[c]);
        own().for_each(|i| add(&mut applied[i], g.mass[i] / mass, &force));
    }
}

/// Adds the pressure of a membrane on its grains, directed to the enclosed body.
fn add_membrane_pressure<const D: usize, const R: usize>(
    clock: &Clock,
    g: &Grains<D, R>,
    membranes: &Membranes,
    (name, membrane): (&str, &Membrane),
    applied: &mut [[f64; D]],
) {
    let (Some(own), Some(other)) = (clock.body_index(name), clock.body_index(&membrane.against)) else {
        return;
    };
    let Some(centre) = g.centre_of_mass(|i| g.body[i] == other) else { return };
    let order = membranes.in_order(g, own);
    match membrane.columns {
        Some(columns) => {
            let sheet = (&*order, columns, membrane.closed);
            add_sheet_pressure(g, sheet, &centre, membrane.pressure, applied);
        }
        None => add_row_pressure(g, &order, &centre, membrane.pressure, applied),
    }
}

/// Adds the pressure on a row of grains in the plane. Each of two neighbours receives half of the force on the line between them.
fn add_row_pressure<const D: usize, const R: usize>(
    g: &Grains<D, R>,
    row: &[usize],
    centre: &[f64; D],
    pressure: f64,
    applied: &mut [[f64; D]],
) {
    let (Some(first), Some(last)) = (row.first(), row.last()) else { return };
    // Rotation by 90° to the left of the row, or to the right where the body lies on its right.
    let left =
        |line: &[f64; D]| -> [f64; D] { std::array::from_fn(|c| if c == 0 { -line[1] } else { line[0] }) };
    let chord = difference(&g.position[*last], &g.position[*first]);
    let Some(middle) = g.centre_of_mass(|i| g.body[i] == g.body[*first]) else { return };
    let side = dot(&left(&chord), &difference(centre, &middle));
    let half = 0.5 * pressure * if side < 0.0 { -1.0 } else { 1.0 };
    for pair in row.windows(2) {
        let normal = left(&difference(&g.position[pair[1]], &g.position[pair[0]]));
        pair.iter().for_each(|&i| add(&mut applied[i], half, &normal));
    }
}

/// Adds the pressure on a sheet of grains in space. Each of four neighbours receives a quarter of the force between them, the pressure
/// times half the vector product of the diagonals.
fn add_sheet_pressure<const D: usize, const R: usize>(
    g: &Grains<D, R>,
    (grains, columns, closed): (&[usize], usize, bool),
    centre: &[f64; D],
    pressure: f64,
    applied: &mut [[f64; D]],
) {
    let (rows, across) = (grains.len() / columns, if closed { columns } else { columns - 1 });
    let mut quads = Vec::with_capacity(rows * columns);
    let mut side = 0.0;
    for row in 1..rows {
        for column in 0..across {
            let next = (column + 1) % columns;
            let [low, high] = [(row - 1) * columns, row * columns];
            let corners = [low + column, low + next, high + next, high + column].map(|k| grains[k]);
            let [a, b, c, d] = corners.map(|i| g.position[i]);
            let area: [f64; D] = cross(&difference(&c, &a), &difference(&d, &b));
            let middle: [f64; D] = std::array::from_fn(|k| 0.25 * (a[k] + b[k] + c[k] + d[k]));
            side += dot(&area, &difference(centre, &middle));
            quads.push((corners, area));
        }
    }
    let eighth = 0.125 * pressure * if side < 0.0 { -1.0 } else { 1.0 };
    for (corners, area) in &quads {
        corners.iter().for_each(|&i| add(&mut applied[i], eighth, area));
    }
}
