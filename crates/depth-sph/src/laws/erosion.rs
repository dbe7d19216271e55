//! Erosion of the bed: rates of entrainment (sheet: depth-sph §2.8).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Law of the bed's erosion rate `e_R` (m/s).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Erosion {
    /// Hungr: `e_R = E_s h |v|`, with the speed along the bed.
    Hungr {
        /// Growth rate `E_s` (1/m), 0 to 0.1.
        rate: f64,
        /// Whether the speed is in plan.
        #[serde(default)]
        plan_speed: bool,
    },
    /// Blanc and Pastor: `e_R = K (tan θ)^2.5 h |v|`.
    BlancPastor {
        /// Coefficient `K` (1/m), 0 to 1.
        coefficient: f64,
    },
    /// Egashira: `e_R = |v| tan(θ - θ_e)`; deposition (negative rates) is omitted.
    Egashira {
        /// Bed friction angle (degrees), non-negative, below 90.
        friction_angle: f64,
    },
    /// Prescribed rate of moving nodes.
    Prescribed {
        /// Erosion rate `e_R` (m/s), non-negative.
        rate: f64,
    },
}

impl Erosion {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The name of the first parameter that is out of range, and the reason.
    pub fn validate(&self) -> Result<(), (&'static str, String)> {
        let within = |name: &'static str, value: f64, high: f64, rule: &str| {
            if (0.0..=high).contains(&value) { Ok(()) } else { Err((name, format!("{value} {rule}"))) }
        };
        match *self {
            Self::Hungr { rate, .. } => within(
                "rate",
                rate,
                0.1,
                "is not in 0..=0.1 1/m (it is a rate per metre of path, not per second)",
            ),
            Self::BlancPastor { coefficient } => {
                within("coefficient", coefficient, 1.0, "is not in 0..=1 1/m")
            }
            Self::Egashira { friction_angle } => {
                within("friction_angle", friction_angle, 89.999, "is not in 0..90 degrees")
            }
            Self::Prescribed { rate } => within("rate", rate, f64::MAX, "must not be negative (m/s)"),
        }
    }

    /// Relative growth of the volume of a node by erosion in a step, exact for Hungr's law without other forces. `speeds` are those along
    /// the bed and in plan (m/s), `tangent` the slope and `depth` the vertical depth (m). `concentration` is `(1 - n)(ρ_s - ρ_w)` over the
    /// sum of this and `ρ_w`.
    #[inline]
    pub fn growth(&self, speeds: [f64; 2], tangent: f64, depth: f64, concentration: f64, dt: f64) -> f64 {
        let [speed, plan] = speeds;
        match *self {
            Self::Hungr { rate, plan_speed } => rate * if plan_speed { plan } else { speed } * dt,
            Self::BlancPastor { coefficient } => coefficient * tangent.powf(2.5) * speed * dt,
            Self::Egashira { friction_angle } => {
                let balance = (concentration * friction_angle.to_radians().tan()).atan();
                speed * (tangent.atan() - balance).tan().max(0.0) / depth * dt
            }
            // At rest nothing is eroded.
            Self::Prescribed { rate } if speed > 0.0 => rate / depth * dt,
            Self::Prescribed { .. } => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// V24: a block without other forces, in any step.
    #[test]
    fn an_eroding_block_slows_down_exactly() {
        let law = Erosion::Hungr { rate: 0.0011, plan_speed: false };
        for (time, exact) in [(10.0, [94.872_741, 1.11, 9.009_009]), (50.0, [398.413_574, 1.55, 6.451_613])] {
            for steps in [1, 10, 1000] {
                let (mut mass, mut speed, mut path) = (1.0, 10.0f64, 0.0);
                let dt = time / f64::from(steps);
                for _ in 0..steps {
                    let growth = law.growth([speed, speed], 0.0, 1.0, 0.0, dt);
                    path += growth.ln_1p() / 0.0011;
                    mass *= 1.0 + growth;
                    speed /= 1.0 + growth;
                }
                let found = [path, mass, speed];
                for (found, exact) in found.iter().zip(exact) {
                    assert!((found / exact - 1.0).abs() < 1e-6, "{steps} steps: {found} for {exact}");
                }
            }
        }
    }

    #[test]
    fn an_erosion_rate_per_second_is_refused_with_the_unit_per_metre() {
        let (name, problem) = Erosion::Hungr { rate: 1.1, plan_speed: false }.validate().unwrap_err();
        assert_eq!(name, "rate");
        assert!(problem.contains("per metre"), "{problem}");
    }

    /// Rates of the other laws, `e_R = growth h / dt`, against their formulas evaluated by hand.
    #[test]
    fn erosion_rates_of_other_laws_follow_their_formulas() {
        let (depth, dt) = (2.0, 0.01);
        let rate = |law: Erosion, speed: f64, tangent: f64, concentration: f64| {
            law.growth([speed, speed], tangent, depth, concentration, dt) * depth / dt
        };
        let near = |found: f64, exact: f64| assert!((found - exact).abs() < 1e-12, "{found} for {exact}");
        // (tan θ)^2.5 = 0.25^2.5 = 1/32.
        near(rate(Erosion::BlancPastor { coefficient: 0.016 }, 5.0, 0.25, 0.0), 0.016 / 32.0 * 2.0 * 5.0);
        // n = 0.4, 2650 and 1000 kg/m³: 990 over 1990. Differences of angles by tan(a - b) = (a - b)/(1 + a b).
        let egashira = Erosion::Egashira { friction_angle: 45.0 };
        let balance = 990.0 / 1990.0;
        near(rate(egashira, 3.0, 0.75, balance), 3.0 * (0.75 - balance) / (1.0 + 0.75 * balance));
        near(rate(egashira, 3.0, balance, balance), 0.0);
        near(rate(egashira, 3.0, 0.2, balance), 0.0);
        let prescribed = Erosion::Prescribed { rate: 0.05 };
        near(rate(prescribed, 4.0, 0.3, 0.0), 0.05);
        near(rate(prescribed, 0.0, 0.3, 0.0), 0.0);
    }
}
