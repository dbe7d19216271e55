//! Warnings about a plan: bodies with coarse resolution, and outputs more frequent than steps.

use colluvium_points::surface::distance_to_line;
use colluvium_points::{Shape, common_interior_point};

use crate::description::OVERLAP_RESOLUTION;
use crate::description::{Body, Space};
use crate::{Case, Plan};
use colluvium_constitutive::Warning;

/// Relative difference of the volume of a body's points from its shape above which there is a warning.
const VOLUME_TOLERANCE: f64 = 0.02;

impl Plan {
    /// Mass of the points of each body (kg), pore fluid included.
    pub fn masses(&self, case: &Case) -> Vec<f64> {
        let of_bulk = || {
            let bodies = case.bodies.iter().zip(&self.volumes).enumerate();
            let density = |number: usize, body| match &self.densities {
                Some(own) => own[number],
                None => case.bulk_density(body),
            };
            bodies.map(|(number, (body, volume))| density(number, body) * volume).collect()
        };
        self.grains.clone().unwrap_or_else(of_bulk)
    }

    /// Warnings of the plan, extended by those about bodies with poor resolution or volume and about outputs more frequent than steps.
    pub fn all_warnings(&self, case: &Case) -> Vec<Warning> {
        let mut warnings = self.warnings.clone();
        let bodies = case.bodies.iter().zip(&self.volumes).enumerate();
        for (number, (body, volume)) in bodies.filter(|(_, (body, _))| !body.rigid && self.grains.is_none()) {
            let exact = body.shape.volume(case.dimension(), case.space == Space::Axisymmetric);
            let excess = volume / exact - 1.0;
            if excess.abs() > VOLUME_TOLERANCE {
                let share = 100.0 * volume / exact;
                let cure = match body.points {
                    Some(_) => {
                        "weights, overlaps and loaded faces are computed from the shape. Make the shape \
                         match the points"
                    }
                    None => "Use smaller cells or spacings, or a shape that ends on their lines",
                };
                warnings.push(Warning::new("volume-mismatch", format!(
                    "bodies[{number}].shape: its points have {share:.1} % of its volume of {exact:.4e}, and \
                     of its mass. {cure}"
                )));
            }
        }
        let dt = self.time_step.dt;
        for (key, interval) in [("frames", case.output.frames), ("measures", case.output.measures)] {
            let Some(interval) = interval.filter(|interval| *interval < dt) else { continue };
            warnings.push(Warning::new(
                "output-shortens-steps",
                format!(
                    "output.{key}: {interval} s is shorter than the time step, {dt:.4e} s, so all steps are \
                 shortened to it. Give a longer interval"
                ),
            ));
        }
        if let Some(resolution) = &self.resolution {
            warnings.extend(thin_bodies(case, resolution));
            warnings.extend(gaps(case, resolution));
        }
        warnings
    }
}

/// Cell size or point spacing of a method, with which the sizes of bodies are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Width of a cell, or spacing of the points (m).
    pub width: f64,
    /// Distance of the points (m).
    pub point_distance: f64,
    /// Number of axes with this resolution, counted from the first.
    pub axes: usize,
    /// Key of the case that determines the width.
    pub case_key: &'static str,
    /// Noun for widths in a message: `cells` or `spacings`.
    pub noun: &'static str,
}

/// Smallest number of widths across a body for bending and shear.
const MIN_WIDTHS: f64 = 2.0;
/// Share of a width that counts as round-off.
const ROUND_OFF: f64 = 1e-6;

/// Smallest extent of a body (m) along the axes along which it does not span the domain, with its axis. A layer, which is thin along its
/// normal, has no axis.
fn thinnest(case: &Case, body: &Body, axes: usize) -> Option<(f64, Option<usize>)> {
    let (low, high) = body.shape.bounds(case.dimension());
    let spans = |axis: usize| {
        let slack = ROUND_OFF * (case.domain.max[axis] - case.domain.min[axis]);
        low[axis] <= case.domain.min[axis] + slack && high[axis] >= case.domain.max[axis] - slack
    };
    let along = (0..axes).filter(|axis| !spans(*axis)).map(|axis| (high[axis] - low[axis], Some(axis)));
    let across = body.shape.layer_thickness().filter(|_| axes == case.dimension()).map(|thick| (thick, None));
    along.chain(across).min_by(|(a, _), (b, _)| a.total_cmp(b))
}

/// Warns of bodies that are thinner than two widths.
fn thin_bodies(case: &Case, resolution: &Resolution) -> Vec<Warning> {
    let Resolution { width, point_distance: apart, axes, case_key, noun } = *resolution;
    let mut found = Vec::new();
    for (number, body) in case.bodies.iter().enumerate() {
        if body.rigid || body.points.is_some() {
            continue;
        }
        let Some((thickness, axis)) = thinnest(case, body, axes) else { continue };
        if thickness >= MIN_WIDTHS * width * (1.0 - ROUND_OFF) {
            continue;
        }
        let rows = if thickness < 1.5 * apart { ", one row of points" } else { "" };
        let place = axis.map_or_else(String::new, |axis| format!(" along {}", ["x", "y", "z"][axis]));
        found.push(Warning::new("thin-body", format!(
            "bodies[{number}].shape: is {thickness:.4} m thick{place}, {:.1} {noun} of {width} m{rows}. Its \
             bending and shear are not resolved. Make {case_key} {:.3} m or less",
            thickness / width,
            thickness / MIN_WIDTHS
        )));
    }
    found
}

/// Warns of bodies whose gap is less than a width: they interact before they touch.
fn gaps(case: &Case, resolution: &Resolution) -> Vec<Warning> {
    let Resolution { width, case_key, noun, .. } = *resolution;
    let bounds: Vec<_> = case.bodies.iter().map(|body| body.shape.bounds(case.dimension())).collect();
    let mut found = Vec::new();
    for (second, first) in (0..bounds.len()).flat_map(|second| (0..second).map(move |first| (second, first)))
    {
        let [one, other] = [first, second].map(|number| &case.bodies[number].shape);
        let boxes = [one, other].iter().all(|shape| matches!(shape, Shape::Box { .. }));
        let gap = if boxes {
            gap_of_boxes(&bounds[first], &bounds[second], resolution)
        } else {
            gap_of_outlines(one, other, case.dimension()).map(|gap| (gap, String::new()))
        };
        let Some((gap, axis)) = gap.filter(|(gap, _)| *gap > ROUND_OFF * width) else { continue };
        if gap < width * (1.0 - ROUND_OFF) {
            found.push(Warning::new("gap-below-cell", format!(
                "bodies[{second}].shape: begins {gap:.4e} m from {:?}{axis}, less than one of the {noun} of \
                 {width} m. The two bodies interact across the gap from the start. Close the gap, or make \
                 the gap larger or {case_key} smaller",
                case.bodies[first].name
            )));
        }
    }
    found
}

/// Gap between two boxes beside each other along an axis (m), with the name of that axis.
fn gap_of_boxes(
    (low, high): &(Vec<f64>, Vec<f64>),
    (other_low, other_high): &(Vec<f64>, Vec<f64>),
    resolution: &Resolution,
) -> Option<(f64, String)> {
    let apart = |axis: usize| (low[axis] - other_high[axis]).max(other_low[axis] - high[axis]);
    let beside =
        (0..resolution.axes).filter(|axis| apart(*axis) > ROUND_OFF * resolution.width).collect::<Vec<_>>();
    let [axis] = beside[..] else { return None };
    Some((apart(axis), format!(" along {}", ["x", "y", "z"][axis])))
}

/// Gap between two shapes in the plane with straight sides (m); zero where they overlap.
fn gap_of_outlines(one: &Shape, other: &Shape, dimension: usize) -> Option<f64> {
    let (corners, others) = (closed_corners(one)?, closed_corners(other)?);
    if common_interior_point(one, other, dimension, OVERLAP_RESOLUTION).is_some() {
        return Some(0.0);
    }
    let from = |corners: &[[f64; 2]], line: &[[f64; 2]]| {
        corners.iter().map(|corner| distance_to_line(line, *corner)).fold(f64::INFINITY, f64::min)
    };
    Some(from(&corners, &others).min(from(&others, &corners)))
}

/// Corners of a shape in the plane with straight sides (m); the last one is the first again.
fn closed_corners(shape: &Shape) -> Option<Vec<[f64; 2]>> {
    let mut corners = match shape {
        Shape::Polygon { vertices } => vertices.to_vec(),
        Shape::Box { min, max } if min.len() == 2 => {
            vec![[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]]
        }
        _ => return None,
    };
    corners.push(*corners.first()?);
    Some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TimeStep;
    use serde_json::{Value, json};

    /// Case of a body of 1 m with this output, and its plan with steps of 0.02 s and a total point volume `volume` (m).
    fn case_and_plan(output: &Value, volume: f64) -> (Case, Plan) {
        let case = json!({
            "title": "t", "space": "1d", "domain": { "min": [0], "max": [1] }, "gravity": [0],
            "materials": { "m": { "model": "linear-elastic", "density": 3, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] } }],
            "stages": [{ "name": "s", "duration": 1 }], "output": output
        });
        let time_step =
            TimeStep { dt: 0.02, limit: crate::StepLimit::ELASTIC_WAVE, point: None, position: [0.0; 3] };
        let plan = Plan {
            points: 1,
            nodes: 2,
            time_step,
            memory: 1,
            volumes: vec![volume],
            grains: None,
            densities: None,
            resolution: None,
            steps: 50,
            updates_per_second: 1.0,
            warnings: Vec::new(),
        };
        (Case::from_json(&case.to_string()).unwrap(), plan)
    }

    #[test]
    fn output_intervals_that_shorten_the_steps_cause_a_warning() {
        let (case, plan) = case_and_plan(&json!({ "frames": 0.01, "measures": 0.1 }), 1.0);
        let warnings = plan.all_warnings(&case);
        assert!(warnings.len() == 1 && warnings[0].text.starts_with("output.frames: 0.01 s"), "{warnings:?}");
    }

    #[test]
    fn missing_volume_of_points_causes_a_warning_except_for_grains() {
        let (case, mut plan) = case_and_plan(&json!({}), 0.5);
        let warnings = plan.all_warnings(&case);
        assert!(
            warnings.len() == 1 && warnings[0].text.contains("have 50.0 % of its volume"),
            "{warnings:?}"
        );
        assert_eq!(plan.masses(&case), [1.5]);
        plan.grains = Some(vec![2.5]);
        assert_eq!((plan.all_warnings(&case).len(), plan.masses(&case)), (0, vec![2.5]));
    }

    /// Warnings about two boxes of 1 m in the plane with cells of 0.2 m, the second one changed by `change`.
    fn of_boxes(change: impl Fn(&mut Value)) -> Vec<Warning> {
        let mut case = json!({
            "title": "t", "space": "plane-strain", "domain": { "min": [0, 0], "max": [4, 4] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 3, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [
                { "name": "a", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } },
                { "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 1], "max": [1, 2] } }
            ],
            "stages": [{ "name": "s", "duration": 1 }]
        });
        change(&mut case["bodies"][1]["shape"]);
        let case = Case::from_json(&case.to_string()).unwrap();
        let resolution = Resolution {
            width: 0.2,
            point_distance: 0.1,
            axes: 2,
            case_key: "methods.mpm.cell_size",
            noun: "cells",
        };
        let plan =
            Plan { volumes: Vec::new(), resolution: Some(resolution), ..case_and_plan(&json!({}), 1.0).1 };
        plan.all_warnings(&case)
    }

    #[test]
    fn bodies_below_two_cells_and_gaps_below_one_cause_warnings_with_a_remedy() {
        assert_eq!(of_boxes(|_| {}), Vec::<Warning>::new());
        let thin = of_boxes(|shape| shape["max"] = json!([1, 1.3]));
        assert!(
            thin.len() == 1
                && thin[0].text.contains("1.5 cells of 0.2 m")
                && thin[0].text.contains("0.150 m or less"),
            "{thin:?}"
        );
        let row = of_boxes(|shape| shape["max"] = json!([1, 1.1]));
        assert!(row.len() == 1 && row[0].text.contains("one row of points"), "{row:?}");
        assert!(of_boxes(|shape| shape["max"] = json!([4, 2])).is_empty());
        let gap = of_boxes(|shape| (shape["min"], shape["max"]) = (json!([0, 1.05]), json!([1, 2.05])));
        assert!(
            gap.len() == 1 && gap[0].text.starts_with("bodies[1].shape: begins 5.0000e-2 m from \"a\""),
            "{gap:?}"
        );
        assert!(
            of_boxes(|shape| (shape["min"], shape["max"]) = (json!([0, 1.3]), json!([1, 2.3]))).is_empty()
        );
        assert!(of_boxes(|shape| shape["min"] = json!([0, 1.0 + 1e-12])).is_empty(), "round-off");
    }

    #[test]
    fn gaps_between_polygons_are_the_least_distance_of_their_sides() {
        let polygon = |corners: Value| {
            move |shape: &mut Value| *shape = json!({ "kind": "polygon", "vertices": corners.clone() })
        };
        let touching = of_boxes(polygon(json!([[0, 1], [1, 1], [0.5, 2]])));
        assert!(touching.is_empty(), "{touching:?}");
        let tip = of_boxes(polygon(json!([[0.5, 1.05], [1.5, 2], [0, 2]])));
        assert!(tip.len() == 1 && tip[0].text.contains("begins 5.0000e-2 m from \"a\", less"), "{tip:?}");
        assert!(of_boxes(polygon(json!([[0.5, 1.3], [1.5, 2.3], [0, 2.3]]))).is_empty());
    }

    #[test]
    fn a_slice_that_spans_the_domain_is_not_thin() {
        let slice = of_boxes(|shape| (shape["min"], shape["max"]) = (json!([0, 1]), json!([4, 1.3])));
        assert_eq!(slice.len(), 1, "across the other axis it is");
    }
}
