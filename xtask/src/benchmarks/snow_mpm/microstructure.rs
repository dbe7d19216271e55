//! Confined compression of a structure of sintered grains (sheet: snow-mpm A4).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use colluvium::points::Shape;
use serde_json::json;

use super::{case_with_options, run_snow_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, scalars};

/// Benchmark of the confined compression of a microstructure of snow.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/microstructure",
    title: "Confined compression of a microstructure of snow",
    source: "Gaume et al. 2020, section 5.1 and Fig. 7; sheet: snow-mpm A4",
    short_seconds: Some(45),
    full_seconds: 400,
    run: benchmark,
};

/// Box of snow, and the plate that compresses it. At the largest speed of the sheet, half a per cent of the wave speed of ice (6 m/s), the
/// plate hits the ice with 6.7 MPa and crushes it at once.
struct CompressionBox {
    /// Width and height of the box (m).
    size: f64,
    /// Speed of the plate (m/s).
    speed: f64,
    /// Compression at the end.
    end: f64,
}

/// Box of the short form, half as wide as that of the full form.
const SHORT_BOX: CompressionBox = CompressionBox { size: 1.5e-3, speed: 0.6, end: 0.32 };
/// Box of the sheet, on cells of 0.05 mm in place of 0.03 mm.
const FULL_BOX: CompressionBox = CompressionBox { size: 3e-3, speed: 0.3, end: 0.2 };

/// Compression of the box between two rows of measures.
const ROW: f64 = 4e-4;

impl CompressionBox {
    /// Compression of the box and mean stress at the plate (Pa), from the work of the plate between two rows.
    fn path(&self, report: &RunReport) -> Vec<(f64, f64)> {
        let work = measure_series(report, "work_of_walls");
        let stress = |pair: &[(f64, f64)]| {
            (pair[1].1 - pair[0].1) / (self.speed * (pair[1].0 - pair[0].0) * self.size)
        };
        work.windows(2).map(|pair| (self.speed * pair[1].0 / self.size, stress(pair))).collect()
    }
}

/// Checks the stages of compression of a microstructure, and draws stress and structure.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let press = if quick { SHORT_BOX } else { FULL_BOX };
    let CompressionBox { size, speed, end } = press;
    let mut case = case_with_options("microstructure", &json!({}))?;
    case.domain.max = vec![size, 1.2 * size];
    if let Shape::Microstructure { max, .. } = &mut case.bodies[0].shape {
        *max = vec![size, size];
    }
    let plate = &mut case.boundaries[3];
    plate.position = Some(size);
    plate.velocity = Some(vec![0.0, -speed]);
    case.stages[0].duration = end * size / speed;
    case.output.frames = Some(0.02 * size / speed);
    case.output.measures = Some(ROW * size / speed);
    let report = run_snow_case(&case)?;
    let path = press.path(&report);
    check_loading_stages(&mut outcome, &report, &path, quick);
    let chart = LineChart {
        series: vec![Series::new("snow-mpm", path, Style::Line)],
        ..LineChart::new("Confined compression", "compression of the box", "mean axial stress (Pa)")
    };
    outcome.svg("A4: stress over compression.", &chart)?;
    for share in [0.02, 0.1, 0.2] {
        let frame = report.frames.iter().find(|frame| speed * frame.time / size >= share - 1e-9);
        if let Some(mut cloud) =
            frame.and_then(|frame| PointCloud::from_snapshot(frame, "plastic_strain", [0, 1]))
        {
            cloud.title = format!("compressed by {:.0} %", 100.0 * share);
            outcome.png("A4: plastic strain of the ice.", &cloud)?;
        }
    }
    Ok(outcome)
}

/// Checks the stages of confined compression: the linear rise of the stress, its drop after the first peak, the plateau, and the final rise
/// when the grains jam.
fn check_loading_stages(
    outcome: &mut BenchmarkOutcome,
    report: &RunReport,
    path: &[(f64, f64)],
    quick: bool,
) {
    let peak = first_peak(path);
    let (at, largest) = path[peak];
    let rise: Vec<(f64, f64)> =
        path[..=peak].iter().copied().take_while(|(_, stress)| *stress <= 0.7 * largest).collect();
    outcome.assert_within(
        "A4 rise: square of the correlation up to 70 % of the first peak",
        "above 0.99",
        correlation(&rise).powi(2),
        (0.99, 1.0),
        "the sheet's criterion",
    );
    let smallest = path[peak..].iter().map(|(_, stress)| *stress).fold(f64::INFINITY, f64::min);
    outcome.assert_below(
        "A4 drop: least stress after the peak over it",
        "0.8",
        smallest / largest,
        0.8,
        "the sheet's criterion",
    );
    let beyond: Vec<f64> =
        path[peak..].iter().filter(|(strain, _)| *strain <= at + 0.1).map(|(_, stress)| *stress).collect();
    let name = "A4 plateau: mean stress over a compression of 0.1 from the peak, over the peak";
    let mean = beyond.iter().sum::<f64>() / beyond.len() as f64 / largest;
    if quick {
        outcome.info(name, "below 1", mean, "the sheet judges a box of ten grains across; this has five");
    } else {
        outcome.assert_below(name, "below 1", mean, 1.0, "the sheet's criterion");
    }
    let again = path.iter().skip(peak + 1).find(|(_, stress)| *stress > largest);
    let length = again.map_or(f64::NAN, |(strain, _)| strain - at);
    let reason = "grains that meet anew carry for a while";
    outcome.info("A4: compression from the peak until it is passed again", "not given", length, reason);
    let last = path.last().map_or(f64::NAN, |(_, stress)| *stress);
    outcome.assert_within(
        "A4 jamming: stress at the end over the first peak",
        "above 1",
        last / largest,
        (1.0, f64::INFINITY),
        "the sheet's criterion",
    );
    outcome.info("A4: first peak (Pa)", "not given", largest, "the source prints no number");
    outcome.info("A4: compression at the first peak", "not given", at, "the source prints no number");
    let masses: Vec<f64> = [report.frames.first(), report.frames.last()]
        .into_iter()
        .map(|frame| frame.map_or(f64::NAN, |frame| scalars(frame, "mass").iter().sum()))
        .collect();
    outcome.assert_close(
        "A4: mass at the end over that at the start",
        1.0,
        1e-14,
        masses[1] / masses[0],
        "no point is lost",
    );
}

/// Index of the first peak of the stress, after which the stress falls by a fifth before it exceeds the peak again.
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

/// Correlation of pairs of numbers.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let count = pairs.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>() / count;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |value: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(value).sum::<f64>();
    let across = sum(&|p| (p.0 - x) * (p.1 - y));
    across / (sum(&|p| (p.0 - x).powi(2)) * sum(&|p| (p.1 - y).powi(2))).sqrt()
}
