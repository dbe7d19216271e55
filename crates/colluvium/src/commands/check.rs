//! `colluvium check`.

use std::path::PathBuf;

use clap::Args;
use colluvium::case::Case;
use colluvium::case::run::check_names;

use super::{Failure, choose, duration, free_memory, threads};

#[derive(Args)]
pub struct Arguments {
    /// The case file.
    case: PathBuf,
    /// The method; needed when the case has options for several.
    #[arg(long)]
    method: Option<String>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
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
    say!("{}", case.title);
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
        let place: Vec<String> =
            step.position[..case.dimension()].iter().map(|coordinate| format!("{coordinate:.4}")).collect();
        say!("               at point {point} ({}) m", place.join(", "));
    }
    say!("steps          about {}", plan.steps);
    say!("memory         about {:.1} MB", plan.memory as f64 / 1e6);
    say!("duration       about {} on {threads} threads", duration(plan.seconds() / threads as f64));
    for stage in &case.stages {
        let until = if stage.equilibrium.is_some() { ", or until at rest" } else { "" };
        say!("stage          {}: {} s{until}", stage.name, stage.duration);
    }
    for warning in plan.all_warnings(&case) {
        complain!("warning: {warning}");
    }
    Ok(())
}
