//! Search for numbers that JSON cannot contain.

use std::fmt;

use serde::ser::{
    Error, Serialize, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};
use serde_json::Value;
use serde_path_to_error::{Path, Segment};

/// Text in the place of a number that is not finite.
pub(crate) const NON_FINITE_MARK: &str = "not a finite number";

/// Replaces the first number of `value` that is not finite, which JSON turns into null, by a text in its JSON form. A check then refuses
/// it at its path.
pub(crate) fn mark_first_non_finite<T: Serialize>(value: &T, json: &mut Value) {
    let Err(error) = serde_path_to_error::serialize(value, FiniteCheck) else { return };
    if let Some(found) = value_at(json, error.path()) {
        *found = Value::from(NON_FINITE_MARK);
    }
}

/// Value at a path; `None` where there is none.
fn value_at<'a>(json: &'a mut Value, path: &Path) -> Option<&'a mut Value> {
    path.iter().try_fold(json, |value, segment| match segment {
        Segment::Seq { index } => value.get_mut(index),
        Segment::Map { key } => value.get_mut(key),
        // Tagged variants have their fields at the same level as their tag.
        Segment::Enum { variant } if value.get(variant).is_some() => value.get_mut(variant),
        Segment::Enum { .. } => Some(value),
        Segment::Unknown => None,
    })
}

/// Serializer without output that fails at a number that is not finite.
#[derive(Clone, Copy)]
struct FiniteCheck;

/// A number that is not finite.
#[derive(Debug)]
struct NotFinite;

impl fmt::Display for NotFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number is not finite")
    }
}

impl std::error::Error for NotFinite {}

impl Error for NotFinite {
    fn custom<T: fmt::Display>(_message: T) -> Self {
        Self
    }
}

/// Functions of a serializer that accept a value of a type.
macro_rules! accept {
    ($($function:ident($type:ty)),*) => {
        $(fn $function(self, _value: $type) -> Result<(), NotFinite> {
            Ok(())
        })*
    };
}

impl Serializer for FiniteCheck {
    type Ok = ();
    type Error = NotFinite;
    type SerializeSeq = Self;
    type SerializeTuple = Self;
    type SerializeTupleStruct = Self;
    type SerializeTupleVariant = Self;
    type SerializeMap = Self;
    type SerializeStruct = Self;
    type SerializeStructVariant = Self;

    accept! {
        serialize_bool(bool), serialize_i8(i8), serialize_i16(i16), serialize_i32(i32), serialize_i64(i64),
        serialize_u8(u8), serialize_u16(u16), serialize_u32(u32), serialize_u64(u64), serialize_char(char),
        serialize_str(&str), serialize_bytes(&[u8]), serialize_unit_struct(&'static str)
    }

    fn serialize_f32(self, value: f32) -> Result<(), NotFinite> {
        self.serialize_f64(f64::from(value))
    }

    fn serialize_f64(self, value: f64) -> Result<(), NotFinite> {
        if value.is_finite() { Ok(()) } else { Err(NotFinite) }
    }

    fn serialize_none(self) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), NotFinite> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), NotFinite> {
        Ok(())
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), NotFinite> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        value: &T,
    ) -> Result<(), NotFinite> {
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_tuple(self, _: usize) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Self, NotFinite> {
        Ok(self)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self, NotFinite> {
        Ok(self)
    }
}

/// Serialization of the entries of a list.
macro_rules! entries {
    ($($name:ident::$function:ident),*) => {
        $(impl $name for FiniteCheck {
            type Ok = ();
            type Error = NotFinite;

            fn $function<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotFinite> {
                value.serialize(*self)
            }

            fn end(self) -> Result<(), NotFinite> {
                Ok(())
            }
        })*
    };
}

entries! {
    SerializeSeq::serialize_element, SerializeTuple::serialize_element, SerializeTupleStruct::serialize_field,
    SerializeTupleVariant::serialize_field
}

/// Serialization of the fields of a structure.
macro_rules! fields {
    ($($name:ident),*) => {
        $(impl $name for FiniteCheck {
            type Ok = ();
            type Error = NotFinite;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                _: &'static str,
                value: &T,
            ) -> Result<(), NotFinite> {
                value.serialize(*self)
            }

            fn end(self) -> Result<(), NotFinite> {
                Ok(())
            }
        })*
    };
}

fields! { SerializeStruct, SerializeStructVariant }

impl SerializeMap for FiniteCheck {
    type Ok = ();
    type Error = NotFinite;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), NotFinite> {
        key.serialize(*self)
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), NotFinite> {
        value.serialize(*self)
    }

    fn end(self) -> Result<(), NotFinite> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde_json::json;

    use super::*;

    #[derive(serde::Serialize)]
    #[serde(tag = "kind", rename_all = "kebab-case")]
    enum Law {
        Linear { stiffness: Option<f64> },
    }

    #[derive(serde::Serialize)]
    struct Options {
        absent: Option<f64>,
        step: Option<f64>,
        laws: BTreeMap<String, Vec<Law>>,
    }

    #[test]
    fn the_first_number_that_is_not_finite_is_marked_at_its_path() {
        let marked = |step: f64, stiffness: f64| {
            let laws = vec![Law::Linear { stiffness: Some(1.0) }, Law::Linear { stiffness: Some(stiffness) }];
            let laws = BTreeMap::from([("sand".to_owned(), laws)]);
            let options = Options { absent: None, step: Some(step), laws };
            let mut json = serde_json::to_value(&options).unwrap();
            mark_first_non_finite(&options, &mut json);
            json
        };
        let text = "not a finite number";
        assert_eq!(marked(f64::NAN, 1.0)["step"], text);
        assert_eq!(marked(1.0, f64::INFINITY)["laws"]["sand"][1]["stiffness"], text);
        assert_eq!(marked(1.0, f64::INFINITY)["absent"], json!(null));
        assert_eq!(marked(1.0, 1.0)["step"], 1.0);
    }
}
