//! Largest smoothing length of the nodes that reach a position: a long one far away does not enlarge a search.

use crate::points::phase_nodes::PlanVector;

/// Cells per node at most.
const CELLS_PER_NODE: f64 = 4.0;

/// Largest smoothing length among the nodes whose support includes a cell.
#[derive(Debug)]
pub struct MaxSmoothingLength<const D: usize> {
    low: PlanVector<D>,
    edge: f64,
    counts: [usize; D],
    cell_lengths: Vec<f64>,
    reaching_lengths: Vec<f64>,
}

impl<const D: usize> Default for MaxSmoothingLength<D> {
    fn default() -> Self {
        Self {
            low: [0.0; D],
            edge: 1.0,
            counts: [0; D],
            cell_lengths: Vec::new(),
            reaching_lengths: Vec::new(),
        }
    }
}

impl<const D: usize> MaxSmoothingLength<D> {
    /// Updates the cells from positions and smoothing lengths of nodes (m); `reach` is the kernel support in smoothing lengths. Positions
    /// that are not finite are ignored here; the neighbour search reports them.
    pub fn update(&mut self, places: &[PlanVector<D>], lengths: &[f64], reach: f64) {
        let (mut low, mut high) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        for x in places {
            for c in 0..D {
                low[c] = low[c].min(x[c]);
                high[c] = high[c].max(x[c]);
            }
        }
        let mean = lengths.iter().sum::<f64>() / lengths.len().max(1) as f64;
        let largest = CELLS_PER_NODE * places.len().max(1) as f64;
        let mut edge = if mean > 0.0 && mean.is_finite() { reach * mean } else { 1.0 };
        let along = |c: usize, edge: f64| ((high[c] - low[c]) / edge).floor().max(0.0) + 1.0;
        // Bounded, so that positions that are not finite cannot keep the loop running.
        for _ in 0..200 {
            if (0..D).map(|c| along(c, edge)).product::<f64>() <= largest {
                break;
            }
            edge *= 2.0;
        }
        let counts: PlanVector<D> = std::array::from_fn(|c| along(c, edge));
        let all = counts.iter().product::<f64>();
        (self.low, self.edge) = (low, edge);
        self.counts = if all <= largest { counts.map(|count| count as usize) } else { [1; D] };
        let cells = self.counts.iter().product();
        for column in [&mut self.cell_lengths, &mut self.reaching_lengths] {
            column.clear();
            column.resize(cells, 0.0);
        }
        for (x, length) in places.iter().zip(lengths) {
            let cell = self.cell(x);
            self.cell_lengths[cell] = self.cell_lengths[cell].max(*length);
        }
        self.propagate(reach);
    }

    /// Transfers the length of each cell to the cells within the support of its nodes.
    fn propagate(&mut self, reach: f64) {
        for cell in 0..self.cell_lengths.len() {
            let length = self.cell_lengths[cell];
            if length == 0.0 {
                continue;
            }
            let steps = (reach * length / self.edge).ceil().clamp(1.0, 1e9) as usize;
            let mut rest = cell;
            let mut spans = [(0, 0); D];
            for c in (0..D).rev() {
                let index = rest % self.counts[c];
                rest /= self.counts[c];
                spans[c] = (index.saturating_sub(steps), (index + steps).min(self.counts[c] - 1));
            }
            let lines: usize = spans[..D - 1].iter().map(|(a, b)| b - a + 1).product();
            for line in 0..lines {
                // One or two axes: a line is a row.
                let row = if D == 1 { 0 } else { (spans[0].0 + line) * self.counts[D - 1] };
                let (a, b) = spans[D - 1];
                self.reaching_lengths[row + a..=row + b]
                    .iter_mut()
                    .for_each(|largest| *largest = largest.max(length));
            }
        }
    }

    /// Index of the cell of a position in plan (m).
    fn cell(&self, x: &PlanVector<D>) -> usize {
        (0..D).fold(0, |key, c| {
            let index = ((x[c] - self.low[c]) / self.edge).max(0.0) as usize;
            key * self.counts[c] + index.min(self.counts[c] - 1)
        })
    }

    /// Largest smoothing length among the nodes whose support includes a position (m); zero if there are none.
    #[inline]
    pub fn length_at(&self, x: &PlanVector<D>) -> f64 {
        self.reaching_lengths.get(self.cell(x)).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_nearby_smoothing_length_is_found_without_distant_ones() {
        let mut places = Vec::new();
        let mut lengths = Vec::new();
        for k in 0..400 {
            places.push([f64::from(k % 20), 0.7 * f64::from(k / 20)]);
            lengths.push(if k == 25 { 2.5 } else { 0.8 + 0.01 * f64::from(k % 7) });
        }
        let mut around = MaxSmoothingLength::default();
        around.update(&places, &lengths, 2.8);
        for x in &places {
            let reaching = places
                .iter()
                .zip(&lengths)
                .filter(|(y, length)| (x[0] - y[0]).hypot(x[1] - y[1]) <= 2.8 * **length);
            let largest = reaching.map(|(_, length)| *length).fold(0.0, f64::max);
            assert!(around.length_at(x) >= largest, "{x:?}");
        }
        assert!(around.length_at(&places[399]) < 1.0);
    }

    #[test]
    fn lost_nodes_do_not_fill_the_memory() {
        let mut around = MaxSmoothingLength::default();
        around.update(&[[0.0, 0.0], [1e12, 3.0], [5.0, -1e9]], &[1.0; 3], 2.8);
        assert!(around.cell_lengths.len() <= 12 && around.length_at(&[0.0, 0.0]) == 1.0);
        around.update(&[[0.0, f64::NAN]], &[1.0], 2.8);
    }
}
