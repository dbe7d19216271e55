//! What a node holds, and what a point reads off the nodes.

use wide::{f64x4, f64x8};

/// Four numbers handled at once: three components of a vector and one more.
pub type Lanes = f64x4;

/// What a node holds. While points scatter: momentum and, in the fourth lane, mass; internal and
/// other forces. After the momentum solve: velocity (mass stays in the fourth lane); acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Node {
    /// Momentum (kg m/s) and mass (kg), later velocity (m/s) and mass.
    pub motion: Lanes,
    /// Force (N), later acceleration (m/s²).
    pub force: Lanes,
}

impl Node {
    /// Changes a solved velocity (m/s), and the acceleration of the step of `dt` (s) with it.
    #[inline(always)]
    pub fn change_velocity(&mut self, change: Lanes, dt: f64) {
        self.motion += change;
        self.force += change * (1.0 / dt);
    }

    /// Both at once.
    #[inline(always)]
    pub(crate) fn whole(&self) -> f64x8 {
        join(self.motion, self.force)
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, value: f64x8) {
        [self.motion, self.force] = split(self.whole() + value);
    }
}

/// A lane for each of the first `D` axes, and zeros.
#[inline(always)]
pub(crate) fn lanes_of<const D: usize>(of: impl Fn(usize) -> f64) -> Lanes {
    let mut lanes = [0.0; 4];
    (0..D).for_each(|axis| lanes[axis] = of(axis));
    Lanes::new(lanes)
}

/// Two sets of lanes at once.
#[inline(always)]
pub(crate) fn join(first: Lanes, second: Lanes) -> f64x8 {
    let ([a, b, c, d], [e, f, g, h]) = (first.to_array(), second.to_array());
    f64x8::new([a, b, c, d, e, f, g, h])
}

/// The two sets of lanes of [`join`].
#[inline(always)]
pub(crate) fn split(both: f64x8) -> [Lanes; 2] {
    let [a, b, c, d, e, f, g, h] = both.to_array();
    [Lanes::new([a, b, c, d]), Lanes::new([e, f, g, h])]
}

/// What a point reads off the grid.
#[derive(Clone, Copy, Debug)]
pub struct Gathered<const D: usize> {
    /// `Σ N v`.
    pub velocity: Lanes,
    /// `Σ N a`.
    pub acceleration: Lanes,
    /// `gradient[j] = Σ v ∂N/∂x_j`: column `j` of the velocity gradient.
    pub gradient: [Lanes; D],
}
