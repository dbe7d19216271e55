//! What a material point undergoes in one step.

use crate::{Mat3, MaterialError, SymTensor};

/// Pore fluid at the point; zeros where there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pore {
    /// Pore pressure (Pa), compression-positive.
    pub pressure: f64,
    /// Degree of saturation, 0 to 1.
    pub saturation: f64,
}

/// Kinematics of one step, from `t` to `t + dt`, and what else a law may need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Relative deformation gradient `f = ∂x₊/∂x` of the step.
    pub deformation: Mat3,
    /// Mid-step velocity gradient times the step, `dt L` with `L_ij = ∂v_i/∂x_j`.
    pub gradient: Mat3,
    /// Step (s).
    pub dt: f64,
    /// Density at the end of the step (kg/m³).
    pub density: f64,
    /// Effective size of the point, volume over area of its section (m), for laws with a length.
    pub size: f64,
    /// Pore fluid.
    pub pore: Pore,
}

impl Motion {
    /// No motion at all, in a second, of a point of 1 m and 1 kg/m³.
    pub const STILL: Self = Self {
        deformation: Mat3::IDENTITY,
        gradient: Mat3::ZERO,
        dt: 1.0,
        density: 1.0,
        size: 1.0,
        pore: Pore { pressure: 0.0, saturation: 0.0 },
    };

    /// Motion with constant velocity gradient `l` (1/s): `f = (1 - A/2)⁻¹ (1 + A/2)`, `A = dt l`.
    /// A pure spin gives an exact rotation. `None` where `1 - A/2` is singular.
    pub fn from_velocity_gradient(l: &Mat3, dt: f64, density: f64, size: f64) -> Option<Self> {
        let a = *l * dt;
        let half = a * 0.5;
        let deformation = (Mat3::IDENTITY - half).inverse()? * (Mat3::IDENTITY + half);
        Some(Self { deformation, gradient: a, dt, density, size, pore: Pore::default() })
    }

    /// Motion with relative deformation gradient `f`: the mid-step gradient is
    /// `A = 2 (f - 1)(f + 1)⁻¹`, so a rigid `f = R` (any angle below 180°) carries no strain.
    /// `None` where `f + 1` is singular.
    pub fn from_deformation(f: &Mat3, dt: f64, density: f64, size: f64) -> Option<Self> {
        let gradient = (*f - Mat3::IDENTITY) * (*f + Mat3::IDENTITY).inverse()? * 2.0;
        Some(Self { deformation: *f, gradient, dt, density, size, pore: Pore::default() })
    }

    /// The first of `count` equal parts of the step, a power of two; `None` where it turns by more than a right
    /// angle and a half. Density is that of the end of the step.
    pub(crate) fn part(&self, count: u32) -> Option<Self> {
        let mut deformation = self.deformation;
        for _ in 0..count.trailing_zeros() {
            deformation = deformation.square_root()?;
        }
        let part = Self::from_deformation(&deformation, self.dt / f64::from(count), self.density, self.size)?;
        Some(Self { pore: self.pore, ..part })
    }

    /// What a step must be for any law (sheet: constitutive §7): time passes, the volume changes by no more than
    /// a factor of two and does not turn inside out, density is a positive number.
    #[inline]
    pub(crate) fn check(&self, model: &'static str) -> Result<(), MaterialError> {
        let volume = self.deformation.determinant();
        let reason = if !(self.dt > 0.0 && self.dt.is_finite()) {
            "dt: the time step must be positive (s)"
        } else if !(volume > 0.0) {
            "deformation: the step inverts the point"
        } else if !(0.5..=2.0).contains(&volume) {
            "deformation: the density changes by more than a factor of 2 in one step"
        } else if !(self.density > 0.0 && self.density.is_finite()) {
            "density: must be positive (kg/m³)"
        } else {
            return Ok(());
        };
        Err(MaterialError::Motion { model, reason })
    }

    /// Whether [`Motion::check`] passes for all of `motions`, without branches.
    #[inline]
    pub(crate) fn are_usable(motions: &[Self]) -> bool {
        let mut usable = true;
        for motion in motions {
            let volume = motion.deformation.determinant();
            usable &= (motion.dt > 0.0) & (motion.dt < f64::INFINITY) & (0.5..=2.0).contains(&volume);
            usable &= (motion.density > 0.0) & (motion.density < f64::INFINITY);
        }
        usable
    }

    /// Strain increment of the step, the symmetric part of [`Motion::gradient`].
    #[inline]
    pub fn strain_increment(&self) -> SymTensor {
        self.gradient.sym()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values at the bounds of each condition, on either side of them and no numbers at all.
    #[test]
    fn a_block_of_motions_is_usable_where_each_of_them_is() {
        let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -0.0, 0.0, 5e-324, 1.0, f64::MAX];
        let stretches =
            [f64::NAN, f64::INFINITY, -1.0, 0.0, 0.5, 0.5f64.next_down(), 1.0, 2.0, 2.0f64.next_up()];
        for dt in wild {
            for density in wild {
                for stretch in stretches {
                    let mut motion = Motion { dt, density, ..Motion::STILL };
                    motion.deformation.0[1][1] = stretch;
                    let passes = motion.check("law").is_ok();
                    assert_eq!(Motion::are_usable(&[motion]), passes, "{dt} {density} {stretch}");
                    assert_eq!(Motion::are_usable(&[Motion::STILL, motion, Motion::STILL]), passes);
                }
            }
        }
        assert!(Motion::are_usable(&[]));
    }
}
