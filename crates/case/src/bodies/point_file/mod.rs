//! Points of a body from a file, instead of points on a lattice.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use crate::description::{Body, InitialStress, PointFile, PorePressure, Space, Velocity};
use crate::files::decimal_sum::relative_to_origin;
use crate::files::json::closest;
use crate::{Case, CaseError, CaseErrorKind, ColumnFile, Quantity};
use colluvium_constitutive::SymTensor;
use colluvium_points::{Sample, Shape};

/// Points of a body, read from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointList {
    /// Positions (m); unused components are zero.
    pub positions: Vec<[f64; 3]>,
    /// Volumes, areas or lengths (m³, m², m), by the dimension of the space.
    pub volumes: Vec<f64>,
    /// Masses (kg, kg/m in plane strain, kg/rad in axisymmetry), if the file has them.
    pub masses: Option<Vec<f64>>,
    /// Initial velocities (m/s), if the file has them.
    pub velocities: Option<Vec<[f64; 3]>>,
    /// Initial stresses (Pa, tension-positive), if the file has them.
    pub stresses: Option<Vec<SymTensor>>,
    /// Initial pore pressures (Pa, compression-positive), if the file has them.
    pub pore_pressures: Option<Vec<f64>>,
    /// Columns of grains.
    pub grains: GrainColumns,
}

/// Columns of grains in a file of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GrainColumns {
    /// Radii of the grains (m).
    pub radii: Option<Vec<f64>>,
    /// Names of grain types.
    pub grain_types: Option<Vec<String>>,
    /// Initial spins (rad/s).
    pub spins: Option<Vec<[f64; 3]>>,
    /// Whether the grains are fixed.
    pub is_held: Option<Vec<bool>>,
    /// Permanent numbers of the grains.
    pub ids: Option<Vec<u32>>,
}

impl GrainColumns {
    /// Columns with the initial spin (rad/s).
    pub const SPIN: [&str; 3] = ["spin_x", "spin_y", "spin_z"];
    /// Other columns of grains.
    const GRAIN_COLUMNS: [&str; 4] = [RADIUS, KIND, HELD_COLUMN, ID];

    /// Empty columns for the grain data that the file contains.
    fn empty_like(columns: &PointFileColumns) -> Self {
        Self {
            radii: columns.has_any(&[RADIUS]).then(Vec::new),
            grain_types: columns.has_any(&[KIND]).then(Vec::new),
            spins: columns.has_any(&Self::SPIN).then(Vec::new),
            is_held: columns.has_any(&[HELD_COLUMN]).then(Vec::new),
            ids: columns.has_any(&[ID]).then(Vec::new),
        }
    }

    /// Adds the values of a row.
    fn add_row(&mut self, row: &PointFileRow<'_>, columns: &PointFileColumns) -> Result<(), String> {
        if let Some(radii) = &mut self.radii {
            radii.push(row.positive(columns, RADIUS)?);
        }
        if let Some(kinds) = &mut self.grain_types {
            kinds.push(row.text(columns, KIND).to_owned());
        }
        let spin = row.numbers(columns, &Self::SPIN)?;
        self.spins.iter_mut().for_each(|all| all.push(spin));
        if let Some(held) = &mut self.is_held {
            held.push(row.integer(columns, HELD_COLUMN, 1)? == 1);
        }
        if let Some(ids) = &mut self.ids {
            ids.push(row.integer(columns, ID, u32::MAX / 2)?);
        }
        Ok(())
    }
}

impl PointList {
    /// Column with the mass (kg).
    pub const MASS: &str = "mass";
    /// Columns with the initial velocity (m/s).
    pub const VELOCITY: [&str; 3] = ["velocity_x", "velocity_y", "velocity_z"];
    /// Columns with the initial stress (Pa, tension-positive).
    pub const STRESS: [&str; 6] =
        ["stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_zx"];
    /// Column with the initial pore pressure (Pa, compression-positive).
    pub const PORE_PRESSURE: &str = "pore_pressure";

    /// Positions and volumes.
    pub fn samples<const D: usize>(&self) -> Vec<Sample<D>> {
        let sample = |(position, volume): (&[f64; 3], &f64)| Sample {
            position: std::array::from_fn(|axis| position[axis]),
            volume: *volume,
        };
        self.positions.iter().zip(&self.volumes).map(sample).collect()
    }

    /// Mean spacing of the points (m) in a space of `dimension` coordinates: the edge of a square or cube of their mean volume.
    pub fn spacing(&self, dimension: usize) -> f64 {
        let mean = self.volumes.iter().sum::<f64>() / self.volumes.len() as f64;
        mean.powf(1.0 / dimension as f64)
    }
}

impl PointFile {
    /// Approximate number of points in the file, without parsing it: its lines except the header and comments. Zero for a file that cannot
    /// be read.
    pub(crate) fn count(&self) -> f64 {
        let Ok(file) = File::open(&self.file) else { return 0.0 };
        let lines = BufReader::new(file).split(b'\n').map_while(Result::ok);
        let rows = lines.filter(|line| !line.trim_ascii().is_empty() && !line.starts_with(b"#"));
        rows.count().saturating_sub(1) as f64
    }
}

impl Case {
    /// Points of a body from its file; `None` for bodies without a file.
    ///
    /// # Errors
    /// When the file cannot be read or is invalid, with line and column; when a point is outside the shape of the body, or two points
    /// coincide.
    pub fn point_list(&self, body: usize) -> Result<Option<PointList>, CaseError> {
        let Some(source) = &self.bodies[body].points else { return Ok(None) };
        let list = self.read_points(&self.bodies[body], source);
        list.map(Some).map_err(|problem| {
            CaseError::new(format!("bodies[{body}].points.file"), problem.in_table(&source.file))
        })
    }

    /// Density of the material, without pore fluid, at point `point` of body `number` (kg/m³): from the mass in its list, or that of the
    /// material.
    ///
    /// # Errors
    /// When the mass is less than that of the pore fluid alone.
    pub fn density_at(
        &self,
        number: usize,
        listed: Option<&PointList>,
        point: usize,
    ) -> Result<f64, CaseError> {
        let body = &self.bodies[number];
        let Some((list, masses)) = listed.and_then(|list| Some((list, list.masses.as_ref()?))) else {
            return Ok(self.materials[&body.material].density());
        };
        let turn = if self.space == Space::Axisymmetric { list.positions[point][0] } else { 1.0 };
        let whole = masses[point] / (list.volumes[point] * turn);
        let fluid = body.pore_fluid.as_ref().map_or(0.0, |fluid| fluid.porosity * fluid.density);
        if whole > fluid {
            return Ok(whole - fluid);
        }
        let problem = format!(
            "the point at {:?} m has a density of {whole} kg/m³, which must be above the {fluid} kg/m³ of \
             the fluid in its pores",
            list.positions[point]
        );
        Err(CaseError::new(format!("bodies[{number}].points.file"), problem))
    }

    /// Initial stress (Pa, tension-positive) of point number `point` of a body, at the position `x` (m).
    pub(crate) fn initial_stress_of(
        &self,
        body: &Body,
        list: Option<&PointList>,
        point: usize,
        x: [f64; 3],
    ) -> SymTensor {
        let own = list.and_then(|list| list.stresses.as_ref());
        own.map_or_else(|| self.initial_stress(body, x), |stresses| stresses[point])
    }

    /// Reads the points of a body from its file, with those of the masses, velocities, stresses and pore pressures that the file contains.
    fn read_points(&self, body: &Body, source: &PointFile) -> Result<PointList, CaseErrorKind> {
        let table = ColumnFile::read(Path::new(&source.file))?;
        let columns = PointFileColumns::new(&table, self.dimension())?;
        columns.check_against(body, source)?;
        let origin = self.origin();
        let unit_ball = Shape::Ball { centre: vec![0.0; self.dimension()], radius: 1.0 };
        let unit_ball = unit_ball.measure(self.dimension()).unwrap_or(f64::NAN);
        let mut rows = Vec::new();
        let mut list = PointList {
            masses: columns.has_any(&[PointList::MASS]).then(Vec::new),
            velocities: columns.has_any(&PointList::VELOCITY).then(Vec::new),
            stresses: columns.has_any(&PointList::STRESS).then(Vec::new),
            pore_pressures: columns.has_any(&[PointList::PORE_PRESSURE]).then(Vec::new),
            grains: GrainColumns::empty_like(&columns),
            ..PointList::default()
        };
        table.visit_rows(|line, cells| {
            let row = PointFileRow { line, record: cells, table: &table };
            let [x, velocity] =
                [&COORDINATE_COLUMNS, &PointList::VELOCITY].map(|names| row.numbers(&columns, names));
            let (mut x, velocity) = (x?, velocity?);
            (0..self.dimension()).for_each(|c| x[c] = relative_to_origin(x[c], origin[c]));
            if !body.shape.contains(&x[..self.dimension()]) {
                let at = &x[..self.dimension()];
                let problem = format!("line {}: the point at {at:?} m is not in the body's shape", row.line);
                return Err(CaseErrorKind::coded("outside-domain", problem));
            }
            list.positions.push(x);
            list.volumes.push(match source.spacing {
                Some(spacing) => spacing.powi(self.dimension() as i32),
                None if columns.has_any(&[VOLUME]) => row.positive(&columns, VOLUME)?,
                None => row.positive(&columns, RADIUS)?.powi(self.dimension() as i32) * unit_ball,
            });
            if let Some(masses) = &mut list.masses {
                masses.push(row.positive(&columns, PointList::MASS)?);
            }
            list.grains.add_row(&row, &columns)?;
            list.velocities.iter_mut().for_each(|all| all.push(velocity));
            let stress = row.numbers(&columns, &PointList::STRESS)?;
            list.stresses.iter_mut().for_each(|all| all.push(SymTensor(stress)));
            let pressure = row.number(&columns, PointList::PORE_PRESSURE)?;
            list.pore_pressures.iter_mut().for_each(|all| all.push(pressure));
            rows.push(row.line);
            Ok::<(), CaseErrorKind>(())
        })?;
        if rows.is_empty() {
            return Err(CaseErrorKind::coded("empty-body", "contains no points"));
        }
        check_distinct(&list.positions, &rows)?;
        Ok(list)
    }
}

/// Columns of the coordinates (m).
const COORDINATE_COLUMNS: [&str; 3] = ["x", "y", "z"];
/// Heading of the column of point volumes (m³, in the plane m² times one metre).
const VOLUME: &str = "volume";
/// Heading of the column of radii (m), from which volumes are computed where the file has none.
const RADIUS: &str = "radius";
/// Heading of the column of kinds of grains.
const KIND: &str = "kind";
/// Column of the flag of grains with prescribed motion.
const HELD_COLUMN: &str = "held";
/// Heading of the column of permanent numbers of points.
const ID: &str = "id";

/// Physical quantity of a column.
fn quantity(name: &str) -> Quantity {
    let is_one_of = |names: &[&str]| names.contains(&name);
    match name {
        VOLUME => Quantity::Volume,
        PointList::MASS => Quantity::Mass,
        PointList::PORE_PRESSURE => Quantity::Stress,
        _ if is_one_of(&COORDINATE_COLUMNS) || name == RADIUS => Quantity::Length,
        _ if is_one_of(&PointList::VELOCITY) => Quantity::Velocity,
        _ if is_one_of(&PointList::STRESS) => Quantity::Stress,
        _ if is_one_of(&GrainColumns::SPIN) => Quantity::AngularVelocity,
        _ => Quantity::Dimensionless,
    }
}

/// Names of the columns, and their factors to SI units.
struct PointFileColumns {
    names: Vec<String>,
    factors: Vec<f64>,
}

impl PointFileColumns {
    /// Finds the columns of a point file by their headings.
    fn new(table: &ColumnFile, dimension: usize) -> Result<Self, CaseErrorKind> {
        let heads = table.headings().ok_or_else(|| {
            format!(
                "has no names of columns in its first line, for example {}",
                COORDINATE_COLUMNS[..dimension].join(",")
            )
        })?;
        let names: Vec<String> = heads.iter().map(|head| ColumnFile::name(head).to_owned()).collect();
        let known: Vec<&str> = COORDINATE_COLUMNS[..dimension]
            .iter()
            .chain([&VOLUME, &PointList::MASS])
            .chain(&PointList::VELOCITY[..dimension])
            .chain(&PointList::STRESS)
            .chain([&PointList::PORE_PRESSURE])
            .chain(&GrainColumns::SPIN[if dimension == 3 { 0 } else { 2 }..])
            .chain(&GrainColumns::GRAIN_COLUMNS)
            .copied()
            .collect();
        for (number, name) in names.iter().enumerate() {
            if !known.contains(&name.as_str()) {
                return Err(match closest(name, &known) {
                    Some(likely) => format!("unknown column {name:?}; did you mean {likely:?}?").into(),
                    None => format!("unknown column {name:?}; there are {}", known.join(", ")).into(),
                });
            }
            if names[..number].contains(name) {
                return Err(format!("two columns are called {name:?}").into());
            }
        }
        if let Some(missing) =
            COORDINATE_COLUMNS[..dimension].iter().find(|axis| !names.iter().any(|name| name == *axis))
        {
            return Err(format!("the column {missing:?} is missing").into());
        }
        let factor = |(head, name): (&String, &String)| ColumnFile::factor(head, quantity(name));
        let factors = heads.iter().zip(&names).map(factor).collect::<Result<_, _>>()?;
        Ok(Self { names, factors })
    }

    /// Index of the column with a name; `None` where the file lacks it.
    fn column_index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Whether one of the columns exists.
    fn has_any(&self, names: &[&str]) -> bool {
        names.iter().any(|name| self.column_index(name).is_some())
    }

    /// Rejects contradictory data, and columns that a rigid body does not have.
    fn check_against(&self, body: &Body, source: &PointFile) -> Result<(), String> {
        let twice = |what: &str, key: &str| {
            Err(format!("has {what}, but the body also has `{key}`: give one of them"))
        };
        match (self.has_any(&[VOLUME]), source.spacing) {
            (true, Some(_)) => return twice("a column \"volume\"", "points.spacing"),
            (false, None) if !self.has_any(&[RADIUS]) => {
                return Err("the column \"volume\" is missing, and `spacing` is not given".to_owned());
            }
            _ => {}
        }
        if self.has_any(&PointList::VELOCITY) && body.velocity != Velocity::Rest {
            return twice("velocities", "velocity");
        }
        if self.has_any(&PointList::STRESS) && body.stress != InitialStress::None {
            return twice("stresses", "stress");
        }
        let fluid = body.pore_fluid.as_ref();
        if self.has_any(&[PointList::PORE_PRESSURE])
            && fluid.is_some_and(|own| own.pressure != PorePressure::None)
        {
            return twice("pore pressures", "pore_fluid.pressure");
        }
        if body.rigid && (self.has_any(&PointList::VELOCITY) || self.has_any(&PointList::STRESS)) {
            return Err("a rigid body begins at rest and has no stress".to_owned());
        }
        Ok(())
    }
}

/// Row of the file.
struct PointFileRow<'a> {
    line: u64,
    record: &'a csv::StringRecord,
    table: &'a ColumnFile,
}

impl PointFileRow<'_> {
    /// Number in a column, in SI units; zero without such a column.
    fn number(&self, columns: &PointFileColumns, name: &str) -> Result<f64, String> {
        let Some(column) = columns.column_index(name) else { return Ok(0.0) };
        let text = self.record[column].trim();
        match self.table.number(text) {
            Some(value) => Ok(value * columns.factors[column]),
            None => Err(format!("line {}, column {name:?}: {text:?} is not a finite number", self.line)),
        }
    }

    /// Returns the numbers of a row in the columns `names`.
    fn numbers<const N: usize>(
        &self,
        columns: &PointFileColumns,
        names: &[&str; N],
    ) -> Result<[f64; N], String> {
        let mut values = [0.0; N];
        for (value, name) in values.iter_mut().zip(names) {
            *value = self.number(columns, name)?;
        }
        Ok(values)
    }

    /// Returns the number of a row in the column `name`, which must be positive.
    fn positive(&self, columns: &PointFileColumns, name: &str) -> Result<f64, String> {
        let value = self.number(columns, name)?;
        if value > 0.0 {
            return Ok(value);
        }
        Err(format!("line {}, column {name:?}: {value} must be positive", self.line))
    }

    /// Integer in a column, at most `limit`.
    fn integer(&self, columns: &PointFileColumns, name: &str, limit: u32) -> Result<u32, String> {
        let text = self.text(columns, name);
        let value = text.parse().ok().filter(|value| *value <= limit);
        let problem = || {
            format!("line {}, column {name:?}: {text:?} is not a whole number from 0 to {limit}", self.line)
        };
        value.ok_or_else(problem)
    }

    /// Text in a column; empty without such a column.
    fn text(&self, columns: &PointFileColumns, name: &str) -> &str {
        columns.column_index(name).map_or("", |column| self.record[column].trim())
    }
}

/// Rejects coinciding points; `lines` are their line numbers in the file.
fn check_distinct(positions: &[[f64; 3]], lines: &[u64]) -> Result<(), String> {
    match coinciding_points(positions) {
        Some([a, b]) => Err(format!("line {}: has the same position as line {}", lines[b], lines[a])),
        None => Ok(()),
    }
}

/// Two points with the same position, by their indices; `None` if all positions differ.
pub(crate) fn coinciding_points(positions: &[[f64; 3]]) -> Option<[usize; 2]> {
    // Zero and minus zero are the same coordinate.
    let key = |number: &usize| positions[*number].map(|x| x + 0.0);
    let mut order: Vec<usize> = (0..positions.len()).collect();
    let compare = |a: &usize, b: &usize| {
        let (a, b) = (key(a), key(b));
        (0..3).map(|c| a[c].total_cmp(&b[c])).find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    order.sort_by(compare);
    order.windows(2).find(|pair| key(&pair[0]) == key(&pair[1])).map(|pair| [pair[0], pair[1]])
}

#[cfg(test)]
mod tests;
