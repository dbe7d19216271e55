//! Contact laws of two grains, or of a grain and a wall: one file per interaction, combined per pair of kinds.
//!
//! The normal points from `j` to `i`; an overlap is positive; forces and moments are those on `i`, repulsive ones positive
//! along the normal (sheet: dem §1.2).

pub mod bond;
pub mod capillary;
pub mod cohesion;
pub(crate) mod contact_energies;
pub(crate) mod contact_histories;
pub(crate) mod contact_laws;
pub(crate) mod contact_state;
pub mod coulomb_friction;
pub mod dashpot;
pub mod hertz;
pub mod jkr;
pub mod linear_spring;
pub mod restitution;
pub mod rolling_resistance;

use colluvium_constitutive::SymTensor;

pub use crate::contact::contact_energies::{ContactEnergies, Virial};
pub use crate::contact::contact_state::{ContactHistory, ContactState};

use crate::contact::coulomb_friction::Coulomb;
use crate::contact::linear_spring::LinearSpring;
use crate::contact::rolling_resistance::RollingResistance;
use crate::points::vector::{
    SimdNumber, difference, dot, normal_spin, scaled, spin_cross_normal, tangential_part,
};
use bond::{Beam, Bond};
use capillary::Capillary;
use cohesion::Cohesion;
use dashpot::StepLengths;
use hertz::Hertz;
use jkr::Jkr;

/// Contact with its force at the current time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<const D: usize> {
    /// Index of the first grain in the present order of the grains.
    pub grain: usize,
    /// Index of the second grain; `None` for a wall.
    pub second: Option<usize>,
    /// Ids of the two grains, constant during a run; `None` for a wall.
    pub ids: (u32, Option<u32>),
    /// Index of a wall in the boundaries of the case, and after them the obstacles; `None` for two grains.
    pub wall: Option<usize>,
    /// Unit normal from the second grain, or the wall, to the first.
    pub unit_normal: [f64; D],
    /// Branch vector from the centre of the second grain, or the contact point on the wall, to the centre of the first (m).
    pub branch: [f64; D],
    /// Force on the first grain (N).
    pub force: [f64; D],
    /// Normal component of the force (N; N/m in the plane), repulsion positive.
    pub normal: f64,
    /// Overlap (m); negative across a gap.
    pub overlap: f64,
    /// Whether an unbroken bond or cohesion acts.
    pub is_bonded: bool,
}

impl<const D: usize> Contact<D> {
    /// Tangential part of the force on the first grain (N; N/m in the plane).
    pub fn tangential(&self) -> [f64; D] {
        std::array::from_fn(|c| self.force[c] - self.normal * self.unit_normal[c])
    }
}

/// Contact data for the fabric.
pub struct FabricSample<const D: usize> {
    /// Grains of each contact, contacts between grains first. A wall or a grain with prescribed motion is `None`.
    pub pairs: Vec<(u32, Option<u32>)>,
    /// Normal force of each contact between grains (N).
    pub forces: Vec<f64>,
    /// Sum of `n ⊗ n` over the contacts between grains.
    pub dyads: SymTensor,
    /// Stress of the contacts times the volume, compression-positive (N m).
    pub stress_volume: [[f64; D]; D],
}

/// Normal contact law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalForceLaw {
    /// Linear spring and dashpot.
    Linear(LinearSpring),
    /// Hertz contact of elastic spheres.
    Hertz(Hertz),
}

impl NormalForceLaw {
    /// Overlap of grains at rest under a force (N), for an effective radius (m).
    pub fn overlap(&self, force: f64, radius: f64) -> f64 {
        match self {
            Self::Linear(law) => force / law.stiffness(radius),
            Self::Hertz(law) => (0.75 * force / (law.modulus * radius.sqrt())).powf(2.0 / 3.0),
        }
    }

    /// Factor on the stiffness or modulus that reduces overlaps by the factor `times`.
    pub fn stiffness_factor(&self, times: f64) -> f64 {
        match self {
            Self::Linear(_) => times,
            Self::Hertz(_) => times.powf(1.5),
        }
    }
}

/// Attraction law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AttractionLaw {
    /// Cohesion: tensile and shear strength until the contact breaks.
    Cohesion(Cohesion),
    /// Adhesion of Johnson, Kendall and Roberts.
    Jkr(Jkr),
    /// Capillary bridge.
    Capillary(Capillary),
}

/// Contact law of a pair of kinds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairLaw {
    /// Normal law.
    pub normal: NormalForceLaw,
    /// Whether the sum of elastic and damping force is limited to compression.
    pub no_tension: bool,
    /// Lag of the velocities in the dashpots, over half a step: 1 for lagged, 0 for predicted velocities.
    pub velocity_lag: f64,
    /// Tangential law with friction.
    pub friction: Coulomb,
    /// Rolling resistance.
    pub rolling: Option<RollingResistance>,
    /// Torsion resistance.
    pub torsion: Option<RollingResistance>,
    /// Attraction.
    pub attraction: Option<AttractionLaw>,
    /// Parallel bond.
    pub bond: Option<Beam>,
}

/// Contact geometry and kinematics of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactGeometry<const D: usize, const R: usize, T = f64> {
    /// Overlap (m); negative for a gap across which attraction acts.
    pub overlap: T,
    /// Unit normal from `j` to `i`.
    pub normal: [T; D],
    /// Normal velocity of `i` relative to `j`, positive in separation (m/s).
    pub separation_velocity: T,
    /// Sliding velocity in tangent coordinates (m/s): velocity of the surface of `i` relative to that of `j`.
    pub sliding_velocity: [T; R],
    /// Angular velocity of `i` minus that of `j` (rad/s).
    pub relative_spin: [T; R],
    /// Mean angular velocity about the normal (rad/s).
    pub spin: T,
    /// Effective mass (kg).
    pub mass: T,
    /// Inverse of the effective mass (1/kg).
    pub inverse_mass: T,
    /// Effective radius (m).
    pub radius: T,
    /// The smaller radius (m).
    pub min_radius: T,
}

/// Motion and size of a grain in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactBody<const D: usize, const R: usize, T = f64> {
    /// Velocity (m/s).
    pub velocity: [T; D],
    /// Angular velocity (rad/s).
    pub spin: [T; R],
    /// Radius (m).
    pub radius: T,
    /// Inverse of the mass (1/kg); zero for a grain with prescribed motion.
    pub inverse_mass: T,
}

impl<const D: usize, const R: usize, T: SimdNumber> ContactGeometry<D, R, T> {
    /// Contact geometry of two grains at a `distance` along `apart` (m), with the velocity `drift` of the periodic image (m/s). The lever
    /// arms are over the radii; they are 1 if `radii` are the arms. One division gives the normal, the arms and the mass.
    #[inline(always)]
    pub fn of_grains(
        [one, two]: [&ContactBody<D, R, T>; 2],
        (apart, distance): (&[T; D], T),
        drift: Option<&[T; D]>,
        radii: bool,
    ) -> (Self, T) {
        let (a, b) = (one.radius, two.radius);
        let (sum, inverse) = (a + b, one.inverse_mass + two.inverse_mass);
        let part = T::broadcast(1.0) / (distance * sum * inverse);
        let normal = scaled(part * (sum * inverse), apart);
        let per_sum = part * (distance * inverse);
        let arm = if radii { T::broadcast(1.0) } else { per_sum * distance };
        let mut relative = difference(&one.velocity, &two.velocity);
        if let Some(drift) = drift {
            relative = difference(&relative, drift);
        }
        let (of_one, of_two) = (arm * a, arm * b);
        let both: [T; R] = std::array::from_fn(|c| of_one * one.spin[c] + of_two * two.spin[c]);
        let sum_of_spins: [T; R] = std::array::from_fn(|c| one.spin[c] + two.spin[c]);
        let geometry = Self {
            overlap: sum - distance,
            normal,
            separation_velocity: dot(&relative, &normal),
            sliding_velocity: difference(
                &tangential_part(&relative, &normal),
                &spin_cross_normal(&both, &normal),
            ),
            relative_spin: difference(&one.spin, &two.spin),
            spin: T::broadcast(0.5) * normal_spin(&sum_of_spins, &normal),
            mass: part * (distance * sum),
            inverse_mass: inverse,
            radius: a * b * per_sum,
            min_radius: a.select_above(b, b, a),
        };
        (geometry, arm)
    }
}

impl<const D: usize, const R: usize, T: SimdNumber> ContactGeometry<D, R, T> {
    /// Contact geometry of a grain and a wall without rotation at a `distance` along the normal (m), and the lever arm (m).
    #[inline(always)]
    pub fn with_wall(
        (one, mass): (&ContactBody<D, R, T>, T),
        (distance, normal): (T, &[T; D]),
        of_wall: &[T; D],
        radii: bool,
    ) -> (Self, T) {
        let radius = one.radius;
        let arm = if radii { radius } else { distance };
        let relative = difference(&one.velocity, of_wall);
        let rolling = spin_cross_normal(&one.spin.map(|c| arm * c), normal);
        let geometry = Self {
            overlap: radius - distance,
            normal: *normal,
            separation_velocity: dot(&relative, normal),
            sliding_velocity: difference(&tangential_part(&relative, normal), &rolling),
            relative_spin: one.spin,
            spin: T::broadcast(0.5) * normal_spin(&one.spin, normal),
            mass,
            inverse_mass: T::broadcast(1.0) / mass,
            radius,
            min_radius: radius,
        };
        (geometry, arm)
    }
}

/// Contact force and moment on `i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce<const R: usize> {
    /// Normal force (N).
    pub normal: f64,
    /// Tangential force in tangent coordinates (N).
    pub tangential: [f64; R],
    /// Moment of rolling, torsion and bonds on `i`, opposite on `j` (N m).
    pub moment: [f64; R],
}

/// Normal response at an overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalResponse<T = f64> {
    /// Normal force (N).
    pub force: T,
    /// Elastic energy (J).
    pub energy: T,
    /// Normal dashpot (N s/m).
    pub damping: T,
    /// Tangential stiffness (N/m).
    pub tangential_stiffness: T,
    /// Tangential dashpot (N s/m).
    pub tangential_damping: T,
}

impl PairLaw {
    /// Normal response of the contact.
    #[inline]
    pub fn normal_response<const D: usize, const R: usize>(
        &self,
        geometry: &ContactGeometry<D, R>,
    ) -> NormalResponse {
        match &self.normal {
            NormalForceLaw::Linear(law) => law.response(geometry),
            NormalForceLaw::Hertz(law) => law.response(geometry),
        }
    }

    /// Whether the normal law is Hertz's.
    #[inline]
    pub fn is_hertz(&self) -> bool {
        matches!(self.normal, NormalForceLaw::Hertz(_))
    }

    /// Gap at which a contact of a state ends (m), for an effective radius (m).
    #[inline]
    pub fn rupture_distance(&self, state: ContactState, radius: f64) -> f64 {
        match &self.attraction {
            None => 0.0,
            Some(_) if state == ContactState::Apart => 0.0,
            Some(AttractionLaw::Cohesion(law)) if state == ContactState::Bonded => law.rupture_distance,
            Some(AttractionLaw::Cohesion(_)) => 0.0,
            Some(AttractionLaw::Jkr(law)) => law.rupture_distance(radius),
            Some(AttractionLaw::Capillary(law)) => law.rupture_distance(radius),
        }
    }

    /// Whether a contact can act across a gap.
    pub fn has_rupture_distance(&self) -> bool {
        self.attraction.is_some() || self.bond.is_some()
    }
}

/// Contact force and moment between two steps; updates the contact history.
#[inline]
pub fn contact_force<const D: usize, const R: usize>(
    law: &PairLaw,
    geometry: &ContactGeometry<D, R>,
    history: &mut ContactHistory<R>,
    steps: &StepLengths,
    energies: &mut ContactEnergies,
) -> ContactForce<R> {
    let dt = steps.last;
    let mut base = law.normal_response(geometry);
    if geometry.overlap < 0.0 && !matches!(law.attraction, Some(AttractionLaw::Cohesion(_))) {
        // Across a gap only attraction acts.
        base = NormalResponse {
            force: 0.0,
            energy: 0.0,
            damping: 0.0,
            tangential_stiffness: 0.0,
            tangential_damping: 0.0,
        };
    }
    base.damping =
        dashpot::dashpot_in_step(law, &base, geometry, history.state == ContactState::Apart, steps);
    let viscous = base.force - base.damping * geometry.separation_velocity;
    let is_tensile = law.no_tension && geometry.overlap >= 0.0 && viscous < 0.0;
    let mut normal = if is_tensile { 0.0 } else { viscous };
    if history.state == ContactState::Apart {
        history.state = law.initial_state();
    }
    let dissipative = normal - base.force;
    energies.dashpots -= 0.5 * (history.damping_force + dissipative) * geometry.separation_velocity * dt;
    history.damping_force = dissipative;
    let mut energy = base.energy;
    let (cap, shear) =
        add_attraction(law, geometry, &base, history, (&mut normal, &mut energy), dt, energies);
    energies.elastic += energy;
    let before = (geometry.overlap + geometry.separation_velocity * dt, law.is_hertz());
    let tangential =
        law.friction.tangential_force(geometry, &base, before, (cap, shear), history, dt, energies);
    if law.attraction.is_some() {
        cohesion::break_by_shear(law, &tangential, (cap, shear), history);
    }
    let mut moment = [0.0; R];
    if law.rolling.is_some() || law.torsion.is_some() {
        rolling_resistance::add_rolling_moments(
            law,
            geometry,
            &base,
            cap,
            history,
            &mut moment,
            dt,
            energies,
        );
    }
    ContactForce { normal, tangential, moment }
}

/// Adds attraction to normal force and elastic energy of a contact. Returns the normal force for the friction limit (N) and the tangential
/// strength of cohesion (N).
#[inline]
fn add_attraction<const D: usize, const R: usize>(
    law: &PairLaw,
    geometry: &ContactGeometry<D, R>,
    base: &NormalResponse,
    history: &mut ContactHistory<R>,
    (normal, energy): (&mut f64, &mut f64),
    dt: f64,
    energies: &mut ContactEnergies,
) -> (f64, f64) {
    let cap = normal.max(0.0);
    match &law.attraction {
        None => (cap, 0.0),
        Some(AttractionLaw::Cohesion(cohesion)) => {
            let shear = cohesion.bound_tension::<D, R>(geometry, history, normal, energy, energies);
            (normal.max(0.0), shear)
        }
        Some(AttractionLaw::Jkr(jkr)) => {
            let NormalForceLaw::Hertz(hertz) = &law.normal else { unreachable!("checked by the setup") };
            let (force, pull_off) = jkr.force(hertz, geometry.radius, geometry.overlap);
            // The JKR force includes that of Hertz: the difference is attraction.
            let attraction = base.force - force;
            *normal -= attraction;
            energies.attraction += attraction * geometry.separation_velocity * dt;
            ((*normal + 2.0 * pull_off).max(0.0), 0.0)
        }
        Some(AttractionLaw::Capillary(bridge)) => {
            let attraction = bridge.force(geometry.radius, -geometry.overlap);
            *normal -= attraction;
            energies.attraction += attraction * geometry.separation_velocity * dt;
            (cap, 0.0)
        }
    }
}

/// Ends a contact; the remaining energy of its springs is dissipated.
#[inline]
pub fn release_contact<const D: usize, const R: usize>(
    law: &PairLaw,
    geometry: &ContactGeometry<D, R>,
    history: &mut ContactHistory<R>,
    dt: f64,
    energies: &mut ContactEnergies,
) {
    energies.dashpots -= 0.5 * history.damping_force * geometry.separation_velocity * dt;
    let held = dot(&history.shear_displacement, &history.shear_displacement);
    if held > 0.0 {
        // With the stiffness of the last step. The last force acts half a step longer, and this work is lost as well.
        let last = ContactGeometry {
            overlap: (geometry.overlap + geometry.separation_velocity * dt).max(0.0),
            ..*geometry
        };
        let across = law.normal_response(&last).tangential_stiffness;
        energies.spring_loss +=
            0.5 * across * (held + dot(&history.shear_displacement, &geometry.sliding_velocity) * dt);
    }
    *history = ContactHistory::default();
}

impl PairLaw {
    /// Initial state of a contact.
    fn initial_state(&self) -> ContactState {
        match &self.attraction {
            Some(AttractionLaw::Cohesion(law)) if law.new_contacts => ContactState::Bonded,
            _ => ContactState::Touching,
        }
    }

    /// Adds the bond of a contact to its force and moment.
    #[inline]
    pub fn add_bond_force<const D: usize, const R: usize>(
        &self,
        geometry: &ContactGeometry<D, R>,
        bond: &mut Bond<R>,
        contact: &mut ContactForce<R>,
        dt: f64,
        energies: &mut ContactEnergies,
    ) {
        if let Some(beam) = &self.bond {
            beam.bond_force(geometry, bond, contact, dt, energies);
        }
    }
}

/// Splits a rotation into rolling, across the normal, and torsion, about the normal.
#[inline]
pub fn rolling_and_twisting<const D: usize, const R: usize, T: SimdNumber>(
    turning: &[T; R],
    n: &[T; D],
) -> ([T; R], T) {
    if D == 2 {
        return (*turning, T::broadcast(0.0));
    }
    let twist = normal_spin(turning, n);
    let mut roll = *turning;
    for c in 0..D {
        roll[c] -= twist * n[c];
    }
    (roll, twist)
}
