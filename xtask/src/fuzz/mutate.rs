//! Structure-aware mutations of a JSON value.

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

/// Numbers that often break programs.
const NUMBERS: [f64; 19] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    2.0,
    1e-12,
    1e-300,
    5e-324,
    1e6,
    1e9,
    1e15,
    9_007_199_254_740_993.0,
    1e17,
    1e300,
    -1e300,
    1.7e308,
    -1e-300,
    3.0,
];

/// Texts that often break programs.
const TEXTS: [&str; 9] = [
    "",
    " ",
    "\n",
    "\u{1b}[31m",
    "../../x",
    "/dev/full",
    "a/b",
    "ü\u{0301}\u{202e}",
    "none-of-the-names-in-the-case-file",
];

/// Makes one to three random changes of a JSON value. `others` are values from which parts are taken.
pub fn mutate(value: &mut Value, others: &[Value], random: &mut ChaCha8Rng) {
    for _ in 0..random.random_range(1..=3) {
        let count = value_count(value);
        let place = random.random_range(0..count);
        let part = others
            .choose(random)
            .map(|other| nth_value(other, random.random_range(0..value_count(other))).clone());
        if let Some(node) = nth_mut(value, &mut { place }) {
            change_value(node, part, random);
        }
    }
}

/// Number of values in a value, itself included.
fn value_count(value: &Value) -> usize {
    1 + match value {
        Value::Array(items) => items.iter().map(value_count).sum(),
        Value::Object(map) => map.values().map(value_count).sum::<usize>(),
        _ => 0,
    }
}

/// Value with a number in depth-first order; the whole value where there are fewer.
fn nth_value(value: &Value, number: usize) -> &Value {
    /// Node of a JSON value by its number in depth-first order.
    fn find<'a>(value: &'a Value, left: &mut usize) -> Option<&'a Value> {
        if *left == 0 {
            return Some(value);
        }
        *left -= 1;
        match value {
            Value::Array(items) => items.iter().find_map(|item| find(item, left)),
            Value::Object(map) => map.values().find_map(|item| find(item, left)),
            _ => None,
        }
    }
    find(value, &mut { number }).unwrap_or(value)
}

/// Mutable node of a JSON value by its number in depth-first order.
fn nth_mut<'a>(value: &'a mut Value, left: &mut usize) -> Option<&'a mut Value> {
    if *left == 0 {
        return Some(value);
    }
    *left -= 1;
    match value {
        Value::Array(items) => items.iter_mut().find_map(|item| nth_mut(item, left)),
        Value::Object(map) => map.values_mut().find_map(|item| nth_mut(item, left)),
        _ => None,
    }
}

/// Changes a JSON value at random.
fn change_value(node: &mut Value, part: Option<Value>, random: &mut ChaCha8Rng) {
    match random.random_range(0..10) {
        0 => *node = value_of_other_type(random),
        1 => *node = part.unwrap_or(Value::Null),
        _ => match node {
            Value::Object(map) => {
                let keys: Vec<String> = map.keys().cloned().collect();
                let Some(key) = keys.choose(random).cloned() else { return };
                match random.random_range(0..4) {
                    0 | 1 => drop(map.remove(&key)),
                    2 => {
                        if let Some(content) = map.remove(&key) {
                            map.insert(misspelt(&key, random), content);
                        }
                    }
                    _ => {
                        let other = keys.choose(random).cloned().unwrap_or_default();
                        map.insert(other, map.get(&key).cloned().unwrap_or_default());
                    }
                }
            }
            Value::Array(items) if items.is_empty() => items.extend(part),
            Value::Array(items) => {
                let at = random.random_range(0..items.len());
                match random.random_range(0..4) {
                    0 => drop(items.remove(at)),
                    1 => items.push(items[at].clone()),
                    2 => items.clear(),
                    _ => {
                        let other = random.random_range(0..items.len());
                        items.swap(at, other);
                    }
                }
            }
            Value::Number(number) => {
                let x = number.as_f64().unwrap_or(0.0);
                let extreme = *NUMBERS.choose(random).unwrap_or(&0.0);
                let choices = [-x, 2.0 * x, 1e3 * x, 1e-3 * x, x + 1.0, extreme, extreme, extreme, x.floor()];
                *node = number_of(*choices.choose(random).unwrap_or(&x));
            }
            Value::String(text) => {
                *text = match random.random_range(0..3) {
                    0 => misspelt(text, random),
                    1 => "x".repeat(random.random_range(1..300)),
                    _ => (*TEXTS.choose(random).unwrap_or(&"")).to_owned(),
                };
            }
            Value::Bool(value) => *value = !*value,
            Value::Null => *node = value_of_other_type(random),
        },
    }
}

/// JSON number that is an integer where it is whole and small.
fn number_of(x: f64) -> Value {
    if x.fract() == 0.0 && x.abs() < 1e15 && !(x == 0.0 && x.is_sign_negative()) {
        json!(x as i64)
    } else {
        json!(x)
    }
}

/// Random value of any type.
fn value_of_other_type(random: &mut ChaCha8Rng) -> Value {
    let kinds = [
        Value::Null,
        json!(true),
        json!("text"),
        json!([]),
        json!({}),
        json!(-3),
        json!("1.5"),
        json!([1, 2, 3, 4]),
        json!([[0, 0], [1]]),
        json!(18_446_744_073_709_551_615u64),
    ];
    kinds.choose(random).cloned().unwrap_or_default()
}

/// Text with a random misspelling.
fn misspelt(text: &str, random: &mut ChaCha8Rng) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    if letters.is_empty() {
        return "x".to_owned();
    }
    let at = random.random_range(0..letters.len());
    match random.random_range(0..3) {
        0 => drop(letters.remove(at)),
        1 => letters.insert(at, 'x'),
        _ => letters[at] = letters[at].to_ascii_uppercase(),
    }
    letters.into_iter().collect()
}
