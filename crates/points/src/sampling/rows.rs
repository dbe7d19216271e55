//! Points in rows that follow the terrain.

use super::{Cells, Sample, SamplingError};
use crate::Layer;

/// Thickness over a spacing below which a layer has no points.
const THINNEST: f64 = 0.25;

/// Points of a layer over the places in plan of a lattice, the first at half a `spacing` (m) from `origin`; `cells` are those of the lattice
/// around it.
pub(super) fn along_terrain<const D: usize>(
    cells: &Cells<D>,
    layer: &Layer,
    origin: [f64; D],
    spacing: f64,
) -> Result<Vec<Sample<D>>, SamplingError> {
    let mut samples = Vec::new();
    let count = std::array::from_fn(|axis| if axis < 2 { cells.count[axis] } else { 1 });
    let columns = Cells { first: cells.first, count, total: count.iter().product() };
    for cell in columns.indices() {
        let place = |axis: usize| origin[axis] + (cell[axis] as f64 + 0.5) * spacing;
        let (x, y) = (place(0), place(1));
        let Some([low, high]) = layer.stretch(x, y) else { continue };
        let thickness = high - low;
        if thickness < THINNEST * spacing {
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

#[cfg(test)]
mod tests {
    use super::super::lattice;
    use super::*;
    use crate::{Depths, LayerRows, Measured, Outline, Raster, Shape, Thickness};

    /// A layer of 0.5 m on ground that falls by 3 m over 4 m, sampled 0.2 m apart.
    fn sampled(rows: LayerRows) -> Vec<Sample<3>> {
        let ground = Raster::from_function([41, 31], [0.0; 2], [1.0; 2], |x, _| 30.0 - 0.75 * x);
        let outline = Outline::new(vec![vec![[5.0, 5.0], [15.0, 5.0], [15.0, 11.0], [5.0, 11.0]]]).unwrap();
        let layer = Layer::new(ground, outline, Depths::Uniform(0.5), Measured::Vertical, [0.0; 2]).unwrap();
        let shape = Shape::Layer {
            on: "slope".into(),
            outline: "outline.geojson".into(),
            thickness: Thickness::Uniform(0.5),
            measured: Measured::Vertical,
            rows,
            laid: layer.into(),
        };
        lattice(&shape, [0.0; 3], 0.2).unwrap()
    }

    #[test]
    fn rows_along_the_terrain_leave_no_ragged_base_and_hold_the_whole_volume() {
        let height = |sample: &Sample<3>| {
            let [x, _, z] = sample.position;
            z - (30.0 - 0.75 * x)
        };
        let along = sampled(LayerRows::Terrain);
        // Two rows and a half are three, of 0.5/3 m each.
        assert_eq!(along.len(), 50 * 30 * 3);
        for sample in &along {
            let row = height(sample) / (0.5 / 3.0) - 0.5;
            assert!((row - row.round()).abs() < 1e-9 && (-0.1..2.1).contains(&row), "{sample:?}");
        }
        let volume: f64 = along.iter().map(|sample| sample.volume).sum();
        assert!((volume - 10.0 * 6.0 * 0.5).abs() < 1e-9, "{volume}");
        // On the lattice the lowest points lie anywhere.
        let level = sampled(LayerRows::Level);
        let lowest = |low: f64, high: f64| level.iter().any(|sample| (low..high).contains(&height(sample)));
        assert!(lowest(0.0, 0.03) && lowest(0.47, 0.5));
    }
}
