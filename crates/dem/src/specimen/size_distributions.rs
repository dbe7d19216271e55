//! Size distributions of grains, by grading curves (sheet: dem §3.8).

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::config::Diameters;

/// Largest number of draws for a grain of a cumulative beta distribution.
const DRAWS: usize = 1_000_000;

/// Ratio of largest to smallest diameter, to the power of the dimension, above which sizes are not drawn by rejection.
const MAX_REJECTION_RATIO: f64 = 1000.0;

/// Number of cells of the table for wider distributions, each with an equal ratio of diameters.
const CELLS: usize = 4096;

/// Smallest number of grains that represents a size class (sheet: dem §3.8).
const MIN_GRAINS_IN_CLASS: usize = 5;

/// Regularised incomplete beta function `I_x(a, b)`, by its continued fraction (Lentz).
pub fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let front = (a * x.ln() + b * (1.0 - x).ln() - log_beta(a, b)).exp() / a;
    let tiny = 1e-300;
    let (mut c, mut d) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)));
    let mut sum = d;
    for m in 1..300 {
        let k = f64::from(m);
        let even = k * (b - k) * x / ((a + 2.0 * k - 1.0) * (a + 2.0 * k));
        let odd = -(a + k) * (a + b + k) * x / ((a + 2.0 * k) * (a + 2.0 * k + 1.0));
        let before = sum;
        for term in [even, odd] {
            d = 1.0 / (1.0 + term * d).max(tiny);
            c = (1.0 + term / c).max(tiny);
            sum *= c * d;
        }
        if (sum / before - 1.0).abs() < 1e-16 {
            break;
        }
    }
    front * sum
}

/// Logarithm of the beta function `B(a, b)`.
fn log_beta(a: f64, b: f64) -> f64 {
    log_gamma(a) + log_gamma(b) - log_gamma(a + b)
}

/// Gamma function of a positive number.
pub fn gamma(x: f64) -> f64 {
    log_gamma(x).exp()
}

/// Logarithm of the gamma function of a positive number (Lanczos).
fn log_gamma(x: f64) -> f64 {
    /// Coefficients of the Lanczos approximation of the gamma function.
    const COEFFICIENTS: [f64; 8] = [
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    if x < 0.5 {
        return (std::f64::consts::PI / (std::f64::consts::PI * x).sin()).ln() - log_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let sum = COEFFICIENTS
        .iter()
        .enumerate()
        .fold(0.999_999_999_999_809_9, |sum, (k, c)| sum + c / (x + k as f64 + 1.0));
    let t = x + 7.5;
    0.5 * (2.0 * std::f64::consts::PI).ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

impl Diameters {
    /// Smallest and largest diameter (m).
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Equal { value } => (*value, *value),
            Self::Uniform { min, max }
            | Self::EqualMass { min, max }
            | Self::CumulativeBeta { min, max, .. } => (*min, *max),
            Self::Curve { diameters, .. } => (
                diameters.first().copied().unwrap_or(f64::NAN),
                diameters.last().copied().unwrap_or(f64::NAN),
            ),
        }
    }

    /// Invalid key of the distribution, with its problem.
    pub fn problem(&self) -> Option<(&'static str, String)> {
        let (min, max) = self.range();
        let length = |value: f64| value.is_finite() && value > 0.0;
        if !length(min) {
            let key = if matches!(self, Self::Equal { .. }) { "value" } else { "min" };
            return Some((key, format!("{min} must be finite and positive (m)")));
        }
        if !(max.is_finite() && max >= min) {
            return Some(("max", format!("{max} must be finite and at least the smallest, {min} (m)")));
        }
        match self {
            Self::CumulativeBeta { a, .. } if !length(*a) => Some(("a", format!("{a} must be positive"))),
            Self::CumulativeBeta { b, .. } if !length(*b) => Some(("b", format!("{b} must be positive"))),
            Self::CumulativeBeta { classes: Some(0), .. } => {
                Some(("classes", "0 must be at least 1".to_owned()))
            }
            Self::Curve { diameters, passing } => {
                let rises = |values: &[f64]| values.windows(2).all(|pair| pair[0] <= pair[1]);
                let ends = passing.first() == Some(&0.0) && passing.last() == Some(&1.0);
                if diameters.len() != passing.len() || diameters.len() < 2 {
                    let problem = "must have as many entries as diameters, at least two";
                    return Some(("passing", problem.to_owned()));
                }
                (!rises(diameters) || !rises(passing) || !ends)
                    .then(|| ("passing", "diameters and passing must ascend, passing from 0 to 1".to_owned()))
            }
            _ => None,
        }
    }

    /// Mean of a power of the diameter by number, in `dimension` dimensions, by quadrature over mass.
    pub fn mean_power(&self, dimension: usize, power: i32) -> f64 {
        let (min, max) = self.range();
        if min == max {
            return min.powi(power);
        }
        let cells = 20_000;
        let (mut top, mut bottom) = (0.0, 0.0);
        for k in 0..cells {
            let from = min + (max - min) * f64::from(k) / f64::from(cells);
            let to = min + (max - min) * f64::from(k + 1) / f64::from(cells);
            let middle = 0.5 * (from + to);
            let number = match self {
                Self::Uniform { .. } => 1.0,
                _ => {
                    (self.mass_fraction_below(to) - self.mass_fraction_below(from))
                        / middle.powi(dimension as i32)
                }
            };
            top += number * middle.powi(power);
            bottom += number;
        }
        top / bottom
    }

    /// Mass fraction of grains smaller than a diameter (m); not defined for distributions by number.
    pub fn mass_fraction_below(&self, diameter: f64) -> f64 {
        let (min, max) = self.range();
        let place = ((diameter - min) / (max - min)).clamp(0.0, 1.0);
        match self {
            Self::CumulativeBeta { a, b, .. } => incomplete_beta(*a, *b, place),
            Self::Curve { diameters, passing } => {
                let after = diameters.partition_point(|d| *d < diameter).clamp(1, diameters.len() - 1);
                let (d, p) = (&diameters[after - 1..=after], &passing[after - 1..=after]);
                let share =
                    if d[1] > d[0] { ((diameter - d[0]) / (d[1] - d[0])).clamp(0.0, 1.0) } else { 1.0 };
                p[0] + share * (p[1] - p[0])
            }
            _ => place,
        }
    }

    /// Random diameter of the distribution (m).
    pub fn draw(&self, dimension: usize, random: &mut ChaCha8Rng) -> f64 {
        let (min, max) = self.range();
        if min == max {
            return min;
        }
        match self {
            Self::Equal { value } => *value,
            Self::Uniform { .. } => min + (max - min) * random.random::<f64>(),
            Self::EqualMass { .. } => {
                let z: f64 = random.random();
                if dimension == 2 {
                    min * max / (max - z * (max - min))
                } else {
                    (min.powi(-2) - z * (min.powi(-2) - max.powi(-2))).powf(-0.5)
                }
            }
            // By rejection: numbers are proportional to mass over volume.
            Self::CumulativeBeta { .. } | Self::Curve { .. } => {
                for _ in 0..DRAWS {
                    let diameter = self.diameter_at_mass(random.random());
                    if random.random::<f64>() < (min / diameter).powi(dimension as i32) {
                        return diameter;
                    }
                }
                min
            }
        }
    }

    /// Random diameters (m) of a wide distribution by mass, `count` in number. The number in each interval is proportional to mass over
    /// volume.
    fn draw_wide(&self, count: usize, dimension: usize, random: &mut ChaCha8Rng) -> Vec<f64> {
        let (min, max) = self.range();
        let edge = |cell: usize| min * (max / min).powf(cell as f64 / CELLS as f64);
        let mut numbers = Vec::with_capacity(CELLS);
        let mut total = 0.0;
        for cell in 0..CELLS {
            let (from, to) = (edge(cell), edge(cell + 1));
            // Over the largest diameter, so that no power overflows or underflows double precision.
            let middle = 0.5 * (from + to) / max;
            total += (self.mass_fraction_below(to) - self.mass_fraction_below(from)).max(0.0)
                / middle.powi(dimension as i32);
            numbers.push(total);
        }
        let one = |_| {
            let number = random.random::<f64>() * total;
            let cell = numbers.partition_point(|sum| *sum <= number).min(CELLS - 1);
            edge(cell) + (edge(cell + 1) - edge(cell)) * random.random::<f64>()
        };
        (0..count).map(one).collect()
    }

    /// Diameter below which a fraction of the mass lies (m).
    fn diameter_at_mass(&self, share: f64) -> f64 {
        let (mut low, mut high) = self.range();
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.mass_fraction_below(middle) < share { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// Random diameters (m), `count` in number, by classes if the distribution has them.
    ///
    /// # Errors
    /// When a class has too few grains.
    pub fn sample(
        &self,
        count: usize,
        dimension: usize,
        random: &mut ChaCha8Rng,
    ) -> Result<Vec<f64>, String> {
        let Self::CumulativeBeta { min, max, classes: Some(classes), .. } = self else {
            let (min, max) = self.range();
            let by_mass = matches!(self, Self::CumulativeBeta { .. } | Self::Curve { .. });
            if by_mass && (max / min).powi(dimension as i32) > MAX_REJECTION_RATIO {
                return Ok(self.draw_wide(count, dimension, random));
            }
            return Ok((0..count).map(|_| self.draw(dimension, random)).collect());
        };
        let edge = |k: usize| min + (max - min) * k as f64 / *classes as f64;
        let weight = |k: usize| {
            let middle = 0.5 * (edge(k) + edge(k + 1));
            (self.mass_fraction_below(edge(k + 1)) - self.mass_fraction_below(edge(k)))
                / middle.powi(dimension as i32)
        };
        let weights: Vec<f64> = (0..*classes).map(weight).collect();
        let total: f64 = weights.iter().sum();
        let shares: Vec<f64> = weights.iter().map(|w| w / total * count as f64).collect();
        let mut numbers: Vec<usize> = shares.iter().map(|share| share.floor() as usize).collect();
        let mut order: Vec<usize> = (0..*classes).collect();
        order.sort_by(|&a, &b| (shares[b] % 1.0).total_cmp(&(shares[a] % 1.0)).then(a.cmp(&b)));
        let missing = count - numbers.iter().sum::<usize>();
        order.iter().take(missing).for_each(|&class| numbers[class] += 1);
        if let Some(class) = numbers.iter().position(|number| *number < MIN_GRAINS_IN_CLASS) {
            return Err(format!(
                "{count} grains give {} in the class from {:.4e} to {:.4e} m, but {MIN_GRAINS_IN_CLASS} are \
                 needed: use fewer classes or more grains",
                numbers[class],
                edge(class),
                edge(class + 1)
            ));
        }
        let mut all: Vec<f64> = Vec::with_capacity(count);
        for (class, number) in numbers.iter().enumerate() {
            all.extend(
                (0..*number).map(|_| edge(class) + (edge(class + 1) - edge(class)) * random.random::<f64>()),
            );
        }
        // Sizes in random order, by the Fisher–Yates shuffle.
        for k in (1..all.len()).rev() {
            all.swap(k, random.random_range(0..=k));
        }
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    #[test]
    fn the_beta_function_has_the_values_of_the_sheet() {
        for (x, value) in [
            (0.1, 0.002_728),
            (0.2, 0.033_344),
            (0.25, 0.070_556_64),
            (0.3, 0.126_036),
            (0.4, 0.289_792),
            (0.5, 0.5),
            (0.75, 0.929_443_36),
            (0.9, 0.997_272),
        ] {
            assert!((incomplete_beta(4.0, 4.0, x) - value).abs() < 1e-8, "{x}");
        }
        assert!((incomplete_beta(2.0, 5.0, 0.25) - 0.466_064_45).abs() < 1e-8);
    }

    #[test]
    fn mean_diameters_by_number_are_those_of_the_sheet() {
        for (ratio, flat, solid) in [
            (1.5, 1.23879, 1.23317),
            (1.8, 1.37415, 1.36112),
            (2.0, 1.46204, 1.44286),
            (6.0, 3.04663, 2.80389),
        ] {
            let sizes = Diameters::CumulativeBeta { min: 1.0, max: ratio, a: 4.0, b: 4.0, classes: None };
            assert!((sizes.mean_power(2, 1) - flat).abs() < 2e-5);
            assert!((sizes.mean_power(3, 1) - solid).abs() < 2e-5);
        }
    }

    #[test]
    fn a_wide_sample_has_its_mean_by_number_and_its_grading_by_mass() {
        let sizes = Diameters::CumulativeBeta { min: 1.0, max: 40.0, a: 1.0, b: 1.0, classes: None };
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let sample = sizes.sample(200_000, 2, &mut random).unwrap();
        // Mass is uniform between 1 and 40: the number density is proportional to 1/d², its mean is ln 40 / (1 - 1/40).
        let mean = sample.iter().sum::<f64>() / sample.len() as f64;
        assert!((mean / (40f64.ln() / (1.0 - 1.0 / 40.0)) - 1.0).abs() < 0.01, "{mean}");
        let mass = |up_to: f64| sample.iter().filter(|d| **d < up_to).map(|d| d * d).sum::<f64>();
        for share in [0.25, 0.5, 0.75] {
            assert!((mass(1.0 + 39.0 * share) / mass(f64::INFINITY) - share).abs() < 0.02, "{share}");
        }
        assert!(sample.iter().all(|d| (1.0..=40.0).contains(d)));
    }

    #[test]
    fn a_sample_has_the_grading_curve_by_mass() {
        let sizes = Diameters::CumulativeBeta { min: 1.0, max: 2.0, a: 4.0, b: 4.0, classes: None };
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut sample = sizes.sample(10_000, 2, &mut random).unwrap();
        let mean = sample.iter().sum::<f64>() / 1e4;
        assert!((mean / 1.46204 - 1.0).abs() < 0.01);
        sample.sort_by(f64::total_cmp);
        let total: f64 = sample.iter().map(|d| d * d).sum();
        let mut mass = 0.0;
        let off = sample.iter().map(|d| {
            mass += d * d / total;
            (mass - incomplete_beta(4.0, 4.0, d - 1.0)).abs()
        });
        assert!(off.fold(0.0, f64::max) < 0.02);
    }

    #[test]
    fn classes_with_too_few_grains_are_refused() {
        let sizes = Diameters::CumulativeBeta { min: 1.0, max: 6.0, a: 4.0, b: 4.0, classes: Some(10) };
        let mut random = ChaCha8Rng::seed_from_u64(3);
        assert!(sizes.sample(200, 2, &mut random).unwrap_err().contains("are needed"));
        assert_eq!(sizes.sample(100_000, 2, &mut random).map(|all| all.len()), Ok(100_000));
    }
}
