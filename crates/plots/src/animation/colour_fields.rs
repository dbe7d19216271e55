//! Sources of the colours of the points: fields and classes.

use colluvium_case::Snapshot;
use serde_json::{Value, json};

use crate::animation::quantisation::QuantisedRange;
use crate::animation::{Panel, View};
use crate::pictures::point_cloud::values;

/// Classification of points by a property of their body, such as its name or material, each class with its colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointClasses {
    /// Name of the classification: `body`, `material`.
    pub name: String,
    /// Names of the classes.
    pub names: Vec<String>,
    /// Class index of each body, by the index of the body.
    pub of_body: Vec<usize>,
}

/// Fields that are shown by default where the frames have them and they vary.
const DEFAULT_FIELDS: [&str; 8] = [
    "displacement",
    "velocity",
    "pressure",
    "depth",
    "plastic_strain",
    "equivalent_plastic_strain",
    "deviatoric_plastic_strain",
    "pore_pressure",
];

/// Share of the values at each end that are beyond the colour scale, so that single flying points do not stretch it.
const CLIPPED_FRACTION: f64 = 0.001;

/// Data by which the points of an animation are coloured.
#[derive(Clone, Debug)]
pub(super) enum ColourSource {
    /// Field, with its scale over all frames of all runs.
    Field { name: String, unit: String, scale: QuantisedRange },
    /// Classes of the points, each with one colour.
    Class(PointClasses),
}

/// Colour sources of an animation: the fields that every frame has, each with one scale, and the classifications with more than one class.
pub(super) fn colour_sources(panels: &[Panel<'_>], view: &View) -> Vec<ColourSource> {
    let frames = || panels.iter().flat_map(|panel| &panel.frames).copied();
    let usual = || DEFAULT_FIELDS.iter().map(|name| (*name).to_owned()).collect();
    let asked = !view.fields.is_empty();
    let names: Vec<String> = if asked { view.fields.clone() } else { usual() };
    let one = |name: String| {
        let unit = frames().next()?.field(&name)?.unit.to_owned();
        let mut all: Vec<f64> = Vec::new();
        for frame in frames() {
            all.extend(values(frame.field(&name)?).into_iter().filter(|value| value.is_finite()));
        }
        let (low, high) = scale_limits(&mut all)?;
        // A uniform field is left out, unless it was requested.
        let varies = high - low > 1e-9 * high.abs().max(low.abs());
        let (low, high) = if varies { (low, high) } else { (low - 0.5, low + 0.5) };
        (varies || asked).then_some(ColourSource::Field {
            name,
            unit,
            scale: QuantisedRange::coarse(low, high),
        })
    };
    let fields = names.into_iter().filter_map(one);
    let classes = view.classes.iter().filter(|classes| classes.names.len() > 1);
    let mut shown: Vec<ColourSource> = fields.chain(classes.cloned().map(ColourSource::Class)).collect();
    if shown.is_empty() {
        shown.push(ColourSource::Class(PointClasses {
            name: "points".into(),
            names: vec!["points".into()],
            of_body: vec![],
        }));
    }
    shown
}

/// Ends of a colour scale: those of the values without the outermost ones.
fn scale_limits(values: &mut [f64]) -> Option<(f64, f64)> {
    let last = values.len().checked_sub(1)?;
    let cut = (CLIPPED_FRACTION * values.len() as f64) as usize;
    let low = *values.select_nth_unstable_by(cut, f64::total_cmp).1;
    let high = *values.select_nth_unstable_by(last - cut, f64::total_cmp).1;
    Some((low, high))
}

impl ColourSource {
    /// Values of the points of a frame; class indices for classes.
    pub fn values(&self, frame: &Snapshot) -> Vec<f64> {
        match self {
            Self::Field { name, .. } => {
                frame.field(name).map_or_else(|| vec![f64::NAN; frame.ids.len()], values)
            }
            Self::Class(classes) => {
                let class = |body: &u32| classes.of_body.get(*body as usize).map_or(0.0, |k| *k as f64);
                frame.bodies.iter().map(class).collect()
            }
        }
    }

    /// Quantised value of the colour scale.
    pub fn number(&self, value: f64) -> u8 {
        match self {
            Self::Field { scale, .. } => scale.quantise(value) as u8,
            Self::Class(_) => value as u8,
        }
    }

    /// Description of the colour source for the player of the animation, as JSON.
    pub fn json(&self) -> Value {
        match self {
            Self::Field { name, unit, scale } => json!({
                "name": name.replace('_', " "), "unit": unit, "low": scale.low, "high": scale.high,
            }),
            Self::Class(classes) => json!({ "name": classes.name, "classes": classes.names }),
        }
    }
}
