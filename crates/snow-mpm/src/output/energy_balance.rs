//! Energy balance (sheet: snow-mpm §2.11): stored energies, external work, removed energy and numerical dissipation.

use colluvium_case::Reaction;
use colluvium_case::measure::ScalarOutput;
use serde::{Deserialize, Serialize};

use crate::momentum::MomentumTerms;
use crate::obstacles::node_obstacles::MAX_RECORDED;
use crate::points::bodies::Bodies;

/// Energy terms accumulated since the start (J).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyBalance {
    /// Total energy at the start.
    start: f64,
    /// Kinetic energy of the points at the start, less that of removed points and of resets.
    kinetic_at_start: f64,
    /// Kinetic energy gained by the nodes within the steps.
    nodes: f64,
    /// Work of gravity.
    gravity: f64,
    /// Work of the body force of a program.
    body_force: f64,
    /// Work of walls on the nodes, with friction and inelastic stops; negative where energy is lost.
    boundary: f64,
    /// Frictional dissipation at obstacles, a part of the work of walls.
    friction: f64,
    /// Work of local damping, negative.
    damping: f64,
    /// Energy removed with points, or by resets between stages.
    removed_energy: f64,
    /// Dissipation of the law in removed points.
    dissipated_of_removed: f64,
    /// Mass and energy removed by each cut of the case.
    cuts: Vec<CutRemoval>,
    /// Reactions of the recorded obstacles.
    reactions: [Reaction; MAX_RECORDED],
}

/// Mass and energy removed by a cut since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutRemoval {
    /// Distance that the cut has moved (m).
    pub cut_displacement: f64,
    /// Removed mass (kg).
    pub mass: f64,
    /// Removed kinetic and recoverable energy (J), a part of the total removed energy.
    pub energy: f64,
}

impl CutRemoval {
    /// Distance by which the cut has advanced (m); `None` before its start. A cut at rest starts when it removes mass.
    pub fn travel_if_started(&self) -> Option<f64> {
        (self.cut_displacement > 0.0 || self.mass > 0.0).then_some(self.cut_displacement)
    }
}

/// Current energies (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredEnergies {
    /// Kinetic energy of the point velocities.
    pub kinetic: f64,
    /// Kinetic energy of the affine velocity fields around the points, with APIC.
    pub affine_kinetic: f64,
    /// Recoverable energy of the materials.
    pub elastic: f64,
    /// Dissipated energy: work of the stresses that is not recoverable.
    pub dissipated_energy: f64,
}

impl StoredEnergies {
    /// Energies of bodies whose shape functions have the second moment `moment` (m²).
    pub fn of_bodies<const D: usize>(bodies: &Bodies<D>, moment: f64) -> Self {
        let mut stored = Self::default();
        for body in &bodies.bodies {
            let [kinetic, affine] = body.kinetic_energies(moment);
            let elastic: f64 = body.stored_energies().iter().sum();
            stored.kinetic += kinetic;
            stored.affine_kinetic += affine;
            stored.elastic += elastic;
            stored.dissipated_energy += body.points.work.iter().sum::<f64>() - elastic;
        }
        stored
    }

    /// Total kinetic energy, with that of the affine fields (J).
    pub fn kinetic_total(&self) -> f64 {
        self.kinetic + self.affine_kinetic
    }

    /// Sum of all energies (J).
    pub fn total(&self) -> f64 {
        self.kinetic + self.affine_kinetic + self.elastic + self.dissipated_energy
    }
}

impl EnergyBalance {
    /// Energy balance at the start of a run with a number of cuts.
    pub fn new(stored: &StoredEnergies, cuts: usize) -> Self {
        Self {
            start: stored.total(),
            kinetic_at_start: stored.kinetic_total(),
            cuts: vec![CutRemoval::default(); cuts],
            reactions: [Reaction { moment: Some([0.0; 3]), ..Reaction::default() }; MAX_RECORDED],
            ..Self::default()
        }
    }

    /// Mass and energy removed by cut number `number`.
    pub fn removal(&mut self, number: usize) -> &mut CutRemoval {
        &mut self.cuts[number]
    }

    /// Mass and energy removed by the cuts, in the order of the case.
    pub fn removals(&self) -> &[CutRemoval] {
        &self.cuts
    }

    /// Reaction of recorded obstacle number `number`.
    pub fn reactions(&self, number: usize) -> Reaction {
        self.reactions[number]
    }

    /// Adds the terms of a step of `dt` (s).
    pub fn add(&mut self, sums: &MomentumTerms, dt: f64) {
        let bears = sums.impulses.iter().zip(&sums.moments);
        for (reaction, (impulse, moment)) in self.reactions.iter_mut().zip(bears) {
            reaction.moment = Some(moment.map(|c| c / dt));
            reaction.force = impulse.map(|c| c / dt);
            (0..3).for_each(|c| reaction.impulse[c] += impulse[c]);
        }
        self.gravity += sums.gravity;
        self.nodes += sums.kinetic_gain;
        self.boundary += sums.boundary;
        self.damping += sums.damping;
        self.friction += sums.friction;
    }

    /// Adds the work of the body force of a program in a step (J).
    pub fn add_body_force_work(&mut self, work: f64) {
        self.body_force += work;
    }

    /// Work of the body force of a program since the start (J).
    pub fn body_force_work(&self) -> f64 {
        self.body_force
    }

    /// Adds a sudden change of energy, by removed points, resets or a program, from the energies `before` and `after`.
    pub fn add_change(&mut self, before: &StoredEnergies, after: &StoredEnergies) {
        self.removed_energy += before.total() - after.total();
        self.kinetic_at_start -= before.kinetic_total() - after.kinetic_total();
    }

    /// Records the removal of points; the dissipation in them remains in the balance. Returns the removed energy (J).
    pub fn add_removed(&mut self, before: &StoredEnergies, after: &StoredEnergies) -> f64 {
        let gone = before.dissipated_energy - after.dissipated_energy;
        let removed = before.total() - after.total() - gone;
        self.dissipated_of_removed += gone;
        self.removed_energy += removed;
        self.kinetic_at_start -= before.kinetic_total() - after.kinetic_total();
        removed
    }

    /// Dissipation of the law since the start (J).
    pub fn law_dissipation(&self, stored: &StoredEnergies) -> f64 {
        stored.dissipated_energy + self.dissipated_of_removed
    }

    /// Numerical dissipation since the start, the remainder of the balance (J).
    pub fn numerical(&self, stored: &StoredEnergies) -> f64 {
        let external = self.start + self.gravity + self.boundary + self.damping + self.body_force;
        let came = external - self.removed_energy;
        came - stored.total() - self.dissipated_of_removed
    }

    /// Loss of kinetic energy in the transfers between points and nodes since the start (J): all change outside the nodal momentum
    /// equation. It is part of the numerical dissipation.
    pub fn transfer_loss(&self, stored: &StoredEnergies) -> f64 {
        self.kinetic_at_start + self.nodes - stored.kinetic_total()
    }

    /// Frictional dissipation at obstacles since the start (J).
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Entries of the energy balance as scalar outputs.
    pub fn scalar_outputs(&self, stored: &StoredEnergies) -> Vec<ScalarOutput> {
        let entries = [
            ("energy_translation", stored.kinetic),
            ("energy_affine", stored.affine_kinetic),
            ("energy_stored", stored.elastic),
            ("work_of_gravity", self.gravity),
            ("work_of_walls", self.boundary),
            ("work_of_damping", self.damping),
            ("energy_plastic", self.law_dissipation(stored)),
            ("energy_numerical", self.numerical(stored)),
            ("energy_filtered", self.transfer_loss(stored)),
        ];
        entries.into_iter().map(|(name, value)| (name.to_owned(), "J".to_owned(), value)).collect()
    }
}
