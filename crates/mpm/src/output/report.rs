//! Reports of the solver: time-step limit, snapshot, budget.

use colluvium_case::bodies::law_points::{LawPoints, law_fields};
use colluvium_case::{Budget, Field, FieldData, Snapshot, StepLimit, TimeStep, spatial};
use colluvium_constitutive::{BLOCK_SIZE, StateBlock, States, SymTensor};
use rayon::prelude::*;

use crate::config::StepCoefficients;
use crate::points::point_set::PointSet;
use crate::points::vectors::square;
use crate::solver::MpmSolver;
use crate::transfer::affine_transfer::affine_energies;

/// The point with the smallest stable step.
#[derive(Clone, Copy)]
pub struct LimitingPoint {
    /// The step (s).
    pub dt: f64,
    /// Cause of the limit.
    pub limit: StepLimit,
    /// Number of the point's set.
    pub set: usize,
    /// Index of the point in it.
    pub index: usize,
}

impl LimitingPoint {
    fn smaller(self, other: Self) -> Self {
        let other_first = (other.dt, other.set, other.index) < (self.dt, self.set, self.index);
        if other_first { other } else { self }
    }
}

/// Returns the smallest of `none` and the values of `of_block(index of its first point, stresses, states)` for the blocks of a set.
fn min_over_blocks(
    stress: &[SymTensor],
    states: &States,
    none: LimitingPoint,
    of_block: &(dyn Fn(usize, &[SymTensor], &StateBlock) -> LimitingPoint + Sync),
) -> LimitingPoint {
    let blocks = stress.par_chunks(BLOCK_SIZE).zip(states.blocks()).enumerate();
    let limit = |(block, (stress, states)): (usize, (&[SymTensor], &StateBlock))| {
        of_block(block * BLOCK_SIZE, stress, states)
    };
    blocks.with_min_len(16).map(limit).reduce(|| none, LimitingPoint::smaller)
}

/// Recoverable energies of the points of a set (J), zero where the law defines none.
pub fn stored_energies<const D: usize>(set: &PointSet<D>) -> Vec<f64> {
    let mut energies = set.law_points().stored_energies();
    energies.iter_mut().zip(&set.points.volume).for_each(|(energy, volume)| *energy *= volume);
    energies
}

impl<const D: usize> MpmSolver<D> {
    /// The largest step that the waves, the motion and the viscosity of the points allow at a Courant number of `courant`;
    /// the critical one at 1.
    pub(crate) fn wave_limit(&self, courant: f64) -> TimeStep {
        let bounds = self.clock.options.step_bounds(D, courant);
        let none = LimitingPoint { dt: f64::INFINITY, limit: StepLimit::NOTHING, set: 0, index: 0 };
        let mut least = none;
        for (number, set) in self.bodies.sets.iter().enumerate() {
            let of_block = |first: usize, stress: &[SymTensor], states: &StateBlock| {
                self.block_limit(bounds, number, first, stress, states)
            };
            least = least.smaller(min_over_blocks(&set.points.stress, &set.states, none, &of_block));
        }
        let point = self.bodies.sets.get(least.set).filter(|set| least.index < set.len());
        TimeStep {
            dt: least.dt,
            limit: least.limit,
            point: point.map(|set| u64::from(set.points.id[least.index])),
            position: point.map_or([0.0; 3], |set| spatial(&set.points.position[least.index])),
        }
    }

    fn block_limit(
        &self,
        bounds: StepCoefficients,
        number: usize,
        first: usize,
        stress: &[SymTensor],
        states: &StateBlock,
    ) -> LimitingPoint {
        let set = &self.bodies.sets[number];
        let ground = self.background.grid_view();
        let mut moduli = [0.0; BLOCK_SIZE];
        let mut viscosities = [0.0; BLOCK_SIZE];
        set.material.wave_moduli(stress, states, &mut moduli[..stress.len()]);
        set.material.viscosities(stress, states, &mut viscosities[..stress.len()]);
        let mut least =
            LimitingPoint { dt: f64::INFINITY, limit: StepLimit::NOTHING, set: number, index: first };
        let stiffening = if self.boundary.penalty_obstacles.is_some() {
            self.clock.options.obstacle_stiffness_factor()
        } else {
            1.0
        };
        for k in 0..stress.len() {
            let index = first + k;
            let h = set.domain.as_slice().spacing(index, &ground);
            let density = set.points.mass[index] / set.points.volume[index];
            if set.rigid.is_some() {
                (moduli[k], viscosities[k]) = (0.0, 0.0);
            }
            let speed = (stiffening * moduli[k] / (self.clock.options.mass_scaling * density)).sqrt()
                + square(&set.points.velocity[index]).sqrt();
            let wave = LimitingPoint {
                dt: bounds.courant * h / speed,
                limit: StepLimit::ELASTIC_WAVE,
                set: number,
                index,
            };
            least = least.smaller(self.phase_limit(bounds, wave, moduli[k]));
            if viscosities[k] > 0.0 {
                // Explicit diffusion of momentum, sheet: mpm §2.10.
                let inertia = self.clock.options.mass_scaling * density;
                let dt = bounds.diffusion * inertia * h * h / viscosities[k];
                least = least.smaller(LimitingPoint { dt, limit: StepLimit::VISCOSITY, set: number, index });
            }
        }
        least
    }

    /// Returns all fields of the points, in the order of ids.
    pub(crate) fn collect_snapshot(&self) -> Snapshot {
        let mut order: Vec<(u32, usize, usize)> = Vec::new();
        for (number, set) in self.bodies.sets.iter().enumerate() {
            order.extend(set.points.id.iter().enumerate().map(|(index, &id)| (id, number, index)));
        }
        order.par_sort_unstable();
        let scalar = |value: &dyn Fn(&PointSet<D>, usize) -> f64| -> FieldData {
            FieldData::Scalar(order.iter().map(|&(_, s, i)| value(&self.bodies.sets[s], i)).collect())
        };
        let vector = |value: &dyn Fn(&PointSet<D>, usize) -> [f64; 3]| -> Vec<[f64; 3]> {
            order.iter().map(|&(_, s, i)| value(&self.bodies.sets[s], i)).collect()
        };
        let displacement = |set: &PointSet<D>, i: usize| -> [f64; 3] {
            spatial(&std::array::from_fn::<f64, D, _>(|c| {
                set.points.position[i][c] - set.points.origin[i][c]
            }))
        };
        let field = |name: &str, unit, data| Field { name: name.to_owned(), unit, data };
        let mut fields = vec![
            field("velocity", "m/s", FieldData::Vector(vector(&|s, i| spatial(&s.points.velocity[i])))),
            field("displacement", "m", FieldData::Vector(vector(&displacement))),
            field(
                "stress",
                "Pa",
                FieldData::Tensor(
                    order.iter().map(|&(_, s, i)| self.bodies.sets[s].points.stress[i]).collect(),
                ),
            ),
            field("pressure", "Pa", scalar(&|s, i| s.points.stress[i].pressure())),
            field("deviatoric_stress", "Pa", scalar(&|s, i| s.points.stress[i].q())),
            field("mass", "kg", scalar(&|s, i| s.points.mass[i] + s.liquid_mass(i))),
            field("volume", "m3", scalar(&|s, i| s.points.volume[i])),
            field(
                "density",
                "kg/m3",
                scalar(&|s, i| (s.points.mass[i] + s.liquid_mass(i)) / s.points.volume[i]),
            ),
        ];
        if self.bodies.sets.iter().any(|set| !set.points.seen.is_empty()) {
            let seen = vector(&|s, i| spatial(&Self::grid_velocity(s, i)));
            fields.push(field("grid_velocity", "m/s", FieldData::Vector(seen)));
        }
        fields.extend(self.pore_fields(&order));
        let bodies: Vec<LawPoints<'_>> = self.bodies.sets.iter().map(PointSet::law_points).collect();
        let places: Vec<(usize, usize)> = order.iter().map(|&(_, set, index)| (set, index)).collect();
        fields.extend(law_fields(&bodies, &places));
        let extents = |s: &PointSet<D>, i: usize| {
            spatial(&s.domain.as_slice().extent(i, &s.extent, self.background.grid.cell))
        };
        Snapshot {
            time: self.clock.time,
            step: self.clock.step,
            ids: order.iter().map(|&(id, ..)| u64::from(id)).collect(),
            bodies: order.iter().map(|&(_, s, _)| self.bodies.sets[s].body).collect(),
            positions: vector(&|s, i| spatial(&s.points.position[i])),
            extents: vector(&extents),
            fields,
        }
    }

    /// Totals over the points.
    pub(crate) fn collect_budget(&self) -> Budget {
        let mut budget = Budget::default();
        for set in &self.bodies.sets {
            let energies = stored_energies(set);
            if let Some(number) = set.rigid {
                let (rigid, mass) = (&self.boundary.driven[number].state.rigid, set.points.mass.iter().sum());
                rigid.add_rotation_energy(mass, set.extent[0], &mut budget);
            }
            for i in 0..set.len() {
                let (x, v, m) =
                    (spatial(&set.points.position[i]), spatial(&set.points.velocity[i]), set.points.mass[i]);
                budget.mass += m;
                budget.kinetic += 0.5 * m * square(&v);
                budget.elastic += energies[i];
                for c in 0..3 {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    budget.momentum[c] += m * v[c];
                    budget.angular_momentum[c] += m * (x[a] * v[b] - x[b] * v[a]);
                    budget.potential -= m * self.clock.gravity[c] * x[c];
                    if self.clock.options.transfer == crate::VelocityTransfer::Apic && a < D && b < D {
                        // Spin within the point.
                        let moment = &set.points.affine[i];
                        budget.angular_momentum[c] += m * (moment[b][a] - moment[a][b]);
                    }
                }
            }
        }
        budget.kinetic += affine_energies(&self.clock, &self.background, &self.bodies).iter().sum::<f64>();
        self.add_liquid(&mut budget);
        budget
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Whether no external work acts on the points and all their energy is recorded, which excludes scaled masses and springs of obstacles.
    pub(crate) fn is_energetically_closed(&self) -> bool {
        self.clock.options.mass_scaling <= 1.0
            && self.clock.case.obstacles.is_empty()
            && self.clock.case.is_isolated(self.clock.stage)
            && self.bodies.sets.iter().all(|set| set.law_points().defines_energy())
    }

    /// Starts the record of work, from the stored energy.
    pub(crate) fn start_work_count(&mut self) {
        for set in self.bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
            set.points.work = stored_energies(set);
        }
    }

    /// Energy dissipated since the start (J), of the points that remain.
    pub(crate) fn dissipated_energy(&self) -> f64 {
        let counted = self.bodies.sets.iter().filter(|set| !set.points.work.is_empty());
        let lost = counted.map(|set| {
            let stored = stored_energies(set);
            set.points.work.iter().zip(stored).map(|(work, stored)| work - stored).sum::<f64>()
        });
        lost.sum()
    }
}
