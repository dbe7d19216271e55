//! Parameters of a case, one a line.

use serde_json::Value;

/// Parameter of a case: its JSON path, its value, and whether the value is a default.
pub(super) struct CaseParameter {
    /// JSON path of the parameter.
    pub(super) path: String,
    /// Value as text.
    pub(super) value: String,
    /// Whether the value is a default that the case does not set.
    pub(super) default: bool,
}

/// All parameters of a case, with the defaults of the options of `method` that the case leaves out.
pub(super) fn all_parameters(case: &Value, method: &str) -> Vec<CaseParameter> {
    let mut found = Vec::new();
    flatten("", case, false, &mut found);
    let Some(method) = crate::method(method) else { return found };
    let given = &case["methods"][method.name()];
    let schema = method.options_schema().to_value();
    for (name, property) in schema["properties"].as_object().into_iter().flatten() {
        let default = &property["default"];
        if given.get(name).is_none() && !default.is_null() {
            flatten(&format!("methods.{}.{name}", method.name()), default, true, &mut found);
        }
    }
    found
}

/// Adds the parameters in a value, with their JSON paths.
fn flatten(path: &str, value: &Value, default: bool, found: &mut Vec<CaseParameter>) {
    match value {
        Value::Object(map) if !map.is_empty() => {
            for (key, value) in map {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                flatten(&path, value, default, found);
            }
        }
        Value::Array(list) if list.iter().any(|item| item.is_object() || item.is_array()) => {
            for (number, item) in list.iter().enumerate() {
                flatten(&format!("{path}[{number}]"), item, default, found);
            }
        }
        // An absent value is not shown.
        Value::Null => {}
        Value::String(text) => {
            found.push(CaseParameter { path: path.to_owned(), value: text.clone(), default });
        }
        other => found.push(CaseParameter { path: path.to_owned(), value: other.to_string(), default }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_parameter_is_listed_with_its_path_and_value() {
        let case = json!({
            "title": "t", "gravity": [0, -9.81], "bodies": [{ "shape": { "points": [[0, 1], [2, 3]] } }],
            "methods": { "mpm": { "cell_size": 0.5, "flip": 0.9 } }
        });
        let all = all_parameters(&case, "mpm");
        let value = |path: &str| all.iter().find(|p| p.path == path).map(|p| (p.value.as_str(), p.default));
        assert_eq!(value("gravity"), Some(("[0,-9.81]", false)));
        assert_eq!(value("bodies[0].shape.points[1]"), Some(("[2,3]", false)));
        assert_eq!(value("methods.mpm.flip"), Some(("0.9", false)));
        assert_eq!(value("methods.mpm.courant"), Some(("0.5", true)));
    }
}
