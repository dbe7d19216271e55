//! Tests that every option of every method changes the result of some run, or is refused: none is read and not used.

mod trials;

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use colluvium::case::{Case, FrameRequest};
use colluvium_testkit::pairwise::CaseFamily;
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use crate::trials::{Trial, trials};

/// Largest number of runs in which an option is tried.
const TRIALS: usize = 60;

/// Number of steps of a run.
const STEPS: usize = 40;

/// Cases by name.
type Runs = BTreeMap<String, Value>;

/// Combinations of levels that use an option only together.
const COMBINED: [(&str, &[(&str, &str)]); 7] = [
    ("dem", &[("space", "space"), ("rolling", "rolling"), ("adhesion", "bond")]),
    ("depth-sph", &[("space", "space"), ("phases", "pore pressure")]),
    ("depth-sph", &[("space", "space"), ("inflow", "line")]),
    (
        "mpm",
        &[("shape", "linear"), ("stress update", "usl"), ("walls", "rough"), ("extras", "consistent mass")],
    ),
    ("mpm", &[("shape", "linear"), ("averages", "mixed, reset")]),
    ("mpm", &[("shape", "linear"), ("averages", "free surface"), ("material", "water")]),
    ("sph", &[("material", "water"), ("continuity", "mass"), ("stability", "density shepard")]),
];

/// Families of cases of `cargo xtask same-bits`.
fn families() -> Vec<CaseFamily> {
    CaseFamily::read_all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/same-bits")).unwrap()
}

/// Base cases, cases with one level other than that of the base, and those of [`COMBINED`].
fn runs(families: &[CaseFamily]) -> Runs {
    let mut runs = Runs::new();
    for family in families {
        let accepts = |case: &Value| refusal(case).is_none();
        let combined = COMBINED.iter().filter(|(name, _)| *name == family.name);
        let combined = combined.map(|(_, levels)| family.row(levels));
        for row in family.single_changes(&accepts).into_iter().chain(combined) {
            let mut case = family.case(&row);
            for stage in case["stages"].as_array_mut().unwrap() {
                stage["duration"] = json!(10);
            }
            runs.insert(format!("{} ({})", family.name, family.description(&row)), case);
        }
    }
    runs
}

/// Outcome of a change of an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Effect {
    /// All values were refused.
    Refused,
    /// A value was accepted and changed nothing.
    Ignored,
    /// A value was accepted and changed the result.
    Changed,
}

/// Schema behind a reference.
fn resolved<'s>(root: &'s Value, mut schema: &'s Value) -> &'s Value {
    while let Some(reference) = schema["$ref"].as_str() {
        schema = root.pointer(reference.trim_start_matches('#')).expect("a reference leads somewhere");
    }
    schema
}

/// Schemas of the variants of a value.
fn forms<'s>(root: &'s Value, schema: &'s Value) -> Vec<&'s Value> {
    let schema = resolved(root, schema);
    let all = ["anyOf", "oneOf"].iter().find_map(|key| schema[*key].as_array());
    all.map_or_else(|| vec![schema], |all| all.iter().flat_map(|own| forms(root, own)).collect())
}

/// Values other than `now` that the schema allows.
fn others(root: &Value, schema: &Value, now: Option<&Value>) -> Vec<Value> {
    let mut all = Vec::new();
    let known = now.or_else(|| schema.get("default")).and_then(Value::as_f64);
    for form in forms(root, schema) {
        let has = |name: &str| {
            form["type"].as_str() == Some(name)
                || form["type"].as_array().is_some_and(|types| types.iter().any(|own| own == name))
        };
        if let Some(value) = form.get("const") {
            all.push(value.clone());
        } else if let Some(values) = form["enum"].as_array() {
            all.extend(values.iter().cloned());
        } else if has("boolean") {
            all.extend([json!(true), json!(false)]);
        } else if has("integer") {
            let known = known.unwrap_or(1.0) as i64;
            all.extend([json!(known + 1), json!(known + 3), json!(2 * known)]);
        } else if has("number") {
            match known.filter(|known| *known != 0.0) {
                Some(known) => all.extend([0.7, 1.4, 0.2].map(|factor| json!(factor * known))),
                None => all.extend([0.3, 1e-5, 2.0, 100.0].map(|value| json!(value))),
            }
        } else if has("object") {
            all.extend(variant(root, form));
        }
    }
    all.retain(|value| !value.is_null() && Some(value) != now);
    all
}

/// Object of a variant that needs only the tag.
fn variant(root: &Value, form: &Value) -> Option<Value> {
    let required = form["required"].as_array()?;
    let mut own = Map::new();
    for key in required {
        let key = key.as_str()?;
        let field = resolved(root, &form["properties"][key]);
        own.insert(key.to_owned(), field.get("const").cloned()?);
    }
    Some(Value::Object(own))
}

/// Position of an option in a case: its path, and its name with `[]` for entries and `*` for names.
struct Place {
    path: String,
    name: String,
    others: Vec<Value>,
}

/// Collects the options in `value`, present or possible, below a path.
fn places(root: &Value, schema: &Value, value: &Value, (path, name): (&str, &str), all: &mut Vec<Place>) {
    for form in forms(root, schema) {
        if let (Some(properties), Some(object)) = (form["properties"].as_object(), value.as_object()) {
            let tag = properties.iter().find_map(|(key, own)| {
                let constant = resolved(root, own).get("const")?;
                Some(object.get(key) == Some(constant))
            });
            if tag == Some(false) || object.keys().any(|key| !properties.contains_key(key)) {
                continue;
            }
            for (key, own) in properties {
                if resolved(root, own).get("const").is_some() {
                    continue;
                }
                let (path, name) = (format!("{path}/{key}"), format!("{name}.{key}"));
                let now = object.get(key);
                all.push(Place { path: path.clone(), name: name.clone(), others: others(root, own, now) });
                if let Some(now) = now {
                    places(root, own, now, (&path, &name), all);
                }
            }
        } else if let (Some(entries), Some(array)) = (form.get("items"), value.as_array()) {
            for (number, entry) in array.iter().enumerate() {
                places(root, entries, entry, (&format!("{path}/{number}"), &format!("{name}[]")), all);
            }
        } else if let (Some(entries), Some(object)) = (form.get("additionalProperties"), value.as_object())
            && entries.is_object()
        {
            for (key, entry) in object {
                places(root, entries, entry, (&format!("{path}/{key}"), &format!("{name}.*")), all);
            }
        }
    }
}

/// Hash of all output of a run after some steps of each stage; `None` where the case is refused.
fn shown(case: &Value) -> Option<u64> {
    let name = case["methods"].as_object()?.keys().next()?.clone();
    let case = Case::from_json(&case.to_string()).ok()?;
    let mut solver = colluvium::method(&name)?.build(&case).ok()?;
    let mut run = || -> Result<(), colluvium::case::SolverError> {
        for stage in 0..case.stages.len() {
            let now = solver.time();
            solver.begin_stage(stage, now)?;
            for _ in 0..STEPS {
                let dt = solver.limit().dt;
                solver.step(dt)?;
            }
        }
        Ok(())
    };
    let stopped = run().err().map(|error| error.to_string());
    let mut hasher = DefaultHasher::new();
    let outputs = (
        solver.frame(FrameRequest::Requested),
        solver.scalar_outputs(),
        solver.budget(),
        solver.time(),
        stopped,
    );
    format!("{outputs:?}").hash(&mut hasher);
    Some(hasher.finish())
}

/// `case` with a value at a path. `None` where a parent object is missing.
fn with_value(case: &Value, path: &str, value: &Value) -> Option<Value> {
    let (parent, key) = path.rsplit_once('/')?;
    let mut case = case.clone();
    case.pointer_mut(parent)?.as_object_mut()?.insert(key.to_owned(), value.clone());
    Some(case)
}

/// Effects of changes of an option, in the runs in which it is present or possible.
fn effect(all: &Runs, trials: &[(&String, Place)]) -> Effect {
    let mut best = Effect::Refused;
    // Cases that name the option come first.
    let (named, open): (Vec<_>, Vec<_>) =
        trials.iter().partition(|(run, place)| all[*run].pointer(&place.path).is_some());
    let open = open.iter().step_by(open.len().div_ceil(TRIALS).max(1)).copied();
    for (run, place) in named.into_iter().take(TRIALS).chain(open) {
        let base = &all[*run];
        let Some(before) = shown(base) else { continue };
        for value in &place.others {
            match with_value(base, &place.path, value).and_then(|case| shown(&case)) {
                Some(after) if after != before => return Effect::Changed,
                Some(_) => best = Effect::Ignored,
                None => {}
            }
        }
    }
    best
}

#[test]
fn every_option_changes_a_result_or_is_refused() {
    let families = families();
    let (root, all) = (colluvium::case_schema(), runs(&families));
    let mut options: BTreeMap<String, Vec<(&String, Place)>> = BTreeMap::new();
    for (run, case) in &all {
        for (method, value) in case["methods"].as_object().unwrap() {
            let schema = &root["properties"]["methods"]["properties"][method];
            let mut own = Vec::new();
            places(&root, schema, value, (&format!("/methods/{method}"), method), &mut own);
            for place in own {
                options.entry(place.name.clone()).or_default().push((run, place));
            }
        }
    }
    let effects: Vec<(&String, Effect)> =
        options.par_iter().map(|(name, trials)| (name, effect(&all, trials))).collect();
    let folder = tempfile::tempdir().unwrap();
    let elsewhere = trials(&families, folder.path());
    let known = |name: &str| elsewhere.iter().any(|trial| trial.option == name);
    let ignored: Vec<&String> = (effects.iter())
        .filter(|(name, effect)| *effect == Effect::Ignored && !known(name))
        .map(|(name, _)| *name)
        .collect();
    assert!(ignored.is_empty(), "of {} options these change nothing: {ignored:#?}", effects.len());
    let still: Vec<String> = elsewhere.par_iter().filter_map(unchanged).collect();
    assert!(still.is_empty(), "these change nothing in runs that are made for them: {still:#?}");
}

/// Option of a trial that changes neither the result of the run nor whether it is accepted, with the reason.
fn unchanged(trial: &Trial) -> Option<String> {
    let other = with_value(&trial.case, &trial.path, &trial.value).expect("the place is there");
    let both = [shown(&trial.case), shown(&other)];
    (both[0] == both[1]).then(|| format!("{} {}", trial.option, refusal(&trial.case).unwrap_or_default()))
}

/// Reason for which a case is refused.
fn refusal(case: &Value) -> Option<String> {
    let name = case["methods"].as_object()?.keys().next()?.clone();
    let case = match Case::from_json(&case.to_string()) {
        Ok(case) => case,
        Err(error) => return Some(error.to_string()),
    };
    colluvium::method(&name)?.build(&case).err().map(|error| error.to_string())
}
