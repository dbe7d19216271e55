//! Open boundaries of a case.

use colluvium_case::description::Wall;
use colluvium_case::{Case, CaseError};

use crate::boundary::open::node_extent_beyond;
use crate::config::DepthOptions;
use crate::config::choices::DepthFrame;
use crate::flow::{Flow, OpenBoundary, Opening};
use crate::setup::NAME;
use colluvium_case::CaseErrorKind;
use colluvium_case::Warning;

/// Bed slope across an open boundary above which the depth at the boundary does not apply outside (sheet: depth-sph §3.9).
const MAX_CROSS_SLOPE: f64 = 0.01;

/// Least length of an absorbing layer, in node distances.
const MIN_LAYER_NODES: f64 = 10.0;

/// Largest number of segments along an open boundary or inflow line.
pub const MAX_SEGMENTS: f64 = 1e6;

/// Absorbing boundaries of a case, with their keys.
pub fn openings(case: &Case, options: &DepthOptions) -> Vec<(Opening, String)> {
    let absorbing =
        case.boundaries.iter().enumerate().filter(|(_, side)| matches!(side.wall, Wall::Absorbing { .. }));
    absorbing
        .map(|(number, side)| {
            let axis = side.side.axis();
            let other = if case.dimension() == 3 { 1 - axis } else { 0 };
            let span = span(case, other);
            let opening = Opening {
                axis,
                coordinate: side.wall_coordinate(&case.domain),
                outward: if side.side.is_max() { 1.0 } else { -1.0 },
                spacing: options.spacing,
                span,
                periodic: case.dimension() == 3 && case.domain.is_periodic(other),
                inlets: Vec::new(),
                absorbing_length: options.absorbing_layer.unwrap_or(0.0),
            };
            (opening, format!("boundaries[{number}].side"))
        })
        .collect()
}

/// Range of boundaries along an axis (m), between walls and open boundaries.
fn span(case: &Case, axis: usize) -> (f64, f64) {
    let (mut low, mut high) = (case.domain.min[axis], case.domain.max[axis]);
    for side in case.boundaries.iter().filter(|side| side.side.axis() == axis) {
        let place = side.wall_coordinate(&case.domain);
        if side.side.is_max() { high = high.min(place) } else { low = low.max(place) }
    }
    (low, high)
}

/// Makes the absorbing sides of a case open boundaries of the flow; returns warnings.
pub fn open_boundaries<const D: usize>(
    openings: &[(Opening, String)],
    flow: &mut Flow<D>,
) -> Result<Vec<Warning>, CaseError> {
    let Some((_, first)) = openings.first() else { return Ok(Vec::new()) };
    let mut warnings = Vec::new();
    let mut slopes = Vec::new();
    for (opening, key) in openings {
        check_segment_count(opening, key)?;
        slopes.push(slope_across(opening, flow, key)?);
    }
    let sides: Vec<Opening> = openings.iter().map(|(opening, _)| opening.clone()).collect();
    let known = flow.boundary.open_sides.len();
    flow.open_sides(&sides).map_err(|failure| {
        CaseError::new(first, CaseErrorKind::coded(failure.reason.code(), failure.to_string()))
    })?;
    let each = (flow.boundary.open_sides.len() - known) / openings.len();
    let ends = flow.boundary.open_sides[known..].chunks(each.max(1));
    for (((_, key), slope), ends) in openings.iter().zip(slopes).zip(ends) {
        // Material that leaves over a dry bed meets nothing that could reflect waves.
        let stands = ends.iter().any(OpenBoundary::is_filled);
        if let Some(slope) = slope.filter(|slope| stands && slope.abs() > MAX_CROSS_SLOPE) {
            warnings.push(Warning::new("side-reflects-waves", format!(
                "{key}: the bed has a slope of {slope:.3} across this side, but the depth beyond the side \
                 is assumed to be equal to that at the side. The side therefore reflects waves: move it to \
                 where the bed is level"
            )));
        }
    }
    if let Some((opening, _)) = openings.iter().find(|(side, _)| {
        side.absorbing_length > 0.0 && side.absorbing_length < MIN_LAYER_NODES * side.spacing
    }) {
        warnings.push(Warning::new(
            "side-reflects-waves",
            format!(
                "methods.{NAME}.absorbing_layer: {} m are fewer than {MIN_LAYER_NODES} nodes, and the layer \
             reflects more than it absorbs: make it as long as two waves",
                opening.absorbing_length
            ),
        ));
    }
    Ok(warnings)
}

/// Rejects a boundary with too many segments.
fn check_segment_count(opening: &Opening, key: &str) -> Result<(), CaseError> {
    let Opening { spacing, span, absorbing_length: layer, .. } = opening;
    let places = ((span.1 - span.0) / spacing).max(1.0) * (layer / spacing).max(1.0);
    if places <= MAX_SEGMENTS {
        return Ok(());
    }
    let problem = format!(
        "has {places:.1e} segments along it and in its layer, more than {MAX_SEGMENTS:.0e}: make the \
         domain there no wider than the flow, or the spacing larger"
    );
    Err(CaseError::new(key, problem))
}

/// Steepest bed slope across an open boundary; an error if there is no bed outside it.
fn slope_across<const D: usize>(
    opening: &Opening,
    flow: &Flow<D>,
    key: &str,
) -> Result<Option<f64>, CaseError> {
    let Opening { axis, coordinate, outward, spacing, span, .. } = opening;
    let lengths = flow.nodes.sets.iter().flat_map(|set| &set.nodes.first_length);
    let reach = node_extent_beyond(&flow.settings, lengths.copied().fold(0.0, f64::max));
    let count = if D == 1 { 1 } else { ((span.1 - span.0) / spacing).ceil().max(1.0) as usize };
    let mut steepest = None;
    for k in 0..count {
        let along = if D == 1 { 0.0 } else { span.0 + (k as f64 + 0.5) / count as f64 * (span.1 - span.0) };
        let at = |beyond: f64| {
            let x: [f64; D] =
                std::array::from_fn(|c| if c == *axis { coordinate + outward * beyond } else { along });
            flow.bed.bed_point(&x)
        };
        let (Some(here), Some(_)) = (at(0.0), at(reach + spacing)) else {
            let problem = format!(
                "has no ground for {:.3} m beyond it, where nodes are placed: give it a `position` farther \
                 inside, or make the terrain larger",
                reach + spacing
            );
            return Err(CaseError::new(key, problem));
        };
        // In the frame of a tilted bed depth follows the bed.
        if flow.settings.frame != DepthFrame::BedFitted
            && steepest.is_none_or(|slope: f64| here.slope[*axis].abs() > slope.abs())
        {
            steepest = Some(outward * here.slope[*axis]);
        }
    }
    Ok(steepest)
}
