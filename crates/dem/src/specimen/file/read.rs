//! Reader of specimen files: from a file to the grains and the solver of a case.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use colluvium_case::description::{Body, Velocity};
use colluvium_case::output::Table;
use colluvium_case::{Case, CaseError, spatial};

use crate::boundary::periodic_cell::{PeriodicCell, inverse};
use crate::config::DemOptions;
use crate::points::grains::Grains;
use crate::specimen::file::{FORMAT, KEY, StoredSpecimen, names};
use colluvium_case::CaseErrorKind;
use colluvium_case::Warning;

/// Names of the axes in column headings.
const AXES: [&str; 3] = ["x", "y", "z"];

/// List of quoted names for a message.
fn name_list<'a>(all: impl IntoIterator<Item = &'a str>) -> String {
    let all: Vec<String> = all.into_iter().map(|name| format!("{name:?}")).collect();
    if all.is_empty() { "none".to_owned() } else { all.join(", ") }
}

/// Table whose columns are found by name.
pub(super) struct NamedTable<'a> {
    table_name: &'static str,
    /// Table with rows and headings.
    pub table: &'a Table,
}

impl<'a> NamedTable<'a> {
    /// Table of a file; an error unless every row has a number for each column.
    pub fn new(table_name: &'static str, table: &'a Table) -> Result<Self, String> {
        let count = table.columns.len();
        match table.rows.iter().position(|row| row.len() != count) {
            Some(row) => Err(format!(
                "row {} of {table_name} has {} numbers for {count} columns",
                row + 1,
                table.rows[row].len()
            )),
            None => Ok(Self { table_name, table }),
        }
    }

    /// Whether the table has a column of this name.
    pub fn has_column(&self, name: &str) -> bool {
        self.table.columns.iter().any(|(own, _)| own == name)
    }

    /// Indices of the columns of a quantity.
    pub fn columns<const N: usize>(&self, name: &str) -> Result<[usize; N], String> {
        let mut found = [0; N];
        for (found, name) in found.iter_mut().zip(names::<N>(name)) {
            let at = self.table.columns.iter().position(|(own, _)| *own == name);
            *found = at.ok_or_else(|| format!("{} have no column {name:?}", self.table_name))?;
        }
        Ok(found)
    }

    /// Index of the column of a number.
    pub fn column(&self, name: &str) -> Result<usize, String> {
        self.columns::<1>(name).map(|[column]| column)
    }

    /// Non-negative integer below `limit` in a row and column.
    pub fn integer(&self, row: usize, column: usize, limit: u64) -> Result<u32, String> {
        let value = self.table.rows[row][column];
        if value >= 0.0 && value < limit as f64 && value.fract() == 0.0 {
            return Ok(value as u32);
        }
        let name = &self.table.columns[column].0;
        Err(format!(
            "row {} of {}: {name} is {value}, which is not an integer from 0 to {}",
            row + 1,
            self.table_name,
            limit - 1
        ))
    }
}

/// Numbers of a row in given columns.
pub(super) fn columns_of_row<const N: usize>(row: &[f64], columns: &[usize; N]) -> [f64; N] {
    columns.map(|column| row[column])
}

impl StoredSpecimen {
    /// Specimen with which the case starts, if it names one.
    ///
    /// # Errors
    /// When its file cannot be read, is no specimen, or does not fit the case.
    pub fn of_case(case: &Case, options: &DemOptions) -> Result<Option<Self>, CaseError> {
        let Some(file) = &options.specimen else { return Ok(None) };
        let stored = Self::read(file).and_then(|stored| stored.check_case(case).map(|()| stored));
        let stored = stored.map_err(|problem| CaseError::new(KEY, format!("{file}: {problem}")))?;
        let counts = stored.counts();
        let mut given =
            case.bodies.iter().enumerate().filter(|(_, body)| counts.contains_key(body.name.as_str()));
        given.try_for_each(|(number, body)| refuse_twice(options, number, body))?;
        Ok(Some(stored))
    }

    /// Reads a specimen file.
    fn read(file: &str) -> Result<Self, String> {
        let text =
            std::fs::read_to_string(Path::new(file)).map_err(|error| format!("cannot be read: {error}"))?;
        serde_json::from_str(&text).map_err(|error| format!("is not a complete specimen file: {error}"))
    }

    /// Number of grains of each body that has any.
    pub fn counts(&self) -> HashMap<&str, usize> {
        let mut counts = HashMap::new();
        let Some(column) = self.grains.columns.iter().position(|(name, _)| name == "body") else {
            return counts;
        };
        for row in &self.grains.rows {
            if let Some(name) = self.head.bodies.get(row[column] as usize) {
                *counts.entry(name.as_str()).or_default() += 1;
            }
        }
        counts
    }

    /// Checks that the specimen matches the bodies and the cell of the case.
    fn check_case(&self, case: &Case) -> Result<(), String> {
        let (head, dimension) = (&self.head, case.dimension());
        if head.format != FORMAT {
            return Err(format!("its format is {:?}, but this program reads {FORMAT:?}", head.format));
        }
        if head.dimension != dimension {
            return Err(format!("has {} dimensions, but the case has {dimension}", head.dimension));
        }
        let grains = NamedTable::new("the grains", &self.grains)?;
        let body = grains.column("body")?;
        NamedTable::new("the contacts", &self.contacts)?;
        let count = head.bodies.len().min(head.kinds.len()) as u64;
        for row in 0..self.grains.rows.len() {
            grains.integer(row, body, count)?;
        }
        for name in self.counts().keys() {
            self.body_fits(case, name)?;
        }
        self.cell_fits(case)
    }

    /// Checks that the case has a body with this name and the same kind of grains.
    fn body_fits(&self, case: &Case, name: &str) -> Result<(), String> {
        let Some(body) = case.bodies.iter().find(|body| body.name == name) else {
            return Err(format!(
                "has grains of the body {name:?}, which the case does not have; the bodies of the case: {}",
                name_list(case.bodies.iter().map(|body| body.name.as_str()))
            ));
        };
        let kind = self.head.bodies.iter().position(|own| own == name).map(|at| &self.head.kinds[at]);
        match kind.filter(|kind| **kind != body.material) {
            Some(kind) => Err(format!(
                "the grains of {name:?} are of the kind {kind:?}, but in the case they are of the kind {:?}",
                body.material
            )),
            None => Ok(()),
        }
    }

    /// Checks that the cell is periodic along the same axes as the domain of the case.
    fn cell_fits(&self, case: &Case) -> Result<(), String> {
        let (cell, dimension) = (&self.head.cell, case.dimension());
        let square = |matrix: &Vec<Vec<f64>>| {
            matrix.len() == dimension && matrix.iter().all(|row| row.len() == dimension)
        };
        let lengths = [cell.periodic.len(), cell.corner.len(), self.head.origin.len()];
        if lengths != [dimension; 3]
            || ![&cell.vectors, &cell.rates, &cell.motion].into_iter().all(square)
            || !(cell.mean_rates.is_empty() || square(&cell.mean_rates))
        {
            return Err(format!("its cell does not have {dimension} dimensions"));
        }
        let along = |periodic: &dyn Fn(usize) -> bool| {
            name_list((0..dimension).filter(|&axis| periodic(axis)).map(|axis| AXES[axis]))
        };
        let (own, of_case) =
            (along(&|axis| cell.periodic[axis]), along(&|axis| case.domain.is_periodic(axis)));
        if own != of_case {
            return Err(format!(
                "its cell is periodic along {own}, but the domain of the case along {of_case}"
            ));
        }
        Ok(())
    }

    /// Displacement from specimen coordinates to those of the case (m).
    pub(super) fn shift<const D: usize>(&self, case: &Case) -> [f64; D] {
        let origin = case.origin();
        std::array::from_fn(|c| self.head.origin[c] - origin[c])
    }

    /// Cell of the case, with the cell vectors of the specimen along periodic axes.
    pub fn cell<const D: usize>(
        &self,
        case: &Case,
        domain: PeriodicCell<D>,
    ) -> Result<PeriodicCell<D>, CaseError> {
        let (own, shift) = (&self.head.cell, self.shift::<D>(case));
        let mut cell = domain;
        for axis in (0..D).filter(|&axis| domain.periodic[axis]) {
            cell.origin[axis] = own.corner[axis] + shift[axis];
            for row in 0..D {
                cell.h[row][axis] = own.vectors[axis][row];
                cell.velocity_gradient[row][axis] = own.rates[row][axis];
                cell.mean_velocity_gradient[row][axis] =
                    own.mean_rates.get(row).unwrap_or(&own.rates[row])[axis];
            }
        }
        let volume = inverse(&cell.h).1;
        if volume > 0.0 {
            Ok(cell)
        } else {
            Err(self.file_error(case, &format!("its cell has a volume of {volume}, which must be positive")))
        }
    }

    /// Note on a cell that differs from the domain of the case.
    pub(super) fn cell_note<const D: usize>(&self, case: &Case) -> Option<Warning> {
        let own = &self.head.cell;
        let differs = |axis: usize| {
            let wide = case.domain.max[axis] - case.domain.min[axis];
            (0..D).any(|row| {
                let of_case = if row == axis { wide } else { 0.0 };
                (own.vectors[axis][row] - of_case).abs() > 1e-9 * wide
            })
        };
        let other = (0..D).find(|&axis| own.periodic[axis] && differs(axis))?;
        Some(Warning::new(
            "specimen-cell-replaces-domain",
            format!(
                "{KEY}: the cell of the specimen replaces the domain along {}, where its vector is {:?} m",
                AXES[other], own.vectors[other]
            ),
        ))
    }

    /// Error in the file of the case.
    pub(super) fn file_error(&self, case: &Case, problem: &str) -> CaseError {
        let file =
            case.methods.get("dem").and_then(|options| options.get("specimen")?.as_str()).unwrap_or_default();
        CaseError::new(KEY, format!("{file}: {problem}"))
    }

    /// Adds the grains of the specimen.
    pub fn fill<const D: usize, const R: usize>(
        &self,
        case: &Case,
        options: &DemOptions,
        grains: &mut Grains<D, R>,
    ) -> Result<(), CaseError> {
        self.push(case, options, grains).map_err(|problem| self.file_error(case, &problem))
    }

    /// Adds the grains of the file to those of the case, with bodies matched by name.
    fn push<const D: usize, const R: usize>(
        &self,
        case: &Case,
        options: &DemOptions,
        grains: &mut Grains<D, R>,
    ) -> Result<(), String> {
        let rows = NamedTable::new("the grains", &self.grains)?;
        let [id, of_body, radius] = [rows.column("id")?, rows.column("body")?, rows.column("radius")?];
        let (place, velocity, force) =
            (rows.columns::<D>("")?, rows.columns::<D>("velocity")?, rows.columns::<D>("force")?);
        let (spin, torque) = (rows.columns::<R>("spin")?, rows.columns::<R>("torque")?);
        let has_turned = options.orientation && rows.has_column("orientation_w");
        let turned = has_turned.then(|| rows.columns::<4>("orientation")).transpose()?;
        let (shift, mut ids) = (self.shift::<D>(case), HashSet::new());
        for (number, row) in rows.table.rows.iter().enumerate() {
            let name = &self.head.bodies[row[of_body] as usize];
            let Some(body) = case.bodies.iter().position(|body| body.name == *name) else { continue };
            let kind = &case.bodies[body].material;
            let index = options.grains.keys().position(|name| name == kind).unwrap_or(0);
            if !(row[radius] > 0.0) {
                return Err(format!(
                    "row {} of the grains: radius {} must be positive",
                    number + 1,
                    row[radius]
                ));
            }
            let x = columns_of_row(row, &place);
            let x = std::array::from_fn(|c| x[c] + shift[c]);
            grains.push(body as u32, index as u32, x, row[radius], options.grains[kind].density);
            let last = grains.len() - 1;
            grains.id[last] = rows.integer(number, id, u64::from(u32::MAX / 2))?;
            if !ids.insert(grains.id[last]) {
                return Err(format!(
                    "row {} of the grains: the id {} is given twice",
                    number + 1,
                    grains.id[last]
                ));
            }
            grains.velocity[last] = columns_of_row(row, &velocity);
            grains.spin[last] = columns_of_row(row, &spin);
            grains.force[last] = columns_of_row(row, &force);
            grains.torque[last] = columns_of_row(row, &torque);
            grains.orientation.extend(turned.map(|turned| columns_of_row(row, &turned)));
            set_prescribed_motion(options, &case.bodies[body], grains, last);
        }
        Ok(())
    }
}

/// Sets the prescribed motion of a grain, if its body has one; it has priority over the velocity in the file.
fn set_prescribed_motion<const D: usize, const R: usize>(
    options: &DemOptions,
    body: &Body,
    grains: &mut Grains<D, R>,
    i: usize,
) {
    let Some(own) = options.bodies.get(&body.name).filter(|own| own.held) else { return };
    let velocity = body.velocity.velocity_at(spatial(&grains.position[i]));
    grains.is_held[i] = true;
    grains.velocity[i] = std::array::from_fn(|c| velocity[c]);
    grains.spin[i] = std::array::from_fn(|c| own.spin.get(c).copied().unwrap_or(0.0));
}

/// Rejects options of the case for a body whose grains are those of the specimen.
fn refuse_twice(options: &DemOptions, number: usize, body: &Body) -> Result<(), CaseError> {
    let own = options.bodies.get(&body.name);
    let held = own.is_some_and(|own| own.held);
    let of_dem = format!("methods.dem.bodies.{}", body.name);
    let path = if body.points.is_some() {
        format!("bodies[{number}].points")
    } else if !held && body.velocity != Velocity::Rest {
        format!("bodies[{number}].velocity")
    } else if own.is_some_and(|own| own.fill.is_some()) {
        format!("{of_dem}.fill")
    } else if own.is_some_and(|own| !held && !own.spin.is_empty()) {
        format!("{of_dem}.spin")
    } else {
        return Ok(());
    };
    Err(CaseError::new(
        path,
        CaseErrorKind::coded(
            "conflicting-keys",
            format!("the grains and velocities of this body come from {KEY}: leave it out"),
        ),
    ))
}
