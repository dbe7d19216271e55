//! Output of the solver: snapshot, budget, scalar outputs, equilibrium.

use colluvium_case::bodies::law_points::{LawPoints, law_fields};
use colluvium_case::measure::ScalarOutput;
use colluvium_case::{Budget, Equilibrium, FieldList, FrameRequest, Snapshot, spatial};

use crate::points::bodies::{BodyPoints, PointColumns};
use crate::solver::SnowSolver;

impl<const D: usize> SnowSolver<D> {
    /// Points with the wanted fields, in the order of ids.
    pub(crate) fn collect_snapshot(&self, wanted: FrameRequest<'_>) -> Snapshot {
        let bodies = &self.bodies.bodies;
        let mut order: Vec<(u32, usize, usize)> = Vec::new();
        for (number, body) in bodies.iter().enumerate() {
            order.extend(body.points.id.iter().enumerate().map(|(index, &id)| (id, number, index)));
        }
        order.sort_unstable();
        let scalar = |value: &dyn Fn(&PointColumns<D>, usize) -> f64| -> Vec<f64> {
            order.iter().map(|&(_, b, i)| value(&bodies[b].points, i)).collect()
        };
        let vector = |value: &dyn Fn(&PointColumns<D>, usize) -> [f64; 3]| -> Vec<[f64; 3]> {
            order.iter().map(|&(_, b, i)| value(&bodies[b].points, i)).collect()
        };
        let displacement = |points: &PointColumns<D>, i: usize| -> [f64; 3] {
            spatial(&std::array::from_fn::<f64, D, _>(|c| points.position[i][c] - points.origin[i][c]))
        };
        let stress = || order.iter().map(|&(_, b, i)| bodies[b].points.stress[i]).collect();
        let mut fields = FieldList::new(wanted);
        fields.vector("velocity", "m/s", || vector(&|p, i| spatial(&p.velocity[i])));
        fields.vector("displacement", "m", || vector(&displacement));
        fields.tensor("stress", "Pa", stress);
        fields.scalar("pressure", "Pa", || scalar(&|p, i| p.stress[i].pressure()));
        fields.scalar("deviatoric_stress", "Pa", || scalar(&|p, i| p.stress[i].q()));
        fields.scalar("mass", "kg", || scalar(&|p, i| p.mass[i]));
        fields.scalar("volume", "m3", || scalar(&|p, i| p.volume[i]));
        fields.scalar("density", "kg/m3", || scalar(&|p, i| p.mass[i] / p.volume[i]));
        let laws: Vec<LawPoints<'_>> = bodies.iter().map(BodyPoints::law_points).collect();
        let places: Vec<(usize, usize)> = order.iter().map(|&(_, body, index)| (body, index)).collect();
        fields.extend(law_fields(&laws, &places, wanted));
        Snapshot {
            time: self.clock.time,
            step: self.clock.step,
            ids: order.iter().map(|&(id, ..)| u64::from(id)).collect(),
            bodies: order.iter().map(|&(_, b, _)| bodies[b].number).collect(),
            positions: vector(&|p, i| spatial(&p.position[i])),
            extents: order.iter().map(|&(_, b, _)| spatial(&[bodies[b].width; D])).collect(),
            fields: fields.into_fields(),
        }
    }

    /// Totals over the points; kinetic energy and angular momentum include the affine velocity fields of the points.
    pub(crate) fn collect_budget(&self) -> Budget {
        let stored = self.stored_energies();
        let mut budget = Budget {
            kinetic: stored.kinetic + stored.affine_kinetic,
            elastic: stored.elastic,
            ..Budget::default()
        };
        let gravity = self.case.gravity3();
        for body in &self.bodies.bodies {
            let PointColumns { position, velocity, affine_velocity, mass, .. } = &body.points;
            for i in 0..mass.len() {
                let (x, v, m) = (spatial(&position[i]), spatial(&velocity[i]), mass[i]);
                budget.mass += m;
                for c in 0..3 {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    budget.momentum[c] += m * v[c];
                    budget.angular_momentum[c] += m * (x[a] * v[b] - x[b] * v[a]);
                    budget.potential -= m * gravity[c] * x[c];
                    if a < D && b < D {
                        // Sheet: snow-mpm §3.6.
                        budget.angular_momentum[c] +=
                            m * (affine_velocity[i][b][a] - affine_velocity[i][a][b]);
                    }
                }
            }
        }
        budget
    }

    /// Energy balance, speed of the fastest point, total volume, and values of obstacles and cuts.
    pub(crate) fn collect_scalar_outputs(&self) -> Vec<ScalarOutput> {
        let stored = self.stored_energies();
        let mut balance = self.energy_balance.clone();
        if let Some(before) = &self.energies_before_changes {
            balance.add_change(before, &stored);
        }
        let mut readings = balance.scalar_outputs(&stored);
        if self.body_force.is_some() || balance.body_force_work() != 0.0 {
            readings.push(("work_of_body_force".to_owned(), "J".to_owned(), balance.body_force_work()));
        }
        let squares = self
            .bodies
            .bodies
            .iter()
            .flat_map(|body| &body.points.velocity)
            .map(crate::points::vectors::square);
        let fastest = squares.fold(0.0, f64::max).sqrt();
        readings.push(("largest_speed".to_owned(), "m/s".to_owned(), fastest));
        // Sheet: snow-mpm §3.11.
        let volume = self.bodies.bodies.iter().flat_map(|body| &body.points.volume).sum();
        readings.push(("volume".to_owned(), "m3".to_owned(), volume));
        if !self.case.obstacles.is_empty() {
            readings.push(("obstacles.friction".to_owned(), "J".to_owned(), self.energy_balance.friction()));
        }
        for (cut, taken) in self.case.removal_shapes.iter().zip(self.energy_balance.removals()) {
            let entries = [
                ("travel", "m", taken.cut_displacement),
                ("mass", "kg", taken.mass),
                ("energy", "J", taken.energy),
            ];
            let readings_of =
                entries.map(|(name, unit, value)| (format!("{}.{name}", cut.name), unit.to_owned(), value));
            readings.extend(readings_of);
        }
        readings
    }

    /// Equilibrium ratios: unbalanced force over weight, and kinetic energy over external work.
    pub(crate) fn measure_equilibrium(&self) -> Equilibrium {
        let sums = &self.clock.sums;
        let ratio = |value: f64, scale: f64| match (value == 0.0, scale > 0.0) {
            (true, _) => 0.0,
            (false, true) => value / scale,
            (false, false) => f64::INFINITY,
        };
        Equilibrium {
            unbalanced_force: ratio(sums.unbalanced.sqrt(), sums.weight.sqrt()),
            kinetic_ratio: ratio(sums.kinetic, self.clock.external_work.abs()),
            kinetic: sums.kinetic,
        }
    }
}
