//! Meshes from Gmsh: `.msh` as text and as binary, versions 2.2 and 4.1.
//!
//! A reader of our own: the crates there are read version 4.1 only, and geotechnical models are still written in 2.2,
//! which most generators offer. Triangles (in the plane) or tetrahedra become elements; physical groups become groups
//! of nodes.

mod faults;
mod source;

use std::collections::{BTreeMap, HashMap, HashSet};

use colluvium_parallel::once_per_dimension;
use thiserror::Error;

use crate::{Mesh, MeshError};
use source::Source;

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
    /// The bytes are not what the format asks for.
    #[error("byte {byte}: {problem}")]
    Binary {
        /// Number of bytes before it.
        byte: usize,
        /// What is wrong there.
        problem: String,
    },
    /// The mesh itself is of no use.
    #[error("the mesh {0}")]
    Mesh(#[from] MeshError),
    /// Elements do not meet in whole facets, or lie over one another.
    #[error("the mesh does not conform: {0}")]
    Conformity(String),
}

/// Distance from the plane over the extent of the mesh that is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Entities of more dimensions than this there are not.
const DIMENSIONS: usize = 4;

/// Content of a file, before it is a mesh.
#[derive(Default)]
struct Content {
    /// Names of physical groups by dimension and tag.
    names: HashMap<(usize, i64), String>,
    /// Physical tags of the entities by dimension and tag (4.1).
    physical: HashMap<(usize, i64), Vec<i64>>,
    /// Number of a node by its tag.
    number: HashMap<u64, usize>,
    places: Vec<[f64; 3]>,
    /// Tag of each node, and the line or byte where it stands.
    tags: Vec<(u64, usize)>,
    /// Tag of each element.
    element_tags: Vec<u64>,
    /// Elements with `D + 1` corners.
    elements: Vec<Vec<usize>>,
    /// The corners of each, in order.
    listed: HashSet<Vec<usize>>,
    groups: BTreeMap<String, Vec<usize>>,
}

impl<const D: usize> Mesh<D> {
    /// The mesh of the bytes of a `.msh` file.
    ///
    /// # Errors
    /// With the place where the file is not what the format asks for, or what is wrong with the mesh. In the plane,
    /// nodes off it are refused.
    pub fn from_msh(bytes: &[u8]) -> Result<Self, MshError> {
        once_per_dimension!(D, read(bytes: &[u8]) -> Read)
    }
}

/// Mesh of a file, or its fault.
type Read<const D: usize> = Result<Mesh<D>, MshError>;

fn read<const D: usize>(bytes: &[u8]) -> Read<D> {
    let mut source = Source::new(bytes);
    let mut content = Content::default();
    let mut version = None;
    while let Some(header) = source.find()? {
        let header = header.as_str();
        match (header, version) {
            ("$MeshFormat", _) => version = Some(format(&mut source)?),
            ("$PhysicalNames", Some(_)) => names(&mut source, &mut content)?,
            ("$Entities", Some(Version::Four)) => entities(&mut source, &mut content)?,
            ("$Nodes", Some(Version::Two)) => nodes_of_two(&mut source, &mut content)?,
            ("$Nodes", Some(Version::Four)) => nodes_of_four(&mut source, &mut content)?,
            ("$Elements", Some(Version::Two)) => elements_of_two(&mut source, &mut content, D)?,
            ("$Elements", Some(Version::Four)) => elements_of_four(&mut source, &mut content, D)?,
            (_, None) => return source.fail("begins without $MeshFormat: not a Gmsh mesh"),
            (other, _) => {
                let end = format!("$End{}", other.trim_start_matches('$'));
                source.skip_past(&end)?;
                continue;
            }
        }
        let end = format!("$End{}", header.trim_start_matches('$'));
        source.expect(&end)?;
    }
    let all = || content.places.iter().flatten().map(|c| c.abs());
    let slack = ROUND_OFF * all().fold(0.0, f64::max);
    if let Some(k) = content.places.iter().position(|x| x[D..].iter().any(|c| !(c.abs() <= slack))) {
        return Err(content.off_the_plane(k, &source));
    }
    let places: Vec<[f64; D]> = content.places.iter().map(|x| std::array::from_fn(|c| x[c])).collect();
    let mesh =
        Mesh::new(&places, &content.elements, &content.groups).map_err(|error| content.with_tags(error))?;
    let clash = mesh.clash();
    clash.map_or(Ok(()), |clash| Err(MshError::Conformity(content.described(&mesh, &clash))))?;
    Ok(mesh)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

fn format(source: &mut Source<'_>) -> Result<Version, MshError> {
    let line = source.line()?;
    let mut words = line.split_whitespace();
    let (version, kind, size) = (words.next(), words.next(), words.next());
    let version = match version.unwrap_or_default() {
        "2.2" | "2.1" | "2" => Version::Two,
        "4.1" => Version::Four,
        other => return source.fail(format!("is of version {other}: save it as 2.2 or 4.1")),
    };
    match kind {
        Some("0") => {}
        Some("1") => source.begin_binary(size.and_then(|size| size.parse().ok()).unwrap_or(8))?,
        _ => return source.fail("does not say whether it is text (0) or binary (1)"),
    }
    Ok(version)
}

fn names(source: &mut Source<'_>, content: &mut Content) -> Result<(), MshError> {
    // Names are text in binary files too.
    for _ in 0..source.count_in_text()? {
        let line = source.line()?;
        let mut words = line.split_whitespace().map(str::parse::<i64>);
        let (Some(Ok(dimension)), Some(Ok(tag))) = (words.next(), words.next()) else {
            return source.fail("a physical name has its dimension and tag before it");
        };
        let quoted = line.split_once('"').and_then(|(_, rest)| rest.rsplit_once('"'));
        let Some((name, _)) = quoted else { return source.fail("a physical name stands in quotes") };
        content.names.insert((usize::try_from(dimension).unwrap_or(DIMENSIONS), tag), name.to_owned());
    }
    Ok(())
}

fn entities(source: &mut Source<'_>, content: &mut Content) -> Result<(), MshError> {
    let counts: Vec<u64> = (0..DIMENSIONS).map(|_| source.size()).collect::<Result<_, _>>()?;
    source.end_row();
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            let tag = source.int()?;
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                source.double()?;
            }
            let physical = source.size()?;
            let tags = (0..physical).map(|_| source.int()).collect::<Result<Vec<i64>, _>>()?;
            if dimension > 0 && source.is_binary() {
                for _ in 0..source.size()? {
                    source.int()?;
                }
            }
            source.end_row();
            content.physical.insert((dimension, tag), tags);
        }
    }
    Ok(())
}

impl Content {
    fn add_node(&mut self, tag: u64, place: [f64; 3], source: &Source<'_>) -> Result<(), MshError> {
        if self.number.insert(tag, self.places.len()).is_some() {
            return source.fail(format!("node {tag} stands here a second time"));
        }
        self.places.push(place);
        self.tags.push((tag, source.place()));
        Ok(())
    }

    /// Takes an element with a tag and a type of Gmsh that belongs to physical groups; other types than simplices are refused
    /// where they would be elements.
    fn add_element(
        &mut self,
        (tag, kind): (u64, i64),
        groups: &[(usize, i64)],
        source: &mut Source<'_>,
        tags: Version,
        dimension: usize,
    ) -> Result<(), MshError> {
        let (own, corners) = match kind {
            15 => (0, 1),
            1 => (1, 2),
            2 => (2, 3),
            4 => (3, 4),
            3 | 9 | 10 | 16 => {
                let problem = format!("element type {kind}: only 3-node triangles are possible in the plane");
                return source.fail(problem);
            }
            other => {
                return source.fail(format!(
                    "element type {other}: only points, lines, 3-node triangles and 4-node tetrahedra are possible"
                ));
            }
        };
        let mut nodes = Vec::with_capacity(corners);
        for _ in 0..corners {
            let tag = if tags == Version::Two { source.tag()? } else { source.size()? };
            let Some(&node) = self.number.get(&tag) else {
                return source.fail(format!("there is no node {tag}"));
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
            self.element_tags.push(tag);
        }
        Ok(())
    }
}

fn sorted(nodes: &[usize]) -> Vec<usize> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes
}

fn place(source: &mut Source<'_>) -> Result<[f64; 3], MshError> {
    Ok([source.double()?, source.double()?, source.double()?])
}

fn nodes_of_two(source: &mut Source<'_>, content: &mut Content) -> Result<(), MshError> {
    for _ in 0..source.count_in_text()? {
        let tag = source.tag()?;
        let place = place(source)?;
        content.add_node(tag, place, source)?;
        source.end_row();
    }
    Ok(())
}

fn nodes_of_four(source: &mut Source<'_>, content: &mut Content) -> Result<(), MshError> {
    let blocks = block_count(source)?;
    for _ in 0..blocks {
        let (dimension, _, parametric) = (source.int()?, source.int()?, source.int()?);
        let count = source.size()?;
        source.end_row();
        let tag = |source: &mut Source<'_>| {
            let tag = source.size()?;
            source.end_row();
            Ok(tag)
        };
        let tags = (0..count).map(|_| tag(source)).collect::<Result<Vec<u64>, MshError>>()?;
        for tag in tags {
            let place = place(source)?;
            content.add_node(tag, place, source)?;
            // Coordinates on the entity, as many as it has dimensions.
            for _ in 0..if parametric == 0 { 0 } else { dimension } {
                source.double()?;
            }
            source.end_row();
        }
    }
    Ok(())
}

/// The number of blocks of a section of version 4, before the numbers and the range of tags of what is in them.
fn block_count(source: &mut Source<'_>) -> Result<u64, MshError> {
    let [blocks, ..] = [source.size()?, source.size()?, source.size()?, source.size()?];
    source.end_row();
    Ok(blocks)
}

/// Dimension of what has a type of Gmsh; those that are refused afterwards do not matter.
fn dimension_of(kind: i64) -> usize {
    match kind {
        15 => 0,
        1 => 1,
        2 => 2,
        _ => 3,
    }
}

fn elements_of_two(source: &mut Source<'_>, content: &mut Content, dimension: usize) -> Result<(), MshError> {
    let mut left = source.count_in_text()?;
    while left > 0 {
        // In binary files elements of one type follow its head; in text each has its own, behind its tag.
        let in_text = !source.is_binary();
        let mut tag = if in_text { source.tag()? } else { 0 };
        let kind = source.int()?;
        let following = if in_text { 1 } else { source.size_of_int()? };
        let count = source.size_of_int()?;
        if following == 0 || following > left {
            return source.fail(format!("{following} elements of one type, where {left} are left"));
        }
        for _ in 0..following {
            if !in_text {
                tag = source.tag()?;
            }
            let tags = (0..count).map(|_| source.int()).collect::<Result<Vec<i64>, _>>()?;
            // The first tag is the physical group, zero for none.
            let group = tags.first().filter(|tag| **tag != 0).map(|&tag| (dimension_of(kind), tag));
            content.add_element((tag, kind), group.as_slice(), source, Version::Two, dimension)?;
            source.end_row();
        }
        left -= following;
    }
    Ok(())
}

fn elements_of_four(
    source: &mut Source<'_>,
    content: &mut Content,
    dimension: usize,
) -> Result<(), MshError> {
    let blocks = block_count(source)?;
    for _ in 0..blocks {
        let (entity_dimension, entity, kind) = (source.int()?, source.int()?, source.int()?);
        let count = source.size()?;
        source.end_row();
        let entity_dimension = usize::try_from(entity_dimension).unwrap_or(DIMENSIONS);
        let tags = content.physical.get(&(entity_dimension, entity)).cloned().unwrap_or_default();
        let groups: Vec<(usize, i64)> = tags.into_iter().map(|tag| (entity_dimension, tag.abs())).collect();
        for _ in 0..count {
            let tag = source.size()?;
            content.add_element((tag, kind), &groups, source, Version::Four, dimension)?;
            source.end_row();
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

    fn two_dimensional(text: &str) -> Mesh<2> {
        Mesh::from_msh(text.as_bytes()).unwrap()
    }

    /// A text as the binary file that Gmsh would write: `$$name` begins numbers, of which `i` are whole, `s` sizes and others coordinates;
    /// what stands between bars is text.
    fn binary(text: &str, is_big_endian: bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut put = |little: &[u8]| {
            if is_big_endian { bytes.extend(little.iter().rev()) } else { bytes.extend(little) }
        };
        for (number, part) in text.split('|').enumerate() {
            if number % 2 == 0 {
                part.bytes().for_each(|byte| put(&[byte]));
                continue;
            }
            for word in part.split_whitespace() {
                if let Some(int) = word.strip_prefix('i') {
                    put(&int.parse::<i32>().unwrap().to_le_bytes());
                } else if let Some(size) = word.strip_prefix('s') {
                    put(&size.parse::<u64>().unwrap().to_le_bytes());
                } else {
                    put(&word.parse::<f64>().unwrap().to_le_bytes());
                }
            }
        }
        bytes
    }

    #[test]
    fn binary_files_of_both_versions_and_orders_give_the_mesh_of_the_text() {
        let two = "$MeshFormat\n2.2 1 8\n|i1|\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"the base\"\n2 9 \"soil\"\n$EndPhysicalNames\n\
            $Nodes\n4\n|i1 0 0 0 i2 1 0 0 i3 1 1 0 i40 0 1 0|\n$EndNodes\n$Elements\n4\n\
            |i15 i1 i2 i1 i0 i1 i1 i1 i1 i2 i2 i7 i1 i1 i2 i2 i2 i2 i3 i9 i1 i1 i2 i3 i4 i9 i1 i1 i3 i40|\n$EndElements\n";
        let four = "$MeshFormat\n4.1 1 8\n|i1|\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"the base\"\n2 9 \"soil\"\n$EndPhysicalNames\n\
            $Entities\n|s1 s1 s1 s0 i1 0 0 0 s0 i1 0 0 0 1 0 0 s1 i7 s2 i1 i-2 i1 0 0 0 1 1 0 s1 i9 s1 i1|\n$EndEntities\n\
            $Nodes\n|s2 s4 s1 s40 i1 i1 i0 s2 s1 s2 0 0 0 1 0 0 i2 i1 i1 s2 s3 s40 1 1 0 0.5 0.5 0 1 0 0.5 0.5|\n$EndNodes\n\
            $NodeData\nanything\n$EndNodeData\n\
            $Elements\n|s2 s3 s1 s3 i1 i1 i1 s1 s1 s1 s2 i2 i1 i2 s2 s2 s1 s2 s3 s3 s1 s3 s40|\n$EndElements\n";
        for text in [two, four] {
            for is_big_endian in [false, true] {
                let bytes = binary(text, is_big_endian);
                assert_eq!(Mesh::<2>::from_msh(&bytes).unwrap(), two_dimensional(TWO));
                // Cut anywhere it is refused, or the same where only line ends are lost.
                for length in 0..bytes.len() - 1 {
                    assert!(Mesh::<2>::from_msh(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
                }
            }
        }
        let cut = Mesh::<2>::from_msh(&binary(&two.replace("i40|\n$EndElements\n", "|"), false))
            .unwrap_err()
            .to_string();
        assert!(cut.starts_with("byte ") && cut.contains("ends where a number must stand"), "{cut}");
    }

    #[test]
    fn round_off_is_no_distance_from_the_plane_and_lines_may_end_as_in_dos() {
        let rough = TWO.replace("40 0 1 0\n", "40 0 1 1e-17\n").replace('\n', "\r\n");
        assert_eq!(two_dimensional(&rough), two_dimensional(TWO));
        assert_eq!(two_dimensional(&format!("\u{feff}{TWO}")), two_dimensional(TWO));
    }

    #[test]
    fn both_versions_give_the_same_mesh() {
        let two = two_dimensional(TWO);
        assert_eq!(two, two_dimensional(FOUR));
        assert_eq!(two.elements().len(), 2);
        let base: Vec<[f64; 2]> =
            two.group("the base").unwrap().iter().map(|n| two.nodes()[*n as usize]).collect();
        assert_eq!(base, [[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(two.groups().collect::<Vec<_>>(), ["soil", "the base"]);
        let unknown = format!("$Comments\nby hand\n$EndComments\n{TWO}");
        assert!(Mesh::<2>::from_msh(unknown.as_bytes()).is_err(), "the format comes first");
        assert_eq!(two_dimensional(&format!("{TWO}$Comments\nby hand\n$EndComments\n")), two);
    }

    #[test]
    fn an_element_of_two_groups_is_one_element() {
        let groups = TWO
            .replace("$Elements\n4\n", "$Elements\n5\n")
            .replace("$PhysicalNames\n2\n", "$PhysicalNames\n3\n");
        let named = groups.replace("2 9 \"soil\"\n", "2 9 \"soil\"\n2 10 \"lower\"\n");
        let twice = named.replace("4 2 2 9 1 1 3 40\n", "4 2 2 9 1 1 3 40\n5 2 2 10 1 1 2 3\n");
        let mesh = two_dimensional(&twice);
        assert_eq!(mesh.elements().len(), 2);
        assert_eq!(mesh.groups().collect::<Vec<_>>(), ["lower", "soil", "the base"]);
        assert_eq!((mesh.group("lower").unwrap().len(), mesh.group("soil").unwrap().len()), (3, 4));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let refuse = |text: &str| Mesh::<2>::from_msh(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(refuse("solid cube"), "line 1: \"solid cube\" stands outside of any section");
        assert!(
            refuse(&TWO.replace("2.2 0", "2.2 1")).contains("line 2: is a binary mesh whose order of bytes")
        );
        assert!(refuse(&TWO.replace("2.2 0", "4.0 0")).contains("version 4.0"));
        assert!(refuse(&TWO.replace("40 0 1 0", "40 0 one 0")).starts_with("line 14: \"one\""));
        assert!(refuse(&TWO.replace("1 1 3 40", "1 1 3 41")).contains("no node 41"));
        assert!(refuse(&TWO.replace("4 2 2 9 1 1 3 40", "4 3 2 9 1 1 2 3 40")).contains("element type 3"));
        let off = refuse(&TWO.replace("2 1 0 0\n", "2 1 0 0.5\n"));
        assert!(off.starts_with("line 12: node 2 lies at [1.0, 0.0, 0.5] m, off the plane z = 0"), "{off}");
        let upright = "1 0 0 0\n2 1 0 0\n3 1 0 1\n40 0 0 1\n";
        let upright = refuse(&TWO.replace("1 0 0 0\n2 1 0 0\n3 1 1 0\n40 0 1 0\n", upright));
        assert!(
            upright.starts_with("line 13: node 3") && upright.contains("in the plane of x and z"),
            "{upright}"
        );
        assert!(refuse(TWO.trim_end_matches("$EndElements\n")).contains("ends in the middle"));
        assert!(refuse(&TWO.replace("9 1 1 2 3", "9 1 1 3 2")).contains("volume"), "clockwise");
        assert!(Mesh::<3>::from_msh(TWO.as_bytes()).unwrap_err().to_string().contains("no tetrahedron"));
    }

    #[test]
    fn meshes_that_do_not_conform_are_refused_with_the_numbers_of_the_file() {
        let refuse = |nodes: &str, elements: &str| {
            let text = format!(
                "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{nodes}$EndNodes\n$Elements\n{}\n{elements}$EndElements\n",
                nodes.lines().count(),
                elements.lines().count()
            );
            Mesh::<2>::from_msh(text.as_bytes()).unwrap_err().to_string()
        };
        let square = "11 0 0 0\n12 1 0 0\n13 1 1 0\n14 0 1 0\n";
        let two = "21 2 2 9 1 11 12 13\n22 2 2 9 1 11 13 14\n";
        let hangs =
            refuse(&format!("{square}15 1 0.5 0\n16 2 0 0\n"), &format!("{two}23 2 2 9 1 12 16 15\n"));
        assert!(
            hangs.contains("does not conform: node 15 lies at [1.0, 0.5] m on a side of element 21, of which it is no corner"),
            "{hangs}"
        );
        let over =
            refuse(&format!("{square}15 0.6 0.2 0\n16 2 0 0\n"), &format!("{two}23 2 2 9 1 15 16 13\n"));
        assert!(over.contains("node 15 lies at [0.6, 0.2] m inside of element 21"), "{over}");
        let twin =
            refuse(&format!("{square}15 1 1e-12 0\n16 2 0 0\n"), &format!("{two}23 2 2 9 1 15 16 13\n"));
        assert!(
            twin.contains("nodes")
                && twin.contains(" 12 ")
                && twin.contains(" 15 ")
                && twin.contains("not merged"),
            "{twin}"
        );
        let same = refuse(&format!("{square}15 1 0 0\n16 2 0 0\n"), &format!("{two}23 2 2 9 1 15 16 13\n"));
        assert!(same.contains("nodes 12 and 15 lie at one place, [1.0, 0.0] m"), "{same}");
        let thrice = refuse(&format!("{square}15 0 2 0\n"), &format!("{two}23 2 2 9 1 11 13 15\n"));
        assert!(thrice.contains("third one"), "{thrice}");
        let flat = refuse(square, "21 2 2 9 1 11 13 12\n22 2 2 9 1 11 13 14\n");
        assert!(flat.contains("element 21 around"), "{flat}");
    }
}
