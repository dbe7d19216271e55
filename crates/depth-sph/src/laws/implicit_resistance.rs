//! Resistance to the pore fluid, implicit in its speed (sheet: depth-sph §2.6, §3.4).

/// Largest number of iterations of the search for a speed; a bisection to a speed near zero needs half of them.
const ITERATIONS: usize = 200;
/// Relative width of the bracket at which the search ends.
const TOLERANCE: f64 = 1e-13;

/// Speed after an implicit step with a resistance (m/s): root of `v + resistance(v) = speed` in `0..=speed`. `resistance` is the speed lost
/// in the step (m/s), which increases with the speed.
pub fn implicit_speed(speed: f64, resistance: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, speed);
    let excess = |v: f64| v + resistance(v) - speed;
    let mut v = speed - resistance(speed).min(0.5 * speed);
    for _ in 0..ITERATIONS {
        let error = excess(v);
        if error > 0.0 {
            high = v;
        } else {
            low = v;
        }
        if high - low <= TOLERANCE * high || error == 0.0 {
            break;
        }
        // Newton's step with a slope by difference; bisection where it leaves the bracket.
        let step = 1e-6 * v;
        let slope = (excess(v + step) - error) / step;
        let next = v - error / slope;
        let inside = next > low && next < high;
        let was = v;
        v = if inside { next } else { 0.5 * (low + high) };
        if inside && (v - was).abs() <= TOLERANCE * v {
            break;
        }
    }
    v
}

#[cfg(test)]
mod tests {
    use super::implicit_speed;

    #[test]
    fn the_root_is_found_for_every_power() {
        for power in [0.3, 0.5, 1.0, 2.0, 3.0] {
            for factor in [1e-6, 1e-2, 1.0, 1e3, 1e8] {
                let v = implicit_speed(3.0, |v| factor * v.powf(power));
                let error = v + factor * v.powf(power) - 3.0;
                assert!(error.abs() < 1e-9 * (1.0 + factor), "{power} {factor}: {v}");
            }
        }
    }
}
