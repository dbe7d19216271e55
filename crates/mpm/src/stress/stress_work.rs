//! Work of the stresses, and its dissipated part (sheet: mpm A-30: energy balance of a run-out).
//!
//! A point does the work `∫ σ : D Ω dt`, in each step with the mean of `Ω σ` before and after. The part that the law does not store as
//! recoverable energy is dissipated.

use colluvium_constitutive::{BLOCK_SIZE, MotionBlock, SymTensor};

use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;

/// Stresses of a group of points before their update (Pa).
pub struct PreviousStress([SymTensor; BLOCK_SIZE]);

impl PreviousStress {
    /// Copies the stresses of a group of points (Pa).
    pub fn of_block(stresses: &[SymTensor]) -> Self {
        let mut before = [SymTensor::ZERO; BLOCK_SIZE];
        before[..stresses.len()].copy_from_slice(stresses);
        Self(before)
    }

    /// Adds the work of a step (J) that ends with the stresses `after` (Pa) and `volumes` (m³).
    pub fn add_work(&self, motions: &MotionBlock, after: &[SymTensor], volumes: &[f64], work: &mut [f64]) {
        for (p, (work, volume)) in work.iter_mut().zip(volumes).enumerate() {
            let started = volume / motions.volume_ratio(p);
            let mean = self.0[p] * (0.5 * started) + after[p] * (0.5 * volume);
            *work += mean.dot(&motions.motion(p).strain_increment());
        }
    }
}

/// Recoverable energies of the points of a set (J); zero if the law defines none.
pub fn stored_energies<const D: usize>(set: &PointSet<D>) -> Vec<f64> {
    let mut energies = set.law_points().stored_energies();
    energies.iter_mut().zip(&set.points.volume).for_each(|(energy, volume)| *energy *= volume);
    energies
}

/// Starts the record of stress work with the stored energy of the points.
pub fn start_work_record<const D: usize>(bodies: &mut Bodies<D>) {
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        set.points.work = stored_energies(set);
    }
}

/// Energy dissipated since the start of the record (J), of the points that remain.
pub fn dissipated_energy<const D: usize>(bodies: &Bodies<D>) -> f64 {
    let recorded = bodies.sets.iter().filter(|set| !set.points.work.is_empty());
    let dissipated = recorded.map(|set| {
        let stored = stored_energies(set);
        set.points.work.iter().zip(stored).map(|(work, stored)| work - stored).sum::<f64>()
    });
    dissipated.sum()
}
