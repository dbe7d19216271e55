//! Records of a run: energy balance, broken bonds and controlled stresses.

use colluvium_case::{FailureReason, SolverError, spatial};

use crate::clock::Clock;
use crate::contact::ContactEnergies;
use crate::force_loop::contact_buffers::ContactBuffers;
use crate::neighbours::VerletLists;
use crate::output::energy_balance::{BrokenBond, EnergyBalance};
use crate::output::stress_control_check::ControlledStress;
use crate::points::grains::Grains;

/// Overlap over the smaller radius above which the run ends with an error (sheet: dem §3.5).
const MAX_OVERLAP: f64 = 0.3;

/// Energy balance, broken bonds and controlled stresses.
#[derive(Debug)]
pub struct Records {
    /// Energy balance.
    pub energy_balance: EnergyBalance,
    /// Broken bonds: time (s) and ids of the grains.
    pub broken_bonds: Vec<BrokenBond>,
    /// Records of the stress-controlled cell entries in row order, and then of the walls.
    pub controlled_stresses: Vec<ControlledStress>,
}

impl Records {
    /// Adds the energies of the contacts of a step, and records the bonds that broke.
    pub fn add_contacts<const D: usize, const R: usize>(
        &mut self,
        clock: &Clock,
        grains: &Grains<D, R>,
        pairs: &mut VerletLists<D, R>,
        energies: &ContactEnergies,
    ) {
        self.energy_balance.add_contacts(energies);
        if energies.bonds_broken > 0 {
            self.record_broken_bonds(clock, grains, pairs);
        }
    }

    /// Records the bonds that broke.
    fn record_broken_bonds<const D: usize, const R: usize>(
        &mut self,
        clock: &Clock,
        grains: &Grains<D, R>,
        lists: &mut VerletLists<D, R>,
    ) {
        for pairs in [&mut lists.slab_pairs, &mut lists.periodic_pairs] {
            for i in 0..grains.len() {
                for k in pairs.row_offsets[i] as usize..pairs.row_offsets[i + 1] as usize {
                    let bond = &mut pairs.histories.bond[k];
                    if bond.strength < 0.0 {
                        bond.strength = 0.0;
                        let other = pairs.second[k] as usize;
                        let across = pairs.image.get(k).is_some_and(|image| *image != 0);
                        let (x, y) = (&grains.position[i], &grains.position[if across { i } else { other }]);
                        self.broken_bonds.push(BrokenBond {
                            time: clock.time,
                            ids: [grains.id[i], grains.id[other]],
                            midpoint: spatial(&std::array::from_fn::<f64, D, _>(|c| 0.5 * (x[c] + y[c]))),
                        });
                    }
                }
            }
        }
    }

    /// Returns an error if two grains, or a grain and a wall, overlap too much.
    pub fn check_overlap<const D: usize, const R: usize>(
        &self,
        clock: &Clock,
        grains: &Grains<D, R>,
        buffers: &ContactBuffers<D, R>,
    ) -> Result<(), SolverError> {
        let overlap = self.energy_balance.overlap;
        if overlap <= MAX_OVERLAP {
            return Ok(());
        }
        let deepest = buffers.slab_energies.iter().find(|(energies, _)| energies.overlap == overlap);
        let grain = deepest.map_or(0, |(energies, _)| energies.max_overlap_grain as usize);
        let reason = format!(
            "overlaps another grain or a wall by {overlap:.2} of the smaller radius, more than {MAX_OVERLAP}: make contacts stiffer \
             or speeds smaller"
        );
        Err(clock.grain_error(grains, grain, FailureReason::Unstable(reason)))
    }
}
