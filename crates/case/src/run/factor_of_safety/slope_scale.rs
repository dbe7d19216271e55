//! Scales of a slope for a search for a factor of safety: height, elastic settlement and displacement of the bodies.

use std::collections::BTreeMap;

use colluvium_points::surface::cross;
use serde_json::Value;

use crate::description::Domain;
use crate::{Case, FieldRole, Snapshot, measure};

/// Share of the points that may move farther than the displacement by which a trial is judged: single loose points are no failure.
const LARGER_DISPLACEMENT_SHARE: f64 = 0.01;
/// Relief over the height of all bodies, below which a free surface counts as level.
const LEVEL: f64 = 0.05;

/// Scales of the bodies at rest, by which displacements are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SlopeScale {
    /// Height of the slope `H` (m).
    pub height: f64,
    /// Elastic settlement `γ H² / E` (m), which makes displacements dimensionless; not-a-number without a Young's modulus of each material
    /// or without weight.
    pub settlement: f64,
}

impl SlopeScale {
    /// Computes the scales of the bodies in the state `rest`, with the given height (m) or the relief of the bodies.
    pub fn of_case(case: &Case, rest: &Snapshot, height: Option<f64>) -> Self {
        let gravity = case.gravity_magnitude();
        let height = height.unwrap_or_else(|| relief(case, rest));
        let moduli: Vec<Option<f64>> =
            case.bodies.iter().map(|body| youngs_modulus(case, &body.material)).collect();
        let (mut weight, mut volume, mut stiffness) = (0.0, 0.0, 0.0);
        let none: &[f64] = &[];
        let (masses, volumes) = (
            rest.role_values(FieldRole::Mass).unwrap_or(none),
            rest.role_values(FieldRole::Volume).unwrap_or(none),
        );
        for ((body, mass), own) in rest.bodies.iter().zip(masses).zip(volumes) {
            let body = *body as usize;
            if case.bodies.get(body).is_some_and(|body| body.rigid) {
                continue;
            }
            weight += mass * gravity;
            volume += own;
            stiffness += own * moduli.get(body).copied().flatten().unwrap_or(f64::NAN);
        }
        let settlement = weight / stiffness * height * height;
        let known = volume > 0.0 && settlement.is_finite() && settlement > 0.0;
        Self { height, settlement: if known { settlement } else { f64::NAN } }
    }
}

/// Young's modulus of a material or of its wrapped material (Pa).
pub(super) fn youngs_modulus(case: &Case, material: &str) -> Option<f64> {
    /// Finds Young's modulus in the keys of a material, or of a material inside it (Pa).
    fn find_number(value: &Value) -> Option<f64> {
        let keys = value.as_object()?;
        keys.get("youngs_modulus").and_then(Value::as_f64).or_else(|| keys.values().find_map(find_number))
    }
    find_number(&serde_json::to_value(case.materials.get(material)?).ok()?)
}

/// Relief (m): height from the lowest to the highest place of the free surface against gravity; of all points where the surface is level or
/// there is no gravity.
fn relief(case: &Case, rest: &Snapshot) -> f64 {
    let counted = measure::counted_points(case, rest, None);
    let size = case.gravity_magnitude();
    let mut up = [0.0, 1.0, 0.0];
    if size > 0.0 {
        up = [0.0; 3];
        case.gravity.iter().enumerate().for_each(|(c, g)| up[c] = -g / size);
    }
    let across = perpendicular_axes(&up);
    let dot = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
    let width = 2.0 * counted.extents.iter().flatten().copied().fold(0.0, f64::max);
    let mut tops: BTreeMap<[i64; 2], f64> = BTreeMap::new();
    let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
    for (place, extent) in counted.positions.iter().zip(&counted.extents) {
        let half = 0.5 * (0..3).map(|c| up[c].abs() * extent[c]).sum::<f64>();
        let level = dot(place, &up);
        (lowest, highest) = (lowest.min(level - half), highest.max(level + half));
        let column = across.map(|axis| (dot(place, &axis) / width).floor() as i64);
        let top = tops.entry(column).or_insert(f64::NEG_INFINITY);
        *top = top.max(level + half);
    }
    let relief = highest - tops.values().copied().fold(highest, f64::min);
    if relief > LEVEL * (highest - lowest) { relief } else { highest - lowest }
}

/// Two unit vectors perpendicular to a unit vector.
fn perpendicular_axes(up: &[f64; 3]) -> [[f64; 3]; 2] {
    let other = if up[2].abs() < 0.5 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let first = cross(up, &other);
    let size = first.iter().map(|c| c * c).sum::<f64>().sqrt();
    let first = first.map(|c| c / size);
    [first, cross(up, &first)]
}

/// Displacements (m) between two snapshots, in the order of `now` and matched by ids; `None` for points that are not in `before`. The
/// shortest distance counts on periodic axes.
pub(super) fn displacements(now: &Snapshot, before: &Snapshot, domain: &Domain) -> Vec<Option<[f64; 3]>> {
    let mut known = before.ids.iter().zip(&before.positions).peekable();
    let displacement = |place: &[f64; 3], was: &[f64; 3]| -> [f64; 3] {
        std::array::from_fn(|c| {
            let displacement = place[c] - was[c];
            let periodic = c < domain.min.len() && domain.is_periodic(c);
            let period = if periodic { domain.max[c] - domain.min[c] } else { f64::INFINITY };
            if periodic { displacement - period * (displacement / period).round() } else { displacement }
        })
    };
    let mut all = Vec::with_capacity(now.ids.len());
    for (id, place) in now.ids.iter().zip(&now.positions) {
        while known.next_if(|(known, _)| *known < id).is_some() {}
        all.push(known.next_if(|(known, _)| *known == id).map(|(_, was)| displacement(place, was)));
    }
    all
}

/// Displacement that one hundredth of the points exceed (m).
pub(super) fn exceeded_displacement(now: &Snapshot, before: &Snapshot, domain: &Domain) -> f64 {
    let length = |u: [f64; 3]| u.iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut all: Vec<f64> = displacements(now, before, domain).into_iter().flatten().map(length).collect();
    let rank = (LARGER_DISPLACEMENT_SHARE * all.len() as f64) as usize;
    if all.is_empty() {
        return 0.0;
    }
    let (_, value, _) = all.select_nth_unstable_by(rank, |a, b| b.total_cmp(a));
    *value
}
