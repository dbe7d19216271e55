//! Confined compression of a structure of sintered grains (sheet: snow-mpm A4).

use colluvium::case::{RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use colluvium::points::Shape;
use serde_json::json;

use super::{changed, solved};
use crate::benchmarks::{Benchmark, Outcome, scalars, stresses};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/microstructure",
    title: "Confined compression of a microstructure of snow",
    source: "Gaume et al. 2020, section 5.1 and Fig. 7; sheet: snow-mpm A4",
    quick: Some(20),
    full: 900,
    run: benchmark,
};

/// Speed of the plate (m/s).
const SPEED: f64 = 6.0;

/// Compression of the box and mean axial stress in it (Pa), compression positive.
fn state(frame: &Snapshot, size: f64) -> (f64, f64) {
    let moved = SPEED * frame.time;
    let volumes = scalars(frame, "volume");
    let force: f64 = stresses(frame).iter().zip(&volumes).map(|(s, v)| -s[1] * v).sum();
    (moved / size, force / (size * (size - moved)))
}

fn benchmark(quick: bool) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    // The sheet's structure is 3 mm wide on cells of 0.03 mm.
    let (size, cell) = if quick { (1.5e-3, 5e-5) } else { (3e-3, 3e-5) };
    let mut case = changed("microstructure", &json!({ "cell_size": cell }))?;
    case.domain.max = vec![size, 1.2 * size];
    if let Shape::Microstructure { max, .. } = &mut case.bodies[0].shape {
        *max = vec![size, size];
    }
    case.boundaries[3].position = Some(size);
    let duration = if quick { 0.4 } else { 0.5 } * size / SPEED;
    case.stages[0].duration = duration;
    case.output.frames = Some(duration / if quick { 100.0 } else { 60.0 });
    let report = solved(&case)?;
    judge(&mut outcome, &report, size);
    let path: Vec<(f64, f64)> = report.frames.iter().map(|frame| state(frame, size)).collect();
    let chart = LineChart {
        title: "Confined compression".into(),
        x_label: "compression of the box".into(),
        y_label: "mean axial stress (Pa)".into(),
        series: vec![Series::new("snow-mpm", path, Style::Line)],
        ..LineChart::default()
    };
    outcome.svg("A4: stress over compression.", &chart)?;
    for share in [0.1, 0.35] {
        let frame = report.frames.iter().find(|frame| state(frame, size).0 >= share);
        if let Some(mut cloud) = frame.and_then(|frame| PointCloud::of(frame, "plastic_strain", [0, 1])) {
            cloud.title = format!("compressed by {:.0} %", 100.0 * share);
            outcome.png("A4: plastic strain of the ice.", &cloud)?;
        }
    }
    Ok(outcome)
}

/// The four phases in their order.
fn judge(outcome: &mut Outcome, report: &RunReport, size: f64) {
    let path: Vec<(f64, f64)> = report.frames.iter().map(|frame| state(frame, size)).collect();
    let peak = first_peak(&path);
    let (at, most) = path[peak];
    let rise: Vec<(f64, f64)> =
        path[..=peak].iter().copied().take_while(|(_, stress)| *stress <= 0.7 * most).collect();
    outcome.within(
        "A4 rise: square of the correlation up to 70 % of the first peak",
        "above 0.99",
        correlation(&rise).powi(2),
        (0.99, 1.0),
        "the sheet's criterion",
    );
    let least = path[peak..].iter().map(|(_, stress)| *stress).fold(f64::INFINITY, f64::min);
    outcome.below(
        "A4 drop: least stress after the peak over it",
        "0.8",
        least / most,
        0.8,
        "the sheet's criterion",
    );
    let again = path.iter().skip(peak + 1).position(|(_, stress)| *stress > most).map(|k| peak + 1 + k);
    let end = again.unwrap_or(path.len() - 1);
    let length = path[end].0 - at;
    outcome.within(
        "A4 plateau: compression from the peak until it is passed again",
        "0.1 or more",
        length,
        (0.1, f64::INFINITY),
        "the sheet's criterion: below the peak over 10 % or more",
    );
    let last = path.last().map_or(f64::NAN, |(_, stress)| *stress);
    outcome.within(
        "A4 jamming: stress at the end over the first peak",
        "above 1",
        last / most,
        (1.0, f64::INFINITY),
        "the sheet's criterion",
    );
    outcome.show("A4: first peak (Pa)", "not given", most, "the source prints no number");
    outcome.show("A4: compression at the first peak", "not given", at, "the source prints no number");
    let masses: Vec<f64> = [report.frames.first(), report.frames.last()]
        .into_iter()
        .map(|frame| frame.map_or(f64::NAN, |frame| scalars(frame, "mass").iter().sum()))
        .collect();
    outcome.near(
        "A4: mass at the end over that at the start",
        1.0,
        1e-14,
        masses[1] / masses[0],
        "no point is lost",
    );
}

/// The first peak: the stress then falls by a fifth before it is passed again.
fn first_peak(path: &[(f64, f64)]) -> usize {
    let mut peak = 0;
    for (number, (_, stress)) in path.iter().enumerate() {
        if *stress > path[peak].1 {
            peak = number;
        } else if *stress < 0.8 * path[peak].1 && path[peak].1 > 0.0 {
            break;
        }
    }
    peak
}

/// Of pairs of numbers.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let count = pairs.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |value: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>();
    let across = sum(&|p| (p.0 - x) * (p.1 - y));
    across / (sum(&|p| (p.0 - x).powi(2)) * sum(&|p| (p.1 - y).powi(2))).sqrt()
}
