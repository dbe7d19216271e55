//! What ranks send each other: copies of particles.

use std::ops::Range;

use colluvium_case::Case;
use colluvium_constitutive::States;
use colluvium_points::struct_of_arrays::{copy_entries, gather_entries};

use crate::points::particles::{Bodies, Derivatives, ParticleGroup, Particles};
use crate::solver::SphSolver;

/// Copies of particles with everything that is theirs, body after body.
#[derive(Clone, Debug, Default)]
pub struct ParticleMessage<const D: usize> {
    /// Number of particles of each body.
    counts: Vec<usize>,
    /// Places of the particles in the order of a solver without ranks.
    pub sequence: Vec<u32>,
    particles: Particles<D>,
    rates: Derivatives<D>,
    /// Positions for which neighbours are listed (m).
    listed: Vec<[f64; D]>,
    /// What they carry of loads that follow their surfaces, load after load.
    carried: Vec<[f64; D]>,
    /// States of the laws, of each body; empty where they are not sent.
    states: Vec<States>,
}

impl<const D: usize> ParticleMessage<D> {
    /// Takes copies of the particles `indices`, ascending, of `domain`; the states of their laws where `whole`.
    pub fn fill(&mut self, domain: &SphSolver<D>, sequence: &[u32], indices: &[u32], whole: bool) {
        let SphSolver { setting, bodies, lists, rates, .. } = domain;
        copy_entries(&mut self.sequence, sequence, indices);
        self.particles.pick(&bodies.particles, indices);
        self.rates.pick(&rates.derivatives, indices);
        let listed = &lists.listed.positions;
        let listed = if listed.is_empty() { &bodies.particles.position } else { listed };
        copy_entries(&mut self.listed, listed, indices);
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

    /// Takes along what the particles carry of loads that follow their surfaces.
    fn collect_loads(&mut self, case: &Case, bodies: &Bodies<D>) {
        self.carried.clear();
        for on in bodies.loads.all.iter().filter(|on| on.is_follower(case)) {
            let ids = self.particles_of(on.body, &bodies.groups);
            self.carried.extend(self.particles.id[ids].iter().map(|id| on.vectors[(id - on.first) as usize]));
        }
    }

    /// Gives `bodies` what its particles carry of loads that follow their surfaces.
    fn apply_loads(&self, case: &Case, bodies: &mut Bodies<D>) {
        let Bodies { loads, groups, .. } = bodies;
        let mut carried = self.carried.iter();
        for on in loads.all.iter_mut().filter(|on| on.is_follower(case)) {
            let ids = self.particles_of(on.body, groups);
            for (id, vector) in self.particles.id[ids].iter().zip(&mut carried) {
                on.vectors[(id - on.first) as usize] = *vector;
            }
        }
    }

    /// Which particles are those of a body; none where it is gone.
    fn particles_of(&self, body: u32, groups: &[ParticleGroup]) -> Range<usize> {
        let Some(number) = groups.iter().position(|group| group.body == body) else { return 0..0 };
        let first = self.counts[..number].iter().sum();
        first..first + self.counts[number]
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.sequence.len()
    }

    /// Puts the state of its particles in the places `indices` of `domain`, where older copies of them are.
    pub fn update_ghosts(&self, domain: &mut SphSolver<D>, indices: &[u32]) {
        let SphSolver { setting, bodies, rates, .. } = domain;
        self.apply_loads(&setting.case, bodies);
        bodies.particles.put(&self.particles, indices);
        rates.derivatives.put(&self.rates, indices);
        let mut first = 0;
        for (group, (states, count)) in bodies.groups.iter_mut().zip(self.states.iter().zip(&self.counts)) {
            // The points stay where they are, but those that came take their states with them.
            let mut picks: Vec<(u32, u32)> = (0..group.states.len() as u32).map(|k| (0, k)).collect();
            for (k, &i) in indices[first..first + count].iter().enumerate() {
                picks[i as usize - group.start] = (1, k as u32);
            }
            first += count;
            group.states = States::gathered(&[&group.states, states], &picks);
        }
    }
}

/// Makes `domain` hold the particles of `parcels`, which bring the states of their laws, in their sequence and nothing
/// else. Returns the sequence and, for each parcel, where its particles stand.
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
    let listed = &mut lists.listed.positions;
    gather_entries(listed, |part| &parcels[part].listed, parcels.len(), &picks);
    // What follows from these is found anew.
    bodies.pair_data.grad_h_factor.clear();
    bodies.pair_data.records.clear();
    bodies.resize(picks.len());
    let mut sequence = Vec::new();
    gather_entries(&mut sequence, |part| &parcels[part].sequence, parcels.len(), &picks);
    (sequence, places)
}
