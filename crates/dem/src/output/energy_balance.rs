//! Energy balance (sheet: dem §2.14): stored energy, energy input and dissipation, all at the time of the last forces.

use colluvium_case::measure::ScalarOutput;
use serde::{Deserialize, Serialize};

use crate::contact::ContactEnergies;
use crate::momentum::time_integration::GrainSums;

/// Record of a broken bond.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BrokenBond {
    /// Time of the breakage (s).
    pub time: f64,
    /// Ids of the two grains.
    pub ids: [u32; 2],
    /// Midpoint of the two grains (m); for a pair across a periodic boundary the centre of the first grain.
    pub midpoint: [f64; 3],
}

/// Energy balance of a run (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyBalance {
    /// Kinetic energy of centres.
    pub kinetic: f64,
    /// Kinetic energy of rotations.
    pub rotation: f64,
    /// Elastic energy of overlaps.
    pub elastic: f64,
    /// Elastic energy of tangential springs.
    pub elastic_tangential: f64,
    /// Elastic energy of rolling and torsion springs.
    pub elastic_rolling: f64,
    /// Elastic energy of bonds.
    pub elastic_bonds: f64,
    /// Work of gravity since the start.
    pub gravity: f64,
    /// Work of forces on bodies and of membranes since the start.
    pub applied_work: f64,
    /// Work of walls, grains with prescribed motion, cell deformation and growth since the start (J).
    pub boundary: f64,
    /// Kinetic energy of grains that entered since the start.
    pub inflow: f64,
    /// Energy changes between stages, by changed laws and velocities (J).
    pub stage_changes: f64,
    /// Energy dissipated by friction.
    pub friction: f64,
    /// Energy dissipated by dashpots.
    pub dashpots: f64,
    /// Energy dissipated by rolling and torsion resistance.
    pub rolling: f64,
    /// Energy lost where springs are rescaled or their contact ends (J).
    pub spring_loss: f64,
    /// Work done against attraction (J); negative where attraction does work on the grains.
    pub attraction: f64,
    /// Energy of bonds that broke.
    pub broken: f64,
    /// Energy dissipated by damping.
    pub damping: f64,
    /// Stored energy at the start.
    pub start: Option<f64>,
    /// Shares of gravity, damping, held grains and applied forces in the half step that follows.
    next_half_step: [f64; 4],
    /// Balance at the start of a stage, from which it continues.
    carried_balance: Option<f64>,
    /// Number of contacts with a force, and number of slipping contacts.
    pub contacts: [u64; 2],
    /// Number of bonds broken since the start.
    pub bonds_broken: u64,
    /// Sums of the squares of forces on grains and of contact forces (N²).
    pub squares: [f64; 2],
    /// Largest overlap over the smaller radius.
    pub overlap: f64,
}

impl EnergyBalance {
    /// Stored energy: kinetic and elastic (J).
    pub fn stored(&self) -> f64 {
        self.kinetic + self.rotation + self.recoverable()
    }

    /// Elastic energy of the contacts (J).
    pub fn recoverable(&self) -> f64 {
        self.elastic + self.elastic_tangential + self.elastic_rolling + self.elastic_bonds
    }

    /// Dissipated energy (J).
    pub fn dissipated(&self) -> f64 {
        self.friction
            + self.dashpots
            + self.rolling
            + self.spring_loss
            + self.attraction
            + self.broken
            + self.damping
    }

    /// Error of the energy balance (J): stored plus dissipated energy minus initial energy and input.
    pub fn balance(&self) -> f64 {
        let came = self.start.unwrap_or(0.0)
            + self.gravity
            + self.applied_work
            + self.boundary
            + self.inflow
            + self.stage_changes;
        self.stored() + self.dissipated() - came
    }

    /// Initial energy plus the absolute values of the inputs (J).
    pub fn input(&self) -> f64 {
        self.start.unwrap_or(0.0)
            + self.gravity.abs()
            + self.applied_work.abs()
            + self.boundary.abs()
            + self.inflow
            + self.stage_changes.abs()
    }

    /// Begins a stage, whose energy changes count as input.
    pub fn begin_stage(&mut self) {
        if self.start.is_some() {
            self.carried_balance = Some(self.balance());
        }
    }

    /// Continues the state of another run: the balance starts with the first step.
    pub fn continue_from_other_run(&mut self) {
        self.carried_balance = Some(0.0);
    }

    /// Adds the sums over contacts of a step.
    pub fn add_contacts(&mut self, energies: &ContactEnergies) {
        self.elastic = energies.elastic;
        self.elastic_tangential = energies.elastic_tangential;
        self.elastic_rolling = energies.elastic_rolling;
        self.elastic_bonds = energies.elastic_bonds;
        self.friction += energies.friction;
        self.dashpots += energies.dashpots;
        self.rolling += energies.rolling;
        self.spring_loss += energies.spring_loss;
        self.attraction += energies.attraction;
        self.broken += energies.broken;
        self.boundary += energies.boundary;
        self.contacts = [energies.contacts, energies.sliding];
        self.bonds_broken += energies.bonds_broken;
        self.squares[1] = energies.squares;
        self.overlap = energies.overlap;
    }

    /// Adds the sums over grains of a step, of which the fraction `share` is before the time of the forces.
    pub fn add_grains<const D: usize>(&mut self, sums: &GrainSums<D>, share: f64) {
        let now = [sums.gravity, sums.damping, sums.held_work, sums.applied_work];
        let sum = |k: usize| self.next_half_step[k] + share * now[k];
        let [gravity, damping, held, applied] = [sum(0), sum(1), sum(2), sum(3)];
        self.gravity += gravity;
        self.applied_work += applied;
        self.damping += damping;
        self.boundary += held;
        self.next_half_step = now.map(|value| (1.0 - share) * value);
        // The velocities at the time of the forces are those before the change of the cell velocity gradient.
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

    /// Scalar outputs of the energy balance.
    pub fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        let error = if self.input() > 0.0 { self.balance() / self.input() } else { 0.0 };
        [
            ("rotational_energy", self.rotation),
            ("energy.tangential", self.elastic_tangential),
            ("energy.rolling", self.elastic_rolling),
            ("energy.bonds", self.elastic_bonds),
            ("work.gravity", self.gravity),
            ("work.forces", self.applied_work),
            ("work.boundaries", self.boundary),
            ("energy.entered", self.inflow),
            ("work.stages", self.stage_changes),
            ("dissipated.friction", self.friction),
            ("dissipated.dashpots", self.dashpots),
            ("dissipated.rolling", self.rolling),
            ("dissipated.rescaling", self.spring_loss),
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
