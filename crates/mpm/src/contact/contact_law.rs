//! Contact between bodies: a velocity field for each, and Coulomb friction with adhesion at their interface
//! (Bardenhagen et al. 2001; sheet: mpm §2.12, §3.6).
//!
//! The normal of a node is the difference of the directions of the gradients of the two bodies' volumes, so that it is
//! opposite for the two, and momentum is conserved. Within a body the gradient is noise, and counts by its size. The
//! sum `Σ_p Ω_p ∇N_i` is the integral of `N_i n` over the surface of a body: its component along the normal is the
//! node's share of the contact's area, which sums to the whole area wherever the interface lies between the nodes.
//!
//! That velocities approach is not enough for what rolls: a node knows bodies a cell away. With the test of gaps bodies
//! act on each other only where their surfaces touch ([`crate::contact::contact_gap`]).

use colluvium_case::{Case, CaseError, CaseErrorKind};
use colluvium_grid::Vector4;

use crate::contact::contact_gap::{CONTACT_TOLERANCE, SurfaceDistance};
use crate::points::point_set::PointSet;
use crate::points::vectors::{dot, first_three, norm};
use crate::{ContactTest, MpmOptions, PenaltyContact};

/// Norm of a volume gradient over its largest value, below which it is regarded as noise of irregular points.
const GRADIENT_NOISE: f64 = 0.1;

/// Pair of velocity fields with its contact law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPair {
    /// The fields, the lower number first.
    pub fields: [usize; 2],
    /// Contact law; `None` for fields that stick.
    pub law: Option<ContactLaw>,
}

/// Coulomb friction with adhesion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Coefficient of friction.
    pub friction: f64,
    /// Adhesion (Pa).
    pub adhesion: f64,
    /// Unit vector from the first field to the second, if the case prescribes it.
    pub normal: Option<[f64; 3]>,
    /// Criterion by which bodies are in contact.
    pub test: ContactTest,
    /// Penalty law for the overlap, in place of the condition on approaching velocities.
    pub penalty: Option<PenaltyContact>,
}

/// Interface of two bodies at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Unit vector from the first body to the second.
    pub normal: [f64; 3],
    /// Contact area of the node (m²).
    pub area: f64,
    /// Overlap of the bodies at the node, in cell sizes, from the gap criterion; negative where there is a gap.
    pub overlap: f64,
}

/// Impulses (N s) between two bodies at a node in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactImpulse {
    /// Impulse along the normal (N s).
    pub normal: f64,
    /// Impulse along the surface (N s), sum of the magnitudes.
    pub tangential: f64,
}

/// Results of contact for a row of nodes and a pair of fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RowContact {
    /// Whether contact changed velocities.
    pub has_changed: bool,
    /// Impulse (N s) on the first field.
    pub impulse: [f64; 3],
    /// Impulses between the two fields at each node in the step; empty unless a law needs them.
    pub impulses: Vec<ContactImpulse>,
}

impl RowContact {
    /// Size in memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&self.impulses[..])
    }
}

/// All contacts of a case.
#[derive(Clone, Debug, Default)]
pub struct FieldContacts {
    /// Every pair of fields, in order; empty for a single field.
    pub pairs: Vec<FieldPair>,
    /// Surface integrals `Σ_p Ω_p ∇N_i` of all fields (m²), with the volumes `Σ_p Ω_p N_i` over the cell size as fourth component; on a
    /// mesh over the element height. Empty for a single field.
    pub surfaces: Vec<Vector4>,
    /// Distances of surfaces from nodes.
    pub distance: SurfaceDistance,
    /// Index of the rigid body of each field among the driven objects; empty for a single field.
    pub rigid: Vec<Option<usize>>,
    /// Volume over the cell size (m²) above which a rigid body constrains a node, node by node; empty for a single field.
    pub rigid_volume_threshold: Vec<f64>,
    /// Radii of the nodes (m) in axisymmetry, where areas are per radian; empty elsewhere.
    pub radii: Vec<f64>,
}

impl FieldContacts {
    /// Memory of the nodes (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.surfaces[..])
            + size_of_val(&self.rigid_volume_threshold[..])
            + size_of_val(&self.radii[..])
    }

    /// Whether a velocity field belongs to a rigid body.
    pub fn is_rigid(&self, field: usize) -> bool {
        self.rigid.get(field).is_some_and(Option::is_some)
    }

    /// Number of velocity fields; `n` fields have `n (n - 1) / 2` pairs.
    pub fn fields(&self) -> usize {
        self.pairs.last().map_or(1, |pair| pair.fields[1] + 1)
    }
}

/// Assigns a field to each body of a contact and to each rigid body, and lists the pairs.
pub fn field_contacts<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    sets: &mut [PointSet<D>],
) -> Result<FieldContacts, CaseError> {
    let laws = contact_laws::<D>(case, options)?;
    let mut bodies: Vec<usize> = laws.iter().flat_map(|(pair, _)| *pair).collect();
    for set in sets.iter() {
        let body = set.body as usize;
        if set.rigid.is_some() {
            bodies.push(body);
        }
    }
    if bodies.is_empty() {
        return Ok(FieldContacts::default());
    }
    bodies.sort_unstable();
    bodies.dedup();
    let shared = usize::from(bodies.len() < case.bodies.len());
    for set in sets.iter_mut() {
        set.field = bodies.binary_search(&(set.body as usize)).map_or(0, |place| place + shared);
    }
    let field = |body: usize| bodies.binary_search(&body).unwrap_or(0) + shared;
    let mut pairs = Vec::new();
    for second in 1..bodies.len() + shared {
        for first in 0..second {
            let law = laws.iter().find_map(|([a, b], law)| match [field(*a), field(*b)] {
                pair if pair == [first, second] => Some(*law),
                pair if pair == [second, first] => {
                    Some(ContactLaw { normal: law.normal.map(|n| n.map(|c| -c)), ..*law })
                }
                _ => None,
            });
            pairs.push(FieldPair { fields: [first, second], law });
        }
    }
    let mut rigid = vec![None; bodies.len() + shared];
    sets.iter().filter(|set| set.rigid.is_some()).for_each(|set| rigid[set.field] = set.rigid);
    Ok(FieldContacts { pairs, rigid, ..FieldContacts::default() })
}

/// Returns the contacts of the case: two bodies and their law.
fn contact_laws<const D: usize>(
    case: &Case,
    options: &MpmOptions,
) -> Result<Vec<([usize; 2], ContactLaw)>, CaseError> {
    let on_mesh = options.mesh.is_some();
    let mut laws: Vec<([usize; 2], ContactLaw)> = Vec::new();
    for (number, contact) in options.contacts.iter().enumerate() {
        let path = |key: &str| format!("methods.mpm.contacts[{number}].{key}");
        let mut pair = [0; 2];
        for (side, name) in contact.bodies.iter().enumerate() {
            let Some(body) = case.bodies.iter().position(|body| body.name == *name) else {
                return Err(CaseError::new(path("bodies"), CaseErrorKind::other_name(name, "a body")));
            };
            pair[side] = body;
        }
        if pair[0] == pair[1] {
            return Err(CaseError::new(path("bodies"), "a contact is between two bodies"));
        }
        if laws.iter().any(|(other, _)| *other == pair || *other == [pair[1], pair[0]]) {
            return Err(CaseError::new(
                path("bodies"),
                CaseErrorKind::coded("duplicate-name", "an earlier contact is between the same two bodies"),
            ));
        }
        contact.validate(on_mesh).map_err(|(key, problem)| CaseError::new(path(key), problem))?;
        let normal = contact.normal.as_deref().map(|n| {
            unit::<D>(n).ok_or(CaseErrorKind::coded(
                "wrong-dimension",
                "must be a vector other than zero with the dimension of the space",
            ))
        });
        let normal = normal.transpose().map_err(|problem| CaseError::new(path("normal"), problem))?;
        let (friction, adhesion) = (contact.friction_coefficient, contact.adhesion);
        let test = contact.test(on_mesh);
        laws.push((pair, ContactLaw { friction, adhesion, normal, test, penalty: contact.penalty }));
    }
    Ok(laws)
}

/// Unit vector of a list of `D` numbers; `None` for a zero vector or another number of entries.
fn unit<const D: usize>(vector: &[f64]) -> Option<[f64; 3]> {
    let length = norm(&std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0)));
    let holds = vector.len() == D && length.is_finite() && length > 0.0;
    holds.then(|| std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0) / length))
}

impl ContactLaw {
    /// Interface at a node, from the surface integrals of two bodies with the volumes as fourth component. `None` without a defined normal
    /// or without contact.
    pub fn interface(&self, surfaces: [Vector4; 2], distance: &SurfaceDistance) -> Option<Interface> {
        let normal = match self.normal {
            Some(normal) => normal,
            None => {
                let [one, other] = surfaces.map(direction);
                let across = std::array::from_fn(|c| one[c] - other[c]);
                let length = norm(&across);
                // Written so that NaN gives no interface.
                if !(length > 0.0) {
                    return None;
                }
                across.map(|c| c / length)
            }
        };
        // Both areas are outward.
        let areas = [dot(&first_three(surfaces[0]), &normal), -dot(&first_three(surfaces[1]), &normal)];
        let volumes = surfaces.map(|surface| surface.as_array()[3]);
        let overlap = if self.test == ContactTest::Gap { distance.overlap(volumes, areas) } else { 0.0 };
        let area = 0.5 * (areas[0] + areas[1]).abs();
        (overlap >= -CONTACT_TOLERANCE).then_some(Interface { normal, area, overlap })
    }

    /// Decrease of the impulse on a body per increase of its velocity (kg), if one body has infinite and the other finite mass. Arguments
    /// as for [`ContactLaw::impulse`]. Row `i`, column `j`: component `i` by velocity `j`.
    pub fn stiffness(
        &self,
        mass: f64,
        velocities: [&[f64; 3]; 2],
        Interface { normal, area, overlap }: Interface,
        [cell, dt]: [f64; 2],
        accumulated: &ContactImpulse,
    ) -> [[f64; 3]; 3] {
        let relative: [f64; 3] = std::array::from_fn(|c| mass * (velocities[0][c] - velocities[1][c]));
        let approach = dot(&relative, &normal);
        let (normal_impulse, normal_factor) = match &self.penalty {
            None => (approach, 1.0),
            Some(penalty) => {
                let overlap = cell * overlap;
                let (spring, parting) = (
                    penalty.stiffness * overlap * area * dt - accumulated.normal,
                    approach + mass * overlap / dt,
                );
                if spring < parting { (spring, 0.0) } else { (parting, 1.0) }
            }
        };
        if !(normal_impulse > 0.0) {
            return [[0.0; 3]; 3];
        }
        let tangential: [f64; 3] = std::array::from_fn(|c| relative[c] - approach * normal[c]);
        let shear = norm(&tangential);
        let max_shear =
            self.penalty.and_then(|penalty| penalty.shear_strength).unwrap_or(f64::INFINITY) * area * dt;
        let strength = self.friction * (accumulated.normal + normal_impulse) + self.adhesion * area * dt;
        let remaining = (strength.min(max_shear) - accumulated.tangential).max(0.0);
        let slips = shear > remaining;
        let sticking_share = if slips { remaining / shear } else { 1.0 };
        let slope = if slips && strength < max_shear && remaining > 0.0 {
            self.friction * normal_factor
        } else {
            0.0
        };
        let slip = tangential.map(|c| if slips { c / shear } else { 0.0 });
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let one = if i == j { 1.0 } else { 0.0 };
                let square = normal[i] * normal[j];
                mass * (normal_factor * square
                    + sticking_share * (one - square - slip[i] * slip[j])
                    + slope * slip[i] * normal[j])
            })
        })
    }

    /// Contact impulse on the first body (N s); `None` if the bodies separate. `masses` (kg) may include an infinite one, `cell` is the
    /// cell size (m). The law applies to the sum of this impulse and the `accumulated` ones of the step, which is stored there.
    pub fn impulse(
        &self,
        masses: [f64; 2],
        velocities: [&[f64; 3]; 2],
        Interface { normal, area, overlap }: Interface,
        [cell, dt]: [f64; 2],
        accumulated: &mut ContactImpulse,
    ) -> Option<[f64; 3]> {
        // m_a (v_a - v) with the common velocity v of both.
        let reduced = 1.0 / (1.0 / masses[0] + 1.0 / masses[1]);
        let relative: [f64; 3] = std::array::from_fn(|c| reduced * (velocities[0][c] - velocities[1][c]));
        let approach = dot(&relative, &normal);
        let normal_impulse = match &self.penalty {
            None => approach,
            // At most the impulse that separates the bodies by the end of the step.
            Some(penalty) => {
                let overlap = cell * overlap;
                (penalty.stiffness * overlap * area * dt - accumulated.normal)
                    .min(approach + reduced * overlap / dt)
            }
        };
        // Written so that NaN separates; the run then stops by itself.
        if !(normal_impulse > 0.0) {
            return None;
        }
        let tangential: [f64; 3] = std::array::from_fn(|c| relative[c] - approach * normal[c]);
        let shear = norm(&tangential);
        let max_shear = self.penalty.and_then(|penalty| penalty.shear_strength).unwrap_or(f64::INFINITY);
        accumulated.normal += normal_impulse;
        let strength =
            (self.friction * accumulated.normal + self.adhesion * area * dt).min(max_shear * area * dt);
        let tangential_impulse = shear.min((strength - accumulated.tangential).max(0.0));
        accumulated.tangential += tangential_impulse;
        let sticking_share = if shear > 0.0 { tangential_impulse / shear } else { 1.0 };
        Some(std::array::from_fn(|c| -normal_impulse * normal[c] - sticking_share * tangential[c]))
    }
}

/// Unit normal of a surface integral. It is shorter if the integral is less than `GRADIENT_NOISE` of its largest possible value.
fn direction(surface: Vector4) -> [f64; 3] {
    let vector = first_three(surface);
    let length = norm(&vector).max(GRADIENT_NOISE * surface.as_array()[3]);
    vector.map(|c| if length > 0.0 { c / length } else { 0.0 })
}
