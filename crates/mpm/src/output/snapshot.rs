//! Fields of the points in frames.

use colluvium_case::bodies::law_points::{LawPoints, law_fields};
use colluvium_case::{Field, FieldData, Snapshot, spatial};
use rayon::prelude::*;

use crate::points::point_set::PointSet;
use crate::solver::MpmSolver;

impl<const D: usize> MpmSolver<D> {
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
        if self.bodies.sets.iter().any(|set| !set.points.grid_velocity.is_empty()) {
            let grid_velocity = vector(&|s, i| spatial(&s.grid_velocity(i)));
            fields.push(field("grid_velocity", "m/s", FieldData::Vector(grid_velocity)));
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

    /// Fields of the pore fluid for points in the given order; NaN for dry points. Empty where no body is saturated.
    fn pore_fields(&self, order: &[(u32, usize, usize)]) -> Vec<Field> {
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
}
