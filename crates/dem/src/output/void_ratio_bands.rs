//! Uniformity of packings of disks: void ratios of bands, with disks cut exactly (sheet: dem §3.8).

use crate::points::grains::Grains;

/// Void ratios of the bands of a packing.
#[derive(Clone, Debug, PartialEq)]
pub struct VoidRatioBands {
    /// Void ratio of each band, from below; infinite where a band is empty.
    pub bands: Vec<f64>,
    /// Void ratio over all bands.
    pub void_ratio: f64,
    /// Variance `Σ (e - e_k)² / (N - 1)`; its root is the standard deviation. A packing counts as uniform below 0.05.
    pub variance: f64,
}

/// Area of the part of a disk of radius `r` below a horizontal line at height `h` above its centre.
fn segment_area(r: f64, h: f64) -> f64 {
    let h = h.clamp(-r, r);
    let half = (h / r).asin();
    r * r * (half + std::f64::consts::FRAC_PI_2) + h * (r * r - h * h).max(0.0).sqrt()
}

/// Void ratios of horizontal bands of equal height between `low` and `high` in the range from `left` to `right` (m), which contains the
/// disks or is periodic. `None` for fewer than two bands, an empty range, and without disks.
pub fn void_ratio_bands(
    grains: &Grains<2, 1>,
    [left, right]: [f64; 2],
    [low, high]: [f64; 2],
    bands: usize,
) -> Option<VoidRatioBands> {
    let height = (high - low) / bands as f64;
    if bands < 2 || !(height > 0.0 && right > left) {
        return None;
    }
    let mut solid = vec![0.0; bands];
    for (x, r) in grains.position.iter().zip(&grains.radius) {
        for (k, sum) in solid.iter_mut().enumerate() {
            let floor = low + height * k as f64;
            *sum += segment_area(*r, floor + height - x[1]) - segment_area(*r, floor - x[1]);
        }
    }
    let area = (right - left) * height;
    let ratio = |solid: f64, area: f64| (area - solid) / solid;
    let total: f64 = solid.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let void_ratio = ratio(total, area * bands as f64);
    let bands: Vec<f64> = solid.iter().map(|solid| ratio(*solid, area)).collect();
    let squares: f64 = bands.iter().map(|e| (e - void_ratio).powi(2)).sum();
    Some(VoidRatioBands { variance: squares / (bands.len() - 1) as f64, bands, void_ratio })
}

#[cfg(test)]
mod tests {
    use super::segment_area;
    use colluvium_testkit::assert_near;

    #[test]
    fn a_line_cuts_a_disk_into_segments() {
        let area = std::f64::consts::PI * 4.0;
        assert_near(segment_area(2.0, 0.0), 0.5 * area, 1e-12);
        assert_near(segment_area(2.0, 5.0), area, 1e-12);
        assert_near(segment_area(2.0, -2.0), 0.0, 1e-12);
        // A segment of half the radius: r² (π/3 - √3/4) is cut off.
        assert_near(
            segment_area(2.0, 1.0),
            area - 4.0 * (std::f64::consts::PI / 3.0 - 3f64.sqrt() / 4.0),
            1e-12,
        );
    }
}
