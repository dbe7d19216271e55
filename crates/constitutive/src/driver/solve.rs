//! The step solve of the element driver.

use nalgebra::{SMatrix, SVector};

use super::control::{Control, NAMES, Program};
use super::record::Record;
use super::{DriverError, Specimen, TestStage};
use crate::{Mat3, Motion};

type Matrix = SMatrix<f64, 6, 6>;
type Vector = SVector<f64, 6>;

/// Newton iterations of a step.
const ITERATIONS: usize = 40;

/// Relative residual at which a step is solved.
const TOLERANCE: f64 = 1e-10;

/// A step that fails is halved this many times, to 1/1024.
const HALVINGS: u32 = 10;

/// How a stage stands in its test.
pub(super) struct Place<'t> {
    /// Number of the stage.
    pub(super) number: usize,
    /// The stage.
    pub(super) stage: &'t TestStage,
}

/// Runs one stage; what was reached is recorded whether or not it ends well.
pub(super) fn stage(
    specimen: &mut Specimen,
    record: &mut Record,
    place: &Place<'_>,
    program: &Program,
) -> Result<(), DriverError> {
    let steps = place.stage.steps;
    let dt = place.stage.duration / (steps * program.parts.len().max(1)) as f64;
    record.pore = program.pore;
    for (part, control) in program.parts.iter().enumerate() {
        for step in 0..steps {
            let result = advance(specimen, record, control, dt, (step, steps));
            record.push_if_moved(specimen);
            let (stage, step) = (place.number, part * steps + step);
            result.map_err(|trouble| match trouble {
                Trouble::Law(source) => DriverError::Law { stage, step, source },
                Trouble::Singular => {
                    DriverError::Stage { stage, problem: "the motion of a step is singular".to_owned() }
                }
                Trouble::Row(row) => {
                    DriverError::LimitLoad { stage, step, row: format!("condition on {}", NAMES[row]) }
                }
            })?;
        }
    }
    Ok(())
}

/// One step of a part of a stage.
fn advance(
    specimen: &mut Specimen,
    record: &mut Record,
    control: &Control,
    dt: f64,
    (step, steps): (usize, usize),
) -> Result<(), Trouble> {
    let share = 1.0 / steps as f64;
    let motion = match control {
        Control::Mixed(conditions) => {
            let mixed = Mixed {
                stress: Matrix::from_fn(|i, j| conditions.stress[i][j]),
                strain: Matrix::from_fn(|i, j| conditions.strain[i][j]),
                total: Vector::from_column_slice(&conditions.amounts(step, steps)),
                shear_turns: conditions.shear_turns,
                spin: conditions.spin(steps),
            };
            return mixed.advance(specimen, record, dt, HALVINGS);
        }
        Control::Given(gradient) => specimen.motion(&(*gradient * share), dt),
        Control::Rotation(angle) => {
            let rotation = Mat3::rotation_z(*angle * share);
            Motion::from_deformation(&rotation, dt, specimen.density, 1.0)
        }
        Control::Deformation { from, to } => {
            let at = |step: usize| *from + (*to - *from) * (step as f64 * share);
            let relative = at(step).inverse().map(|inverse| at(step + 1) * inverse);
            relative
                .filter(|f| f.determinant() > 0.0)
                .and_then(|f| Motion::from_deformation(&f, dt, specimen.density / f.determinant(), 1.0))
        }
    };
    apply(specimen, record, &motion.ok_or(Trouble::Singular)?).map_err(Trouble::Law)
}

fn apply(specimen: &mut Specimen, record: &mut Record, motion: &Motion) -> Result<(), crate::MaterialError> {
    let before = specimen.clone();
    specimen.accept(motion, specimen.tried(motion)?);
    record.add(motion, &before, specimen);
    Ok(())
}

/// The six conditions must be independent for some elastic stiffness.
pub(super) fn check_rank(stress: &[[f64; 6]; 6], strain: &[[f64; 6]; 6]) -> Result<(), String> {
    // A generic positive stiffness stands for the material's.
    let stiffness = Matrix::from_fn(|i, j| {
        let volumetric = if i < 3 && j < 3 { 0.7 } else { 0.0 };
        if i == j { 1.3 + 0.01 * i as f64 + volumetric } else { volumetric }
    });
    let s = Matrix::from_fn(|i, j| stress[i][j]);
    let e = Matrix::from_fn(|i, j| strain[i][j]);
    let rank = (s * stiffness + e).rank(1e-9);
    if rank == 6 {
        Ok(())
    } else {
        Err(format!("the control is over- or under-constrained: rank {rank}, 6 is needed"))
    }
}

/// Residual, relative to the stresses that are subtracted in it, that is round-off.
const ROUND_OFF: f64 = 1e-12;

/// Why a step cannot be solved.
enum Trouble {
    /// The condition that cannot be met.
    Row(usize),
    /// The step turns the material inside out.
    Singular,
    /// What the law says.
    Law(crate::MaterialError),
}

struct Mixed {
    stress: Matrix,
    strain: Matrix,
    total: Vector,
    shear_turns: bool,
    spin: Mat3,
}

impl Mixed {
    /// Velocity gradient times step of the strain increment `e` (engineering shear).
    fn gradient(&self, e: &Vector) -> Mat3 {
        let mut a = Mat3([
            [e[0], 0.5 * e[3], 0.5 * e[5]],
            [0.5 * e[3], e[1], 0.5 * e[4]],
            [0.5 * e[5], 0.5 * e[4], e[2]],
        ]);
        if self.shear_turns {
            a.0[0][1] = e[3];
            a.0[1][0] = 0.0;
        }
        a + self.spin
    }

    /// One step, in halves where it does not converge.
    fn advance(
        &self,
        specimen: &mut Specimen,
        record: &mut Record,
        dt: f64,
        halvings: u32,
    ) -> Result<(), Trouble> {
        match self.solve(specimen, dt) {
            Ok(motion) => apply(specimen, record, &motion).map_err(Trouble::Law),
            Err(trouble) if halvings == 0 => Err(trouble),
            Err(_) => {
                let half = Self { total: self.total * 0.5, spin: self.spin * 0.5, ..*self };
                half.advance(specimen, record, 0.5 * dt, halvings - 1)?;
                half.advance(specimen, record, 0.5 * dt, halvings - 1)
            }
        }
    }

    fn solve(&self, specimen: &Specimen, dt: f64) -> Result<Motion, Trouble> {
        let still = specimen.motion(&Mat3::ZERO, dt).ok_or(Trouble::Singular)?;
        let initial = specimen.tangent(&still).map_err(Trouble::Law)?;
        let stiffness = (0..6).map(|i| initial.0[i][i].abs()).fold(1.0, f64::max);
        // Strain rows are brought to the size of stresses.
        let scale = Vector::from_fn(|i, _| if self.stress.row(i).norm() > 0.0 { 1.0 } else { stiffness });
        let largest = (0..6).map(|i| (self.total[i] * scale[i]).abs()).fold(0.0, f64::max);
        let size = largest.max(1e-6 * specimen.stress.norm()).max(1e-12 * stiffness);
        let residual = |e: &Vector| -> Result<(Vector, Motion), Trouble> {
            let motion = specimen.motion(&self.gradient(e), dt).ok_or(Trouble::Singular)?;
            let (stress, _) = specimen.tried(&motion).map_err(Trouble::Law)?;
            let change = Vector::from_column_slice(&(stress - specimen.stress).0);
            Ok(((self.stress * change + self.strain * e - self.total).component_mul(&scale), motion))
        };
        let mut e = Vector::zeros();
        let (mut r, mut motion) = residual(&e)?;
        for _ in 0..ITERATIONS {
            if r.amax() <= TOLERANCE * size {
                return Ok(motion);
            }
            let stuck = Trouble::Row(r.iamax());
            let tangent = specimen.tangent(&motion).map_err(Trouble::Law)?;
            let jacobian = self.stress * Matrix::from_fn(|i, j| tangent.0[i][j]) + self.strain;
            let jacobian = Matrix::from_fn(|i, j| jacobian[(i, j)] * scale[i]);
            // On an edge of a yield surface two conditions may become one: the shortest step serves both.
            let svd = jacobian.svd(true, true);
            let cut = 1e-9 * svd.singular_values.amax();
            let Ok(step) = svd.solve(&r, cut) else { return Err(stuck) };
            if !step.iter().all(|v| v.is_finite()) || step.amax() > 1.0 {
                return Err(stuck);
            }
            let mut length = 1.0;
            loop {
                let next = e - step * length;
                match residual(&next) {
                    Ok((new, at)) if new.norm() < r.norm() * (1.0 - 1e-4 * length) => {
                        (e, r, motion) = (next, new, at);
                        break;
                    }
                    _ if length < 1e-3 => {
                        // No better: fine at the round-off of the stresses, a failure above it.
                        let round_off = ROUND_OFF * (specimen.stress.norm() + stiffness * e.amax());
                        return if r.amax() <= round_off { Ok(motion) } else { Err(stuck) };
                    }
                    _ => length *= 0.5,
                }
            }
        }
        Err(Trouble::Row(r.iamax()))
    }
}
