//! `colluvium check`.

use std::path::PathBuf;
use std::time::Duration;

use crate::case::run::{RunTiming, SearchCost, check_names};
use crate::case::{BodyDensities, Case, Plan, Space, TimeScales, Warning, printable};
use crate::machine::{available_threads, free_memory, peak_memory};
use crate::select_method;
use clap::Args;

use super::{CommandError, LibraryArguments, duration_text, print_note, print_warning};
use crate::cli::file_kind;
use crate::cli::file_kind::FileKind;

/// Time for which steps are measured.
const MEASURING_TIME: Duration = Duration::from_millis(700);

#[derive(Args)]
#[command(after_help = "Usual call:\n  colluvium check slope.json")]
pub struct CheckArguments {
    /// The case file.
    case: PathBuf,
    /// Name of the method; needed when the case has options for several.
    #[arg(long)]
    method: Option<String>,
    #[command(flatten)]
    pub library: LibraryArguments,
}

/// Checks a case, and prints its size, time step, estimated duration and warnings.
pub fn run(arguments: &CheckArguments) -> Result<(), CommandError> {
    file_kind::require_kind(&arguments.case, FileKind::Case)?;
    let case = Case::from_file(&arguments.case)?;
    let method = select_method(&case, arguments.method.as_deref())?;
    let size = method.problem_size(&case)?;
    size.check_memory(free_memory())?;
    if let Some(ahead) = size.size_notice() {
        print_note(&ahead);
    }
    let (mut plan, mut solver) = method.plan_and_build(&case)?;
    check_names(&case, &*solver)?;
    let threads = available_threads();
    let pace = RunTiming::measure(&case, &plan, &mut *solver, MEASURING_TIME);
    let seconds = match &pace {
        Some(pace) => {
            plan.steps = pace.steps.ceil() as u64;
            plan.updates_per_second = plan.points as f64 / pace.step / threads as f64;
            pace.run_time(&case)
        }
        None => plan.seconds() / threads as f64,
    };
    drop(solver);
    plan.memory =
        plan.memory.max(peak_memory().unwrap_or(0)) + pace.map_or(0, |pace| pace.frame_memory as u64);
    let step = &plan.time_step;
    print_line!("{}", printable(&case.title));
    print_line!("method         {}: {}", method.name(), method.summary());
    print_line!("points         {}", plan.points);
    print_body_masses(&case, &plan)?;
    print_line!("gravity        {}", gravity_text(&case.gravity));
    if plan.nodes > 0 {
        print_line!("grid nodes     {}", plan.nodes);
    }
    print_line!("time step      {:.4e} s at the start, limited by: {}", step.dt, step.limit);
    if let Some(point) = step.point {
        let on_map = step.position.iter().zip(case.origin()).map(|(x, origin)| x + origin);
        let place: Vec<String> =
            on_map.take(case.dimension()).map(|coordinate| format!("{coordinate:.4}")).collect();
        print_line!("               at point {point} ({}) m", place.join(", "));
    }
    print_line!("steps          about {}", plan.steps);
    print_line!("memory         about {:.1} MB", plan.memory as f64 / 1e6);
    print_line!("duration       about {} on {threads} threads", duration_text(seconds));
    for (name, search) in case.factors_of_safety() {
        print_search(name, &SearchCost::of_case(&case, &plan, search), threads)?;
    }
    for stage in &case.stages {
        let until = if stage.equilibrium.is_some() { ", or until at rest" } else { "" };
        print_line!("stage          {}: {} s{until}", stage.name, stage.duration);
    }
    let has_laws = method.has_elasticity() && method.capabilities(&case)?.has_materials();
    print_line!("time scales    {}", time_scales(&case, has_laws));
    plan.all_warnings(&case).iter().for_each(print_warning);
    Ok(())
}

/// Size of gravity (m/s²), and its angle with the last axis, against which it usually acts.
fn gravity_text(gravity: &[f64]) -> String {
    let size = gravity.iter().map(|component| component * component).sum::<f64>().sqrt();
    let axis = ["x", "y", "z"][gravity.len().clamp(1, 3) - 1];
    let last = gravity.last().copied().unwrap_or(0.0);
    // Three-dimensional cases may have their vertical axis along y.
    let (axis, along) = match gravity {
        [_, y, z] if y.abs() > z.abs() => ("y", *y),
        _ => (axis, last),
    };
    if size == 0.0 {
        return "none".to_owned();
    }
    let sign = if along > 0.0 { "+" } else { "-" };
    let angle = (along.abs() / size).min(1.0).acos().to_degrees();
    if angle < 1e-6 {
        format!("{size:.4} m/s² along {sign}{axis}")
    } else {
        format!("{size:.4} m/s², {angle:.2}° from {sign}{axis}")
    }
}

/// Prints the masses and volumes of the bodies, and the densities of bodies with pore fluid.
fn print_body_masses(case: &Case, plan: &Plan) -> Result<(), CommandError> {
    let volume_unit = match case.space {
        Space::PlaneStrain => "m³ per metre",
        Space::Axisymmetric => "m³ per radian",
        Space::OneD | Space::ThreeD => "m³",
    };
    for ((body, mass), volume) in case.bodies.iter().zip(plan.masses(case)).zip(&plan.volumes) {
        let (name, material) = (printable(&body.name), printable(&body.material));
        // Grains have the mass of their bodies without voids.
        let volume = match plan.grains {
            None => format!(", {volume:.4e} {volume_unit}"),
            Some(_) => String::new(),
        };
        print_line!("mass           {name}: {mass:.4e} kg of {material}{volume}");
    }
    for body in &case.bodies {
        if let Some(BodyDensities { dry, saturated, grains }) = case.densities(body) {
            print_line!(
                "densities      {}: dry {dry:.0}, saturated {saturated:.0}, grains {grains:.0} kg/m³",
                printable(&body.name)
            );
        }
    }
    Ok(())
}

/// Text with the characteristic times of a case and its duration (s). Times that depend on a stiffness are left out where the method has no
/// material laws.
fn time_scales(case: &Case, has_laws: bool) -> String {
    let TimeScales { height, consolidation, wave_time, fall_time: fall } = case.time_scales();
    let of_law = |time: Option<f64>| time.filter(|_| has_laws);
    let named = [
        ("consolidation h²/c_v", of_law(consolidation)),
        ("wave h/c", of_law(wave_time)),
        ("fall √(h/g)", fall),
    ];
    let known = named.into_iter().filter_map(|(name, time)| Some(format!("{name} {:.3e} s, ", time?)));
    let known: String = known.collect();
    format!("{known}run {:.4} s; h = {height:.4} m", case.end_time())
}

/// Prints the cost of the search `name`, with a note where it is unknown.
fn print_search(name: &str, cost: &SearchCost, threads: usize) -> Result<(), CommandError> {
    print_line!("{}", search_cost_text(name, cost, threads));
    if cost.window.is_nan() {
        let text = format!(
            "measures.{name}: the duration of a window is unknown until the bodies are at rest without \
             yielding. To set it, give `duration`"
        );
        print_note(&Warning::new("search-cost-unknown", text));
    }
    Ok(())
}

/// Text with the cost of the search `name` for a factor of safety, without the duration of the stages.
fn search_cost_text(name: &str, cost: &SearchCost, threads: usize) -> String {
    let SearchCost { trials: [likely, largest], windows, window, seconds } = cost;
    let trials = format!(
        "search         {name}: {likely} trials, {largest} at most, of {windows} time windows at most"
    );
    if window.is_nan() {
        return trials;
    }
    let [usual, longest] = seconds.map(|seconds| duration_text(seconds / threads as f64));
    format!(
        "{trials}, about {window:.3} s each: about {usual}, {longest} at most, in addition to the duration of the stages"
    )
}

#[cfg(test)]
mod tests {
    use super::gravity_text;

    #[test]
    fn gravity_is_described_by_its_size_and_direction() {
        let tilted = [9.81 * 35f64.to_radians().sin(), -9.81 * 35f64.to_radians().cos()];
        assert_eq!(gravity_text(&tilted), "9.8100 m/s², 35.00° from -y");
        assert_eq!(gravity_text(&[0.0, 9.81]), "9.8100 m/s² along +y");
        assert_eq!(gravity_text(&[0.0, -9.81, 0.0]), "9.8100 m/s² along -y");
        assert_eq!(gravity_text(&[0.0, 0.0, -9.81]), "9.8100 m/s² along -z");
        assert_eq!(gravity_text(&[0.0]), "none");
    }
}
