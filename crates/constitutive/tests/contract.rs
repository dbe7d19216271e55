//! What every law owes its callers (constitutive sheet §3.1), held against every registered law
//! without naming one.

use std::sync::Arc;

use colluvium_constitutive::{
    InitialCondition, Mat3, Material, MaterialSpec, Motion, StateBlock, States, SymTensor,
};
use proptest::prelude::*;

/// A law and the stress its points start from.
struct Subject {
    spec: MaterialSpec,
    law: Arc<dyn Material>,
    start: SymTensor,
}

/// A single point on its way.
#[derive(Clone)]
struct Walker {
    stress: SymTensor,
    states: States,
    density: f64,
}

fn subjects() -> Vec<Subject> {
    let subject = |spec: MaterialSpec| {
        let law = spec.build().expect("an example builds");
        Subject { start: SymTensor::isotropic(-50e3), spec, law }
    };
    MaterialSpec::examples().into_iter().map(subject).collect()
}

impl Subject {
    fn walker(&self) -> Walker {
        let density = self.spec.density();
        let (stress, states) =
            self.law.initial(&[InitialCondition { stress: self.start, density }]).expect("admissible");
        Walker { stress: stress[0], states, density }
    }

    fn step(&self, walker: &Walker, gradient: &Mat3, dt: f64) -> Option<Walker> {
        let motion = motion(gradient, dt, walker.density)?;
        self.apply(walker, &motion)
    }

    fn apply(&self, walker: &Walker, motion: &Motion) -> Option<Walker> {
        let mut new = walker.clone();
        let mut stress = [walker.stress];
        self.law.update(std::slice::from_ref(motion), &mut stress, &mut new.states.blocks_mut()[0]).ok()?;
        new.stress = stress[0];
        new.density = motion.density;
        Some(new)
    }

    fn yield_value(&self, walker: &Walker) -> f64 {
        one(walker, |stress, block, out| self.law.yield_values(stress, block, out))
    }

    fn energy(&self, walker: &Walker) -> f64 {
        one(walker, |stress, block, out| {
            self.law.stored_energies(stress, block, out);
        })
    }

    /// Fluids have no memory of shear, so some of what holds for solids does not for them.
    fn is_solid(&self) -> bool {
        one(&self.walker(), |stress, block, out| self.law.viscosities(stress, block, out)) == 0.0
    }
}

fn one(walker: &Walker, read: impl Fn(&[SymTensor], &StateBlock, &mut [f64])) -> f64 {
    let mut out = [0.0];
    read(&[walker.stress], &walker.states.blocks()[0], &mut out);
    out[0]
}

/// Motion with mid-step gradient `a`, density following the volume.
fn motion(a: &Mat3, dt: f64, density: f64) -> Option<Motion> {
    let mut motion = Motion::from_velocity_gradient(&(*a * (1.0 / dt)), dt, density, 0.1)?;
    motion.density = density / motion.deformation.determinant();
    Some(motion)
}

/// The same motion seen by an observer turned by `q`.
fn turned(motion: &Motion, q: &Mat3) -> Motion {
    let turn = |m: &Mat3| *q * *m * q.transpose();
    Motion { deformation: turn(&motion.deformation), gradient: turn(&motion.gradient), ..*motion }
}

fn gradients(count: usize, size: f64) -> impl Strategy<Value = Vec<Mat3>> {
    let entry = -size..size;
    let matrix = proptest::array::uniform3(proptest::array::uniform3(entry)).prop_map(Mat3);
    proptest::collection::vec(matrix, 1..=count)
}

fn rotation() -> impl Strategy<Value = Mat3> {
    (0.0..6.2f64, 0.0..6.2f64, 0.0..6.2f64).prop_map(|(a, b, c)| {
        let (s, k) = b.sin_cos();
        let tilt = Mat3([[1.0, 0.0, 0.0], [0.0, k, -s], [0.0, s, k]]);
        Mat3::rotation_z(a) * tilt * Mat3::rotation_z(c)
    })
}

/// Scale of stress below which differences mean nothing (Pa).
const SCALE: f64 = 1e4;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn no_motion_changes_nothing(path in gradients(3, 0.05)) {
        for subject in subjects() {
            let mut walker = subject.walker();
            for a in &path {
                let Some(next) = subject.step(&walker, a, 1e-3) else { break };
                walker = next;
            }
            let still = subject.step(&walker, &Mat3::ZERO, 1e-3).expect("standing still is always possible");
            if subject.is_solid() {
                let change = (still.stress - walker.stress).norm();
                // A return ends within round-off of the surface, and is returned again from there.
                prop_assert!(change <= 1e-11 * walker.stress.norm().max(SCALE), "{}: {change}", subject.law.name());
            } else {
                prop_assert!(still.stress.deviator().norm() <= 1e-9 * SCALE, "a resting fluid carries no shear");
            }
        }
    }

    #[test]
    fn a_turned_observer_sees_the_turned_stress(path in gradients(4, 0.1), q in rotation()) {
        for subject in subjects() {
            let (mut here, mut there) = (subject.walker(), subject.walker());
            for a in &path {
                let Some(motion) = motion(a, 1e-2, here.density) else { break };
                let (Some(next), Some(seen)) = (subject.apply(&here, &motion), subject.apply(&there, &turned(&motion, &q))) else { break };
                (here, there) = (next, seen);
                let difference = (there.stress - here.stress.rotated(&q)).norm();
                prop_assert!(difference <= 1e-8 * here.stress.norm().max(SCALE), "{}: {difference}", subject.law.name());
            }
        }
    }

    #[test]
    fn a_rigid_turn_turns_the_stress(path in gradients(3, 0.05), q in rotation()) {
        for subject in subjects().iter().filter(|s| s.is_solid()) {
            let mut walker = subject.walker();
            for a in &path {
                let Some(next) = subject.step(&walker, a, 1e-3) else { break };
                walker = next;
            }
            let Some(motion) = Motion::from_deformation(&q, 1e-3, walker.density, 0.1) else { continue };
            if motion.gradient.0.as_flattened().iter().any(|g| g.abs() > 1e3) {
                continue; // Half a turn in one step has no spin of finite size.
            }
            let Some(after) = subject.apply(&walker, &motion) else { continue };
            let difference = (after.stress - walker.stress.rotated(&q)).norm();
            prop_assert!(difference <= 1e-7 * walker.stress.norm().max(SCALE), "{}: {difference}", subject.law.name());
        }
    }

    #[test]
    fn stress_stays_finite_and_inside_the_yield_surface(path in gradients(6, 0.1)) {
        for subject in subjects() {
            let mut walker = subject.walker();
            for a in &path {
                let Some(next) = subject.step(&walker, a, 1e-3) else { break };
                prop_assert!(next.stress.is_finite(), "{}", subject.law.name());
                let excess = subject.yield_value(&next);
                let scale = next.stress.norm().max(SCALE);
                prop_assert!(excess <= 1e-9 * scale * 10.0, "{}: f = {excess} Pa at {scale} Pa", subject.law.name());
                walker = next;
            }
        }
    }

    #[test]
    fn wild_motions_are_refused_or_survived(entries in proptest::array::uniform9(prop_oneof![
        -1e3..1e3f64, Just(f64::NAN), Just(f64::INFINITY), Just(0.0), Just(-1.0), Just(1e300)
    ])) {
        for subject in subjects() {
            let walker = subject.walker();
            let gradient = Mat3(*entries.as_chunks::<3>().0.first_chunk::<3>().expect("nine entries"));
            let motion = Motion {
                deformation: Mat3::IDENTITY + gradient,
                gradient,
                dt: 1e-3,
                density: walker.density,
                size: 0.1,
                pore: Default::default(),
            };
            if !gradient.is_finite() {
                prop_assert!(subject.apply(&walker, &motion).is_none(), "{} took a motion that is not finite", subject.law.name());
            } else {
                let _ = subject.apply(&walker, &motion);
            }
        }
    }

    #[test]
    fn plastic_flow_dissipates(path in gradients(5, 0.02)) {
        for subject in subjects().iter().filter(|s| s.is_solid()) {
            let mut walker = subject.walker();
            let mut plastic = 0.0;
            for a in &path {
                // Many small steps: the work integral is then exact enough to see a sign.
                for _ in 0..20 {
                    let share = *a * 0.05;
                    let Some(next) = subject.step(&walker, &share, 1e-3) else { break };
                    let volume = |w: &Walker| subject.spec.density() / w.density;
                    let middle = 0.5 * (volume(&walker) + volume(&next));
                    let work = 0.5 * (walker.stress + next.stress).dot(&share.sym()) * middle;
                    plastic += work - (subject.energy(&next) * volume(&next) - subject.energy(&walker) * volume(&walker));
                    walker = next;
                }
            }
            // The rate form is not exactly hyperelastic: strains of some per cent leave a share of the energy.
            let scale = subject.energy(&walker).max(SCALE * 1e-2);
            prop_assert!(plastic >= -0.15 * scale, "{}: {plastic} J/m³ of {scale}", subject.law.name());
        }
    }

    #[test]
    fn the_same_input_gives_the_same_bits(path in gradients(4, 0.1)) {
        for subject in subjects() {
            let walk = || {
                let mut walker = subject.walker();
                for a in &path {
                    let Some(next) = subject.step(&walker, a, 1e-3) else { break };
                    walker = next;
                }
                (walker.stress.0.map(f64::to_bits), subject.law.save(&walker.states))
            };
            prop_assert!(walk() == walk(), "{}", subject.law.name());
        }
    }
}

#[test]
fn halving_the_step_quarters_the_error() {
    let gradient = Mat3([[0.02, 0.05, 0.0], [-0.03, -0.04, 0.01], [0.0, 0.02, 0.01]]);
    for subject in subjects().iter().filter(|s| s.is_solid()) {
        let end = |steps: usize| {
            let share = gradient * (1.0 / steps as f64);
            (0..steps)
                .fold(subject.walker(), |w, _| subject.step(&w, &share, 1e-3).expect("a mild step"))
                .stress
        };
        let reference = end(512);
        let error = |steps: usize| (end(steps) - reference).norm() / reference.norm();
        let (coarse, fine) = (error(4), error(16));
        // At least first order; round-off where a law is exact.
        assert!(fine <= 0.3 * coarse + 1e-10, "{}: {coarse} to {fine}", subject.law.name());
    }
}

#[test]
fn states_survive_saving_and_reordering() {
    for subject in subjects() {
        let count = 150;
        let density = subject.spec.density();
        let conditions: Vec<InitialCondition> = (0..count)
            .map(|i| InitialCondition { stress: SymTensor::isotropic(-1e3 * (1.0 + f64::from(i))), density })
            .collect();
        let (stresses, states) =
            subject.law.initial(&conditions).expect("isotropic compression is admissible");
        assert_eq!(stresses.len(), states.len());
        let bytes = subject.law.save(&states);
        let back = subject.law.load(&bytes).expect("its own bytes");
        assert_eq!(subject.law.save(&back), bytes);
        assert!(subject.law.load(&bytes[..bytes.len() / 3]).is_none() || bytes.len() < 6);
        let order: Vec<u32> = (0..count as u32).rev().collect();
        let twice = states.permuted(&order).permuted(&order);
        assert_eq!(subject.law.save(&twice), bytes, "{}", subject.law.name());
    }
}

#[test]
fn analytic_tangents_are_the_slopes_of_the_update() {
    for subject in subjects().iter().filter(|s| s.is_solid()) {
        for size in [1e-5, 4e-3] {
            let walker = subject.walker();
            let gradient = Mat3([[0.5, 0.3, 0.1], [0.3, -1.0, 0.2], [0.1, 0.2, 0.2]]) * size;
            let at = motion(&gradient, 1e-3, walker.density).expect("a mild step");
            let tangent =
                subject.law.tangent(&at, &walker.stress, &walker.states.blocks()[0], 0).expect("a tangent");
            let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
            let stiffest = tangent.0.iter().flatten().fold(0.0, |a: f64, c| a.max(c.abs()));
            for (column, (i, j)) in pairs.into_iter().enumerate() {
                let step = 1e-7 * size.max(1e-3);
                let stress = |sign: f64| {
                    let mut a = gradient;
                    a.0[i][j] += 0.5 * sign * step;
                    a.0[j][i] += 0.5 * sign * step;
                    subject.step(&walker, &a, 1e-3).expect("a mild step").stress
                };
                let slope = (stress(1.0) - stress(-1.0)) * (0.5 / step);
                for row in 0..6 {
                    let error = (tangent.0[row][column] - slope[row]).abs();
                    assert!(
                        error <= 1e-5 * stiffest,
                        "{} [{row}][{column}]: {error} of {stiffest}",
                        subject.law.name()
                    );
                }
            }
        }
    }
}
