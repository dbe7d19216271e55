//! Curves of an element test from the beginning of a stage, as in a laboratory record.

use thiserror::Error;

use crate::case::files::piecewise_linear::{non_ascending, value_at};
use crate::constitutive::SymTensor;
use crate::constitutive::driver::{DriverError, ElementPath, TestTrace};
use crate::fit::{DataFile, LaboratoryData, MeasuredCurve, MeasuredValue, short};

/// Columns that count from the beginning of the stage; strains do as well.
const INCREMENTAL: [&str; 5] =
    ["time", "volumetric_strain", "work", "dissipated_work", "excess_pore_pressure"];
/// Columns of the six components of strain.
const STRAINS: [&str; 6] = ["strain_xx", "strain_yy", "strain_zz", "strain_xy", "strain_yz", "strain_zx"];
/// Relative distance beyond the computed range that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Reason why a test cannot be compared with its data.
#[derive(Clone, Debug, PartialEq, Error)]
pub(super) enum TestFailure {
    /// Invalid description or parameters of the test.
    #[error(transparent)]
    Driver(DriverError),
    /// Test that stopped before the stage with which the data begin.
    #[error("the test ends before the stage {0} of its data")]
    MissingStage(usize),
    /// Abscissa that neither rises nor falls throughout.
    #[error(
        "{name} changes from {} to {} in row {row} after the beginning of the data, but must rise or fall throughout: choose another \
         column, such as time, or fewer stages",
        short(*.from),
        short(*.to)
    )]
    NotMonotone { name: String, row: usize, from: f64, to: f64 },
    /// Datum beyond the computed curve.
    #[error(
        "line {line} has {name} = {}, but the test is computed from {} to {}{}",
        short(*.value),
        short(*.from),
        short(*.to),
        stopped(.stop)
    )]
    OutOfRange { line: u64, name: String, value: f64, from: f64, to: f64, stop: Option<Box<DriverError>> },
    /// Computed value that is not finite.
    #[error("{name} is not a number at {}", short(*.at))]
    NotFinite { name: String, at: f64 },
}

/// Clause on the reason why a test stopped early.
fn stopped(stop: &Option<Box<DriverError>>) -> String {
    stop.as_ref().map_or_else(String::new, |reason| format!(" ({reason})"))
}

/// Computed curves of a test, from the beginning of the data's stage.
#[derive(Clone, Debug, PartialEq)]
pub struct StageCurves {
    /// Abscissae (SI units).
    pub over: Vec<f64>,
    /// Values of each curve, in the order of their names.
    pub curves: Vec<Vec<f64>>,
    /// Reason why the test stopped before its end.
    stop: Option<DriverError>,
}

impl StageCurves {
    /// Curves of a test that has been run, for its data.
    pub(super) fn new(trace: TestTrace, data: &DataFile) -> Result<Self, TestFailure> {
        let Some(first) = trace.stage_rows.get(data.stage) else {
            return Err(trace.stop_reason.map_or(TestFailure::MissingStage(data.stage), TestFailure::Driver));
        };
        let column = |name: &String| column_from(&trace.path, *first, name);
        let curves = Self {
            over: column(&data.over),
            curves: data.curves.keys().map(column).collect(),
            stop: trace.stop_reason,
        };
        curves.require_monotone(&data.over)?;
        Ok(curves)
    }

    /// Requires that the abscissa rises or falls throughout.
    fn require_monotone(&self, name: &str) -> Result<(), TestFailure> {
        let places = || self.signed().into_iter();
        match non_ascending(places(), false).next() {
            Some((row, ..)) => Err(TestFailure::NotMonotone {
                name: name.to_owned(),
                row,
                from: self.over[row - 1],
                to: self.over[row],
            }),
            None if places().any(|x| !x.is_finite()) => {
                Err(TestFailure::NotFinite { name: name.to_owned(), at: f64::NAN })
            }
            None => Ok(()),
        }
    }

    /// Abscissae, with the opposite sign where they fall.
    fn signed(&self) -> Vec<f64> {
        let sign = self.sign();
        self.over.iter().map(|x| sign * x).collect()
    }

    /// Sign with which the abscissae rise.
    fn sign(&self) -> f64 {
        if self.over.last() < self.over.first() { -1.0 } else { 1.0 }
    }

    /// Computed values at the abscissae of the data, curve by curve.
    pub(super) fn at_data(&self, name: &str, data: &LaboratoryData) -> Result<Vec<Vec<f64>>, TestFailure> {
        let (sign, places) = (self.sign(), self.signed());
        let (low, high) = (places[0], places[places.len() - 1]);
        let rounding = ROUNDING * (high - low).max(low.abs()).max(high.abs());
        let curve_at = |(curve, computed): (&MeasuredCurve, &Vec<f64>)| {
            let value = |measured: &MeasuredValue| {
                let x = sign * measured.x;
                if !(low - rounding..=high + rounding).contains(&x) {
                    return Err(TestFailure::OutOfRange {
                        line: measured.line,
                        name: name.to_owned(),
                        value: measured.x,
                        from: self.over[0],
                        to: self.over[self.over.len() - 1],
                        stop: self.stop.clone().map(Box::new),
                    });
                }
                let value = value_at(&places, |place| *place, |k| computed[k], x).unwrap_or(f64::NAN);
                match value.is_finite() {
                    true => Ok(value),
                    false => Err(TestFailure::NotFinite { name: curve.name.clone(), at: measured.x }),
                }
            };
            curve.values.iter().map(value).collect()
        };
        data.curves.iter().zip(&self.curves).map(curve_at).collect()
    }
}

/// Column of a path from a row on. Strains, work, pore pressure and time count from that row.
fn column_from(path: &ElementPath, first: usize, name: &str) -> Vec<f64> {
    let strains = || {
        let components = STRAINS.map(|name| path.column(name).unwrap_or_default());
        let at =
            move |row: usize| SymTensor(std::array::from_fn(|k| components[k][row] - components[k][first]));
        (first..path.rows.len()).map(at)
    };
    match name {
        "axial_compression" => strains().map(|strain| 0.0 - strain.principal_values()[2]).collect(),
        "deviatoric_strain" => strains()
            .map(|strain| {
                let deviator = strain.deviator();
                (2.0 / 3.0 * deviator.dot(&deviator)).sqrt()
            })
            .collect(),
        _ => {
            let values = path.column(name).unwrap_or_default();
            let counts = INCREMENTAL.contains(&name) || STRAINS.contains(&name);
            let origin = if counts { values.get(first).copied().unwrap_or(0.0) } else { 0.0 };
            values.into_iter().skip(first).map(|value| value - origin).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constitutive::LinearElasticSpec;
    use crate::constitutive::driver::{ElementTest, LoadingPath, TestStage};

    #[test]
    fn strains_count_from_the_beginning_of_the_stage_and_stresses_do_not() {
        let stage = |path| TestStage { path, steps: 4, duration: 2.0 };
        let test = ElementTest::new(LinearElasticSpec::new(2000.0, 1e7, 0.25))
            .stage(stage(LoadingPath::Isotropic { pressure: 1e5 }))
            .stage(stage(LoadingPath::TriaxialDrained { axial_compression: 0.01 }));
        let path = test.run().unwrap();
        let last = |name: &str| *column_from(&path, 4, name).last().unwrap();
        let first = |name: &str| column_from(&path, 4, name)[0];
        for name in ["axial_compression", "volumetric_strain", "deviatoric_strain", "time", "work"] {
            assert_eq!(first(name), 0.0, "{name}");
        }
        // Uniaxial compression under constant lateral stress: q = E ε₁, ε_v = -(1 - 2ν) ε₁, ε_q = 2/3 (1 + ν) ε₁.
        for (name, exact) in [
            ("axial_compression", 0.01),
            ("volumetric_strain", -0.005),
            ("deviatoric_strain", 2.0 / 3.0 * 1.25 * 0.01),
            ("q", 1e5),
            ("time", 2.0),
        ] {
            // Logarithmic strain and rotated stress agree with small-strain elasticity to the square of the strain.
            assert!((last(name) / exact - 1.0).abs() < 1e-6, "{name}: {}", last(name));
        }
        assert!((first("p") - 1e5).abs() < 1e-3);
    }
}
