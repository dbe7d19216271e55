//! Meshes from Gmsh: the text form of `.msh`, versions 2.2 and 4.1.
//!
//! A reader of our own: the crates there are read version 4.1 only, and geotechnical models are still written in 2.2,
//! which most generators offer. Triangles (in the plane) or tetrahedra become elements; physical groups become groups
//! of nodes.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Display;
use std::str::{FromStr, SplitWhitespace};

use colluvium_parallel::once_per_dimension;
use thiserror::Error;

use crate::{Mesh, MeshError};

/// Why a mesh file cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MshError {
    /// The text is not what the format asks for.
    #[error("line {line}: {problem}")]
    Syntax {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
    /// The mesh itself is of no use.
    #[error("the mesh {0}")]
    Mesh(#[from] MeshError),
}

/// Entities of more dimensions than this there are not.
const DIMENSIONS: usize = 4;

/// What a file says, before it is a mesh.
#[derive(Default)]
struct Content {
    /// Names of physical groups by dimension and tag.
    names: HashMap<(usize, i64), String>,
    /// Physical tags of the entities by dimension and tag (4.1).
    physical: HashMap<(usize, i64), Vec<i64>>,
    /// Number of a node by its tag.
    number: HashMap<u64, usize>,
    places: Vec<[f64; 3]>,
    /// Elements with `D + 1` corners.
    elements: Vec<Vec<usize>>,
    /// The corners of each, in order.
    listed: HashSet<Vec<usize>>,
    groups: BTreeMap<String, Vec<usize>>,
}

impl<const D: usize> Mesh<D> {
    /// The mesh of a `.msh` text.
    ///
    /// # Errors
    /// With the line where the text is not what the format asks for, or what is wrong with the mesh. In the plane,
    /// nodes off it are refused.
    pub fn from_msh(text: &str) -> Result<Self, MshError> {
        once_per_dimension!(D, read(text: &str) -> Read)
    }
}

/// What comes of a text.
type Read<const D: usize> = Result<Mesh<D>, MshError>;

fn read<const D: usize>(text: &str) -> Read<D> {
    let mut lines = Lines { lines: text.lines(), number: 0 };
    let mut content = Content::default();
    let mut version = None;
    while let Some(header) = lines.find()? {
        match (header, version) {
            ("$MeshFormat", _) => version = Some(format(&mut lines)?),
            ("$PhysicalNames", Some(_)) => names(&mut lines, &mut content)?,
            ("$Entities", Some(Version::Four)) => entities(&mut lines, &mut content)?,
            ("$Nodes", Some(Version::Two)) => nodes_of_two(&mut lines, &mut content)?,
            ("$Nodes", Some(Version::Four)) => nodes_of_four(&mut lines, &mut content)?,
            ("$Elements", Some(Version::Two)) => elements_of_two(&mut lines, &mut content, D)?,
            ("$Elements", Some(Version::Four)) => elements_of_four(&mut lines, &mut content, D)?,
            (_, None) => return lines.fail("begins without $MeshFormat: not a Gmsh mesh"),
            (other, _) => {
                let end = format!("$End{}", other.trim_start_matches('$'));
                lines.skip_past(&end)?;
                continue;
            }
        }
        let end = format!("$End{}", header.trim_start_matches('$'));
        lines.expect(&end)?;
    }
    if let Some(k) = content.places.iter().position(|x| x[D..].iter().any(|c| *c != 0.0)) {
        let place = content.places[k];
        return lines.fail(format!("a node lies at {place:?} m, off the plane z = 0"));
    }
    let places: Vec<[f64; D]> = content.places.iter().map(|x| std::array::from_fn(|c| x[c])).collect();
    Ok(Mesh::new(&places, &content.elements, &content.groups)?)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// The lines of a text, counted.
struct Lines<'a> {
    lines: std::str::Lines<'a>,
    number: usize,
}

impl<'a> Lines<'a> {
    fn fail<T>(&self, problem: impl Into<String>) -> Result<T, MshError> {
        Err(MshError::Syntax { line: self.number, problem: problem.into() })
    }

    fn line(&mut self) -> Result<&'a str, MshError> {
        self.number += 1;
        match self.lines.next() {
            Some(line) => Ok(line.trim()),
            None => self.fail("the file ends in the middle of a section"),
        }
    }

    /// The next header of a section, blank lines skipped; `None` at the end.
    fn find(&mut self) -> Result<Option<&'a str>, MshError> {
        for line in self.lines.by_ref() {
            self.number += 1;
            match line.trim() {
                "" => {}
                header if header.starts_with('$') => return Ok(Some(header)),
                other => {
                    let start: String = other.chars().take(20).collect();
                    return self.fail(format!("{start:?} stands outside of any section"));
                }
            }
        }
        Ok(None)
    }

    fn skip_past(&mut self, end: &str) -> Result<(), MshError> {
        while self.line()? != end {}
        Ok(())
    }

    fn expect(&mut self, end: &str) -> Result<(), MshError> {
        let line = self.line()?;
        if line == end { Ok(()) } else { self.fail(format!("{line:?} where {end} must stand")) }
    }

    fn words(&mut self) -> Result<Words<'a>, MshError> {
        let line = self.line()?;
        Ok(Words { words: line.split_whitespace(), line: self.number })
    }

    /// The one number of a line.
    fn count(&mut self) -> Result<usize, MshError> {
        self.words()?.next()
    }
}

/// The numbers of a line.
struct Words<'a> {
    words: SplitWhitespace<'a>,
    line: usize,
}

impl Words<'_> {
    fn next<T: FromStr<Err: Display>>(&mut self) -> Result<T, MshError> {
        let fail = |problem: String| Err(MshError::Syntax { line: self.line, problem });
        match self.words.next() {
            None => fail("has too few numbers".to_owned()),
            Some(word) => word.parse().or_else(|error: T::Err| fail(format!("{word:?}: {error}"))),
        }
    }
}

fn format(lines: &mut Lines<'_>) -> Result<Version, MshError> {
    let mut words = lines.words()?;
    let (version, binary): (String, usize) = (words.next()?, words.next()?);
    if binary != 0 {
        return lines.fail("is a binary mesh: save it as text (ASCII)");
    }
    match version.as_str() {
        "2.2" | "2.1" | "2" => Ok(Version::Two),
        "4.1" => Ok(Version::Four),
        other => lines.fail(format!("is of version {other}: save it as 2.2 or 4.1")),
    }
}

fn names(lines: &mut Lines<'_>, content: &mut Content) -> Result<(), MshError> {
    for _ in 0..lines.count()? {
        let line = lines.line()?;
        let mut words = Words { words: line.split_whitespace(), line: lines.number };
        let (dimension, tag) = (words.next()?, words.next()?);
        let quoted = line.split_once('"').and_then(|(_, rest)| rest.rsplit_once('"'));
        let Some((name, _)) = quoted else { return lines.fail("a physical name stands in quotes") };
        content.names.insert((dimension, tag), name.to_owned());
    }
    Ok(())
}

fn entities(lines: &mut Lines<'_>, content: &mut Content) -> Result<(), MshError> {
    let mut words = lines.words()?;
    let counts: Vec<usize> = (0..DIMENSIONS).map(|_| words.next()).collect::<Result<_, _>>()?;
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let mut words = lines.words()?;
            let tag: i64 = words.next()?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                words.next::<f64>()?;
            }
            let physical: usize = words.next()?;
            let tags = (0..physical).map(|_| words.next()).collect::<Result<Vec<i64>, _>>()?;
            content.physical.insert((dimension, tag), tags);
        }
    }
    Ok(())
}

impl Content {
    fn add_node(&mut self, tag: u64, place: [f64; 3], lines: &Lines<'_>) -> Result<(), MshError> {
        if self.number.insert(tag, self.places.len()).is_some() {
            return lines.fail(format!("node {tag} stands here a second time"));
        }
        self.places.push(place);
        Ok(())
    }

    /// Takes an element of a type of Gmsh that belongs to physical groups; other types than simplices are refused
    /// where they would be elements.
    fn add_element(
        &mut self,
        kind: usize,
        groups: &[(usize, i64)],
        words: &mut Words<'_>,
        dimension: usize,
    ) -> Result<(), MshError> {
        let fail = |problem: String| Err(MshError::Syntax { line: words.line, problem });
        let (own, corners) = match kind {
            15 => (0, 1),
            1 => (1, 2),
            2 => (2, 3),
            4 => (3, 4),
            3 | 9 | 10 | 16 => {
                return fail(format!("element type {kind}: only 3-node triangles are possible in the plane"));
            }
            other => {
                return fail(format!(
                    "element type {other}: only points, lines, 3-node triangles and 4-node tetrahedra are possible"
                ));
            }
        };
        let mut nodes = Vec::with_capacity(corners);
        for _ in 0..corners {
            let tag: u64 = words.next()?;
            let Some(&node) = self.number.get(&tag) else {
                return Err(MshError::Syntax {
                    line: words.line,
                    problem: format!("there is no node {tag}"),
                });
            };
            nodes.push(node);
        }
        for group in groups {
            let name = self.names.get(group).cloned().unwrap_or_else(|| group.1.to_string());
            self.groups.entry(name).or_default().extend(&nodes);
        }
        // Version 2.2 lists an element once for each of its groups.
        if own == dimension && self.listed.insert(sorted(&nodes)) {
            self.elements.push(nodes);
        }
        Ok(())
    }
}

fn sorted(nodes: &[usize]) -> Vec<usize> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes
}

fn nodes_of_two(lines: &mut Lines<'_>, content: &mut Content) -> Result<(), MshError> {
    for _ in 0..lines.count()? {
        let mut words = lines.words()?;
        let tag = words.next()?;
        content.add_node(tag, [words.next()?, words.next()?, words.next()?], lines)?;
    }
    Ok(())
}

fn nodes_of_four(lines: &mut Lines<'_>, content: &mut Content) -> Result<(), MshError> {
    let blocks = lines.count()?;
    for _ in 0..blocks {
        let mut words = lines.words()?;
        let (_, _, parametric): (usize, i64, usize) = (words.next()?, words.next()?, words.next()?);
        let count: usize = words.next()?;
        if parametric != 0 {
            return lines.fail("has parametric nodes: save the mesh without them");
        }
        let tags = (0..count).map(|_| lines.words()?.next()).collect::<Result<Vec<u64>, _>>()?;
        for tag in tags {
            let mut words = lines.words()?;
            content.add_node(tag, [words.next()?, words.next()?, words.next()?], lines)?;
        }
    }
    Ok(())
}

/// Dimension of what has a type of Gmsh; those that are refused afterwards do not matter.
fn dimension_of(kind: usize) -> usize {
    match kind {
        15 => 0,
        1 => 1,
        2 => 2,
        _ => 3,
    }
}

fn elements_of_two(lines: &mut Lines<'_>, content: &mut Content, dimension: usize) -> Result<(), MshError> {
    for _ in 0..lines.count()? {
        let mut words = lines.words()?;
        let _tag: u64 = words.next()?;
        let (kind, count): (usize, usize) = (words.next()?, words.next()?);
        let tags = (0..count).map(|_| words.next()).collect::<Result<Vec<i64>, _>>()?;
        // The first tag is the physical group, zero for none.
        let group = tags.first().filter(|tag| **tag != 0).map(|&tag| (dimension_of(kind), tag));
        content.add_element(kind, group.as_slice(), &mut words, dimension)?;
    }
    Ok(())
}

fn elements_of_four(lines: &mut Lines<'_>, content: &mut Content, dimension: usize) -> Result<(), MshError> {
    let blocks = lines.count()?;
    for _ in 0..blocks {
        let mut words = lines.words()?;
        let (entity_dimension, entity): (usize, i64) = (words.next()?, words.next()?);
        let (kind, count): (usize, usize) = (words.next()?, words.next()?);
        let tags = content.physical.get(&(entity_dimension, entity)).cloned().unwrap_or_default();
        let groups: Vec<(usize, i64)> = tags.into_iter().map(|tag| (entity_dimension, tag.abs())).collect();
        for _ in 0..count {
            let mut words = lines.words()?;
            let _tag: u64 = words.next()?;
            content.add_element(kind, &groups, &mut words, dimension)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles with its base as a group, as version 2.2.
    const TWO: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"the base\"\n2 9 \"soil\"\n\
        $EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n40 0 1 0\n$EndNodes\n$Elements\n4\n\
        1 15 2 0 1 1\n2 1 2 7 1 1 2\n3 2 2 9 1 1 2 3\n4 2 2 9 1 1 3 40\n$EndElements\n";

    /// The same as version 4.1.
    const FOUR: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"the base\"\n2 9 \"soil\"\n\
        $EndPhysicalNames\n$Entities\n1 1 1 0\n1 0 0 0 0\n1 0 0 0 1 0 0 1 7 2 1 -2\n1 0 0 0 1 1 0 1 9 1 1\n$EndEntities\n\
        $Nodes\n2 4 1 40\n1 1 0 2\n1\n2\n0 0 0\n1 0 0\n2 1 0 2\n3\n40\n1 1 0\n0 1 0\n$EndNodes\n\
        $Elements\n2 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 2\n2 1 2 3\n3 1 3 40\n$EndElements\n";

    #[test]
    fn both_versions_give_the_same_mesh() {
        let two = Mesh::<2>::from_msh(TWO).unwrap();
        assert_eq!(two, Mesh::<2>::from_msh(FOUR).unwrap());
        assert_eq!(two.elements().len(), 2);
        let base: Vec<[f64; 2]> =
            two.group("the base").unwrap().iter().map(|n| two.nodes()[*n as usize]).collect();
        assert_eq!(base, [[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(two.groups().collect::<Vec<_>>(), ["soil", "the base"]);
        let unknown = format!("$Comments\nby hand\n$EndComments\n{TWO}");
        assert!(Mesh::<2>::from_msh(&unknown).is_err(), "the format comes first");
        assert_eq!(Mesh::<2>::from_msh(&format!("{TWO}$Comments\nby hand\n$EndComments\n")).unwrap(), two);
    }

    #[test]
    fn an_element_of_two_groups_is_one_element() {
        let groups = TWO
            .replace("$Elements\n4\n", "$Elements\n5\n")
            .replace("$PhysicalNames\n2\n", "$PhysicalNames\n3\n");
        let named = groups.replace("2 9 \"soil\"\n", "2 9 \"soil\"\n2 10 \"lower\"\n");
        let twice = named.replace("4 2 2 9 1 1 3 40\n", "4 2 2 9 1 1 3 40\n5 2 2 10 1 1 2 3\n");
        let mesh = Mesh::<2>::from_msh(&twice).unwrap();
        assert_eq!(mesh.elements().len(), 2);
        assert_eq!(mesh.groups().collect::<Vec<_>>(), ["lower", "soil", "the base"]);
        assert_eq!((mesh.group("lower").unwrap().len(), mesh.group("soil").unwrap().len()), (3, 4));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let refuse = |text: &str| Mesh::<2>::from_msh(text).unwrap_err().to_string();
        assert_eq!(refuse("solid cube"), "line 1: \"solid cube\" stands outside of any section");
        assert!(refuse(&TWO.replace("2.2 0", "2.2 1")).contains("line 2: is a binary mesh"));
        assert!(refuse(&TWO.replace("2.2 0", "4.0 0")).contains("version 4.0"));
        assert!(refuse(&TWO.replace("40 0 1 0", "40 0 one 0")).starts_with("line 14: \"one\""));
        assert!(refuse(&TWO.replace("1 1 3 40", "1 1 3 41")).contains("no node 41"));
        assert!(refuse(&TWO.replace("4 2 2 9 1 1 3 40", "4 3 2 9 1 1 2 3 40")).contains("element type 3"));
        assert!(refuse(&TWO.replace("40 0 1 0", "40 0 1 0.5")).contains("off the plane"));
        assert!(refuse(TWO.trim_end_matches("$EndElements\n")).contains("ends in the middle"));
        assert!(refuse(&TWO.replace("9 1 1 2 3", "9 1 1 3 2")).contains("volume"), "clockwise");
        assert!(Mesh::<3>::from_msh(TWO).unwrap_err().to_string().contains("no tetrahedron"));
    }
}
