//! State of all points at an instant.

use colluvium_constitutive::SymTensor;

use super::FieldRole;
use crate::files::checksum::FileChecksum;

/// Named quantity on points, nodes or cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name in snake case: `velocity`, `stress`, `mass`, `volume`, `displacement`, `density`, …
    pub name: String,
    /// SI unit, for labels.
    pub unit: &'static str,
    /// Values of the field.
    pub data: FieldData,
}

/// Values of a [`Field`], one for each point, node or cell.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldData {
    /// Whole numbers.
    Integer(Vec<i64>),
    /// Scalars.
    Scalar(Vec<f64>),
    /// Vectors.
    Vector(Vec<[f64; 3]>),
    /// Symmetric tensors.
    Tensor(Vec<SymTensor>),
}

/// Points of a [`Frame`](super::Frame) with their fields, sorted by id.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Time of the state (s).
    pub time: f64,
    /// Number of steps.
    pub step: u64,
    /// Ids, ascending; an id always belongs to the same point.
    pub ids: Vec<u64>,
    /// Index into `Case::bodies` of each point, or [`Snapshot::NO_BODY`].
    pub bodies: Vec<u32>,
    /// Positions (m); unused components are zero.
    pub positions: Vec<[f64; 3]>,
    /// Full widths of the domains of the points (m); zero for points without widths.
    pub extents: Vec<[f64; 3]>,
    /// Fields. Methods of material points give at least `velocity`, `stress`, `mass`, `volume` and `displacement`.
    pub fields: Vec<Field>,
}

impl Snapshot {
    /// Body number of points without a body.
    pub const NO_BODY: u32 = u32::MAX;

    /// Field with the name `name`.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|f| f.name == name)
    }

    /// Values of the scalar field `name`, one per point; `None` without such a scalar field.
    pub fn scalars(&self, name: &str) -> Option<&[f64]> {
        match &self.field(name)?.data {
            FieldData::Scalar(values) => Some(values),
            _ => None,
        }
    }

    /// Values of the scalar field with a role, one per point; `None` without such a field.
    pub fn role_values(&self, role: FieldRole) -> Option<&[f64]> {
        self.scalars(role.name())
    }

    /// Values of the vector field `name`, one per point; `None` without such a vector field.
    pub fn vectors(&self, name: &str) -> Option<&[[f64; 3]]> {
        match &self.field(name)?.data {
            FieldData::Vector(values) => Some(values),
            _ => None,
        }
    }

    /// Values of the tensor field `name`, one per point; `None` without such a tensor field.
    pub fn tensors(&self, name: &str) -> Option<&[SymTensor]> {
        match &self.field(name)?.data {
            FieldData::Tensor(values) => Some(values),
            _ => None,
        }
    }
}

impl Snapshot {
    /// Hash of a snapshot: of time, step, ids, bodies, positions, and fields with their names. It is equal for bit-identical snapshots
    /// only.
    pub fn hash(&self) -> u64 {
        let mut bytes: Vec<u8> = Vec::new();
        bytes.extend(self.time.to_bits().to_le_bytes());
        bytes.extend(self.step.to_le_bytes());
        // Counts separate consecutive arrays.
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
                FieldData::Integer(values) => bytes.extend(values.iter().flat_map(|v| v.to_le_bytes())),
                FieldData::Scalar(values) => add(&mut bytes, values),
                FieldData::Vector(values) => add(&mut bytes, values.as_flattened()),
                FieldData::Tensor(values) => values.iter().for_each(|tensor| add(&mut bytes, &tensor.0)),
            }
        }
        FileChecksum::of_bytes(&bytes).fnv1a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snapshot_hashes_differ_for_a_difference_in_any_field() {
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
