//! Names and well-known texts of coordinate reference systems.

/// EPSG code in a name: `EPSG:25832`, `urn:ogc:def:crs:EPSG::25832` or `http://www.opengis.net/def/crs/EPSG/0/25832`. Of several codes, as
/// in a compound system with heights, it is the first.
pub(crate) fn epsg_code(name: &str) -> Option<u32> {
    let codes = name.split([',', '+', '&']).filter(|part| part.to_uppercase().contains("EPSG"));
    codes.filter_map(|part| part.trim().rsplit([':', '/', '#']).next()?.parse().ok()).next()
}

/// Error text of Web Mercator, whose lengths differ from those on the ground.
pub(crate) const WEB_MERCATOR: &str = "lies in Web Mercator, whose lengths are longer than those on the ground (1.5 times at 48°): project it to metres \
                                       of its place, for example to UTM";

/// Error text of other projections for world maps.
pub(crate) const WORLD_MAP: &str = "lies in a projection for maps of the world, whose lengths are not those on the ground: project it to metres of its \
                                    place, for example to UTM";

/// Error text of geocentric coordinates.
pub(crate) const GEOCENTRIC: &str = "lies in a geocentric CRS, whose coordinates count from the centre of the Earth: project it to metres, for example to UTM";

/// Horizontal part of a compound system, given by name or by well-known text.
pub(crate) fn horizontal_part(crs: &str) -> &str {
    if !is_well_known(crs) {
        return crs.split(" + ").next().unwrap_or(crs);
    }
    let inner = ["PROJCS[", "PROJCRS[", "PROJECTEDCRS[", "LOCAL_CS[", "ENGCRS[", "PROJCS(", "PROJCRS("];
    let Some(begin) = inner.iter().filter_map(|head| crs.find(head)).min() else {
        return crs;
    };
    let (mut depth, mut is_quoted) = (0, false);
    for (at, letter) in crs[begin..].char_indices() {
        match letter {
            '"' => is_quoted = !is_quoted,
            '[' | '(' if !is_quoted => depth += 1,
            ']' | ')' if !is_quoted => {
                depth -= 1;
                if depth == 0 {
                    return &crs[begin..=begin + at];
                }
            }
            _ => {}
        }
    }
    crs
}

/// Whether a text is a well-known text rather than a name.
pub(crate) fn is_well_known(text: &str) -> bool {
    text.contains(['[', '('])
        && text
            .split(['[', '('])
            .next()
            .is_some_and(|head| !head.is_empty() && head.chars().all(is_keyword_char))
}

/// Whether a letter can be part of a keyword of well-known text.
fn is_keyword_char(letter: char) -> bool {
    letter.is_ascii_uppercase() || letter == '_'
}

/// Calls `look` at each bracket of a well-known text, with the keywords of the open brackets and the text after the bracket.
pub(crate) fn visit_brackets(text: &str, mut look: impl FnMut(&[String], &str) -> Option<()>) {
    let (mut open, mut rest) = (Vec::<String>::new(), text);
    while let Some(at) = rest.find(['[', '(', ']', ')', '"']) {
        let (before, after) = (&rest[..at], &rest[at + 1..]);
        rest = after;
        match text.as_bytes()[text.len() - after.len() - 1] {
            b'"' => rest = after.find('"').map_or("", |end| &after[end + 1..]),
            b'[' | b'(' => {
                let keyword = before.rsplit([',', ' ', '\n', '\r', '\t']).next().unwrap_or_default();
                open.push(keyword.trim().to_uppercase());
                let _ = look(&open, after);
            }
            _ => drop(open.pop()),
        }
    }
}
