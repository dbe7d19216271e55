//! Animations of runs, with axes, bodies and materials from their case.

use serde_json::Value;

use crate::plots::{Animation, PointClasses, RigidGeometry, SCRIPT, STYLE, View};

/// View of a case: all three axes in three dimensions, else the axes of `plane`. Points are coloured by `fields` (default fields where it
/// is empty), by bodies and by materials.
pub fn view(case: &Value, plane: [usize; 2], fields: &[String]) -> View {
    let size = |axis: usize| case["gravity"][axis].as_f64().unwrap_or(0.0).abs();
    let solid = case["space"] == "3d";
    let axes = if solid { vec![0, 1, 2] } else { plane.to_vec() };
    let against =
        axes.iter().copied().max_by(|a, b| size(*a).total_cmp(&size(*b))).filter(|axis| size(*axis) > 0.0);
    let last = axes.last().copied().unwrap_or(1);
    View {
        vertical_axis: against.unwrap_or(last),
        axes,
        fields: fields.to_vec(),
        classes: vec![body_classes(case, "body", "name"), body_classes(case, "material", "material")],
        ground: RigidGeometry::default(),
        bytes: 0,
    }
}

/// Classes of the bodies of a case by a text key, such as the material.
fn body_classes(case: &Value, name: &str, key: &str) -> PointClasses {
    let mut names: Vec<String> = Vec::new();
    let mut of_body = Vec::new();
    for (number, body) in case["bodies"].as_array().into_iter().flatten().enumerate() {
        let text = body[key].as_str().map_or_else(|| format!("{name} {}", number + 1), str::to_owned);
        let known = names.iter().position(|known| *known == text);
        of_body.push(known.unwrap_or(names.len()));
        if known.is_none() {
            names.push(text);
        }
    }
    PointClasses { name: name.to_owned(), names, of_body }
}

/// HTML of an animation with its scripts. A page with several animations takes [`Animation::element`] of each and [`scripts`] once.
pub fn player_html(animation: &Animation) -> String {
    animation.element() + &scripts()
}

/// Style sheet and script of the animations of a page.
pub fn scripts() -> String {
    format!("<style>{STYLE}</style><script>{SCRIPT}</script>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn bodies_and_materials_are_classes_and_gravity_points_down() {
        let case = json!({
            "space": "3d", "gravity": [0, -9.81, 0],
            "bodies": [
                { "name": "crest", "material": "sand" }, { "name": "toe", "material": "clay" },
                { "name": "fill", "material": "sand" }
            ]
        });
        let animation_view = view(&case, [0, 2], &[]);
        assert_eq!((animation_view.axes, animation_view.vertical_axis), (vec![0, 1, 2], 1));
        assert_eq!(animation_view.classes[0].of_body, [0, 1, 2]);
        assert_eq!(
            (animation_view.classes[1].names.join(" "), &animation_view.classes[1].of_body[..]),
            ("sand clay".into(), &[0, 1, 0][..])
        );
        let flat = view(&json!({ "space": "plane-strain", "bodies": [{}] }), [0, 1], &["depth".into()]);
        assert_eq!((flat.axes, flat.vertical_axis, flat.fields), (vec![0, 1], 1, vec!["depth".to_owned()]));
    }
}
