//! Inflows of a case, across lines and through ends of a profile.

use colluvium_case::{Case, CaseError, Quantity, read_pairs};

use super::{NAME, option_error};
use crate::bed::Bed;
use crate::config::choices::{FlowLayer, InflowDistribution, Phases};
use crate::config::{DepthOptions, InflowOptions};
use crate::flow::{Flow, Inlet, Opening};
use crate::inflow::cross_section::CrossSection;
use crate::inflow::{Inflow, InflowSection, InflowState};
use crate::setup::open_boundaries::MAX_SEGMENTS;
use colluvium_case::CaseErrorKind;
use colluvium_case::Warning;

/// Mean bed slope in the direction of an inflow above which there is a warning.
const MAX_UPHILL_SLOPE: f64 = 0.02;

/// Number of rows behind an inflow line in addition to those in kernel range.
const ROWS: f64 = 2.0;

/// Adds the inflow lines of a case to its flow. Returns the inflows through ends of a profile, each with its opening and key.
pub fn add_inflows<const D: usize>(
    case: &Case,
    options: &DepthOptions,
    flow: &mut Flow<D>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<(Opening, String)>, CaseError> {
    let (mut openings, mut standing): (Vec<(Opening, String)>, _) = (Vec::new(), Vec::new());
    for (number, given) in options.inflows.iter().enumerate() {
        let key = |name: &str| format!("inflows[{number}].{name}");
        let place = format!("methods.{NAME}.inflows[{number}]");
        if D == 1 {
            let opening = end_inlet(case, options, flow, given, &key)?;
            let cut = opening
                .inlets
                .iter()
                .find_map(|inlet| truncated_hydrograph_warning(&inlet.hydrograph, case.end_time()));
            warnings.extend(cut.map(|cut| Warning::new(cut.code, format!("{place}: {}", cut.text))));
            add_opening(&mut openings, opening, &key)?;
            continue;
        }
        let mut inflow = inflow::<D>(case, options, flow, given, &key)?;
        let little = outflow_warning(case, &inflow).map_err(|problem| option_error(&key("from"), problem))?;
        let level =
            highest_bed_level(&inflow, &flow.bed).map_err(|problem| option_error(&key("from"), problem))?;
        if given.across == InflowDistribution::Level {
            let bed =
                |k: usize| flow.bed.bed_point(&inflow.node_position(k, 0.0)).map_or(level, |bed| bed.level);
            let beds: Vec<f64> = (0..inflow.count()).map(bed).collect();
            inflow.channel = Some(CrossSection::new(inflow.width(), &beds));
        }
        let InflowSection { depth, speed, max_depth: deepest } = inflow.max_section();
        let before = flow.initial_state_at_inflow(&inflow);
        let [depth, deepest] =
            [depth, deepest].map(|own| before.map_or(own, |(standing, _)| standing.max(own)));
        inflow.depth = depth;
        if before.is_some() && flow.count_nodes_behind(&inflow) > 0 {
            let problem = "lies within a body, but nodes of the inflow are placed behind it: let the body begin at the line, to the right of the direction from `from` to `to`";
            return Err(option_error(&key("from"), problem));
        }
        standing.push(before);
        flow.limits.include(level + deepest, speed);
        if let Some(slope) = uphill_slope(&inflow, &flow.bed) {
            warnings.push(Warning::new("inflow-uphill", format!(
                "{place}: the bed rises by {:.1} % in the direction of the inflow, to the right of the line from `from` to `to`: \
                 check whether the two must be exchanged",
                100.0 * slope
            )));
        }
        let doubts =
            little.into_iter().chain(truncated_hydrograph_warning(&inflow.hydrograph, case.end_time()));
        warnings.extend(doubts.map(|doubt| Warning::new(doubt.code, format!("{place}: {}", doubt.text))));
        flow.boundary.inflows.push(inflow);
    }
    if standing.iter().any(Option::is_some) {
        flow.initialise_inflows(&standing).map_err(|failure| {
            option_error("inflows", CaseErrorKind::coded(failure.reason.code(), failure.to_string()))
        })?;
    }
    Ok(openings)
}

/// Adds the opening of an end of a profile, or adds its inlets to an existing opening of that end.
fn add_opening(
    openings: &mut Vec<(Opening, String)>,
    mut opening: Opening,
    key: &dyn Fn(&str) -> String,
) -> Result<(), CaseError> {
    let known = openings.iter_mut().find(|(known, _)| known.outward == opening.outward);
    let Some((known, _)) = known else {
        openings.push((opening, format!("methods.{NAME}.{}", key("side"))));
        return Ok(());
    };
    if known.inlets.iter().any(|known| opening.inlets.iter().any(|inlet| inlet.layer == known.layer)) {
        return Err(option_error(
            &key("side"),
            CaseErrorKind::coded("duplicate-name", "has another inflow: add up their discharges"),
        ));
    }
    known.inlets.append(&mut opening.inlets);
    Ok(())
}

/// Share of the domain ahead of an inflow line below which there is a warning.
const MIN_AREA_AHEAD: f64 = 0.1;

/// Warning for an inflow that is directed out of most of the domain, or an error if the flow leaves at once.
fn outflow_warning<const D: usize>(case: &Case, inflow: &Inflow<D>) -> Result<Option<Warning>, String> {
    let middle: [f64; D] = std::array::from_fn(|c| 0.5 * (inflow.start[c] + inflow.end[c]));
    let to_edge = |sense: f64| {
        let direction = inflow.normal().map(|c| sense * c);
        let edge = |c: usize| if direction[c] > 0.0 { case.domain.max[c] } else { case.domain.min[c] };
        let crossed = (0..D).filter(|&c| direction[c] != 0.0 && !case.domain.is_periodic(c));
        crossed.map(|c| (edge(c) - middle[c]) / direction[c]).fold(f64::INFINITY, f64::min).max(0.0)
    };
    let [ahead, behind] = [1.0, -1.0].map(to_edge);
    if !(ahead < MIN_AREA_AHEAD * (ahead + behind)) {
        return Ok(None);
    }
    let problem = format!(
        "the inflow leaves the domain {ahead:.3} m ahead of the line, and {behind:.3} m of the domain lie \
         behind the line: it flows to the right of the direction from `from` to `to`; exchange the two to \
         reverse the inflow"
    );
    if ahead < inflow.row_extent {
        Err(problem)
    } else {
        Ok(Some(Warning::new("inflow-leaves-domain", problem)))
    }
}

/// Warning for a run that ends (s) before the whole hydrograph has entered.
fn truncated_hydrograph_warning(hydrograph: &[[f64; 2]], end: f64) -> Option<Warning> {
    let until = |end: f64| {
        let part = |pair: &[[f64; 2]]| {
            let [[from, first], [to, last]] = [pair[0], pair[1]];
            let until = to.min(end);
            let at_end = first + (last - first) * (until - from) / (to - from).max(f64::MIN_POSITIVE);
            if until > from { 0.5 * (first + at_end) * (until - from) } else { 0.0 }
        };
        hydrograph.windows(2).map(part).sum::<f64>()
    };
    let (whole, brought) = (until(f64::INFINITY), until(end));
    let share = brought / whole;
    (share < 1.0 - 1e-9).then(|| {
        Warning::new(
            "hydrograph-truncated",
            format!(
                "the run ends at {end} s, when {:.1} % of the volume of the hydrograph has flowed in: to \
             include all of it, make the stages longer",
                100.0 * share
            ),
        )
    })
}

/// Porosity of an inflow of grains and fluid, by default that of the mixture; `None` for a single phase.
fn porosity(
    options: &DepthOptions,
    given: &InflowOptions,
    key: &dyn Fn(&str) -> String,
) -> Result<Option<f64>, CaseError> {
    let wrong = |problem: String| Err(option_error(&key("porosity"), problem));
    match given.porosity {
        Some(_) if options.phases != Phases::Two => wrong(
            "applies only to grains and fluid with separate nodes: set `phases` to `two`, or leave it out"
                .to_owned(),
        ),
        Some(porosity) if !(porosity > 0.0 && porosity < 1.0) => {
            wrong(format!("{porosity} is not between 0 and 1 (both excluded)"))
        }
        None if options.phases != Phases::Two => Ok(None),
        given => Ok(given.or(options.mixture.as_ref().map(|mixture| mixture.porosity))),
    }
}

/// Number of the layer of an inflow in a two-layer flow.
fn layer<const D: usize>(
    options: &DepthOptions,
    flow: &Flow<D>,
    given: &InflowOptions,
    key: &dyn Fn(&str) -> String,
) -> Result<Option<usize>, CaseError> {
    let wrong = |problem: &str| Err(option_error(&key("layer"), problem));
    let set = match (options.phases == Phases::Layers, given.layer) {
        (false, None) => return Ok(None),
        (false, Some(_)) => {
            return wrong("applies only to two layers: set `phases` to `layers`, or leave it out");
        }
        (true, None) => return wrong("is missing: give the layer that flows in, `lower` or `upper`"),
        (true, Some(FlowLayer::Lower)) => 0,
        (true, Some(FlowLayer::Upper)) => 1,
    };
    if flow.nodes.sets[set].is_empty() {
        return wrong(
            "has no body that defines the material of the inflow: add one, which may be small and away \
             from the flow",
        );
    }
    Ok(Some(set))
}

/// Opening of an end of a profile with an inflow.
fn end_inlet<const D: usize>(
    case: &Case,
    options: &DepthOptions,
    flow: &Flow<D>,
    given: &InflowOptions,
    key: &dyn Fn(&str) -> String,
) -> Result<Opening, CaseError> {
    let Some(side) = given.side.filter(|side| side.axis() == 0) else {
        return Err(option_error(
            &key("side"),
            "must be the end of the profile through which material flows in: x-min or x-max",
        ));
    };
    if given.from.is_some() || given.to.is_some() {
        return Err(option_error(
            &key("from"),
            CaseErrorKind::coded(
                "conflicting-keys",
                "belongs to a line in plan, which a profile does not have: leave it out",
            ),
        ));
    }
    if given.across != InflowDistribution::Even {
        let problem = "applies only to a line in plan: leave it out";
        return Err(option_error(&key("across"), CaseErrorKind::coded("conflicting-keys", problem)));
    }
    if case.boundaries.iter().any(|boundary| boundary.side == side) {
        let problem = "has a wall: leave the wall out";
        return Err(option_error(&key("side"), CaseErrorKind::coded("conflicting-keys", problem)));
    }
    let porosity = porosity(options, given, key)?.unwrap_or(0.0);
    let layer = layer(options, flow, given, key)?;
    let inlet = Inlet { hydrograph: hydrograph(given, key)?, froude: given.froude, porosity, layer };
    let coordinate = if side.is_max() { case.domain.max[0] } else { case.domain.min[0] };
    let outward = if side.is_max() { 1.0 } else { -1.0 };
    let beyond = [0.0, 4.0 * options.spacing]
        .map(|far| flow.bed.bed_point(&[coordinate + outward * far; D]).is_some());
    if beyond != [true; 2] {
        return Err(option_error(
            &key("side"),
            CaseErrorKind::coded(
                "no-data",
                "has no ground beyond it, where the nodes of the inflow are placed",
            ),
        ));
    }
    let (spacing, span) = (options.spacing, (0.0, 0.0));
    Ok(Opening {
        axis: 0,
        coordinate,
        outward,
        spacing,
        span,
        periodic: false,
        inlets: vec![inlet],
        absorbing_length: 0.0,
    })
}

/// Column names of times in hydrograph files, in several languages.
const TIMES: [&str; 6] = ["time", "t", "zeit", "temps", "tempo", "tiempo"];

/// Column names of discharges in hydrograph files, in several languages.
const DISCHARGES: [&str; 13] = [
    "discharge",
    "q",
    "flow",
    "flowrate",
    "rate",
    "inflow",
    "abfluss",
    "durchfluss",
    "zufluss",
    "débit",
    "debit",
    "portata",
    "caudal",
];

/// Hydrograph of an inflow, checked.
fn hydrograph(given: &InflowOptions, key: &dyn Fn(&str) -> String) -> Result<Vec<[f64; 2]>, CaseError> {
    if !(given.froude > 0.0 && given.froude.is_finite()) {
        return Err(option_error(&key("froude"), format!("{} must be positive", given.froude)));
    }
    let pairs = match (&given.hydrograph, given.discharge.is_empty()) {
        (Some(file), true) => {
            let columns: [(Quantity, &[&str]); 2] =
                [(Quantity::Time, &TIMES), (Quantity::Discharge, &DISCHARGES)];
            let of_file = |error: String| option_error(&key("hydrograph"), format!("{file}: {error}"));
            let pairs = read_pairs(file, columns)
                .map_err(|kind| option_error(&key("hydrograph"), kind.in_table(file)))?;
            check(&pairs).map_err(of_file)?;
            pairs
        }
        (None, false) => {
            check(&given.discharge).map_err(|problem| option_error(&key("discharge"), problem))?;
            given.discharge.clone()
        }
        _ => {
            return Err(option_error(
                &key("discharge"),
                CaseErrorKind::coded("conflicting-keys", "give either discharge or hydrograph"),
            ));
        }
    };
    Ok(pairs)
}

/// Inflow of its options: a line in plan, or a side of a profile.
fn inflow<const D: usize>(
    case: &Case,
    options: &DepthOptions,
    flow: &Flow<D>,
    given: &InflowOptions,
    key: &dyn Fn(&str) -> String,
) -> Result<Inflow<D>, CaseError> {
    let origin = case.origin();
    let place = |x: [f64; 2]| std::array::from_fn(|c| x[c] - origin[c]);
    if given.side.is_some() {
        return Err(option_error(
            &key("side"),
            CaseErrorKind::coded(
                "needs-other-key",
                "applies only to a profile: give a line in plan, `from` and `to`",
            ),
        ));
    }
    let (Some(from), Some(to)) = (given.from, given.to) else {
        let name = if given.from.is_none() { "from" } else { "to" };
        return Err(option_error(
            &key(name),
            CaseErrorKind::coded("needs-other-key", "is missing: a line in plan needs `from` and `to`"),
        ));
    };
    if from == to {
        return Err(option_error(&key("to"), "is equal to `from`: the line has no length"));
    }
    let places = (to[0] - from[0]).hypot(to[1] - from[1]) / options.spacing;
    if !(places <= MAX_SEGMENTS) {
        let problem = format!(
            "makes the line {places:.1e} spacings long, more than {MAX_SEGMENTS:.0e}: check that it is in \
             metres"
        );
        return Err(option_error(&key("to"), problem));
    }
    let hydrograph = hydrograph(given, key)?;
    let layer = layer(options, flow, given, key)?;
    let ratio = options.smoothing_ratio(D);
    Ok(Inflow {
        start: place(from),
        end: place(to),
        hydrograph,
        froude: given.froude,
        depth: 0.0,
        gravity: flow.settings.gravity,
        spacing: options.spacing,
        ratio,
        row_extent: (flow.settings.numerics.kernel.support() * ratio + ROWS) * options.spacing,
        body: layer.map_or(0, |set| flow.nodes.sets[set].nodes.body[0]),
        porosity: porosity(options, given, key)?,
        layer,
        channel: None,
        state: InflowState::default(),
    })
}

/// Checks a hydrograph (sheet: depth-sph §7).
fn check(hydrograph: &[[f64; 2]]) -> Result<(), String> {
    if hydrograph.len() < 2 {
        return Err("has fewer than two times".to_owned());
    }
    if let Some([time, discharge]) = hydrograph.iter().find(|pair| !(pair[1] >= 0.0 && pair[1].is_finite())) {
        return Err(format!("{discharge} m³/s at {time} s must not be negative"));
    }
    if let Some(pair) = hydrograph.windows(2).find(|pair| !(pair[1][0] > pair[0][0])) {
        return Err(format!("times must increase: {} s follows {} s", pair[1][0], pair[0][0]));
    }
    if hydrograph[0][0] < 0.0 || hydrograph.iter().all(|pair| pair[1] == 0.0) {
        return Err("must begin at zero or later and have a discharge above zero at some time".to_owned());
    }
    Ok(())
}

/// Mean bed slope in the direction of an inflow, if it is uphill.
fn uphill_slope<const D: usize>(inflow: &Inflow<D>, bed: &Bed<D>) -> Option<f64> {
    let places = (0..inflow.count()).filter_map(|k| bed.bed_point(&inflow.node_position(k, 0.0)));
    let slopes = places.map(|bed| -inflow.outward_and_tangential(&bed.slope)[0]);
    let slope = slopes.sum::<f64>() / inflow.count() as f64;
    (slope > MAX_UPHILL_SLOPE).then_some(slope)
}

/// Highest bed level under the nodes behind an inflow line (m).
fn highest_bed_level<const D: usize>(inflow: &Inflow<D>, bed: &Bed<D>) -> Result<f64, String> {
    let mut highest = f64::NEG_INFINITY;
    let count = inflow.count();
    let rows = (inflow.row_extent / inflow.spacing).ceil() as usize + 2;
    for number in 0..count * rows {
        let behind = inflow.spacing * (number / count) as f64;
        match bed.bed_point(&inflow.node_position(number % count, behind)) {
            Some(bed) => highest = highest.max(bed.level),
            None => {
                return Err(format!(
                    "there is no ground {behind} m behind the line, where its nodes are placed"
                ));
            }
        }
    }
    Ok(highest)
}

#[cfg(test)]
mod tests {
    use super::truncated_hydrograph_warning;

    #[test]
    fn a_hydrograph_longer_than_the_run_causes_a_warning() {
        let triangle = [[10.0, 0.0], [20.0, 4.0], [30.0, 0.0]];
        assert_eq!(truncated_hydrograph_warning(&triangle, 30.0), None);
        assert!(truncated_hydrograph_warning(&triangle, 20.0).unwrap().text.contains("at 20 s, when 50.0 %"));
        assert!(truncated_hydrograph_warning(&triangle, 25.0).unwrap().text.contains("when 87.5 %"));
        assert!(truncated_hydrograph_warning(&triangle, 5.0).unwrap().text.contains("when 0.0 %"));
    }
}
