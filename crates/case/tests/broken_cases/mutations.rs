//! Random changes of the structure and the text of cases: none leads to a panic.

use colluvium_case::Case;
use proptest::prelude::*;
use serde_json::Value;

use super::non_finite_numbers::numbers;
use super::sound;

/// All JSON pointers into a value.
fn pointers(value: &Value, at: &str, all: &mut Vec<String>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(key, child)| {
            all.push(format!("{at}/{key}"));
            pointers(child, &format!("{at}/{key}"), all);
        }),
        Value::Array(items) => items.iter().enumerate().for_each(|(i, child)| {
            all.push(format!("{at}/{i}"));
            pointers(child, &format!("{at}/{i}"), all);
        }),
        _ => {}
    }
}

fn anything() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<f64>()
            .prop_filter_map("JSON has no NaN", |x| serde_json::Number::from_f64(x).map(Value::Number)),
        any::<i64>().prop_map(Value::from),
        "[a-z-]{0,8}".prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 16, 4, |inner| {
        prop_oneof![
            proptest::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
            proptest::collection::hash_map("[a-z_]{1,8}", inner, 0..4)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

fn survives(text: &str) {
    match Case::from_json(text) {
        Ok(case) => {
            let _ = case.warnings();
            assert_eq!(Case::from_json(&case.to_json()).expect("what it wrote itself"), case);
        }
        Err(errors) => {
            assert!(!errors.0.is_empty());
            assert!(errors.0.iter().all(|error| !error.path.is_empty() && !error.problem().is_empty()));
        }
    }
}

/// Change of a case's structure at one of its JSON pointers.
#[derive(Clone, Debug)]
enum Change {
    Replace(Value),
    Remove,
    /// Inserts a value beside the position: under this key in an object, before it in a list.
    Insert(String, Value),
    /// Replaces the value here by a copy of that at another position.
    Copy(prop::sample::Index),
}

fn change() -> impl Strategy<Value = (prop::sample::Index, Change)> {
    let key = prop_oneof![
        "[a-z_]{0,8}".boxed(),
        prop::sample::select(vec!["kind", "name", "side", "position", "shape", "value", "radius", "axis"])
            .prop_map(str::to_owned)
            .boxed(),
    ];
    let change = prop_oneof![
        anything().prop_map(Change::Replace),
        Just(Change::Remove),
        (key, anything()).prop_map(|(key, value)| Change::Insert(key, value)),
        any::<prop::sample::Index>().prop_map(Change::Copy),
    ];
    (any::<prop::sample::Index>(), change)
}

fn apply(case: &mut Value, place: &prop::sample::Index, change: Change) {
    let mut all = Vec::new();
    pointers(case, "", &mut all);
    if all.is_empty() {
        return;
    }
    let pointer = place.get(&all);
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let slot = match change {
        Change::Replace(value) => value,
        Change::Copy(from) => case.pointer(&all[from.index(all.len())]).cloned().unwrap_or_default(),
        Change::Remove => match case.pointer_mut(parent) {
            Some(Value::Object(map)) => return drop(map.remove(key)),
            Some(Value::Array(items)) => return drop(items.remove(key.parse().expect("an index"))),
            _ => return,
        },
        Change::Insert(name, value) => match case.pointer_mut(parent) {
            Some(Value::Object(map)) => return drop(map.insert(name, value)),
            Some(Value::Array(items)) => return items.insert(key.parse().expect("an index"), value),
            _ => return,
        },
    };
    // A key that contains a slash leads to no value.
    if let Some(place) = case.pointer_mut(pointer) {
        *place = slot;
    }
}

/// Change of a case's text.
#[derive(Clone, Debug)]
enum Edit {
    Delete(usize),
    Insert(Vec<u8>),
    Overwrite(Vec<u8>),
}

fn edit() -> impl Strategy<Value = (prop::sample::Index, Edit)> {
    let telling = prop::sample::select(b"{}[]\",:.-+eE0189 \n\\ntf\0\xff".to_vec());
    let byte = prop_oneof![any::<u8>(), telling.clone(), telling];
    let bytes = proptest::collection::vec(byte, 1..6);
    let edit = prop_oneof![
        (1usize..40).prop_map(Edit::Delete),
        bytes.clone().prop_map(Edit::Insert),
        bytes.prop_map(Edit::Overwrite),
    ];
    (any::<prop::sample::Index>(), edit)
}

fn edit_text(text: &mut Vec<u8>, place: &prop::sample::Index, edit: Edit) {
    let at = place.index(text.len() + 1);
    let (end, new) = match edit {
        Edit::Delete(count) => (at + count, Vec::new()),
        Edit::Insert(bytes) => (at, bytes),
        Edit::Overwrite(bytes) => (at + bytes.len(), bytes),
    };
    let end = end.min(text.len());
    text.splice(at..end, new);
}

#[test]
fn a_file_that_is_no_text_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.json");
    std::fs::write(&path, [b'{', 0xff, 0xfe, b'}']).unwrap();
    assert!(Case::from_file(&path).unwrap_err().to_string().contains("cannot be read"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn mutated_cases_never_panic(changes in proptest::collection::vec(change(), 1..5)) {
        let mut case: Value = serde_json::from_str(&numbers().to_json()).unwrap();
        for (place, change) in changes {
            apply(&mut case, &place, change);
        }
        survives(&case.to_string());
    }

    #[test]
    fn edited_texts_never_panic(edits in proptest::collection::vec(edit(), 1..4), plain in any::<bool>()) {
        let mut text = if plain { sound().to_string() } else { numbers().to_json() }.into_bytes();
        for (place, edit) in edits {
            edit_text(&mut text, &place, edit);
        }
        survives(&String::from_utf8_lossy(&text));
    }

    #[test]
    fn any_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        survives(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn any_json_never_panics(value in anything()) {
        survives(&value.to_string());
    }

    #[test]
    fn any_text_never_panics(text in "\\PC{0,200}") {
        survives(&text);
    }

    #[test]
    fn torn_files_never_panic(cut in any::<prop::sample::Index>()) {
        let text = sound().to_string();
        let mut end = cut.index(text.len());
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        survives(&text[..end]);
    }
}
