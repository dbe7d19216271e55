use crate::mesh::msh::*;

/// Mesh file of a square of two triangles with its base as a group, version 2.2.
const MESH_VERSION_2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"the base\"\n2 9 \"soil\"\n\
    $EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n40 0 1 0\n$EndNodes\n$Elements\n4\n\
    1 15 2 0 1 1\n2 1 2 7 1 1 2\n3 2 2 9 1 1 2 3\n4 2 2 9 1 1 3 40\n$EndElements\n";

/// Mesh file of the same square, version 4.1.
const MESH_VERSION_4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 7 \"the base\"\n2 9 \"soil\"\n\
    $EndPhysicalNames\n$Entities\n1 1 1 0\n1 0 0 0 0\n1 0 0 0 1 0 0 1 7 2 1 -2\n1 0 0 0 1 1 0 1 9 1 1\n$EndEntities\n\
    $Nodes\n2 4 1 40\n1 1 0 2\n1\n2\n0 0 0\n1 0 0\n2 1 0 2\n3\n40\n1 1 0\n0 1 0\n$EndNodes\n\
    $Elements\n2 3 1 3\n1 1 1 1\n1 1 2\n2 1 2 2\n2 1 2 3\n3 1 3 40\n$EndElements\n";

fn two_dimensional(text: &str) -> Mesh<2> {
    Mesh::from_msh(text.as_bytes()).unwrap()
}

/// Returns a text as the binary file that Gmsh would write: `$$name` begins numbers, of which `i` are integers, `s` sizes and others
/// coordinates; the part between bars is text.
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
            assert_eq!(Mesh::<2>::from_msh(&bytes).unwrap(), two_dimensional(MESH_VERSION_2));
            // A truncated file is refused, or gives the same mesh where only line ends are missing.
            for length in 0..bytes.len() - 1 {
                assert!(Mesh::<2>::from_msh(&bytes[..length]).is_err(), "{length} of {}", bytes.len());
            }
        }
    }
    let cut = Mesh::<2>::from_msh(&binary(&two.replace("i40|\n$EndElements\n", "|"), false))
        .unwrap_err()
        .to_string();
    assert!(cut.starts_with("byte ") && cut.contains("ends before a number"), "{cut}");
}

#[test]
fn round_off_is_no_distance_from_the_plane_and_lines_may_end_as_in_dos() {
    let rough = MESH_VERSION_2.replace("40 0 1 0\n", "40 0 1 1e-17\n").replace('\n', "\r\n");
    assert_eq!(two_dimensional(&rough), two_dimensional(MESH_VERSION_2));
    assert_eq!(two_dimensional(&format!("\u{feff}{MESH_VERSION_2}")), two_dimensional(MESH_VERSION_2));
}

#[test]
fn both_versions_give_the_same_mesh() {
    let two = two_dimensional(MESH_VERSION_2);
    assert_eq!(two, two_dimensional(MESH_VERSION_4));
    assert_eq!(two.elements().len(), 2);
    let base: Vec<[f64; 2]> =
        two.group("the base").unwrap().iter().map(|n| two.nodes()[*n as usize]).collect();
    assert_eq!(base, [[0.0, 0.0], [1.0, 0.0]]);
    assert_eq!(two.groups().collect::<Vec<_>>(), ["soil", "the base"]);
    let unknown = format!("$Comments\nby hand\n$EndComments\n{MESH_VERSION_2}");
    assert!(Mesh::<2>::from_msh(unknown.as_bytes()).is_err(), "the format comes first");
    assert_eq!(two_dimensional(&format!("{MESH_VERSION_2}$Comments\nby hand\n$EndComments\n")), two);
}

#[test]
fn an_element_of_two_groups_is_one_element() {
    let groups = MESH_VERSION_2
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
fn errors_in_mesh_files_name_their_line() {
    let refuse = |text: &str| Mesh::<2>::from_msh(text.as_bytes()).unwrap_err().to_string();
    assert_eq!(refuse("solid cube"), "line 1: \"solid cube\" is outside of any section");
    assert!(
        refuse(&MESH_VERSION_2.replace("2.2 0", "2.2 1"))
            .contains("line 2: is a binary mesh with an unknown order of bytes")
    );
    assert!(refuse(&MESH_VERSION_2.replace("2.2 0", "4.0 0")).contains("version 4.0"));
    assert!(refuse(&MESH_VERSION_2.replace("40 0 1 0", "40 0 one 0")).starts_with("line 14: \"one\""));
    assert!(refuse(&MESH_VERSION_2.replace("1 1 3 40", "1 1 3 41")).contains("no node 41"));
    assert!(
        refuse(&MESH_VERSION_2.replace("4 2 2 9 1 1 3 40", "4 3 2 9 1 1 2 3 40")).contains("element type 3")
    );
    let off = refuse(&MESH_VERSION_2.replace("2 1 0 0\n", "2 1 0 0.5\n"));
    assert!(off.starts_with("line 12: node 2 lies at [1.0, 0.0, 0.5] m, off the plane z = 0"), "{off}");
    let upright = "1 0 0 0\n2 1 0 0\n3 1 0 1\n40 0 0 1\n";
    let upright = refuse(&MESH_VERSION_2.replace("1 0 0 0\n2 1 0 0\n3 1 1 0\n40 0 1 0\n", upright));
    assert!(
        upright.starts_with("line 13: node 3") && upright.contains("in the plane of x and z"),
        "{upright}"
    );
    assert!(refuse(MESH_VERSION_2.trim_end_matches("$EndElements\n")).contains("ends in the middle"));
    assert!(refuse(&MESH_VERSION_2.replace("9 1 1 2 3", "9 1 1 3 2")).contains("volume"), "clockwise");
    assert!(
        Mesh::<3>::from_msh(MESH_VERSION_2.as_bytes()).unwrap_err().to_string().contains("no tetrahedron")
    );
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
    let hangs = refuse(&format!("{square}15 1 0.5 0\n16 2 0 0\n"), &format!("{two}23 2 2 9 1 12 16 15\n"));
    assert!(
        hangs.contains(
            "does not conform: node 15 lies at [1.0, 0.5] m on a side of element 21, but is not a \
             corner of this element"
        ),
        "{hangs}"
    );
    let over = refuse(&format!("{square}15 0.6 0.2 0\n16 2 0 0\n"), &format!("{two}23 2 2 9 1 15 16 13\n"));
    assert!(over.contains("node 15 lies at [0.6, 0.2] m inside of element 21"), "{over}");
    let twin = refuse(&format!("{square}15 1 1e-12 0\n16 2 0 0\n"), &format!("{two}23 2 2 9 1 15 16 13\n"));
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
    assert!(thrice.contains("a third element"), "{thrice}");
    let flat = refuse(square, "21 2 2 9 1 11 13 12\n22 2 2 9 1 11 13 14\n");
    assert!(flat.contains("element 21 around"), "{flat}");
}
