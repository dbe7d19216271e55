//! `colluvium check`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::run::{SearchCost, check_names};
use colluvium::case::{Case, printable};

use super::{
    Failure, choose, duration, free_memory,
    kind::{self, Kind},
    threads,
};

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
    let (plan, solver) = method.made(&case)?;
    check_names(&case, &*solver)?;
    let step = &plan.time_step;
    let threads = threads();
    say!("{}", printable(&case.title));
    say!("method         {}: {}", method.name(), method.summary());
    say!("points         {}", plan.points);
    for (body, mass) in case.bodies.iter().zip(plan.masses(&case)) {
        say!("mass           {}: {mass:.4e} kg of {}", body.name, body.material);
    }
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
    say!("duration       about {} on {threads} threads", duration(plan.seconds() / threads as f64));
    for (name, search) in case.factors_of_safety() {
        say!("{}", searching(name, &SearchCost::of(&case, &plan, search), threads));
    }
    for stage in &case.stages {
        let until = if stage.equilibrium.is_some() { ", or until at rest" } else { "" };
        say!("stage          {}: {} s{until}", stage.name, stage.duration);
    }
    for warning in plan.all_warnings(&case) {
        complain!("warning: {warning}");
    }
    Ok(())
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
