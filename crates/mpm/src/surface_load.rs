//! A load that the points of a body carry.

/// One load on the points of a set.
pub struct SurfaceLoad<const D: usize> {
    /// Index into `Case::loads`.
    pub number: usize,
    /// Whether it acts on the pore fluid.
    pub liquid: bool,
    /// Whether it follows the surface.
    pub follows: bool,
    /// Force of each point at full load (N); zero within the body.
    pub force: Vec<[f64; D]>,
    /// Share that was last applied.
    pub applied: f64,
}

impl<const D: usize> SurfaceLoad<D> {
    /// Puts the points in a new order.
    pub fn permute(&mut self, order: &[u32]) {
        self.force = order.iter().map(|&i| self.force[i as usize]).collect();
    }

    /// Takes the forces of a checkpoint.
    pub fn restore(&mut self, force: Vec<[f64; D]>) {
        self.force = force;
        self.applied = f64::NAN;
    }
}
