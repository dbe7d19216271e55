//! Contact of two velocity fields at a node (sheet: mpm §3.6).

use colluvium_grid::{NodalState, NodeWalls, Vector4};

use crate::background_grid::BackgroundGrid;
use crate::clock::Clock;
use crate::contact::contact_gap::SurfaceDistance;
use crate::contact::contact_law::{ContactImpulse, ContactLaw, FieldContacts, FieldPair, Interface};
use crate::points::vectors::{dot, first_three, norm};

/// Change of velocity over velocity below which an iteration has converged.
const CONVERGENCE_TOLERANCE: f64 = 1e-12;

/// Contact data of a pair of fields, for all nodes.
pub struct ContactNode<'a> {
    /// Contact law; `None` for fields that stick.
    pub law: Option<ContactLaw>,
    /// Whether each field is that of a rigid body.
    rigid: [bool; 2],
    /// Surface integrals of the two fields, node by node.
    surfaces: [&'a [Vector4]; 2],
    distance: &'a SurfaceDistance,
    walls: &'a NodeWalls,
    keep_initial_velocity: bool,
    mass_cutoff: f64,
    inertia: f64,
    /// Volume over the cell size (m²) above which a rigid body constrains a node, node by node.
    rigid_volume_threshold: &'a [f64],
    /// Radii of the nodes (m) in axisymmetry; empty elsewhere.
    radii: &'a [f64],
    cell: f64,
    dt: f64,
}

impl ContactNode<'_> {
    /// Inertias of the two bodies at the node (kg), infinite for a rigid body.
    pub fn inertias(&self, masses: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|side| if self.rigid[side] { f64::INFINITY } else { self.inertia * masses[side] })
    }

    /// Whether both bodies have enough mass or volume at the node.
    pub fn are_both_present(&self, place: usize, masses: [f64; 2]) -> bool {
        let filled =
            |side: usize| self.surfaces[side][place].as_array()[3] >= self.rigid_volume_threshold[place];
        masses.iter().all(|mass| *mass > self.mass_cutoff)
            && (0..2).all(|side| !self.rigid[side] || filled(side))
    }

    /// Returns the interface at a node for a law.
    pub fn interface(&self, place: usize, law: &ContactLaw) -> Option<Interface> {
        let surface = law.interface(self.surfaces.map(|surfaces| surfaces[place]), self.distance)?;
        // Areas per radian become areas of the full section by the radius.
        let around = self.radii.get(place).copied().unwrap_or(1.0);
        Some(Interface { area: around * surface.area, ..surface })
    }

    /// Corrects the velocities of two solved nodes for contact. Returns whether they changed, and the impulse on the first one (N s).
    pub fn correct_velocities(
        &self,
        place: usize,
        index: &[usize; 3],
        pair: [&mut NodalState; 2],
        accumulated: &mut ContactImpulse,
    ) -> Option<(bool, [f64; 3])> {
        let masses = [pair[0].momentum_and_mass.as_array()[3], pair[1].momentum_and_mass.as_array()[3]];
        if !self.are_both_present(place, masses) {
            return None;
        }
        let ends = [first_three(pair[0].momentum_and_mass), first_three(pair[1].momentum_and_mass)];
        let inertias = self.inertias(masses);
        let corrected = self.velocities(place, inertias, [&ends[0], &ends[1]], accumulated)?;
        let side = usize::from(self.rigid[0]);
        let moved: [f64; 3] = std::array::from_fn(|c| corrected[side][c] - ends[side][c]);
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let impulse = moved.map(|v| sign * inertias[side] * v);
        let changed = norm(&moved) > CONVERGENCE_TOLERANCE * norm(&ends[side]).max(norm(&corrected[side]));
        for (side, node) in pair.into_iter().enumerate().filter(|(side, _)| !self.rigid[*side]) {
            let rate = first_three(node.force);
            let mut start: [f64; 3] = std::array::from_fn(|c| ends[side][c] - self.dt * rate[c]);
            let mut end = corrected[side];
            self.walls.constrain(index, &mut start, &mut end, self.keep_initial_velocity);
            node.momentum_and_mass = Vector4::new([end[0], end[1], end[2], masses[side]]);
            let rate = |c: usize| (end[c] - start[c]) / self.dt;
            node.force = Vector4::new([rate(0), rate(1), rate(2), 0.0]);
        }
        Some((changed, impulse))
    }

    /// Velocities after contact; `None` without contact.
    fn velocities(
        &self,
        place: usize,
        inertias: [f64; 2],
        ends: [&[f64; 3]; 2],
        accumulated: &mut ContactImpulse,
    ) -> Option<[[f64; 3]; 2]> {
        let surface = match &self.law {
            Some(law) => Some(self.interface(place, law)?),
            None => None,
        };
        self.velocities_at_interface(surface, inertias, ends, accumulated)
    }

    /// Decrease of the impulse on a rigid body per increase of its velocity at a node (kg).
    pub fn stiffness(
        &self,
        surface: Option<Interface>,
        inertia: f64,
        ends: [&[f64; 3]; 2],
        accumulated: &ContactImpulse,
    ) -> [[f64; 3]; 3] {
        match self.law.as_ref().zip(surface) {
            Some((law, surface)) => law.stiffness(inertia, ends, surface, [self.cell, self.dt], accumulated),
            None => std::array::from_fn(|i| std::array::from_fn(|j| if i == j { inertia } else { 0.0 })),
        }
    }

    /// Velocities after contact at an interface (m/s); `None` without contact.
    pub fn velocities_at_interface(
        &self,
        surface: Option<Interface>,
        inertias: [f64; 2],
        ends: [&[f64; 3]; 2],
        accumulated: &mut ContactImpulse,
    ) -> Option<[[f64; 3]; 2]> {
        let common = common_velocity(inertias, ends);
        let Some(law) = &self.law else { return Some([common; 2]) };
        let impulse = law.impulse(inertias, ends, surface?, [self.cell, self.dt], accumulated)?;
        let moved = |side: usize, sign: f64| -> [f64; 3] {
            std::array::from_fn(|c| ends[side][c] + sign * impulse[c] / inertias[side])
        };
        let corrected = [moved(0, 1.0), moved(1, -1.0)];
        // Sticking nodes have the same velocity to the last bit: re-mapping needs that.
        let relative: [f64; 3] = std::array::from_fn(|c| corrected[0][c] - corrected[1][c]);
        let before: [f64; 3] = std::array::from_fn(|c| ends[0][c] - ends[1][c]);
        Some(if norm(&relative) <= 1e-12 * norm(&before) { [common; 2] } else { corrected })
    }

    /// Corrects re-mapped velocities in contact: bodies neither approach nor separate, and those that stick have no slip.
    pub fn correct_remapped(&self, place: usize, solved: [&NodalState; 2], pair: [&mut Vector4; 2]) {
        let masses = [solved[0].momentum_and_mass.as_array()[3], solved[1].momentum_and_mass.as_array()[3]];
        if !self.are_both_present(place, masses) {
            return;
        }
        let velocities = [first_three(*pair[0]), first_three(*pair[1])];
        let common = common_velocity(self.inertias(masses), [&velocities[0], &velocities[1]]);
        let ends = [first_three(solved[0].momentum_and_mass), first_three(solved[1].momentum_and_mass)];
        let end_difference: [f64; 3] = std::array::from_fn(|c| ends[0][c] - ends[1][c]);
        let slight = 1e-9 * norm(&ends[0]);
        let stuck = norm(&end_difference) <= slight;
        let mut after = [common; 2];
        if let Some(law) = &self.law {
            // A penalty is a force like others, and has been applied already.
            if law.penalty.is_some() {
                return;
            }
            let Some(Interface { normal, .. }) = self.interface(place, law) else { return };
            let relative: [f64; 3] = std::array::from_fn(|c| velocities[0][c] - velocities[1][c]);
            let is_in_contact = dot(&end_difference, &normal).abs() <= slight;
            if !(is_in_contact || dot(&relative, &normal) > 0.0) {
                return;
            }
            if !stuck {
                for side in 0..2 {
                    let excess: [f64; 3] = std::array::from_fn(|c| velocities[side][c] - common[c]);
                    let into = dot(&excess, &normal);
                    after[side] = std::array::from_fn(|c| velocities[side][c] - into * normal[c]);
                }
            }
        }
        for (velocity, after) in pair.into_iter().zip(after) {
            *velocity = Vector4::new([after[0], after[1], after[2], 0.0]);
        }
    }
}

/// Velocity of the common centre of mass of two masses (m/s), one of which may be infinite.
fn common_velocity(masses: [f64; 2], velocities: [&[f64; 3]; 2]) -> [f64; 3] {
    let inverse = masses.map(f64::recip);
    let sum = inverse[0] + inverse[1];
    std::array::from_fn(|c| (inverse[1] * velocities[0][c] + inverse[0] * velocities[1][c]) / sum)
}

/// Returns the contact data of a pair in a step of `dt` (s).
pub fn contact_node<'a, const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    mass_cutoff: f64,
    walls: &'a NodeWalls,
    contacts: &'a FieldContacts,
    pair: &FieldPair,
    dt: f64,
) -> ContactNode<'a> {
    let len = background.layout.len();
    ContactNode {
        law: pair.law,
        surfaces: pair.fields.map(|field| &contacts.surfaces[field * len..(field + 1) * len]),
        rigid: pair.fields.map(|field| contacts.rigid[field].is_some()),
        distance: &contacts.distance,
        walls,
        keep_initial_velocity: clock.keeps_initial_velocity(),
        mass_cutoff,
        inertia: clock.options.mass_scaling,
        rigid_volume_threshold: &contacts.rigid_volume_threshold,
        radii: &contacts.radii,
        cell: background.grid.cell,
        dt,
    }
}
