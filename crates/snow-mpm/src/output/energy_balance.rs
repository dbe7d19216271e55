//! Energy balance (sheet: snow-mpm §2.11): stored, supplied and dissipated energies, and the numerical remainder.

use colluvium_case::Reaction;
use colluvium_case::measure::ScalarOutput;
use serde::{Deserialize, Serialize};

use crate::momentum::MomentumTerms;
use crate::obstacles::node_obstacles::MAX_RECORDED;
use crate::points::bodies::Bodies;

/// Energy balance since the start (J).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyBalance {
    /// Energy at the start.
    start: f64,
    /// Kinetic energy of the points at the start, less that of points that left or were reset.
    kinetic_at_start: f64,
    /// Kinetic energy gained by the nodes within the steps.
    nodes: f64,
    /// Work of gravity.
    gravity: f64,
    /// Work of walls on the nodes, friction and stops included; negative where it dissipates.
    boundary: f64,
    /// Energy dissipated by friction at obstacles, part of the work of walls.
    friction: f64,
    /// Work of local damping, negative.
    damping: f64,
    /// Energy of points that left, and energy reset between stages.
    removed: f64,
    /// Dissipated energy of points that have left.
    dissipated_of_removed: f64,
    /// Removals of each cut of the case.
    cuts: Vec<CutRemoval>,
    /// Reactions of the obstacles with a measured reaction.
    borne: [Reaction; MAX_RECORDED],
}

/// Removal by a cut since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutRemoval {
    /// Displacement of the cut (m).
    pub travel: f64,
    /// Mass removed (kg).
    pub mass: f64,
    /// Kinetic and recoverable energy removed (J), part of the removed energy.
    pub energy: f64,
}

impl CutRemoval {
    /// Displacement of the cut (m) after its start: a cut at rest starts with its first removal.
    pub fn travel_if_started(&self) -> Option<f64> {
        (self.travel > 0.0 || self.mass > 0.0).then_some(self.travel)
    }
}

/// Energies of the points at a time (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StoredEnergies {
    /// Kinetic energy of the points without affine fields.
    pub kinetic: f64,
    /// Kinetic energy of the affine velocity fields, with APIC.
    pub affine: f64,
    /// Recoverable energy of the materials.
    pub elastic: f64,
    /// Work of the stresses that is not recoverable.
    pub dissipated: f64,
}

impl StoredEnergies {
    /// Returns the energies of bodies whose shape functions have the second moment `moment` (m²).
    pub fn of_bodies<const D: usize>(bodies: &Bodies<D>, moment: f64) -> Self {
        let mut stored = Self::default();
        for body in &bodies.all {
            let [kinetic, affine] = body.kinetic_energies(moment);
            let elastic: f64 = body.stored_energies().iter().sum();
            stored.kinetic += kinetic;
            stored.affine += affine;
            stored.elastic += elastic;
            stored.dissipated += body.points.work.iter().sum::<f64>() - elastic;
        }
        stored
    }

    /// Kinetic energy, including that of the affine fields.
    pub fn kinetic_total(&self) -> f64 {
        self.kinetic + self.affine
    }

    /// Sum of all energies.
    pub fn total(&self) -> f64 {
        self.kinetic + self.affine + self.elastic + self.dissipated
    }
}

impl EnergyBalance {
    /// Returns the balance at the start of a run with this number of cuts.
    pub fn new(stored: &StoredEnergies, cuts: usize) -> Self {
        Self {
            start: stored.total(),
            kinetic_at_start: stored.kinetic_total(),
            cuts: vec![CutRemoval::default(); cuts],
            borne: [Reaction { moment: Some([0.0; 3]), ..Reaction::default() }; MAX_RECORDED],
            ..Self::default()
        }
    }

    /// Removal by cut number `number`.
    pub fn removal(&mut self, number: usize) -> &mut CutRemoval {
        &mut self.cuts[number]
    }

    /// Removals of the cuts, in the order of the case.
    pub fn removals(&self) -> &[CutRemoval] {
        &self.cuts
    }

    /// Reaction of obstacle number `number` of those with a measured reaction.
    pub fn reactions(&self, number: usize) -> Reaction {
        self.borne[number]
    }

    /// Adds a step of `dt` (s).
    pub fn add(&mut self, sums: &MomentumTerms, dt: f64) {
        let bears = sums.impulses.iter().zip(&sums.moments);
        for (borne, (impulse, moment)) in self.borne.iter_mut().zip(bears) {
            borne.moment = Some(moment.map(|c| c / dt));
            borne.force = impulse.map(|c| c / dt);
            (0..3).for_each(|c| borne.impulse[c] += impulse[c]);
        }
        self.gravity += sums.gravity;
        self.nodes += sums.kinetic_gain;
        self.boundary += sums.boundary;
        self.damping += sums.damping;
        self.friction += sums.friction;
    }

    /// Adds an instantaneous change, as of points that left or were reset, from the energies `before` and `after`.
    pub fn add_change(&mut self, before: &StoredEnergies, after: &StoredEnergies) {
        self.removed += before.total() - after.total();
        self.kinetic_at_start -= before.kinetic_total() - after.kinetic_total();
    }

    /// Adds the removal of points: their dissipated energy remains in the balance. Returns the energy removed (J).
    pub fn add_removed(&mut self, before: &StoredEnergies, after: &StoredEnergies) -> f64 {
        let gone = before.dissipated - after.dissipated;
        let removed = before.total() - after.total() - gone;
        self.dissipated_of_removed += gone;
        self.removed += removed;
        self.kinetic_at_start -= before.kinetic_total() - after.kinetic_total();
        removed
    }

    /// Energy dissipated by the law since the start (J).
    pub fn dissipated(&self, stored: &StoredEnergies) -> f64 {
        stored.dissipated + self.dissipated_of_removed
    }

    /// Numerical dissipation since the start: the remainder of the balance (J).
    pub fn numerical(&self, stored: &StoredEnergies) -> f64 {
        let came = self.start + self.gravity + self.boundary + self.damping - self.removed;
        came - stored.total() - self.dissipated_of_removed
    }

    /// Kinetic energy lost in the transfers between points and nodes since the start (J): all change outside the nodal solve of the steps.
    /// It is part of the numerical dissipation.
    pub fn transfer_loss(&self, stored: &StoredEnergies) -> f64 {
        self.kinetic_at_start + self.nodes - stored.kinetic_total()
    }

    /// Energy dissipated by friction at obstacles since the start (J).
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Scalar outputs of the balance, for a row of the measures.
    pub fn scalar_outputs(&self, stored: &StoredEnergies) -> Vec<ScalarOutput> {
        let entries = [
            ("energy_translation", stored.kinetic),
            ("energy_affine", stored.affine),
            ("energy_stored", stored.elastic),
            ("work_of_gravity", self.gravity),
            ("work_of_walls", self.boundary),
            ("work_of_damping", self.damping),
            ("energy_plastic", self.dissipated(stored)),
            ("energy_numerical", self.numerical(stored)),
            ("energy_filtered", self.transfer_loss(stored)),
        ];
        entries.into_iter().map(|(name, value)| (name.to_owned(), "J".to_owned(), value)).collect()
    }
}
