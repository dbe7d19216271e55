//! Force chains from the grain stresses (Peters et al. 2005; sheet: dem §3.9).
//!
//! A grain is part of a chain where the largest compressive stress of its contacts is above the mean of all grains. It links to another
//! such grain in contact with it where the line of centres lies within 45° of the direction of that stress in both. Chains are
//! sets of linked grains, three or more.

use colluvium_case::measure::ScalarOutput;
use colluvium_points::UnionFind;

use crate::output::packing_view::PackingView;
use crate::points::vector::{dot, norm};

/// Smallest cosine of the angle between the major principal stress and the line of centres in a force chain.
const MIN_ALIGNMENT_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Number of grains of the shortest chain.
const MIN_CHAIN_LENGTH: usize = 3;

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Force chains as ascending grain numbers, the longest chain first, and of equal ones that with the lowest number.
    pub fn force_chains(&self) -> Vec<Vec<usize>> {
        let (stresses, _) = self.grain_stresses();
        let count = stresses.len();
        // Compression is negative: the major compressive stress is the lowest eigenvalue.
        let major: Vec<(f64, [f64; D])> = stresses
            .iter()
            .map(|stress| {
                let spectrum = stress.spectrum();
                let direction = spectrum.directions[2];
                (-spectrum.values[2], std::array::from_fn(|c| direction[c]))
            })
            .collect();
        let free = (0..count).filter(|&i| !self.grains.is_held[i]);
        let mean = free.clone().map(|i| major[i].0).sum::<f64>() / free.count().max(1) as f64;
        let strong = |i: usize| major[i].0 > mean && major[i].0 > 0.0 && !self.grains.is_held[i];
        let mut chains = UnionFind::new(count);
        self.for_each_contact(|contact, _, _| {
            let (i, Some(j)) = (contact.grain, contact.second) else { return };
            let along = |k: usize| {
                dot(&major[k].1, &contact.branch).abs() >= MIN_ALIGNMENT_COSINE * norm(&contact.branch)
            };
            if contact.normal > 0.0 && strong(i) && strong(j) && along(i) && along(j) {
                chains.union(i, j);
            }
        });
        let mut of: Vec<Vec<usize>> = vec![Vec::new(); count];
        (0..count).for_each(|i| of[chains.root(i)].push(i));
        of.retain(|grains| grains.len() >= MIN_CHAIN_LENGTH);
        of.sort_by_key(|grains| (std::cmp::Reverse(grains.len()), grains[0]));
        of
    }

    /// Scalar outputs of the force chains.
    pub(crate) fn chain_outputs(&self) -> Vec<ScalarOutput> {
        let chains = self.force_chains();
        let free = self.grains.is_held.iter().filter(|held| !**held).count() as f64;
        let inside = chains.iter().map(Vec::len).sum::<usize>() as f64;
        let longest = chains.first().map_or(0.0, |grains| grains.len() as f64);
        [("chains.count", chains.len() as f64), ("chains.longest", longest), ("chains.grains", inside / free)]
            .map(|(name, value)| (name.to_owned(), String::new(), value))
            .to_vec()
    }
}
