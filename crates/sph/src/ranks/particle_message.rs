//! Messages between ranks: copies of particles.

use std::ops::Range;

use colluvium_case::Case;
use colluvium_constitutive::States;
use colluvium_points::struct_of_arrays::{copy_entries, gather_entries};

use crate::points::particles::{Bodies, Derivatives, ParticleGroup, Particles};
use crate::solver::SphSolver;

/// Copies of particles with all their fields, body after body.
#[derive(Clone, Debug, Default)]
pub struct ParticleMessage<const D: usize> {
    /// Number of particles of each body.
    counts: Vec<usize>,
    /// Indices of the particles in the sequence of a solver without ranks.
    pub sequence: Vec<u32>,
    particles: Particles<D>,
    rates: Derivatives<D>,
    /// Positions for which neighbours are listed (m).
    listed_positions: Vec<[f64; D]>,
    /// Vectors of follower loads of the particles, load after load.
    follower_loads: Vec<[f64; D]>,
    /// States of the laws, of each body; empty where they are not sent.
    states: Vec<States>,
}

impl<const D: usize> ParticleMessage<D> {
    /// Copies the particles with the ascending `indices` of `domain`, and with `whole` the states of their laws.
    pub fn fill(&mut self, domain: &SphSolver<D>, sequence: &[u32], indices: &[u32], whole: bool) {
        let SphSolver { setting, bodies, lists, rates, .. } = domain;
        copy_entries(&mut self.sequence, sequence, indices);
        self.particles.gather_from(&bodies.particles, indices);
        self.rates.gather_from(&rates.derivatives, indices);
        let listed = &lists.listed_positions.positions;
        let listed = if listed.is_empty() { &bodies.particles.position } else { listed };
        copy_entries(&mut self.listed_positions, listed, indices);
        self.counts.clear();
        self.states.clear();
        let mut left = indices;
        for group in &bodies.groups {
            let (own, others) = left.split_at(left.partition_point(|&i| (i as usize) < group.end));
            left = others;
            self.counts.push(own.len());
            if whole {
                let within: Vec<u32> = own.iter().map(|&i| i - group.start as u32).collect();
                self.states.push(group.states.permuted(&within));
            }
        }
        self.collect_loads(&setting.case, bodies);
    }

    /// Copies the vectors of follower loads of the particles.
    fn collect_loads(&mut self, case: &Case, bodies: &Bodies<D>) {
        self.follower_loads.clear();
        for on in bodies.loads.loads.iter().filter(|on| on.is_follower(case)) {
            let ids = self.particles_of(on.body, &bodies.groups);
            self.follower_loads
                .extend(self.particles.id[ids].iter().map(|id| on.vectors[(id - on.first) as usize]));
        }
    }

    /// Writes the vectors of follower loads into `bodies`.
    fn apply_loads(&self, case: &Case, bodies: &mut Bodies<D>) {
        let Bodies { loads, groups, .. } = bodies;
        let mut carried = self.follower_loads.iter();
        for on in loads.loads.iter_mut().filter(|on| on.is_follower(case)) {
            let ids = self.particles_of(on.body, groups);
            for (id, vector) in self.particles.id[ids].iter().zip(&mut carried) {
                on.vectors[(id - on.first) as usize] = *vector;
            }
        }
    }

    /// Index range of the particles of a body; empty if it is removed.
    fn particles_of(&self, body: u32, groups: &[ParticleGroup]) -> Range<usize> {
        let Some(number) = groups.iter().position(|group| group.body == body) else { return 0..0 };
        let first = self.counts[..number].iter().sum();
        first..first + self.counts[number]
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.sequence.len()
    }

    /// Writes the state of the particles to the ghosts `indices` of `domain`.
    pub fn update_ghosts(&self, domain: &mut SphSolver<D>, indices: &[u32]) {
        let SphSolver { setting, bodies, rates, .. } = domain;
        self.apply_loads(&setting.case, bodies);
        bodies.particles.scatter_from(&self.particles, indices);
        rates.derivatives.scatter_from(&self.rates, indices);
        let mut first = 0;
        for (group, (states, count)) in bodies.groups.iter_mut().zip(self.states.iter().zip(&self.counts)) {
            // The points keep their positions, but the received ones bring their states.
            let mut picks: Vec<(u32, u32)> = (0..group.states.len() as u32).map(|k| (0, k)).collect();
            for (k, &i) in indices[first..first + count].iter().enumerate() {
                picks[i as usize - group.start] = (1, k as u32);
            }
            first += count;
            group.states = States::gathered(&[&group.states, states], &picks);
        }
    }
}

/// Replaces the particles of `domain` by those of `parcels`, in their original order. Returns the sequence and, for each message, the
/// indices of its particles.
pub fn assemble<const D: usize>(
    domain: &mut SphSolver<D>,
    parcels: &[&ParticleMessage<D>],
) -> (Vec<u32>, Vec<Vec<u32>>) {
    let SphSolver { setting, bodies, lists, rates, .. } = domain;
    parcels.iter().for_each(|parcel| parcel.apply_loads(&setting.case, bodies));
    let mut picks: Vec<(u32, u32)> = Vec::new();
    let mut starts = vec![0; parcels.len()];
    for (number, group) in bodies.groups.iter_mut().enumerate() {
        let first = picks.len();
        for (part, parcel) in parcels.iter().enumerate() {
            let start = starts[part];
            picks.extend((start..start + parcel.counts[number]).map(|k| (part as u32, k as u32)));
        }
        picks[first..].sort_unstable_by_key(|&(part, k)| parcels[part as usize].sequence[k as usize]);
        let states: Vec<&States> = parcels.iter().map(|parcel| &parcel.states[number]).collect();
        let within = picks[first..].iter().map(|&(part, k)| (part, k - starts[part as usize] as u32));
        group.states = States::gathered(&states, &within.collect::<Vec<_>>());
        (group.start, group.end) = (first, picks.len());
        parcels.iter().zip(&mut starts).for_each(|(parcel, start)| *start += parcel.counts[number]);
    }
    let mut places: Vec<Vec<u32>> = parcels.iter().map(|parcel| vec![0; parcel.len()]).collect();
    for (place, &(part, k)) in picks.iter().enumerate() {
        places[part as usize][k as usize] = place as u32;
    }
    let particles: Vec<&Particles<D>> = parcels.iter().map(|parcel| &parcel.particles).collect();
    bodies.particles.gather(&particles, &picks);
    let derivatives: Vec<&Derivatives<D>> = parcels.iter().map(|parcel| &parcel.rates).collect();
    rates.derivatives.gather(&derivatives, &picks);
    let listed = &mut lists.listed_positions.positions;
    gather_entries(listed, |part| &parcels[part].listed_positions, parcels.len(), &picks);
    // Data derived from these are recomputed.
    bodies.pair_data.grad_h_factor.clear();
    bodies.pair_data.records.clear();
    bodies.resize(picks.len());
    let mut sequence = Vec::new();
    gather_entries(&mut sequence, |part| &parcels[part].sequence, parcels.len(), &picks);
    (sequence, places)
}
