//! Search for the preparation friction that gives a porosity (sheet: dem §3.8).

use colluvium_constitutive::MaterialError;

use crate::material::spec::parameter_error;

/// Largest friction coefficient of the search; higher ones hardly increase the porosity (sheet: dem §5, B14).
const MAX_FRICTION: f64 = 1.0;
/// Tolerance of the porosity of the specimen (-).
const POROSITY_TOLERANCE: f64 = 2e-3;
/// Number of bisections of the friction interval.
const HALVINGS: usize = 12;

/// Result of `prepare` with the friction coefficient whose porosity is closest to the target, by bisection. Porosity increases with the
/// friction during compression.
///
/// # Errors
/// When no friction gives a porosity near the target, with the porosities found; when a specimen cannot be prepared.
pub fn friction<T>(
    target: f64,
    prepare: impl Fn(f64) -> Result<T, MaterialError>,
    porosity: impl Fn(&T) -> f64,
) -> Result<T, MaterialError> {
    let (mut low, mut high) = (0.0, MAX_FRICTION);
    let ends = (prepare(low)?, prepare(high)?);
    let (smallest, largest) = (porosity(&ends.0), porosity(&ends.1));
    if target < smallest - POROSITY_TOLERANCE || target > largest + POROSITY_TOLERANCE {
        let rule = format!(
            "{target} is not between {smallest:.4}, the porosity after compression without friction, and {largest:.4}, with a friction of {MAX_FRICTION}"
        );
        return Err(parameter_error("preparation.porosity", rule));
    }
    let error = |result: &T| (porosity(result) - target).abs();
    let mut nearest = if error(&ends.0) <= error(&ends.1) { ends.0 } else { ends.1 };
    for _ in 0..HALVINGS {
        if error(&nearest) <= POROSITY_TOLERANCE {
            return Ok(nearest);
        }
        let middle = 0.5 * (low + high);
        let result = prepare(middle)?;
        if porosity(&result) < target {
            low = middle;
        } else {
            high = middle;
        }
        if error(&result) < error(&nearest) {
            nearest = result;
        }
    }
    let rule = format!(
        "{target} is not reached: the nearest porosity of these grains is {:.4}; use more grains or another seed",
        porosity(&nearest)
    );
    Err(parameter_error("preparation.porosity", rule))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_friction_of_a_porosity_is_found_within_its_bounds() {
        // Porosities as a closed form of the friction.
        let of = |friction: f64| 0.16 + 0.04 * friction.sqrt();
        for requested in [0.16, 0.171, 0.19, 0.2, 0.2015] {
            let found = friction(requested, Ok, |found| of(*found)).unwrap();
            assert!((of(found) - requested).abs() <= POROSITY_TOLERANCE, "{requested}: {found}");
        }
        for requested in [0.15, 0.21] {
            let refusal = friction(requested, Ok, |found| of(*found)).unwrap_err().to_string();
            assert!(
                refusal.contains("is not between 0.1600, the porosity")
                    && refusal.contains("and 0.2000, with"),
                "{refusal}"
            );
        }
        // A porosity that jumps across the target.
        let jumps = |friction: &f64| if *friction < 0.3 { 0.16 } else { 0.2 };
        let refusal = friction(0.18, Ok, jumps).unwrap_err().to_string();
        assert!(refusal.contains("the nearest porosity of these grains is "), "{refusal}");
        let stuck = |_: f64| Err::<f64, _>(MaterialError::NotConverged { model: "m", reason: "r" });
        assert!(friction(0.18, stuck, |found| *found).is_err());
    }
}
