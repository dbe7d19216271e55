//! Piecewise linear functions of one variable.

/// Value at `x` of the piecewise linear function through `points`. `place` returns the abscissa of a point, in ascending order, and `value`
/// its ordinate. It is constant beyond the first and the last point, and on a jump (two points with the same abscissa) it is the value
/// above. `None` without points.
pub fn value_at<T>(
    points: &[T],
    place: impl Fn(&T) -> f64,
    value: impl Fn(usize) -> f64,
    x: f64,
) -> Option<f64> {
    let next = points.partition_point(|point| place(point) <= x);
    Some(match (next.checked_sub(1), points.get(next)) {
        (Some(before), Some(after)) => {
            let (from, to) = (place(&points[before]), place(after));
            let (low, high) = (value(before), value(next));
            low + (high - low) * (x - from) / (to - from)
        }
        (Some(last), None) => value(last),
        (None, Some(_)) => value(0),
        (None, None) => return None,
    })
}

/// Abscissae that are not larger than the previous one. Each entry has its index, the abscissa, and the previous one. With `jumps` they may
/// be equal. Values that are not finite are skipped.
pub fn non_ascending(
    places: impl Iterator<Item = f64>,
    jumps: bool,
) -> impl Iterator<Item = (usize, f64, f64)> {
    let mut before = f64::NAN;
    places.enumerate().filter_map(move |(number, place)| {
        let last = std::mem::replace(&mut before, place);
        let descends = place < last || (place == last && !jumps);
        (descends && place.is_finite() && last.is_finite()).then_some((number, place, last))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn piecewise_linear_values_jump_at_repeated_points_and_are_constant_beyond_the_ends() {
        let points = [(1.0, 0.0), (1.0, 2.0), (3.0, 1.0), (5.0, -3.0)];
        let at = |x| value_at(&points, |point| point.0, |number| points[number].1, x);
        let expected =
            [(0.9, 0.0), (1.0, 2.0), (2.0, 1.5), (3.0, 1.0), (4.5, -2.0), (5.0, -3.0), (7.0, -3.0)];
        for (x, value) in expected {
            assert_eq!(at(x), Some(value), "at {x}");
        }
        assert_eq!(value_at(&[0.0; 0], |x| *x, |_| 1.0, 0.0), None);
    }

    #[test]
    fn non_ascending_values_are_found_and_equal_ones_only_without_jumps() {
        let places = [0.0, 1.0, 1.0, f64::NAN, 0.5, 0.25];
        let found = |jumps| non_ascending(places.into_iter(), jumps).collect::<Vec<_>>();
        assert_eq!(found(true), [(5, 0.25, 0.5)]);
        assert_eq!(found(false), [(2, 1.0, 1.0), (5, 0.25, 0.5)]);
    }
}
