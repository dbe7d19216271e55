//! Meshes from Gmsh: `.msh` as text and as binary, versions 2.2 and 4.1.
//!
//! This reader is part of the project, since existing crates read version 4.1 only, and geotechnical models are still written in 2.2, which
//! most generators offer. Triangles (in the plane) or tetrahedra become elements; physical groups become groups
//! of nodes.

mod diagnostics;
mod reader;

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, HashMap, HashSet};

use thiserror::Error;

use crate::mesh::msh::reader::MshReader;
use crate::{Mesh, MeshError};

/// Reason why a mesh file cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MshError {
    /// Text that does not follow the format.
    #[error("line {line}: {problem}")]
    Syntax {
        /// Number of the line, from 1.
        line: usize,
        /// Description of the error.
        problem: String,
    },
    /// Bytes that do not follow the format.
    #[error("byte {byte}: {problem}")]
    Binary {
        /// Number of bytes before the error.
        byte: usize,
        /// Description of the error.
        problem: String,
    },
    /// Invalid mesh.
    #[error("the mesh {0}")]
    Mesh(#[from] MeshError),
    /// Elements that do not share whole facets, or overlap.
    #[error("the mesh does not conform: {0}")]
    Conformity(String),
}

impl MshError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        "mesh"
    }
}

/// Round-off of the distance from the plane, over the extent of the mesh.
const ROUND_OFF: f64 = 1e-9;

/// Bound of the dimension of entities.
const DIMENSIONS: usize = 4;

/// Content of a file, before it becomes a mesh.
#[derive(Default)]
struct MshContent {
    /// Names of physical groups by dimension and tag.
    names: HashMap<(usize, i64), String>,
    /// Physical tags of the entities by dimension and tag (4.1).
    physical: HashMap<(usize, i64), Vec<i64>>,
    /// Number of a node by its tag.
    number: HashMap<u64, usize>,
    positions: Vec<[f64; 3]>,
    /// Tag of each node, and its line or byte in the file.
    tags: Vec<(u64, usize)>,
    /// Tag of each element.
    element_tags: Vec<u64>,
    /// Elements with `D + 1` corners.
    elements: Vec<Vec<usize>>,
    /// Sorted corners of each element.
    element_corners: HashSet<Vec<usize>>,
    groups: BTreeMap<String, Vec<usize>>,
}

impl<const D: usize> Mesh<D> {
    /// Reads the mesh from the bytes of a `.msh` file.
    ///
    /// # Errors
    /// With the position where the file does not follow the format, or the error of the mesh. In the plane,
    /// nodes outside of it are refused.
    pub fn from_msh(bytes: &[u8]) -> Result<Self, MshError> {
        read(bytes)
    }
}

fn read<const D: usize>(bytes: &[u8]) -> Result<Mesh<D>, MshError> {
    let mut source = MshReader::new(bytes);
    let mut content = MshContent::default();
    let mut version = None;
    while let Some(header) = source.next_section()? {
        let header = header.as_str();
        match (header, version) {
            ("$MeshFormat", _) => version = Some(format(&mut source)?),
            ("$PhysicalNames", Some(_)) => names(&mut source, &mut content)?,
            ("$Entities", Some(Version::V4)) => entities(&mut source, &mut content)?,
            ("$Nodes", Some(Version::V2)) => nodes_of_version_2(&mut source, &mut content)?,
            ("$Nodes", Some(Version::V4)) => nodes_of_version_4(&mut source, &mut content)?,
            ("$Elements", Some(Version::V2)) => elements_of_version_2(&mut source, &mut content, D)?,
            ("$Elements", Some(Version::V4)) => elements_of_version_4(&mut source, &mut content, D)?,
            (_, None) => return source.error("begins without $MeshFormat: not a Gmsh mesh"),
            (other, _) => {
                let end = format!("$End{}", other.trim_start_matches('$'));
                source.skip_past(&end)?;
                continue;
            }
        }
        let end = format!("$End{}", header.trim_start_matches('$'));
        source.read_section_end(&end)?;
    }
    let all = || content.positions.iter().flatten().map(|c| c.abs());
    let slack = ROUND_OFF * all().fold(0.0, f64::max);
    if let Some(k) = content.positions.iter().position(|x| x[D..].iter().any(|c| !(c.abs() <= slack))) {
        return Err(content.out_of_plane_error(k, &source));
    }
    let places: Vec<[f64; D]> = content.positions.iter().map(|x| std::array::from_fn(|c| x[c])).collect();
    let mesh =
        Mesh::new(&places, &content.elements, &content.groups).map_err(|error| content.with_tags(error))?;
    let clash = mesh.first_nonconformity();
    clash.map_or(Ok(()), |clash| Err(MshError::Conformity(content.describe_nonconformity(&mesh, &clash))))?;
    Ok(mesh)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    V2,
    V4,
}

fn format(source: &mut MshReader<'_>) -> Result<Version, MshError> {
    let line = source.line()?;
    let mut words = line.split_whitespace();
    let (version, kind, size) = (words.next(), words.next(), words.next());
    let version = match version.unwrap_or_default() {
        "2.2" | "2.1" | "2" => Version::V2,
        "4.1" => Version::V4,
        other => return source.error(format!("is of version {other}: save it as 2.2 or 4.1")),
    };
    match kind {
        Some("0") => {}
        Some("1") => source.begin_binary_part(size.and_then(|size| size.parse().ok()).unwrap_or(8))?,
        _ => return source.error("does not define whether it is text (0) or binary (1)"),
    }
    Ok(version)
}

fn names(source: &mut MshReader<'_>, content: &mut MshContent) -> Result<(), MshError> {
    // Names are text in binary files too.
    for _ in 0..source.count_in_text()? {
        let line = source.line()?;
        let mut words = line.split_whitespace().map(str::parse::<i64>);
        let (Some(Ok(dimension)), Some(Ok(tag))) = (words.next(), words.next()) else {
            return source.error("a physical name must follow its dimension and tag");
        };
        let quoted = line.split_once('"').and_then(|(_, rest)| rest.rsplit_once('"'));
        let Some((name, _)) = quoted else { return source.error("a physical name must be in quotes") };
        content.names.insert((usize::try_from(dimension).unwrap_or(DIMENSIONS), tag), name.to_owned());
    }
    Ok(())
}

fn entities(source: &mut MshReader<'_>, content: &mut MshContent) -> Result<(), MshError> {
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

impl MshContent {
    fn add_node(&mut self, tag: u64, place: [f64; 3], source: &MshReader<'_>) -> Result<(), MshError> {
        if self.number.insert(tag, self.positions.len()).is_some() {
            return source.error(format!("node {tag} is defined a second time"));
        }
        self.positions.push(place);
        self.tags.push((tag, source.location()));
        Ok(())
    }

    /// Adds an element with a tag, a Gmsh type and physical groups; types other than simplices are refused
    /// where they would be elements.
    fn add_element(
        &mut self,
        (tag, kind): (u64, i64),
        groups: &[(usize, i64)],
        source: &mut MshReader<'_>,
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
                return source.error(problem);
            }
            other => {
                return source.error(format!(
                    "element type {other}: only points, lines, 3-node triangles and 4-node tetrahedra are possible"
                ));
            }
        };
        let mut nodes = Vec::with_capacity(corners);
        for _ in 0..corners {
            let tag = if tags == Version::V2 { source.read_tag()? } else { source.size()? };
            let Some(&node) = self.number.get(&tag) else {
                return source.error(format!("there is no node {tag}"));
            };
            nodes.push(node);
        }
        for group in groups {
            let name = self.names.get(group).cloned().unwrap_or_else(|| group.1.to_string());
            self.groups.entry(name).or_default().extend(&nodes);
        }
        // Version 2.2 lists an element once for each of its groups.
        if own == dimension && self.element_corners.insert(sorted_nodes(&nodes)) {
            self.elements.push(nodes);
            self.element_tags.push(tag);
        }
        Ok(())
    }
}

fn sorted_nodes(nodes: &[usize]) -> Vec<usize> {
    let mut nodes = nodes.to_vec();
    nodes.sort_unstable();
    nodes
}

fn read_position(source: &mut MshReader<'_>) -> Result<[f64; 3], MshError> {
    Ok([source.double()?, source.double()?, source.double()?])
}

fn nodes_of_version_2(source: &mut MshReader<'_>, content: &mut MshContent) -> Result<(), MshError> {
    for _ in 0..source.count_in_text()? {
        let tag = source.read_tag()?;
        let place = read_position(source)?;
        content.add_node(tag, place, source)?;
        source.end_row();
    }
    Ok(())
}

fn nodes_of_version_4(source: &mut MshReader<'_>, content: &mut MshContent) -> Result<(), MshError> {
    let blocks = block_count(source)?;
    for _ in 0..blocks {
        let (dimension, _, parametric) = (source.int()?, source.int()?, source.int()?);
        let count = source.size()?;
        source.end_row();
        let tag = |source: &mut MshReader<'_>| {
            let tag = source.size()?;
            source.end_row();
            Ok(tag)
        };
        let tags = (0..count).map(|_| tag(source)).collect::<Result<Vec<u64>, MshError>>()?;
        for tag in tags {
            let place = read_position(source)?;
            content.add_node(tag, place, source)?;
            // Parametric coordinates on the entity, as many as it has dimensions.
            for _ in 0..if parametric == 0 { 0 } else { dimension } {
                source.double()?;
            }
            source.end_row();
        }
    }
    Ok(())
}

/// Number of blocks of a section of version 4; also reads the entity count and the range of tags.
fn block_count(source: &mut MshReader<'_>) -> Result<u64, MshError> {
    let [blocks, ..] = [source.size()?, source.size()?, source.size()?, source.size()?];
    source.end_row();
    Ok(blocks)
}

/// Dimension of a Gmsh element type; types that are refused afterwards do not matter.
fn dimension_of(kind: i64) -> usize {
    match kind {
        15 => 0,
        1 => 1,
        2 => 2,
        _ => 3,
    }
}

fn elements_of_version_2(
    source: &mut MshReader<'_>,
    content: &mut MshContent,
    dimension: usize,
) -> Result<(), MshError> {
    let mut left = source.count_in_text()?;
    while left > 0 {
        // In binary files elements of one type follow a common header; in text each has its own type, after its tag.
        let in_text = !source.is_binary();
        let mut tag = if in_text { source.read_tag()? } else { 0 };
        let kind = source.int()?;
        let following = if in_text { 1 } else { source.size_of_int()? };
        let count = source.size_of_int()?;
        if following == 0 || following > left {
            return source.error(format!("{following} elements of one type, where {left} are left"));
        }
        for _ in 0..following {
            if !in_text {
                tag = source.read_tag()?;
            }
            let tags = (0..count).map(|_| source.int()).collect::<Result<Vec<i64>, _>>()?;
            // The first tag is the physical group, zero for none.
            let group = tags.first().filter(|tag| **tag != 0).map(|&tag| (dimension_of(kind), tag));
            content.add_element((tag, kind), group.as_slice(), source, Version::V2, dimension)?;
            source.end_row();
        }
        left -= following;
    }
    Ok(())
}

fn elements_of_version_4(
    source: &mut MshReader<'_>,
    content: &mut MshContent,
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
            content.add_element((tag, kind), &groups, source, Version::V4, dimension)?;
            source.end_row();
        }
    }
    Ok(())
}
