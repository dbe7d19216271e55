//! Path of an element test: a table with one row per step.

use std::io::Write;

use crate::driver::ElementSpecimen;
use crate::{Motion, SymTensor};

/// Columns of every path, with units. Outputs of a law have other names.
pub const PATH_COLUMNS: [(&str, &str); 26] = [
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
    ("dissipated_work", "J/m3"),
    ("excess_pore_pressure", "Pa"),
    ("wave_speed", "m/s"),
];

/// Index of the first stress column.
const STRESS: usize = 7;

/// Result of an element test as a table, with one row for the start and one for each step.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementPath {
    /// Name and unit of each column; the output values of the law are in the last columns.
    pub columns: Vec<(&'static str, &'static str)>,
    /// Rows of the table.
    pub rows: Vec<Vec<f64>>,
}

impl ElementPath {
    /// Values of the column with this name, if there is one.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let index = self.columns.iter().position(|(column, _)| *column == name)?;
        Some(self.rows.iter().map(|row| row.get(index).copied().unwrap_or(f64::NAN)).collect())
    }

    /// Last value of a column; NaN if there is no column of this name.
    pub fn last(&self, name: &str) -> f64 {
        self.column(name).and_then(|values| values.last().copied()).unwrap_or(f64::NAN)
    }

    /// Stress at the end (Pa); NaN if the table is empty.
    pub fn last_stress(&self) -> SymTensor {
        self.stress(self.rows.len().wrapping_sub(1))
    }

    /// Stress of a row (Pa); NaN if there is no such row.
    pub fn stress(&self, row: usize) -> SymTensor {
        let value = |k: usize| self.rows.get(row).and_then(|row| row.get(STRESS + k)).copied();
        SymTensor(std::array::from_fn(|k| value(k).unwrap_or(f64::NAN)))
    }

    /// Writes the path as CSV, with a header that states signs, order and units.
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
            let values: Vec<String> = row.iter().map(|value| cell(*value)).collect();
            writeln!(out, "{}", values.join(","))?;
        }
        Ok(())
    }
}

/// Text of a number in a table, which reads back to the last bit; empty for NaN and infinity.
pub fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:e}") } else { String::new() }
}

/// Recorder of the path during the test.
pub(super) struct PathRecorder {
    time: f64,
    strain: SymTensor,
    work: f64,
    /// Work per initial volume (J/m³).
    reference_work: f64,
    /// Recoverable energy per initial volume at the start (J/m³).
    initial_energy: f64,
    initial_density: f64,
    pore_pressure: f64,
    has_new_row: bool,
    rows: Vec<Vec<f64>>,
}

impl PathRecorder {
    /// Recorder whose first row is the current state of the specimen.
    pub(super) fn new(specimen: &ElementSpecimen) -> Self {
        let mut record = Self {
            time: 0.0,
            strain: SymTensor::ZERO,
            work: 0.0,
            reference_work: 0.0,
            initial_energy: specimen.energy(),
            initial_density: specimen.density,
            pore_pressure: 0.0,
            has_new_row: true,
            rows: Vec::new(),
        };
        record.push_if_moved(specimen);
        record
    }

    /// Adds a motion from `before` to `after` that changed the pore pressure by `pore` (Pa).
    pub(super) fn add(
        &mut self,
        motion: &Motion,
        pore: f64,
        before: &ElementSpecimen,
        after: &ElementSpecimen,
    ) {
        let strain = motion.strain_increment();
        let work = 0.5 * (before.stress + after.stress).dot(&strain);
        self.time += motion.dt;
        self.strain += strain;
        self.work += work;
        self.reference_work += 0.5 * (self.volume(before) + self.volume(after)) * work;
        self.pore_pressure += pore;
        self.has_new_row = true;
    }

    /// Current over initial volume of the specimen.
    fn volume(&self, specimen: &ElementSpecimen) -> f64 {
        self.initial_density / specimen.density
    }

    /// Adds a row, unless the last row already has the state of the specimen.
    pub(super) fn push_if_moved(&mut self, specimen: &ElementSpecimen) {
        if !std::mem::take(&mut self.has_new_row) {
            return;
        }
        let (strain, stress) = (&self.strain, &specimen.stress);
        let deviator = strain.deviator();
        let energy = specimen.energy();
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
            energy,
            self.work,
            stress.pressure().ln(),
            self.reference_work - (self.volume(specimen) * energy - self.initial_energy),
            self.pore_pressure,
            specimen.wave_speed(),
        ]);
        row.extend(specimen.outputs());
        self.rows.push(row);
    }

    /// Index of the last row.
    pub(super) fn last_row(&self) -> usize {
        self.rows.len().saturating_sub(1)
    }

    /// Returns the table of the path; the output values of the law are in the last columns.
    pub(super) fn into_path(self, outputs: &[&'static str]) -> ElementPath {
        let mut columns = PATH_COLUMNS.to_vec();
        columns.extend(outputs.iter().map(|name| (*name, "")));
        ElementPath { columns, rows: self.rows }
    }
}
