//! Formulas of the coordinates, for initial fields.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::description::expression::{COORDINATES, Expression};

/// Formula of the coordinates `x`, `y` and `z` (m, from `domain.origin` where the case has one), as text, or a number. Operators and
/// functions: `+ - * / ^`, brackets, `PI`, `E` and `TAU`, and `abs`, `signum`, `sqrt`, `cbrt`, `exp`, `ln`, `log2`, `log10`, `floor`,
/// `ceil`, `round`, `sin`, `cos`, `tan`, their inverses and their hyperbolic forms, and, between two numbers, `min`, `max` and `atan2`:
/// `"0.3 * sin(PI * x) max 0"`. Angles are in radians.
#[derive(Clone, Debug)]
pub struct Formula(FormulaContent);

/// Number, or text with its parsed expression, boxed because it is large and most fields have no formula.
#[derive(Clone, Debug)]
enum FormulaContent {
    Number(f64),
    Text(String, Box<Expression>),
}

/// Formula as written in the case file.
#[derive(Deserialize)]
#[serde(untagged)]
enum FormulaSource {
    Number(f64),
    Text(String),
}

impl Formula {
    /// Parses a formula.
    ///
    /// # Errors
    /// Description of the error, or the name in it that is not a coordinate.
    pub fn new(text: &str) -> Result<Self, String> {
        let expression = Box::new(Expression::parse(text)?);
        Ok(Self(FormulaContent::Text(text.to_owned(), expression)))
    }

    /// Value at `x` (m); not finite where it is undefined.
    pub fn evaluate(&self, x: [f64; 3]) -> f64 {
        match &self.0 {
            FormulaContent::Number(value) => *value,
            FormulaContent::Text(_, expression) => expression.evaluate(x),
        }
    }

    /// First coordinate of the formula that a space of `dimension` axes does not have.
    pub(crate) fn unknown_coordinate(&self, dimension: usize) -> Option<&'static str> {
        let FormulaContent::Text(_, expression) = &self.0 else { return None };
        expression.axes().iter().find(|axis| **axis >= dimension).map(|axis| COORDINATES[*axis])
    }
}

impl PartialEq for Formula {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (FormulaContent::Number(own), FormulaContent::Number(other)) => own == other,
            (FormulaContent::Text(own, _), FormulaContent::Text(other, _)) => own == other,
            _ => false,
        }
    }
}

impl Serialize for Formula {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            FormulaContent::Number(value) => value.serialize(serializer),
            FormulaContent::Text(text, _) => text.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Formula {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let source = FormulaSource::deserialize(deserializer).map_err(|_| {
            serde::de::Error::custom("is neither a formula of x, y and z (a text) nor a number")
        })?;
        match source {
            FormulaSource::Number(value) => Ok(Self(FormulaContent::Number(value))),
            FormulaSource::Text(text) => Self::new(&text).map_err(serde::de::Error::custom),
        }
    }
}

impl JsonSchema for Formula {
    fn schema_name() -> Cow<'static, str> {
        "Formula".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Number, or formula of the coordinates `x`, `y` and `z` (m, from `domain.origin` if given). There are `+ - * / ^`, \
                brackets, `PI`, `E`, `TAU`, and functions with brackets. These are `abs`, `signum`, `sqrt`, `cbrt`, `exp`, `ln`, `log2`, `log10`, \
                `floor`, `ceil`, `round`, and `sin`, `cos`, `tan` with their inverses and hyperbolic forms. Between two numbers stand `min`, `max` \
                and `atan2`, as in `0 max (1 - y)`. Angles are in radians.",
            "type": ["string", "number"]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_formula_has_the_values_of_its_coordinates() {
        let at = |text: &str| Formula::new(text).unwrap().evaluate([0.5, 2.0, -3.0]);
        assert_eq!(at("z + 2*y"), 1.0);
        assert_eq!(at("x^2 - y^3"), -7.75);
        assert!((at("sin(PI*x)*cos(PI*y) + E*0") - 1.0).abs() < 1e-15);
        assert_eq!(at("0 max (1 - y)"), 0.0);
        assert_eq!(at("-z*-1"), -3.0);
        assert_eq!(at("2.5e-3*y + 1E2 + .5e+1"), 105.005);
        assert!(!at("ln(z)").is_finite());
        let number: Formula = serde_json::from_str("-2.5e-3").unwrap();
        assert_eq!(number.evaluate([1.0; 3]), -2.5e-3);
    }

    #[test]
    fn invalid_formulas_are_refused_with_the_faulty_part() {
        for (text, part) in [
            ("x + t", "\"t\""),
            ("sin(", "not a formula"),
            ("", "not a formula"),
            ("2 x y", "not a formula"),
            ("µ*x", "other than plain letters"),
            ("sine(x)", "sine"),
        ] {
            let problem = Formula::new(text).unwrap_err();
            assert!(problem.contains(part), "{text}: {problem}");
        }
        assert!(Formula::new(&"(".repeat(200)).is_err());
        assert!(serde_json::from_str::<Formula>("true").unwrap_err().to_string().contains("formula"));
    }

    #[test]
    fn a_formula_is_written_as_it_was_read() {
        for text in ["\"x*y\"", "3.0"] {
            let formula: Formula = serde_json::from_str(text).unwrap();
            assert_eq!(serde_json::to_string(&formula).unwrap(), text);
        }
    }
}
