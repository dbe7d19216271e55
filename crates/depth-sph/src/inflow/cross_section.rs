//! Cross-section of the bed along a line of inflow, and its filling by a discharge (sheet: depth-sph §3.9).

/// Depth below which a position of the section has no inflow, as a share of the largest depth; its share is given to its neighbours.
const MIN_DEPTH_RATIO: f64 = 0.02;
/// Number of bisections in the search for the water level.
const HALVINGS: usize = 60;

/// Cross-section of the bed along an inflow line, as levels of equal parts of the line.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSection {
    /// Length of the line (m).
    width: f64,
    /// Heights of the bed above its lowest point (m).
    beds: Vec<f64>,
}

impl CrossSection {
    /// Cross-section of a line of length `width` (m) over a bed with these levels (m).
    pub fn new(width: f64, heights: &[f64]) -> Self {
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        Self { width, beds: heights.iter().map(|height| height - lowest).collect() }
    }

    /// Area (m²) and width (m) of the wetted section up to a level (m above the lowest point).
    pub fn wetted_area_and_width(&self, level: f64) -> (f64, f64) {
        let part = self.width / self.beds.len() as f64;
        let depths = self.beds.iter().map(|bed| level - bed).filter(|depth| *depth > 0.0);
        let (sum, count) = depths.fold((0.0, 0), |(sum, count), depth| (sum + depth, count + 1));
        (sum * part, f64::from(count) * part)
    }

    /// Water level (m above the lowest point) at which the mean depth of the wetted width equals `depth`, a function of that width (m). A
    /// depth of zero leaves the line dry.
    pub fn level(&self, depth: impl Fn(f64) -> f64) -> f64 {
        if !(depth(self.width) > 0.0) {
            return 0.0;
        }
        let is_short = |level: f64| {
            let (area, width) = self.wetted_area_and_width(level);
            !(width > 0.0) || area / width < depth(width)
        };
        let (mut low, mut high) = (0.0, 1e-3);
        while is_short(high) && high < 1e9 {
            high *= 2.0;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_short(middle) { low = middle } else { high = middle }
        }
        high
    }

    /// Wetted positions of the section at a level (m above the lowest point), with their shares of the wetted area.
    pub fn wetted_shares(&self, level: f64) -> Vec<(usize, f64)> {
        let depths = self.beds.iter().map(|bed| level - bed).enumerate();
        let wet: Vec<(usize, f64)> = depths.filter(|(_, depth)| *depth > MIN_DEPTH_RATIO * level).collect();
        let whole: f64 = wet.iter().map(|(_, depth)| depth).sum();
        wet.into_iter().map(|(k, depth)| (k, depth / whole)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle has the area `s²/m` and the width `2 s/m` of its level `s` and the slope `m` of its sides.
    #[test]
    fn a_triangular_channel_is_filled_up_to_its_level() {
        let heights: Vec<f64> =
            (0..4000).map(|k| 7.0 + 0.5 * (f64::from(k) * 0.01 + 0.005 - 20.0).abs()).collect();
        let section = CrossSection::new(40.0, &heights);
        let (area, width) = section.wetted_area_and_width(3.0);
        assert!((area - 18.0).abs() < 0.05 && (width - 12.0).abs() < 0.05, "{area} m² {width} m");
        // Critical flow of 20 m³/s: `Q² b = g A³`, level `(8 Q² / (g 4))^(1/5)` with m = ½.
        let critical = |width: f64| ((20.0 / width).powi(2) / 9.81).cbrt();
        let level = section.level(critical);
        let exact = (0.5f64 * 20.0 * 20.0 / 9.81).powf(0.2);
        assert!((level / exact - 1.0).abs() < 0.01, "{level} m for {exact}");
        let shares = section.wetted_shares(level);
        assert!((shares.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(shares.iter().all(|(k, _)| heights[*k] < 7.0 + level));
        assert_eq!(section.level(|_| 0.0), 0.0);
    }
}
