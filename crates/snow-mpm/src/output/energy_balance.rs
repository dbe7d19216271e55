//! The energy balance (sheet: snow-mpm §2.11): what there is, what came in, what went, and what the numerics took.

use colluvium_case::Reaction;
use colluvium_case::measure::ScalarOutput;
use serde::{Deserialize, Serialize};

use crate::momentum::MomentumTerms;
use crate::obstacles::node_obstacles::MAX_RECORDED;
use crate::points::bodies::Bodies;

/// What came in and went since the start (J).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyBalance {
    /// What there was at the start.
    start: f64,
    /// Kinetic energy of the points that there was at the start, less that of those that left or were set back.
    kinetic_at_start: f64,
    /// Kinetic energy that the nodes have gained within the steps.
    nodes: f64,
    /// Work of gravity.
    gravity: f64,
    /// Work of walls on the nodes, friction and stops included; negative where they take.
    boundary: f64,
    /// What friction has taken at obstacles, part of what walls do.
    friction: f64,
    /// Work of local damping, negative.
    damping: f64,
    /// What left with points, or was set back between stages.
    removed: f64,
    /// What the law had dissipated of points that have left.
    dissipated_of_removed: f64,
    /// What each cut of the case has taken.
    cuts: Vec<CutRemoval>,
    /// What the obstacles have borne whose reaction is measured.
    borne: [Reaction; MAX_RECORDED],
}

/// What a cut has taken since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CutRemoval {
    /// How far it has moved (m).
    pub travel: f64,
    /// Mass (kg).
    pub mass: f64,
    /// Kinetic and recoverable energy (J), part of what was removed.
    pub energy: f64,
}

impl CutRemoval {
    /// How far the cut has moved (m), if it has begun: one that stands still begins with what it takes.
    pub fn travel_if_started(&self) -> Option<f64> {
        (self.travel > 0.0 || self.mass > 0.0).then_some(self.travel)
    }
}

/// What there is at a time (J).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StoredEnergies {
    /// Kinetic energy of the points as bodies of their own.
    pub kinetic: f64,
    /// Kinetic energy of the velocity fields around them, with APIC.
    pub affine: f64,
    /// Recoverable energy of the materials.
    pub elastic: f64,
    /// Work of the stresses that is not recoverable.
    pub dissipated: f64,
}

impl StoredEnergies {
    /// Of bodies whose shape functions have the second moment `moment` (m²).
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

    /// Kinetic energy, that of the fields around the points included.
    pub fn kinetic_total(&self) -> f64 {
        self.kinetic + self.affine
    }

    /// All of it.
    pub fn total(&self) -> f64 {
        self.kinetic + self.affine + self.elastic + self.dissipated
    }
}

impl EnergyBalance {
    /// At the start of a run with so many cuts.
    pub fn new(stored: &StoredEnergies, cuts: usize) -> Self {
        Self {
            start: stored.total(),
            kinetic_at_start: stored.kinetic_total(),
            cuts: vec![CutRemoval::default(); cuts],
            borne: [Reaction { moment: Some([0.0; 3]), ..Reaction::default() }; MAX_RECORDED],
            ..Self::default()
        }
    }

    /// What cut number `number` has taken.
    pub fn removal(&mut self, number: usize) -> &mut CutRemoval {
        &mut self.cuts[number]
    }

    /// What the cuts have taken, in the order of the case.
    pub fn removals(&self) -> &[CutRemoval] {
        &self.cuts
    }

    /// What obstacle number `number` of those whose reaction is measured has borne.
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

    /// Books what went at once, as points left or were set back: what there was `before` and `after`.
    pub fn add_change(&mut self, before: &StoredEnergies, after: &StoredEnergies) {
        self.removed += before.total() - after.total();
        self.kinetic_at_start -= before.kinetic_total() - after.kinetic_total();
    }

    /// Books points that left: what the law had dissipated there stays on the account. The energy that went with them (J).
    pub fn add_removed(&mut self, before: &StoredEnergies, after: &StoredEnergies) -> f64 {
        let gone = before.dissipated - after.dissipated;
        let removed = before.total() - after.total() - gone;
        self.dissipated_of_removed += gone;
        self.removed += removed;
        self.kinetic_at_start -= before.kinetic_total() - after.kinetic_total();
        removed
    }

    /// What the law has dissipated since the start (J).
    pub fn dissipated(&self, stored: &StoredEnergies) -> f64 {
        stored.dissipated + self.dissipated_of_removed
    }

    /// What the numerics have taken since the start: the remainder of the balance (J).
    pub fn numerical(&self, stored: &StoredEnergies) -> f64 {
        let came = self.start + self.gravity + self.boundary + self.damping - self.removed;
        came - stored.total() - self.dissipated_of_removed
    }

    /// What the way from the points to the nodes and back has taken of the kinetic energy since the start (J): all that did not
    /// happen to the nodes within a step. It is part of what the numerics have taken.
    pub fn transfer_loss(&self, stored: &StoredEnergies) -> f64 {
        self.kinetic_at_start + self.nodes - stored.kinetic_total()
    }

    /// What friction has taken at obstacles since the start (J).
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// The entries, for a row of the measures.
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
