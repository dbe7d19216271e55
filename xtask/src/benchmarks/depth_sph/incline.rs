//! Frictional dam break on an incline (sheet: depth-sph §5.3, V7).

use colluvium::case::Case;
use colluvium::depth_sph::analytical_solutions::frictional_dam_break;
use colluvium::plots::{Series, Style};
use serde_json::json;

use crate::benchmarks::depth_sph::common_cases::{
    NodeProfile, chart, closed_form_series, load, start, step_until,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, set_material, set_method_option};

/// Benchmark of a frictional dam break on an incline.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/incline",
    title: "Frictional dam break on an incline, depth-integrated",
    source: "Mangeney and others 2000; sheet: depth-sph §5.3, V7",
    short_seconds: Some(5),
    full_seconds: 20,
    run,
};

/// Time of the comparison with the closed form (s).
const TIME: f64 = 2.0;

/// Dam break on an incline: slope and friction angle (degrees), depth (m).
struct InclineFlow {
    slope: f64,
    friction: f64,
    depth: f64,
}

impl InclineFlow {
    /// Gravity normal to the bed, and net acceleration along the bed (m/s²). Friction acts on `share` of the weight.
    fn forces(&self, share: f64) -> (f64, f64) {
        let normal = 9.81 * self.slope.to_radians().cos();
        let net = self.slope.to_radians().tan() - share * self.friction.to_radians().tan();
        (normal, normal * net)
    }

    /// Case of the dam break on the incline.
    fn case(&self) -> Result<Case, String> {
        let mut case = load("incline")?;
        let (sin, cos) = self.slope.to_radians().sin_cos();
        case.gravity = vec![9.81 * sin, -9.81 * cos];
        case.domain.max[1] = 1.2 * self.depth;
        let shape = json!({ "kind": "box", "min": [-60, 0], "max": [0, self.depth] });
        case.bodies[0].shape = serde_json::from_value(shape).map_err(|error| error.to_string())?;
        let basal = json!({ "model": "coulomb", "friction_angle": self.friction });
        set_method_option(&mut case, "depth-sph", "basal", basal);
        Ok(case)
    }
}

/// Checks depth and velocity of frictional dam breaks on inclines against the closed form.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let slab = InclineFlow { slope: 22.0, friction: 12.0, depth: 10.0 };
    let table = [
        (-5.0, 6.640_84, 7.013_48),
        (0.0, 5.293_08, 8.680_14),
        (10.0, 3.055_66, 12.013_48),
        (20.0, 1.429_02, 15.346_81),
    ];
    judge(&mut outcome, "22° over 12°", &slab.case()?, slab.forces(1.0), slab.depth, &table)?;
    if quick {
        return Ok(outcome);
    }
    let steep = InclineFlow { slope: 30.0, friction: 25.0, depth: 20.0 };
    let table = [(0.0, 9.543_84, 9.947_92), (20.0, 3.785_74, 16.614_59)];
    judge(&mut outcome, "30° over 25°", &steep.case()?, steep.forces(1.0), steep.depth, &table)?;
    check_saturated(&mut outcome, &slab).map(|()| outcome)
}

/// Checks grains in water on the incline: with buoyancy and drainage, and liquefied without drainage.
fn check_saturated(outcome: &mut BenchmarkOutcome, slab: &InclineFlow) -> Result<(), String> {
    let mut case = slab.case()?;
    set_material(&mut case, "sand", &[("density", json!(2050.0))])?;
    let mixture = json!({ "grain_density": 2500, "fluid_density": 1000, "porosity": 0.3,
        "drag": { "law": "anderson", "settling_velocity": 1e-3 } });
    set_method_option(&mut case, "depth-sph", "mixture", mixture);
    judge(outcome, "saturated, drained", &case, slab.forces(1050.0 / 2050.0), slab.depth, &[])?;
    set_method_option(&mut case, "depth-sph", "column", json!({ "consolidation": 0, "excess_ratio": 1 }));
    judge(outcome, "saturated, liquefied", &case, slab.forces(0.0), slab.depth, &[])?;
    let mut solver = start(&case)?;
    step_until(&mut *solver, TIME)?;
    let ratios = crate::benchmarks::scalars(&solver.snapshot(), "liquefaction");
    let worst = ratios.iter().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max);
    let reason = "V7, V14: a liquefied column stays so under thinning, to 1e-10";
    outcome.assert_below(
        "V7, saturated, liquefied: change of the liquefaction ratio",
        "0",
        worst,
        1e-10,
        reason,
    );
    Ok(())
}

/// Checks depth and velocity of one dam break after two seconds.
fn judge(
    outcome: &mut BenchmarkOutcome,
    name: &str,
    case: &Case,
    (gravity, acceleration): (f64, f64),
    depth: f64,
    table: &[(f64, f64, f64)],
) -> Result<(), String> {
    let mut solver = start(case)?;
    step_until(&mut *solver, TIME)?;
    let profile = NodeProfile::from_snapshot(&solver.snapshot(), 0, &[]);
    let celerity = (gravity * depth).sqrt();
    let fall = 0.5 * acceleration * TIME * TIME;
    let exact = |x: f64| frictional_dam_break(gravity, depth, acceleration, x, TIME);
    // From the slab that the wave has not reached to the front; velocities up to half of the distance, as in V5.
    let (rear, front) = (fall - celerity * TIME, fall + 2.0 * celerity * TIME);
    let label = |what: &str| format!("V7, {name}: {what}");
    let (height, _) = profile.errors(rear - 10.0, front, exact);
    let reason = "V7: as V5, below 0.6 %";
    outcome.assert_below(label("mean error of depth over the first one"), "0", height / depth, 0.006, reason);
    let (_, velocity) = profile.errors(rear - 10.0, fall + celerity * TIME, exact);
    let reason = "V7: as V5, below 0.7 %; up to half of the way to the front";
    outcome.assert_below(
        label("mean error of velocity over celerity"),
        "0",
        velocity / celerity,
        0.007,
        reason,
    );
    for (x, h, u) in table {
        let found = profile.height_and_velocity_at(*x);
        let reason = "not judged: a point of the curve above";
        outcome.info(label(&format!("depth at {x} m (m)")), &format!("{h}"), found.0, reason);
        outcome.info(label(&format!("velocity at {x} m (m/s)")), &format!("{u}"), found.1, reason);
    }
    let mut chart = chart(&format!("Slab on an incline after 2 s, {name}"), "depth (m)");
    chart.series.push(closed_form_series("closed form", rear - 10.0, front, |x| exact(x).0));
    chart.series.push(Series::new("nodes", profile.heights(rear - 10.0, front), Style::Line));
    outcome.svg("V7: depth normal to the bed along it.", &chart)
}
