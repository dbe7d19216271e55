//! Diagnostics of the sums over neighbours (Bui & Nguyen 2021, eq. 19; sheet: sph §2.2, pitfalls 9 and 13).

use colluvium_case::measure::ScalarOutput;
use colluvium_case::{FieldList, SolverError, spatial};
use colluvium_constitutive::{Mat3, SymTensor};
use rayon::prelude::*;

use crate::pairs::PairContext;
use crate::points::particles::{MIN_PARTICLES_PER_TASK, ParticleGroup};
use crate::points::vector_algebra::separation;
use crate::solver::{SphSolver, update_pair_data};
use crate::stress::regularisation::BodyNeighbours;
use crate::walls::ObstacleEnergies;

/// Distance (smoothing lengths) within which two particles coincide: their kernel has no direction.
const COINCIDENT: f64 = 1e-12;

/// Diagnostics of a particle.
#[derive(Clone, Copy, Debug, Default)]
struct ParticleDiagnostics {
    /// Gradient of a constant, `h Σ V_j ∇W`.
    constant: [f64; 3],
    /// Gradient of the position, `M = Σ V_j (x_j - x_i) ⊗ ∇W`.
    linear: SymTensor,
    /// Number of particles of higher index, or images, at the same position.
    coincident_count: usize,
    /// Whether the corrected gradient falls back to the plain one.
    is_uncorrected: bool,
    /// Whether moving least squares fall back to Shepard's interpolation.
    is_averaged: bool,
}

impl<const D: usize> SphSolver<D> {
    /// Solver with the same particles at their current positions, with new neighbour lists, images and walls.
    ///
    /// # Errors
    /// When particles are too far from one another for a search.
    pub(crate) fn diagnostic_copy(&self) -> Result<Self, SolverError> {
        let mut probe = self.empty_like();
        probe.bodies.particles = self.bodies.particles.clone();
        for (group, own) in probe.bodies.groups.iter_mut().zip(&self.bodies.groups) {
            (group.start, group.end) = (own.start, own.end);
        }
        let Self { setting, clock, bodies, walls, lists, .. } = &mut probe;
        let support = setting.support(bodies.max_smoothing_length(setting));
        lists.set_list_positions(setting, clock, &bodies.particles, support);
        lists.build(setting, clock, bodies, walls)?;
        Ok(probe)
    }

    /// Diagnostic values of all particles; `None` unless the case requires them.
    fn particle_diagnostics(&self) -> Option<Vec<ParticleDiagnostics>> {
        if !self.setting.options.diagnostics {
            return None;
        }
        let Self { setting, clock, mut bodies, walls, lists, .. } = self.diagnostic_copy().ok()?;
        update_pair_data(&setting, &clock, &mut bodies, &walls, &lists);
        let p = &bodies.particles;
        let (pairs, mls) = (PairContext::new(&setting, p, &walls), setting.options.has_linear_averages());
        let near = BodyNeighbours::new(&setting, p, &walls, &lists);
        let of_particle = |i: usize| {
            let row = lists.neighbours.neighbours(i);
            let h = p.length[i];
            let moment = pairs.moment(i, row);
            let entry = |a: usize, b: usize| if a < D && b < D { moment.matrix[a][b] } else { 0.0 };
            let linear = Mat3(std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b))));
            let distance = |j: usize| separation(&p.position[i], &p.position[j]).1.sqrt();
            let others = row.iter().map(|j| *j as usize).filter(|j| *j > i);
            let body = bodies.group_of(i).map(ParticleGroup::range);
            ParticleDiagnostics {
                constant: spatial(&pairs.gradient_of_constant(i, row)).map(|g| h * g),
                linear: linear.sym(),
                coincident_count: others.filter(|j| distance(*j) < COINCIDENT * h).count(),
                is_uncorrected: moment.correction().is_none(),
                is_averaged: mls && body.is_some_and(|body| near.linear_weights(i, &body).is_none()),
            }
        };
        Some(
            (0..p.len())
                .into_par_iter()
                .with_min_len(MIN_PARTICLES_PER_TASK)
                .map(of_particle)
                .collect::<Vec<_>>(),
        )
    }

    /// Adds the fields of the uncorrected gradient of a constant and of the position, for particles in the given order; none unless the
    /// options ask for them.
    pub(crate) fn add_diagnostic_fields(&self, order: &[usize], fields: &mut FieldList<'_>) {
        if !["gradient_of_constant", "gradient_of_position"].iter().any(|name| fields.includes(name)) {
            return;
        }
        let Some(findings) = self.particle_diagnostics() else { return };
        let constants = || order.iter().map(|&i| findings[i].constant).collect();
        fields.vector("gradient_of_constant", "", constants);
        fields.tensor("gradient_of_position", "", || order.iter().map(|&i| findings[i].linear).collect());
    }

    /// Numbers of coincident particles and of corrections that fall back; none unless requested.
    pub(crate) fn collect_scalar_outputs(&self) -> Vec<ScalarOutput> {
        let mut readings = Vec::new();
        if !self.walls.obstacles.is_empty() {
            let ObstacleEnergies { friction, normal_loss: stopped, work } = self.obstacle_energies;
            readings.push(("obstacles.friction".to_owned(), "J".to_owned(), friction));
            readings.push(("obstacles.stopped".to_owned(), "J".to_owned(), stopped));
            if self.walls.obstacles.are_moving() {
                readings.push(("obstacles.work".to_owned(), "J".to_owned(), work));
            }
        }
        for group in &self.bodies.groups {
            let name = &self.setting.case.bodies[group.body as usize].name;
            let free = self.setting.case.moves_freely(name);
            let rigid = self.rigid_state_at_positions(group).filter(|_| free);
            readings.extend(rigid.into_iter().flat_map(|rigid| rigid.scalar_outputs(name, D)));
        }
        let Some(findings) = self.particle_diagnostics() else { return readings };
        let mut push = |name: &str, count: usize| {
            readings.push((name.to_owned(), String::new(), count as f64));
        };
        push("coincident_pairs", findings.iter().map(|finding| finding.coincident_count).sum());
        let count =
            |is: fn(&ParticleDiagnostics) -> bool| findings.iter().filter(|finding| is(finding)).count();
        if self.setting.options.has_corrected_gradients() {
            push("uncorrected_gradients", count(|finding| finding.is_uncorrected));
        }
        if self.setting.options.has_linear_averages() {
            push("averages_by_shepard", count(|finding| finding.is_averaged));
        }
        readings
    }
}
