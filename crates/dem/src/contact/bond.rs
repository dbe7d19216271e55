//! Parallel bonds: breakable beams between grains (Potyondy and Cundall 2004; sheet: dem §2.7).

use std::f64::consts::PI;

use colluvium_points::struct_of_arrays::FixedBytes;

use super::{ContactEnergies, ContactForce, ContactGeometry, rolling_and_twisting};
use crate::points::vector::{dot, rotate_with_normal};

/// Parameters of a parallel bond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Normal stiffness per area (Pa/m).
    pub normal: f64,
    /// Shear stiffness per area (Pa/m).
    pub shear: f64,
    /// Bond radius over the radius of the smaller grain.
    pub radius: f64,
    /// Factor on the moments in the stresses that break the bond (-).
    pub moments: f64,
    /// Tensile strength (Pa); infinite for a bond that does not break in tension.
    pub tensile_strength: f64,
    /// Shear strength without pressure (Pa); infinite for a bond that does not break in shear.
    pub cohesion: f64,
    /// Tangent of the friction angle of the shear strength.
    pub friction: f64,
    /// Coefficient of variation of the strengths.
    pub scatter: f64,
    /// Largest gap over mean diameter of grains that are bonded at the start.
    pub gap: f64,
}

/// State of a bond: its strength, forces and moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bond<const R: usize> {
    /// Factor on the strengths of the bond; 0 without a bond, negative for a broken one.
    pub strength: f64,
    /// Tension (N).
    pub tension: f64,
    /// Shear force on `i` in tangent coordinates (N).
    pub shear: [f64; R],
    /// Bending moment on `i` (N m).
    pub bending: [f64; R],
    /// Twisting moment on `i` (N m).
    pub twist: f64,
}

impl<const R: usize> Default for Bond<R> {
    fn default() -> Self {
        Self { strength: 0.0, tension: 0.0, shear: [0.0; R], bending: [0.0; R], twist: 0.0 }
    }
}

impl<const R: usize> Bond<R> {
    /// Whether the bond is intact.
    #[inline]
    pub fn is_intact(&self) -> bool {
        self.strength > 0.0
    }
}

impl<const R: usize> FixedBytes for Bond<R> {
    const BYTE_COUNT: usize = (3 + 2 * R) * size_of::<f64>();

    fn append_bytes(self, out: &mut Vec<u8>) {
        [self.strength, self.tension, self.twist].append_bytes(out);
        self.shear.append_bytes(out);
        self.bending.append_bytes(out);
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        let number = |k: usize| f64::from_bytes(&bytes[8 * k..8 * (k + 1)]);
        Self {
            strength: number(0),
            tension: number(1),
            twist: number(2),
            shear: std::array::from_fn(|c| number(3 + c)),
            bending: std::array::from_fn(|c| number(3 + R + c)),
        }
    }
}

/// Cross-section: area (m²), second moments of area in bending and in torsion (m⁴), radius (m).
struct BeamSection {
    area: f64,
    bending: f64,
    torsion: f64,
    radius: f64,
}

impl Beam {
    /// Cross-section of the beam between grains of which the smaller has radius `small` (m).
    fn section<const D: usize>(&self, small: f64) -> BeamSection {
        let radius = self.radius * small;
        if D == 2 {
            return BeamSection {
                area: 2.0 * radius,
                bending: 2.0 / 3.0 * radius.powi(3),
                torsion: 0.0,
                radius,
            };
        }
        let fourth = radius.powi(4);
        BeamSection {
            area: PI * radius * radius,
            bending: 0.25 * PI * fourth,
            torsion: 0.5 * PI * fourth,
            radius,
        }
    }

    /// Larger of the normal and the shear stiffness (N/m) of a bond of a grain of radius `small` (m).
    pub fn stiffness<const D: usize>(&self, small: f64) -> f64 {
        self.normal.max(self.shear) * self.section::<D>(small).area
    }

    /// Adds force and moment of the bond in a step of `dt` (s). The bond breaks if its strength is exceeded.
    #[inline]
    pub fn bond_force<const D: usize, const R: usize>(
        &self,
        geometry: &ContactGeometry<D, R>,
        bond: &mut Bond<R>,
        contact: &mut ContactForce<R>,
        dt: f64,
        energies: &mut ContactEnergies,
    ) {
        if !bond.is_intact() {
            return;
        }
        let section = self.section::<D>(geometry.min_radius);
        let (normal, tangential) = (self.normal * section.area, self.shear * section.area);
        let (bending, torsion) = (self.normal * section.bending, self.shear * section.torsion);
        let (roll, twist) = rolling_and_twisting(&geometry.relative_spin, &geometry.normal);
        bond.tension += normal * geometry.separation_velocity * dt;
        bond.shear = rotate_with_normal(&bond.shear, &geometry.normal, geometry.spin * dt);
        bond.bending = rotate_with_normal(&bond.bending, &geometry.normal, geometry.spin * dt);
        for c in 0..R {
            bond.shear[c] -= tangential * geometry.sliding_velocity[c] * dt;
            bond.bending[c] -= bending * roll[c] * dt;
        }
        bond.twist -= torsion * twist * dt;
        let (shear, bent) = (dot(&bond.shear, &bond.shear), dot(&bond.bending, &bond.bending));
        let mut energy = 0.5 * (bond.tension * bond.tension / normal + shear / tangential + bent / bending);
        if torsion > 0.0 {
            energy += 0.5 * bond.twist * bond.twist / torsion;
        }
        if self.breaks(&section, bond, shear.sqrt(), bent.sqrt()) {
            *bond = Bond { strength: -bond.strength, ..Bond::default() };
            energies.broken += energy;
            energies.bonds_broken += 1;
            return;
        }
        energies.elastic_bonds += energy;
        contact.normal -= bond.tension;
        for c in 0..R {
            contact.tangential[c] += bond.shear[c];
            contact.moment[c] += bond.bending[c];
        }
        if D == 3 {
            for c in 0..D {
                contact.moment[c] += bond.twist * geometry.normal[c];
            }
        }
    }

    /// Whether tension or shear in the bond exceeds its strength, from shear force (N) and bending moment (N m).
    fn breaks<const R: usize>(&self, section: &BeamSection, bond: &Bond<R>, shear: f64, bent: f64) -> bool {
        let tension = bond.tension / section.area;
        let outer = tension + self.moments * bent * section.radius / section.bending;
        let mut sheared = shear / section.area;
        if section.torsion > 0.0 {
            sheared += self.moments * bond.twist.abs() * section.radius / section.torsion;
        }
        let shear_strength = self.cohesion * bond.strength + (-tension).max(0.0) * self.friction;
        outer > self.tensile_strength * bond.strength || sheared > shear_strength
    }
}
