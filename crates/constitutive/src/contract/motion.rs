//! Kinematics of a material point in one step.

use crate::{BLOCK_SIZE, BatchError, Mat3, MaterialError, SymTensor};

/// State of the pore fluid at the point; zero for a point without pore fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoreFluidState {
    /// Pore pressure (Pa), compression-positive.
    pub pressure: f64,
    /// Degree of saturation, 0 to 1.
    pub saturation: f64,
}

/// Kinematics of one step, from `t` to `t + dt`, and further inputs of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Relative deformation gradient `f = ∂x₊/∂x` of the step.
    pub deformation: Mat3,
    /// Mid-step velocity gradient times the step, `dt L` with `L_ij = ∂v_i/∂x_j`.
    pub velocity_gradient_dt: Mat3,
    /// Step (s).
    pub dt: f64,
    /// Density at the end of the step (kg/m³).
    pub density: f64,
    /// Effective size of the point, volume over area of its section (m), for laws with a length.
    pub size: f64,
    /// State of the pore fluid at the point.
    pub pore: PoreFluidState,
}

impl Motion {
    /// Motion of a point at rest: step of 1 s, size of 1 m, density of 1 kg/m³.
    pub const AT_REST: Self = Self {
        deformation: Mat3::IDENTITY,
        velocity_gradient_dt: Mat3::ZERO,
        dt: 1.0,
        density: 1.0,
        size: 1.0,
        pore: PoreFluidState { pressure: 0.0, saturation: 0.0 },
    };

    /// Motion with constant velocity gradient `l` (1/s): `f = (1 - A/2)⁻¹ (1 + A/2)`, `A = dt l`.
    /// A pure spin gives an exact rotation. `None` where `1 - A/2` is singular.
    pub fn from_velocity_gradient(l: &Mat3, dt: f64, density: f64, size: f64) -> Option<Self> {
        let a = *l * dt;
        let half = a * 0.5;
        let deformation = (Mat3::IDENTITY - half).inverse()? * (Mat3::IDENTITY + half);
        Some(Self {
            deformation,
            velocity_gradient_dt: a,
            dt,
            density,
            size,
            pore: PoreFluidState::default(),
        })
    }

    /// Motion with the relative deformation gradient `f`, by the mid-step gradient `A = 2 (f - 1)(f + 1)⁻¹`. A rigid rotation below 180°
    /// has no strain. `None` if `f + 1` is singular.
    pub fn from_deformation(f: &Mat3, dt: f64, density: f64, size: f64) -> Option<Self> {
        let gradient = (*f - Mat3::IDENTITY) * (*f + Mat3::IDENTITY).inverse()? * 2.0;
        Some(Self {
            deformation: *f,
            velocity_gradient_dt: gradient,
            dt,
            density,
            size,
            pore: PoreFluidState::default(),
        })
    }

    /// Motion of the first of `count` equal sub-steps, `count` being a power of two; `None` if the step rotates by more than 135°. Density
    /// is that of the end of the step.
    pub(crate) fn equal_part(&self, count: u32) -> Option<Self> {
        let mut deformation = self.deformation;
        for _ in 0..count.trailing_zeros() {
            deformation = deformation.square_root()?;
        }
        let part = Self::from_deformation(&deformation, self.dt / f64::from(count), self.density, self.size)?;
        Some(Self { pore: self.pore, ..part })
    }

    /// Checks that a step is valid for any law (sheet: constitutive §7): positive time step and density, and a volume ratio between one
    /// half and two.
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

    /// Whether all motions pass [`Motion::check`], computed without branches.
    #[inline]
    pub(crate) fn are_valid(motions: &[Self]) -> bool {
        let mut usable = true;
        for motion in motions {
            let volume = motion.deformation.determinant();
            usable &= (motion.dt > 0.0) & (motion.dt < f64::INFINITY) & (0.5..=2.0).contains(&volume);
            usable &= (motion.density > 0.0) & (motion.density < f64::INFINITY);
        }
        usable
    }

    /// Strain increment of the step, the symmetric part of [`Motion::velocity_gradient_dt`].
    #[inline]
    pub fn strain_increment(&self) -> SymTensor {
        self.velocity_gradient_dt.sym()
    }
}

/// Values of one component at all points of a block.
pub(crate) type BlockArray = [f64; BLOCK_SIZE];

/// Motions of up to [`BLOCK_SIZE`] points in one array per component, so that SIMD instructions process several points at once. Entries
/// behind the last point are not read.
#[derive(Clone, Debug)]
pub struct MotionBlock {
    /// Relative deformation gradients, see [`Motion::deformation`], row by row.
    pub deformation: [BlockArray; 9],
    /// Velocity gradients times step, see [`Motion::velocity_gradient_dt`], row by row.
    pub velocity_gradient_dt: [BlockArray; 9],
    /// Densities (kg/m³), see [`Motion::density`].
    pub density: BlockArray,
    /// Step (s), see [`Motion::dt`].
    pub dt: f64,
    /// Effective sizes (m), see [`Motion::size`].
    pub size: BlockArray,
    /// Pore pressures (Pa), see [`PoreFluidState::pressure`].
    pub pore_pressure: BlockArray,
    /// Degrees of saturation, see [`PoreFluidState::saturation`].
    pub saturation: BlockArray,
    /// Whether nothing moves or is sheared out of the plane of the first two axes. Those components are then not read.
    pub in_plane: bool,
}

/// Indices of out-of-plane components of matrices stored row by row.
pub(crate) const OUT_OF_PLANE_COMPONENTS: [usize; 4] = [2, 5, 6, 7];

impl MotionBlock {
    /// Motions of points at rest in a step of `dt` (s), of effective size `size` (m) and 1 kg/m³.
    pub const fn at_rest(dt: f64, size: f64, in_plane: bool) -> Self {
        let (zero, one) = ([0.0; BLOCK_SIZE], [1.0; BLOCK_SIZE]);
        let deformation = [one, zero, zero, zero, one, zero, zero, zero, one];
        Self {
            deformation,
            velocity_gradient_dt: [zero; 9],
            density: one,
            dt,
            size: [size; BLOCK_SIZE],
            pore_pressure: zero,
            saturation: zero,
            in_plane,
        }
    }

    /// Sets the motion of a point; the time step remains that of the block.
    pub fn set(&mut self, index: usize, motion: &Motion) {
        for c in 0..9 {
            self.deformation[c][index] = motion.deformation.0[c / 3][c % 3];
            self.velocity_gradient_dt[c][index] = motion.velocity_gradient_dt.0[c / 3][c % 3];
        }
        self.density[index] = motion.density;
        self.size[index] = motion.size;
        (self.pore_pressure[index], self.saturation[index]) = (motion.pore.pressure, motion.pore.saturation);
    }

    /// Sets the velocity gradients of the first points from their columns along the first `D` axes.
    #[inline(always)]
    pub fn set_gradients<const D: usize>(&mut self, columns: impl Iterator<Item = [[f64; 4]; D]>) {
        for (index, columns) in columns.enumerate().take(BLOCK_SIZE) {
            for (j, column) in columns.iter().enumerate() {
                for i in 0..D {
                    self.velocity_gradient_dt[3 * i + j][index] = column[i];
                }
            }
        }
    }

    /// Sets the relative deformation gradients to `1 + dt L` along the first `D` axes.
    #[inline(always)]
    pub fn deform_linearly<const D: usize>(&mut self) {
        for i in 0..D {
            for j in 0..D {
                let one = if i == j { 1.0 } else { 0.0 };
                let (to, from) = (&mut self.deformation[3 * i + j], &self.velocity_gradient_dt[3 * i + j]);
                to.iter_mut().zip(from).for_each(|(to, from)| *to = one + from);
            }
        }
    }

    /// Ratio of the volume after the step to that before, `det f`.
    #[inline(always)]
    pub fn volume_ratio(&self, index: usize) -> f64 {
        let [a, b, c, d, e, f, g, h, k] = &self.deformation;
        let i = index;
        if self.in_plane {
            a[i] * (e[i] * k[i]) - b[i] * (d[i] * k[i])
        } else {
            Mat3([[a[i], b[i], c[i]], [d[i], e[i], f[i]], [g[i], h[i], k[i]]]).determinant()
        }
    }

    /// Volume ratio of each point, see [`MotionBlock::volume_ratio`].
    #[inline(always)]
    pub fn volume_ratios(&self) -> [f64; BLOCK_SIZE] {
        let mut ratios = [1.0; BLOCK_SIZE];
        (0..BLOCK_SIZE).for_each(|p| ratios[p] = self.volume_ratio(p));
        ratios
    }

    /// Multiplies the volumes of points (m³) by their volume ratios and sets the densities from the masses (kg). The error is the first
    /// point whose ratio is not positive, with the reason.
    #[inline(always)]
    pub fn change_volumes(
        &mut self,
        ratios: &[f64; BLOCK_SIZE],
        volumes: &mut [f64],
        masses: &[f64],
    ) -> Option<(usize, String)> {
        // Written so that NaN counts as a failure.
        let inverted = ratios[..volumes.len()].iter().position(|ratio| !(*ratio > 0.0));
        for (((volume, mass), density), ratio) in
            volumes.iter_mut().zip(masses).zip(&mut self.density).zip(ratios)
        {
            *volume *= ratio;
            *density = mass / *volume;
        }
        inverted.map(|p| (p, format!("the step would invert it (volume ratio {})", ratios[p])))
    }

    /// Motion of point `index` as a separate structure.
    pub fn motion(&self, index: usize) -> Motion {
        let matrix = |of: &[BlockArray; 9]| {
            let component = |c: usize| {
                if self.in_plane && OUT_OF_PLANE_COMPONENTS.contains(&c) { 0.0 } else { of[c][index] }
            };
            Mat3(std::array::from_fn(|row| std::array::from_fn(|column| component(3 * row + column))))
        };
        Motion {
            deformation: matrix(&self.deformation),
            velocity_gradient_dt: matrix(&self.velocity_gradient_dt),
            dt: self.dt,
            density: self.density[index],
            size: self.size[index],
            pore: PoreFluidState { pressure: self.pore_pressure[index], saturation: self.saturation[index] },
        }
    }

    /// Motions of the first `count` points as separate structures; the remaining ones are at rest.
    pub(crate) fn to_array(&self, count: usize) -> [Motion; BLOCK_SIZE] {
        std::array::from_fn(|i| if i < count { self.motion(i) } else { Motion::AT_REST })
    }

    /// Checks the motions of the first `count` points ([`Motion::check`]) for a law of this name.
    ///
    /// # Errors
    /// The first point that fails.
    #[inline]
    pub(crate) fn check(&self, model: &'static str, count: usize) -> Result<(), BatchError> {
        if !self.are_valid(count) {
            for index in 0..count {
                self.motion(index).check(model).map_err(|source| BatchError { index, source })?;
            }
        }
        Ok(())
    }

    /// Whether the first `count` points pass [`Motion::check`], computed without branches.
    #[inline]
    pub(crate) fn are_valid(&self, count: usize) -> bool {
        let density = &self.density;
        let mut usable = (self.dt > 0.0) & (self.dt < f64::INFINITY);
        for i in 0..count.min(BLOCK_SIZE) {
            usable &= (0.5..=2.0).contains(&self.volume_ratio(i));
            usable &= (density[i] > 0.0) & (density[i] < f64::INFINITY);
        }
        usable
    }

    /// Whether no strain increment of the `count` points from `first` on, at most `N`, is larger than `largest`.
    #[inline(always)]
    pub(crate) fn strains_are_within<const N: usize>(
        &self,
        first: usize,
        count: usize,
        largest: f64,
    ) -> bool {
        let maximum = largest * largest;
        let small = |strain: &SymTensor| strain.dot(strain) <= maximum;
        if count < N {
            return (first..first + count).all(|i| small(&self.motion(i).strain_increment()));
        }
        let lane = |c: usize| {
            self.velocity_gradient_dt[c][first..].first_chunk::<N>().expect("a block of whole groups")
        };
        let ([a, b, d, e, k], [c, f, g, h]) =
            ([lane(0), lane(1), lane(3), lane(4), lane(8)], [lane(2), lane(5), lane(6), lane(7)]);
        let mut within = true;
        if self.in_plane {
            for i in 0..N {
                within &= small(&SymTensor([a[i], e[i], k[i], 0.5 * (b[i] + d[i]), 0.0, 0.0]));
            }
        } else {
            for i in 0..N {
                let (xy, yz, zx) = (0.5 * (b[i] + d[i]), 0.5 * (f[i] + h[i]), 0.5 * (g[i] + c[i]));
                within &= small(&SymTensor([a[i], e[i], k[i], xy, yz, zx]));
            }
        }
        within
    }

    /// Relative deformation gradients of up to `N` points from index `first` on, in one array per component; missing points repeat the last
    /// one.
    #[inline(always)]
    pub(crate) fn deformation_components<const N: usize>(
        &self,
        first: usize,
        count: usize,
        to: &mut [[f64; N]; 9],
    ) {
        for c in (0..9).filter(|c| !(self.in_plane && OUT_OF_PLANE_COMPONENTS.contains(c))) {
            let lane = &self.deformation[c][first..];
            if count >= N {
                to[c].copy_from_slice(&lane[..N]);
            } else {
                (0..N).for_each(|i| to[c][i] = lane[i.min(count - 1)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values at the bounds of each condition, on either side of them, and NaN or infinity.
    #[test]
    fn a_block_of_motions_is_usable_where_each_of_them_is() {
        let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -0.0, 0.0, 5e-324, 1.0, f64::MAX];
        let stretches =
            [f64::NAN, f64::INFINITY, -1.0, 0.0, 0.5, 0.5f64.next_down(), 1.0, 2.0, 2.0f64.next_up()];
        for dt in wild {
            for density in wild {
                for stretch in stretches {
                    let mut motion = Motion { dt, density, ..Motion::AT_REST };
                    motion.deformation.0[1][1] = stretch;
                    let passes = motion.check("law").is_ok();
                    assert_eq!(Motion::are_valid(&[motion]), passes, "{dt} {density} {stretch}");
                    assert_eq!(Motion::are_valid(&[Motion::AT_REST, motion, Motion::AT_REST]), passes);
                }
            }
        }
        assert!(Motion::are_valid(&[]));
    }

    #[test]
    fn volumes_follow_the_deformation_and_the_first_inverted_point_is_reported() {
        let mut motions = MotionBlock::at_rest(1e-3, 1.0, true);
        motions.deformation[0][1] = 1.5;
        (motions.deformation[1][2], motions.deformation[3][2]) = (0.5, 0.4);
        (motions.deformation[4][3], motions.deformation[4][5]) = (-0.25, f64::NAN);
        let (mut volumes, masses) = ([2.0; 6], [3.0; 6]);
        let (index, reason) = motions
            .change_volumes(&motions.volume_ratios(), &mut volumes, &masses)
            .expect("one is turned inside out");
        assert_eq!((index, volumes[..4].to_vec()), (3, vec![2.0, 3.0, 1.6, -0.5]));
        assert!(reason.ends_with("(volume ratio -0.25)"), "{reason}");
        assert_eq!(motions.density[..3], [1.5, 1.0, 3.0 / 1.6]);
        // Points of the block beyond the requested ones are not read.
        assert!(motions.change_volumes(&motions.volume_ratios(), &mut volumes[..3], &masses[..3]).is_none());
    }
}
