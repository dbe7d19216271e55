//! Points in rows that follow the terrain.

use crate::TerrainLayer;
use crate::plan::polygon::signed_area;
use crate::sampling::{CandidateCells, Sample, SamplingError};

/// Least thickness of a layer with points, in spacings.
const MIN_THICKNESS: f64 = 0.25;

/// Samples a layer by columns of points over a lattice in plan. The lattice begins half a `spacing` (m) from `origin`; `cells` are its
/// cells around the layer.
pub(super) fn sample_along_terrain<const D: usize>(
    cells: &CandidateCells<D>,
    layer: &TerrainLayer,
    origin: [f64; D],
    spacing: f64,
) -> Result<Vec<Sample<D>>, SamplingError> {
    let mut samples = Vec::new();
    let count = std::array::from_fn(|axis| if axis < 2 { cells.count[axis] } else { 1 });
    let columns = CandidateCells { first: cells.first, count, total: count.iter().product() };
    for cell in columns.indices() {
        let place = |axis: usize| origin[axis] + (cell[axis] as f64 + 0.5) * spacing;
        let (x, y) = (place(0), place(1));
        let Some([low, high]) = layer.vertical_range(x, y) else { continue };
        let thickness = high - low;
        if thickness < MIN_THICKNESS * spacing {
            continue;
        }
        let count = (thickness / spacing).round().max(1.0);
        let height = thickness / count;
        samples.extend((0..count as usize).map(|row| {
            let z = low + height * (row as f64 + 0.5);
            Sample {
                position: std::array::from_fn(|axis| [x, y, z][axis]),
                volume: spacing * spacing * height,
            }
        }));
    }
    Ok(samples)
}

/// Samples a layer along a line. `outline` has the corners of its lower side, and then those of its upper side in reverse order. Each point
/// is the centroid of a part of a row, about a `spacing` (m) high and as long along the middle of the layer.
pub(super) fn sample_along_line<const D: usize>(outline: &[[f64; 2]], spacing: f64) -> Vec<Sample<D>> {
    let half = outline.len() / 2;
    if half < 2 {
        return Vec::new();
    }
    let stations: Vec<[[f64; 2]; 2]> = (0..half).map(|k| [outline[k], outline[2 * half - 1 - k]]).collect();
    let middle = |[low, high]: [[f64; 2]; 2]| [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
    let mut lengths = vec![0.0];
    for pair in stations.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + distance(middle(pair[0]), middle(pair[1])));
    }
    let fitting = |length: f64| (length / spacing).round().max(1.0);
    let rows = fitting(distance(stations[0][0], stations[0][1]));
    let whole = lengths[half - 1];
    let columns = fitting(whole);
    let mut samples = Vec::with_capacity((rows * columns) as usize);
    // Start of a column: the stations around it, and its two ends.
    let (mut next, mut begin) = (1, stations[0]);
    for column in 1..=columns as usize {
        let until = whole * column as f64 / columns;
        let mut ends = vec![begin];
        while next < half - 1 && lengths[next] < until {
            ends.push(stations[next]);
            next += 1;
        }
        let share = ((until - lengths[next - 1]) / (lengths[next] - lengths[next - 1])).clamp(0.0, 1.0);
        begin =
            std::array::from_fn(|side| interpolate(stations[next - 1][side], stations[next][side], share));
        ends.push(begin);
        samples.extend((0..rows as usize).map(|row| {
            let side =
                |share: f64| ends.iter().map(move |[low, high]| interpolate(*low, *high, share / rows));
            let ring: Vec<[f64; 2]> = side(row as f64).chain(side(row as f64 + 1.0).rev()).collect();
            let (volume, centre) = centroid(&ring);
            Sample { position: std::array::from_fn(|axis| if axis < 2 { centre[axis] } else { 0.0 }), volume }
        }));
    }
    samples
}

/// Position between two others, at a share of their distance.
fn interpolate(a: [f64; 2], b: [f64; 2], share: f64) -> [f64; 2] {
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

/// Distance of two positions (m).
fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Area (m²) and centroid of a ring, relative to its first corner so that no digits are lost far from the origin.
fn centroid(ring: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let from = ring[0];
    let ring: Vec<[f64; 2]> = ring.iter().map(|x| [x[0] - from[0], x[1] - from[1]]).collect();
    let area = signed_area(&ring);
    let mut moment = [0.0; 2];
    for (a, b) in ring.iter().zip(ring[1..].iter().chain(&ring[..1])) {
        let part = a[0] * b[1] - b[0] * a[1];
        moment = std::array::from_fn(|c| moment[c] + part * (a[c] + b[c]));
    }
    (area.abs(), std::array::from_fn(|c| from[c] + moment[c] / (6.0 * area)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::lattice;
    use crate::{LayerRows, LayerThickness, Outline, Raster, Shape, ThicknessData, ThicknessDirection};

    /// Layer of 0.5 m on ground that falls by 3 m over 4 m, sampled 0.2 m apart.
    fn sampled_layer(rows: LayerRows) -> Vec<Sample<3>> {
        let ground = Raster::from_function([41, 31], [0.0; 2], [1.0; 2], |x, _| 30.0 - 0.75 * x);
        let outline =
            Outline::new(vec![vec![vec![[5.0, 5.0], [15.0, 5.0], [15.0, 11.0], [5.0, 11.0]]]]).unwrap();
        let layer = TerrainLayer::new(
            ground,
            outline,
            ThicknessData::Uniform(0.5),
            ThicknessDirection::Vertical,
            [0.0; 2],
        )
        .unwrap();
        let shape = Shape::Layer {
            on: "slope".into(),
            outline: Some("outline.geojson".into()),
            thickness: LayerThickness::Uniform(0.5),
            measured: ThicknessDirection::Vertical,
            rows,
            laid: layer.into(),
        };
        lattice(&shape, [0.0; 3], 0.2).unwrap()
    }

    #[test]
    fn rows_parallel_to_the_terrain_have_an_even_base_and_the_whole_volume() {
        let height = |sample: &Sample<3>| {
            let [x, _, z] = sample.position;
            z - (30.0 - 0.75 * x)
        };
        let along = sampled_layer(LayerRows::Terrain);
        // Two rows and a half are rounded to three, of 0.5/3 m each.
        assert_eq!(along.len(), 50 * 30 * 3);
        for sample in &along {
            let row = height(sample) / (0.5 / 3.0) - 0.5;
            assert!((row - row.round()).abs() < 1e-9 && (-0.1..2.1).contains(&row), "{sample:?}");
        }
        let volume: f64 = along.iter().map(|sample| sample.volume).sum();
        assert!((volume - 10.0 * 6.0 * 0.5).abs() < 1e-9, "{volume}");
        // On the lattice the lowest points lie at any height within a spacing.
        let level = sampled_layer(LayerRows::Level);
        let lowest = |low: f64, high: f64| level.iter().any(|sample| (low..high).contains(&height(sample)));
        assert!(lowest(0.0, 0.03) && lowest(0.47, 0.5));
    }

    #[test]
    fn rows_along_a_line_keep_their_distance_from_it_and_hold_the_whole_area() {
        // A quarter of a ring of radii 3 and 3.5 m.
        let side = |radius: f64| {
            (0..=400).map(move |k| {
                let (sine, cosine) = (f64::from(k) / 400.0 * std::f64::consts::FRAC_PI_2).sin_cos();
                [1e5 + radius * cosine, radius * sine]
            })
        };
        let outline: Vec<[f64; 2]> = side(3.0).chain(side(3.5).rev()).collect();
        let samples: Vec<Sample<2>> = sample_along_line(&outline, 0.1);
        assert_eq!(samples.len(), 51 * 5);
        let area: f64 = samples.iter().map(|sample| sample.volume).sum();
        let right = std::f64::consts::FRAC_PI_4 * (3.5 * 3.5 - 9.0);
        assert!((area / right - 1.0).abs() < 1e-5, "{area} for {right}");
        for sample in &samples {
            let radius = (sample.position[0] - 1e5).hypot(sample.position[1]);
            let row = (radius - 3.05) / 0.1;
            assert!((row - row.round()).abs() < 2e-3 && (-0.1..4.1).contains(&row), "{sample:?}");
            assert!((sample.volume / (0.01 * radius / 3.25) - 1.0).abs() < 0.01);
        }
    }
}
