//! Solution of a step of the element driver.

use nalgebra::{SMatrix, SVector};

use crate::driver::element_path::PathRecorder;
use crate::driver::path_control::{Control, ControlEquations, ControlSequence, NAMES};
use crate::driver::{DriverError, ElementSpecimen, TestStage};
use crate::{Mat3, Motion, SymTensor, Tangent};

/// Matrix of the seven unknowns, strain increment (engineering shear) and pore pressure, and their equations.
type Matrix7 = SMatrix<f64, 7, 7>;
/// Vector of six strain or stress components and the pore pressure.
type Vector7 = SVector<f64, 7>;

/// Largest number of Newton iterations of a step.
const ITERATIONS: usize = 40;

/// Relative residual at which a step is solved.
const TOLERANCE: f64 = 1e-10;

/// Largest number of halvings of a step that fails, to 1/1024.
const HALVINGS: u32 = 10;

/// Stage with its number in the test.
pub(super) struct StageContext<'t> {
    /// Number of the stage.
    pub(super) number: usize,
    /// Stage of the test.
    pub(super) stage: &'t TestStage,
}

/// Runs a stage and records its steps, up to the last converged one if it fails.
pub(super) fn run_stage(
    specimen: &mut ElementSpecimen,
    record: &mut PathRecorder,
    place: &StageContext<'_>,
    program: &ControlSequence,
) -> Result<(), DriverError> {
    let steps = place.stage.steps;
    let dt = place.stage.duration / (steps * program.segments.len().max(1)) as f64;
    for (part, control) in program.segments.iter().enumerate() {
        for step in 0..steps {
            let result = advance(specimen, record, control, dt, (step, steps));
            record.push_if_moved(specimen);
            let (stage, step) = (place.number, part * steps + step);
            result.map_err(|trouble| match trouble {
                StepError::Law(source) => DriverError::Law { stage, step, source },
                StepError::Singular => {
                    DriverError::Stage { stage, problem: "the motion of a step is singular".to_owned() }
                }
                StepError::Row(row) => {
                    let name = NAMES.get(row).copied().unwrap_or("the pore pressure");
                    DriverError::LimitLoad { stage, step, row: format!("condition on {name}") }
                }
            })?;
        }
    }
    Ok(())
}

/// Advances a step of a segment of a stage.
fn advance(
    specimen: &mut ElementSpecimen,
    record: &mut PathRecorder,
    control: &Control,
    dt: f64,
    (step, steps): (usize, usize),
) -> Result<(), StepError> {
    let share = 1.0 / steps as f64;
    let motion = match control {
        Control::Mixed(conditions) => {
            let mixed = MixedControl {
                equations: ControlSystem::from_conditions(conditions),
                total: Vector7::from_iterator(
                    conditions.right_hand_side(step, steps).into_iter().chain([0.0]),
                ),
                shear_turns: conditions.is_simple_shear,
                spin: conditions.spin(steps),
            };
            return mixed.advance(specimen, record, dt, HALVINGS);
        }
        Control::PrescribedGradient(gradient) => specimen.motion(&(*gradient * share), dt),
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
    apply_step(specimen, record, &motion.ok_or(StepError::Singular)?, 0.0).map_err(StepError::Law)
}

/// Applies the step, which changes the pore pressure by `pore` (Pa).
fn apply_step(
    specimen: &mut ElementSpecimen,
    record: &mut PathRecorder,
    motion: &Motion,
    pore: f64,
) -> Result<(), crate::MaterialError> {
    let before = specimen.clone();
    specimen.accept(motion, specimen.trial_update(motion)?);
    record.add(motion, pore, &before, specimen);
    Ok(())
}

/// Linear system `S Δσ' + E Δε + P Δp_w = ΔY` of a step, whose last equation is that of the pore pressure.
#[derive(Clone, Copy)]
struct ControlSystem {
    /// Matrix S; its last column is unused.
    stress: Matrix7,
    /// Matrix E, with P as its last column.
    strain_coefficients: Matrix7,
}

impl ControlSystem {
    /// Matrices 7 × 7 of the control equations, with the pore pressure as the seventh unknown.
    fn from_conditions(conditions: &ControlEquations) -> Self {
        let ControlEquations { stress, strain, pore, .. } = conditions;
        let entry = |row: usize, column: usize, six: &[[f64; 6]; 6], last: &[f64; 6]| match (row, column) {
            (_, 6) => 0.0,
            (6, _) => last[column],
            _ => six[row][column],
        };
        let stress = Matrix7::from_fn(|i, j| entry(i, j, stress, &pore.stress));
        let mut strain_coefficients = Matrix7::from_fn(|i, j| entry(i, j, strain, &pore.strain));
        for row in 0..6 {
            strain_coefficients[(row, 6)] = pore.column[row];
        }
        strain_coefficients[(6, 6)] = pore.pressure;
        Self { stress, strain_coefficients }
    }

    /// Derivative of the residual by the unknowns at the stiffness `tangent`.
    fn jacobian(&self, tangent: &Tangent) -> Matrix7 {
        let stiffness = Matrix7::from_fn(|i, j| if i < 6 && j < 6 { tangent.0[i][j] } else { 0.0 });
        self.stress * stiffness + self.strain_coefficients
    }
}

/// Checks that the control equations are independent, for some elastic stiffness.
pub(super) fn check_rank(conditions: &ControlEquations) -> Result<(), String> {
    // A generic positive stiffness replaces the material's.
    let stiffness = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let volumetric = if i < 3 && j < 3 { 0.7 } else { 0.0 };
            if i == j { 1.3 + 0.01 * i as f64 + volumetric } else { volumetric }
        })
    });
    // The pore pressure is added to the six; against this stiffness that of a fluid is zero.
    let mut jacobian = ControlSystem::from_conditions(conditions).jacobian(&Tangent(stiffness));
    if conditions.pore.strain != [0.0; 6] {
        jacobian[(6, 6)] = 0.0;
    }
    let rank = jacobian.rank(1e-9);
    if rank == 7 {
        Ok(())
    } else {
        Err(format!(
            "the control is over- or under-constrained: rank {}, 6 is needed",
            rank.saturating_sub(1)
        ))
    }
}

/// Scale factors of the equations and unknowns of a step, by which all terms have the same magnitude.
struct StepScaling {
    /// Largest stiffness at the start of the step (Pa).
    stiffness: f64,
    /// Factors of the equations: rows of strain are scaled to the size of stresses.
    rows: Vector7,
    /// Factors of the unknowns: the pore pressure is scaled to the size of strains.
    unknowns: Vector7,
}

impl StepScaling {
    /// Scales of equations and unknowns by the largest diagonal stiffness of the tangent (Pa).
    fn new(equations: &ControlSystem, tangent: &Tangent) -> Self {
        let stiffness = (0..6).map(|i| tangent.0[i][i].abs()).fold(1.0, f64::max);
        let ControlSystem { stress, strain_coefficients } = equations;
        let of_strain =
            |i: usize| stress.row(i).norm() == 0.0 && strain_coefficients.row(i).columns(0, 6).norm() > 0.0;
        let rows = Vector7::from_fn(|i, _| if of_strain(i) { stiffness } else { 1.0 });
        let unknowns = Vector7::from_fn(|j, _| if j == 6 { stiffness } else { 1.0 });
        Self { stiffness, rows, unknowns }
    }

    /// Scaled derivative of the residual by the unknowns, from the tangent of the law.
    fn jacobian(
        &self,
        equations: &ControlSystem,
        specimen: &ElementSpecimen,
        motion: &Motion,
    ) -> Result<Matrix7, StepError> {
        let tangent = specimen.tangent(motion).map_err(StepError::Law)?;
        let jacobian = equations.jacobian(&tangent);
        Ok(Matrix7::from_fn(|i, j| jacobian[(i, j)] * self.rows[i] * self.unknowns[j]))
    }
}

/// Tolerance of the residual for round-off, relative to the stresses of which it is the difference.
const ROUND_OFF: f64 = 1e-12;

/// Reason why a step cannot be solved.
enum StepError {
    /// Row of the condition that cannot be satisfied.
    Row(usize),
    /// Singular deformation: the step inverts the material.
    Singular,
    /// Error of the law.
    Law(crate::MaterialError),
}

/// Control equations of a segment with their right-hand sides and the spin of the motion.
struct MixedControl {
    equations: ControlSystem,
    total: Vector7,
    shear_turns: bool,
    spin: Mat3,
}

impl MixedControl {
    /// Velocity gradient times step of the strain increment `e` (engineering shear).
    fn gradient(&self, e: &Vector7) -> Mat3 {
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

    /// Solves a step by Newton's method, and divides it into halves if the iteration does not converge.
    fn advance(
        &self,
        specimen: &mut ElementSpecimen,
        record: &mut PathRecorder,
        dt: f64,
        halvings: u32,
    ) -> Result<(), StepError> {
        // A foreign library may return a tangent that is not that of its step, such as the elastic one.
        let by_differences = |_| self.solve(specimen, dt, Derivative::Differences);
        match self.solve(specimen, dt, Derivative::Tangent).or_else(by_differences) {
            Ok((motion, pore)) => apply_step(specimen, record, &motion, pore).map_err(StepError::Law),
            Err(trouble) if halvings == 0 => Err(trouble),
            Err(_) => {
                let half = Self { total: self.total * 0.5, spin: self.spin * 0.5, ..*self };
                half.advance(specimen, record, 0.5 * dt, halvings - 1)?;
                half.advance(specimen, record, 0.5 * dt, halvings - 1)
            }
        }
    }

    /// Magnitude of the terms of the scaled residual (Pa).
    fn magnitude(&self, specimen: &ElementSpecimen, scaling: &StepScaling) -> f64 {
        let largest = self.total.component_mul(&scaling.rows).amax();
        largest.max(1e-6 * specimen.stress.norm()).max(1e-12 * scaling.stiffness)
    }

    /// Scaled residual of the equations at the unknowns `x`, and the motion of the step.
    fn residual(
        &self,
        specimen: &ElementSpecimen,
        scaling: &StepScaling,
        dt: f64,
        x: &Vector7,
    ) -> Result<(Vector7, Motion), StepError> {
        let motion = specimen.motion(&self.gradient(x), dt).ok_or(StepError::Singular)?;
        let (new, _) = specimen.trial_update(&motion).map_err(StepError::Law)?;
        let change = stress_vector(&(new - specimen.stress));
        let ControlSystem { stress, strain_coefficients } = &self.equations;
        let left = stress * change + strain_coefficients * x.component_mul(&scaling.unknowns);
        Ok(((left - self.total).component_mul(&scaling.rows), motion))
    }

    /// Motion of the step, and the change of the pore pressure (Pa).
    fn solve(
        &self,
        specimen: &ElementSpecimen,
        dt: f64,
        derivative: Derivative,
    ) -> Result<(Motion, f64), StepError> {
        let still = specimen.motion(&Mat3::ZERO, dt).ok_or(StepError::Singular)?;
        let initial = specimen.tangent(&still).map_err(StepError::Law)?;
        let scaling = StepScaling::new(&self.equations, &initial);
        let stiffness = scaling.stiffness;
        let size = self.magnitude(specimen, &scaling);
        let accepted = (TOLERANCE * size).max(specimen.material.stress_tolerance() * specimen.stress.norm());
        let residual = |x: &Vector7| self.residual(specimen, &scaling, dt, x);
        // With all strains prescribed only the law can fail; it counts as failed where it rejects the
        // shortest step tried.
        let prescribed = self.equations.stress.rows(0, 6).iter().all(|entry| *entry == 0.0);
        let mut refused = None;
        let mut x = Vector7::zeros();
        let (mut r, mut motion) = residual(&x)?;
        for _ in 0..ITERATIONS {
            if r.amax() <= accepted {
                return Ok((motion, x[6] * stiffness));
            }
            let stuck = StepError::Row(r.iamax());
            let jacobian = match derivative {
                Derivative::Tangent => scaling.jacobian(&self.equations, specimen, &motion)?,
                Derivative::Differences => {
                    difference_jacobian(|x| residual(x).map(|(r, _)| r), &x, &r, size / stiffness)?
                }
            };
            let Some(step) = newton_step(jacobian, &r) else { return Err(stuck) };
            let mut length = 1.0;
            loop {
                let next = x - step * length;
                match residual(&next) {
                    Ok((new, at)) if new.norm() < r.norm() * (1.0 - 1e-4 * length) => {
                        (x, r, motion) = (next, new, at);
                        break;
                    }
                    Ok(_) if prescribed => {}
                    tried => refused = tried.err(),
                }
                if length < 1e-3 {
                    // No improvement: converged at the round-off of the stresses, a failure above it.
                    let round_off = ROUND_OFF * (specimen.stress.norm() + stiffness * x.amax());
                    let solved = r.amax() <= round_off;
                    return if solved {
                        Ok((motion, x[6] * stiffness))
                    } else {
                        Err(refused.unwrap_or(stuck))
                    };
                }
                length *= 0.5;
            }
        }
        let refused = refused.filter(|_| prescribed);
        Err(refused.unwrap_or(StepError::Row(r.iamax())))
    }
}

/// Step of Newton's method; `None` where it is not finite or strains by more than one.
fn newton_step(jacobian: Matrix7, r: &Vector7) -> Option<Vector7> {
    // On an edge of a yield surface two conditions may coincide: the shortest step satisfies both.
    let svd = jacobian.svd(true, true);
    let cut = 1e-9 * svd.singular_values.amax();
    let step = svd.solve(r, cut).ok()?;
    (step.iter().all(|v| v.is_finite()) && step.rows(0, 6).amax() <= 1.0).then_some(step)
}

/// Derivative of the residual in Newton's method.
#[derive(Clone, Copy)]
enum Derivative {
    /// From the tangent of the law.
    Tangent,
    /// By forward differences of the residual.
    Differences,
}

/// Step of forward differences over the magnitude of the unknowns: their errors by curvature and by round-off are equal near it.
const DIFFERENCE: f64 = 1e-7;

/// Derivative of the residual `r` at `x` by forward differences; `scale` is the magnitude of the unknowns.
fn difference_jacobian(
    residual: impl Fn(&Vector7) -> Result<Vector7, StepError>,
    x: &Vector7,
    r: &Vector7,
    scale: f64,
) -> Result<Matrix7, StepError> {
    let mut jacobian = Matrix7::zeros();
    for j in 0..7 {
        let step = DIFFERENCE * x[j].abs().max(scale);
        let mut moved = *x;
        moved[j] += step;
        jacobian.set_column(j, &((residual(&moved)? - r) / step));
    }
    Ok(jacobian)
}

/// Vector of the stress components with a zero for the pore pressure.
fn stress_vector(stress: &SymTensor) -> Vector7 {
    Vector7::from_iterator(stress.0.into_iter().chain([0.0]))
}
