//! Readers of closed triangle meshes.

use std::io::{Cursor, ErrorKind};
use std::path::Path;

use colluvium_points::surface::FacettedSurface;

use crate::mesh::triangulation;

/// Largest round-off of the vertices over the extent of a mesh.
const MAX_ROUND_OFF: f64 = 1e-5;

/// Number of bytes of the header of a binary STL file, including the number of triangles.
const STL_HEADER_BYTES: usize = 84;
/// Number of bytes of a triangle in a binary STL file.
const STL_TRIANGLE_BYTES: usize = 50;

/// Bytes of an STL file as one solid. A text file may contain several solids, and have its keywords in capitals.
fn merge_solids(bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    let count = bytes
        .get(STL_HEADER_BYTES - 4..STL_HEADER_BYTES)
        .and_then(|count| count.try_into().ok())
        .map(u32::from_le_bytes);
    let whole = |count: u32| STL_HEADER_BYTES + STL_TRIANGLE_BYTES * count as usize;
    let begins = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // The header of a binary file may contain any text.
    if !begins || count.is_some_and(|count| whole(count) == bytes.len()) {
        return Ok(bytes);
    }
    let text = String::from_utf8_lossy(&bytes).to_lowercase();
    let solids = text.lines().filter(|line| line.trim_start().starts_with("solid")).count();
    let ends = text.lines().filter(|line| line.trim_start().starts_with("endsolid")).count();
    if solids != ends {
        return Err(format!("begins {solids} solids and ends {ends}: it may be truncated"));
    }
    let is_inner =
        |line: &&str| !["solid", "endsolid"].iter().any(|word| line.trim_start().starts_with(word));
    let lines: Vec<&str> = text.lines().filter(is_inner).collect();
    Ok(format!("solid all\n{}\nendsolid all\n", lines.join("\n")).into_bytes())
}

/// First vertex line of a text file that does not have three numbers.
fn first_invalid_line(lines: &[String]) -> Option<String> {
    let is_wrong = |line: &&String| {
        let mut words = line.split_whitespace();
        let numbers = words.next() == Some("vertex");
        let read = |word: &str| word.parse::<f32>().ok().filter(|number| number.is_finite());
        numbers && (words.clone().count() != 3 || words.any(|word| read(word).is_none()))
    };
    let line = lines.iter().find(is_wrong)?;
    let cure = if line.contains(',') { ": write numbers with a decimal point" } else { "" };
    Some(format!(": {:?} does not have three numbers{cure}", line.trim()))
}

/// Reads an STL file, text or binary: the triangles of all its solids. Coordinates have single precision; corners with equal coordinates
/// are one vertex.
pub(crate) fn read_stl(
    file: &Path,
    placed: &dyn Fn(usize, f64) -> f64,
) -> Result<FacettedSurface<3>, String> {
    let bytes = std::fs::read(file).map_err(|error| format!("cannot be read: {error}"))?;
    let count = bytes
        .get(STL_HEADER_BYTES - 4..STL_HEADER_BYTES)
        .map_or(0, |count| count.iter().rev().fold(0, |sum, byte| 256 * sum + usize::from(*byte)));
    let length = bytes.len();
    let bytes = merge_solids(bytes)?;
    let lines = String::from_utf8_lossy(&bytes).lines().map(str::to_owned).collect::<Vec<_>>();
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => format!(
            "is not an STL file, or is truncated: its {length} bytes are not those of the header and the \
             {count} triangles of a binary STL file"
        ),
        _ => {
            let place = first_invalid_line(&lines).unwrap_or_default();
            format!("is not a readable STL file{place} ({error})")
        }
    })?;
    if mesh.faces.is_empty() {
        return Err("contains no triangles".to_owned());
    }
    let all = || mesh.vertices.iter();
    let extents = (0..3).map(|c| {
        let along = || all().map(|vertex| f64::from(vertex[c]));
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    });
    let (extent, far) = (
        extents.fold(0.0, f64::max),
        all().flat_map(|v| (0..3).map(|c| f64::from(v[c].abs()))).fold(0.0, f64::max),
    );
    if far * f64::from(f32::EPSILON) > MAX_ROUND_OFF * extent {
        return Err(format!(
            "lies up to {far:.0} m from its origin, where the single precision of STL is {:.1e} m, for a \
             mesh of {extent:.1} m: write it as an OBJ file with all digits",
            far * f64::from(f32::EPSILON)
        ));
    }
    let corner = |number: usize| -> [f64; 3] {
        std::array::from_fn(|c| placed(c, f64::from(mesh.vertices[number][c])))
    };
    let triangles: Vec<[[f64; 3]; 3]> = mesh.faces.iter().map(|face| face.vertices.map(corner)).collect();
    FacettedSurface::from_triangles(&triangles).map_err(|error| error.problem)
}

/// Reads a Wavefront OBJ file: the faces of all its objects, cut into triangles. Materials are ignored.
pub(crate) fn read_obj(
    file: &Path,
    placed: &dyn Fn(usize, f64) -> f64,
) -> Result<FacettedSurface<3>, String> {
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let text = join_continued_lines(&crate::read_text(file).map_err(|error| error.problem)?);
    let no_materials = |_: &Path| Ok(Default::default());
    let read = |text: &str| tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials);
    let (models, _) = read(&text).map_err(|error| {
        // The shortest beginning of the file that cannot be read ends with the faulty line.
        let ends = text.split_inclusive('\n').scan(0, |end, line| {
            *end += line.len();
            Some(*end)
        });
        let ends: Vec<usize> = ends.collect();
        let line = ends.partition_point(|end| read(&text[..*end]).is_ok());
        let content = text.lines().nth(line).unwrap_or_default().trim();
        format!("line {}: {content:?} cannot be read: {error}", line + 1)
    })?;
    check_weights(&text)?;
    let mut lines = face_lines(&text);
    let mut triangles = Vec::new();
    for tobj::Model { mesh, .. } in &models {
        let corner =
            |number: &u32| -> [f64; 3] { std::array::from_fn(|c| mesh.positions[3 * *number as usize + c]) };
        let in_case = |x: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| placed(c, x[c])) };
        // The library leaves out the counts of corners where all faces are triangles.
        let all_triangles = vec![3; mesh.indices.len() / 3];
        let counts = if mesh.face_arities.is_empty() { &all_triangles } else { &mesh.face_arities };
        let mut rest = mesh.indices.as_slice();
        for count in counts {
            let (face, after) = rest.split_at((*count as usize).min(rest.len()));
            rest = after;
            let corners: Vec<[f64; 3]> = face.iter().map(corner).collect();
            let line = lines.next().unwrap_or_default();
            let cut =
                triangulation::triangulate(&corners).map_err(|problem| format!("line {line}: {problem}"))?;
            triangles.extend(cut.into_iter().map(|t| t.map(|k| in_case(corners[k]))));
        }
    }
    if triangles.is_empty() {
        return Err("contains no faces".to_owned());
    }
    FacettedSurface::from_triangles(&triangles).map_err(|error| error.problem)
}

/// Text with continued lines (backslash at the end) joined into their first line.
fn join_continued_lines(text: &str) -> String {
    let (mut whole, mut owed) = (String::with_capacity(text.len()), 0);
    for line in text.lines() {
        if let Some(begun) = line.strip_suffix('\\') {
            whole.extend([begun, " "]);
            owed += 1;
        } else {
            whole.extend([line, "\n"]);
            // Blank lines keep the line numbers of the following lines.
            whole.extend(std::iter::repeat_n('\n', std::mem::take(&mut owed)));
        }
    }
    whole
}

/// Rejects vertices with a weight, which rational curves and surfaces have, but not meshes.
fn check_weights(text: &str) -> Result<(), String> {
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        if words.next() != Some("v") {
            continue;
        }
        let numbers: Vec<&str> = words.take(5).collect();
        if let [_, _, _, weight] = numbers[..]
            && weight.parse() != Ok(1.0)
        {
            return Err(format!(
                "line {}: the vertex has the fourth number {weight}, a weight: write x, y and z only",
                number + 1
            ));
        }
    }
    Ok(())
}

/// Line numbers, from 1, of the faces with three or more corners.
fn face_lines(text: &str) -> impl Iterator<Item = usize> {
    let is_face = |line: &str| {
        let mut words = line.split_whitespace();
        words.next() == Some("f") && words.nth(2).is_some()
    };
    text.lines().enumerate().filter(move |(_, line)| is_face(line)).map(|(number, _)| number + 1)
}
