//! Output of the solver: fields, totals, scalar outputs.

use colluvium_case::measure::ScalarOutput;
use colluvium_case::{Budget, FieldList, Frame, FrameRequest, Reaction, Snapshot, spatial};
use colluvium_constitutive::SymTensor;

use crate::momentum::applied_forces::applied_forces;
use crate::output::packing_view::PackingView;
use crate::points::grains::{Grains, volume};
use crate::points::vector::{add, difference, dot};

/// Names of the components of an orientation in space.
const QUATERNION: [&str; 4] = ["orientation_w", "orientation_x", "orientation_y", "orientation_z"];

/// Grain indices in the order of ids.
struct IdOrder {
    indices: Vec<usize>,
}

impl IdOrder {
    /// Order of the grains by their ids.
    fn new<const D: usize, const R: usize>(grains: &Grains<D, R>) -> Self {
        let mut indices: Vec<usize> = (0..grains.len()).collect();
        indices.sort_unstable_by_key(|&i| grains.id[i]);
        Self { indices }
    }

    /// Numbers of a quantity.
    fn scalars(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        self.indices.iter().map(|&i| value(i)).collect()
    }

    /// Spatial vectors of a quantity.
    fn vectors<const N: usize>(&self, value: impl Fn(usize) -> [f64; N]) -> Vec<[f64; 3]> {
        self.indices.iter().map(|&i| spatial(&value(i))).collect()
    }
}

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Velocity at the time of the positions, extrapolated from half a step earlier (m/s).
    fn velocity(&self, i: usize, (gravity, applied): (&[f64; D], &[[f64; D]]), ahead: f64) -> [f64; D] {
        let g = &self.grains;
        if g.is_held[i] {
            return g.velocity[i];
        }
        let mut v: [f64; D] =
            std::array::from_fn(|c| g.velocity[i][c] + ahead * (g.force[i][c] / g.mass[i] + gravity[c]));
        if let Some(applied) = applied.get(i) {
            add(&mut v, ahead / g.mass[i], applied);
        }
        v
    }

    /// Spin of a grain after a further time `ahead` (s) under its present moment (rad/s).
    fn spin(&self, i: usize, ahead: f64) -> [f64; R] {
        let g = &self.grains;
        if g.is_held[i] {
            return g.spin[i];
        }
        std::array::from_fn(|c| g.spin[i][c] + ahead * g.torque[i][c] / g.inertia(i))
    }

    /// Grains with the wanted fields, in the order of ids.
    pub(crate) fn collect_snapshot(&self, wanted: FrameRequest<'_>) -> Snapshot {
        let g = self.grains;
        let order = IdOrder::new(g);
        let mut fields = FieldList::new(wanted);
        let needs_contacts = ["stress", "pressure", "contacts"].iter().any(|name| fields.includes(name));
        let (stresses, contacts) = if needs_contacts { self.grain_stresses() } else { Default::default() };
        self.add_motion_fields(&order, &stresses, &mut fields);
        self.add_grain_fields(&order, &contacts, &mut fields);
        if g.is_held.contains(&true) {
            fields.scalar("held", "", || order.scalars(|i| f64::from(u8::from(g.is_held[i]))));
        }
        if self.clock.options.voronoi {
            self.add_cell_fields(&order, &mut fields);
        }
        if !g.orientation.is_empty() {
            let component = |c: usize| order.scalars(|i| g.orientation[i][c]);
            match R {
                1 => fields.scalar("orientation", "rad", || component(0)),
                _ => (0..4).for_each(|c| fields.scalar(QUATERNION[c], "", || component(c))),
            }
        }
        let indices = || order.indices.iter();
        Snapshot {
            time: self.clock.time,
            step: self.clock.step,
            ids: indices().map(|&i| u64::from(g.id[i])).collect(),
            bodies: indices().map(|&i| g.body[i]).collect(),
            positions: order.vectors(|i| g.position[i]),
            extents: order.vectors(|i| [2.0 * g.radius[i]; D]),
            fields: fields.into_fields(),
        }
    }

    /// Adds velocities, displacements and stresses of the grains.
    fn add_motion_fields(&self, order: &IdOrder, stresses: &[SymTensor], fields: &mut FieldList<'_>) {
        let g = self.grains;
        fields.vector("velocity", "m/s", || {
            let applied = applied_forces(self.clock, g, &self.boundary.membranes);
            let accelerations = (&self.clock.gravity_at(0.0), applied.as_slice());
            order.vectors(|i| self.velocity(i, accelerations, self.half_step()))
        });
        fields.vector("displacement", "m", || order.vectors(|i| difference(&g.position[i], &g.origin[i])));
        let mean = |i: usize| -stresses[i].0[..D].iter().sum::<f64>() / D as f64;
        fields.tensor("stress", "Pa", || order.indices.iter().map(|&i| stresses[i]).collect());
        fields.scalar("pressure", "Pa", || order.scalars(mean));
    }

    /// Adds the quantities that each grain has.
    fn add_grain_fields(&self, order: &IdOrder, contacts: &[f64], fields: &mut FieldList<'_>) {
        let g = self.grains;
        fields.scalar("mass", "kg", || order.scalars(|i| g.mass[i]));
        fields.scalar("volume", "m3", || order.scalars(|i| volume(D, g.radius[i])));
        fields.scalar("density", "kg/m3", || order.scalars(|i| g.mass[i] / volume(D, g.radius[i])));
        fields.scalar("radius", "m", || order.scalars(|i| g.radius[i]));
        match R {
            1 => fields.scalar("spin", "rad/s", || order.scalars(|i| self.spin(i, self.half_step())[0])),
            _ => fields.vector("spin", "rad/s", || order.vectors(|i| self.spin(i, self.half_step()))),
        }
        fields.vector("force", "N", || order.vectors(|i| g.force[i]));
        fields.scalar("contacts", "", || order.scalars(|i| contacts[i]));
        fields.scalar("kind", "", || order.scalars(|i| f64::from(g.kind[i])));
    }

    /// Time from the velocities to the positions (s).
    fn half_step(&self) -> f64 {
        0.5 * self.clock.last_step
    }

    /// Adds the fields of the Laguerre tessellation; none in space.
    fn add_cell_fields(&self, order: &IdOrder, fields: &mut FieldList<'_>) {
        let names = ["cell_area", "cell_solid_fraction", "cell_of_surface"];
        if !names.iter().any(|name| fields.includes(name)) {
            return;
        }
        let (g, cells) = (self.grains, self.tessellation());
        if cells.area.is_empty() {
            return;
        }
        let solid_fraction = |i: usize| volume(D, g.radius[i]) / cells.area[i];
        fields.scalar("cell_area", "m2", || order.scalars(|i| cells.area[i]));
        fields.scalar("cell_solid_fraction", "", || order.scalars(solid_fraction));
        let is_surface = |i: usize| f64::from(u8::from(cells.surface[i]));
        fields.scalar("cell_of_surface", "", || order.scalars(is_surface));
    }

    /// Output frame with the grains and the data sets that the case requests.
    pub(crate) fn collect_frame(&self, wanted: FrameRequest<'_>) -> Frame {
        let mut frame = Frame::from(self.collect_snapshot(wanted));
        if wanted == FrameRequest::Requested {
            frame.datasets.extend(self.clock.case.lattice().map(|nodes| self.coarse_grained_dataset(nodes)));
            frame.datasets.extend(self.clock.case.output.contacts.then(|| self.contacts_dataset()));
            let lists_broken = self.clock.case.output.contacts && !self.records.broken_bonds.is_empty();
            frame.datasets.extend(lists_broken.then(|| self.broken_bonds_dataset()));
        }
        frame
    }

    /// Totals at the time of the last forces, a step before the positions.
    pub(crate) fn collect_budget(&self) -> Budget {
        let g = &self.grains;
        let mut budget = Budget::default();
        let (gravity, applied) =
            (self.clock.gravity_at(0.0), applied_forces(self.clock, self.grains, &self.boundary.membranes));
        let accelerations = (&gravity, applied.as_slice());
        let (behind, reach) = (-0.5 * self.clock.last_step, spatial(&self.clock.case.gravity));
        for i in 0..g.len() {
            let m = g.mass[i];
            budget.mass += m;
            let then: [f64; D] =
                std::array::from_fn(|c| g.position[i][c] - self.clock.last_step * g.velocity[i][c]);
            let (x, v) = (spatial(&then), spatial(&self.velocity(i, accelerations, behind)));
            let mut turn = [x[1] * v[2] - x[2] * v[1], x[2] * v[0] - x[0] * v[2], x[0] * v[1] - x[1] * v[0]];
            turn.iter_mut().for_each(|component| *component *= m);
            let (spin, inertia) = (self.spin(i, behind), g.inertia(i));
            for c in 0..R {
                turn[3 - R + c] += inertia * spin[c];
            }
            for c in 0..3 {
                budget.momentum[c] += m * v[c];
                budget.angular_momentum[c] += turn[c];
                budget.potential -= m * reach[c] * x[c];
            }
        }
        if self.clock.step == 0 {
            let (kinetic, elastic) = self.energies();
            (budget.kinetic, budget.elastic) = (kinetic, elastic);
        } else {
            budget.kinetic = self.records.energy_balance.kinetic + self.records.energy_balance.rotation;
            budget.elastic = self.records.energy_balance.recoverable();
        }
        budget
    }

    /// Force of the grains on a body with prescribed motion (N).
    pub(crate) fn reaction_of_body(&self, name: &str) -> Option<Reaction> {
        let body = self.clock.case.bodies.iter().position(|body| body.name == name)? as u32;
        let mut force = [0.0; D];
        for i in (0..self.grains.len()).filter(|&i| self.grains.body[i] == body && self.grains.is_held[i]) {
            add(&mut force, 1.0, &self.grains.force[i]);
        }
        Some(Reaction { force: spatial(&force), impulse: [f64::NAN; 3], moment: None })
    }

    /// Kinetic and elastic energy at present (J).
    fn energies(&self) -> (f64, f64) {
        let g = &self.grains;
        let free = (0..g.len()).filter(|&i| !g.is_held[i]);
        let of = |i: usize| {
            0.5 * g.mass[i] * dot(&g.velocity[i], &g.velocity[i])
                + 0.5 * g.inertia(i) * dot(&g.spin[i], &g.spin[i])
        };
        let mut elastic = 0.0;
        self.for_each_contact(|_, _, energies| {
            elastic += energies.elastic
                + energies.elastic_tangential
                + energies.elastic_rolling
                + energies.elastic_bonds;
        });
        (free.map(of).sum(), elastic)
    }

    /// Scalar outputs besides the totals.
    pub(crate) fn collect_scalar_outputs(&self) -> Vec<ScalarOutput> {
        let mut outputs = self.records.energy_balance.scalar_outputs();
        let mut read = |name: &str, unit: &str, value: f64| {
            outputs.push((name.to_owned(), unit.to_owned(), value));
        };
        let count = self.grains.is_held.iter().filter(|held| !**held).count() as f64;
        read("coordination", "", 2.0 * self.records.energy_balance.contacts[0] as f64 / count);
        if self.clock.options.voronoi {
            read("inner_solid_fraction", "", self.inner_solid_fraction());
        }
        if self.cell.geometry.is_periodic() {
            let grains: f64 = self.grains.radius.iter().map(|r| volume(D, *r)).sum();
            let stress = self.cell.stress();
            read("solid_fraction", "", grains / self.cell.geometry.volume());
            let axes = ["x", "y", "z"];
            for i in 0..D {
                for j in i..D {
                    let name = format!("cell_stress.{}{}", axes[i], axes[j]);
                    read(&name, "Pa", 0.5 * (stress[i][j] + stress[j][i]));
                }
            }
            for i in 0..D {
                read(&format!("cell.{}", axes[i]), "m", self.cell.geometry.h[i][i]);
            }
        }
        outputs.extend(self.boundary.servo_outputs(self.clock, &self.cell.geometry, self.grains));
        outputs.extend(self.boundary.membranes.scalar_outputs(self.clock, self.grains, &self.boundary.walls));
        outputs.extend(self.fabric_outputs());
        outputs.extend(self.chain_outputs());
        outputs.extend(self.region_outputs());
        outputs
    }

    /// Mean unbalanced force over the mean contact force (Ng 2006; sheet: dem §3.1).
    pub(crate) fn unbalanced_ratio(&self) -> f64 {
        let free = self.grains.is_held.iter().filter(|held| !**held).count() as f64;
        let [grains, contacts] = self.records.energy_balance.squares;
        if grains == 0.0 {
            return 0.0;
        }
        if contacts == 0.0 {
            return f64::INFINITY;
        }
        (grains / free).sqrt() / (contacts / self.records.energy_balance.contacts[0] as f64).sqrt()
    }
}
