//! Scalar outputs on the state of a run in each row of the measures (sheet: mpm §3.9).

use colluvium_case::measure::ScalarOutput;

use crate::momentum::NodeObstacleEnergies;
use crate::obstacles::obstacle_penalty::{PenaltyEnergies, penalty_energies};
use crate::points::point_set::PointSet;
use crate::solver::MpmSolver;
use crate::transfer::affine_transfer::affine_energies;

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

impl<const D: usize> MpmSolver<D> {
    /// Scalar outputs: kinetic energy along each axis, work of the external forces, volume ratios, points per cell.
    pub(crate) fn collect_scalar_outputs(&self) -> Vec<ScalarOutput> {
        let mut readings = Vec::new();
        let mut push = |name: &str, unit: &str, value: f64| {
            readings.push((name.to_owned(), unit.to_owned(), value));
        };
        for (axis, energy) in AXES.into_iter().zip(self.kinetic_energies()) {
            push(&format!("kinetic_energy.{axis}"), "J", energy);
        }
        let audited = self.clock.stage().equilibrium.is_some();
        push("external_work", "J", if audited { self.nodes.external_work } else { f64::NAN });
        let [smallest, largest] = self.volume_ratios();
        push("volume_ratio.min", "", smallest);
        push("volume_ratio.max", "", largest);
        let [fewest, mean] = self.points_per_cell();
        push("points_per_cell.min", "", fewest);
        push("points_per_cell.mean", "", mean);
        if let Some(PenaltyEnergies { friction, spring_energy, penetration_loss, work }) =
            penalty_energies(self.boundary.penalty_obstacles.as_deref())
        {
            push("obstacles.friction", "J", friction);
            push("obstacles.stored", "J", spring_energy);
            push("obstacles.stopped", "J", penetration_loss);
            work.into_iter().for_each(|work| push("obstacles.work", "J", work));
        }
        for driven in &self.boundary.driven {
            if driven.patch.is_some() || !self.clock.case.moves_freely(&driven.name) {
                continue;
            }
            let outputs = driven.state.rigid.scalar_outputs(&driven.name, D);
            outputs.iter().for_each(|(name, unit, value)| push(name, unit, *value));
        }
        if let Some(recorder) = &self.boundary.reaction_recorder {
            let NodeObstacleEnergies { friction, work } = recorder.state.energies;
            push("obstacles.friction", "J", friction);
            if !self.boundary.node_obstacles.moving_obstacles.is_empty() {
                push("obstacles.work", "J", work);
            }
        }
        readings
    }

    /// Kinetic energy of both phases along each axis (J), affine velocity fields included.
    fn kinetic_energies(&self) -> [f64; D] {
        let mut energies = affine_energies(&self.clock, &self.background, &self.bodies);
        let mut add = |mass: f64, velocity: &[f64; D]| {
            energies.iter_mut().zip(velocity).for_each(|(energy, v)| *energy += 0.5 * mass * v * v);
        };
        for set in &self.bodies.sets {
            set.points
                .mass
                .iter()
                .zip(&set.points.velocity)
                .for_each(|(mass, velocity)| add(*mass, velocity));
            if let Some(pore) = &set.pore {
                pore.points
                    .velocity
                    .iter()
                    .enumerate()
                    .for_each(|(p, velocity)| add(set.liquid_mass(p), velocity));
            }
        }
        energies
    }

    /// Smallest and largest volume of a point over its initial volume; NaN without points.
    fn volume_ratios(&self) -> [f64; 2] {
        let ratios = self.bodies.deformable_sets().flat_map(|set| {
            set.points.volume.iter().zip(&set.points.initial_volume).map(|(volume, initial)| volume / initial)
        });
        ratios.fold([f64::NAN; 2], |[smallest, largest], ratio| [ratio.min(smallest), ratio.max(largest)])
    }

    /// Smallest and mean number of points in the cells that contain points; NaN without points.
    fn points_per_cell(&self) -> [f64; 2] {
        let view = self.background.grid_view();
        let of_set = |set: &PointSet<D>| -> Vec<usize> {
            let mut cells = vec![0; set.len()];
            set.domain.as_slice().cells(&view, &set.points.position, &mut cells);
            cells
        };
        let mut cells: Vec<usize> = self.bodies.deformable_sets().flat_map(of_set).collect();
        cells.sort_unstable();
        let counts = || cells.chunk_by(|a, b| a == b).map(<[usize]>::len);
        let fewest = counts().min().map_or(f64::NAN, |count| count as f64);
        [fewest, cells.len() as f64 / counts().count() as f64]
    }
}
