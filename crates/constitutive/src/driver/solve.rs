//! The step solve of the element driver.

use nalgebra::{SMatrix, SVector};

use super::path::{Control, NAMES};
use super::{DriverError, Record, Specimen, TestStage};
use crate::{Mat3, Motion};

type Matrix = SMatrix<f64, 6, 6>;
type Vector = SVector<f64, 6>;

/// Newton iterations of a step.
const ITERATIONS: usize = 40;

/// Relative residual at which a step is solved.
const TOLERANCE: f64 = 1e-10;

/// A step that fails is halved this many times, to 1/1024.
const HALVINGS: u32 = 10;

/// Runs one stage.
pub(super) fn stage(
    specimen: &mut Specimen,
    record: &mut Record,
    number: usize,
    stage: &TestStage,
) -> Result<(), DriverError> {
    let dt = stage.duration / stage.steps as f64;
    let control = stage.path.control(&specimen.stress, stage.steps, dt);
    if let Control::Mixed { stress, strain, .. } = &control {
        check_rank(stress, strain).map_err(|problem| DriverError::Stage { stage: number, problem })?;
    }
    for step in 0..stage.steps {
        let law = |source| DriverError::Law { stage: number, step, source };
        let invalid =
            || DriverError::Stage { stage: number, problem: "the motion of a step is singular".to_owned() };
        match &control {
            Control::Given(gradient) => {
                let motion = specimen.motion(gradient, dt).ok_or_else(invalid)?;
                apply(specimen, record, &motion).map_err(law)?;
            }
            Control::Rotation(angle) => {
                let density = specimen.density;
                let rotation = Mat3::rotation_z(*angle);
                let motion = Motion::from_deformation(&rotation, dt, density, 1.0).ok_or_else(invalid)?;
                apply(specimen, record, &motion).map_err(law)?;
            }
            Control::Mixed { stress, strain, total, shear_turns } => {
                let mixed = Mixed {
                    stress: Matrix::from_fn(|i, j| stress[i][j]),
                    strain: Matrix::from_fn(|i, j| strain[i][j]),
                    total: Vector::from_column_slice(total),
                    shear_turns: *shear_turns,
                };
                mixed.advance(specimen, record, dt, HALVINGS).map_err(|trouble| match trouble {
                    Trouble::Law(source) => law(source),
                    Trouble::Row(row) => {
                        let row = format!("condition on {}", NAMES[row]);
                        DriverError::LimitLoad { stage: number, step, row }
                    }
                })?;
            }
        }
        record.push(specimen);
    }
    Ok(())
}

fn apply(specimen: &mut Specimen, record: &mut Record, motion: &Motion) -> Result<(), crate::MaterialError> {
    let new = specimen.tried(motion)?;
    record.add(motion.dt, &motion.strain_increment(), &specimen.stress, &new.0);
    specimen.accept(motion, new);
    Ok(())
}

/// The six conditions must be independent for some elastic stiffness.
fn check_rank(stress: &[[f64; 6]; 6], strain: &[[f64; 6]; 6]) -> Result<(), String> {
    // A generic positive stiffness stands for the material's.
    let stiffness = Matrix::from_fn(|i, j| {
        let volumetric = if i < 3 && j < 3 { 0.7 } else { 0.0 };
        if i == j { 1.3 + 0.01 * i as f64 + volumetric } else { volumetric }
    });
    let s = Matrix::from_fn(|i, j| stress[i][j]);
    let e = Matrix::from_fn(|i, j| strain[i][j]);
    let finite = s.iter().chain(e.iter()).all(|v| v.is_finite());
    let rank = if finite { (s * stiffness + e).rank(1e-9) } else { 0 };
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
    /// What the law says.
    Law(crate::MaterialError),
}

struct Mixed {
    stress: Matrix,
    strain: Matrix,
    total: Vector,
    shear_turns: bool,
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
        a
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
                let half =
                    Self { total: self.total * 0.5, stress: self.stress, strain: self.strain, ..*self };
                half.advance(specimen, record, 0.5 * dt, halvings - 1)?;
                half.advance(specimen, record, 0.5 * dt, halvings - 1)
            }
        }
    }

    fn solve(&self, specimen: &Specimen, dt: f64) -> Result<Motion, Trouble> {
        let still = specimen.motion(&Mat3::ZERO, dt).ok_or(Trouble::Row(0))?;
        let initial = specimen.tangent(&still).map_err(Trouble::Law)?;
        let stiffness = (0..6).map(|i| initial.0[i][i].abs()).fold(1.0, f64::max);
        // Strain rows are brought to the size of stresses.
        let scale = Vector::from_fn(|i, _| if self.stress.row(i).norm() > 0.0 { 1.0 } else { stiffness });
        let largest = (0..6).map(|i| (self.total[i] * scale[i]).abs()).fold(0.0, f64::max);
        let size = largest.max(1e-6 * specimen.stress.norm()).max(1e-12 * stiffness);
        let residual = |e: &Vector| -> Result<(Vector, Motion), Trouble> {
            let motion = specimen.motion(&self.gradient(e), dt).ok_or(Trouble::Row(0))?;
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
