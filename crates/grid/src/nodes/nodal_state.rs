//! State of a node, and motion interpolated to a point.

use wide::{f64x4, f64x8};

/// Vector of four numbers: three components and one scalar, such as momentum and mass.
pub type Vector4 = f64x4;

/// Momentum, mass and force of a node; after the solve velocity and acceleration. During the scatter of points: momentum and, in the fourth
/// lane, mass; internal and other forces. After the momentum solve: velocity (mass stays in the fourth lane); acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct NodalState {
    /// Momentum (kg m/s) and mass (kg), later velocity (m/s) and mass.
    pub momentum_and_mass: Vector4,
    /// Force (N), later acceleration (m/s²).
    pub force: Vector4,
}

impl NodalState {
    /// Changes a solved velocity (m/s), and the acceleration in the step of `dt` (s) consistently.
    #[inline(always)]
    pub fn change_velocity(&mut self, change: Vector4, dt: f64) {
        self.momentum_and_mass += change;
        self.force += change * (1.0 / dt);
    }

    /// Both vectors in eight lanes.
    #[inline(always)]
    pub(crate) fn as_f64x8(&self) -> f64x8 {
        join_halves(self.momentum_and_mass, self.force)
    }

    /// Adds a momentum, mass and force.
    #[inline(always)]
    pub(crate) fn add(&mut self, value: f64x8) {
        [self.momentum_and_mass, self.force] = split_halves(self.as_f64x8() + value);
    }
}

/// Vector with a lane for each of the first `D` axes, and zeros.
#[inline(always)]
pub(crate) fn vector4<const D: usize>(of: impl Fn(usize) -> f64) -> Vector4 {
    let mut lanes = [0.0; 4];
    (0..D).for_each(|axis| lanes[axis] = of(axis));
    Vector4::new(lanes)
}

/// Joins two vectors of four lanes.
#[inline(always)]
pub(crate) fn join_halves(first: Vector4, second: Vector4) -> f64x8 {
    let ([a, b, c, d], [e, f, g, h]) = (first.to_array(), second.to_array());
    f64x8::new([a, b, c, d, e, f, g, h])
}

/// Splits the result of [`join_halves`] into its two vectors.
#[inline(always)]
pub(crate) fn split_halves(both: f64x8) -> [Vector4; 2] {
    let [a, b, c, d, e, f, g, h] = both.to_array();
    [Vector4::new([a, b, c, d]), Vector4::new([e, f, g, h])]
}

/// Motion interpolated from the grid to a point.
#[derive(Clone, Copy, Debug)]
pub struct InterpolatedMotion<const D: usize> {
    /// Interpolated velocity `Σ N v` (m/s).
    pub velocity: Vector4,
    /// Interpolated acceleration `Σ N a` (m/s²).
    pub acceleration: Vector4,
    /// `gradient[j] = Σ v ∂N/∂x_j`: column `j` of the velocity gradient.
    pub gradient: [Vector4; D],
}
