//! Test cases that cover all pairs of options.
//!
//! A family of cases is a JSON file: a `base` case and `factors`, each a list of named levels. A level sets values of the case by JSON
//! pointers (`null` removes one). A row chooses one level of each factor. The rows cover each pair of levels of two factors that some case
//! allows.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Map, Value};

/// Base case and the factors that vary it.
pub struct CaseFamily {
    /// Name of the family: that of its file.
    pub name: String,
    base: Value,
    factors: Vec<Factor>,
}

/// Option and its levels; the first level is that of the base.
struct Factor {
    name: String,
    levels: Vec<(String, Map<String, Value>)>,
}

/// Row of a family of cases: the index of the level of each factor.
pub type LevelRow = Vec<usize>;

impl CaseFamily {
    /// Reads a family of cases.
    ///
    /// # Errors
    /// When the file cannot be read or has another form, as a text that names it.
    pub fn read(file: &Path) -> Result<Self, String> {
        let wrong = |problem: &dyn std::fmt::Display| format!("{}: {problem}", file.display());
        let text = std::fs::read_to_string(file).map_err(|error| wrong(&error))?;
        let json: Value = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
        let factors = json["factors"].as_array().ok_or_else(|| wrong(&"no factors"))?;
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let factors = factors.iter().map(factor).collect::<Option<Vec<_>>>();
        let factors = factors.ok_or_else(|| wrong(&"a factor has a name and levels of one key each"))?;
        Ok(Self { name, base: json["base"].clone(), factors })
    }

    /// All families of a folder, in the order of their file names.
    ///
    /// # Errors
    /// See [`CaseFamily::read`].
    pub fn read_all(folder: &Path) -> Result<Vec<Self>, String> {
        let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let files: BTreeSet<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        files
            .iter()
            .filter(|file| file.extension().is_some_and(|end| end == "json"))
            .map(|file| Self::read(file))
            .collect()
    }

    /// Row of the base with the given levels of the given factors.
    ///
    /// # Panics
    /// When a factor or level does not exist.
    pub fn row(&self, levels: &[(&str, &str)]) -> LevelRow {
        let mut row = vec![0; self.factors.len()];
        for (name, level) in levels {
            let place = self.factors.iter().position(|factor| factor.name == *name);
            let place = place.unwrap_or_else(|| panic!("{} has no factor {name:?}", self.name));
            let found = self.factors[place].levels.iter().position(|(own, _)| own == level);
            row[place] = found.unwrap_or_else(|| panic!("{name} has no level {level:?}"));
        }
        row
    }

    /// Converts a row of another version of the family by the names of factors and levels, or by their numbers without such names.
    pub fn row_of(&self, other: &Self, row: &[usize]) -> LevelRow {
        let level = |(place, factor): (usize, &Factor)| {
            let known = other.factors.iter().position(|own| own.name == factor.name).unwrap_or(place);
            let number = row.get(known).copied().unwrap_or(0);
            let name = other.factors.get(known).and_then(|own| own.levels.get(number)).map(|own| &own.0);
            factor.levels.iter().position(|own| Some(&own.0) == name).unwrap_or(number)
        };
        self.factors.iter().enumerate().map(level).collect()
    }

    /// Case of a row. Levels that the family does not have are ignored.
    pub fn case(&self, row: &[usize]) -> Value {
        let mut case = self.base.clone();
        for (factor, level) in self.factors.iter().zip(row) {
            for (pointer, value) in factor.levels.get(*level).into_iter().flat_map(|(_, values)| values) {
                set_value(&mut case, pointer, value);
            }
        }
        case
    }

    /// Text with the levels of a row that differ from the base.
    pub fn description(&self, row: &[usize]) -> String {
        let chosen = self.factors.iter().zip(row).filter(|(_, level)| **level > 0);
        let names: Vec<String> = chosen
            .map(|(factor, level)| {
                format!("{}: {}", factor.name, factor.levels.get(*level).map_or("-", |own| &own.0))
            })
            .collect();
        if names.is_empty() { "base".to_owned() } else { names.join(", ") }
    }

    /// Rows with one level that differs from the base, and the base itself, for which `accepts` accepts the case.
    pub fn single_changes(&self, accepts: &dyn Fn(&Value) -> bool) -> Vec<LevelRow> {
        let mut rows = vec![vec![0; self.factors.len()]];
        for (place, factor) in self.factors.iter().enumerate() {
            for level in 1..factor.levels.len() {
                let mut row = vec![0; self.factors.len()];
                row[place] = level;
                rows.push(row);
            }
        }
        rows.retain(|row| accepts(&self.case(row)));
        rows
    }

    /// Rows that together contain each pair of levels for which `accepts` accepts a case. Each row begins with a missing pair and takes,
    /// for each further factor, the level that adds most missing pairs.
    pub fn pairwise_rows(&self, accepts: &dyn Fn(&Value) -> bool) -> Vec<LevelRow> {
        let mut open = self.all_pairs();
        let mut rows = Vec::new();
        while let Some(pair) = open.pop_first() {
            let mut row = vec![0; self.factors.len()];
            for (place, level) in [pair.0, pair.1] {
                row[place] = level;
            }
            if !accepts(&self.case(&row)) {
                continue;
            }
            for place in (0..row.len()).filter(|place| *place != pair.0.0 && *place != pair.1.0) {
                self.choose_level(place, &mut row, &open, accepts);
            }
            open.retain(|(a, b)| row[a.0] != a.1 || row[b.0] != b.1);
            rows.push(row);
        }
        rows
    }

    /// All pairs of levels of two factors.
    fn all_pairs(&self) -> BTreeSet<LevelPair> {
        let mut pairs = BTreeSet::new();
        for (a, first) in self.factors.iter().enumerate() {
            for (b, second) in self.factors.iter().enumerate().skip(a + 1) {
                let levels =
                    (0..first.levels.len()).flat_map(|i| (0..second.levels.len()).map(move |j| (i, j)));
                pairs.extend(levels.map(|(i, j)| ((a, i), (b, j))));
            }
        }
        pairs
    }

    /// Sets the factor at `place` to the accepted level that adds most missing pairs.
    fn choose_level(
        &self,
        place: usize,
        row: &mut LevelRow,
        open: &BTreeSet<LevelPair>,
        accepts: &dyn Fn(&Value) -> bool,
    ) {
        let gain = |level: usize| {
            let others = row.iter().enumerate().filter(|(other, _)| *other != place);
            others.filter(|(other, own)| open.contains(&pair((place, level), (*other, **own)))).count()
        };
        let mut levels: Vec<(usize, usize)> = (0..self.factors[place].levels.len())
            .map(|level| (gain(level), level))
            .filter(|(gain, _)| *gain > 0)
            .collect();
        levels.sort_by_key(|(gain, level)| (std::cmp::Reverse(*gain), *level));
        for (_, level) in levels {
            let before = std::mem::replace(&mut row[place], level);
            if accepts(&self.case(row)) {
                return;
            }
            row[place] = before;
        }
    }
}

/// Two factors by number, each with a level; the smaller factor number is first.
type LevelPair = ((usize, usize), (usize, usize));

/// Pair of levels, the one of the earlier factor first.
fn pair(a: (usize, usize), b: (usize, usize)) -> LevelPair {
    if a.0 < b.0 { (a, b) } else { (b, a) }
}

/// Factor with its levels, from JSON.
fn factor(json: &Value) -> Option<Factor> {
    let levels = json["levels"].as_array()?.iter().map(|level| {
        let (name, values) = level.as_object().filter(|level| level.len() == 1)?.iter().next()?;
        Some((name.clone(), values.as_object()?.clone()))
    });
    Some(Factor { name: json["factor"].as_str()?.to_owned(), levels: levels.collect::<Option<Vec<_>>>()? })
}

/// Sets a value by its JSON pointer. Missing parent objects are made, and a list may grow by one entry; `null` removes the key.
pub fn set_value(json: &mut Value, pointer: &str, value: &Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap_or(("", pointer));
    if json.pointer(parent).is_none() {
        set_value(json, parent, &Value::Object(Map::new()));
    }
    match json.pointer_mut(parent) {
        Some(Value::Object(object)) if value.is_null() => drop(object.remove(key)),
        Some(Value::Object(object)) => drop(object.insert(key.to_owned(), value.clone())),
        Some(Value::Array(entries)) => match key.parse::<usize>() {
            Ok(number) if number < entries.len() => entries[number] = value.clone(),
            _ => entries.push(value.clone()),
        },
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn family() -> CaseFamily {
        let levels = |name: &str, count: usize| Factor {
            name: name.to_owned(),
            levels: (0..count)
                .map(|level| (level.to_string(), Map::from_iter([(format!("/{name}"), json!(level))])))
                .collect(),
        };
        let factors = vec![levels("a", 3), levels("b", 4), levels("c", 2), levels("d", 3)];
        CaseFamily { name: "test".to_owned(), base: json!({}), factors }
    }

    #[test]
    fn each_pair_that_is_accepted_is_in_a_row() {
        let family = family();
        let accepts = |case: &Value| case["a"] != 2 || case["b"] != 3;
        let rows = family.pairwise_rows(&accepts);
        assert!(rows.len() <= 16, "{} rows", rows.len());
        for ((a, i), (b, j)) in family.all_pairs() {
            let is_there = rows.iter().any(|row| row[a] == i && row[b] == j);
            assert_eq!(is_there, (a, i, b, j) != (0, 2, 1, 3), "{a} {i} {b} {j}");
        }
        assert!(rows.iter().all(|row| accepts(&family.case(row))));
    }

    #[test]
    fn a_row_keeps_its_levels_when_others_are_added() {
        let (old, mut new) = (family(), family());
        new.factors[1].levels.insert(1, ("new".to_owned(), Map::new()));
        new.factors.swap(2, 3);
        let row = new.row(&[("a", "2"), ("b", "3"), ("d", "1")]);
        assert_eq!(old.description(&old.row_of(&new, &row)), "a: 2, b: 3, d: 1");
        new.factors[0].name = "renamed".to_owned();
        assert_eq!(old.row_of(&new, &row)[0], 2);
    }

    #[test]
    fn a_level_sets_values_by_pointers() {
        let mut json = json!({ "list": [1, 2], "gone": 1 });
        set_value(&mut json, "/list/1", &json!(3));
        set_value(&mut json, "/list/2", &json!(4));
        set_value(&mut json, "/new/of/it", &json!(5));
        set_value(&mut json, "/gone", &Value::Null);
        assert_eq!(json, json!({ "list": [1, 3, 4], "new": { "of": { "it": 5 } } }));
    }
}
