//! The state of all points at an instant.

use colluvium_constitutive::SymTensor;
use colluvium_points::Raster;

/// One named quantity on the points.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name in snake case: `velocity`, `stress`, `mass`, `volume`, `displacement`, `density`, …
    pub name: String,
    /// SI unit, for labels.
    pub unit: &'static str,
    /// The values.
    pub data: FieldData,
}

/// Values of a [`Field`], one per point.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldData {
    /// Scalars.
    Scalar(Vec<f64>),
    /// Vectors.
    Vector(Vec<[f64; 3]>),
    /// Symmetric tensors.
    Tensor(Vec<SymTensor>),
}

/// Numbers on a raster over the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRaster {
    /// Name in snake case, that of its files.
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// The numbers; not-a-number where there is none.
    pub raster: Raster,
}

/// Nodes at equal distances, the first axis fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The first node (m).
    pub low: [f64; 3],
    /// Distance of the nodes along each axis (m).
    pub spacing: f64,
    /// Nodes along each axis; one along those that the space has not.
    pub count: [usize; 3],
}

/// The state of all points at an instant, in the order of their ids, whatever order the solver keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Time (s).
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Ids, ascending; an id is the point's for its whole life.
    pub ids: Vec<u64>,
    /// Index into `Case::bodies` of each point.
    pub bodies: Vec<u32>,
    /// Positions (m); unused components are zero.
    pub positions: Vec<[f64; 3]>,
    /// Full widths of the points' domains (m).
    pub extents: Vec<[f64; 3]>,
    /// Fields; every method gives at least `velocity`, `stress`, `mass`, `volume`, `displacement`.
    pub fields: Vec<Field>,
}

impl Snapshot {
    /// The field called `name`.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|f| f.name == name)
    }

    /// The scalars of the field called `name`, one a point; `None` where there is none of scalars.
    pub fn scalars(&self, name: &str) -> Option<&[f64]> {
        match &self.field(name)?.data {
            FieldData::Scalar(values) => Some(values),
            _ => None,
        }
    }

    /// The vectors of the field called `name`, one a point; `None` where there is none of vectors.
    pub fn vectors(&self, name: &str) -> Option<&[[f64; 3]]> {
        match &self.field(name)?.data {
            FieldData::Vector(values) => Some(values),
            _ => None,
        }
    }

    /// The tensors of the field called `name`, one a point; `None` where there is none of tensors.
    pub fn tensors(&self, name: &str) -> Option<&[SymTensor]> {
        match &self.field(name)?.data {
            FieldData::Tensor(values) => Some(values),
            _ => None,
        }
    }
}

impl Snapshot {
    /// A number that is the same only for snapshots equal to the last bit: time, step, ids, bodies,
    /// places and fields with their names.
    pub fn hash(&self) -> u64 {
        let mut bytes: Vec<u8> = Vec::new();
        bytes.extend(self.time.to_bits().to_le_bytes());
        bytes.extend(self.step.to_le_bytes());
        // Counts keep apart what would run together.
        bytes.extend((self.ids.len() as u64).to_le_bytes());
        bytes.extend(self.ids.iter().flat_map(|id| id.to_le_bytes()));
        bytes.extend(self.bodies.iter().flat_map(|body| body.to_le_bytes()));
        let add = |bytes: &mut Vec<u8>, values: &[f64]| {
            bytes.extend(values.iter().flat_map(|v| v.to_bits().to_le_bytes()));
        };
        add(&mut bytes, self.positions.as_flattened());
        add(&mut bytes, self.extents.as_flattened());
        for field in &self.fields {
            bytes.extend((field.name.len() as u64).to_le_bytes());
            bytes.extend(field.name.as_bytes());
            match &field.data {
                FieldData::Scalar(values) => add(&mut bytes, values),
                FieldData::Vector(values) => add(&mut bytes, values.as_flattened()),
                FieldData::Tensor(values) => values.iter().for_each(|tensor| add(&mut bytes, &tensor.0)),
            }
        }
        crate::load::fnv1a(&bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_tells_apart_snapshots_that_differ_anywhere() {
        let whole = Snapshot {
            time: 1.0,
            step: 7,
            ids: vec![0, 1],
            bodies: vec![0, 1],
            positions: vec![[0.0; 3], [1.0; 3]],
            extents: vec![[0.1; 3]; 2],
            fields: vec![Field { name: "mass".into(), unit: "kg", data: FieldData::Scalar(vec![1.0, 2.0]) }],
        };
        let changes: [fn(&mut Snapshot); 8] = [
            |s| s.time = 1.5,
            |s| s.step = 8,
            |s| s.ids[1] = 2,
            |s| s.bodies[1] = 0,
            |s| s.positions[0][1] = -0.0,
            |s| s.extents[0][0] = 0.2,
            |s| s.fields[0].name = "heat".into(),
            |s| s.fields[0].data = FieldData::Scalar(vec![1.0, 2.0 + 1e-15]),
        ];
        let hashes: Vec<u64> = changes
            .iter()
            .map(|change| {
                let mut snapshot = whole.clone();
                change(&mut snapshot);
                snapshot.hash()
            })
            .chain([whole.hash()])
            .collect();
        for (i, hash) in hashes.iter().enumerate() {
            assert!(!hashes[..i].contains(hash), "change {i} goes unseen");
        }
        assert_eq!(whole.hash(), whole.clone().hash());
    }
}

/// Lines with fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    /// Both ends of each line (m).
    pub ends: Vec<[[f64; 3]; 2]>,
    /// What they carry, one value a line.
    pub fields: Vec<Field>,
}

impl Lines {
    /// The same with `by` (m) added to all coordinates.
    #[must_use]
    pub fn shifted(mut self, by: [f64; 3]) -> Self {
        for end in self.ends.as_flattened_mut() {
            end.iter_mut().zip(by).for_each(|(x, by)| *x += by);
        }
        self
    }
}
