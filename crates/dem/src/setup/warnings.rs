//! Warnings about a case that DEM accepts.

use colluvium_case::Case;
use colluvium_case::description::Wall;

use crate::config::{DemOptions, Fill};
use crate::points::vector::norm;
use crate::solver::DemSolver;
use crate::specimen::Specimen;
use colluvium_case::{Warning, friction_warning};

/// Difference between the actual and the requested porosity that causes a warning.
const POROSITY_TOLERANCE: f64 = 0.01;
/// Overlap over the diameter under the weight of the body, above which there is a warning (sheet: dem §7). Porosity and coordination then
/// depend on the stiffness.
const MAX_WEIGHT_OVERLAP: f64 = 0.01;

/// Warnings of a solver at time zero.
pub(super) fn warnings<const D: usize, const R: usize>(
    case: &Case,
    solver: &DemSolver<D, R>,
) -> Vec<Warning> {
    let mut warnings = case.warnings();
    option_warnings(case, &solver.clock.options, &mut warnings);
    warnings.extend(friction_warnings(&solver.clock.options));
    warnings.extend(underived_pair_warnings(&solver.clock.options));
    warnings.extend(soft_grain_warnings(case, solver));
    warnings.extend(porosity_warnings(solver));
    warnings.extend(solver.specimen.source.notes.iter().cloned());
    warnings
}

/// Adds warnings for grains without rolling resistance, and for grains of a single size.
fn option_warnings(case: &Case, options: &DemOptions, warnings: &mut Vec<Warning>) {
    let flat = |wall: &Wall| matches!(wall, Wall::Rough | Wall::Frictional { .. });
    let resists = options.pairs.iter().any(|pair| pair.rolling.is_some());
    let falls = case.gravity.iter().any(|g| *g != 0.0);
    if falls && case.boundaries.iter().any(|boundary| flat(&boundary.wall)) && !resists {
        warnings.push(Warning::new(
            "grains-roll",
            "boundaries: single grains roll on a flat wall without stopping; use a floor of held grains, \
             or rolling resistance",
        ));
    }
    for (name, kind) in &options.grains {
        let mono = kind.diameter.as_ref().is_some_and(|sizes| sizes.range().1 < 1.2 * sizes.range().0);
        let lattice = matches!(kind.fill, Some(Fill::Lattice { .. }));
        if mono && case.dimension() == 2 && !lattice {
            warnings.push(Warning::new("grains-form-lattice", format!(
                "methods.dem.grains.{name}.diameter: disks of nearly one size form a regular lattice; use \
                 diameters that differ by 20 % or more"
            )));
        }
    }
}

/// Warnings about coefficients of friction and rolling friction that are probably angles in degrees.
fn friction_warnings(options: &DemOptions) -> Vec<Warning> {
    let coefficients = options.pairs.iter().enumerate().flat_map(|(number, pair)| {
        let path = format!("methods.dem.pairs[{number}]");
        let sliding =
            pair.friction.as_ref().map(|own| (format!("{path}.friction.coefficient"), own.coefficient));
        let rolling = pair.rolling.as_ref().map(|own| (format!("{path}.rolling.friction"), own.friction));
        sliding.into_iter().chain(rolling)
    });
    coefficients.filter_map(|(path, coefficient)| friction_warning(&path, coefficient)).collect()
}

/// Warnings about pairs derived by `mix` from kinds whose further interactions are not derived.
fn underived_pair_warnings(options: &DemOptions) -> Vec<Warning> {
    let pair = |a: &str, b: &str| {
        options.pairs.iter().find(|pair| {
            let [one, two] = &pair.between;
            (one == a && two == b) || (one == b && two == a)
        })
    };
    let more = |kind: &str| {
        let own = pair(kind, kind)?;
        let parts = [
            ("rolling", own.rolling.is_some()),
            ("twisting", own.twisting.is_some()),
            ("adhesion", own.adhesion.is_some()),
            ("bond", own.bond.is_some()),
        ];
        parts.into_iter().find(|(_, has)| *has).map(|(key, _)| (kind.to_owned(), key))
    };
    let kinds: Vec<&str> = options.grains.keys().map(String::as_str).collect();
    let mut warnings = Vec::new();
    for (number, a) in kinds.iter().enumerate().filter(|_| options.mix) {
        for b in kinds[number + 1..].iter().filter(|b| pair(a, b).is_none()) {
            if let Some((kind, key)) = more(a).or_else(|| more(b)) {
                warnings.push(Warning::new("underived-pair", format!(
                    "methods.dem.mix: grains of {a:?} and {b:?} have no {key} between them, although those \
                     of {kind:?} have it: if it matters, give this pair in methods.dem.pairs"
                )));
            }
        }
    }
    warnings
}

/// Warnings for kinds of grains with large overlaps under the weight of their body. At its base a contact force is about the pressure times
/// the diameter, in space its square.
fn soft_grain_warnings<const D: usize, const R: usize>(
    case: &Case,
    solver: &DemSolver<D, R>,
) -> Vec<Warning> {
    let (g, gravity) = (&solver.grains, solver.clock.gravity_at::<D>(0.0));
    let size = norm(&gravity);
    if size == 0.0 {
        return Vec::new();
    }
    let down =
        (0..D).fold(0, |largest, c| if gravity[c].abs() >= gravity[largest].abs() { c } else { largest });
    let of_body = |body: usize| {
        let own: Vec<usize> = (0..g.len()).filter(|&i| g.body[i] as usize == body && !g.is_held[i]).collect();
        let first = *own.first()?;
        let mean = 2.0 * own.iter().map(|&i| g.radius[i]).sum::<f64>() / own.len() as f64;
        let weight = size * own.iter().map(|&i| g.mass[i]).sum::<f64>();
        let width = |c: usize| {
            let ends =
                |end: f64, pick: fn(f64, f64) -> f64| own.iter().map(|&i| g.position[i][c]).fold(end, pick);
            ends(f64::NEG_INFINITY, f64::max) - ends(f64::INFINITY, f64::min) + mean
        };
        let foot: f64 = (0..D).filter(|c| *c != down).map(width).product();
        let pressure = weight / foot;
        let kind = g.kind[first] as usize;
        let law = solver.laws.stage.pairs[kind * solver.laws.kinds.len() + kind];
        if law.bond.is_some() {
            return None;
        }
        let share = law.normal.overlap(pressure * mean.powi(D as i32 - 1), 0.25 * mean) / mean;
        (share > MAX_WEIGHT_OVERLAP).then(|| {
            Warning::new(
                "soft-grains",
                format!(
                    "methods.dem.pairs: the weight of the body {:?} ({pressure:.3e} Pa at its base) causes \
                 overlaps of about {:.1} % of the diameter, so that porosity, coordination and flow depend \
                 on the stiffness; for overlaps of 0.1 %, make contacts {:.0} times as stiff",
                    case.bodies[body].name,
                    1e2 * share,
                    law.normal.stiffness_factor(share / 1e-3),
                ),
            )
        })
    };
    (0..case.bodies.len()).filter_map(of_body).collect()
}

/// Warnings for bodies whose porosity differs from the requested one.
fn porosity_warnings<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Vec<Warning> {
    let is_far = |own: &&Specimen| {
        own.requested_porosity.is_some_and(|requested| (own.porosity - requested).abs() > POROSITY_TOLERANCE)
    };
    let text = |own: &Specimen| {
        Warning::new(
            "porosity-missed",
            format!(
                "{own}: grains that would extend beyond the shape or into obstacles are left out. Use a \
                 larger body or smaller grains"
            ),
        )
    };
    solver.specimen.reports.iter().filter(is_far).map(text).collect()
}
