//! `colluvium check`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use colluvium::case::run::{Pace, SearchCost, check_names};
use colluvium::case::{Case, Densities, Plan, TimeScales, printable};

use super::{
    Failure, choose, duration, free_memory,
    kind::{self, Kind},
    largest_memory, threads,
};

/// Time for which steps are measured.
const MEASURED: Duration = Duration::from_millis(700);

#[derive(Args)]
pub struct Arguments {
    /// The case file.
    case: PathBuf,
    /// The method; needed when the case has options for several.
    #[arg(long)]
    method: Option<String>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    kind::expect(&arguments.case, Kind::Case)?;
    let case = Case::load(&arguments.case)?;
    let method = choose(&case, arguments.method.as_deref())?;
    let size = method.size(&case)?;
    size.fit(free_memory())?;
    if let Some(ahead) = size.beforehand() {
        complain!("note: {ahead}");
    }
    let (mut plan, mut solver) = method.made(&case)?;
    check_names(&case, &*solver)?;
    let threads = threads();
    let pace = Pace::of(&case, &plan, &mut *solver, MEASURED);
    let seconds = match &pace {
        Some(pace) => {
            plan.steps = pace.steps.ceil() as u64;
            plan.updates_per_second = plan.points as f64 / pace.step / threads as f64;
            pace.whole(&case)
        }
        None => plan.seconds() / threads as f64,
    };
    drop(solver);
    plan.memory =
        plan.memory.max(largest_memory().unwrap_or(0)) + pace.map_or(0, |pace| pace.frame_memory as u64);
    let step = &plan.time_step;
    say!("{}", printable(&case.title));
    say!("method         {}: {}", method.name(), method.summary());
    say!("points         {}", plan.points);
    tell_bodies(&case, &plan)?;
    if plan.nodes > 0 {
        say!("grid nodes     {}", plan.nodes);
    }
    say!("time step      {:.4e} s at the start, limited by: {}", step.dt, step.limit);
    if let Some(point) = step.point {
        let on_map = step.position.iter().zip(case.origin()).map(|(x, origin)| x + origin);
        let place: Vec<String> =
            on_map.take(case.dimension()).map(|coordinate| format!("{coordinate:.4}")).collect();
        say!("               at point {point} ({}) m", place.join(", "));
    }
    say!("steps          about {}", plan.steps);
    say!("memory         about {:.1} MB", plan.memory as f64 / 1e6);
    say!("duration       about {} on {threads} threads", duration(seconds));
    for (name, search) in case.factors_of_safety() {
        say!("{}", searching(name, &SearchCost::of(&case, &plan, search), threads));
    }
    for stage in &case.stages {
        let until = if stage.equilibrium.is_some() { ", or until at rest" } else { "" };
        say!("stage          {}: {} s{until}", stage.name, stage.duration);
    }
    let has_laws = method.has_elasticity() && method.honours(&case)?.has_materials();
    say!("time scales    {}", scales(&case, has_laws));
    for warning in plan.all_warnings(&case) {
        complain!("warning: {warning}");
    }
    Ok(())
}

/// Prints the masses of the bodies, and the densities of those with pore fluid.
fn tell_bodies(case: &Case, plan: &Plan) -> Result<(), Failure> {
    for (body, mass) in case.bodies.iter().zip(plan.masses(case)) {
        let (name, material) = (printable(&body.name), printable(&body.material));
        say!("mass           {name}: {mass:.4e} kg of {material}");
    }
    for body in &case.bodies {
        if let Some(Densities { dry, saturated, grains }) = case.densities(body) {
            say!(
                "densities      {}: dry {dry:.0}, saturated {saturated:.0}, grains {grains:.0} kg/m³",
                printable(&body.name)
            );
        }
    }
    Ok(())
}

/// Times that decide what a case shows, beside that of its run; those of stiffness where the method `has_laws`.
fn scales(case: &Case, has_laws: bool) -> String {
    let TimeScales { height, consolidation, wave, fall } = case.time_scales();
    let of_law = |time: Option<f64>| time.filter(|_| has_laws);
    let named =
        [("consolidation h²/c_v", of_law(consolidation)), ("wave h/c", of_law(wave)), ("fall √(h/g)", fall)];
    let known = named.into_iter().filter_map(|(name, time)| Some(format!("{name} {:.3e} s, ", time?)));
    let known: String = known.collect();
    format!("{known}run {:.4} s; h = {height:.4} m", case.end_time())
}

/// What the search `name` for a factor of safety takes beside the stages.
fn searching(name: &str, cost: &SearchCost, threads: usize) -> String {
    let SearchCost { trials: [likely, most], blocks, block, seconds } = cost;
    let trials =
        format!("search         {name}: {likely} trials, {most} at most, of {blocks} blocks at most");
    if block.is_nan() {
        return format!(
            "{trials}; how long a block is shows when bodies that do not yield have come to rest"
        );
    }
    let [usual, longest] = seconds.map(|seconds| duration(seconds / threads as f64));
    format!(
        "{trials}, about {block:.3} s each: about {usual}, {longest} at most, beside the duration of the stages"
    )
}
