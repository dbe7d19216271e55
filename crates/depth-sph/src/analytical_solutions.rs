//! Closed-form solutions of depth-integrated flow, for verification (sheet: depth-sph §5).

/// Ritter's dam break on a dry bed: depth (m) and velocity (m/s) at `x` (m) after `t` (s), of a reservoir of depth `h0` (m) at `x < 0`.
pub fn ritter(gravity: f64, h0: f64, x: f64, t: f64) -> (f64, f64) {
    frictional_dam_break(gravity, h0, 0.0, x, t)
}

/// Dam break of a frictional material on an incline: [`ritter`] with the net acceleration `g'(tan θ - tan δ)` along the bed (m/s²).
/// `gravity` is the gravity normal to the bed (m/s²).
pub fn frictional_dam_break(gravity: f64, h0: f64, acceleration: f64, x: f64, t: f64) -> (f64, f64) {
    let celerity = (gravity * h0).sqrt();
    let fall = 0.5 * acceleration * t * t;
    if x < fall - celerity * t {
        return (h0, acceleration * t);
    }
    if x > fall + 2.0 * celerity * t {
        return (0.0, 0.0);
    }
    let head = 2.0 * celerity - x / t + 0.5 * acceleration * t;
    (head * head / (9.0 * gravity), 2.0 / 3.0 * (x / t + celerity + acceleration * t))
}

/// Stoker's dam break on a wet bed, with the state between the waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stoker {
    gravity: f64,
    left_depth: f64,
    right_depth: f64,
    /// Depth between the waves (m).
    pub depth: f64,
    /// Velocity between the waves (m/s).
    pub velocity: f64,
    /// Speed of the bore (m/s).
    pub bore_speed: f64,
}

/// Root of a monotone function between `low` and `high` by bisection.
fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let rises = f(high) > f(low);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == rises { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Velocity across a bore from depth `a` to `b` (m/s).
fn bore_velocity(gravity: f64, a: f64, b: f64) -> f64 {
    (b - a) * (0.5 * gravity * (a + b) / (a * b)).sqrt()
}

impl Stoker {
    /// Creates the solution of depths `left_depth` > `right_depth` > 0 (m).
    pub fn new(gravity: f64, left_depth: f64, right_depth: f64) -> Self {
        let celerity = |h: f64| (gravity * h).sqrt();
        let balance =
            |h: f64| 2.0 * (celerity(h) - celerity(left_depth)) + bore_velocity(gravity, right_depth, h);
        let depth = root(right_depth, left_depth, balance);
        let velocity = 2.0 * (celerity(left_depth) - celerity(depth));
        Self {
            gravity,
            left_depth,
            right_depth,
            depth,
            velocity,
            bore_speed: depth * velocity / (depth - right_depth),
        }
    }

    /// Depth and velocity at `x` (m) after `t` (s).
    pub fn state_at(&self, x: f64, t: f64) -> (f64, f64) {
        let celerity = |h: f64| (self.gravity * h).sqrt();
        let place = x / t;
        if place < -celerity(self.left_depth) {
            (self.left_depth, 0.0)
        } else if place < self.velocity - celerity(self.depth) {
            ritter(self.gravity, self.left_depth, x, t)
        } else if place < self.bore_speed {
            (self.depth, self.velocity)
        } else {
            (self.right_depth, 0.0)
        }
    }

    /// Depth (m) and velocity (m/s) of the bore that a wall reflects.
    pub fn reflected(&self) -> (f64, f64) {
        let (h, u) = (self.depth, self.velocity);
        let depth = root(h, 100.0 * h, |wall| bore_velocity(self.gravity, h, wall) - u);
        (depth, -u * h / (depth - h))
    }
}

/// Dam break of a mixture with a common velocity of the phases and a different density on each side (sheet: depth-sph §5.2, B1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LockedDam {
    gravity: f64,
    densities: [f64; 2],
    depths: [f64; 2],
    /// Pressure over the depth between the waves (N/m).
    pub pressure: f64,
    /// Velocity between the waves (m/s).
    pub velocity: f64,
    /// Depths at the left and the right of the contact discontinuity (m).
    pub contact_depths: [f64; 2],
}

impl LockedDam {
    /// Solution for given densities (kg/m³) and depths (m) at the left and the right.
    pub fn new(gravity: f64, densities: [f64; 2], depths: [f64; 2]) -> Self {
        let star = |side: usize, p: f64| (2.0 * p / (gravity * densities[side])).sqrt();
        let jump = |side: usize, p: f64| {
            let (h, after) = (depths[side], star(side, p));
            if after > h {
                bore_velocity(gravity, h, after)
            } else {
                2.0 * ((gravity * after).sqrt() - (gravity * h).sqrt())
            }
        };
        let own = |side: usize| 0.5 * gravity * densities[side] * depths[side].powi(2);
        let pressure = root(0.01 * own(0).min(own(1)), own(0).max(own(1)), |p| jump(0, p) + jump(1, p));
        let velocity = 0.5 * (jump(1, pressure) - jump(0, pressure));
        Self {
            gravity,
            densities,
            depths,
            pressure,
            velocity,
            contact_depths: [star(0, pressure), star(1, pressure)],
        }
    }

    /// Speeds of the waves (m/s): left head, left tail, contact, right tail, right head. Head and tail of a bore are equal.
    pub fn waves(&self) -> [f64; 5] {
        let celerity = |h: f64| (self.gravity * h).sqrt();
        let side = |side: usize, sign: f64| {
            let (h, star) = (self.depths[side], self.contact_depths[side]);
            if star > h {
                let speed = self.velocity * star / (star - h);
                [speed, speed]
            } else {
                [sign * celerity(h), self.velocity + sign * celerity(star)]
            }
        };
        let ([left, left_tail], [right, right_tail]) = (side(0, -1.0), side(1, 1.0));
        [left, left_tail, self.velocity, right_tail, right]
    }

    /// Depth and velocity at `x` (m) after `t` (s), before any reflection.
    pub fn state_at(&self, x: f64, t: f64) -> (f64, f64) {
        let (place, [left, left_tail, contact, right_tail, right]) = (x / t, self.waves());
        let fan = |side: usize, sign: f64| {
            let celerity = (self.gravity * self.depths[side]).sqrt();
            let own = (2.0 * celerity + sign * place) / 3.0;
            (own * own / self.gravity, 2.0 / 3.0 * (place - sign * celerity))
        };
        if place < left {
            (self.depths[0], 0.0)
        } else if place < left_tail {
            fan(0, -1.0)
        } else if place < contact {
            (self.contact_depths[0], self.velocity)
        } else if place < right_tail {
            (self.contact_depths[1], self.velocity)
        } else if place < right {
            fan(1, 1.0)
        } else {
            (self.depths[1], 0.0)
        }
    }
}

/// Parabolic cap of Savage and Hutter, released on an incline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParabolicCap {
    /// Half of the initial length (m).
    pub half_length: f64,
    /// Area of the cap (m²).
    pub area: f64,
    /// Gravity normal to the bed (m/s²).
    pub gravity: f64,
    /// Earth-pressure coefficient.
    pub coefficient: f64,
}

impl ParabolicCap {
    /// Half of the length (m) and its growth rate (m/s) after `t` (s).
    pub fn half_length(&self, t: f64) -> (f64, f64) {
        let strength = 1.5 * self.coefficient * self.gravity * self.area;
        let first = self.half_length;
        let time = |l: f64| {
            let root = (l * (l - first)).sqrt();
            let log = ((l.sqrt() + (l - first).sqrt()) / first.sqrt()).ln();
            (first / (2.0 * strength)).sqrt() * (root + first * log)
        };
        let largest = first + t * (2.0 * strength / first).sqrt() + 1e-9;
        let half = root(first, largest, |l| time(l) - t);
        (half, (2.0 * strength * (1.0 / first - 1.0 / half).max(0.0)).sqrt())
    }

    /// Depth (m) at a distance from the middle (m) when half of the length is `half` (m).
    pub fn depth(&self, half: f64, from_middle: f64) -> f64 {
        let xi = from_middle / half;
        0.75 * self.area / half * (1.0 - xi * xi).max(0.0)
    }
}

/// Speeds of the four waves of a two-phase flow (m/s), the roots of the characteristic equation (sheet: depth-sph §2.5, property 4).
/// `heights` (m) and `velocities` (m/s) list the grains first. `None` if two speeds are complex.
pub fn wave_speeds(gravity: f64, heights: [f64; 2], velocities: [f64; 2], ratio: f64) -> Option<[f64; 4]> {
    let [hs, hw] = heights;
    let a = gravity * (hs + 0.5 * (1.0 - ratio) * hw);
    let b = gravity * hw;
    let c = gravity * gravity * 0.5 * (1.0 + ratio) * hs * hw;
    let equation = |l: f64| ((l - velocities[0]).powi(2) - a) * ((l - velocities[1]).powi(2) - b) - c;
    // All real roots lie within these speeds; between them signs change at most four times.
    let largest = velocities[0].abs().max(velocities[1].abs()) + 2.0 * (a + b + c.sqrt()).sqrt();
    let count = 4000;
    let place = |k: i32| largest * (2.0 * f64::from(k) / f64::from(count) - 1.0);
    let mut roots = Vec::new();
    for k in 0..count {
        let (low, high) = (place(k), place(k + 1));
        if (equation(low) > 0.0) != (equation(high) > 0.0) {
            roots.push(root(low, high, equation));
        }
    }
    <[f64; 4]>::try_from(roots).ok()
}

#[cfg(test)]
mod tests {
    use colluvium_testkit::assert_near;

    use super::*;

    #[test]
    fn stoker_has_the_values_of_the_sheet() {
        let table = [
            (10.0, 5.0, 7.269_204, 2.919_933, 9.353_758),
            (10.0, 1.0, 3.961_748, 7.340_769, 9.819_295),
            (1.0, 0.1, 0.396_175, 2.321_355, 3.105_134),
        ];
        for (left, right, depth, velocity, bore) in table {
            let found = Stoker::new(9.81, left, right);
            assert_near(found.depth, depth, 1e-6);
            assert_near(found.velocity, velocity, 1e-6);
            assert_near(found.bore_speed, bore, 1e-6);
        }
        let (depth, speed) = Stoker::new(9.81, 1.0, 0.5).reflected();
        assert_near(depth, 0.997_260, 1e-6);
        assert_near(speed, -2.482_847, 1e-6);
    }

    /// V19.
    #[test]
    fn locked_dam_has_the_values_of_the_sheet() {
        let dam = LockedDam::new(9.81, [1360.0 / 1.04, 2220.0 / 1.38], [1.04, 1.38]);
        assert_near(dam.pressure, 10_291.853, 1e-3);
        assert_near(dam.velocity, -0.664_381, 1e-6);
        assert_near(dam.contact_depths[0], 1.266_702, 1e-6);
        assert_near(dam.contact_depths[1], 1.142_064, 1e-6);
        let [bore, tail, contact, right_tail, head] = dam.waves();
        assert_near(bore, -3.712_238, 1e-6);
        assert_eq!((tail, contact), (bore, dam.velocity));
        assert_near(right_tail, 2.682_804, 1e-6);
        assert_near(head, 3.679_375, 1e-6);
    }

    #[test]
    fn cap_and_frictional_dam_have_the_values_of_the_sheet() {
        let cap = ParabolicCap { half_length: 10.0, area: 80.0 / 3.0, gravity: 8.035_882, coefficient: 1.0 };
        for (t, half, speed) in [(1.0, 11.529_904, 2.920_660), (5.0, 33.418_348, 6.711_930)] {
            let found = cap.half_length(t);
            assert_near(found.0, half, 1e-5);
            assert_near(found.1, speed, 1e-5);
        }
        let gravity = 9.81 * 22f64.to_radians().cos();
        let driving_acceleration = gravity * (22f64.to_radians().tan() - 12f64.to_radians().tan());
        let (h, u) = frictional_dam_break(gravity, 10.0, driving_acceleration, 10.0, 2.0);
        assert_near(h, 3.055_66, 1e-5);
        assert_near(u, 12.013_48, 1e-5);
    }

    /// V18 and V18b.
    #[test]
    fn speeds_of_two_phases_have_the_values_of_the_sheet() {
        let rest = wave_speeds(9.81, [0.6, 0.4], [0.0, 0.0], 0.4).unwrap();
        assert_near(rest[3], 3.132_092, 1e-6);
        assert_near(rest[2], 1.084_988, 1e-6);
        let slip = wave_speeds(9.81, [0.6, 0.4], [0.0, 0.5], 0.4).unwrap();
        for (found, exact) in slip.iter().zip([-3.000_659, -0.708_299, 1.384_525, 3.324_432]) {
            assert_near(*found, exact, 1e-6);
        }
        assert_eq!(wave_speeds(9.81, [0.6, 0.4], [0.0, 2.5], 0.4), None);
    }
}
