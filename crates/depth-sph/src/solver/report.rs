//! Output of the solver: snapshot, budget, scalar readings.

use colluvium_case::measure::ScalarOutput;
use colluvium_case::{Budget, Field, FieldData, PhaseBudget, PlanRaster, Snapshot};
use colluvium_constitutive::SymTensor;

use crate::bed::BedPoint;
use crate::config::choices::{DepthFrame, Phases};
use crate::flow::{PhaseSet, PhaseTotals};
use crate::phases::phase_nodes::dot;
use crate::solver::DepthSolver;

fn scalar(name: &str, unit: &'static str, values: Vec<f64>) -> Field {
    Field { name: name.to_owned(), unit, data: FieldData::Scalar(values) }
}

/// Vector along the bed: its plan components and the rise over a slope.
fn along_bed<const D: usize>(v: &[f64; D], slope: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|c| match c.cmp(&D) {
        std::cmp::Ordering::Less => v[c],
        std::cmp::Ordering::Equal => dot(v, slope),
        std::cmp::Ordering::Greater => 0.0,
    })
}

impl<const D: usize> DepthSolver<D> {
    /// Set and index of every node, in the order of ids.
    fn in_order(&self) -> Vec<(usize, usize)> {
        let sets = self.flow.sets.iter().enumerate();
        let mut order: Vec<(usize, usize)> =
            sets.flat_map(|(set, nodes)| (0..nodes.len()).map(move |i| (set, i))).collect();
        order.sort_by_key(|&(set, i)| self.flow.sets[set].nodes.id[i]);
        order
    }

    /// Snapshot of all nodes, in the order of ids.
    pub(crate) fn collect_snapshot(&self) -> Snapshot {
        let flow = &self.flow;
        let order = self.in_order();
        let nodes = |set: usize| &flow.sets[set].nodes;
        let beds: Vec<_> = order.iter().map(|&(set, i)| flow.bed_below(&nodes(set).position[i])).collect();
        let place = |(&(set, i), level): (&(usize, usize), f64)| {
            let x = &nodes(set).position[i];
            std::array::from_fn(|c| match c.cmp(&D) {
                std::cmp::Ordering::Less => x[c],
                std::cmp::Ordering::Equal => level + 0.5 * nodes(set).depth[i],
                std::cmp::Ordering::Greater => 0.0,
            })
        };
        let extent = |&(set, i): &(usize, usize)| -> [f64; 3] {
            let width = (nodes(set).volume[i] / nodes(set).partial_thickness[i]).powf(1.0 / D as f64);
            std::array::from_fn(|c| match c.cmp(&D) {
                std::cmp::Ordering::Less => width,
                std::cmp::Ordering::Equal => nodes(set).depth[i],
                std::cmp::Ordering::Greater => 0.0,
            })
        };
        Snapshot {
            time: self.time,
            step: self.steps,
            ids: order.iter().map(|&(set, i)| nodes(set).id[i]).collect(),
            bodies: order.iter().map(|&(set, i)| nodes(set).body[i]).collect(),
            positions: order.iter().zip(beds.iter().map(|bed| bed.level)).map(place).collect(),
            extents: order.iter().map(extent).collect(),
            fields: self.fields(&order, &beds),
        }
    }

    /// Fields of the nodes in `order`, over the `beds` below them.
    fn fields(&self, order: &[(usize, usize)], beds: &[BedPoint<D>]) -> Vec<Field> {
        let flow = &self.flow;
        let nodes = |set: usize| &flow.sets[set].nodes;
        let each =
            |value: &dyn Fn(usize, usize) -> f64| order.iter().map(|&(set, i)| value(set, i)).collect();
        let stress = |&(set, i): &(usize, usize)| {
            // Half of the pressure at the base: the mean over the depth, taken isotropic.
            let mean =
                -0.5 * flow.density_over(set, i) * nodes(set).effective_gravity[i] * nodes(set).depth[i];
            SymTensor([mean, mean, mean, 0.0, 0.0, 0.0])
        };
        let velocity = order
            .iter()
            .zip(beds)
            .map(|(&(set, i), bed)| along_bed(&nodes(set).velocity[i], &bed.slope))
            .collect();
        let displacement = order
            .iter()
            .map(|&(set, i)| {
                let (x, origin) = (&nodes(set).position[i], &nodes(set).origin[i]);
                let moved: [f64; D] = std::array::from_fn(|c| x[c] - origin[c]);
                along_bed(&moved, &[0.0; D])
            })
            .collect();
        let stresses = order.iter().map(stress).collect();
        let mut fields = vec![
            scalar("depth", "m", each(&|set, i| nodes(set).depth[i])),
            Field { name: "velocity".into(), unit: "m/s", data: FieldData::Vector(velocity) },
            Field { name: "displacement".into(), unit: "m", data: FieldData::Vector(displacement) },
            Field { name: "stress".into(), unit: "Pa", data: FieldData::Tensor(stresses) },
            scalar("mass", "kg", each(&|set, i| flow.density(set) * nodes(set).volume[i])),
            scalar("volume", "m3", each(&|set, i| nodes(set).volume[i])),
            scalar("bed", "m", beds.iter().map(|bed| bed.level).collect()),
            scalar("smoothing_length", "m", each(&|set, i| nodes(set).length[i])),
        ];
        if flow.sets.len() > 1 {
            fields.push(scalar("phase", "", each(&|set, _| set as f64)));
            fields.push(scalar("height", "m", each(&|set, i| nodes(set).partial_thickness[i])));
        }
        fields.extend(self.fields_of_columns(order));
        if !(flow.inflows.is_empty() && flow.open_boundaries.is_empty()) {
            let outside = |set: usize, i: usize| f64::from(u8::from(flow.is_outside(nodes(set).id[i])));
            fields.push(scalar("outside", "", each(&outside)));
        }
        if flow.settings.zones.iter().any(|zone| zone.erosion.is_some()) {
            fields.push(scalar("eroded", "m3", each(&|set, i| nodes(set).eroded[i])));
        }
        fields
    }

    /// Pore pressures of the nodes in `order`, where there are columns.
    fn fields_of_columns(&self, order: &[(usize, usize)]) -> Vec<Field> {
        let flow = &self.flow;
        if flow.pore_columns.is_empty() {
            return Vec::new();
        }
        let nodes = |set: usize| &flow.sets[set].nodes;
        let each =
            |value: &dyn Fn(usize, usize) -> f64| order.iter().map(|&(set, i)| value(set, i)).collect();
        let head = |set: usize, i: usize| if set == 0 { flow.pore_columns.base(i) } else { f64::NAN };
        let excess = |set: usize, i: usize| flow.submerged(set, i) * nodes(set).bearing[i] * head(set, i);
        let mean = |set: usize, i: usize| {
            let head = if set == 0 { flow.pore_columns.mean(i) } else { f64::NAN };
            flow.submerged(set, i) * nodes(set).bearing[i] * head
        };
        let fluid = flow.settings.material.densities.fluid;
        let whole =
            |set: usize, i: usize| excess(set, i) + fluid * nodes(set).bearing[i] * nodes(set).depth[i];
        vec![
            scalar("liquefaction", "", each(&|set, i| head(set, i) / nodes(set).depth[i])),
            scalar("excess_pore_pressure", "Pa", each(&excess)),
            scalar("mean_excess_pore_pressure", "Pa", each(&mean)),
            scalar("pore_pressure", "Pa", each(&whole)),
        ]
    }

    /// Totals of mass, momentum and energy.
    pub(crate) fn collect_budget(&self) -> Budget {
        let spatial = |totals: &PhaseTotals<D>| {
            let mut momentum = along_bed(&totals.momentum, &[0.0; D]);
            momentum[D] = totals.vertical_momentum;
            momentum
        };
        let all: Vec<PhaseTotals<D>> = (0..self.flow.sets.len()).map(|set| self.flow.totals(set)).collect();
        let sum = |value: &dyn Fn(&PhaseTotals<D>) -> f64| all.iter().map(value).sum();
        let momentum = std::array::from_fn(|c| all.iter().map(|t| spatial(t)[c]).sum());
        let liquid = all.get(1).filter(|_| self.flow.settings.phases == Phases::Two).map(|t| PhaseBudget {
            mass: t.mass,
            momentum: spatial(t),
            kinetic: t.kinetic,
            elastic: 0.0,
            potential: t.potential,
        });
        Budget {
            mass: sum(&|t| t.mass),
            momentum,
            angular_momentum: [f64::NAN; 3],
            kinetic: sum(&|t| t.kinetic),
            elastic: 0.0,
            potential: sum(&|t| t.potential),
            liquid,
        }
    }

    /// Energy balance (J): energies of bed and pressure, dissipation, inflow, and the error.
    fn energies(&self) -> [(&'static str, f64); 7] {
        let (account, ledger) = (self.flow.energy_balance_summary(), &self.flow.energy_balance);
        [
            ("energy_bed", account.now.bed),
            ("energy_pressure", account.now.pressure),
            ("energy_friction", ledger.friction),
            ("energy_viscosity", ledger.viscosity),
            ("energy_entered", ledger.entered),
            ("energy_error", account.error),
            ("pressure_work_difference", account.difference),
        ]
    }

    /// Scalar outputs of the method in each row of the measures.
    pub(crate) fn collect_scalar_outputs(&self) -> Vec<ScalarOutput> {
        let flow = &self.flow;
        let nodes = || flow.sets.iter().flat_map(|set| (0..set.len()).map(move |i| (&set.nodes, i)));
        let most = |value: &dyn Fn(&crate::phases::phase_nodes::PhaseNodes<D>, usize) -> f64| {
            nodes().map(|(nodes, i)| value(nodes, i)).fold(0.0, f64::max)
        };
        let reading = |name: &str, unit: &str, value: f64| (name.to_owned(), unit.to_owned(), value);
        let mut readings = vec![
            reading("flow_volume", "m3", {
                let whole: f64 = flow.sets.iter().map(|set| set.nodes.total_volume()).sum();
                whole - flow.waiting_volume()
            }),
            reading("volume_left", "m3", {
                let left: f64 = flow.outflow_volume.iter().sum();
                if flow.open_boundaries.is_empty() { left } else { left + flow.passed() }
            }),
            reading("largest_depth", "m", most(&|nodes, i| nodes.depth[i])),
            reading("largest_speed", "m/s", {
                let along_bed = |set: &PhaseSet<D>| {
                    let speed = |i: usize| set.bed[i].speed(&set.nodes.velocity[i]);
                    (0..set.len()).map(speed).fold(0.0, f64::max)
                };
                flow.sets.iter().map(along_bed).fold(0.0, f64::max)
            }),
            reading("stopped", "s", self.rest.stopped),
        ];
        readings.extend(self.energies().map(|(name, value)| reading(name, "J", value)));
        if let Some([most, mean]) = self.departure {
            readings.push(reading("bed_off_raster", "m", most));
            readings.push(reading("bed_off_raster_rms", "m", mean));
        }
        if !flow.inflows.is_empty() || flow.open_boundaries.iter().any(crate::flow::OpenBoundary::has_inlet) {
            readings.push(reading("volume_entered", "m3", flow.entered()));
            if flow.settings.phases == Phases::Two {
                readings.push(reading("fluid_entered", "m3", flow.fluid_entered()));
            }
        }
        if flow.settings.zones.iter().any(|zone| zone.erosion.is_some()) {
            readings.push(reading("volume_eroded", "m3", flow.entrained.iter().sum()));
        }
        if let Some(worn) = flow.erodible_bed() {
            readings.push(reading("deepest_erosion", "m", worn.eroded_depths().fold(0.0, f64::max)));
        }
        if let Some(areas) =
            self.hazard_rasters.as_ref().and_then(crate::output::hazard_rasters::HazardRasters::score)
        {
            let names = ["mapped_hit", "mapped_missed", "mapped_beyond"];
            readings.extend(names.iter().zip(areas).map(|(name, area)| reading(name, "m2", area)));
            readings.push(reading("mapped_fit", "", areas[0] / areas.iter().sum::<f64>()));
        }
        if !flow.pore_columns.is_empty() {
            let (mut weighted, mut whole) = (0.0, 0.0);
            let solid = &flow.sets[0].nodes;
            for i in (0..solid.len()).filter(|i| !flow.is_outside(solid.id[*i])) {
                weighted += solid.volume[i] * flow.pore_columns.base(i) / solid.depth[i];
                whole += solid.volume[i];
            }
            readings.push(reading("mean_liquefaction", "", weighted / whole));
        }
        readings
    }

    /// Rasters over the plan, where the case has them.
    pub(crate) fn collect_rasters(&self) -> Vec<PlanRaster> {
        let Some(maps) = &self.hazard_rasters else { return Vec::new() };
        let normal = self.flow.settings.frame == DepthFrame::BedFitted;
        let all = maps.rasters(&self.flow, if normal { "normal" } else { "vertical" });
        all.into_iter().map(|(name, unit, raster)| PlanRaster { name, unit, raster }).collect()
    }

    /// Warnings about the state at the end of the run.
    pub(crate) fn warnings_at_end(&self) -> Vec<String> {
        let flow = &self.flow;
        let mut remarks = Vec::new();
        if flow.removed_nodes > 0 {
            remarks.push(format!(
                "{} nodes with a volume of {:.4e} m³ have left the terrain and were removed. If this \
                 volume matters, make the terrain larger",
                flow.removed_nodes,
                flow.outflow_volume.iter().sum::<f64>()
            ));
        }
        if self.hazard_rasters.as_ref().is_some_and(crate::output::hazard_rasters::HazardRasters::are_empty) {
            let threshold = self.case.output.rasters.as_ref().map_or(0.0, |rasters| rasters.threshold);
            remarks.push(format!(
                "output.rasters.threshold: the flow was less than {threshold} m deep in all cells, so the \
                 rasters are empty"
            ));
        }
        let account = flow.energy_balance_summary();
        if account.is_off() {
            let cure = match (self.departure.is_some(), flow.settings.numerics.variable_length) {
                (true, true) => {
                    "set `variable_smoothing` to false, increase `terrain_smoothing` or reduce `spacing`"
                }
                (true, false) => "increase `terrain_smoothing` or reduce `spacing`",
                (false, true) => "set `variable_smoothing` to false, or `momentum` to `variational`",
                (false, false) => "set `momentum` to `variational`, or reduce `spacing`",
            };
            remarks.push(format!(
                "the computation has {} {:.2e} J by numerical error, {:.1} % of the {:.2e} J that the flow \
                 has exchanged (column energy_error of the measures). To reduce the error, {cure}",
                if account.error > 0.0 { "gained" } else { "lost" },
                account.error.abs(),
                100.0 * account.error.abs() / account.exchanged,
                account.exchanged
            ));
        }
        if self.rest.stopped.is_nan() {
            remarks.push(
                "the flow still moves at the end of the run: the criterion of methods.depth-sph.stop is \
                 not met"
                    .to_owned(),
            );
        }
        remarks
    }
}
