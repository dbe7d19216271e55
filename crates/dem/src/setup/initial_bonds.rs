//! Bonds and cohesion at the start.

use colluvium_case::CaseError;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::boundary::periodic_cell::PeriodicCell;
use crate::clock::Clock;
use crate::contact::bond::Bond;
use crate::contact::contact_laws::ContactLaws;
use crate::contact::{AttractionLaw, ContactState, PairLaw};
use crate::neighbours::VerletLists;
use crate::points::grains::Grains;
use crate::points::vector::{difference, dot};
use crate::specimen::size_distributions::gamma;
use crate::specimen::specimen_preparation::SpecimenSource;

/// Pair of grains that may be bonded.
struct BondCandidate<'a> {
    /// Ids of the two grains, ascending.
    ids: (u32, u32),
    /// Whether the pair is in the list across the periodic boundary.
    is_periodic: bool,
    /// Number of the pair in its list.
    pair: usize,
    /// Gap between the two (m).
    gap: f64,
    /// Law of the contact.
    law: &'a PairLaw,
    /// Sum of the radii (m).
    radii: f64,
}

/// Creates bonds between grains in contact at the start, and sets the cohesion of their contacts.
pub(super) fn initialise_bonds<const D: usize, const R: usize>(
    clock: &Clock,
    laws: &ContactLaws,
    grains: &Grains<D, R>,
    cell: &PeriodicCell<D>,
    lists: &mut VerletLists<D, R>,
    source: &SpecimenSource,
) -> Result<(), CaseError> {
    let has_bonds = laws.stage.pairs.iter().any(|law| law.bond.is_some());
    let coheres = |law: &PairLaw| matches!(law.attraction, Some(AttractionLaw::Cohesion(_)));
    if !has_bonds && !laws.stage.pairs.iter().any(coheres) {
        return Ok(());
    }
    let mut random = ChaCha8Rng::seed_from_u64(clock.options.seed ^ 0xb0d5);
    let (mut candidates, mut bonds) = bond_candidates(laws, grains, cell, lists, source);
    // Strengths are drawn in the order of ids.
    candidates.sort_by_key(|candidate| candidate.ids);
    for BondCandidate { is_periodic, pair, gap, law, radii, .. } in candidates {
        let list = if is_periodic { &mut lists.periodic_pairs } else { &mut lists.slab_pairs };
        if let Some(beam) = law.bond
            && gap <= beam.gap * radii
        {
            list.histories.bond[pair].strength = strength(beam.scatter, &mut random);
            bonds += 1;
        }
        if let Some(AttractionLaw::Cohesion(_)) = law.attraction
            && gap < 0.0
        {
            list.histories.state[pair] = ContactState::Bonded;
        }
    }
    if has_bonds && bonds == 0 {
        let problem =
            "no two grains are near enough at the start to be bonded: fill more densely, or raise bond.gap";
        return Err(CaseError::new("methods.dem.pairs", problem));
    }
    Ok(())
}

/// Listed pairs that may be bonded, and the number of pairs that a specimen file states to be bonded.
fn bond_candidates<'a, const D: usize, const R: usize>(
    laws: &'a ContactLaws,
    g: &Grains<D, R>,
    cell: &PeriodicCell<D>,
    lists: &VerletLists<D, R>,
    source: &SpecimenSource,
) -> (Vec<BondCandidate<'a>>, usize) {
    let mut shifts = Vec::new();
    cell.shifts(&mut shifts);
    let (mut candidates, mut bonds) = (Vec::new(), 0usize);
    for (pairs, is_periodic) in [(&lists.slab_pairs, false), (&lists.periodic_pairs, true)] {
        for (i, k) in pairs.first_grains() {
            let j = pairs.second[k] as usize;
            let is_of_file = |grain: usize| source.has_body(g.body[grain] as usize);
            if source.has_bonds && is_of_file(i) && is_of_file(j) {
                // The file states that it is bonded, or broken.
                bonds += usize::from(pairs.histories.bond.get(k).is_some_and(Bond::is_intact));
                continue;
            }
            let code = pairs.image.get(k).map_or(0, |code| *code as usize);
            let apart = difference(&difference(&g.position[i], &g.position[j]), &shifts[code].0);
            candidates.push(BondCandidate {
                ids: (g.id[i].min(g.id[j]), g.id[i].max(g.id[j])),
                is_periodic,
                pair: k,
                gap: dot(&apart, &apart).sqrt() - g.radius[i] - g.radius[j],
                law: &laws.stage.pairs[g.kind[i] as usize * laws.kinds.len() + g.kind[j] as usize],
                radii: g.radius[i] + g.radius[j],
            });
        }
    }
    (candidates, bonds)
}

/// Random factor on strengths, of a Weibull distribution of mean 1 and coefficient of variation `scatter`.
fn strength(scatter: f64, random: &mut ChaCha8Rng) -> f64 {
    if scatter == 0.0 {
        return 1.0;
    }
    // Weibull modulus from the coefficient of variation (Justus and Mikhail 1976, within 1 % from 0.1 to 1).
    let modulus = scatter.powf(-1.086);
    let draw: f64 = 1.0 - random.random::<f64>();
    (-draw.ln()).powf(1.0 / modulus) / gamma(1.0 + 1.0 / modulus)
}
