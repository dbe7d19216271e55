//! Surface load on the points of a body.

use std::io::{self, Read};

use colluvium_points::struct_of_arrays::read_column;

/// Load on the points of a set.
pub struct SurfaceLoad<const D: usize> {
    /// Index into `Case::loads`.
    pub number: usize,
    /// Whether the load acts on the pore fluid.
    pub liquid: bool,
    /// Whether the load rotates with the surface.
    pub is_follower: bool,
    /// Load vector of each point (`Case::load_vectors`); zero for interior points.
    pub vectors: Vec<[f64; D]>,
    /// Factor of the load at its last application.
    pub applied_factor: f64,
}

impl<const D: usize> SurfaceLoad<D> {
    /// Reads the vectors of a checkpoint.
    ///
    /// # Errors
    /// When the bytes end early.
    pub fn read(&mut self, input: &mut dyn Read) -> io::Result<()> {
        self.applied_factor = f64::NAN;
        read_column(&mut self.vectors, |vector: [f64; D]| vector, input)
    }
}
