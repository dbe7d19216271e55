//! Checks of a solver at the start against its case.

use colluvium_case::CaseError;

use crate::clock::Clock;
use crate::config::Fill;
use crate::contact::contact_laws::ContactLaws;
use crate::solver::DemSolver;
use colluvium_case::CaseErrorKind;

/// Checks that the contacts allow a fixed time step of the case.
pub(super) fn check_step(clock: &Clock, laws: &ContactLaws) -> Result<(), CaseError> {
    let [stable, bound] = laws.stage.step;
    let Some(step) = clock.options.time_step.filter(|step| *step > bound) else {
        return Ok(());
    };
    let problem = format!(
        "{step} s is larger than {bound:.4e} s, the longest step of the stiffest contact with its lightest grains; {stable:.4e} s is \
         taken where it is left out"
    );
    Err(CaseError::new("methods.dem.time_step", problem))
}

/// Checks the membranes and servo walls of the stages against the grains and walls.
pub(super) fn check_stages<const D: usize, const R: usize>(
    solver: &DemSolver<D, R>,
) -> Result<(), CaseError> {
    check_sheets(solver)?;
    check_areas(solver)
}

/// Checks that membranes in space consist of at least two complete rows of grains, and that those filled with rings are closed.
fn check_sheets<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Result<(), CaseError> {
    for (stage, own) in &solver.clock.options.stages {
        for (name, membrane) in &own.membranes {
            let Some(columns) = membrane.columns else { continue };
            let number = solver.clock.case.bodies.iter().position(|body| body.name == *name);
            let count = solver.grains.body.iter().filter(|own| Some(**own as usize) == number).count();
            let body =
                number.map(|number| &solver.clock.case.bodies[number]).filter(|body| body.points.is_none());
            let problem = match body.and_then(|body| solver.clock.options.fill_of_body(body)) {
                _ if count % columns != 0 || count < 2 * columns => {
                    format!("the body has {count} grains, which do not form two or more rows of {columns}")
                }
                Some(Fill::Sleeve { columns: rings }) if rings != columns || !membrane.closed => {
                    format!(
                        "the body is filled with rings of {rings} grains: set columns to {rings} and closed to true"
                    )
                }
                _ => continue,
            };
            let path = format!("methods.dem.stages.{stage}.membranes.{name}.columns");
            return Err(CaseError::new(path, problem));
        }
    }
    Ok(())
}

/// Checks that the area of each servo-controlled wall is bounded by walls or periodic boundaries, or given by the case.
fn check_areas<const D: usize, const R: usize>(solver: &DemSolver<D, R>) -> Result<(), CaseError> {
    let case = &solver.clock.case;
    for (stage, own) in &solver.clock.options.stages {
        for (name, servo) in &own.walls {
            let path = format!("methods.dem.stages.{stage}.walls.{name}");
            let Some(wall) = case.boundaries.iter().find(|boundary| boundary.name() == name) else {
                continue;
            };
            let axis = wall.side.axis();
            if let Some(sleeve) = &servo.sleeve {
                if solver
                    .boundary
                    .membranes
                    .enclosed_area(&solver.clock, &solver.grains, sleeve, axis)
                    .is_none()
                {
                    let problem = format!("{sleeve:?} is not a body that is a closed membrane in a stage");
                    return Err(CaseError::new(format!("{path}.sleeve"), problem));
                }
                continue;
            }
            let bounded = |other: usize| {
                let on = |upper| {
                    case.boundaries.iter().any(|own| own.side.axis() == other && own.side.is_max() == upper)
                };
                other == axis || case.domain.is_periodic(other) || (on(false) && on(true))
            };
            if let (None, Some(other)) = (servo.area, (0..D).find(|&other| !bounded(other))) {
                let problem = format!(
                    "is missing: along {} no walls bound the grains that {name:?} presses on; give the area, or in 3d the membrane around the grains as sleeve",
                    ["x", "y", "z"][other]
                );
                return Err(CaseError::new(
                    format!("{path}.area"),
                    CaseErrorKind::coded("needs-other-key", problem),
                ));
            }
        }
    }
    Ok(())
}

/// Checks the initial overlaps of grains with each other and with walls.
pub(super) fn check_overlaps<const D: usize, const R: usize>(
    solver: &DemSolver<D, R>,
) -> Result<(), CaseError> {
    let (g, maximum) = (&solver.grains, solver.clock.options.initial_overlap);
    let mut largest: Option<(f64, usize, Option<usize>)> = None;
    let view = solver.view();
    view.for_each_contact(|contact, _, _| {
        let share = view.overlap_of(&contact);
        let given = |grain: usize| solver.specimen.source.has_body(g.body[grain] as usize);
        // A specimen is in equilibrium with its overlaps.
        let of_file = given(contact.grain) && contact.second.is_none_or(given);
        let maximum = if of_file { maximum.max(solver.specimen.source.overlap) } else { maximum };
        if share > maximum * (1.0 + 1e-9) && largest.is_none_or(|(before, ..)| share > before) {
            largest = Some((share, contact.grain, contact.second));
        }
    });
    let Some((share, i, other)) = largest else { return Ok(()) };
    let body = |grain: usize| &solver.clock.case.bodies[g.body[grain] as usize].name;
    let with = match other {
        Some(j) => format!("grain {} of body {:?} at {:.4?} m", g.id[j], body(j), g.position[j]),
        None => "a wall".to_owned(),
    };
    let problem = CaseErrorKind::coded(
        "overlap",
        format!(
            "grain {} at {:.4?} m and {with} overlap by {share:.3} of the smaller radius at the start, more than {maximum}: fill more \
         loosely, or raise initial_overlap",
            g.id[i], g.position[i]
        ),
    );
    Err(CaseError::new(format!("bodies[{}].shape", g.body[i]), problem))
}
