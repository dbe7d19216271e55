//! Pore-fluid part of snapshot and budget.

use colluvium_case::{Budget, Field, FieldData, PhaseBudget, StepLimit, spatial};
use colluvium_constitutive::SymTensor;

use crate::config::{StepCoefficients, StepCriterion};
use crate::output::report::LimitingPoint;
use crate::phases::pore_fluid::{PoreFluidConstants, critical_step, simple_steps};
use crate::points::point_set::PointSet;
use crate::points::vectors::square;
use crate::solver::MpmSolver;

impl<const D: usize> PointSet<D> {
    /// Porosity of a point; zero where it is dry.
    pub fn porosity(&self, point: usize) -> f64 {
        let fluid = self.pore.as_ref().and_then(|pore| pore.fluid);
        fluid.map_or(0.0, |fluid| {
            fluid.porosity_at(self.points.volume[point], self.points.initial_volume[point])
        })
    }

    /// Pore pressure of a point (Pa), zero where it is dry.
    pub fn pore_pressure(&self, point: usize) -> f64 {
        self.pore.as_ref().map_or(0.0, |pore| pore.points.pressure[point])
    }

    /// Effective stress of a point less its pore pressure (Pa).
    pub fn total_stress(&self, point: usize) -> SymTensor {
        self.points.stress[point] - SymTensor::isotropic(self.pore_pressure(point))
    }

    /// Mass of the pore fluid of a point (kg).
    pub fn liquid_mass(&self, point: usize) -> f64 {
        let fluid = self.pore.as_ref().and_then(|pore| pore.fluid);
        fluid.map_or(0.0, |fluid| {
            let n = fluid.porosity_at(self.points.volume[point], self.points.initial_volume[point]);
            n * fluid.density * self.points.volume[point]
        })
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Fields of the pore fluid, of points in the given order; NaN on dry ones. Empty where no body is saturated.
    pub(crate) fn pore_fields(&self, order: &[(u32, usize, usize)]) -> Vec<Field> {
        if self.two_phase.is_none() {
            return Vec::new();
        }
        let wet = |s: usize| self.bodies.sets[s].pore.as_ref().filter(|pore| pore.fluid.is_some());
        let pressure =
            |&(_, s, i): &(u32, usize, usize)| wet(s).map_or(f64::NAN, |pore| pore.points.pressure[i]);
        let velocity = |&(_, s, i): &(u32, usize, usize)| {
            wet(s).map_or([f64::NAN; 3], |pore| spatial(&pore.points.velocity[i]))
        };
        let porosity =
            |&(_, s, i): &(u32, usize, usize)| wet(s).map_or(f64::NAN, |_| self.bodies.sets[s].porosity(i));
        let total = |&(_, s, i): &(u32, usize, usize)| self.bodies.sets[s].total_stress(i);
        let field = |name: &str, unit, data| Field { name: name.to_owned(), unit, data };
        vec![
            field("pore_pressure", "Pa", FieldData::Scalar(order.iter().map(pressure).collect())),
            field("liquid_velocity", "m/s", FieldData::Vector(order.iter().map(velocity).collect())),
            field("porosity", "", FieldData::Scalar(order.iter().map(porosity).collect())),
            field("total_stress", "Pa", FieldData::Tensor(order.iter().map(total).collect())),
        ]
    }

    /// Step limit of a point from that of its skeleton's wave; with pore fluid that of both phases.
    #[inline]
    pub(crate) fn phase_limit(
        &self,
        bounds: StepCoefficients,
        wave: LimitingPoint,
        modulus: f64,
    ) -> LimitingPoint {
        let (set, i) = (&self.bodies.sets[wave.set], wave.index);
        let Some(fluid) = set.pore.as_ref().and_then(|pore| pore.fluid) else { return wave };
        let (n, dry) = (set.porosity(i), set.points.mass[i] / set.points.volume[i]);
        let h = set.domain.as_slice().spacing(i, &self.background.grid_view());
        // In time over the root of the scale of inertia the equations are the unscaled ones, with a weaker drag.
        let scale = self.clock.options.mass_scaling.sqrt();
        // Obstacles on points have the same springs for fluid and skeleton.
        let stiffening = if self.boundary.penalty_obstacles.is_some() {
            self.clock.options.obstacle_stiffness_factor()
        } else {
            1.0
        };
        let (modulus, bulk_modulus) = (stiffening * modulus, stiffening * fluid.bulk_modulus);
        let scaled = PoreFluidConstants { resistance: fluid.resistance / scale, bulk_modulus, ..fluid };
        let moving =
            |step: f64| bounds.courant / (1.0 / (scale * step) + square(&set.points.velocity[i]).sqrt() / h);
        let (dt, by_drag) = match self.clock.options.step_criterion {
            StepCriterion::Combined => {
                let (step, by_drag) = critical_step(&scaled, n, dry, modulus, h);
                (moving(step), by_drag)
            }
            StepCriterion::Simple => {
                let [step, drag] = simple_steps(&scaled, n, dry, modulus, h);
                let (dt, drag) = (moving(step), scale * drag);
                (dt.min(drag), drag < dt)
            }
        };
        LimitingPoint {
            dt,
            limit: if by_drag { StepLimit::SEEPAGE_DRAG } else { StepLimit::ELASTIC_WAVE },
            ..wave
        }
    }

    /// Adds the pore fluid to the totals.
    pub(crate) fn add_liquid(&self, budget: &mut Budget) {
        if self.two_phase.is_none() {
            return;
        }
        let mut liquid = PhaseBudget::default();
        for set in &self.bodies.sets {
            let Some(pore) = &set.pore else { continue };
            let Some(fluid) = pore.fluid else { continue };
            for i in 0..set.len() {
                let (x, v, m) =
                    (spatial(&set.points.position[i]), spatial(&pore.points.velocity[i]), set.liquid_mass(i));
                liquid.mass += m;
                liquid.kinetic += 0.5 * m * square(&v);
                let volume = set.porosity(i) * set.points.volume[i];
                liquid.elastic += 0.5 * pore.points.pressure[i].powi(2) / fluid.bulk_modulus * volume;
                for c in 0..3 {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    liquid.momentum[c] += m * v[c];
                    budget.angular_momentum[c] += m * (x[a] * v[b] - x[b] * v[a]);
                    liquid.potential -= m * self.clock.gravity[c] * x[c];
                }
            }
        }
        budget.mass += liquid.mass;
        budget.kinetic += liquid.kinetic;
        budget.elastic += liquid.elastic;
        budget.potential += liquid.potential;
        for c in 0..3 {
            budget.momentum[c] += liquid.momentum[c];
        }
        budget.liquid = Some(liquid);
    }
}
