//! Membranes: bodies of grains that carry a pressure, and the sections that closed ones enclose (sheet: dem §2.1).

use std::borrow::Cow;
use std::collections::BTreeSet;

use colluvium_case::measure::ScalarOutput;

use crate::boundary::walls::RigidWall;
use crate::clock::Clock;
use crate::config::Membrane;
use crate::points::grains::Grains;

/// Indices of the grains of membranes.
#[derive(Debug, Default)]
pub struct Membranes {
    /// Bodies that are membranes in some stage, and the indices of their grains in the order of ids; empty where grains have been reordered
    /// since the last list build.
    bodies: Vec<(u32, Vec<usize>)>,
}

impl Membranes {
    /// Removes the indices, because grains have been reordered.
    pub fn clear(&mut self) {
        self.bodies.clear();
    }

    /// Finds the indices of the grains of membranes.
    pub fn find_grains<const D: usize, const R: usize>(&mut self, clock: &Clock, grains: &Grains<D, R>) {
        let names: BTreeSet<&String> =
            clock.options.stages.values().flat_map(|stage| stage.membranes.keys()).collect();
        let numbers = names.into_iter().filter_map(|name| clock.body_index(name));
        self.bodies = numbers.map(|body| (body, sorted_by_id(grains, body))).collect();
    }

    /// Indices of the grains of a body, in the order of their ids.
    pub fn in_order<const D: usize, const R: usize>(
        &self,
        grains: &Grains<D, R>,
        body: u32,
    ) -> Cow<'_, [usize]> {
        match self.bodies.iter().find(|(own, _)| *own == body) {
            Some((_, grains)) => Cow::Borrowed(grains),
            None => Cow::Owned(sorted_by_id(grains, body)),
        }
    }

    /// Area enclosed by a closed membrane, projected along an axis, as the mean over its rings of grains (m²). `None` if the body is no
    /// closed membrane in any stage.
    pub fn enclosed_area<const D: usize, const R: usize>(
        &self,
        clock: &Clock,
        grains: &Grains<D, R>,
        name: &str,
        axis: usize,
    ) -> Option<f64> {
        let sheets = clock.options.stages.values().filter_map(|stage| stage.membranes.get(name));
        let columns = sheets.filter(|sheet| sheet.closed).find_map(|sheet| sheet.columns)?;
        let order = self.in_order(grains, clock.body_index(name)?);
        let (a, b) = ((axis + 1) % D, (axis + 2) % D);
        let area = |row: &[usize]| {
            let next = row.iter().cycle().skip(1);
            let twice = row.iter().zip(next).map(|(&i, &j)| {
                let (x, y) = (&grains.position[i], &grains.position[j]);
                x[a] * y[b] - x[b] * y[a]
            });
            0.5 * twice.sum::<f64>().abs()
        };
        let rows = (order.len() / columns) as f64;
        Some(order.chunks_exact(columns).map(area).sum::<f64>() / rows)
    }

    /// Enclosed section (m²) and volume (m³) of each closed membrane, up to the grain centres and along the axis of its rings.
    pub fn scalar_outputs<const D: usize, const R: usize>(
        &self,
        clock: &Clock,
        grains: &Grains<D, R>,
        walls: &[RigidWall<D>],
    ) -> Vec<ScalarOutput> {
        let closed = |(_, sheet): &(&String, &Membrane)| sheet.closed;
        let sheets = clock.options.stages.values().flat_map(|stage| &stage.membranes).filter(closed);
        let names: BTreeSet<&String> = sheets.map(|(name, _)| name).collect();
        let mut outputs = Vec::new();
        for name in names {
            let areas: Vec<f64> = (0..D)
                .map(|axis| self.enclosed_area(clock, grains, name, axis).unwrap_or(f64::NAN))
                .collect();
            let axis = (0..D).fold(0, |largest, c| if areas[c] > areas[largest] { c } else { largest });
            let position = |upper: bool| {
                let mut across = walls.iter().filter(|wall| wall.surface.is_none() && wall.axis == axis);
                across.find(|wall| wall.is_upper == upper).map_or(f64::NAN, |wall| wall.position)
            };
            let volume = areas[axis] * (position(true) - position(false));
            outputs.push((format!("membrane.{name}.area"), "m2".to_owned(), areas[axis]));
            outputs.push((format!("membrane.{name}.volume"), "m3".to_owned(), volume));
        }
        outputs
    }
}

/// Indices of the grains of a body, sorted by id.
fn sorted_by_id<const D: usize, const R: usize>(g: &Grains<D, R>, body: u32) -> Vec<usize> {
    let mut grains: Vec<usize> = (0..g.len()).filter(|&i| g.body[i] == body).collect();
    grains.sort_unstable_by_key(|&i| g.id[i]);
    grains
}
