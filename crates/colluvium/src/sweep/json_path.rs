//! Paths of values in a case, as error messages name them.

use serde_json::Value;

/// Part of a JSON path: a key of an object or an index of a list.
enum PathStep<'a> {
    /// Key of an object.
    Key(&'a str),
    /// Index in a list.
    Index(usize),
}

/// Parses the parts of a path such as `bodies[0].shape.max[1]`.
fn parse_path(path: &str) -> Result<Vec<PathStep<'_>>, String> {
    let odd = || format!("{path:?} is not a path like bodies[0].shape.max[1]");
    let mut steps = Vec::new();
    for part in path.split('.') {
        let (key, indices) = part.split_once('[').map_or((part, None), |(key, rest)| (key, Some(rest)));
        if key.is_empty() {
            return Err(odd());
        }
        steps.push(PathStep::Key(key));
        let Some(indices) = indices else { continue };
        let indices = indices.strip_suffix(']').ok_or_else(odd)?;
        for index in indices.split("][") {
            steps.push(PathStep::Index(index.parse().map_err(|_| odd())?));
        }
    }
    Ok(steps)
}

/// Sets a value in a case. The last key may be new; its parent must exist.
///
/// # Errors
/// When the path is malformed or leads nowhere.
pub(crate) fn set_value(case: &mut Value, path: &str, value: &Value) -> Result<(), String> {
    let nowhere = || format!("{path:?} is not in the case");
    let steps = parse_path(path)?;
    let mut place = case;
    for (number, step) in steps.iter().enumerate() {
        let last = number + 1 == steps.len();
        let inner = match step {
            PathStep::Key(key) => place.as_object_mut().and_then(|map| match last {
                true => Some(map.entry(*key).or_insert(Value::Null)),
                false => map.get_mut(*key),
            }),
            PathStep::Index(index) => place.as_array_mut().and_then(|items| items.get_mut(*index)),
        };
        place = inner.ok_or_else(nowhere)?;
    }
    *place = value.clone();
    Ok(())
}

/// Value at a path; `None` where the path is malformed or leads nowhere.
pub(crate) fn value_at<'a>(root: &'a Value, path: &str) -> Option<&'a Value> {
    parse_path(path).ok()?.iter().try_fold(root, |place, step| match step {
        PathStep::Key(key) => place.get(key),
        PathStep::Index(index) => place.get(index),
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn set_value_changes_the_value_at_the_json_path() {
        let mut case = json!({ "bodies": [{ "shape": { "max": [1, 2] } }], "gravity": [[1, 2], [3, 4]] });
        set_value(&mut case, "bodies[0].shape.max[1]", &json!(7)).unwrap();
        set_value(&mut case, "bodies[0].rigid", &json!(true)).unwrap();
        set_value(&mut case, "gravity[1][0]", &json!("x")).unwrap();
        let expected = json!({ "bodies": [{ "shape": { "max": [1, 7] }, "rigid": true }], "gravity": [[1, 2], ["x", 4]] });
        assert_eq!(case, expected);
        assert_eq!(value_at(&case, "bodies[0].shape.max[1]"), Some(&json!(7)));
        assert_eq!(value_at(&case, "bodies[1].shape"), None);
    }

    #[test]
    fn missing_json_paths_are_refused_and_change_nothing() {
        let case = json!({ "bodies": [{ "shape": { "max": [1, 2] } }] });
        for path in [
            "",
            "bodies[1].shape",
            "bodies[0].shap.max",
            "bodies[x]",
            "bodies[0",
            "bodies.shape",
            "a..b",
            "[0]",
        ] {
            let mut changed = case.clone();
            assert!(set_value(&mut changed, path, &json!(1)).is_err(), "{path}");
            assert_eq!(changed, case, "{path}");
        }
    }
}
