//! Penalty contact law of a point on surfaces: a normal force by the overlap, and a spring along the surface with Coulomb's bound
//! (docs/theory/mpm.md, obstacles).

use colluvium_case::ObstacleLaw;

/// Maximum number of surfaces in contact with a point; among more the nearest ones are used.
pub const MAX_OVERLAPS: usize = 8;

/// Overlap of a point with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceOverlap<const D: usize> {
    /// Unit normal out of the obstacle.
    pub normal: [f64; D],
    /// Overlap along the normal (m), positive.
    pub depth: f64,
    /// Number of the obstacle.
    pub obstacle: usize,
    /// Contact law of the obstacle at the overlap.
    pub law: ObstacleLaw,
}

/// Fraction of the deepest overlap below which an overlap is neglected.
const NEGLIGIBLE_OVERLAP: f64 = 1e-9;

/// Scalar product.
fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|c| a[c] * b[c]).sum()
}

/// Length of a vector.
pub fn length<const D: usize>(a: &[f64; D]) -> f64 {
    dot(a, a).sqrt()
}

/// Smallest translation (m) that removes all overlaps of a point, `Σ way_i n_i` with non-negative components `translation_shares` (m). With
/// a stiffness the energy is half the stiffness times the squared translation, for any number of surfaces.
///
/// With the shares times a stiffness as forces, the energy is half the stiffness times the square of the translation, for any number of
/// surfaces. Of two facets with almost the same normal the deeper one counts, at a right angle both do in full, with a continuous
/// transition. Where no translation removes all overlaps, as between two walls, every overlap acts by itself.
pub fn minimum_translation<const D: usize>(
    overlaps: &[SurfaceOverlap<D>],
    translation_shares: &mut [f64; MAX_OVERLAPS],
) -> [f64; D] {
    translation_shares.fill(0.0);
    let count = overlaps.len().min(MAX_OVERLAPS);
    if count == 0 {
        return [0.0; D];
    }
    let deepest = overlaps[..count].iter().map(|overlap| overlap.depth).fold(0.0, f64::max);
    let mut of =
        |chosen: &[usize]| solve(overlaps, count, chosen, NEGLIGIBLE_OVERLAP * deepest, translation_shares);
    let found = (0..count)
        .find_map(|i| of(&[i]))
        .or_else(|| overlap_pairs(count).find_map(|[i, j]| of(&[i, j])))
        .or_else(|| {
            let triples = overlap_pairs(count).flat_map(|[i, j]| (j + 1..count).map(move |k| [i, j, k]));
            if D < 3 { None } else { triples.into_iter().find_map(|chosen| of(&chosen)) }
        });
    found.unwrap_or_else(|| {
        translation_shares.fill(0.0);
        let mut translation = [0.0; D];
        for (overlap, own) in overlaps[..count].iter().zip(translation_shares) {
            *own = overlap.depth;
            (0..D).for_each(|c| translation[c] += overlap.depth * overlap.normal[c]);
        }
        translation
    })
}

/// Pairs of indices below `count`, each once.
fn overlap_pairs(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| [i, j]))
}

/// Smallest translation onto the surfaces of the `chosen` overlaps; `None` unless all components are positive and all overlaps are removed.
fn solve<const D: usize>(
    overlaps: &[SurfaceOverlap<D>],
    count: usize,
    chosen: &[usize],
    slack: f64,
    translation_shares: &mut [f64; MAX_OVERLAPS],
) -> Option<[f64; D]> {
    // Cholesky factors of the products of their normals.
    let (mut lower, mut shares) = ([[0.0; 3]; 3], [0.0; 3]);
    for (a, &i) in chosen.iter().enumerate() {
        for (b, &j) in chosen[..=a].iter().enumerate() {
            let rest: f64 = (0..b).map(|c| lower[a][c] * lower[b][c]).sum();
            let value = dot(&overlaps[i].normal, &overlaps[j].normal) - rest;
            lower[a][b] = if a == b {
                if value < NEGLIGIBLE_OVERLAP {
                    return None;
                }
                value.sqrt()
            } else {
                value / lower[b][b]
            };
        }
        let rest: f64 = (0..a).map(|c| lower[a][c] * shares[c]).sum();
        shares[a] = (overlaps[i].depth - rest) / lower[a][a];
    }
    for a in (0..chosen.len()).rev() {
        let rest: f64 = (a + 1..chosen.len()).map(|c| lower[c][a] * shares[c]).sum();
        shares[a] = (shares[a] - rest) / lower[a][a];
    }
    if shares[..chosen.len()].iter().any(|share| *share < 0.0) {
        return None;
    }
    let mut translation = [0.0; D];
    for (share, &i) in shares.iter().zip(chosen) {
        (0..D).for_each(|c| translation[c] += share * overlaps[i].normal[c]);
    }
    if overlaps[..count].iter().any(|overlap| dot(&overlap.normal, &translation) < overlap.depth - slack) {
        return None;
    }
    translation_shares.fill(0.0);
    shares.iter().zip(chosen).for_each(|(share, &i)| translation_shares[i] = *share);
    Some(translation)
}

/// Tangential spring displacement (m) after a displacement `moved` of the point relative to the surface (m), and the slip (m). After a
/// change of the normal the spring is rotated with it and keeps its length. It is bounded by `max_length` (m), which may be infinite.
pub fn friction_impulse<const D: usize>(
    spring: &[f64; D],
    moved: &[f64; D],
    normal: &[f64; D],
    max_length: f64,
) -> ([f64; D], f64) {
    let along = |a: &[f64; D]| -> [f64; D] {
        let out = dot(a, normal);
        std::array::from_fn(|c| a[c] - out * normal[c])
    };
    let tangential = along(spring);
    let (before, after) = (length(spring), length(&tangential));
    let scale = if after > 0.0 { before / after } else { 0.0 };
    let step = along(moved);
    let next: [f64; D] = std::array::from_fn(|c| scale * tangential[c] + step[c]);
    let full = length(&next);
    // Written so that a point without any bound never divides by zero.
    if full <= max_length {
        return (next, 0.0);
    }
    (next.map(|c| c * (max_length / full)), full - max_length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use colluvium_case::description::ObstacleWall;
    use proptest::prelude::*;

    const SMOOTH: ObstacleLaw = ObstacleLaw { wall: ObstacleWall::Smooth, separation: true };

    fn overlap<const D: usize>(normal: [f64; D], depth: f64) -> SurfaceOverlap<D> {
        SurfaceOverlap { normal, depth, obstacle: 0, law: SMOOTH }
    }

    #[test]
    fn minimum_translation_is_the_depth_of_one_surface_and_both_in_a_corner() {
        let mut translation_shares = [0.0; MAX_OVERLAPS];
        let floor = overlap([0.0, 1.0], 0.2);
        assert_eq!(minimum_translation(&[floor], &mut translation_shares), [0.0, 0.2]);
        let wall = overlap([1.0, 0.0], 0.1);
        let translation = minimum_translation(&[floor, wall], &mut translation_shares);
        assert!(
            (translation[0] - 0.1).abs() < 1e-15 && (translation[1] - 0.2).abs() < 1e-15,
            "{translation:?}"
        );
        assert!((translation_shares[0] - 0.2).abs() < 1e-15 && (translation_shares[1] - 0.1).abs() < 1e-15);
        assert_eq!(
            minimum_translation(&[floor, overlap([0.0, 1.0], 0.15)], &mut translation_shares),
            [0.0, 0.2],
            "the deeper of two"
        );
        let slot = minimum_translation(&[wall, overlap([-1.0, 0.0], 0.3)], &mut translation_shares);
        assert!((slot[0] + 0.2).abs() < 1e-15, "between two walls: {slot:?}");
        assert_eq!(minimum_translation::<2>(&[], &mut translation_shares), [0.0; 2]);
    }

    #[test]
    fn minimum_translation_in_a_corner_of_three_planes_has_all_components() {
        let mut translation_shares = [0.0; MAX_OVERLAPS];
        let planes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let overlaps: Vec<_> = planes.iter().zip([0.1, 0.2, 0.3]).map(|(n, d)| overlap(*n, d)).collect();
        let translation = minimum_translation(&overlaps, &mut translation_shares);
        assert!((0..3).all(|c| (translation[c] - 0.1 * (c + 1) as f64).abs() < 1e-14), "{translation:?}");
    }

    proptest! {
        #[test]
        fn the_minimum_translation_removes_all_overlaps_and_none_is_shorter(
            angles in proptest::collection::vec(-1.2..1.2f64, 1..6),
            depths in proptest::collection::vec(0.01..1.0f64, 6),
            at in (-2.0..2.0f64, -2.0..2.0f64),
        ) {
            let overlaps: Vec<_> =
                angles.iter().zip(&depths).map(|(a, d)| overlap([a.sin(), a.cos()], *d)).collect();
            let translation = minimum_translation(&overlaps, &mut [0.0; MAX_OVERLAPS]);
            prop_assert!(overlaps.iter().all(|o| dot(&o.normal, &translation) >= o.depth - 1e-8));
            let other = [at.0, at.1];
            let leads_out = overlaps.iter().all(|o| dot(&o.normal, &other) >= o.depth);
            prop_assert!(!leads_out || length(&other) >= length(&translation) - 1e-8);
        }
    }

    #[test]
    fn a_friction_spring_slips_at_its_limit_and_rotates_with_the_normal() {
        let (spring, slip) = friction_impulse(&[0.0; 2], &[0.3, 5.0], &[0.0, 1.0], 0.1);
        assert!((spring[0] - 0.1).abs() < 1e-15 && spring[1] == 0.0 && (slip - 0.2).abs() < 1e-15);
        let tilted = [0.6, 0.8];
        let (scale, slip) = friction_impulse(&[0.1, 0.0], &[0.0; 2], &tilted, f64::INFINITY);
        assert!((length(&scale) - 0.1).abs() < 1e-15 && dot(&scale, &tilted).abs() < 1e-15 && slip == 0.0);
        let (none, slip) = friction_impulse(&[0.0; 2], &[0.2, 0.0], &[0.0, 1.0], 0.0);
        assert_eq!((none, slip), ([0.0; 2], 0.2), "a smooth surface");
    }
}
