//! Case of one method of a comparison, with options chosen where the case has none for it.

use serde_json::{Map, Value, json};

use crate::case::{Case, Method};

/// Number of points across the smallest extent of the smallest body, where no method of the case has a spacing.
const DEFAULT_POINTS_ACROSS: f64 = 20.0;

/// Case with the options of one method.
#[derive(Clone, Debug)]
pub struct MethodCase {
    /// The case, with options for the method alone.
    pub case: Case,
    /// Text with the options that the comparison chose; empty where the case has all options.
    pub chosen_options: String,
}

/// Distance between points (m), and the text that says where it comes from.
struct SpacingChoice {
    value: f64,
    origin: String,
}

impl MethodCase {
    /// Builds the case for `method`. Where the case has no entry for it, the required keys follow from the spacing of points of another
    /// method's entry, or from the smallest body. A method that requires more than a spacing gets no entry, and its own message refuses the
    /// case.
    pub fn for_method(method: &dyn Method, case: &Case) -> Self {
        let name = method.name();
        let mut own = case.clone();
        own.methods.retain(|key, _| key == name);
        if own.methods.contains_key(name) {
            return Self { case: own, chosen_options: String::new() };
        }
        let schema = method.options_schema();
        let Some(spacing) = requested_spacing(case) else {
            return Self { case: own, chosen_options: String::new() };
        };
        let mut options = Map::new();
        for key in required_keys(schema.as_value()) {
            let value = match key {
                "spacing" => spacing.value,
                "cell_size" => fitted_cell_size(
                    case,
                    spacing.value * default_value(schema.as_value(), "points_per_cell"),
                ),
                _ => return Self { case: own, chosen_options: String::new() },
            };
            options.insert(key.to_owned(), json!(value));
        }
        if options.is_empty() {
            return Self { case: own, chosen_options: String::new() };
        }
        let option_text = |(key, value): (&String, &Value)| {
            format!("{key} {} m", value.as_f64().map_or(f64::NAN, rounded_to_six_digits))
        };
        let took = options.iter().map(option_text).collect::<Vec<_>>().join(", ");
        own.methods.insert(name.to_owned(), Value::Object(options));
        Self {
            case: own,
            chosen_options: format!("{took} ({}); other options have their defaults", spacing.origin),
        }
    }
}

/// Keys that a schema requires.
fn required_keys(schema: &Value) -> Vec<&str> {
    schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect()
}

/// Default of a key by its schema; 1 where it has none.
fn default_value(schema: &Value, key: &str) -> f64 {
    schema["properties"][key]["default"].as_f64().unwrap_or(1.0)
}

/// Number rounded to six digits.
fn rounded_to_six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Cell size nearest to `wanted` (m) by which every side of the domain is divided into whole cells. `wanted` itself where there is none
/// within half of it.
fn fitted_cell_size(case: &Case, wanted: f64) -> f64 {
    let sides: Vec<f64> =
        case.domain.min.iter().zip(&case.domain.max).map(|(low, high)| high - low).collect();
    let whole = |cell: &f64| {
        sides.iter().all(|side| {
            let count = side / cell;
            count.round() >= 1.0 && (count - count.round()).abs() < 1e-7 * count
        })
    };
    let Some(first) = sides.first() else { return wanted };
    let (fewest, largest) = ((first / (1.5 * wanted)).ceil(), (first / (0.5 * wanted)).floor());
    if !(largest - fewest < 1e6) {
        return wanted;
    }
    let cells = (fewest.max(1.0) as u64..=largest as u64)
        .map(|count| rounded_where_fitting(first / count as f64, whole));
    let nearest = cells.filter(whole).min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs()));
    nearest.unwrap_or(wanted)
}

/// Cell size rounded to six digits where the rounded one fits too, so that quotients of round numbers remain round.
fn rounded_where_fitting(cell: f64, fits: impl Fn(&f64) -> bool) -> f64 {
    Some(rounded_to_six_digits(cell)).filter(|rounded| fits(rounded)).unwrap_or(cell)
}

/// Spacing of points that an option of the case prescribes.
fn requested_spacing(case: &Case) -> Option<SpacingChoice> {
    let entries = || case.methods.iter();
    let direct = entries().find_map(|(name, options)| Some((name, options["spacing"].as_f64()?)));
    if let Some((name, value)) = direct {
        return Some(SpacingChoice { value, origin: format!("the spacing of methods.{name}") });
    }
    let cells = entries().find_map(|(name, options)| {
        let schema = crate::method(name)?.options_schema();
        let per_cell = options["points_per_cell"].as_f64();
        let per_cell = per_cell.unwrap_or_else(|| default_value(schema.as_value(), "points_per_cell"));
        Some((name, options["cell_size"].as_f64()? / per_cell))
    });
    if let Some((name, value)) = cells {
        return Some(SpacingChoice { value, origin: format!("the spacing of points of methods.{name}") });
    }
    let minimum = |(low, high): (Vec<f64>, Vec<f64>)| {
        (0..case.dimension()).map(|c| high[c] - low[c]).fold(f64::INFINITY, f64::min)
    };
    let extents = case.bodies.iter().map(|body| minimum(body.shape.bounds(case.dimension())));
    let smallest = extents.filter(|extent| extent.is_finite() && *extent > 0.0).fold(f64::INFINITY, f64::min);
    smallest.is_finite().then(|| SpacingChoice {
        value: smallest / DEFAULT_POINTS_ACROSS,
        origin: format!("{DEFAULT_POINTS_ACROSS} points across the smallest body"),
    })
}

#[cfg(test)]
mod tests {
    use super::MethodCase;
    use crate::case::Case;

    fn column() -> Case {
        Case::from_json(crate::template("column-collapse").expect("a template")).expect("a case")
    }

    #[test]
    fn a_method_without_options_gets_the_resolution_of_another_with_a_note() {
        let sph = MethodCase::for_method(crate::method("sph").unwrap(), &column());
        assert_eq!(sph.case.methods.keys().collect::<Vec<_>>(), ["sph"]);
        // Cells of 5 mm with three points along each axis.
        assert!((sph.case.methods["sph"]["spacing"].as_f64().unwrap() - 0.005 / 3.0).abs() < 1e-8);
        assert!(sph.chosen_options.contains("methods.mpm"), "{}", sph.chosen_options);
    }

    #[test]
    fn cells_divide_the_domain_of_the_template() {
        let snow = MethodCase::for_method(crate::method("snow-mpm").unwrap(), &column());
        let cell = snow.case.methods["snow-mpm"]["cell_size"].as_f64().unwrap();
        for side in [0.5, 0.15] {
            assert!((side / cell - (side / cell).round()).abs() < 1e-9 && cell < 0.005, "{cell}");
        }
        assert!(snow.chosen_options.starts_with("cell_size 0.00333333 m"), "{}", snow.chosen_options);
    }

    #[test]
    fn without_method_options_the_smallest_body_sets_the_resolution() {
        let mut case = column();
        case.methods.clear();
        let mpm = MethodCase::for_method(crate::method("mpm").unwrap(), &case);
        let cell = mpm.case.methods["mpm"]["cell_size"].as_f64().unwrap();
        let per_cell = cell / (0.1 / 20.0);
        assert!((per_cell - per_cell.round()).abs() < 1e-9 && per_cell >= 1.0, "{per_cell}");
        assert!(mpm.chosen_options.contains("20 points"), "{}", mpm.chosen_options);
    }

    #[test]
    fn given_method_options_are_unchanged_and_grains_have_no_derived_options() {
        let mpm = MethodCase::for_method(crate::method("mpm").unwrap(), &column());
        assert_eq!(mpm.case.methods["mpm"], column().methods["mpm"]);
        assert!(mpm.chosen_options.is_empty());
        let dem = MethodCase::for_method(crate::method("dem").unwrap(), &column());
        assert!(dem.case.methods.is_empty() && dem.chosen_options.is_empty());
    }
}
