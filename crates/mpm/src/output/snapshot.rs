//! Fields of the points in frames.

use colluvium_case::bodies::law_points::{LawPoints, law_fields};
use colluvium_case::{FieldList, FrameRequest, Snapshot, spatial};
use rayon::prelude::*;

use crate::points::point_set::PointSet;
use crate::solver::MpmSolver;

impl<const D: usize> MpmSolver<D> {
    /// Points with the wanted fields, in the order of ids.
    pub(crate) fn collect_snapshot(&self, wanted: FrameRequest<'_>) -> Snapshot {
        let mut order: Vec<(u32, usize, usize)> = Vec::new();
        for (number, set) in self.bodies.sets.iter().enumerate() {
            order.extend(set.points.id.iter().enumerate().map(|(index, &id)| (id, number, index)));
        }
        order.par_sort_unstable();
        let scalar = |value: &dyn Fn(&PointSet<D>, usize) -> f64| -> Vec<f64> {
            order.iter().map(|&(_, s, i)| value(&self.bodies.sets[s], i)).collect()
        };
        let vector = |value: &dyn Fn(&PointSet<D>, usize) -> [f64; 3]| -> Vec<[f64; 3]> {
            order.iter().map(|&(_, s, i)| value(&self.bodies.sets[s], i)).collect()
        };
        let displacement = |set: &PointSet<D>, i: usize| -> [f64; 3] {
            spatial(&std::array::from_fn::<f64, D, _>(|c| {
                set.points.position[i][c] - set.points.origin[i][c]
            }))
        };
        let stress = || order.iter().map(|&(_, s, i)| self.bodies.sets[s].points.stress[i]).collect();
        let mass = |s: &PointSet<D>, i: usize| s.points.mass[i] + s.liquid_mass(i);
        let mut fields = FieldList::new(wanted);
        fields.vector("velocity", "m/s", || vector(&|s, i| spatial(&s.points.velocity[i])));
        fields.vector("displacement", "m", || vector(&displacement));
        fields.tensor("stress", "Pa", stress);
        fields.scalar("pressure", "Pa", || scalar(&|s, i| s.points.stress[i].pressure()));
        fields.scalar("deviatoric_stress", "Pa", || scalar(&|s, i| s.points.stress[i].q()));
        fields.scalar("mass", "kg", || scalar(&mass));
        fields.scalar("volume", "m3", || scalar(&|s, i| s.points.volume[i]));
        fields.scalar("density", "kg/m3", || scalar(&|s, i| mass(s, i) / s.points.volume[i]));
        if self.bodies.sets.iter().any(|set| !set.points.grid_velocity.is_empty()) {
            fields.vector("grid_velocity", "m/s", || vector(&|s, i| spatial(&s.grid_velocity(i))));
        }
        self.add_pore_fields(&order, &mut fields);
        let bodies: Vec<LawPoints<'_>> = self.bodies.sets.iter().map(PointSet::law_points).collect();
        let places: Vec<(usize, usize)> = order.iter().map(|&(_, set, index)| (set, index)).collect();
        fields.extend(law_fields(&bodies, &places, wanted));
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
            fields: fields.into_fields(),
        }
    }

    /// Adds fields of the pore fluid for points in the given order; NaN for dry points. None where no body is saturated.
    fn add_pore_fields(&self, order: &[(u32, usize, usize)], fields: &mut FieldList<'_>) {
        if self.two_phase.is_none() {
            return;
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
        fields.scalar("pore_pressure", "Pa", || order.iter().map(pressure).collect());
        fields.vector("liquid_velocity", "m/s", || order.iter().map(velocity).collect());
        fields.scalar("porosity", "", || order.iter().map(porosity).collect());
        fields.tensor("total_stress", "Pa", || order.iter().map(total).collect());
    }
}
