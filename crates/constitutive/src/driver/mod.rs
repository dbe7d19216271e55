//! The element driver: one material point under prescribed strains and stresses (constitutive
//! sheet §3.12), the way laws are tested and calibrated.
//!
//! An [`ElementTest`] is a material, an initial stress and a list of stages. Every step solves
//! `S Δσ + E Δε = ΔY` for the strain increment by Newton's method with the law's own tangent.
//! Axis z is the axis of triaxial and oedometer tests, y that of biaxial tests; shear is xy.

mod path;
mod solve;

use std::io::Write;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    InitialCondition, Mat3, Material, MaterialError, MaterialSpec, Motion, StateBlock, States, SymTensor,
};

pub use path::Path;

/// A test of a single material point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElementTest {
    /// What the test is, in a line.
    pub title: String,
    /// The material.
    pub material: MaterialSpec,
    /// Initial stress (Pa, tension-positive): xx yy zz xy yz zx.
    #[serde(default)]
    pub initial_stress: [f64; 6],
    /// What is done to the point, one stage after another.
    pub stages: Vec<TestStage>,
}

/// A part of an element test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TestStage {
    /// What is prescribed.
    pub path: Path,
    /// Number of steps.
    #[serde(default = "steps")]
    pub steps: usize,
    /// Duration (s), for laws that feel the rate.
    #[serde(default = "duration")]
    pub duration: f64,
}

fn steps() -> usize {
    200
}

fn duration() -> f64 {
    1.0
}

/// Why an element test stopped.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DriverError {
    /// The material's parameters or initial stress are wrong.
    #[error("material: {0}")]
    Material(#[from] MaterialError),
    /// A stage is described wrongly.
    #[error("stages[{stage}]: {problem}")]
    Stage {
        /// Number of the stage.
        stage: usize,
        /// What is wrong.
        problem: String,
    },
    /// No strain carries the prescribed stress: the material has reached its limit load.
    #[error(
        "stages[{stage}], step {step}: limit load reached: no strain gives the prescribed stress ({row})"
    )]
    LimitLoad {
        /// Number of the stage.
        stage: usize,
        /// Step in the stage.
        step: usize,
        /// The condition that fails.
        row: String,
    },
    /// The law failed.
    #[error("stages[{stage}], step {step}: {source}")]
    Law {
        /// Number of the stage.
        stage: usize,
        /// Step in the stage.
        step: usize,
        /// What the law says.
        source: MaterialError,
    },
}

/// The columns every path has, with units.
const COLUMNS: [(&str, &str); 23] = [
    ("time", "s"),
    ("strain_xx", ""),
    ("strain_yy", ""),
    ("strain_zz", ""),
    ("strain_xy", ""),
    ("strain_yz", ""),
    ("strain_zx", ""),
    ("stress_xx", "Pa"),
    ("stress_yy", "Pa"),
    ("stress_zz", "Pa"),
    ("stress_xy", "Pa"),
    ("stress_yz", "Pa"),
    ("stress_zx", "Pa"),
    ("p", "Pa"),
    ("q", "Pa"),
    ("lode_angle", "rad"),
    ("volumetric_strain", ""),
    ("axial_compression", ""),
    ("deviatoric_strain", ""),
    ("yield_value", "Pa"),
    ("stored_energy", "J/m3"),
    ("work", "J/m3"),
    ("ln_p", ""),
];

/// What a point went through: one row per step, the start included.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementPath {
    /// Name and unit of each column; the law's own outputs come last.
    pub columns: Vec<(&'static str, &'static str)>,
    /// The rows.
    pub rows: Vec<Vec<f64>>,
}

/// A plot worth drawing of an element test: columns and labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StandardPlot {
    /// Short name, for files.
    pub name: &'static str,
    /// Column on the horizontal axis.
    pub x: &'static str,
    /// Column on the vertical axis.
    pub y: &'static str,
    /// Label of the horizontal axis.
    pub x_label: &'static str,
    /// Label of the vertical axis.
    pub y_label: &'static str,
}

/// The four plots every soil test is looked at through.
pub const STANDARD_PLOTS: [StandardPlot; 4] = [
    StandardPlot {
        name: "q-strain",
        x: "axial_compression",
        y: "q",
        x_label: "largest compression (-)",
        y_label: "q (Pa)",
    },
    StandardPlot {
        name: "volume-strain",
        x: "axial_compression",
        y: "volumetric_strain",
        x_label: "largest compression (-)",
        y_label: "volumetric strain, expansion positive (-)",
    },
    StandardPlot { name: "q-p", x: "p", y: "q", x_label: "p (Pa)", y_label: "q (Pa)" },
    StandardPlot {
        name: "volume-ln-p",
        x: "ln_p",
        y: "volumetric_strain",
        x_label: "ln(p / Pa)",
        y_label: "volumetric strain, expansion positive (-)",
    },
];

impl ElementPath {
    /// The values of a column, or `None` where there is none of that name.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.columns.iter().position(|(column, _)| *column == name)?;
        Some(self.rows.iter().map(|row| row[index]).collect())
    }

    /// Last value of a column; NaN where there is none of that name.
    pub fn last(&self, name: &str) -> f64 {
        self.column(name).and_then(|values| values.last().copied()).unwrap_or(f64::NAN)
    }

    /// Stress at the end (Pa).
    pub fn last_stress(&self) -> SymTensor {
        self.stress(self.rows.len() - 1)
    }

    /// Stress of a row (Pa).
    pub fn stress(&self, row: usize) -> SymTensor {
        SymTensor(std::array::from_fn(|k| self.rows[row][7 + k]))
    }

    /// Writes the path as CSV, with a head that states signs, order and units.
    ///
    /// # Errors
    /// When the writer fails.
    pub fn write_csv(&self, mut out: impl Write) -> std::io::Result<()> {
        writeln!(
            out,
            "# stress and strain tension-positive, tensor shear; p compression-positive; SI units"
        )?;
        let head: Vec<String> = self
            .columns
            .iter()
            .map(|(name, unit)| if unit.is_empty() { (*name).to_owned() } else { format!("{name} ({unit})") })
            .collect();
        writeln!(out, "{}", head.join(","))?;
        for row in &self.rows {
            let values: Vec<String> = row.iter().map(|value| format!("{value:e}")).collect();
            writeln!(out, "{}", values.join(","))?;
        }
        Ok(())
    }
}

/// The material point under test.
pub(crate) struct Specimen {
    material: std::sync::Arc<dyn Material>,
    pub(crate) stress: SymTensor,
    pub(crate) states: States,
    density: f64,
}

impl Specimen {
    fn new(test: &ElementTest) -> Result<Self, DriverError> {
        let material = test.material.build()?;
        let density = test.material.density();
        let condition = InitialCondition { stress: SymTensor(test.initial_stress), density };
        let (stresses, states) = material.initial(&[condition]).map_err(|error| error.source)?;
        Ok(Self { material, stress: stresses[0], states, density })
    }

    fn block(&self) -> &StateBlock {
        &self.states.blocks()[0]
    }

    fn motion(&self, gradient: &Mat3, dt: f64) -> Option<Motion> {
        let mut motion = Motion::from_velocity_gradient(&(*gradient * (1.0 / dt)), dt, 1.0, 1.0)?;
        motion.gradient = *gradient;
        motion.density = self.density / motion.deformation.determinant();
        Some(motion)
    }

    /// Stress and states after a motion; the specimen itself stays as it was.
    pub(crate) fn tried(&self, motion: &Motion) -> Result<(SymTensor, States), MaterialError> {
        let mut states = self.states.clone();
        let mut stress = [self.stress];
        self.material
            .update(std::slice::from_ref(motion), &mut stress, &mut states.blocks_mut()[0])
            .map_err(|error| error.source)?;
        Ok((stress[0], states))
    }

    pub(crate) fn tangent(&self, motion: &Motion) -> Result<crate::Tangent, MaterialError> {
        self.material.tangent(motion, &self.stress, self.block(), 0)
    }

    fn accept(&mut self, motion: &Motion, (stress, states): (SymTensor, States)) {
        self.stress = stress;
        self.states = states;
        self.density = motion.density;
    }

    fn yield_value(&self) -> f64 {
        let mut value = [0.0];
        self.material.yield_values(&[self.stress], self.block(), &mut value);
        value[0]
    }

    fn energy(&self) -> f64 {
        let mut value = [0.0];
        self.material.stored_energies(&[self.stress], self.block(), &mut value);
        value[0]
    }

    fn outputs(&self) -> Vec<f64> {
        let mut values = vec![0.0; self.material.output_names().len()];
        self.material.outputs(&[self.stress], self.block(), &mut values);
        values
    }
}

impl ElementTest {
    /// Runs the test.
    ///
    /// # Errors
    /// When the material or a stage is wrong, the law fails, or a limit load is reached under stress
    /// control.
    pub fn run(&self) -> Result<ElementPath, DriverError> {
        let mut specimen = Specimen::new(self)?;
        let mut columns = COLUMNS.to_vec();
        columns.extend(specimen.material.output_names().iter().map(|name| (*name, "")));
        let mut record = Record { time: 0.0, strain: SymTensor::ZERO, work: 0.0, rows: Vec::new() };
        record.push(&specimen);
        for (number, stage) in self.stages.iter().enumerate() {
            let problem = |problem: &str| DriverError::Stage { stage: number, problem: problem.to_owned() };
            if stage.steps == 0 {
                return Err(problem("steps must be at least 1"));
            }
            if !(stage.duration.is_finite() && stage.duration > 0.0) {
                return Err(problem("duration must be positive (s)"));
            }
            solve::stage(&mut specimen, &mut record, number, stage)?;
        }
        Ok(ElementPath { columns, rows: record.rows })
    }
}

/// What is written down on the way.
pub(crate) struct Record {
    time: f64,
    strain: SymTensor,
    work: f64,
    rows: Vec<Vec<f64>>,
}

impl Record {
    pub(crate) fn add(&mut self, dt: f64, strain: &SymTensor, before: &SymTensor, after: &SymTensor) {
        self.time += dt;
        self.strain += *strain;
        self.work += 0.5 * (*before + *after).dot(strain);
    }

    pub(crate) fn push(&mut self, specimen: &Specimen) {
        let (strain, stress) = (&self.strain, &specimen.stress);
        let deviator = strain.deviator();
        let mut row = vec![self.time];
        row.extend(strain.0);
        row.extend(stress.0);
        row.extend([
            stress.pressure(),
            stress.q(),
            stress.lode_angle(),
            strain.trace(),
            -strain.principal_values()[2],
            (2.0 / 3.0 * deviator.dot(&deviator)).sqrt(),
            specimen.yield_value(),
            specimen.energy(),
            self.work,
            stress.pressure().ln(),
        ]);
        row.extend(specimen.outputs());
        self.rows.push(row);
    }
}

#[cfg(test)]
mod tests;
