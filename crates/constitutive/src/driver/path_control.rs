//! Loading paths as conditions on stress and strain increments.

use std::f64::consts::TAU;

use crate::driver::loading_path::{ControlledQuantity, LoadingPath};
use crate::{Mat3, SymTensor};

/// Names of the components, for messages.
pub(super) const NAMES: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "zx"];

/// Control of a stage, for its initial stress.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ControlSequence {
    /// Consecutive segments, each with the number of steps of the stage.
    pub(super) segments: Vec<Control>,
}

/// Control of a segment of a stage: six linear equations for each step, or the motion itself.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Control {
    /// Mixed control by `S Δσ + E Δε = ΔY`.
    Mixed(ControlEquations),
    /// Time integral of the velocity gradient.
    PrescribedGradient(Mat3),
    /// Rigid rotation about z (rad).
    Rotation(f64),
    /// Deformation gradient that changes from one value to another.
    Deformation {
        /// Deformation gradient at the start.
        from: Mat3,
        /// Deformation gradient at the end.
        to: Mat3,
    },
}

/// Equation of the pore pressure, `a·Δσ' + b·Δε + c Δp_w = 0`, and coefficients of the pore pressure in the other six equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PorePressureEquation {
    /// Coefficients `a` of the effective stress increment.
    pub(super) stress: [f64; 6],
    /// Coefficients `b` of the strain increment.
    pub(super) strain: [f64; 6],
    /// Coefficient `c` of the pore pressure.
    pub(super) pressure: f64,
    /// Coefficient of `Δp_w` in each of the six equations.
    pub(super) column: [f64; 6],
}

impl PorePressureEquation {
    /// Drained condition: constant pore pressure.
    const DRAINED: Self = Self { stress: [0.0; 6], strain: [0.0; 6], pressure: 1.0, column: [0.0; 6] };

    /// Undrained condition: the pore pressure follows from the volumetric strain and the stiffness `K_f/n` (Pa). Without a stiffness the
    /// volume is constant.
    fn undrained(fluid_stiffness: Option<f64>, stress: &[[f64; 6]; 6]) -> Self {
        let pressure = fluid_stiffness.map_or(0.0, f64::recip);
        // Rows of total stress, Δσ = Δσ' - Δp_w 1.
        let column = stress.map(|row| -(row[0] + row[1] + row[2]));
        Self { strain: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], pressure, column, ..Self::DRAINED }
    }
}

/// Six linear control equations between stress and engineering strain increments, with the total change over a segment as right-hand side.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ControlEquations {
    /// Coefficients of the stress components, one row per equation.
    pub(super) stress: [[f64; 6]; 6],
    /// Coefficients of the engineering strain components, one row per equation.
    pub(super) strain: [[f64; 6]; 6],
    /// Seventh equation, of the pore pressure.
    pub(super) pore: PorePressureEquation,
    /// Right-hand sides: total change of each controlled quantity over the segment.
    pub(super) total: [f64; 6],
    /// Amplitude of a quantity that changes by one period of a sine over the segment.
    pub(super) amplitude: [f64; 6],
    /// Phase of the sine (rad).
    pub(super) phase: [f64; 6],
    /// Whether the shear strain xy is simple shear, with rotation of the material.
    pub(super) is_simple_shear: bool,
    /// Angles of rotation about x, y, z (rad).
    pub(super) spin: [f64; 3],
}

impl ControlEquations {
    /// Equations of zero strain increments.
    fn zero_strain() -> Self {
        let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        Self {
            stress: [[0.0; 6]; 6],
            strain: std::array::from_fn(|i| std::array::from_fn(|j| unit(i, j))),
            pore: PorePressureEquation::DRAINED,
            total: [0.0; 6],
            amplitude: [0.0; 6],
            phase: [0.0; 6],
            is_simple_shear: false,
            spin: [0.0; 3],
        }
    }

    /// Prescribes the total change of a strain component.
    fn strain(mut self, component: usize, total: f64) -> Self {
        self.total[component] = total;
        self
    }

    /// Prescribes the total change of a stress component (Pa) in place of its strain.
    fn stress(mut self, component: usize, total: f64) -> Self {
        self.strain[component][component] = 0.0;
        self.stress[component][component] = 1.0;
        self.total[component] = total;
        self
    }

    /// Sets the motion to simple shear, with rotation of the shear strain.
    fn simple_shear(mut self) -> Self {
        self.is_simple_shear = true;
        self
    }

    /// Equations of undrained deformation, in which prescribed stresses are total stresses; see [`PorePressureEquation::undrained`].
    fn undrained(mut self, fluid_stiffness: Option<f64>) -> Self {
        self.pore = PorePressureEquation::undrained(fluid_stiffness, &self.stress);
        self
    }

    /// Equations in the units of the solver, from those of a file with tensorial shear strain and angles in degrees. `fluid_stiffness` is
    /// the stiffness `K_f/n` of undrained pore fluid (Pa).
    fn into_solver_units(mut self, fluid_stiffness: Option<f64>) -> Self {
        self.strain.iter_mut().for_each(|row| row[3..].iter_mut().for_each(|e| *e *= 0.5));
        self.phase = self.phase.map(f64::to_radians);
        self.spin = self.spin.map(f64::to_radians);
        match fluid_stiffness {
            Some(_) => self.undrained(fluid_stiffness),
            None => self,
        }
    }

    /// Right-hand sides of the equations in step `step` of `steps`.
    pub(super) fn right_hand_side(&self, step: usize, steps: usize) -> [f64; 6] {
        let share = 1.0 / steps as f64;
        let sine = |row: usize, step: usize| (TAU * step as f64 * share + self.phase[row]).sin();
        std::array::from_fn(|row| {
            let wave = self.amplitude[row];
            let cycle = if wave == 0.0 { 0.0 } else { wave * (sine(row, step + 1) - sine(row, step)) };
            self.total[row] * share + cycle
        })
    }

    /// Spin increment `dt W` of a step; the rotation of a step without strain is exact.
    pub(super) fn spin(&self, steps: usize) -> Mat3 {
        let [x, y, z] = self.spin.map(|angle| angle / steps as f64);
        let angle = (x * x + y * y + z * z).sqrt();
        if angle == 0.0 {
            return Mat3::ZERO;
        }
        Mat3([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) * (2.0 * (0.5 * angle).tan() / angle)
    }

    /// Equations of the reversed segment, with a fraction of the total changes.
    fn reversed(&self, fraction: f64) -> Self {
        let back = |amounts: [f64; 6]| amounts.map(|amount| -fraction * amount);
        Self {
            total: back(self.total),
            amplitude: back(self.amplitude),
            phase: self.phase.map(|phase| -phase),
            spin: self.spin.map(|angle| -fraction * angle),
            ..self.clone()
        }
    }
}

impl Control {
    /// Control of the reversed motion, by `fraction` of it.
    fn reversed(&self, fraction: f64) -> Self {
        match self {
            Self::Mixed(conditions) => Self::Mixed(conditions.reversed(fraction)),
            Self::PrescribedGradient(gradient) => Self::PrescribedGradient(*gradient * -fraction),
            Self::Rotation(angle) => Self::Rotation(-fraction * angle),
            Self::Deformation { from, to } => {
                Self::Deformation { from: *to, to: *to + (*from - *to) * fraction }
            }
        }
    }
}

impl ControlSequence {
    /// Sequence of the reversed segments in reversed order, by `fraction` of each.
    fn reversed(&self, fraction: f64) -> Self {
        let segments = self.segments.iter().rev().map(|part| part.reversed(fraction)).collect();
        Self { segments }
    }
}

impl LoadingPath {
    /// Control of the path from `stress`, within `duration` (s), after the stage `before`; `None` for a
    /// reversal of nothing.
    pub(super) fn program(
        &self,
        stress: &SymTensor,
        duration: f64,
        before: Option<&ControlSequence>,
    ) -> Option<ControlSequence> {
        let segments = match self {
            Self::Reversal { fraction } => return before.map(|stage| stage.reversed(*fraction)),
            Self::Direct { control, increments, spins } => direct_control(control, increments, spins),
            Self::Flow { velocity_gradient } => {
                vec![Control::PrescribedGradient(Mat3(*velocity_gradient) * duration)]
            }
            Self::DeformationGradient { deformation } => {
                vec![Control::Deformation { from: Mat3::IDENTITY, to: Mat3(*deformation) }]
            }
            Self::Relaxation {} => vec![Control::PrescribedGradient(Mat3::ZERO)],
            Self::Rotation { angle } => vec![Control::Rotation(angle.to_radians())],
            mixed => vec![Control::Mixed(mixed.conditions(stress))],
        };
        Some(ControlSequence { segments })
    }

    /// Six equations of a path controlled by equations.
    fn conditions(&self, start: &SymTensor) -> ControlEquations {
        let still = ControlEquations::zero_strain;
        match *self {
            Self::Isotropic { pressure } => {
                let to = |c: usize| -pressure - start[c];
                still().stress(0, to(0)).stress(1, to(1)).stress(2, to(2))
            }
            Self::Oedometer { axial_compression } => still().strain(2, -axial_compression),
            Self::TriaxialDrained { axial_compression: amount } => {
                still().stress(0, 0.0).stress(1, 0.0).strain(2, -amount)
            }
            Self::TriaxialExtension { axial_extension: amount } => {
                still().stress(0, 0.0).stress(1, 0.0).strain(2, amount)
            }
            Self::TriaxialUndrained { axial_compression: amount, fluid_stiffness } => {
                let rows = still().stress(0, 0.0).stress(1, 0.0).strain(2, -amount);
                rows.undrained(fluid_stiffness)
            }
            Self::TrueTriaxial { axial_compression, b } => {
                let mut rows = still().stress(0, 0.0).stress(1, 0.0).strain(2, -axial_compression);
                rows.stress[1] = [b - 1.0, 1.0, -b, 0.0, 0.0, 0.0];
                rows
            }
            Self::BiaxialPlaneStrain { axial_compression } => {
                still().stress(0, 0.0).strain(1, -axial_compression)
            }
            Self::SimpleShearConstantVolume { shear } => {
                // As for undrained loading at constant total normal stress.
                let stress = [0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
                let pore = PorePressureEquation { stress, pressure: -1.0, ..PorePressureEquation::DRAINED };
                ControlEquations { pore, ..still().strain(3, shear).simple_shear() }
            }
            Self::SimpleShearConstantNormalStress { shear } => {
                still().stress(1, 0.0).strain(3, shear).simple_shear()
            }
            Self::SimpleShearStress { shear_stress } => {
                still().stress(1, 0.0).stress(3, shear_stress).simple_shear()
            }
            Self::Strain { increment } => ControlEquations { total: engineering(&increment), ..still() },
            Self::Stress { increment } => (0..6).fold(still(), |rows, c| rows.stress(c, increment[c])),
            Self::General { stress, strain, total, amplitude, phase, spin, fluid_stiffness } => {
                let rows = ControlEquations { stress, strain, total, amplitude, phase, spin, ..still() };
                rows.into_solver_units(fluid_stiffness)
            }
            Self::Creep {} => (0..6).fold(still(), |rows, c| rows.stress(c, 0.0)),
            // The others have no equations; see `program`.
            Self::Reversal { .. }
            | Self::Direct { .. }
            | Self::Flow { .. }
            | Self::DeformationGradient { .. }
            | Self::Relaxation {}
            | Self::Rotation { .. } => still(),
        }
    }
}

/// Engineering strain of a tensorial strain: shear components are doubled.
fn engineering(strain: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|c| if c < 3 { strain[c] } else { 2.0 * strain[c] })
}

/// Segments with strain or stress prescribed for each component, one per row of `increments`, with spins in degrees.
fn direct_control(
    control: &[ControlledQuantity; 6],
    increments: &[[f64; 6]],
    spins: &[[f64; 3]],
) -> Vec<Control> {
    let part = |(number, increment): (usize, &[f64; 6])| {
        let strain = engineering(increment);
        let rows = (0..6).fold(ControlEquations::zero_strain(), |rows, c| match control[c] {
            ControlledQuantity::Strain => rows.strain(c, strain[c]),
            ControlledQuantity::Stress => rows.stress(c, increment[c]),
        });
        let spin = spins.get(number).map_or([0.0; 3], |spin| spin.map(f64::to_radians));
        Control::Mixed(ControlEquations { spin, ..rows })
    };
    increments.iter().enumerate().map(part).collect()
}
