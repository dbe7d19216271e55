//! Saving and restoring the solver, and the `Solver` face of it.

use std::io::{self, Read, Write};

use colluvium_case::description::{Reset, Stage};
use colluvium_case::measure::Reading;
use colluvium_case::{
    Advance, Budget, Equilibrium, Frame, Reaction, Solver, SolverError, TimeStep, Wanted, spatial,
};
use colluvium_points::columns::{foreign, read_column, write_column};
use serde::{Deserialize, Serialize};

use crate::ledger::{Broken, Ledger};
use crate::pairs::Pairs;
use crate::rain::Entered;
use crate::solver::{DemSolver, Followed};
use crate::surfaces::Facet;

/// Version of the layout of a checkpoint.
const FORMAT: u32 = 11;

/// What is no column.
#[derive(Serialize, Deserialize)]
struct Head {
    format: u32,
    dimension: usize,
    time: f64,
    step: u64,
    last: f64,
    fastest: f64,
    deep_share: f64,
    ledger: Ledger,
    virial: Vec<f64>,
    /// Vectors, rates and mean rates of the cell, and its vectors when the lists were made.
    cell: Vec<f64>,
    since: Option<(Vec<f64>, f64, f64)>,
    walls: Vec<(u32, Vec<f64>)>,
    broken: Vec<Broken>,
    entered: Vec<Entered>,
    next_id: u32,
    followed: Vec<Followed>,
}

fn flat<const D: usize>(matrix: &[[f64; D]; D]) -> Vec<f64> {
    matrix.as_flattened().to_vec()
}

fn matrix<const D: usize>(flat: &[f64]) -> Option<[[f64; D]; D]> {
    let mut out = [[0.0; D]; D];
    let entries = out.as_flattened_mut();
    if entries.len() != flat.len() {
        return None;
    }
    entries.copy_from_slice(flat);
    Some(out)
}

fn write_pairs<const R: usize>(pairs: &Pairs<R>, out: &mut dyn Write) -> io::Result<()> {
    write_column(&pairs.starts, |value| value, out)?;
    write_column(&pairs.other, |value| value, out)?;
    write_column(&pairs.image, |value| value, out)?;
    pairs.memory.write(out)
}

fn read_pairs<const R: usize>(pairs: &mut Pairs<R>, count: usize, input: &mut dyn Read) -> io::Result<()> {
    read_column(&mut pairs.starts, |value: u32| value, input)?;
    read_column(&mut pairs.other, |value: u32| value, input)?;
    read_column(&mut pairs.image, |value: u8| value, input)?;
    pairs.memory.read(input)?;
    let ends = pairs.starts.is_empty() && pairs.other.is_empty()
        || pairs.starts.len() == count + 1 && pairs.starts[count] as usize == pairs.other.len();
    let sorted = pairs.starts.windows(2).all(|pair| pair[0] <= pair[1]);
    let within = pairs.other.iter().all(|&j| (j as usize) < count);
    let images = pairs.image.is_empty() || pairs.image.len() == pairs.other.len();
    if ends && sorted && within && images && pairs.memory.len() == pairs.other.len() {
        Ok(())
    } else {
        Err(foreign("the lists of pairs do not fit the grains"))
    }
}

impl<const D: usize, const R: usize> DemSolver<D, R> {
    pub(crate) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut cell = flat(&self.cell.h);
        cell.extend(flat(&self.cell.rate));
        cell.extend(flat(&self.cell.mean_rate));
        let wall = |wall: &crate::walls::Wall<D>| {
            let velocity = wall.velocity.get(wall.axis).copied().unwrap_or(0.0);
            let mut numbers = vec![wall.position, velocity];
            numbers.extend(wall.reaction.as_flattened());
            numbers.extend(&wall.moment);
            (wall.boundary as u32, numbers)
        };
        let head = Head {
            format: FORMAT,
            dimension: D,
            time: self.time,
            step: self.step,
            last: self.last,
            fastest: self.fastest,
            deep_share: self.deep_share,
            ledger: self.ledger,
            virial: self.virial.iter().flat_map(flat).collect(),
            cell,
            since: self.since.cell.map(|then| (flat(&then), self.since.moved, self.since.others)),
            walls: self.walls.iter().map(wall).collect(),
            broken: self.broken.clone(),
            entered: self.sources.iter().map(|source| source.entered).collect(),
            next_id: self.next_id,
            followed: self.followed.clone(),
        };
        let head = postcard::to_stdvec(&head).map_err(io::Error::other)?;
        write_column(&head, |byte| byte, out)?;
        self.grains.write(out)?;
        write_pairs(&self.lists.inner, out)?;
        write_pairs(&self.lists.seam, out)?;
        write_column(&self.lists.slabs, |value| value, out)?;
        write_column(&self.near.grain, |value| value, out)?;
        write_column(&self.near.wall, |value| value, out)?;
        write_column(&self.near.slabs, |value| value, out)?;
        write_column(&self.near.key, |value| value, out)?;
        let facets: Vec<f64> = self
            .near
            .facet
            .iter()
            .flat_map(|f| [f.distance, f.normal[0], f.normal[1], f.normal[2]])
            .collect();
        write_column(&facets, |value| value, out)?;
        self.near.memory.write(out)
    }

    pub(crate) fn read(&mut self, input: &mut dyn Read) -> io::Result<()> {
        let mut bytes: Vec<u8> = Vec::new();
        read_column(&mut bytes, |byte: u8| byte, input)?;
        let head: Head = postcard::from_bytes(&bytes).map_err(io::Error::other)?;
        if head.format != FORMAT || head.dimension != D {
            return Err(foreign("written by another version or for another case"));
        }
        self.membranes.clear();
        self.grains.read(input)?;
        let count = self.grains.len();
        self.radii = self.grains.radii();
        read_pairs(&mut self.lists.inner, count, input)?;
        read_pairs(&mut self.lists.seam, count, input)?;
        self.lists.close.forget();
        read_column(&mut self.lists.slabs, |value: u32| value, input)?;
        read_column(&mut self.near.grain, |value: u32| value, input)?;
        read_column(&mut self.near.wall, |value: u32| value, input)?;
        read_column(&mut self.near.slabs, |value: u32| value, input)?;
        read_column(&mut self.near.key, |value: u64| value, input)?;
        let mut facets: Vec<f64> = Vec::new();
        read_column(&mut facets, |value: f64| value, input)?;
        let facet = |v: &[f64]| Facet { distance: v[0], normal: [v[1], v[2], v[3]] };
        self.near.facet = facets.chunks_exact(4).map(facet).collect();
        self.near.memory.read(input)?;
        let fits = self.near.memory.len() == self.near.grain.len()
            && self.near.wall.len() == self.near.grain.len()
            && self.near.slabs.len() == self.lists.slabs.len()
            && self.near.key.len() == self.near.facet.len()
            && (self.near.key.is_empty() || self.near.key.len() == self.near.grain.len())
            && self.near.grain.iter().all(|&i| (i as usize) < count);
        if !fits {
            return Err(foreign("the lists of walls do not fit the grains"));
        }
        self.find_membranes();
        self.take(head).ok_or_else(|| foreign("the cell or the walls do not fit the case"))
    }

    fn take(&mut self, head: Head) -> Option<()> {
        let third = head.cell.len() / 3;
        self.cell.h = matrix(&head.cell[..third])?;
        self.cell.rate = matrix(&head.cell[third..2 * third])?;
        self.cell.mean_rate = matrix(&head.cell[2 * third..])?;
        let half = head.virial.len() / 2;
        self.virial = [matrix(&head.virial[..half])?, matrix(&head.virial[half..])?];
        self.since = crate::solver::Since::default();
        if let Some((then, moved, others)) = head.since {
            self.since = crate::solver::Since { cell: Some(matrix(&then)?), moved, others };
        }
        self.walls.retain(|wall| head.walls.iter().any(|(boundary, _)| *boundary as usize == wall.boundary));
        if self.walls.len() != head.walls.len() {
            return None;
        }
        for (wall, (_, numbers)) in self.walls.iter_mut().zip(&head.walls) {
            let ([position, velocity], reaction) = numbers.split_first_chunk()?;
            wall.position = *position;
            wall.velocity[wall.axis] = *velocity;
            if let Some(moving) = &mut wall.moving {
                moving.go_to(head.time);
                moving.take_pace(head.time, head.last);
            }
            let (reaction, moment) = reaction.split_at_checked(2 * D)?;
            let (force, impulse) = reaction.split_at(D);
            wall.moment = <[f64; 3]>::try_from(moment).ok()?;
            wall.reaction = [<[f64; D]>::try_from(force).ok()?, <[f64; D]>::try_from(impulse).ok()?];
        }
        (self.time, self.step, self.last, self.fastest) = (head.time, head.step, head.last, head.fastest);
        (self.deep_share, self.ledger) = (head.deep_share, head.ledger);
        (self.broken, self.next_id) = (head.broken, head.next_id);
        if self.sources.len() != head.entered.len() || self.followed.len() != head.followed.len() {
            return None;
        }
        self.followed = head.followed;
        for (source, entered) in self.sources.iter_mut().zip(head.entered) {
            source.entered = entered;
        }
        Some(())
    }
}

impl<const D: usize, const R: usize> Solver for DemSolver<D, R> {
    fn time(&self) -> f64 {
        self.time
    }

    fn step_count(&self) -> u64 {
        self.step
    }

    fn points(&self) -> usize {
        self.grains.len()
    }

    fn limit(&mut self) -> TimeStep {
        self.critical_step()
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        self.take_step(at_most)
    }

    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        let fresh = start == self.time;
        (self.stage, self.stage_start) = (stage, start);
        self.enter_stage(fresh)
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        for reset in &stage.reset {
            match reset {
                Reset::Velocity => {
                    let g = &mut self.grains;
                    for (velocity, _) in g.velocity.iter_mut().zip(&g.held).filter(|(_, held)| !**held) {
                        *velocity = [0.0; D];
                    }
                    g.spin.fill([0.0; R]);
                    // The next step starts from rest: it kicks by half.
                    self.last = 0.0;
                    for moving in self.walls.iter_mut().filter_map(|wall| wall.moving.as_mut()) {
                        moving.take_pace(self.time, 0.0);
                    }
                }
                Reset::Displacement => self.grains.origin.clone_from(&self.grains.position),
                Reset::State => self.reset_contacts(),
            }
        }
        Ok(())
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        let kinetic = self.ledger.kinetic + self.ledger.rotation;
        let elastic = self.ledger.recoverable();
        let kinetic_ratio = match (kinetic, elastic) {
            (0.0, _) => 0.0,
            (_, 0.0) => f64::INFINITY,
            _ => kinetic / elastic,
        };
        Some(Equilibrium { unbalanced_force: self.unbalanced(), kinetic_ratio, kinetic })
    }

    fn readings(&self) -> Vec<Reading> {
        self.take_readings()
    }

    fn reaction(&self, name: &str) -> Option<Reaction> {
        let Some(wall) = self.walls.iter().find(|wall| wall.name == name) else {
            return self.reaction_of_body(name);
        };
        let [force, impulse] = wall.reaction.map(|of| spatial(&of));
        Some(Reaction { force, impulse, moment: wall.surface.is_some().then_some(wall.moment) })
    }

    fn dissipated(&self) -> Option<f64> {
        Some(self.ledger.dissipated())
    }

    fn warning(&self) -> Option<String> {
        if let Some(full) = self.full_region() {
            return Some(full);
        }
        // Sheet: dem §3.5.
        (self.ledger.overlap > 0.05).then(|| {
            format!(
                "t = {:.4e} s: overlaps reach {:.3} of the smaller radius, more than 0.05: solid fractions and contacts per grain \
                 are those of soft grains (make contacts stiffer)",
                self.time, self.ledger.overlap
            )
        })
    }

    fn remarks(&self) -> Vec<String> {
        self.given.notes.iter().cloned().chain(self.missed_stresses()).collect()
    }

    fn facts(&self) -> Vec<String> {
        self.specimens.iter().map(|specimen| format!("at the start, {specimen}")).collect()
    }

    fn frame(&self, wanted: Wanted) -> Frame {
        self.take_frame(wanted)
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.take_budget())
    }

    fn specimen(&self) -> Option<String> {
        Some(self.stored())
    }

    fn has_specimen(&self) -> bool {
        true
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        self.write(out).map_err(|error| SolverError::Checkpoint(error.to_string()))
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        self.read(input).map_err(|error| SolverError::Checkpoint(error.to_string()))
    }
}
