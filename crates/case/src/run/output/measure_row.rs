//! Row of the measures, and the names of its columns that a case may use.

use crate::files::json::closest;
use crate::measure;
use crate::measure::{AXES, FieldUse, Measure, ScalarOutput};
use crate::{Budget, Case, CaseError, CaseErrorKind, CaseErrors, FrameRequest, Snapshot, Solver};

/// Fields of every frame in addition to those of its snapshot.
const ALWAYS_IN_FRAMES: [&str; 3] = ["id", "body", "extent"];

/// Columns of a row that are independent of the measures of the case: time, totals, and columns of the method.
pub(crate) fn run_outputs(solver: &dyn Solver, time_step: Option<f64>) -> Vec<ScalarOutput> {
    let mut readings = Vec::new();
    let mut push = |name: &str, unit: &str, value: f64| {
        readings.push((name.to_owned(), unit.to_owned(), value));
    };
    push("time", "s", solver.time());
    push("step", "", solver.step_count() as f64);
    push("time_step", "s", time_step.unwrap_or(f64::NAN));
    if let Some(budget) = solver.budget() {
        totals(&budget, solver.dissipated(), &mut push);
    }
    let equilibrium = solver.equilibrium();
    push("unbalanced_force", "", equilibrium.map_or(f64::NAN, |e| e.unbalanced_force));
    push("kinetic_ratio", "", equilibrium.map_or(f64::NAN, |e| e.kinetic_ratio));
    readings.extend(solver.scalar_outputs());
    readings
}

/// Adds columns of totals, with the dissipated energy (J).
fn totals(budget: &Budget, dissipated: Option<f64>, push: &mut dyn FnMut(&str, &str, f64)) {
    push("mass", "kg", budget.mass);
    for (c, axis) in AXES.into_iter().enumerate() {
        push(&format!("momentum.{axis}"), "kg m/s", budget.momentum[c]);
    }
    push("angular_momentum.z", "kg m2/s", budget.angular_momentum[2]);
    push("kinetic_energy", "J", budget.kinetic);
    push("elastic_energy", "J", budget.elastic);
    push("potential_energy", "J", budget.potential);
    push("total_energy", "J", budget.total() + dissipated.unwrap_or(0.0));
    if let Some(liquid) = &budget.liquid {
        push("liquid_mass", "kg", liquid.mass);
        for (c, axis) in AXES.into_iter().enumerate() {
            push(&format!("liquid_momentum.{axis}"), "kg m/s", liquid.momentum[c]);
        }
        push("liquid_kinetic_energy", "J", liquid.kinetic);
        push("liquid_elastic_energy", "J", liquid.elastic);
        push("liquid_potential_energy", "J", liquid.potential);
    }
}

/// Columns of the measures of the case.
pub(crate) fn case_outputs(case: &Case, solver: &dyn Solver, snapshot: &Snapshot) -> Vec<ScalarOutput> {
    measure::read_snapshot(case, solver, snapshot)
}

/// Names of the numbers at the end of a run: columns of its measures, and factors of safety.
pub fn column_names(case: &Case, solver: &dyn Solver) -> Vec<String> {
    let readings =
        run_outputs(solver, None).into_iter().chain(case_outputs(case, solver, &solver.snapshot()));
    let found = case.factors_of_safety().map(|(name, _)| name.to_owned());
    readings.map(|(name, ..)| name).chain(found).collect()
}

/// Reports an error for measures at positions, where the frames of the solver are empty.
fn check_without_places(case: &Case) -> Result<(), CaseErrors> {
    let of_places = case.measures.iter().filter(|(_, measure)| measure.needs_points());
    let error = |(name, _): (&String, &Measure)| {
        let problem = "needs points, nodes or cells, but the frames of the method have none";
        CaseError::new(format!("measures.{name}"), CaseErrorKind::coded("needs-other-key", problem))
    };
    let errors: Vec<CaseError> = of_places.map(error).collect();
    if errors.is_empty() { Ok(()) } else { Err(CaseErrors(errors)) }
}

/// Checks the names in a case that depend on the solver: fields of its points, and measures with the name of a column that every run has.
///
/// # Errors
/// Every wrong name, with its JSON path.
pub fn check_names(case: &Case, solver: &dyn Solver) -> Result<(), CaseErrors> {
    if case.output.fields.is_none() && case.measures.is_empty() {
        return Ok(());
    }
    let mut now = solver.frame(FrameRequest::Measured);
    let measured = now.take_points().or_else(|| now.first_as_points());
    if measured.is_none() {
        check_without_places(case)?;
    }
    let snapshot = measured.unwrap_or_default();
    let mut errors = Vec::new();
    let fields: Vec<&str> = snapshot.fields.iter().map(|field| field.name.as_str()).collect();
    let mut check = |path: String, name: &str, known: &[&str]| {
        if !known.contains(&name) {
            let kind = match closest(name, known) {
                Some(_) => CaseErrorKind::unknown_name(name, known, "a field"),
                None => CaseErrorKind::other_name(name, format!("a field; there are {}", known.join(", "))),
            };
            errors.push(CaseError::new(path, kind));
        }
    };
    let beside = now.datasets.iter().flat_map(|dataset| &dataset.fields).map(|field| field.name.as_str());
    let in_frames: Vec<&str> = fields.iter().copied().chain(beside).chain(ALWAYS_IN_FRAMES).collect();
    for (number, name) in case.output.fields.iter().flatten().enumerate() {
        check(format!("output.fields[{number}]"), name, &in_frames);
    }
    for (measure, description) in &case.measures {
        for FieldUse { key, name, is_scalar } in description.fields() {
            let known: Vec<&str> = fields
                .iter()
                .copied()
                .filter(|name| !is_scalar || snapshot.scalars(name).is_some())
                .collect();
            check(format!("measures.{measure}.{key}"), &name, &known);
        }
    }
    let taken = run_outputs(solver, None);
    let mut last = None;
    for (column, ..) in case_outputs(case, solver, &snapshot) {
        let measure = column.split('.').next().unwrap_or_default().to_owned();
        if taken.iter().any(|(name, ..)| *name == column) && last.as_ref() != Some(&measure) {
            let problem = format!("the column {column:?} exists in every run: choose another name");
            errors.push(CaseError::new(format!("measures.{measure}"), problem));
            last = Some(measure);
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(CaseErrors(errors)) }
}
