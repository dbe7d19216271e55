//! Contract of every law with its callers (sheet: constitutive §3.1), tested on every registered law
//! without naming one.
//!
//! Round-off is measured against the stress of a step: the stress before it plus that of its
//! elastic trial, `‖σ‖ + M ‖Δε‖` with the wave modulus `M` (the larger of both ends where stiffness
//! depends on pressure).

mod batches_and_states;
mod laws;
mod objectivity;
mod steps;
mod stress_bounds;
mod tangents;

use std::sync::Arc;

use colluvium_constitutive::{
    InitialCondition, Mat3, Material, MaterialSpec, Motion, StateBlock, States, SymTensor, Tangent,
};
use proptest::prelude::*;

/// Law under test and initial stress of its points.
struct Subject {
    spec: MaterialSpec,
    law: Arc<dyn Material>,
    start: SymTensor,
    /// Factor of the steps of all paths.
    scale: f64,
}

/// Single point on a path.
#[derive(Clone)]
struct TestPoint {
    stress: SymTensor,
    states: States,
    density: f64,
}

impl Subject {
    fn name(&self) -> String {
        format!("{:?}", self.spec)
    }

    fn point(&self) -> TestPoint {
        self.point_at(self.start)
    }

    fn point_at(&self, stress: SymTensor) -> TestPoint {
        let density = self.spec.density();
        let (stress, states) = self.law.initial(&[InitialCondition { stress, density }]).expect("admissible");
        TestPoint { stress: stress[0], states, density }
    }

    fn step(&self, point: &TestPoint, gradient: &Mat3, dt: f64) -> TestPoint {
        self.apply(point, &self.motion(gradient, dt, point.density))
    }

    /// Motion with mid-step gradient `a`, scaled, density following from the volume.
    fn motion(&self, a: &Mat3, dt: f64, density: f64) -> Motion {
        motion(&(*a * self.scale), dt, density)
    }

    fn end_of_path(&self, path: &[Mat3], dt: f64) -> TestPoint {
        path.iter().fold(self.point(), |point, a| self.step(&point, a, dt))
    }

    fn apply(&self, point: &TestPoint, motion: &Motion) -> TestPoint {
        match self.try_apply(point, motion) {
            Ok(new) => new,
            Err(error) => {
                panic!("{}: {error} at {:?}, {:?}", self.name(), point.stress, motion.velocity_gradient_dt)
            }
        }
    }

    fn try_apply(&self, point: &TestPoint, motion: &Motion) -> Result<TestPoint, String> {
        let mut new = point.clone();
        let mut stress = [point.stress];
        let block = &mut new.states.blocks_mut()[0];
        self.law.update(std::slice::from_ref(motion), &mut stress, block).map_err(|e| e.to_string())?;
        new.stress = stress[0];
        new.density = motion.density;
        Ok(new)
    }

    fn yield_value(&self, point: &TestPoint) -> f64 {
        value_of(point, |stress, block, out| self.law.yield_values(stress, block, out))
    }

    fn energy(&self, point: &TestPoint) -> f64 {
        value_of(point, |stress, block, out| {
            self.law.stored_energies(stress, block, out);
        })
    }

    /// Scale of the stress in a step (Pa): initial stress plus its elastic trial.
    fn stress_scale(&self, point: &TestPoint, motion: &Motion) -> f64 {
        let modulus = value_of(point, |stress, block, out| self.law.wave_moduli(stress, block, out));
        point.stress.norm() + modulus * motion.velocity_gradient_dt.sym().norm()
    }

    /// Point after the end of motion: a viscous stress ends with the motion, so for laws with a viscosity
    /// the remaining stress is the one that rest and rigid rotations must not change.
    fn stopped(&self, point: TestPoint) -> TestPoint {
        let viscous = value_of(&point, |stress, block, out| self.law.viscosities(stress, block, out)) > 0.0;
        if viscous && self.is_solid() { self.step(&point, &Mat3::ZERO, 1e-3) } else { point }
    }

    /// Whether the law is a solid: fluids have no memory of shear, so some tests of solids do not apply to them.
    fn is_solid(&self) -> bool {
        !self.spec.is_fluid()
    }

    fn tangent(&self, motion: &Motion, point: &TestPoint) -> Tangent {
        self.law.tangent(motion, &point.stress, &point.states.blocks()[0], 0).expect("a tangent")
    }
}

fn value_of(point: &TestPoint, read: impl Fn(&[SymTensor], &StateBlock, &mut [f64])) -> f64 {
    let mut out = [0.0];
    read(&[point.stress], &point.states.blocks()[0], &mut out);
    out[0]
}

/// Motion with mid-step gradient `a`, density following from the volume.
fn motion(a: &Mat3, dt: f64, density: f64) -> Motion {
    let mut motion = Motion::from_velocity_gradient(&(*a * (1.0 / dt)), dt, density, 0.1).expect("moderate");
    motion.density = density / motion.deformation.determinant();
    motion
}

fn gradients(count: usize, size: f64) -> impl Strategy<Value = Vec<Mat3>> {
    let entry = -size..size;
    let matrix = proptest::array::uniform3(proptest::array::uniform3(entry)).prop_map(Mat3);
    proptest::collection::vec(matrix, 1..=count)
}
