//! Measures: numbers read off a snapshot.

mod arc_front;
mod crack_tip;
mod fragments;
mod front;

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::description::{Body, BreakageCriterion, Measure, Side};
use crate::{Case, Field, FieldData, FieldRole, Reaction, Snapshot, Solver, spatial};

pub use crate::measure::arc_front::arc_front;
pub use crate::solver::ScalarOutput;
pub use fragments::fragments;
pub use front::{FrontColumns, front};

/// Evaluates all scalar measures of the case on a snapshot, in the order of their names.
pub fn read(
    case: &Case,
    snapshot: &Snapshot,
    cell: Option<f64>,
    travels: &[Option<f64>],
) -> Vec<ScalarOutput> {
    let mut readings = Vec::new();
    for (name, measure) in &case.measures {
        let front = |side: Side, quantile: f64, own: Option<f64>, bodies: &Option<Vec<String>>| {
            let counted = counted_points(case, snapshot, bodies.as_deref());
            match quantile {
                1.0 => FrontColumns::of_case(case, side, own.or(cell), &counted).front(&counted),
                _ => front(&counted, side, quantile),
            }
        };
        match measure {
            Measure::Front { side, quantile, cell, bodies } => {
                let front = front(*side, *quantile, *cell, bodies) + case.origin()[side.axis()];
                readings.push((name.clone(), "m".to_owned(), front));
            }
            Measure::RunOut { side, origin, initial_length, quantile, cell, bodies } => {
                let sign = if side.is_max() { 1.0 } else { -1.0 };
                let length = sign * (front(*side, *quantile, *cell, bodies) - origin);
                readings.push((name.clone(), String::new(), (length - initial_length) / initial_length));
            }
            Measure::Probe { position, radius, fields } => {
                readings.extend(probe(name, snapshot, position, *radius, fields));
            }
            Measure::CrackTip(tip) => readings.extend(tip.scalar_outputs(name, case, snapshot, travels)),
            Measure::ArcFront { obstacle: of, quantile, zero, bodies } => {
                let counted = counted_points(case, snapshot, bodies.as_deref());
                readings.push((
                    name.clone(),
                    "m".to_owned(),
                    arc_front(case, &counted, of, *quantile) - zero,
                ));
            }
            Measure::Fragments { link, least, bodies, broken } => {
                let whole = broken
                    .as_ref()
                    .map_or(Cow::Borrowed(snapshot), |broken| unbroken_points(snapshot, broken));
                let counted = counted_points(case, &whole, bodies.as_deref());
                readings.extend(fragments::scalar_outputs(name, &counted, *link, *least));
            }
            Measure::Profile { .. }
            | Measure::Reaction { .. }
            | Measure::ImpactPressure { .. }
            | Measure::Gauge { .. }
            | Measure::Discharge { .. }
            | Measure::Dissipation {}
            | Measure::FactorOfSafety(_) => {}
        }
    }
    readings
}

/// Whether a measure needs the positions of points, nodes or cells.
#[cfg(feature = "output")]
pub(crate) fn needs_places(measure: &Measure) -> bool {
    match measure {
        Measure::Front { .. }
        | Measure::RunOut { .. }
        | Measure::Probe { .. }
        | Measure::CrackTip(_)
        | Measure::ArcFront { .. }
        | Measure::Fragments { .. }
        | Measure::Profile { .. }
        | Measure::FactorOfSafety(_) => true,
        Measure::Reaction { .. }
        | Measure::ImpactPressure { .. }
        | Measure::Gauge { .. }
        | Measure::Discharge { .. }
        | Measure::Dissipation {} => false,
    }
}

/// Points whose mass a measure counts: those of `bodies`, or of all bodies that are not rigid.
pub fn counted_points<'a>(
    case: &Case,
    snapshot: &'a Snapshot,
    bodies: Option<&[String]>,
) -> Cow<'a, Snapshot> {
    let counts = |body: &Body| match bodies {
        Some(names) => names.contains(&body.name),
        None => !body.rigid,
    };
    let counts: Vec<bool> = case.bodies.iter().map(counts).collect();
    let kept = |i: &usize| counts.get(snapshot.bodies[*i] as usize).copied().unwrap_or(bodies.is_none());
    let kept: Vec<usize> = (0..snapshot.bodies.len()).filter(kept).collect();
    if kept.len() == snapshot.bodies.len() {
        return Cow::Borrowed(snapshot);
    }
    Cow::Owned(point_subset(snapshot, &kept))
}

/// Points that are not broken by the criterion. All points where the snapshot lacks the field of the criterion.
fn unbroken_points<'a>(snapshot: &'a Snapshot, broken: &BreakageCriterion) -> Cow<'a, Snapshot> {
    let Some(values) = snapshot.scalars(&broken.field) else { return Cow::Borrowed(snapshot) };
    // Points without the value, such as those of another law, have not broken.
    let kept: Vec<usize> = (0..values.len()).filter(|&i| !(values[i] <= broken.max)).collect();
    Cow::Owned(point_subset(snapshot, &kept))
}

/// Subset of the points, with their `mass`.
fn point_subset(snapshot: &Snapshot, kept: &[usize]) -> Snapshot {
    let mass = snapshot.role_values(FieldRole::Mass).map(|values| {
        let data = FieldData::Scalar(kept.iter().map(|&i| values[i]).collect());
        Field { name: "mass".to_owned(), unit: "kg", data }
    });
    Snapshot {
        time: snapshot.time,
        step: snapshot.step,
        ids: kept.iter().map(|&i| snapshot.ids[i]).collect(),
        bodies: kept.iter().map(|&i| snapshot.bodies[i]).collect(),
        positions: kept.iter().map(|&i| snapshot.positions[i]).collect(),
        extents: kept.iter().map(|&i| snapshot.extents[i]).collect(),
        fields: mass.into_iter().collect(),
    }
}

/// Evaluates the measures that need the solver: forces and impulses of reactions, dissipated energy, depth and velocity at gauges,
/// discharge across lines.
pub fn solver_outputs(case: &Case, solver: &dyn Solver) -> Vec<ScalarOutput> {
    let mut readings = Vec::new();
    for (name, measure) in &case.measures {
        if let Measure::Dissipation {} = measure {
            readings.push((name.clone(), "J".to_owned(), solver.dissipated().unwrap_or(f64::NAN)));
        }
        if let Measure::Gauge { position } = measure {
            let (depth, velocity) = solver.gauge(position).unwrap_or((f64::NAN, [f64::NAN; 3]));
            readings.push((format!("{name}.depth"), "m".to_owned(), depth));
            for (c, axis) in ["x", "y"].into_iter().enumerate().take(case.dimension() - 1) {
                readings.push((format!("{name}.velocity.{axis}"), "m/s".to_owned(), velocity[c]));
            }
        }
        if let Measure::Discharge { from, to } = measure {
            let discharge = solver.discharge(*from, *to).unwrap_or(f64::NAN);
            readings.push((name.clone(), "m3/s".to_owned(), discharge));
        }
        if let Measure::ImpactPressure { target: of, direction, area } = measure {
            readings.extend(pressure(name, solver.reaction(of), direction, *area));
        }
        let Measure::Reaction { target: of, about } = measure else { continue };
        let reaction = solver.reaction(of);
        for (c, axis) in ["x", "y", "z"].into_iter().enumerate().take(case.dimension()) {
            let of = |value: fn(&Reaction) -> [f64; 3]| reaction.as_ref().map_or(f64::NAN, |r| value(r)[c]);
            readings.push((format!("{name}.{axis}"), "N".to_owned(), of(|r| r.force)));
            readings.push((format!("{name}.impulse.{axis}"), "N s".to_owned(), of(|r| r.impulse)));
        }
        if !about.is_empty() {
            let moment = reaction.as_ref().and_then(|reaction| reaction.moment_about(&spatial(about)));
            readings.extend(moments(name, case.dimension(), moment.unwrap_or([f64::NAN; 3])));
        }
    }
    readings
}

/// Components of a moment; in the plane only the one perpendicular to it.
fn moments(name: &str, dimension: usize, [x, y, z]: [f64; 3]) -> Vec<ScalarOutput> {
    let reading = |name: String, value: f64| (name, "N m".to_owned(), value);
    if dimension < 3 {
        return vec![reading(format!("{name}.moment"), z)];
    }
    let named = ["x", "y", "z"].into_iter().zip([x, y, z]);
    named.map(|(axis, value)| reading(format!("{name}.moment.{axis}"), value)).collect()
}

/// Pressure and impulse per area of a `reaction` along `direction` over `area` (m²).
fn pressure(name: &str, reaction: Option<Reaction>, direction: &[f64], area: f64) -> [ScalarOutput; 2] {
    let length = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
    let over =
        |vector: [f64; 3]| direction.iter().zip(vector).map(|(d, v)| d * v).sum::<f64>() / (length * area);
    let of = |value: fn(&Reaction) -> [f64; 3]| reaction.as_ref().map_or(f64::NAN, |r| over(value(r)));
    [
        (name.to_owned(), "Pa".to_owned(), of(|r| r.force)),
        (format!("{name}.impulse"), "Pa s".to_owned(), of(|r| r.impulse)),
    ]
}

/// Height of the surface in bins of width `bin` (m) along `axis`: pairs of bin centre and height (m).
pub fn profile(snapshot: &Snapshot, axis: usize, height: usize, bin: f64) -> Vec<(f64, f64)> {
    let mut bins: BTreeMap<i64, f64> = BTreeMap::new();
    for (position, extent) in snapshot.positions.iter().zip(&snapshot.extents) {
        let number = (position[axis] / bin).floor() as i64;
        let top = position[height] + 0.5 * extent[height];
        let entry = bins.entry(number).or_insert(f64::NEG_INFINITY);
        *entry = entry.max(top);
    }
    bins.into_iter().map(|(number, top)| ((number as f64 + 0.5) * bin, top)).collect()
}

/// Values of fields at a position, as means over the points within `radius`.
fn probe(
    name: &str,
    snapshot: &Snapshot,
    place: &[f64],
    radius: f64,
    fields: &[String],
) -> Vec<ScalarOutput> {
    let near = |x: &[f64; 3]| {
        let square: f64 = place.iter().zip(x).map(|(p, x)| (p - x).powi(2)).sum();
        square <= radius * radius
    };
    let inside: Vec<usize> =
        (0..snapshot.positions.len()).filter(|&i| near(&snapshot.positions[i])).collect();
    let mean = |value: &dyn Fn(usize) -> f64| {
        // NaN without a point in the probe.
        inside.iter().map(|&i| value(i)).sum::<f64>() / inside.len() as f64
    };
    let mut readings = Vec::new();
    for wanted in fields {
        let Some(field) = snapshot.field(wanted) else {
            readings.push((format!("{name}.{wanted}"), String::new(), f64::NAN));
            continue;
        };
        let unit = || field.unit.to_owned();
        match &field.data {
            FieldData::Integer(values) => {
                readings.push((format!("{name}.{wanted}"), unit(), mean(&|i| values[i] as f64)));
            }
            FieldData::Scalar(values) => {
                readings.push((format!("{name}.{wanted}"), unit(), mean(&|i| values[i])));
            }
            FieldData::Vector(values) => {
                for (c, axis) in ["x", "y", "z"].into_iter().enumerate() {
                    readings.push((format!("{name}.{wanted}.{axis}"), unit(), mean(&|i| values[i][c])));
                }
            }
            FieldData::Tensor(values) => {
                for (c, part) in ["xx", "yy", "zz", "xy", "yz", "zx"].into_iter().enumerate() {
                    readings.push((format!("{name}.{wanted}.{part}"), unit(), mean(&|i| values[i][c])));
                }
            }
        }
    }
    readings
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    fn line(positions: &[f64]) -> Snapshot {
        let count = positions.len();
        Snapshot {
            time: 0.0,
            step: 0,
            ids: (0..count as u64).collect(),
            bodies: vec![0; count],
            positions: positions.iter().map(|&x| [x, 0.5 * x, 0.0]).collect(),
            extents: vec![[0.1; 3]; count],
            fields: vec![Field {
                name: "mass".into(),
                unit: "kg",
                data: FieldData::Scalar(vec![1.0; count]),
            }],
        }
    }

    #[test]
    fn a_profile_is_the_highest_point_of_each_bin() {
        let heights = profile(&line(&[0.05, 0.15, 0.25]), 0, 1, 0.2);
        let expected = [(0.1, 0.125), (0.3, 0.175)];
        assert_eq!(heights.len(), 2);
        for (found, exact) in heights.iter().zip(expected) {
            assert!((found.0 - exact.0).abs() < 1e-12 && (found.1 - exact.1).abs() < 1e-12);
        }
    }

    #[test]
    fn rigid_bodies_count_only_where_they_are_named() {
        let body = |name: &str, at: f64, rigid: bool| {
            let shape = json!({ "kind": "box", "min": [at, 0], "max": [at + 1.0, 1] });
            json!({ "name": name, "material": "m", "rigid": rigid, "shape": shape })
        };
        let measure = |bodies: Value| {
            let mut measure = json!({ "kind": "front", "side": "x-max", "quantile": 0.5 });
            if !bodies.is_null() {
                measure["bodies"] = bodies;
            }
            measure
        };
        let elastic =
            json!({ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 });
        let case = json!({
            "title": "plough", "space": "plane-strain", "gravity": [0, -10],
            "domain": { "min": [0, 0], "max": [9, 9] }, "materials": { "m": elastic },
            "bodies": [body("soil", 0.0, false), body("stone", 2.0, false), body("plough", 4.0, true)],
            "stages": [{ "name": "go", "duration": 1 }],
            "measures": {
                "loose": measure(Value::Null),
                "plough": measure(json!(["plough"])),
                "soil": measure(json!(["soil"])),
                "run": { "kind": "run-out", "side": "x-max", "origin": 0, "initial_length": 2, "cell": 9 }
            }
        });
        let case = Case::from_json(&case.to_string()).unwrap();
        let snapshot = Snapshot { bodies: vec![0, 1, 2], ..line(&[0.55, 2.95, 4.95]) };
        let readings = read(&case, &snapshot, None, &[]);
        for (name, exact) in [("loose", 0.6), ("plough", 5.0), ("soil", 0.6), ("run", 0.5)] {
            let found = readings.iter().find(|(n, ..)| n == name).unwrap().2;
            assert!((found - exact).abs() < 1e-12, "{name}: {found} is not {exact}");
        }
        let heights = profile(&counted_points(&case, &snapshot, None), 0, 1, 9.0);
        assert!((heights[0].1 - 1.525).abs() < 1e-12, "the plough is higher: {heights:?}");
    }

    #[test]
    fn broken_points_do_not_connect_fragments() {
        let mut row = line(&[0.0, 0.1, 0.2, 0.3, 0.4]);
        let strength = FieldData::Scalar(vec![1.0, 2.0, 0.0, f64::NAN, 1.0]);
        row.fields.push(Field { name: "strength".into(), unit: "Pa", data: strength });
        let broken = |at_most: f64| BreakageCriterion { field: "strength".into(), max: at_most };
        let pieces = |broken: &BreakageCriterion| {
            let whole = unbroken_points(&row, broken);
            fragments(&whole, 0.12, 1).unwrap().0
        };
        assert_eq!(pieces(&broken(0.0)), [2.0, 2.0]);
        assert_eq!(pieces(&broken(1.0)), [1.0, 1.0]);
        assert_eq!(pieces(&BreakageCriterion { field: "none".into(), max: 9.0 }), [5.0]);
    }

    #[test]
    fn a_pressure_is_force_along_a_direction_over_an_area() {
        let reaction = Reaction { force: [30.0, 40.0, 0.0], impulse: [3.0, -4.0, 0.0], moment: None };
        let found = pressure("p", Some(reaction), &[6.0, 8.0], 2.0);
        assert!((found[0].2 - 25.0).abs() < 1e-12 && (found[1].2 + 0.7).abs() < 1e-12, "{found:?}");
        assert!(found[1].0 == "p.impulse" && pressure("p", None, &[1.0, 0.0], 2.0)[0].2.is_nan());
    }

    #[test]
    fn a_probe_averages_the_points_within_its_radius() {
        let readings =
            probe("p", &line(&[0.0, 1.0, 5.0]), &[0.5, 0.25], 1.0, &["mass".into(), "heat".into()]);
        assert_eq!(readings[0].0, "p.mass");
        assert_eq!(readings[0].2, 1.0);
        assert!(readings[1].2.is_nan());
    }
}
