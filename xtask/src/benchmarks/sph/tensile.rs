//! Tensile instability of a cohesive block and its cures (sheet: sph V-36; B-04).

use colluvium::case::Snapshot;
use colluvium::plots::PointCloud;
use serde_json::json;

use crate::analysis::{MaxOrNan, connected_front};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory, set_method_option};

/// Benchmark of the tensile instability, and of artificial stress and pressure against it.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/tensile",
    title: "Tensile instability: artificial stress and pressure, SPH",
    source: "Bui & Nguyen 2021, Fig. 17; sheet: sph V-36 with its reference run",
    short_seconds: Some(10),
    full_seconds: 10,
    run,
};

/// Spacing of the particles (m).
const SPACING: f64 = 0.1;

/// Share of the particles whose nearest neighbour is closer than `limit` (m), and the least distance (m).
fn clumped_share(snapshot: &Snapshot, limit: f64) -> (f64, f64) {
    let x = &snapshot.positions;
    let nearest = |i: usize| {
        let others = x.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, b)| (x[i][0] - b[0]).hypot(x[i][1] - b[1])).fold(f64::INFINITY, f64::min)
    };
    let all: Vec<f64> = (0..x.len()).map(nearest).collect();
    let close = all.iter().filter(|r| **r < limit).count();
    (close as f64 / all.len() as f64, all.into_iter().fold(f64::INFINITY, f64::min))
}

/// Cure of the tensile instability, with the share of clumped particles and the front (m) of the sheet's reference run.
struct TensileCure {
    name: &'static str,
    /// Kind of the option `tensile`, and its strength.
    option: Option<(&'static str, f64)>,
    clumped_share: f64,
    front: f64,
}

/// Cures of the tensile instability, with the results of the sheet.
const TENSILE_CURES: [TensileCure; 4] = [
    TensileCure { name: "none", option: None, clumped_share: 0.123, front: 4.96 },
    TensileCure {
        name: "stress 0.5",
        option: Some(("artificial-stress", 0.5)),
        clumped_share: 0.0025,
        front: 4.85,
    },
    TensileCure {
        name: "pressure 0.5",
        option: Some(("artificial-pressure", 0.5)),
        clumped_share: 0.029,
        front: 4.75,
    },
    TensileCure {
        name: "pressure 0.9",
        option: Some(("artificial-pressure", 0.9)),
        clumped_share: 0.020,
        front: 4.87,
    },
];

impl TensileCure {
    /// Runs the case with the cure, and returns the share of particles closer than 0.7 spacings and the front (m).
    fn run(&self, outcome: &mut BenchmarkOutcome) -> Result<(f64, f64), String> {
        let name = self.name;
        let mut case = load_case("sph/tensile")?;
        let option = self.option.map_or_else(
            || json!({ "kind": "none" }),
            |(kind, strength)| json!({ "kind": kind, "strength": strength, "exponent": 2.55 }),
        );
        set_method_option(&mut case, "sph", "tensile", option);
        let snapshot = run_in_memory("sph", &case)?.snapshot;
        let (share, smallest) = clumped_share(&snapshot, 0.7 * SPACING);
        let front = connected_front(&snapshot, SPACING);
        let reason = "the sheet's reference run; judged below";
        let claim = self.clumped_share.to_string();
        outcome.info(format!("{name}: share closer than 0.7 spacings"), &claim, share, reason);
        outcome.info(format!("{name}: least distance over spacing"), "", smallest / SPACING, reason);
        outcome.info(format!("{name}: front (m)"), &self.front.to_string(), front, reason);
        if let (true, Some(cloud)) = (
            name == "none" || name == "stress 0.5",
            PointCloud::from_snapshot(&snapshot, "displacement", [0, 1]),
        ) {
            outcome.png(&format!("The block after 2 s, artificial {name}: displacement."), &cloud)?;
        }
        Ok((share, front))
    }
}

/// Checks the clumping of particles without a cure and with three.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let (mut shares, mut fronts) = (Vec::new(), Vec::new());
    for cure in &TENSILE_CURES {
        let (share, front) = cure.run(&mut outcome)?;
        shares.push(share);
        fronts.push(front);
    }
    let [none, stress, half, strong] = shares[..] else { return Err("four runs".to_owned()) };
    let reason = "V-36: without a cure more than 8 %";
    outcome.assert_within("none: share closer than 0.7 spacings", "> 0.08", none, (0.08, 1.0), reason);
    let name = "stress 0.5: share closer than 0.7 spacings";
    outcome.assert_below(name, "< 0.01", stress, 0.01, "V-36: less than 1 %");
    let ordered = f64::from(u8::from(none > half && half > strong && strong > stress));
    let name = "the shares are ranked as the source's (1 is yes)";
    let reason = "V-36: none > pressure 0.5 > pressure 0.9 > stress 0.5, the source's ranking";
    outcome.assert_within(name, "yes", ordered, (1.0, 1.0), reason);
    let low = fronts.iter().copied().fold(f64::INFINITY, f64::min);
    let high = fronts.iter().copied().max_or_nan();
    let name = "largest front over least - 1";
    outcome.assert_below(name, "< 0.05", high / low - 1.0, 0.05, "V-36: within 5 % of each other");
    Ok(outcome)
}
