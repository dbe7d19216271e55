//! What ranks send each other: copies of particles.

use colluvium_constitutive::{States, SymTensor};

use crate::particles::Matrix;
use crate::solver::SphSolver;

/// Copies of particles with everything that is theirs, body after body.
#[derive(Clone, Debug, Default)]
pub struct Parcel<const D: usize> {
    /// Number of particles of each body.
    counts: Vec<usize>,
    /// Places of the particles in the order of a solver without ranks.
    pub sequence: Vec<u32>,
    id: Vec<u32>,
    vectors: [Vec<[f64; D]>; 4],
    scalars: [Vec<f64>; 4],
    stress: Vec<SymTensor>,
    gradient: Vec<Matrix<D>>,
    divergence: Vec<f64>,
    /// Positions for which neighbours are listed (m).
    listed: Vec<[f64; D]>,
    /// States of the laws, of each body; empty where they are not sent.
    states: Vec<States>,
}

fn pick<T: Copy>(to: &mut Vec<T>, from: &[T], indices: &[u32]) {
    to.clear();
    to.extend(indices.iter().map(|&i| from[i as usize]));
}

impl<const D: usize> Parcel<D> {
    /// Takes copies of the particles `indices`, ascending, of `domain`; the states of their laws where `whole`.
    pub fn fill(&mut self, domain: &SphSolver<D>, sequence: &[u32], indices: &[u32], whole: bool) {
        let p = &domain.particles;
        pick(&mut self.sequence, sequence, indices);
        pick(&mut self.id, &p.id, indices);
        self.vectors.iter_mut().zip(p.vectors()).for_each(|(to, from)| pick(to, from, indices));
        self.scalars.iter_mut().zip(p.scalars()).for_each(|(to, from)| pick(to, from, indices));
        pick(&mut self.stress, &p.stress, indices);
        pick(&mut self.gradient, &p.gradient, indices);
        pick(&mut self.divergence, &p.divergence, indices);
        let listed = &domain.listed.positions;
        pick(&mut self.listed, if listed.is_empty() { &p.position } else { listed }, indices);
        self.counts.clear();
        self.states.clear();
        let mut left = indices;
        for group in &domain.groups {
            let (own, others) = left.split_at(left.partition_point(|&i| (i as usize) < group.end));
            left = others;
            self.counts.push(own.len());
            if whole {
                let within: Vec<u32> = own.iter().map(|&i| i - group.start as u32).collect();
                self.states.push(group.states.permuted(&within));
            }
        }
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.sequence.len()
    }

    /// Puts the state of its particles in the places `indices` of `domain`, where older copies of them are.
    pub fn renew(&self, domain: &mut SphSolver<D>, indices: &[u32]) {
        fn put<T: Copy>(to: &mut [T], from: &[T], indices: &[u32]) {
            indices.iter().zip(from).for_each(|(&i, value)| to[i as usize] = *value);
        }
        let p = &mut domain.particles;
        p.vectors_mut().into_iter().zip(&self.vectors).for_each(|(to, from)| put(to, from, indices));
        p.scalars_mut().into_iter().zip(&self.scalars).for_each(|(to, from)| put(to, from, indices));
        put(&mut p.stress, &self.stress, indices);
        put(&mut p.gradient, &self.gradient, indices);
        put(&mut p.divergence, &self.divergence, indices);
        let mut first = 0;
        for (group, (states, count)) in domain.groups.iter_mut().zip(self.states.iter().zip(&self.counts)) {
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

fn gather<'a, T: Copy + 'a>(picks: &[(u32, u32)], from: impl Fn(usize) -> &'a Vec<T>, to: &mut Vec<T>) {
    to.clear();
    to.extend(picks.iter().map(|&(part, k)| from(part as usize)[k as usize]));
}

/// Makes `domain` hold the particles of `parcels`, which bring the states of their laws, in their sequence and nothing
/// else. Returns the sequence and, for each parcel, where its particles stand.
pub fn assemble<const D: usize>(
    domain: &mut SphSolver<D>,
    parcels: &[&Parcel<D>],
) -> (Vec<u32>, Vec<Vec<u32>>) {
    let mut picks: Vec<(u32, u32)> = Vec::new();
    let mut starts = vec![0; parcels.len()];
    for (number, group) in domain.groups.iter_mut().enumerate() {
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
    let mut p = std::mem::take(&mut domain.particles);
    p.len = picks.len();
    for (number, vectors) in p.vectors_mut().into_iter().enumerate() {
        gather(&picks, |part| &parcels[part].vectors[number], vectors);
    }
    for (number, scalars) in p.scalars_mut().into_iter().enumerate() {
        gather(&picks, |part| &parcels[part].scalars[number], scalars);
    }
    gather(&picks, |part| &parcels[part].id, &mut p.id);
    gather(&picks, |part| &parcels[part].stress, &mut p.stress);
    gather(&picks, |part| &parcels[part].gradient, &mut p.gradient);
    gather(&picks, |part| &parcels[part].divergence, &mut p.divergence);
    gather(&picks, |part| &parcels[part].listed, &mut domain.listed.positions);
    // What follows from these is found anew.
    p.spread.clear();
    p.records.clear();
    p.resize(p.len);
    domain.particles = p;
    let mut sequence = Vec::new();
    gather(&picks, |part| &parcels[part].sequence, &mut sequence);
    (sequence, places)
}
