//! Applied forces on grains: on bodies, and on membranes (sheet: dem §2.1).

use std::borrow::Cow;
use std::collections::BTreeSet;

use colluvium_case::measure::ScalarOutput;

use crate::config::{GrainStage, Membrane};
use crate::points::vector::{add, cross, difference, dot};
use crate::solver::DemSolver;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Applied forces on the grains, without gravity and contacts (N); empty where the stage has none.
    pub(crate) fn applied(&self) -> Vec<[f64; D]> {
        let Some(stage) = self.stage().filter(|own| !(own.forces.is_empty() && own.membranes.is_empty()))
        else {
            return Vec::new();
        };
        let mut applied = vec![[0.0; D]; self.grains.len()];
        self.add_body_forces(stage, &mut applied);
        for (name, membrane) in &stage.membranes {
            self.add_membrane_pressure(name, membrane, &mut applied);
        }
        applied
    }

    /// Distributes forces on bodies among their grains by mass.
    fn add_body_forces(&self, stage: &GrainStage, applied: &mut [[f64; D]]) {
        let g = &self.grains;
        for (name, force) in &stage.forces {
            let Some(body) = self.number_of(name) else { continue };
            let own = || (0..g.len()).filter(|&i| g.body[i] == body);
            let mass: f64 = own().map(|i| g.mass[i]).sum();
            let force: [f64; D] = std::array::from_fn(|c| force[c]);
            own().for_each(|i| add(&mut applied[i], g.mass[i] / mass, &force));
        }
    }

    /// Adds the pressure of a membrane, a row or a sheet of grains, towards a body.
    fn add_membrane_pressure(&self, name: &str, membrane: &Membrane, applied: &mut [[f64; D]]) {
        let g = &self.grains;
        let (Some(own), Some(other)) = (self.number_of(name), self.number_of(&membrane.against)) else {
            return;
        };
        let Some(centre) = self.centre(|i| g.body[i] == other) else { return };
        let grains = self.in_order(own);
        match membrane.columns {
            Some(columns) => {
                self.add_sheet_pressure(
                    (&grains, columns, membrane.closed),
                    &centre,
                    membrane.pressure,
                    applied,
                );
            }
            None => self.add_row_pressure(&grains, &centre, membrane.pressure, applied),
        }
    }

    /// Adds the pressure on a row in the plane towards a point: each of two neighbours takes half of the force on the line between them.
    fn add_row_pressure(&self, row: &[usize], centre: &[f64; D], pressure: f64, applied: &mut [[f64; D]]) {
        let g = &self.grains;
        let (Some(first), Some(last)) = (row.first(), row.last()) else { return };
        // Rotation by 90° to the left of the row, or to the right where the body lies on its right.
        let left =
            |way: &[f64; D]| -> [f64; D] { std::array::from_fn(|c| if c == 0 { -way[1] } else { way[0] }) };
        let chord = difference(&g.position[*last], &g.position[*first]);
        let Some(middle) = self.centre(|i| g.body[i] == g.body[*first]) else { return };
        let side = dot(&left(&chord), &difference(centre, &middle));
        let half = 0.5 * pressure * if side < 0.0 { -1.0 } else { 1.0 };
        for pair in row.windows(2) {
            let push = left(&difference(&g.position[pair[1]], &g.position[pair[0]]));
            pair.iter().for_each(|&i| add(&mut applied[i], half, &push));
        }
    }

    /// Adds the pressure on a sheet in space towards a point: each of four neighbours takes a quarter of the force on the surface between
    /// them, the pressure times half the cross product of the diagonals, whatever surface the four span.
    fn add_sheet_pressure(
        &self,
        (grains, columns, closed): (&[usize], usize, bool),
        centre: &[f64; D],
        pressure: f64,
        applied: &mut [[f64; D]],
    ) {
        let position = &self.grains.position;
        let (rows, across) = (grains.len() / columns, if closed { columns } else { columns - 1 });
        let mut quads = Vec::with_capacity(rows * columns);
        let mut side = 0.0;
        for row in 1..rows {
            for column in 0..across {
                let next = (column + 1) % columns;
                let [low, high] = [(row - 1) * columns, row * columns];
                let corners = [low + column, low + next, high + next, high + column].map(|k| grains[k]);
                let [a, b, c, d] = corners.map(|i| position[i]);
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

    /// Area enclosed by the rows of a closed sheet, projected along an axis and to the centres of their grains: the mean of all rows (m²).
    /// `None` where the body is no closed sheet in any stage.
    pub(crate) fn enclosed_by(&self, name: &str, axis: usize) -> Option<f64> {
        let sheets = self.options.stages.values().filter_map(|stage| stage.membranes.get(name));
        let columns = sheets.filter(|sheet| sheet.closed).find_map(|sheet| sheet.columns)?;
        let grains = self.in_order(self.number_of(name)?);
        let (a, b) = ((axis + 1) % D, (axis + 2) % D);
        let area = |row: &[usize]| {
            let next = row.iter().cycle().skip(1);
            let twice = row.iter().zip(next).map(|(&i, &j)| {
                let (x, y) = (&self.grains.position[i], &self.grains.position[j]);
                x[a] * y[b] - x[b] * y[a]
            });
            0.5 * twice.sum::<f64>().abs()
        };
        let rows = (grains.len() / columns) as f64;
        Some(grains.chunks_exact(columns).map(area).sum::<f64>() / rows)
    }

    /// Enclosed sections and volumes of the closed membranes of all stages (m², m³), to the centres of their grains and along
    /// the axis of their rings.
    pub(crate) fn sleeve_outputs(&self) -> Vec<ScalarOutput> {
        let closed = |(_, sheet): &(&String, &Membrane)| sheet.closed;
        let sheets = self.options.stages.values().flat_map(|stage| &stage.membranes).filter(closed);
        let names: BTreeSet<&String> = sheets.map(|(name, _)| name).collect();
        let mut readings = Vec::new();
        for name in names {
            let areas: Vec<f64> =
                (0..D).map(|axis| self.enclosed_by(name, axis).unwrap_or(f64::NAN)).collect();
            let axis = (0..D).fold(0, |most, c| if areas[c] > areas[most] { c } else { most });
            let place = |upper: bool| {
                let mut across = self.walls.iter().filter(|wall| wall.surface.is_none() && wall.axis == axis);
                across.find(|wall| wall.upper == upper).map_or(f64::NAN, |wall| wall.position)
            };
            let volume = areas[axis] * (place(true) - place(false));
            readings.push((format!("membrane.{name}.area"), "m2".to_owned(), areas[axis]));
            readings.push((format!("membrane.{name}.volume"), "m3".to_owned(), volume));
        }
        readings
    }

    /// Finds the indices of the grains of membranes.
    pub(crate) fn find_membranes(&mut self) {
        let names: BTreeSet<&String> =
            self.options.stages.values().flat_map(|stage| stage.membranes.keys()).collect();
        let numbers = names.into_iter().filter_map(|name| self.number_of(name));
        self.membranes = numbers.map(|body| (body, self.sorted(body))).collect();
    }

    /// Indices of the grains of a body in the order of their ids.
    fn in_order(&self, body: u32) -> Cow<'_, [usize]> {
        match self.membranes.iter().find(|(own, _)| *own == body) {
            Some((_, grains)) => Cow::Borrowed(grains),
            None => Cow::Owned(self.sorted(body)),
        }
    }

    fn sorted(&self, body: u32) -> Vec<usize> {
        let g = &self.grains;
        let mut grains: Vec<usize> = (0..g.len()).filter(|&i| g.body[i] == body).collect();
        grains.sort_unstable_by_key(|&i| g.id[i]);
        grains
    }

    /// Centre of mass of the selected grains (m); `None` without grains.
    fn centre(&self, holds: impl Fn(usize) -> bool) -> Option<[f64; D]> {
        let g = &self.grains;
        let (mut mass, mut moment) = (0.0, [0.0; D]);
        for i in (0..g.len()).filter(|&i| holds(i)) {
            mass += g.mass[i];
            add(&mut moment, g.mass[i], &g.position[i]);
        }
        (mass > 0.0).then(|| moment.map(|c| c / mass))
    }

    fn number_of(&self, body: &str) -> Option<u32> {
        Some(self.case.bodies.iter().position(|own| own.name == body)? as u32)
    }
}
