//! Crack tip: the distance that a crack has propagated (sheet: snow-mpm §3.11).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error_collector::ErrorCollector;
use crate::measure::{FieldUse, MeasureDefinition, MeasuredState, ScalarOutput, visit_position};
use crate::{Case, RemovalShape, Snapshot};

/// Default damage at which a point counts as broken: 0.5.
const fn default_damage() -> f64 {
    0.5
}

/// Crack through a body, in bins along a line. A bin is cracked where one of its points has failed. It is cut where the body has been cut
/// and no point is left. Points count in the bin of their initial position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackTip {
    /// Weak layer body.
    pub body: String,
    /// Scalar field that marks failure: `collapsed` of weak `cohesive-cam-clay` layers.
    pub field: String,
    /// Failure threshold: the field is at least this.
    #[serde(default = "default_damage")]
    pub threshold: f64,
    /// Whether failed points are at or below the threshold instead.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub below: bool,
    /// Crack direction, of any length.
    pub direction: Vec<f64>,
    /// Origin of bins and distances (m): the body's end where the crack begins.
    pub from: Vec<f64>,
    /// Bin width (m), at least a point's: a grid cell.
    pub bin: f64,
}

impl CrackTip {
    /// Tip of the crack in a body along a direction, from a position (m), in bins of a width (m). A point is broken where the field is at
    /// least 0.5.
    #[must_use]
    pub fn new(
        body: impl Into<String>,
        field: impl Into<String>,
        direction: impl Into<Vec<f64>>,
        from: impl Into<Vec<f64>>,
        bin: f64,
    ) -> Self {
        Self {
            body: body.into(),
            field: field.into(),
            threshold: default_damage(),
            below: false,
            direction: direction.into(),
            from: from.into(),
            bin,
        }
    }
}

impl MeasureDefinition for CrackTip {
    fn check(&self, path: &str, errors: &mut ErrorCollector<'_>) {
        let bodies: Vec<&str> = errors.case.bodies.iter().map(|body| body.name.as_str()).collect();
        errors.name(&format!("{path}.body"), &self.body, &bodies, "the name of a body");
        errors.vector(&format!("{path}.direction"), &self.direction);
        let is_zero = self.direction.iter().all(|c| *c == 0.0);
        errors.require(!is_zero, format!("{path}.direction"), "must not be zero");
        errors.vector(&format!("{path}.from"), &self.from);
        errors.finite(format!("{path}.threshold"), self.threshold);
        errors.positive(format!("{path}.bin"), self.bin, "m");
        let dimension = errors.case.dimension();
        if is_zero || self.direction.len() != dimension || self.from.len() != dimension {
            return;
        }
        let reach = self.body_end(errors.case).unwrap_or(f64::INFINITY);
        let body = &self.body;
        let problem =
            format!("the body {body:?} does not lie along the direction from here: the crack has no length");
        // Layers along a track have no extent before the track is known.
        errors.require(reach > 0.0 || !reach.is_finite(), format!("{path}.from"), problem);
    }

    fn read(&self, name: &str, state: &MeasuredState<'_>) -> Vec<ScalarOutput> {
        let [main, farthest] = self.tip_distances(state.case, state.snapshot, state.travels);
        vec![(name.to_owned(), "m".to_owned(), main), (format!("{name}.farthest"), "m".to_owned(), farthest)]
    }

    fn visit_coordinates(&mut self, visit: &mut dyn FnMut(usize, &mut f64)) {
        visit_position(&mut self.from, visit);
    }

    fn fields(&self) -> Vec<FieldUse<'_>> {
        vec![FieldUse { key: "field".to_owned(), name: self.field.as_str().into(), is_scalar: true }]
    }
}

/// State of an interval along the crack path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CrackBin {
    /// No point in the bin: removed where a removal shape has passed, else empty from the start.
    Empty,
    /// No failed point.
    Intact,
    /// At least one failed point.
    Failed,
}

impl CrackTip {
    /// Distances from the start of the crack along its direction (m). The first one is that to the end of the connected crack: the
    /// intervals that are failed or cut without a gap. The second one is that to the end of the farthest failed or cut interval. NaN where
    /// the snapshot lacks the field. `travels` are the travelled distances of the removal shapes
    /// ([`Solver::removal_shape_travel`](crate::Solver::removal_shape_travel)).
    pub fn tip_distances(&self, case: &Case, snapshot: &Snapshot, travels: &[Option<f64>]) -> [f64; 2] {
        let (Some(bins), Some(end)) = (self.bins(case, snapshot), self.body_end(case)) else {
            return [f64::NAN; 2];
        };
        let reached = |count: usize| (count as f64 * self.bin).min(end);
        // Slanted ends of a layer leave bins without a point, also at the sawn end.
        let swept: Vec<[f64; 2]> = self.swept_intervals(case, travels);
        let is_cut = |number: usize| {
            let [low, high] = [number, number + 1].map(|side| side as f64 * self.bin);
            swept.iter().any(|interval| low < interval[1] && high > interval[0])
        };
        let gone = |number: &usize| match bins[*number] {
            CrackBin::Empty => is_cut(*number),
            CrackBin::Intact => false,
            CrackBin::Failed => true,
        };
        let farthest = |count: usize| (0..count).rfind(gone).map_or(0, |number| number + 1);
        let whole = bins.iter().position(|bin| *bin == CrackBin::Intact).unwrap_or(bins.len());
        [reached(farthest(whole)), reached(farthest(bins.len()))]
    }

    /// Intervals swept by the removal shapes of the body (m from the start of the crack, along the direction).
    fn swept_intervals(&self, case: &Case, travels: &[Option<f64>]) -> Vec<[f64; 2]> {
        let along = self.unit_direction();
        let interval = |(cut, travel): (&RemovalShape, &Option<f64>)| {
            let moving = if cut.speed() > 0.0 { (*travel)? / cut.speed() } else { (*travel)? };
            let mut ends = [0.0; 2];
            for (axis, [low, high]) in
                cut.bounds(case.dimension()).into_iter().enumerate().take(case.dimension())
            {
                let (from, shift) = (self.from[axis], cut.velocity[axis] * moving);
                let sides = [low, high, low + shift, high + shift].map(|x| along[axis] * (x - from));
                ends[0] += sides.into_iter().fold(f64::INFINITY, f64::min);
                ends[1] += sides.into_iter().fold(f64::NEG_INFINITY, f64::max);
            }
            cut.applies_to(&self.body).then_some(ends)
        };
        case.removal_shapes.iter().zip(travels).filter_map(interval).collect()
    }

    /// End of the body along the direction (m from the start of the crack).
    fn body_end(&self, case: &Case) -> Option<f64> {
        let body = case.bodies.iter().find(|body| body.name == self.body)?;
        let (low, high) = body.shape.bounds(case.dimension());
        let along = self.unit_direction();
        let largest = |axis: usize| (along[axis] * low[axis]).max(along[axis] * high[axis]);
        let start: f64 = (0..case.dimension()).map(|axis| along[axis] * self.from[axis]).sum();
        Some((0..case.dimension()).map(largest).sum::<f64>() - start)
    }

    /// Unit vector of the direction.
    fn unit_direction(&self) -> [f64; 3] {
        let length = self.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        std::array::from_fn(|axis| self.direction.get(axis).map_or(0.0, |c| c / length))
    }

    /// States of the intervals along the crack path, from the points of the body; `None` without the body or the field.
    fn bins(&self, case: &Case, snapshot: &Snapshot) -> Option<Vec<CrackBin>> {
        let number = case.bodies.iter().position(|body| body.name == self.body)?;
        let values = snapshot.scalars(&self.field)?;
        let moved = snapshot.vectors("displacement");
        let along = self.unit_direction();
        let count = (self.body_end(case)? / self.bin - 1e-9).ceil().max(0.0) as usize;
        let mut bins = vec![CrackBin::Empty; count];
        for (i, place) in snapshot.positions.iter().enumerate() {
            if snapshot.bodies[i] as usize != number {
                continue;
            }
            // Points remain in the bin of their initial position.
            let at = |axis: usize| place[axis] - moved.map_or(0.0, |moved| moved[i][axis]);
            let from = |axis: usize| self.from.get(axis).copied().unwrap_or(0.0);
            let distance: f64 = (0..3).map(|axis| along[axis] * (at(axis) - from(axis))).sum();
            let Some(bin) = bins.get_mut((distance / self.bin).floor() as usize).filter(|_| distance >= 0.0)
            else {
                continue;
            };
            let failed = if self.below { values[i] <= self.threshold } else { values[i] >= self.threshold };
            *bin = if failed || *bin == CrackBin::Failed { CrackBin::Failed } else { CrackBin::Intact };
        }
        Some(bins)
    }
}

#[cfg(test)]
mod tests {
    use colluvium_testkit::assert_near;

    use super::*;
    use crate::{Field, FieldData};

    /// Body from 0 to 1 m with points of the given positions, displacements and failure values.
    fn cracked_body(points: &[(f64, f64, f64)]) -> (Case, Snapshot) {
        let case = r#"{
            "title": "crack", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [ { "name": "weak", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 0.1] } } ],
            "removal_shapes": [ { "name": "saw", "shape": { "kind": "box", "min": [1, 0], "max": [1.2, 0.1] }, "velocity": [-0.25, 0] } ],
            "stages": [ { "name": "go", "duration": 1 } ]
        }"#;
        let count = points.len();
        let field = |name: &str, data| Field { name: name.to_owned(), unit: "", data };
        let snapshot = Snapshot {
            time: 0.0,
            step: 0,
            ids: (0..count as u64).collect(),
            bodies: vec![0; count],
            positions: points.iter().map(|(x, moved, _)| [x + moved, 0.05, 0.0]).collect(),
            extents: vec![[0.1; 3]; count],
            fields: vec![
                field(
                    "displacement",
                    FieldData::Vector(points.iter().map(|(_, moved, _)| [*moved, 0.0, 0.0]).collect()),
                ),
                field("collapsed", FieldData::Scalar(points.iter().map(|(.., failed)| *failed).collect())),
            ],
        };
        (Case::from_json(case).unwrap(), snapshot)
    }

    fn tip(direction: [f64; 2], from: [f64; 2]) -> CrackTip {
        CrackTip {
            body: "weak".to_owned(),
            field: "collapsed".to_owned(),
            threshold: 0.5,
            below: false,
            direction: direction.to_vec(),
            from: from.to_vec(),
            bin: 0.1,
        }
    }

    #[test]
    fn the_crack_tip_is_the_end_of_the_contiguous_cut_or_cracked_part() {
        // From the right: two bins cut away, two cracked, one of whose points has moved into the next bin; a daughter crack beyond.
        let places: Vec<(f64, f64, f64)> = (0..8)
            .map(|i| {
                (
                    0.05 + 0.1 * f64::from(i),
                    if i == 6 { -0.1 } else { 0.0 },
                    f64::from(u8::from(i > 5 || i == 3)),
                )
            })
            .collect();
        let (case, snapshot) = cracked_body(&places);
        let [main, farthest] = tip([-2.0, 0.0], [1.0, 0.0]).tip_distances(&case, &snapshot, &[Some(0.2)]);
        assert_near(main, 0.4, 1e-12);
        assert_near(farthest, 0.7, 1e-12);
        let [main, farthest] = tip([1.0, 0.0], [0.0, 0.0]).tip_distances(&case, &snapshot, &[Some(0.2)]);
        assert_near(main, 0.0, 0.0);
        assert_near(farthest, 1.0, 1e-12);
    }

    #[test]
    fn a_crack_that_points_out_of_its_body_is_refused() {
        let (case, _) = cracked_body(&[]);
        for (direction, from, refused) in [
            ([-1.0, 0.0], [1.0, 0.0], false),
            ([-1.0, 0.0], [0.0, 0.0], true),
            ([1.0, 0.0], [1.0, 0.0], true),
        ] {
            let mut errors = ErrorCollector { case: &case, errors: Vec::new(), origin: [0.0; 3] };
            tip(direction, from).check("measures.crack", &mut errors);
            let paths: Vec<String> = errors.errors.iter().map(ToString::to_string).collect();
            assert_eq!(
                paths.iter().any(|error| error.starts_with("measures.crack.from")),
                refused,
                "{paths:?}"
            );
        }
    }

    #[test]
    fn empty_bins_at_slanted_layer_ends_do_not_count_as_cracked() {
        let places: Vec<(f64, f64, f64)> = (2..9).map(|i| (0.05 + 0.1 * f64::from(i), 0.0, 0.0)).collect();
        let (mut case, snapshot) = cracked_body(&places);
        // The saw starts at 1 m and passes the empty bin at 0.95 m on its way to 0.75 m, but never reaches the empty bins below 0.2 m.
        let tips = |case: &Case, travel: Option<f64>| {
            tip([-1.0, 0.0], [1.0, 0.0]).tip_distances(case, &snapshot, &[travel])
        };
        assert_eq!(tips(&case, None), [0.0, 0.0], "before the saw begins");
        assert_eq!(tips(&case, Some(0.0)), [0.0, 0.0], "as it begins");
        assert_eq!(tips(&case, Some(0.07)), [0.1, 0.1]);
        assert_eq!(tips(&case, Some(0.25)), [0.1, 0.1], "whole points in its way, as of another layer");
        case.removal_shapes.clear();
        assert_eq!(tips(&case, None), [0.0, 0.0]);
    }

    #[test]
    fn a_crack_through_the_body_ends_with_it() {
        let places: Vec<(f64, f64, f64)> = (0..10).map(|i| (0.05 + 0.1 * f64::from(i), 0.0, 1.0)).collect();
        let (case, snapshot) = cracked_body(&places);
        let wide = CrackTip { bin: 0.3, ..tip([-1.0, 0.0], [1.0, 0.0]) };
        assert_eq!(wide.tip_distances(&case, &snapshot, &[None]), [1.0, 1.0]);
        let none = CrackTip { field: "heat".to_owned(), ..wide };
        assert!(none.tip_distances(&case, &snapshot, &[None])[0].is_nan());
    }
}
