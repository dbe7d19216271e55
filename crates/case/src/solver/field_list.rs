//! Fields of a frame, of which only the wanted ones are computed.

use colluvium_constitutive::SymTensor;

use super::{Field, FieldData, FrameRequest};

/// Fields of a frame in the order in which they are added. A field that the request does not include is not computed.
///
/// ```
/// use colluvium_case::{FieldList, FrameRequest};
///
/// let mut fields = FieldList::new(FrameRequest::Fields(&["mass"]));
/// fields.scalar("mass", "kg", || vec![2.0, 3.0]);
/// fields.vector("velocity", "m/s", || unreachable!("nobody wants it"));
/// assert_eq!(fields.into_fields().len(), 1);
/// ```
pub struct FieldList<'a> {
    wanted: FrameRequest<'a>,
    fields: Vec<Field>,
}

impl<'a> FieldList<'a> {
    /// Empty list of the fields in a request.
    #[must_use]
    pub fn new(wanted: FrameRequest<'a>) -> Self {
        Self { wanted, fields: Vec::new() }
    }

    /// Whether the request includes a field.
    #[must_use]
    pub fn includes(&self, name: &str) -> bool {
        self.wanted.includes(name)
    }

    /// Adds a field, one value per point; `unit` is its SI unit.
    pub fn add(&mut self, name: &str, unit: &'static str, data: impl FnOnce() -> FieldData) {
        if self.includes(name) {
            self.fields.push(Field { name: name.to_owned(), unit, data: data() });
        }
    }

    /// Adds a field of numbers.
    pub fn scalar(&mut self, name: &str, unit: &'static str, values: impl FnOnce() -> Vec<f64>) {
        self.add(name, unit, || FieldData::Scalar(values()));
    }

    /// Adds a field of vectors.
    pub fn vector(&mut self, name: &str, unit: &'static str, values: impl FnOnce() -> Vec<[f64; 3]>) {
        self.add(name, unit, || FieldData::Vector(values()));
    }

    /// Adds a field of symmetric tensors.
    pub fn tensor(&mut self, name: &str, unit: &'static str, values: impl FnOnce() -> Vec<SymTensor>) {
        self.add(name, unit, || FieldData::Tensor(values()));
    }

    /// Adds fields that exist already.
    pub fn extend(&mut self, fields: impl IntoIterator<Item = Field>) {
        let wanted = self.wanted;
        self.fields.extend(fields.into_iter().filter(|field| wanted.includes(&field.name)));
    }

    /// Fields in the order in which they were added.
    #[must_use]
    pub fn into_fields(self) -> Vec<Field> {
        self.fields
    }
}
