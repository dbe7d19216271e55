//! Upper bound theorem of limit analysis for a homogeneous slope with a level crest: a rigid body of soil that turns about a point beyond
//! the face on a logarithmic spiral through the toe (Chen 1975, *Limit Analysis and Soil Plasticity*, §9.2). No slope of associated
//! Mohr–Coulomb soil has a factor of safety above the one found here.

use crate::analysis::bishop_circle::HomogeneousSlope;
use crate::analysis::statistics::grid_search_minimum;

/// Logarithmic spiral as a slip surface, with its upper bound of the factor of safety.
#[derive(Clone, Copy, Debug)]
pub struct LogSpiral {
    /// Factor of safety.
    pub safety_factor: f64,
    /// Position at which the spiral enters the slope at its crest, from the toe (m).
    pub crest_entry: f64,
}

/// Number of positions per angle in each pass of the search, and the ratio of the search width to that of the previous pass.
const SEARCH_GRID: (usize, f64) = (25, 0.5);
/// Number of bisections of the factor.
const BISECTIONS: usize = 40;

/// Stability number (critical height times unit weight over cohesion) of a spiral, and length of the moving crest over the height. Its
/// radii to the crest and to the toe are at the angles `from` and `to`; `None` where it is no mechanism.
fn mechanism(slope: f64, friction: f64, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
    let t = friction.tan();
    let grown = ((to - from) * t).exp();
    // Height and length of the moving crest, over the radius to the crest.
    let height = to.sin() * grown - from.sin();
    let crest = (to - from).sin() / to.sin() - (to + slope).sin() / (to.sin() * slope.sin()) * height;
    // Written so that NaN gives none.
    if !(height > 0.0 && crest > 0.0) {
        return None;
    }
    // Work of the weight: the sector of the spiral less the two triangles outside the soil.
    let end = |angle: f64, size: f64| (3.0 * t * angle.cos() + angle.sin()) * size;
    let sector = (end(to, grown.powi(3)) - end(from, 1.0)) / (3.0 * (1.0 + 9.0 * t * t));
    let above = crest * (2.0 * from.cos() - crest) * from.sin() / 6.0;
    let face = grown * ((to - from).sin() - crest * to.sin()) * (from.cos() - crest + to.cos() * grown) / 6.0;
    let work = sector - above - face;
    // Dissipation along the spiral, over twice the tangent of the friction angle.
    let dissipated = if t > 0.0 { (grown * grown - 1.0) / (2.0 * t) } else { to - from };
    (work > 0.0).then(|| [dissipated / work * height, crest / height])
}

/// Least stability number `γ H / c` of a slope (angles in radians), and the length of the moving crest over the height.
fn min_stability_number(slope: f64, friction: f64) -> Option<[f64; 2]> {
    let limits = [(0.02, 2.0), (0.1, 3.0)];
    let found = |at: [f64; 2]| mechanism(slope, friction, at).filter(|_| at[1] > at[0]);
    let (_, at) =
        grid_search_minimum(limits, SEARCH_GRID, |at| found(at).map_or(f64::INFINITY, |[number, _]| number))?;
    found(at)
}

impl HomogeneousSlope {
    /// Least upper bound of the factor of safety by spirals through the toe.
    pub fn log_spiral(&self) -> Option<LogSpiral> {
        let face = (1.0 / self.cotangent).atan();
        let reduced = |factor: f64| {
            let weak = self.weakened(factor);
            let [number, crest] = min_stability_number(face, weak.friction_angle.to_radians())?;
            Some((number * weak.cohesion / weak.unit_weight, crest))
        };
        let (mut low, mut high) = (0.1, 10.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if reduced(middle)?.0 > self.height { low = middle } else { high = middle }
        }
        let (_, crest) = reduced(low)?;
        Some(LogSpiral { safety_factor: low, crest_entry: self.height * (self.cotangent + crest) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stability_numbers_are_those_of_chen() {
        // Friction angle, slope (degrees), γ H / c.
        for (friction, slope, published) in [(0.0, 90.0, 3.83), (20.0, 60.0, 10.39)] {
            let [number, _] =
                min_stability_number(f64::to_radians(slope), f64::to_radians(friction)).unwrap();
            assert!((number - published).abs() < 5e-3, "{friction}, {slope}: {number}");
        }
    }

    #[test]
    fn a_factor_scales_with_strength() {
        let slope = HomogeneousSlope {
            height: 5.0,
            cotangent: 1.0,
            unit_weight: 18e3,
            cohesion: 12e3,
            friction_angle: 25.0,
        };
        let factor = slope.log_spiral().unwrap().safety_factor;
        assert!((slope.weakened(factor).log_spiral().unwrap().safety_factor - 1.0).abs() < 1e-6);
    }
}
