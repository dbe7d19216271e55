//! Buffers of the contact forces.

use crate::boundary::walls::WallReaction;
use crate::contact::{ContactEnergies, Virial};
use crate::force_loop::GrainRecords;

/// Buffers of the contact forces of a step.
#[derive(Default)]
pub struct ContactBuffers<const D: usize, const R: usize> {
    /// Energies and virial of each slab, and of the periodic pairs.
    pub slab_energies: Vec<(ContactEnergies, Virial<D>)>,
    /// Reactions of the walls, slab by slab.
    pub reactions: Vec<WallReaction<D>>,
    /// Shift (m) and velocity (m/s) of each image.
    pub shifts: Vec<([f64; D], [f64; D])>,
    /// Predicted velocities, extrapolated by half a step (m/s).
    pub velocity: Vec<[f64; D]>,
    /// Predicted angular velocities (rad/s).
    pub spin: Vec<[f64; R]>,
    /// Records of the grains for the SIMD kernels, with their forces.
    pub records: GrainRecords,
}
