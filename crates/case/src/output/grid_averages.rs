//! Averages of the fields of points on a regular grid, for iso-surfaces and volume rendering (sheet: mpm §3.9).

use colluvium_constitutive::SymTensor;

use crate::description::Space;
use crate::{Case, Dataset, DatasetGeometry, Field, FieldData, FieldRole, Lattice, Snapshot};

/// Name of the field of mass per volume of space.
const DENSITY: &str = "density";

/// Part of the mass of a point that a node receives (kg).
struct NodeShare {
    point: usize,
    node: usize,
    mass: f64,
}

/// Nodes of a regular grid over the domain of a case, one cell apart.
struct AveragingNodes {
    low: [f64; 3],
    cell: f64,
    count: [usize; 3],
    dimension: usize,
}

/// Averages of a frame at the nodes of a regular grid over the domain: `density` (kg/m³ of space) and mass-weighted averages of fields. The
/// weights are linear, and points outside the domain do not count. The two ends of a periodic axis are one.
pub fn averages(case: &Case, cell: f64, snapshot: &Snapshot, only: Option<&[String]>) -> Dataset {
    let nodes = lattice(case, cell);
    let Lattice { low, count, .. } = nodes;
    let frame = AveragingNodes { low, cell, count, dimension: case.dimension() };
    let shares = frame.node_shares(snapshot);
    let periodic: Vec<usize> = case.domain.periodic.iter().map(|axis| axis.number()).collect();
    let mass = frame.sums(&shares, 1, |_, _| 1.0, &periodic);
    let mean = |components: usize, value: &dyn Fn(usize, usize) -> f64| {
        let mut sums = frame.sums(&shares, components, value, &periodic);
        for (values, mass) in sums.chunks_exact_mut(components).zip(&mass) {
            values.iter_mut().for_each(|value| *value = if *mass > 0.0 { *value / mass } else { 0.0 });
        }
        sums
    };
    let average = |field: &Field| {
        let data = match &field.data {
            FieldData::Integer(values) => FieldData::Scalar(mean(1, &|point, _| values[point] as f64)),
            FieldData::Scalar(values) => FieldData::Scalar(mean(1, &|point, _| values[point])),
            FieldData::Vector(values) => {
                FieldData::Vector(mean(3, &|point, c| values[point][c]).as_chunks().0.to_vec())
            }
            FieldData::Tensor(values) => {
                let means = mean(6, &|point, c| values[point].0[c]);
                FieldData::Tensor(means.as_chunks().0.iter().copied().map(SymTensor).collect())
            }
        };
        Field { data, ..field.clone() }
    };
    let has_average =
        |name: &String| name != DENSITY && !FieldRole::from_name(name).is_some_and(FieldRole::is_amount);
    let wanted = |name: &String| has_average(name) && only.is_none_or(|names| names.contains(name));
    let radial = case.space == Space::Axisymmetric;
    let density = |(node, mass): (usize, &f64)| mass / frame.volume(node, radial, &periodic);
    let density = FieldData::Scalar(mass.iter().enumerate().map(density).collect());
    let mut fields = vec![Field { name: DENSITY.to_owned(), unit: "kg/m3", data: density }];
    fields.extend(snapshot.fields.iter().filter(|field| wanted(&field.name)).map(average));
    let support = DatasetGeometry::Lattice { nodes, mask: Vec::new() };
    Dataset { name: Dataset::GRID.to_owned(), geometry: support, fields }
}

impl AveragingNodes {
    /// Sums of values times masses at the nodes. Each point contributes by the part of its mass at the node.
    fn sums(
        &self,
        shares: &[NodeShare],
        components: usize,
        value: impl Fn(usize, usize) -> f64,
        periodic: &[usize],
    ) -> Vec<f64> {
        let mut sums = vec![0.0; components * self.count.iter().product::<usize>()];
        for NodeShare { point, node, mass } in shares {
            for c in 0..components {
                sums[node * components + c] += mass * value(*point, c);
            }
        }
        periodic.iter().for_each(|axis| self.sum_periodic_images(&mut sums, components, *axis));
        sums
    }

    /// Parts of the masses of points at the nodes around them, by linear weights; points outside the domain have none.
    fn node_shares(&self, snapshot: &Snapshot) -> Vec<NodeShare> {
        let masses = snapshot.role_values(FieldRole::Mass).unwrap_or_default();
        let strides = [1, self.count[0], self.count[0] * self.count[1]];
        let mut shares = Vec::with_capacity(snapshot.positions.len() << self.dimension);
        'points: for (point, (x, mass)) in snapshot.positions.iter().zip(masses).enumerate() {
            let (mut first, mut part) = ([0; 3], [0.0; 3]);
            for axis in 0..self.dimension {
                let place = (x[axis] - self.low[axis]) / self.cell;
                let last = self.count[axis] - 1;
                if !(0.0..=last as f64).contains(&place) {
                    continue 'points;
                }
                first[axis] = (place as usize).min(last - 1);
                part[axis] = place - first[axis] as f64;
            }
            for corner in 0..1usize << self.dimension {
                let (mut node, mut mass) = (0, *mass);
                for axis in 0..self.dimension {
                    let upper = corner >> axis & 1;
                    node += (first[axis] + upper) * strides[axis];
                    mass *= if upper == 1 { part[axis] } else { 1.0 - part[axis] };
                }
                shares.push(NodeShare { point, node, mass });
            }
        }
        shares
    }

    /// Index of a node along each axis.
    fn axis_indices(&self, node: usize) -> [usize; 3] {
        let [nx, ny, _] = self.count;
        [node % nx, node / nx % ny, node / (nx * ny)]
    }

    /// Adds the sums of the first and the last nodes of a periodic axis, and assigns the result to both.
    fn sum_periodic_images(&self, sums: &mut [f64], components: usize, axis: usize) {
        let stride: usize = self.count[..axis].iter().product();
        let offset = (self.count[axis] - 1) * stride;
        for node in (0..sums.len() / components).filter(|node| self.axis_indices(*node)[axis] == 0) {
            for c in 0..components {
                let (first, last) = (node * components + c, (node + offset) * components + c);
                let sum = sums[first] + sums[last];
                (sums[first], sums[last]) = (sum, sum);
            }
        }
    }

    /// Volume of space of a node (m³; per metre in plane strain, per radian in axisymmetry).
    fn volume(&self, node: usize, radial: bool, periodic: &[usize]) -> f64 {
        let index = self.axis_indices(node);
        let share = |axis: usize| {
            let at_end = index[axis] == 0 || index[axis] == self.count[axis] - 1;
            if at_end && !periodic.contains(&axis) { 0.5 } else { 1.0 }
        };
        let volume: f64 = (0..self.dimension).map(|axis| self.cell * share(axis)).product();
        if !radial {
            return volume;
        }
        // Mean radius with the linear weight of the node.
        let (radius, third) = (self.low[0] + self.cell * index[0] as f64, self.cell / 3.0);
        let offset = match index[0] {
            0 => third,
            last if last == self.count[0] - 1 => -third,
            _ => 0.0,
        };
        volume * (radius + offset)
    }
}

/// Nodes of cells of edge `cell` (m) that cover the domain of a case; the last ones may lie outside it.
fn lattice(case: &Case, cell: f64) -> Lattice {
    let (mut low, mut count) = ([0.0; 3], [1; 3]);
    for axis in 0..case.dimension() {
        low[axis] = case.domain.min[axis];
        count[axis] = case.grid_nodes_along(cell, axis) as usize;
    }
    Lattice { low, spacing: cell, count }
}

impl Case {
    /// Nodes of `output.grid`; `None` where the case has none.
    #[must_use]
    pub fn lattice(&self) -> Option<Lattice> {
        self.output.grid.map(|cell| lattice(self, cell))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(space: &str, periodic: &[&str]) -> Case {
        let text = serde_json::json!({
            "title": "block", "space": space, "domain": { "min": [0, 0], "max": [4, 2], "periodic": periodic },
            "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [4, 2] } }],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        Case::from_json(&text.to_string()).unwrap()
    }

    /// Points at the quarters of cells of 1 m, of 1500 kg/m³ (per radian), with a velocity that grows along x.
    fn snapshot(radial: bool) -> Snapshot {
        let places = |count: usize| (0..count).map(|i| 0.25 + 0.5 * i as f64);
        let positions: Vec<[f64; 3]> = places(8).flat_map(|x| places(4).map(move |y| [x, y, 0.0])).collect();
        let mass = positions.iter().map(|x| 375.0 * if radial { x[0] } else { 1.0 }).collect();
        let velocity = positions.iter().map(|x| [2.0 * x[0], -1.0, 0.0]).collect();
        let stress = vec![SymTensor([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]); positions.len()];
        let field = |name: &str, data| Field { name: name.into(), unit: "", data };
        Snapshot {
            time: 0.0,
            step: 0,
            ids: (0..32).collect(),
            bodies: vec![0; 32],
            extents: vec![[0.5; 3]; 32],
            positions,
            fields: vec![
                field("mass", FieldData::Scalar(mass)),
                field("velocity", FieldData::Vector(velocity)),
                field("stress", FieldData::Tensor(stress)),
            ],
        }
    }

    fn count(dataset: &Dataset) -> [usize; 3] {
        let DatasetGeometry::Lattice { nodes, .. } = &dataset.geometry else { panic!("a lattice") };
        nodes.count
    }

    #[test]
    fn regular_points_give_their_density_and_linear_fields_exactly() {
        let frame = averages(&case("plane-strain", &[]), 1.0, &snapshot(false), None);
        assert_eq!(count(&frame), [5, 3, 1]);
        let [density, velocity, stress] = &frame.fields[..] else { panic!("three fields") };
        let FieldData::Scalar(density) = &density.data else { panic!("density") };
        assert!(density.iter().all(|rho| (rho / 1500.0 - 1.0).abs() < 1e-12), "{density:?}");
        let FieldData::Vector(velocity) = &velocity.data else { panic!("velocity") };
        for (node, v) in velocity.iter().enumerate() {
            let inside = (1..4).contains(&(node % 5));
            assert!(!inside || (v[0] - 2.0 * (node % 5) as f64).abs() < 1e-12 && (v[1] + 1.0).abs() < 1e-12);
        }
        let FieldData::Tensor(stress) = &stress.data else { panic!("stress") };
        assert!(stress.iter().all(|s| (0..6).all(|c| (s.0[c] - (c + 1) as f64).abs() < 1e-12)));
    }

    #[test]
    fn rings_and_periods_keep_their_density() {
        let of = |case: &Case, radial| match &averages(case, 1.0, &snapshot(radial), None).fields[0].data {
            FieldData::Scalar(density) => density.clone(),
            _ => panic!("a scalar"),
        };
        // Volume per radian times radius with the weight of each node, within the spread of points over a cell.
        let rings = of(&case("axisymmetric", &[]), true);
        assert!(rings.iter().all(|rho| (rho / 1500.0 - 1.0).abs() < 0.13), "{rings:?}");
        assert!((rings[2] / 1500.0 - 1.0).abs() < 1e-12, "{rings:?}");
        let period = of(&case("plane-strain", &["x"]), false);
        assert!(period.iter().all(|rho| (rho / 1500.0 - 1.0).abs() < 1e-12), "{period:?}");
    }

    #[test]
    fn only_requested_fields_are_averaged() {
        let frame = averages(&case("plane-strain", &[]), 0.7, &snapshot(false), Some(&["stress".into()]));
        assert_eq!(count(&frame), [7, 4, 1]);
        let names: Vec<&str> = frame.fields.iter().map(|field| &*field.name).collect();
        assert_eq!(names, ["density", "stress"]);
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("grid.vtr");
        crate::output::write_dataset(&path, &frame, [0.0; 3], crate::description::Compression::Fast).unwrap();
        assert!(std::fs::read_to_string(&path).unwrap().contains("WholeExtent=\"0 6 0 3 0 0\""));
    }
}
