//! Erodible bed: terrain that is lowered by erosion, down to the erodible depth (sheet: depth-sph §2.8, §3.4 step 8).

use crate::bed::terrain_bed::TerrainBed;
use crate::bed::{BedPoint, BedSurface};
use crate::points::phase_nodes::PlanVector;

/// Number of steps between two updates of the bed surface, in which erosion is some millimetres.
const STEPS_PER_UPDATE: u64 = 10;
/// Number of nodes along the edge of a tile, the unit in which the spline is recomputed.
const TILE_NODES: usize = 32;

/// Terrain whose surface is lowered by erosion.
#[derive(Clone, Debug)]
pub struct ErodibleBed {
    ground: TerrainBed,
    /// Whether erosion lowers the surface.
    lowers_surface: bool,
    /// Initial heights (m).
    initial_heights: Vec<f64>,
    /// Erodible depth at each node (m).
    erodible: Vec<f64>,
    /// Eroded depths.
    state: ErosionState,
    /// Tiles with erosion that the heights do not contain yet.
    changed_tiles: Vec<bool>,
}

/// Eroded depth at each node of the terrain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErosionState {
    /// Depth that the heights contain (m).
    pub in_surface: Vec<f64>,
    /// Depth that the heights do not contain yet (m).
    pub pending_depth: Vec<f64>,
}

impl ErodibleBed {
    /// Bed before erosion and without a limit of the erodible depth. With `lowers` the surface follows the erosion.
    pub fn new(ground: TerrainBed, lowers: bool) -> Self {
        let given = ground.raster().values.clone();
        let count = given.len();
        let raster = ground.raster();
        let tiles = raster.columns.div_ceil(TILE_NODES) * raster.rows.div_ceil(TILE_NODES);
        let state = ErosionState { in_surface: vec![0.0; count], pending_depth: vec![0.0; count] };
        Self {
            ground,
            lowers_surface: lowers,
            initial_heights: given,
            erodible: vec![f64::INFINITY; count],
            state,
            changed_tiles: vec![false; tiles],
        }
    }

    /// Sets the erodible depth (m) as a function of position in plan (m).
    pub fn set_erodible_depth(&mut self, depth: impl Fn([f64; 2]) -> f64) {
        let raster = self.ground.raster();
        let columns = raster.columns;
        for (number, limit) in self.erodible.iter_mut().enumerate() {
            *limit = depth(raster.node_position(number % columns, number / columns));
        }
    }

    /// Level, slope and curvature of the bed at a position in plan.
    #[inline]
    pub fn bed_point<const D: usize>(&self, x: &PlanVector<D>) -> Option<BedPoint<D>> {
        self.ground.bed_point(x)
    }

    /// Whether the bed is defined at a position in plan (m).
    pub fn is_defined<const D: usize>(&self, x: &PlanVector<D>) -> bool {
        self.ground.is_defined(x)
    }

    /// Distance of the nodes of the terrain (m).
    pub fn cell(&self) -> Option<f64> {
        BedSurface::<2>::cell(&self.ground)
    }

    /// Area of a raster node (m²); in a profile, where rows are equal, its length (m).
    fn area<const D: usize>(&self, number: usize) -> f64 {
        let raster = self.ground.raster();
        let half = |k: usize, count: usize| if k == 0 || k + 1 == count { 0.5 } else { 1.0 };
        let along = half(number % raster.columns, raster.columns) * raster.spacing[0];
        if D == 1 {
            return along;
        }
        along * half(number / raster.columns, raster.rows) * raster.spacing[1]
    }

    /// Erodes the volume `wanted` (m³; m² in a profile) at a position, as far as the erodible depth of the nodes around it permits. Returns
    /// the eroded volume.
    pub fn erode<const D: usize>(&mut self, x: &PlanVector<D>, wanted: f64) -> f64 {
        let y = x.get(1).copied().unwrap_or(self.ground.y);
        let Some(mut weights) = self.ground.weights(x[0], y) else { return 0.0 };
        let columns = self.ground.raster().columns;
        if D == 1 {
            // One row represents all.
            for k in 0..2 {
                weights[k] = (weights[k].0 % columns, weights[k].1 + weights[k + 2].1);
                weights[k + 2].1 = 0.0;
            }
        }
        let mut taken = 0.0;
        for (node, weight) in weights {
            let area = self.area::<D>(node);
            let left = self.erodible[node] - self.state.in_surface[node] - self.state.pending_depth[node];
            let depth = (weight * wanted / area).min(left);
            if depth > 0.0 {
                self.state.pending_depth[node] += depth;
                taken += depth * area;
                let tiles = columns.div_ceil(TILE_NODES);
                self.changed_tiles[node / columns / TILE_NODES * tiles + node % columns / TILE_NODES] = true;
            }
        }
        taken
    }

    /// Lowers the heights by the eroded depths, every few steps; returns whether they have changed.
    pub fn update_surface<const D: usize>(&mut self, step: u64) -> bool {
        let lowers = self.lowers_surface
            && step.is_multiple_of(STEPS_PER_UPDATE)
            && self.changed_tiles.contains(&true);
        if lowers {
            self.lower::<D>();
        }
        lowers
    }

    /// Lowers the surface by the eroded depth of the changed tiles.
    fn lower<const D: usize>(&mut self) {
        let raster = self.ground.raster();
        let (columns, rows) = (raster.columns, raster.rows);
        let tiles = [columns.div_ceil(TILE_NODES), rows.div_ceil(TILE_NODES)];
        let window = |tile: usize| {
            let [i, j] = [tile % tiles[0] * TILE_NODES, tile / tiles[0] * TILE_NODES];
            [i..(i + TILE_NODES).min(columns), j..(j + TILE_NODES).min(rows)]
        };
        for tile in (0..self.changed_tiles.len()).filter(|tile| self.changed_tiles[*tile]) {
            let [across, mut up] = window(tile);
            if D == 1 {
                up.end = up.end.min(1);
            }
            for node in up.flat_map(|row| across.clone().map(move |column| row * columns + column)) {
                let ErosionState { in_surface: shown, pending_depth } = &mut self.state;
                shown[node] += std::mem::take(&mut pending_depth[node]);
                for row in if D == 1 { 0..rows } else { 0..1 } {
                    let copy = node + row * columns;
                    self.ground.levels_mut()[copy] = self.initial_heights[copy] - shown[node];
                }
            }
        }
        for tile in (0..self.changed_tiles.len()).filter(|tile| self.changed_tiles[*tile]) {
            let [across, up] = window(tile);
            self.ground.update_window([across, if D == 1 { 0..rows } else { up }]);
        }
        self.changed_tiles.fill(false);
    }

    /// Eroded depth at each raster node (m), one row after another; in a profile of the first row only.
    pub fn eroded_depths(&self) -> impl Iterator<Item = f64> + '_ {
        self.state.in_surface.iter().zip(&self.state.pending_depth).map(|(shown, pending)| shown + pending)
    }

    /// Eroded depth at a position in plan (m), by bilinear interpolation; zero outside the terrain.
    pub fn eroded_depth_at(&self, x: f64, y: f64) -> f64 {
        let of = |(node, weight): (usize, f64)| {
            weight * (self.state.in_surface[node] + self.state.pending_depth[node])
        };
        self.ground.weights(x, y).map_or(0.0, |weights| weights.into_iter().map(of).sum())
    }

    /// Eroded volume (m³; m² in a profile).
    pub fn volume<const D: usize>(&self) -> f64 {
        self.eroded_depths().enumerate().map(|(node, depth)| depth * self.area::<D>(node)).sum()
    }

    /// Eroded depths, as saved in a checkpoint.
    pub fn state(&self) -> &ErosionState {
        &self.state
    }

    /// Restores the eroded depths; `None` if the saved ones are of another raster.
    pub fn restore<const D: usize>(&mut self, state: ErosionState) -> Option<()> {
        let count = self.initial_heights.len();
        if state.in_surface.len() != count || state.pending_depth.len() != count {
            return None;
        }
        let columns = self.ground.raster().columns;
        let tiles = columns.div_ceil(TILE_NODES);
        for node in 0..count {
            let source = if D == 1 { node % columns } else { node };
            if state.in_surface[source] > 0.0 {
                self.ground.levels_mut()[node] = self.initial_heights[node] - state.in_surface[source];
            }
            if state.pending_depth[node] > 0.0 {
                self.changed_tiles[node / columns / TILE_NODES * tiles + node % columns / TILE_NODES] = true;
            }
        }
        self.ground.update_all();
        self.state = state;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use colluvium_points::Raster;

    use super::*;

    fn slope(smoothing: usize) -> ErodibleBed {
        let raster =
            Raster::from_function([40, 36], [0.0; 2], [2.0; 2], |x, y| 50.0 - 0.5 * x + 0.01 * y * y);
        ErodibleBed::new(TerrainBed::new(TerrainBed::smoothed(&raster, smoothing)).unwrap(), true)
    }

    #[test]
    fn erosion_of_a_bed_is_limited_to_its_erodible_volume() {
        let mut eroded_bed = slope(2);
        eroded_bed.set_erodible_depth(|x| if x[0] < 40.0 { 0.25 } else { 0.0 });
        assert!((eroded_bed.erode(&[7.0, 9.5], 0.6) - 0.6).abs() < 1e-15);
        assert_eq!(eroded_bed.erode(&[50.0, 9.5], 0.6), 0.0, "rock");
        // A node 2 m from its neighbours contains 1 m³: four of them have no more than that.
        let more: f64 = (0..20).map(|_| eroded_bed.erode(&[7.0, 9.0], 0.5)).sum();
        let (whole, all) = (0.6 + more, eroded_bed.volume::<2>());
        assert!((whole - all).abs() < 1e-12 && whole < 4.0 + 1e-12, "{whole} {all}");
        assert_eq!(eroded_bed.erode(&[7.0, 9.0], 0.5), 0.0);
        assert!(eroded_bed.eroded_depths().all(|depth| (0.0..=0.25).contains(&depth)));
    }

    #[test]
    fn an_eroded_surface_is_lowered_and_restored_identically() {
        let mut eroded_bed = slope(2);
        let before = eroded_bed.bed_point(&[7.0, 9.0]).unwrap();
        eroded_bed.erode(&[7.0, 9.0], 2.0);
        eroded_bed.update_surface::<2>(9);
        assert_eq!(eroded_bed.bed_point(&[7.0, 9.0]).unwrap(), before, "not before the tenth step");
        eroded_bed.update_surface::<2>(10);
        let after = eroded_bed.bed_point(&[7.0, 9.0]).unwrap();
        // In the middle of four nodes that are lowered alike the spline is lowered by 10/9 along each axis.
        assert!(
            (before.level - after.level - eroded_bed.eroded_depth_at(7.0, 9.0) * 100.0 / 81.0).abs() < 1e-12
        );
        assert!(after.curvature[0][0] > before.curvature[0][0], "a hollow");
        eroded_bed.erode(&[62.0, 63.0], 1.0);
        let mut other = slope(2);
        other.restore::<2>(eroded_bed.state().clone()).unwrap();
        eroded_bed.update_surface::<2>(20);
        other.update_surface::<2>(20);
        for x in [[7.0, 9.0], [62.0, 63.0], [63.9, 64.1], [20.0, 9.0]] {
            assert_eq!(eroded_bed.bed_point(&x), other.bed_point(&x));
        }
    }

    #[test]
    fn a_profile_is_lowered_in_all_its_rows() {
        let raster = Raster::from_function([40, 4], [0.0; 2], [0.5; 2], |x, _| 20.0 - x);
        let mut eroded_bed = ErodibleBed::new(TerrainBed::new(raster).unwrap(), true);
        assert!((eroded_bed.erode(&[5.25], 0.1) - 0.1).abs() < 1e-15);
        assert!((eroded_bed.volume::<1>() - 0.1).abs() < 1e-15);
        eroded_bed.update_surface::<1>(10);
        let bed: BedPoint<1> = eroded_bed.bed_point(&[5.25]).unwrap();
        // The spline is lowered by 10/9 between two lowered nodes.
        assert!(
            (bed.level - (14.75 - 0.1 / 0.9)).abs() < 1e-12,
            "half of a cell's volume on either side: {bed:?}"
        );
    }
}
