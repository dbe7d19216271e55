//! Debris flow of Yu Tung Road from its case file, against the figures of the source (sheet: depth-sph §5.2, B3).

use colluvium::case::{Case, PlanRaster, Snapshot, Solver};
use colluvium::plots::{LineChart, MapCells, Series, Style, TerrainMap};
use serde_json::{Value, json};

use super::terrain::channel_bed;
use crate::benchmarks::depth_sph::common_cases::{load, start, step_until};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars, set_method_option, vectors};

/// Benchmark of the debris flow of Yu Tung Road from its case file.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/yu-tung",
    title: "Debris flow after Yu Tung Road from a case file: speeds, reach, erosion and what they depend on",
    source: "Pastor and others 2020, §6.3; sheet: depth-sph §5.2, B3",
    short_seconds: Some(12),
    full_seconds: 120,
    run,
};

/// Spacing of the nodes in the short form and for comparisons between runs (m).
const COARSE: f64 = 1.6;

/// Position and speed of the front at a time.
#[derive(Clone, Copy)]
struct FrontPosition {
    time: f64,
    /// Position: 99 % quantile of the nodes of grains (m).
    position: f64,
    /// Mean speed in plan of the leading 5 % (m/s).
    speed: f64,
}

impl FrontPosition {
    /// Position and speed of the front of the grains: 99 % quantile along the channel, and mean of the leading 5 %.
    fn from_snapshot(snapshot: &Snapshot) -> Self {
        let (velocity, phase) = (vectors(snapshot, "velocity"), scalars(snapshot, "phase"));
        let grains = |i: &usize| phase.get(*i).is_none_or(|phase| *phase < 0.5);
        let mut order: Vec<usize> = (0..snapshot.positions.len()).filter(grains).collect();
        order.sort_by(|a, b| snapshot.positions[*a][0].total_cmp(&snapshot.positions[*b][0]));
        let count = order.len();
        let last = order[(0.99 * (count - 1) as f64).round() as usize];
        let leading = &order[count - count / 20..];
        let speed = leading.iter().map(|i| velocity[*i][0].hypot(velocity[*i][1])).sum::<f64>();
        Self {
            time: snapshot.time,
            position: snapshot.positions[last][0],
            speed: speed / leading.len() as f64,
        }
    }
}

/// Results of a run: fronts every half second, rasters after 40 s and at the end, and volumes.
struct YuTungRun {
    fronts: Vec<FrontPosition>,
    eroded: Vec<PlanRaster>,
    rasters: Vec<PlanRaster>,
    /// Volume at the start and at the end (m³).
    volumes: [f64; 2],
}

impl YuTungRun {
    /// Runs the case, with the position of the front every half second.
    fn from_case(case: &Case) -> Result<Self, String> {
        let mut solver = start(case)?;
        let volume = |solver: &dyn Solver| scalars(&solver.snapshot(), "volume").iter().sum::<f64>();
        let before = volume(&*solver);
        let mut run = Self {
            fronts: vec![FrontPosition::from_snapshot(&solver.snapshot())],
            eroded: Vec::new(),
            rasters: Vec::new(),
            volumes: [before; 2],
        };
        for half in 1..=90 {
            step_until(&mut *solver, 0.5 * f64::from(half))?;
            run.fronts.push(FrontPosition::from_snapshot(&solver.snapshot()));
            if half == 80 {
                run.eroded = solver.rasters();
            }
        }
        run.rasters = solver.rasters();
        run.volumes[1] = volume(&*solver);
        Ok(run)
    }

    /// Front after a time (s).
    fn front_at(&self, time: f64) -> FrontPosition {
        self.fronts[(2.0 * time).round() as usize]
    }

    /// Raster of the run.
    fn raster(&self, name: &str) -> Result<&PlanRaster, String> {
        self.rasters.iter().find(|raster| raster.name == name).ok_or_else(|| format!("no raster {name}"))
    }
}

/// Case with a node spacing (m) and other options of the method.
fn case(spacing: f64, more: &[(&str, Value)]) -> Result<Case, String> {
    let mut case = load("debris-flow")?;
    set_method_option(&mut case, "depth-sph", "spacing", spacing);
    more.iter().for_each(|(key, value)| set_method_option(&mut case, "depth-sph", key, value.clone()));
    Ok(case)
}

/// Checks speeds, reach and erosion of the debris flow against the values of the source.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let fine = 120.0 / 106.0;
    let whole = YuTungRun::from_case(&case(if quick { COARSE } else { fine }, &[])?)?;
    check_source_values(&mut outcome, &whole);
    check_eroded_volume(&mut outcome, &whole)?;
    draw(&mut outcome, &whole)?;
    if !quick {
        check_sensitivity(&mut outcome, &whole)?;
    }
    Ok(outcome)
}

/// Checks front, speeds and volumes against the source.
fn check_source_values(outcome: &mut BenchmarkOutcome, run: &YuTungRun) {
    let at = run.fronts.iter().find(|front| front.position >= 100.0).map_or(f64::NAN, |front| front.speed);
    let name = |what: &str| format!("B3: {what}");
    let reason = "B3: 12 ± 3 m/s, of the source";
    outcome.assert_within(name("speed of the front at 100 m (m/s)"), "12", at, (9.0, 15.0), reason);
    let maximum = run.fronts.iter().map(|front| front.speed).fold(0.0, f64::max);
    let reason = "B3: 17 ± 2.5 m/s, of the source";
    outcome.assert_within(name("largest speed of the front (m/s)"), "17", maximum, (14.5, 19.5), reason);
    let reason = "B3: 11 ± 3 m/s, of the source";
    outcome.assert_within(
        name("speed of the front after 23 s (m/s)"),
        "11",
        run.front_at(23.0).speed,
        (8.0, 14.0),
        reason,
    );
    let reason = "B3: 510 ± 45 m, of the source";
    outcome.assert_within(
        name("front after 45 s (m)"),
        "510",
        run.front_at(45.0).position,
        (465.0, 555.0),
        reason,
    );
    let reason = "B3: 3400 ± 250 m³, of the source";
    outcome.assert_within(name("volume after 45 s (m³)"), "3400", run.volumes[1], (3150.0, 3650.0), reason);
    // The sheet's formula gives 2350 m³; its samples at 1 m, with the edge between nodes, 0.16 % more.
    let reason = "sum over the nodes of release.asc, whose rim is cut by the outline";
    outcome.assert_close(name("volume of the release (m³)"), 2353.737, 1e-4, run.volumes[0], reason);
}

/// Checks that the volume eroded by the flow equals the loss of the bed.
fn check_eroded_volume(outcome: &mut BenchmarkOutcome, run: &YuTungRun) -> Result<(), String> {
    let raster = &run.raster("bed_change")?.raster;
    let area = raster.spacing[0] * raster.spacing[1];
    let changed = || raster.values.iter().filter(|change| change.is_finite());
    let lost: f64 = changed().map(|change| -change * area).sum();
    let growth = run.volumes[1] - run.volumes[0];
    let reason = "B3: 1e-9; the raster's cells are those of the terrain";
    let error = (growth - lost).abs() / run.volumes[0];
    outcome.assert_below(
        "B3: growth less the volume of the bed's change, over the release",
        "0",
        error,
        1e-9,
        reason,
    );
    let passed = changed().filter(|change| **change < -1e-3).count() as f64 * area;
    let deepest = changed().fold(0.0, |deep: f64, change| deep.max(-change));
    let reason =
        "not judged: the source's map of erosion is not published; the sheet expects some decimetres";
    outcome.info("B3: mean depth of erosion where it is above 1 mm (m)", "0.1–1", lost / passed, reason);
    outcome.info("B3: largest depth of erosion (m)", "", deepest, reason);
    Ok(())
}

/// Checks the influence of discretisation and parameters on the reach.
fn check_sensitivity(outcome: &mut BenchmarkOutcome, fine: &YuTungRun) -> Result<(), String> {
    let base = YuTungRun::from_case(&case(COARSE, &[])?)?;
    let apart = (base.front_at(45.0).position - fine.front_at(45.0).position).abs();
    let reason =
        "the sheet's own computation differs by less than 1 m between 1472 and 2944 nodes; this halves them";
    outcome.assert_below("B3: reach on half as many nodes, difference (m)", "0", apart, 15.0, reason);
    let drag = json!({ "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 1e-3 } });
    let two = YuTungRun::from_case(&case(COARSE, &[("phases", json!("two")), ("mixture", drag)])?)?;
    let apart = (two.front_at(45.0).position - base.front_at(45.0).position).abs();
    let reason = "locked by their drag, the phases move as one; the sheet has 2 to 3 % between the two in B2";
    outcome.assert_below("B3: reach of two phases, difference from one (m)", "0", apart, 25.0, reason);
    let column = |consolidation: f64, ratio: f64| json!({ "cells": 10, "consolidation": consolidation, "excess_ratio": ratio, "lower_bound": { "kind": "no-suction" } });
    let voellmy = json!({ "model": "voellmy", "friction_angle": 40, "turbulence": 300 });
    let rack = json!([
        { "shape": { "kind": "box", "min": [400, -60], "max": [410, 60] }, "drainage": { "kind": "atmospheric" },
          "erosion": { "law": "hungr", "rate": 0.0011 } },
        { "shape": { "kind": "box", "min": [30, -60], "max": [700, 60] }, "erosion": { "law": "hungr", "rate": 0.0011 } }
    ]);
    let less: [(&str, Vec<(&str, Value)>); 6] = [
        ("without erosion", vec![("regions", json!([])), ("lower_bed", json!(false))]),
        ("turbulence of 300 m/s²", vec![("basal", voellmy)]),
        ("drained from the start", vec![("column", column(0.01, 0.0))]),
        ("consolidation of 0.03 m²/s", vec![("column", column(0.03, 1.0))]),
        ("consolidation of 0.1 m²/s", vec![("column", column(0.1, 1.0))]),
        ("a rack from 400 to 410 m", vec![("regions", rack)]),
    ];
    for (name, more) in less {
        let found = YuTungRun::from_case(&case(COARSE, &more)?)?.front_at(45.0).position
            / base.front_at(45.0).position;
        let name = format!("B3, {name}: reach over that of the flow");
        outcome.assert_below(name, "< 1", found, 1.0, "B3: signs of the sensitivities");
    }
    let found = YuTungRun::from_case(&case(COARSE, &[("metric", json!("normal"))])?)?.front_at(45.0).position
        / base.front_at(45.0).position;
    let name = "B3, pressure along the normal: reach over that of the flow";
    outcome.assert_within(name, "> 1", found, (1.0, f64::INFINITY), "B3: signs of the sensitivities");
    Ok(())
}

/// Map of a raster over the channel.
fn map(title: &str, label: &str, raster: &PlanRaster, sign: f64) -> TerrainMap {
    let of = &raster.raster;
    let counts = [of.columns, of.rows];
    let heights = (0..of.values.len()).map(|k| {
        let [x, y] = of.node_position(k % of.columns, k / of.columns);
        channel_bed(x, y)
    });
    let signed_change = |value: &f64| if value.abs() > 1e-3 { sign * value } else { f64::NAN };
    let ring = (0..=72).map(|k| std::f64::consts::TAU * f64::from(k) / 72.0);
    TerrainMap {
        title: title.to_owned(),
        label: label.to_owned(),
        heights: Some(MapCells { counts, origin: of.origin, spacing: of.spacing, values: heights.collect() }),
        cells: MapCells {
            counts,
            origin: of.origin,
            spacing: of.spacing,
            values: of.values.iter().map(signed_change).collect(),
        },
        outlines: vec![ring.map(|a| [35.0 + 35.0 * a.cos(), 17.0 * a.sin()]).collect()],
        ..TerrainMap::default()
    }
}

/// Draws the speed of the front, and the depths in plan.
fn draw(outcome: &mut BenchmarkOutcome, run: &YuTungRun) -> Result<(), String> {
    let speeds = LineChart {
        series: vec![
            Series::new(
                "leading 5 %",
                run.fronts.iter().map(|front| (front.position, front.speed)).collect(),
                Style::Line,
            ),
            Series::new("source, at its 100 and 350 m", vec![(100.0, 12.0), (350.0, 17.0)], Style::Markers),
            Series::new(
                "after 4, 13 and 23 s",
                [4.0, 13.0, 23.0].map(|t| (run.front_at(t).position, run.front_at(t).speed)).to_vec(),
                Style::Markers,
            ),
        ],
        ..LineChart::new("Speed of the front along the channel", "front (m)", "speed (m/s)")
    };
    outcome.svg(
        "B3: the source's places and times do not agree with one another; speeds are compared.",
        &speeds,
    )?;
    let arrival = run.fronts.iter().map(|front| (front.time, front.position)).collect();
    let places = LineChart {
        series: vec![Series::new("99 % of the nodes", arrival, Style::Line)],
        ..LineChart::new("Front over time", "time (s)", "front (m)")
    };
    outcome.svg("B3: the front; the road is at 510 m.", &places)?;
    let peak = run.raster("peak_thickness_vertical")?;
    outcome.png(
        "B3: largest depth; the release as a line.",
        &map("Debris flow: largest depth", "peak depth (m)", peak, 1.0),
    )?;
    let deposit = run.raster("final_thickness_vertical")?;
    outcome.png("B3: depth after 45 s.", &map("Debris flow: depth after 45 s", "depth (m)", deposit, 1.0))?;
    if let Some(eroded) = run.eroded.iter().find(|raster| raster.name == "bed_change") {
        let picture = map("Debris flow: erosion after 40 s", "depth of erosion (m)", eroded, -1.0);
        outcome.png("B3: what has been taken up from the bed after 40 s.", &picture)?;
    }
    Ok(())
}
