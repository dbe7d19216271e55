//! Curved free edges on fitted rows and on a lattice: a thick ring (Lamé), a plate with a hole (Kirsch).

use colluvium::case::Snapshot;
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use colluvium::points::Sampling;

use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_in_memory, stresses};

/// Benchmark of rows of particles fitted to round edges: a thick ring under pressure, and a plate with a hole.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/ring",
    title: "Rows fitted to round edges: thick ring under pressure, plate with a hole, total-Lagrangian SPH",
    source: "Lamé 1852; Kirsch 1898; finite width after Heywood 1952",
    short_seconds: Some(10),
    full_seconds: 300,
    run,
};

/// Pressure inside the ring (Pa).
const PRESSURE: f64 = 1e4;
/// Spacing of the particles (m).
const SPACING: f64 = 0.1;
/// Arrangements of the particles that are compared.
const SAMPLINGS: [(&str, Sampling); 2] = [("fitted rows", Sampling::Fitted), ("lattice", Sampling::Lattice)];

/// Position of a particle (m), its distance from the centre (m), and its hoop stress (Pa).
type HoopStressPoint = ([f64; 2], f64, f64);

/// Checks stresses at the curved edges of a ring and of a plate with a hole.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    ring(&mut outcome)?;
    if !quick {
        plate(&mut outcome)?;
    }
    Ok(outcome)
}

/// Hoop stress of the ring after Lamé (Pa).
fn lame(r: f64) -> f64 {
    PRESSURE / 3.0 * (1.0 + 4.0 / (r * r))
}

/// Stress along the tension beside a hole of radius one in an infinite plate, over the remote stress, after Kirsch.
fn kirsch(r: f64) -> f64 {
    0.5 * (2.0 + r.powi(-2) + 3.0 * r.powi(-4))
}

/// Position, radius (m) and hoop stress (Pa) of the particles.
fn hoop_stresses(snapshot: &Snapshot) -> Vec<HoopStressPoint> {
    let hoop = |(x, s): (&[f64; 3], &colluvium::constitutive::SymTensor)| {
        let r = x[0].hypot(x[1]);
        let (c, n) = (x[0] / r, x[1] / r);
        (
            [x[0], x[1]],
            r,
            s.component(0, 0) * n * n + s.component(1, 1) * c * c - 2.0 * s.component(0, 1) * c * n,
        )
    };
    snapshot.positions.iter().zip(&stresses(snapshot)).map(hoop).collect()
}

/// Least, mean and largest value.
fn min_mean_max(values: &[f64]) -> [f64; 3] {
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    [smallest, values.iter().sum::<f64>() / values.len() as f64, largest]
}

/// Checks hoop stresses of a thick ring against those of Lamé.
fn ring(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new(
        "Thick ring under a pressure within",
        "distance from the centre (m)",
        "hoop stress (kPa)",
    );
    for (name, sampling) in SAMPLINGS {
        let mut case = load_case("sph/ring")?;
        case.bodies[0].sampling = sampling;
        let all = hoop_stresses(&run_in_memory("sph", &case)?.snapshot);
        let first: Vec<f64> =
            all.iter().filter(|(_, r, _)| *r < 1.0 + SPACING).map(|(_, r, s)| s / lame(*r)).collect();
        let [smallest, mean, maximum] = min_mean_max(&first);
        let label = |what: &str| format!("ring, {name}: hoop stress of the first row over Lamé, {what}");
        if sampling == Sampling::Fitted {
            let reason = "issue: 5 % at ten particles to the inner radius; the load acts half a spacing within the edge, which \
                          makes it 5 % larger";
            for (what, found) in [("least", smallest), ("mean", mean), ("largest", maximum)] {
                outcome.assert_close(label(what), 1.0, 0.05, found, reason);
            }
            let off = all.iter().map(|(_, r, s)| (s / lame(*r) - 1.0).abs()).fold(0.0, f64::max);
            let name = "ring, fitted rows: largest error of the hoop stress anywhere";
            outcome.assert_below(name, "0", off, 0.05, "as in the first row");
        } else {
            let reason = "not judged: round edges are stepped on a lattice; for comparison";
            for (what, found) in [("least", smallest), ("mean", mean), ("largest", maximum)] {
                outcome.info(label(what), "1", found, reason);
            }
        }
        let points = all.iter().map(|(_, r, s)| (*r, s / 1e3)).collect();
        chart.series.push(Series::new(name, points, Style::Markers));
        let cloud = PointCloud {
            title: format!("Hoop stress, {name}"),
            points: all.iter().map(|(x, _, s)| (*x, [SPACING; 2], s / 1e3)).collect(),
            label: "hoop stress (kPa)".into(),
            axes: ["x (m)".into(), "y (m)".into()],
            ..PointCloud::default()
        };
        outcome.png(&format!("Hoop stress of the ring, {name}; Lamé has 6.7 to 16.7 kPa."), &cloud)?;
    }
    let exact = (0..=50).map(|k| 1.0 + 0.02 * f64::from(k)).map(|r| (r, lame(r) / 1e3)).collect();
    chart.series.push(Series::new("Lamé", exact, Style::Dashed));
    outcome.svg("Hoop stress of all particles against the closed form.", &chart)
}

/// Checks stresses of a plate with a hole against those of Kirsch.
fn plate(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new(
        "Plate with a hole",
        "distance from the centre of the hole (m)",
        "stress over that far away",
    );
    for (name, sampling) in SAMPLINGS {
        let mut case = load_case("sph/plate-with-hole")?;
        case.bodies[0].sampling = sampling;
        let snapshot = run_in_memory("sph", &case)?.snapshot;
        let all: Vec<([f64; 2], f64)> = (snapshot.positions.iter().zip(&stresses(&snapshot)))
            .map(|(x, s)| ([x[0], x[1]], s.component(0, 0)))
            .collect();
        let far: Vec<f64> = (all.iter())
            .filter(|([x, y], _)| (4.5..6.5).contains(&x.abs()) && y.abs() < 4.5)
            .map(|(_, s)| *s)
            .collect();
        let [_, far, _] = min_mean_max(&far);
        // Within six degrees of the line across the tension.
        let beside: Vec<(f64, f64)> = (all.iter())
            .filter(|([x, y], _)| x.abs() < 0.105 * y.abs() && x.hypot(*y) < 3.0)
            .map(|([x, y], s)| (x.hypot(*y), s / far))
            .collect();
        for row in 0..2 {
            let from = 1.0 + SPACING * f64::from(row);
            let of_row: Vec<f64> = (beside.iter())
                .filter(|(r, _)| (from..from + SPACING).contains(r))
                .map(|(r, s)| s / kirsch(*r))
                .collect();
            let [_, mean, _] = min_mean_max(&of_row);
            let label = format!("plate, {name}: stress of row {} beside the hole over Kirsch", row + 1);
            if sampling == Sampling::Fitted && row == 1 {
                outcome.assert_close(
                    label,
                    1.0,
                    0.05,
                    mean,
                    "issue: 5 % at ten particles to the radius, as for the ring",
                );
            } else if sampling == Sampling::Fitted {
                let reason = "not judged: the first row has neighbours on one side only and stress there falls by a tenth over half a spacing; \
                              3.10 at the edge itself with the width of the plate";
                outcome.info(label, "1", mean, reason);
            } else {
                outcome.info(label, "1", mean, "not judged: stepped edges; for comparison");
            }
        }
        chart.series.push(Series::new(name, beside, Style::Markers));
    }
    let exact = (0..=100).map(|k| 1.0 + 0.02 * f64::from(k)).map(|r| (r, kirsch(r))).collect();
    chart.series.push(Series::new("Kirsch, no end", exact, Style::Dashed));
    outcome.svg("Stress along the pull beside the hole, over that far away.", &chart)
}
