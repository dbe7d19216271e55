//! Units in the heads of columns, such as `m`, `kN/m²` or `l s-1`.

use std::f64::consts::{PI, TAU};

/// Physical quantity of a column, by the powers of length, mass and time in its unit. Units of spaces with fewer dimensions are valid too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Length (m).
    Length,
    /// Time (s).
    Time,
    /// Discharge (m³/s; m²/s in a profile).
    Discharge,
    /// Velocity (m/s).
    Velocity,
    /// Angular velocity (rad/s).
    AngularVelocity,
    /// Stress (Pa).
    Stress,
    /// Mass (kg; kg/m in plane strain, kg/rad in axisymmetry).
    Mass,
    /// Volume (m³; m² in the plane, m in one dimension).
    Volume,
    /// Ratio (-): strain, void ratio, saturation.
    Ratio,
    /// Angle (rad).
    Angle,
    /// Energy per volume (J/m³).
    EnergyDensity,
    /// Number without a unit, or text.
    Dimensionless,
}

impl Quantity {
    /// Powers of length, mass and time, and the unit as text.
    fn units(self) -> (&'static [[i32; 3]], &'static str) {
        match self {
            Self::Length => (&[[1, 0, 0]], "a length, as m, mm or ft"),
            Self::Time => (&[[0, 0, 1]], "a time, as s, min or h"),
            Self::Discharge => (&[[3, 0, -1], [2, 0, -1]], "a discharge, as m3/s or l/s"),
            Self::Velocity => (&[[1, 0, -1]], "a velocity, as m/s or km/h"),
            Self::AngularVelocity => (&[[0, 0, -1]], "an angular velocity, as rad/s or rpm"),
            Self::Stress => (&[[-1, 1, -2]], "a stress, as Pa, kPa or kN/m2"),
            Self::Mass => (&[[0, 1, 0], [-1, 1, 0]], "a mass, as kg or t"),
            Self::Volume => (&[[3, 0, 0], [2, 0, 0], [1, 0, 0]], "a volume, as m3 or cm3"),
            Self::Ratio => (&[[0, 0, 0]], "a ratio, as % or -"),
            Self::Angle => (&[[0, 0, 0]], "an angle, as rad or deg"),
            Self::EnergyDensity => (&[[-1, 1, -2]], "an energy per volume, as J/m3 or kJ/m3"),
            Self::Dimensionless => (&[], ""),
        }
    }

    /// Factor to SI units of numbers in `unit`; `None` where it is no known unit of the quantity.
    pub(super) fn known_factor(self, unit: &str) -> Option<f64> {
        let powers = self.units().0;
        parse(unit)
            .filter(|parsed| powers.contains(&parsed.powers) && unit != "in" && self.fits_angle(unit))
            .map(|parsed| parsed.factor)
    }

    /// Whether a unit is an angle exactly if the quantity is; angles and ratios have equal powers.
    fn fits_angle(self, unit: &str) -> bool {
        let angle = ["rad", "deg", "°"].into_iter().any(|name| unit.to_lowercase().contains(name));
        match self {
            Self::Angle => angle,
            Self::Ratio => !angle,
            _ => true,
        }
    }

    /// Factor to SI units of numbers in `unit`.
    ///
    /// # Errors
    /// When a unit is unknown, or of another quantity, as a text.
    pub(super) fn factor(self, unit: &str) -> Result<f64, String> {
        let (powers, words) = self.units();
        if powers.is_empty() {
            return Ok(1.0);
        }
        match parse(unit) {
            Some(parsed) if powers.contains(&parsed.powers) && self.fits_angle(unit) => Ok(parsed.factor),
            _ => Err(format!("the unit must be one of {words}; without any, numbers are in SI units")),
        }
    }
}

/// Unit: its size in SI units, and its powers of length, mass and time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Unit {
    factor: f64,
    powers: [i32; 3],
}

impl Unit {
    /// Unit of numbers without dimension.
    const DIMENSIONLESS: Self = Self { factor: 1.0, powers: [0; 3] };

    /// Product of this unit and a power of another.
    fn times(self, other: Self, power: i32) -> Self {
        Self {
            factor: self.factor * other.factor.powi(power),
            powers: std::array::from_fn(|k| self.powers[k] + power * other.powers[k]),
        }
    }
}

/// Whether a word is a unit.
pub(super) fn is_known(word: &str) -> bool {
    word == "%" || parse(word).is_some_and(|unit| unit.powers != [0; 3])
}

/// Unit of a text; `None` where it is unknown.
fn parse(text: &str) -> Option<Unit> {
    let plain = text
        .replace('²', "2")
        .replace('³', "3")
        .replace("⁻¹", "-1")
        .replace("⁻²", "-2")
        .replace(['^', '{', '}'], "")
        .replace("**", "")
        .replace(['·', '*', '×', '⋅'], " ");
    let mut unit = Unit::DIMENSIONLESS;
    for (number, part) in plain.split('/').enumerate() {
        let mut words = part.split_whitespace();
        let sign = if number == 0 { 1 } else { -1 };
        // In `m3/s m` the last word is in the numerator.
        let first = words.next()?;
        unit = multiply_by_word(first, unit, sign)?;
        for word in words {
            unit = multiply_by_word(word, unit, 1)?;
        }
    }
    Some(unit)
}

/// Multiplies `unit` by the unit of a word with its exponent, such as `m`, `s-1` or `m3`. Divides by it where `sign` is -1. `None` for an
/// unknown word.
fn multiply_by_word(word: &str, unit: Unit, sign: i32) -> Option<Unit> {
    if word == "1" || word == "-" {
        return Some(unit);
    }
    let end = word.find(|c: char| c.is_ascii_digit() || c == '-').unwrap_or(word.len());
    let power = if end == word.len() { 1 } else { word[end..].parse::<i32>().ok()? };
    (1..=9).contains(&power.abs()).then_some(())?;
    Some(unit.times(unit_by_name(&word[..end])?, sign * power))
}

/// Unit with a name or symbol; `None` for an unknown one.
fn unit_by_name(word: &str) -> Option<Unit> {
    let of = |factor: f64, powers: [i32; 3]| Some(Unit { factor, powers });
    let (length, time, mass) = ([1, 0, 0], [0, 0, 1], [0, 1, 0]);
    let (force, stress, volume) = ([1, 1, -2], [-1, 1, -2], [3, 0, 0]);
    match word {
        "mm" => return of(1e-3, length),
        "Mg" => return of(1e3, mass),
        "mg" => return of(1e-6, mass),
        "MN" => return of(1e6, force),
        "MPa" => return of(1e6, stress),
        _ => {}
    }
    match word.to_lowercase().as_str() {
        "m" | "metre" | "metres" | "meter" | "meters" => of(1.0, length),
        "km" => of(1e3, length),
        "dm" => of(0.1, length),
        "cm" => of(0.01, length),
        "mm" => of(1e-3, length),
        "um" | "µm" | "μm" => of(1e-6, length),
        "ft" | "foot" | "feet" => of(0.3048, length),
        "in" | "inch" | "inches" => of(0.0254, length),
        "s" | "sec" | "secs" | "second" | "seconds" => of(1.0, time),
        "ms" => of(1e-3, time),
        "min" | "mins" | "minute" | "minutes" => of(60.0, time),
        "h" | "hr" | "hrs" | "hour" | "hours" => of(3600.0, time),
        "d" | "day" | "days" => of(86_400.0, time),
        "kg" => of(1.0, mass),
        "g" => of(1e-3, mass),
        "t" | "tonne" | "tonnes" => of(1e3, mass),
        "n" => of(1.0, force),
        "kn" => of(1e3, force),
        "pa" => of(1.0, stress),
        "hpa" | "mbar" => of(100.0, stress),
        "kpa" => of(1e3, stress),
        "bar" => of(1e5, stress),
        "gpa" => of(1e9, stress),
        "psi" => of(6_894.757_293_168, stress),
        "l" | "litre" | "litres" | "liter" | "liters" => of(1e-3, volume),
        "ml" => of(1e-6, volume),
        "j" => of(1.0, [2, 1, -2]),
        "kj" => of(1e3, [2, 1, -2]),
        "%" | "percent" => of(0.01, [0; 3]),
        "rad" => of(1.0, [0; 3]),
        "deg" | "°" => of(PI / 180.0, [0; 3]),
        "rpm" => of(TAU / 60.0, [0, 0, -1]),
        "cfs" => of(0.3048f64.powi(3), [3, 0, -1]),
        "cumec" | "cumecs" => of(1.0, [3, 0, -1]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn column_units_are_accepted_in_their_usual_spellings() {
        use Quantity::{
            Angle, AngularVelocity, Dimensionless, Discharge, EnergyDensity, Length, Mass, Ratio, Stress,
            Time, Velocity, Volume,
        };
        for (quantity, unit, factor) in [
            (Length, "mm", 1e-3),
            (Length, "M", 1.0),
            (Time, "h", 3600.0),
            (Time, "min", 60.0),
            (Discharge, "m3/s", 1.0),
            (Discharge, "m³ s⁻¹", 1.0),
            (Discharge, "l/min", 1e-3 / 60.0),
            (Discharge, "m^2/h", 1.0 / 3600.0),
            (Discharge, "m³/s/m", 1.0),
            (Velocity, "km/h", 1.0 / 3.6),
            (Stress, "kPa", 1e3),
            (Stress, "kN/m²", 1e3),
            (Stress, "N/mm2", 1e6),
            (Stress, "MPa", 1e6),
            (Mass, "t", 1e3),
            (Mass, "kg/m", 1.0),
            (Mass, "kg/rad", 1.0),
            (Volume, "cm3", 1e-6),
            (Volume, "m2", 1.0),
            (Volume, "l", 1e-3),
            (AngularVelocity, "1/s", 1.0),
            (AngularVelocity, "rpm", TAU / 60.0),
            (AngularVelocity, "deg/s", PI / 180.0),
            (Ratio, "%", 0.01),
            (Ratio, "-", 1.0),
            (Ratio, "mm/m", 1e-3),
            (Angle, "deg", PI / 180.0),
            (EnergyDensity, "kJ/m³", 1e3),
            (Dimensionless, "anything", 1.0),
        ] {
            let found = quantity.factor(unit).unwrap();
            assert!((found / factor - 1.0).abs() < 1e-12, "{unit}: {found}");
        }
        for (quantity, unit) in [
            (Length, "s"),
            (Length, "east"),
            (Time, "m3/s"),
            (Stress, "kN/m3"),
            (Discharge, "m3"),
            (Time, ""),
            (Length, "m99"),
            (Ratio, "deg"),
            (Ratio, "kPa"),
            (Angle, "%"),
        ] {
            assert!(quantity.factor(unit).is_err(), "{unit}");
        }
        assert!(Length.factor("yards").unwrap_err().contains("a length, as m, mm or ft"));
    }
}
