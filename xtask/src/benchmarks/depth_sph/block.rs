//! Single blocks and endless layers: forces on a column without neighbours (sheet: depth-sph §5.4, V21; §5.5, V24–V26, V32).

use colluvium::case::PlanRegion;
use colluvium::depth_sph::bed::{Bed, BedPoint, paraboloid};
use colluvium::depth_sph::config::choices::{DepthFrame, TimeScheme};
use colluvium::depth_sph::config::settings::{BedZone, Consolidation, FlowSettings, PoreColumn};
use colluvium::depth_sph::flow::Flow;
use colluvium::depth_sph::laws::erosion::Erosion;
use colluvium::depth_sph::laws::pore_pressure_column::{Drainage, LowerBound, PressureProfile};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::benchmarks::depth_sph::common_cases::{
    basal_law, block, endless_layer, grains_in_water, step_with_limit,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of single sliding columns: consolidation, racks, erosion, curvature and travel angle.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/block",
    title: "Sliding blocks: consolidation, racks, erosion, curvature, travel angle",
    source: "Hutchinson 1986; sheet: depth-sph §5.4, V21; §5.5, V24, V25, V25b, V26, V32",
    short_seconds: Some(3),
    full_seconds: 3,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;

/// Checks single columns: consolidation, racks, erosion, curvature of the bed, energy and travel angle.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    consolidation(&mut outcome)?;
    check_drained_rack(&mut outcome)?;
    erosion(&mut outcome)?;
    arc(&mut outcome)?;
    energy(&mut outcome)?;
    travel_angle(&mut outcome)?;
    Ok(outcome)
}

/// Settings of grains in water on a tilted bed with a friction angle of 35 degrees, with a pore-pressure column.
fn saturated_block(slope: f64, excess: f64, consolidation: f64) -> Result<FlowSettings<1>, String> {
    let mut settings = FlowSettings::single_phase(2050.0);
    settings.material = grains_in_water(0.3);
    settings.frame = DepthFrame::BedFitted;
    settings.gravity = GRAVITY * slope.to_radians().cos();
    settings.plan_gravity = [GRAVITY * slope.to_radians().sin()];
    settings.zones =
        vec![BedZone::unbounded(basal_law(json!({ "model": "coulomb", "friction_angle": 35 }))?)];
    settings.column = Some(PoreColumn {
        cells: 40,
        weight: 0.5,
        profile: PressureProfile::FiniteDifference,
        consolidation: Consolidation::Coefficient(consolidation),
        lower_bound: LowerBound::default(),
        excess_ratio: excess,
        stiffness: 1e8,
        dilatancy: None,
    });
    Ok(settings)
}

/// Mean speed along x (m/s) and path (m) of the first node.
fn state(flow: &Flow<1>) -> (f64, f64) {
    let nodes = &flow.nodes.sets[0].nodes;
    (nodes.velocity[0][0], nodes.position[0][0] - nodes.origin[0][0])
}

/// Checks a liquefied block whose base drains by a single exponential (V21).
fn consolidation(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new("Block on consolidating ground", "time (s)", "velocity (m/s)");
    // A quarter of a cosine with the whole weight at the base is more than liquefied above it. Finite differences limit such a column at
    // its bound, so that they start with 0.6 of it.
    let rows = [
        (20.0f64, 1.0, PressureProfile::ShapeFunction, &[1.0, 2.0, 5.0, 10.0][..]),
        (12.0, 1.0, PressureProfile::ShapeFunction, &[1.0, 2.0][..]),
        (20.0, 0.6, PressureProfile::FiniteDifference, &[1.0, 2.0, 5.0, 10.0][..]),
    ];
    for (slope, share, profile, times) in rows {
        let sliding = SlidingBlock::new(slope, share);
        let mut flow = sliding.flow(profile)?;
        let name = |what: &str| format!("V21, {slope}°, ratio {share}: {what}");
        let mut found = Vec::new();
        for t in times {
            while flow.clock.time < t * (1.0 - 1e-9) {
                let end = (flow.clock.time + 0.1).min(*t);
                step_with_limit(&mut flow, 2e-3, end)?;
                found.push((flow.clock.time, state(&flow).0));
            }
            let ((v, s), reason) = (state(&flow), "V21: 0.5 %");
            outcome.assert_close(
                name(&format!("velocity after {t} s (m/s)")),
                sliding.speed(*t),
                0.005,
                v,
                reason,
            );
            outcome.assert_close(name(&format!("path after {t} s (m)")), sliding.path(*t), 0.005, s, reason);
        }
        let stops = slope < 15.0;
        while stops && state(&flow).0 > 0.0 && flow.clock.time < 9.0 {
            let end = flow.clock.time + 2e-3;
            step_with_limit(&mut flow, 2e-3, end)?;
            found.push((flow.clock.time, state(&flow).0));
        }
        if stops {
            outcome.assert_close(
                name("time at which it stops (s)"),
                7.056_889,
                0.005,
                flow.clock.time,
                "V21: 0.5 %",
            );
            outcome.assert_close(name("where it stops (m)"), 11.762_818, 0.005, state(&flow).1, "V21: 0.5 %");
        }
        let last = if stops { 7.06 } else { 10.0 };
        let exact = (0..=100).map(|k| f64::from(k) / 100.0 * last).map(|t| (t, sliding.speed(t))).collect();
        chart.series.push(Series::new(format!("closed form, {slope}°, ratio {share}"), exact, Style::Dashed));
        chart.series.push(Series::new(format!("{slope}°, ratio {share}"), found, Style::Line));
    }
    outcome.svg("V21: a liquefied block regains its friction while its base drains.", &chart)
}

/// Block 2 m high whose basal pore pressure decays exponentially: `dv/dt = gain + loss exp(-t/fade)`.
struct SlidingBlock {
    slope: f64,
    share: f64,
    gain: f64,
    loss: f64,
    decay_time: f64,
}

impl SlidingBlock {
    /// Depth of the block (m).
    const DEPTH: f64 = 2.0;
    /// Coefficient of consolidation (m²/s).
    const CONSOLIDATION: f64 = 0.5;

    /// Block on a slope (degrees) with a liquefaction ratio at the start.
    fn new(slope: f64, share: f64) -> Self {
        let (sin, cos) = slope.to_radians().sin_cos();
        let held = 1050.0 / 2050.0 * cos * 35f64.to_radians().tan();
        let decay_time = 4.0 * Self::DEPTH.powi(2) / (std::f64::consts::PI.powi(2) * Self::CONSOLIDATION);
        Self { slope, share, gain: GRAVITY * (sin - held), loss: share * GRAVITY * held, decay_time }
    }

    /// Velocity at a time, in closed form (m/s).
    fn speed(&self, t: f64) -> f64 {
        self.gain * t + self.loss * self.decay_time * (1.0 - (-t / self.decay_time).exp())
    }

    /// Travelled distance at a time, in closed form (m).
    fn path(&self, t: f64) -> f64 {
        0.5 * self.gain * t * t
            + self.loss * self.decay_time * (t - self.decay_time * (1.0 - (-t / self.decay_time).exp()))
    }

    /// Layer without end, with the excess pore pressure of the first mode of consolidation.
    fn flow(&self, profile: PressureProfile) -> Result<Flow<1>, String> {
        let mut settings = saturated_block(self.slope, 1.0, Self::CONSOLIDATION)?;
        settings.column.iter_mut().for_each(|column| column.profile = profile);
        let mut flow = endless_layer(settings, Self::DEPTH, &[1.0])?;
        let width = flow.nodes.pore_columns.width;
        for (k, value) in flow.nodes.pore_columns.heads.iter_mut().enumerate() {
            let zeta = (k % width) as f64 / (width - 1) as f64;
            *value = self.share * Self::DEPTH * (std::f64::consts::FRAC_PI_2 * zeta).cos();
        }
        Ok(flow)
    }
}

/// Checks a liquefied block that slides onto a drained part of the bed (V32).
fn check_drained_rack(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let rows = [
        ("base to the air", Drainage::Atmospheric, 4.148_111, 6.838_6),
        ("hydrostatic base", Drainage::Hydrostatic, 7.069_802, 22.828),
    ];
    for (name, drainage, after, stop) in rows {
        for length in [5.0, 100.0] {
            let mut settings = saturated_block(12.0, 1.0, 0.5)?;
            let shape = json!({ "kind": "box", "min": [0], "max": [length] });
            let region = serde_json::from_value(shape).map_err(|error| error.to_string())?;
            let zone =
                BedZone { regions: vec![PlanRegion::Shape(region)], drainage, ..settings.zones[0].clone() };
            settings.zones.insert(0, zone);
            let mut flow = block(settings, Bed::Flat(0.0), 2.0, 1e-9, 8.0)?;
            let mut before = state(&flow);
            while before.1 < 5.0 || length > 5.0 {
                let end = flow.clock.time + 5e-4;
                step_with_limit(&mut flow, 5e-4, end)?;
                let now = state(&flow);
                if now.0 == 0.0 || (length < 6.0 && now.1 >= 5.0) {
                    break;
                }
                before = now;
                if flow.clock.time > 60.0 {
                    return Err(format!("V32, {name}: the block still moves after a minute"));
                }
            }
            let reason = "V32: 0.5 %";
            if length < 6.0 {
                outcome.assert_close(
                    format!("V32, {name}: speed behind 5 m (m/s)"),
                    after,
                    0.005,
                    before.0,
                    reason,
                );
            } else {
                outcome.assert_close(
                    format!("V32, {name}: where it stops (m)"),
                    stop,
                    0.005,
                    state(&flow).1,
                    reason,
                );
            }
        }
    }
    Ok(())
}

/// Checks a block that is decelerated only by the material that it erodes (V24).
fn erosion(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut settings = FlowSettings::single_phase(2000.0);
    settings.zones[0].erosion = Some(Erosion::Hungr { rate: 0.0011, plan_speed: false });
    let mut flow = block(settings, Bed::Flat(0.0), 1.0, 0.0, 10.0)?;
    let first = flow.nodes.sets[0].nodes.volume[0];
    for (time, path, growth, speed) in
        [(10.0, 94.872_741, 1.11, 9.009_009), (50.0, 398.413_574, 1.55, 6.451_613)]
    {
        step_with_limit(&mut flow, 0.01, time)?;
        let nodes = &flow.nodes.sets[0].nodes;
        let name = |what: &str| format!("V24, {time} s: {what}");
        outcome.assert_close(name("path (m)"), path, 1e-6, nodes.path[0], "V24: 1e-6");
        outcome.assert_close(name("growth of the mass"), growth, 1e-6, nodes.volume[0] / first, "V24: 1e-6");
        outcome.assert_close(name("speed (m/s)"), speed, 1e-6, nodes.velocity[0][0], "V24: 1e-6");
        let taken = (nodes.volume[0] - first - flow.records.eroded_volume[0]).abs() / first;
        outcome.assert_below(name("growth that the bed has not given"), "0", taken, 1e-12, "mass is exact");
    }
    Ok(())
}

/// Speed along the bed at the positions `places` (m), by linear interpolation between steps.
fn speeds_at(flow: &mut Flow<1>, longest: f64, places: &[f64]) -> Result<Vec<f64>, String> {
    let look = |flow: &Flow<1>| {
        let nodes = &flow.nodes.sets[0].nodes;
        let bed = flow.bed_below(&nodes.position[0]);
        (nodes.position[0][0], bed.speed(&nodes.velocity[0]))
    };
    let (mut before, mut found) = (look(flow), Vec::new());
    while found.len() < places.len() {
        let end = flow.clock.time + longest;
        step_with_limit(flow, longest, end)?;
        let now = look(flow);
        if now.0 >= places[found.len()] {
            let share = (places[found.len()] - before.0) / (now.0 - before.0);
            found.push(before.1 + share * (now.1 - before.1));
        }
        if flow.clock.time > 60.0 {
            return Err(format!("the block has not come to {} m within a minute", places[found.len()]));
        }
        before = now;
    }
    Ok(found)
}

/// Checks the speed of a block on a circular arc with friction (V25).
fn arc(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let radius = 50.0;
    let friction = 0.3f64.atan().to_degrees();
    let rows = [
        (true, "", [9.331_271, 9.928_668, 6.622_346]),
        (false, ", curvature off in friction", [9.744_108, 11.044_021, 8.900_939]),
    ];
    for (curvature, name, exact) in rows {
        let mut settings = FlowSettings::single_phase(2000.0);
        settings.zones =
            vec![BedZone::unbounded(basal_law(json!({ "model": "coulomb", "friction_angle": friction }))?)];
        settings.curvature_in_friction = curvature;
        let bed = Bed::formula(move |x: &[f64; 1]| {
            let up = (radius * radius - x[0] * x[0]).sqrt();
            BedPoint { level: radius - up, slope: [x[0] / up], curvature: [[radius * radius / up.powi(3)]] }
        });
        let place = |degrees: f64| -radius * degrees.to_radians().sin();
        let mut flow = block(settings, bed, 0.1, place(45.0), 0.0)?;
        let found = speeds_at(&mut flow, 1e-3, &[30.0, 15.0, 0.0].map(place))?;
        for ((angle, exact), found) in [30, 15, 0].into_iter().zip(exact).zip(found) {
            let name = format!("V25{name}: speed at {angle}° (m/s)");
            outcome.assert_close(name, exact, 0.002, found, "V25: 0.2 %");
        }
    }
    Ok(())
}

/// Checks the energy of a block on a parabola without friction (V25b).
fn energy(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let half = (2.0 * GRAVITY * 1200.0 / 60.0f64).sqrt();
    for (name, integration, step) in
        [("leapfrog", TimeScheme::Leapfrog, 2e-4), ("fourth order", TimeScheme::RungeKutta4, 1e-2)]
    {
        let mut settings = FlowSettings::single_phase(1000.0);
        settings.numerics.integration = integration;
        let mut flow = block(settings, paraboloid(1.0 / 60.0, [0.0]), 0.1, -40.0, 0.0)?;
        let found = speeds_at(&mut flow, step, &[-20.0, 0.0])?;
        let label = |what: &str| format!("V25b, {name}, steps of {} ms: {what}", 1e3 * step);
        outcome.assert_close(label("speed half way down (m/s)"), half, 1e-4, found[0], "V25b: 0.01 %");
        outcome.assert_close(label("speed at the bottom (m/s)"), 22.873_566, 1e-4, found[1], "V25b: 0.01 %");
    }
    Ok(())
}

/// Checks the travel angle of a block that slides down a slope and an arc, and out on the flat (V26).
fn travel_angle(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (radius, slope) = (25.0f64, 30f64.to_radians());
    // The arc ends at x = 0 on the flat and begins where it is as steep as the slope.
    let start = -radius * slope.sin();
    let height = radius * (1.0 - slope.cos());
    let bed = Bed::formula(move |x: &[f64; 1]| {
        if x[0] >= 0.0 {
            BedPoint::horizontal(0.0)
        } else if x[0] > start {
            let up = (radius * radius - x[0] * x[0]).sqrt();
            BedPoint { level: radius - up, slope: [x[0] / up], curvature: [[radius * radius / up.powi(3)]] }
        } else {
            BedPoint { slope: [-slope.tan()], ..BedPoint::horizontal(height - slope.tan() * (x[0] - start)) }
        }
    });
    let mut settings = FlowSettings::single_phase(2000.0);
    settings.zones =
        vec![BedZone::unbounded(basal_law(json!({ "model": "coulomb", "friction_angle": 15 }))?)];
    settings.curvature_in_friction = false;
    let drop = 20.0;
    let from = start - (drop - height) / slope.tan();
    let mut flow = block(settings, bed, 0.1, from, 0.0)?;
    while flow.clock.time < 1.0 || state(&flow).0 > 0.0 {
        let end = flow.clock.time + 1e-3;
        step_with_limit(&mut flow, 1e-3, end)?;
        if flow.clock.time > 100.0 {
            return Err("V26: the block still moves after 100 s".to_owned());
        }
    }
    let found = drop / state(&flow).1;
    outcome.assert_close("V26: drop over distance", 15f64.to_radians().tan(), 0.005, found, "V26: 0.5 %");
    Ok(())
}
