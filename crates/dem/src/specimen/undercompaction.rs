//! Undercompaction: layers pressed one on another, the lower ones too little at first (multilayer undercompaction, Jiang et al. 2003;
//! sheet: dem §3.8).

use rand_chacha::ChaCha8Rng;

use crate::points::grains::volume;
use crate::specimen::{
    Container, LAST_RELAXATION_ITERATIONS, RELAXATION_ITERATIONS, check_overlap, pack, separate_overlaps,
};

/// Initial solid fraction of a layer over the target.
const INITIAL_FRACTION_RATIO: f64 = 0.6;
/// Number of steps of the lid on a new layer.
const STEPS: usize = 40;

/// Number and solid fractions of the layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UndercompactedLayers {
    /// Number of layers of equal mass.
    pub count: usize,
    /// Solid fraction of the first layer before the second is added.
    pub first: f64,
    /// Solid fraction of all layers at the end.
    pub last: f64,
}

impl UndercompactedLayers {
    /// Solid fraction of the first `number` layers after compaction of the last of them. The void ratio decreases linearly from that of the
    /// first layer to that of all.
    pub fn fraction(&self, number: usize) -> f64 {
        let void_ratio = |fraction: f64| (1.0 - fraction) / fraction;
        let [first, last] = [self.first, self.last].map(void_ratio);
        let left = if self.count > 1 { (self.count - number) as f64 / (self.count - 1) as f64 } else { 0.0 };
        1.0 / (1.0 + last + (first - last) * left)
    }
}

/// Positions of balls with given radii (m) that fill a container in layers. Each layer is placed at random above the previous ones, and a
/// lid compresses all of them to their solid fraction. The first grains are in the lowest layer.
///
/// # Errors
/// When the balls do not fit, or layers are thinner than two of the largest grains.
pub fn pack_layers<const D: usize>(
    container: &Container<D>,
    radii: &[f64],
    layers: UndercompactedLayers,
    random: &mut ChaCha8Rng,
) -> Result<Vec<[f64; D]>, String> {
    let up = D - 1;
    let base = container.section();
    let total: f64 = radii.iter().map(|radius| volume(D, *radius)).sum();
    let mut positions: Vec<[f64; D]> = Vec::with_capacity(radii.len());
    let (mut solid, mut top) = (0.0, container.low[up]);
    for number in 1..=layers.count {
        let start = positions.len();
        let due = total * number as f64 / layers.count as f64 * (1.0 - 1e-12);
        let mut end = start;
        while end < radii.len() && (solid < due || number == layers.count) {
            solid += volume(D, radii[end]);
            end += 1;
        }
        let own: f64 = radii[start..end].iter().map(|radius| volume(D, *radius)).sum();
        let loose = top + own / (base * INITIAL_FRACTION_RATIO * layers.last);
        let mut above = *container;
        (above.low[up], above.high[up]) = (top, loose);
        above.periodic[up] = false;
        let layer = pack(&above, &radii[start..end], random)
            .map_err(|problem| format!("layer {number}: {problem}"))?;
        positions.extend(layer);
        let fraction = layers.fraction(number);
        top = container.low[up] + solid / (base * fraction);
        let deepest = lower_lid(container, &mut positions, &radii[..end], [loose, top])?;
        check_overlap(deepest, fraction).map_err(|problem| format!("layers 1 to {number}: {problem}"))?;
    }
    Ok(positions)
}

/// Lowers the lid from one height to another (m). Returns the largest remaining overlap over the smaller radius.
fn lower_lid<const D: usize>(
    container: &Container<D>,
    positions: &mut [[f64; D]],
    radii: &[f64],
    [from, to]: [f64; 2],
) -> Result<f64, String> {
    let mut under = *container;
    under.periodic[D - 1] = false;
    let mut deepest = 0.0;
    for step in 1..=STEPS {
        under.high[D - 1] = from + (to - from) * step as f64 / STEPS as f64;
        let pushes = if step == STEPS { LAST_RELAXATION_ITERATIONS } else { RELAXATION_ITERATIONS };
        positions.iter_mut().zip(radii).for_each(|(x, radius)| under.confine(x, *radius));
        deepest = separate_overlaps(&under, positions, radii, 1.0, pushes)?;
    }
    Ok(deepest)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::points::vector::dot;

    #[test]
    fn void_ratios_of_layers_fall_linearly_to_the_last() {
        let layers = UndercompactedLayers { count: 5, first: 0.5, last: 0.8 };
        for (number, void_ratio) in [(1, 1.0), (2, 0.8125), (3, 0.625), (4, 0.4375), (5, 0.25)] {
            assert!((1.0 / layers.fraction(number) - 1.0 - void_ratio).abs() < 1e-12, "{number}");
        }
        assert!((UndercompactedLayers { count: 1, ..layers }.fraction(1) - 0.8).abs() < 1e-15);
    }

    fn random_packing(seed: u64) -> (Container<2>, Vec<f64>, Result<Vec<[f64; 2]>, String>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let radii: Vec<f64> = (0..400).map(|_| 0.4 + 0.2 * random.random::<f64>()).collect();
        let solid: f64 = radii.iter().map(|r| volume(2, *r)).sum();
        let container = Container {
            low: [0.0, 1.0],
            high: [20.0, 1.0 + solid / (20.0 * 0.78)],
            periodic: [true, false],
            round_wall: None,
        };
        let layers = UndercompactedLayers { count: 4, first: 0.7, last: 0.78 };
        let placed = pack_layers(&container, &radii, layers, &mut random);
        (container, radii, placed)
    }

    #[test]
    fn layers_fill_their_box_in_order_without_overlaps() {
        let (container, radii, placed) = random_packing(3);
        let placed = placed.unwrap();
        for i in 0..placed.len() {
            assert!(
                placed[i][1] > 1.0 + radii[i] - 1e-9 && placed[i][1] < container.high[1] - radii[i] + 1e-9
            );
            for j in 0..i {
                let apart = container.separation(&placed[i], &placed[j]);
                let overlap = radii[i] + radii[j] - dot(&apart, &apart).sqrt();
                assert!(overlap <= 0.011 * radii[i].min(radii[j]), "{i} {j} {overlap}");
            }
        }
        // Grains of a layer stay above those of the one before.
        let mean = |part: &[[f64; 2]]| part.iter().map(|x| x[1]).sum::<f64>() / part.len() as f64;
        let heights: Vec<f64> = placed.chunks(100).map(mean).collect();
        let quarter = (container.high[1] - 1.0) / 4.0;
        for (k, height) in heights.iter().enumerate() {
            assert!((height - 1.0 - quarter * (k as f64 + 0.5)).abs() < 0.25 * quarter, "{heights:?}");
        }
        assert_eq!(random_packing(3).2.unwrap(), placed);
        assert_ne!(random_packing(4).2.unwrap(), placed);
    }

    #[test]
    fn layers_that_are_too_thin_or_too_dense_are_refused() {
        let (container, radii, _) = random_packing(3);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let thin = pack_layers(
            &container,
            &radii,
            UndercompactedLayers { count: 40, first: 0.7, last: 0.78 },
            &mut random,
        )
        .unwrap_err();
        assert!(thin.starts_with("layer 1: ") && thin.contains("two of the largest grains"), "{thin}");
        let dense = pack_layers(
            &container,
            &radii,
            UndercompactedLayers { count: 4, first: 0.9, last: 0.9 },
            &mut random,
        )
        .unwrap_err();
        assert!(dense.starts_with("layers 1 to 1: ") && dense.contains("leaves overlaps"), "{dense}");
    }
}
