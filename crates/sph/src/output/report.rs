//! Reports of the solver: snapshot, energy budget, equilibrium scales.

use colluvium_case::bodies::law_points::{LawPoints, law_fields};
use colluvium_case::rigid::RigidState;
use colluvium_case::{Budget, EquilibriumScales, FieldList, FrameRequest, Snapshot, spatial};
use colluvium_points::surface::cross;

use crate::config::{SmoothingLength, TimeIntegration};
use crate::pairs::repulsion_energy;
use crate::points::particles::ParticleGroup;
use crate::points::vector_algebra::square;
use crate::solver::SphSolver;

impl<const D: usize> SphSolver<D> {
    /// Reference scales of unbalanced force and kinetic energy where no external force acts.
    pub(crate) fn equilibrium_scales(&self) -> EquilibriumScales {
        let (mut scales, p) = (EquilibriumScales::default(), &self.bodies.particles);
        for group in self.bodies.groups.iter().filter(|group| group.prescribed_velocity.is_none()) {
            let moduli = p.law_points(group).law_values(1, |stress, states, out| {
                group.material.wave_moduli(stress, states, out);
            });
            for (i, modulus) in group.range().zip(moduli) {
                let volume = p.mass[i] / p.density[i];
                scales.add(volume, volume.powf(1.0 / D as f64), &p.stress[i], &p.stress[i], modulus);
            }
        }
        scales
    }

    /// Velocity at the time of the positions (m/s).
    fn velocity(&self, i: usize) -> [f64; D] {
        let (v, a, half) = (
            &self.bodies.particles.velocity[i],
            &self.rates.derivatives.acceleration[i],
            self.velocity_lag(i),
        );
        let factor = self.damping_factor(i, half);
        std::array::from_fn(|c| (v[c] + half * a[c]) * factor)
    }

    /// Factor of viscous damping on a velocity over its time lag `half` (s). The leapfrog damps whole
    /// steps, so that its velocities lack none.
    fn damping_factor(&self, i: usize, half: f64) -> f64 {
        let p = &self.bodies.particles;
        match self.setting.options.integration {
            TimeIntegration::LeapfrogRates => self.setting.damping_factor(p.sound[i], p.length[i], half),
            _ => 1.0,
        }
    }

    /// Delay of the velocity of a particle relative to its position (s): half a step, or zero.
    fn velocity_lag(&self, i: usize) -> f64 {
        let held = self
            .bodies
            .groups
            .iter()
            .any(|group| group.prescribed_velocity.is_some() && group.range().contains(&i));
        if self.setting.has_half_step_velocities() && !held { 0.5 * self.clock.last_step } else { 0.0 }
    }

    /// Angular momentum over mass at the time of the positions (m²/s). The last acceleration belongs to the positions
    /// one step earlier; with the present ones it would have a spurious torque.
    fn specific_angular_momentum(&self, i: usize) -> [f64; 3] {
        let p = &self.bodies.particles;
        let (velocity, half) = (&p.velocity[i], self.velocity_lag(i));
        let [x, v, a] =
            [&p.position[i], velocity, &self.rates.derivatives.acceleration[i]].map(|vector| spatial(vector));
        let before: [f64; 3] = std::array::from_fn(|c| x[c] - 2.0 * half * v[c]);
        let (own, moment_rate, factor) = (cross(&x, &v), cross(&before, &a), self.damping_factor(i, half));
        std::array::from_fn(|c| (own[c] + half * moment_rate[c]) * factor)
    }

    /// State of a rigid body at the time of the positions.
    pub(crate) fn rigid_state_at_positions(&self, group: &ParticleGroup) -> Option<RigidState> {
        Some(group.rigid?.extrapolated(0.5 * self.clock.last_step))
    }

    /// Particles with the wanted fields, in the order of ids.
    pub(crate) fn collect_snapshot(&self, wanted: FrameRequest<'_>) -> Snapshot {
        let p = &self.bodies.particles;
        let mut order: Vec<usize> = (0..p.len()).collect();
        order.sort_unstable_by_key(|&i| p.id[i]);
        let mut bodies = vec![0; p.len()];
        self.bodies.groups.iter().for_each(|group| bodies[group.range()].fill(group.body));
        let scalar = |value: &dyn Fn(usize) -> f64| -> Vec<f64> { order.iter().map(|&i| value(i)).collect() };
        let vector = |value: &dyn Fn(usize) -> [f64; D]| -> Vec<[f64; 3]> {
            order.iter().map(|&i| spatial(&value(i))).collect()
        };
        let moved = |i: usize| std::array::from_fn(|c| p.position[i][c] - p.origin[i][c]);
        let mut fields = FieldList::new(wanted);
        fields.vector("velocity", "m/s", || vector(&|i| self.velocity(i)));
        fields.vector("displacement", "m", || vector(&moved));
        fields.tensor("stress", "Pa", || order.iter().map(|&i| p.stress[i]).collect());
        fields.scalar("pressure", "Pa", || scalar(&|i| p.stress[i].pressure()));
        fields.scalar("deviatoric_stress", "Pa", || scalar(&|i| p.stress[i].q()));
        fields.scalar("mass", "kg", || scalar(&|i| p.mass[i]));
        fields.scalar("volume", "m3", || scalar(&|i| p.mass[i] / p.density[i]));
        fields.scalar("density", "kg/m3", || scalar(&|i| p.density[i]));
        if self.setting.options.is_variable() {
            fields.scalar("smoothing_length", "m", || self.lengths(&order));
        }
        let mut places = vec![(0, 0); p.len()];
        for (number, group) in self.bodies.groups.iter().enumerate() {
            group.range().for_each(|i| places[i] = (number, i - group.start));
        }
        let laws: Vec<LawPoints<'_>> = self.bodies.groups.iter().map(|group| p.law_points(group)).collect();
        let places: Vec<(usize, usize)> = order.iter().map(|&i| places[i]).collect();
        fields.extend(law_fields(&laws, &places, wanted));
        self.add_diagnostic_fields(&order, &mut fields);
        let width = |i: usize| [(p.mass[i] / p.density[i]).powf(1.0 / D as f64); D];
        Snapshot {
            time: self.clock.time,
            step: self.clock.step,
            ids: order.iter().map(|&i| u64::from(p.id[i])).collect(),
            bodies: order.iter().map(|&i| bodies[i]).collect(),
            positions: vector(&|i| p.position[i]),
            extents: vector(&width),
            fields: fields.into_fields(),
        }
    }

    /// Smoothing lengths at the current densities (m), if they vary.
    fn lengths(&self, order: &[usize]) -> Vec<f64> {
        let p = &self.bodies.particles;
        let mut lengths = p.length[..p.len()].to_vec();
        if self.setting.options.smoothing_length == SmoothingLength::Density {
            for group in &self.bodies.groups {
                group.range().for_each(|i| lengths[i] = self.setting.length_at(group.density, p.density[i]));
            }
        }
        order.iter().map(|&i| lengths[i]).collect()
    }

    /// Whether no external power acts on the particles, and their laws report stored energy.
    pub(crate) fn is_energetically_closed(&self) -> bool {
        let (bodies, p) = (&self.bodies, &self.bodies.particles);
        let open = |group: &ParticleGroup| {
            group.prescribed_velocity.is_some() || group.is_confined || !p.law_points(group).defines_energy()
        };
        self.setting.case.is_isolated(self.clock.stage)
            && bodies.loads.body_force.is_none()
            && !bodies.groups.iter().any(open)
    }

    /// Energy and momentum totals over the particles.
    pub(crate) fn collect_budget(&self) -> Budget {
        let mut budget = Budget::default();
        let p = &self.bodies.particles;
        for group in &self.bodies.groups {
            if let Some(rigid) = self.rigid_state_at_positions(group) {
                let mass = group.range().map(|i| p.mass[i]).sum();
                rigid.add_rotation_energy(mass, self.setting.options.spacing, &mut budget);
            }
            let energies = p.law_points(group).stored_energies();
            for (k, i) in group.range().enumerate() {
                let (v, m) = (spatial(&self.velocity(i)), p.mass[i]);
                let (x, turn) = (spatial(&p.position[i]), self.specific_angular_momentum(i));
                budget.mass += m;
                budget.kinetic += 0.5 * m * square(&v);
                budget.elastic += energies[k] * m / p.density[i];
                for c in 0..3 {
                    budget.momentum[c] += m * v[c];
                    budget.angular_momentum[c] += m * turn[c];
                    budget.potential -= m * spatial(&self.setting.gravity)[c] * x[c];
                }
            }
        }
        budget.elastic += repulsion_energy(&self.setting, &self.bodies, &self.walls, self.clock.time);
        budget
    }
}
