//! The energy balance (sheet: dem §2.14): what there is, what came in, what went, all at the time of the last forces.

use colluvium_case::measure::ScalarOutput;
use serde::{Deserialize, Serialize};

use crate::contact::ContactEnergies;
use crate::momentum::time_integration::GrainSums;

/// A bond that has broken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BrokenBond {
    /// When (s).
    pub time: f64,
    /// Ids of its grains.
    pub ids: [u32; 2],
    /// Half way between these, or the centre of the first where they met across a side of a periodic cell (m).
    pub place: [f64; 3],
}

/// Energies (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyBalance {
    /// Kinetic energy of centres.
    pub kinetic: f64,
    /// Kinetic energy of rotations.
    pub rotation: f64,
    /// Energy of overlaps.
    pub elastic: f64,
    /// Energy of springs across.
    pub elastic_tangential: f64,
    /// Energy of springs against rolling and twisting.
    pub elastic_rolling: f64,
    /// Energy of bonds.
    pub elastic_bonds: f64,
    /// Work of gravity since the start.
    pub gravity: f64,
    /// Work of forces on bodies and of membranes since the start.
    pub applied: f64,
    /// Work of walls, held grains, a moving cell and growth since the start.
    pub boundary: f64,
    /// Kinetic energy of grains that entered since the start.
    pub entered: f64,
    /// Changes between stages: other laws, velocities set.
    pub stage_changes: f64,
    /// Taken by friction.
    pub friction: f64,
    /// Taken by dashpots.
    pub dashpots: f64,
    /// Taken by resistance against rolling and twisting.
    pub rolling: f64,
    /// Taken where springs are rescaled or vanish.
    pub rescaled: f64,
    /// Taken by attraction; negative where it gives.
    pub attraction: f64,
    /// Taken by bonds that broke.
    pub broken: f64,
    /// Taken by damping.
    pub damping: f64,
    /// What there was at the start.
    pub start: Option<f64>,
    /// What of gravity, damping, held grains and applied forces belongs to the half step that follows.
    next_half_step: [f64; 4],
    /// The balance to go on from when a stage begins.
    carried_balance: Option<f64>,
    /// Contacts with a force, and those that slip.
    pub contacts: [u64; 2],
    /// Bonds that have broken since the start.
    pub bonds_broken: u64,
    /// Sums of the squares of forces on grains and of contact forces (N²).
    pub squares: [f64; 2],
    /// Largest overlap over the smaller radius.
    pub overlap: f64,
}

impl EnergyBalance {
    /// What there is.
    pub fn stored(&self) -> f64 {
        self.kinetic + self.rotation + self.recoverable()
    }

    /// What contacts hold.
    pub fn recoverable(&self) -> f64 {
        self.elastic + self.elastic_tangential + self.elastic_rolling + self.elastic_bonds
    }

    /// What has been taken out.
    pub fn dissipated(&self) -> f64 {
        self.friction
            + self.dashpots
            + self.rolling
            + self.rescaled
            + self.attraction
            + self.broken
            + self.damping
    }

    /// What there is and went, less what there was and came: nothing.
    pub fn balance(&self) -> f64 {
        let came = self.start.unwrap_or(0.0)
            + self.gravity
            + self.applied
            + self.boundary
            + self.entered
            + self.stage_changes;
        self.stored() + self.dissipated() - came
    }

    /// What came in, by size.
    pub fn input(&self) -> f64 {
        self.start.unwrap_or(0.0)
            + self.gravity.abs()
            + self.applied.abs()
            + self.boundary.abs()
            + self.entered
            + self.stage_changes.abs()
    }

    /// When a stage begins what changes with it is no error.
    pub fn begin_stage(&mut self) {
        if self.start.is_some() {
            self.carried_balance = Some(self.balance());
        }
    }

    /// What happened before belongs to another run: the balance is that from the first step on.
    pub fn continue_from_other_run(&mut self) {
        self.carried_balance = Some(0.0);
    }

    /// Sums over contacts of a step.
    pub fn add_contacts(&mut self, tally: &ContactEnergies) {
        self.elastic = tally.elastic;
        self.elastic_tangential = tally.elastic_tangential;
        self.elastic_rolling = tally.elastic_rolling;
        self.elastic_bonds = tally.elastic_bonds;
        self.friction += tally.friction;
        self.dashpots += tally.dashpots;
        self.rolling += tally.rolling;
        self.rescaled += tally.rescaled;
        self.attraction += tally.attraction;
        self.broken += tally.broken;
        self.boundary += tally.boundary;
        self.contacts = [tally.contacts, tally.sliding];
        self.bonds_broken += tally.bonds_broken;
        self.squares[1] = tally.squares;
        self.overlap = tally.overlap;
    }

    /// Sums over grains of a step, of which `share` lies before the time of the forces.
    pub fn add_grains<const D: usize>(&mut self, sums: &GrainSums<D>, share: f64) {
        let now = [sums.gravity, sums.damping, sums.held, sums.applied];
        let sum = |k: usize| self.next_half_step[k] + share * now[k];
        let [gravity, damping, held, applied] = [sum(0), sum(1), sum(2), sum(3)];
        self.gravity += gravity;
        self.applied += applied;
        self.damping += damping;
        self.boundary += held;
        self.next_half_step = now.map(|value| (1.0 - share) * value);
        // Velocities at the time of the forces are those before the cell changed them.
        self.next_half_step[2] += sums.cell;
        (self.kinetic, self.rotation) = (sums.kinetic, sums.rotation);
        self.squares[0] = sums.squares;
        if self.start.is_none() {
            self.start = Some(self.stored());
        }
        if let Some(balance) = self.carried_balance.take() {
            self.stage_changes += self.balance() - balance;
        }
    }

    /// What goes into the rows of the measures.
    pub fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        let error = if self.input() > 0.0 { self.balance() / self.input() } else { 0.0 };
        [
            ("rotational_energy", self.rotation),
            ("energy.tangential", self.elastic_tangential),
            ("energy.rolling", self.elastic_rolling),
            ("energy.bonds", self.elastic_bonds),
            ("work.gravity", self.gravity),
            ("work.forces", self.applied),
            ("work.boundaries", self.boundary),
            ("energy.entered", self.entered),
            ("work.stages", self.stage_changes),
            ("dissipated.friction", self.friction),
            ("dissipated.dashpots", self.dashpots),
            ("dissipated.rolling", self.rolling),
            ("dissipated.rescaling", self.rescaled),
            ("dissipated.attraction", self.attraction),
            ("dissipated.bonds", self.broken),
            ("dissipated.damping", self.damping),
            ("energy_balance", self.balance()),
        ]
        .into_iter()
        .map(|(name, value)| (name.to_owned(), "J".to_owned(), value))
        .chain([
            ("energy_error".to_owned(), String::new(), error),
            ("contacts".to_owned(), String::new(), self.contacts[0] as f64),
            ("sliding_contacts".to_owned(), String::new(), self.contacts[1] as f64),
            ("broken_bonds".to_owned(), String::new(), self.bonds_broken as f64),
            ("largest_overlap".to_owned(), String::new(), self.overlap),
        ])
        .collect()
    }
}
