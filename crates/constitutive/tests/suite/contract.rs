//! Contract of every law with its callers (sheet: constitutive §3.1), tested on every registered law
//! without naming one.
//!
//! Round-off is measured against the stress of a step: the stress before it plus that of its
//! elastic trial, `‖σ‖ + M ‖Δε‖` with the wave modulus `M` (the larger of both ends where stiffness
//! depends on pressure).

use std::sync::{Arc, LazyLock};

use colluvium_constitutive::laws::{
    DoubleScaleSpec, DruckerPragerSpec, Matching, MohrCoulombSpec, OutsideStrength, PlasticIntegration,
    Softening, StrainMeasure,
};
use colluvium_constitutive::{
    InitialCondition, Mat3, Material, MaterialSpec, Motion, MotionBlock, StateBlock, States, SymTensor,
    Tangent,
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
struct Walker {
    stress: SymTensor,
    states: States,
    density: f64,
}

fn all() -> Vec<Subject> {
    let subject = |spec: MaterialSpec| {
        let law = spec.build().expect("an example builds");
        let start = SymTensor([-60e3, -50e3, -45e3, 3e3, -2e3, 1e3]);
        let mean = SymTensor::isotropic(start.trace() / 3.0);
        let fluid = law.initial(&[InitialCondition { stress: start, density: spec.density() }]).is_err();
        Subject { start: if fluid { mean } else { start }, spec, law, scale: 1.0 }
    };
    let registered =
        MaterialSpec::examples().into_iter().chain(MaterialSpec::wrapped_examples()).map(subject);
    let banded = yielding_surroundings().map(|spec| Subject { scale: SMALL, ..subject(spec) });
    registered.chain(banded).chain(steeply_softening().map(subject)).collect()
}

fn subjects() -> &'static [Subject] {
    static SUBJECTS: LazyLock<Vec<Subject>> = LazyLock::new(all);
    &SUBJECTS
}

/// Steps of 0.1 % in place of 10 %.
const SMALL: f64 = 0.01;

/// Bands with yielding surroundings, without and with softening. They lose ellipticity, so that a long step may end
/// at one of several equilibria, or at none.
fn yielding_surroundings() -> [MaterialSpec; 2] {
    let banded = MaterialSpec::examples().into_iter().find_map(|spec| match spec {
        MaterialSpec::DoubleScale(spec) => Some(DoubleScaleSpec { local_solve: None, ..spec }),
        _ => None,
    });
    let banded = banded.expect("there is a sample");
    let softening = Softening {
        residual_friction_angle: 28.0,
        residual_cohesion: 12e3,
        friction_rate: 3.0,
        cohesion_rate: 5.0,
        hardening: false,
    };
    [None, Some(softening)].map(|softening| {
        let outside = OutsideStrength {
            friction_angle: 30.0,
            cohesion: 15e3,
            dilatancy_angle: 10.0,
            matching: Matching::Compression,
            softening,
        };
        MaterialSpec::DoubleScale(DoubleScaleSpec { outside: Some(outside), ..banded.clone() })
    })
}

/// Strength that falls faster than the stress unloads in yielding, 1.1 times for the pyramid, 1.3 times for the cone:
/// the step beyond the peak snaps back, and no single slope predicts its end.
fn steeply_softening() -> [MaterialSpec; 4] {
    let softening = Softening {
        residual_friction_angle: 2.0,
        residual_cohesion: 1e3,
        friction_rate: 10.0,
        cohesion_rate: 30.0,
        hardening: false,
    };
    let cone = |integration| {
        MaterialSpec::DruckerPrager(DruckerPragerSpec {
            density: 2000.0,
            youngs_modulus: 1e6,
            poissons_ratio: 0.3,
            friction_angle: 5.0,
            cohesion: 25e3,
            dilatancy_angle: 1.0,
            matching: Matching::Compression,
            softening: Some(softening),
            dilatancy_decay: 0.0,
            integration,
            strain_measure: StrainMeasure::Rate,
            return_initial_stress_to_yield: false,
        })
    };
    let pyramid = MaterialSpec::MohrCoulomb(MohrCoulombSpec {
        density: 2000.0,
        youngs_modulus: 1e6,
        poissons_ratio: 0.3,
        friction_angle: 5.0,
        cohesion: 25e3,
        dilatancy_angle: 1.0,
        softening: Some(softening),
        dilatancy_decay: 0.0,
        tensile_strength: None,
        strain_measure: StrainMeasure::Rate,
        return_initial_stress_to_yield: false,
    });
    let [returned, semi_implicit, explicit] =
        [PlasticIntegration::ClosestPoint, PlasticIntegration::SemiImplicit, PlasticIntegration::Explicit]
            .map(cone);
    [pyramid, returned, semi_implicit, explicit]
}

fn solids() -> impl Iterator<Item = &'static Subject> {
    subjects().iter().filter(|subject| subject.is_solid())
}

/// Laws that declare isotropy.
fn isotropic() -> impl Iterator<Item = &'static Subject> {
    subjects().iter().filter(|subject| subject.law.is_isotropic())
}

impl Subject {
    fn name(&self) -> String {
        format!("{:?}", self.spec)
    }

    fn walker(&self) -> Walker {
        self.walker_at(self.start)
    }

    fn walker_at(&self, stress: SymTensor) -> Walker {
        let density = self.spec.density();
        let (stress, states) = self.law.initial(&[InitialCondition { stress, density }]).expect("admissible");
        Walker { stress: stress[0], states, density }
    }

    fn step(&self, walker: &Walker, gradient: &Mat3, dt: f64) -> Walker {
        self.apply(walker, &self.motion(gradient, dt, walker.density))
    }

    /// Motion with mid-step gradient `a`, scaled, density following from the volume.
    fn motion(&self, a: &Mat3, dt: f64, density: f64) -> Motion {
        motion(&(*a * self.scale), dt, density)
    }

    fn walk(&self, path: &[Mat3], dt: f64) -> Walker {
        path.iter().fold(self.walker(), |walker, a| self.step(&walker, a, dt))
    }

    fn apply(&self, walker: &Walker, motion: &Motion) -> Walker {
        match self.try_apply(walker, motion) {
            Ok(new) => new,
            Err(error) => {
                panic!("{}: {error} at {:?}, {:?}", self.name(), walker.stress, motion.velocity_gradient_dt)
            }
        }
    }

    fn try_apply(&self, walker: &Walker, motion: &Motion) -> Result<Walker, String> {
        let mut new = walker.clone();
        let mut stress = [walker.stress];
        let block = &mut new.states.blocks_mut()[0];
        self.law.update(std::slice::from_ref(motion), &mut stress, block).map_err(|e| e.to_string())?;
        new.stress = stress[0];
        new.density = motion.density;
        Ok(new)
    }

    /// Compares a path with its rotation by `q`.
    ///
    /// A path may lead to where a law amplifies the round-off of its own input: a band whose direction is that of a principal
    /// stress hardly larger than another one. Differences of that size, measured by a path that differs in its last digits, are not
    /// due to the rotation.
    fn turned_with(&self, path: &[Mat3], q: &Mat3) -> Result<(), String> {
        let (mut here, mut there) = (self.walker(), self.walker_at(self.start.rotated(q)));
        let mut near = self.walker();
        let mut allowed = 0.0;
        for a in path {
            let motion = self.motion(a, 1e-2, here.density);
            let nearly = self.motion(&last_digits_changed(a), 1e-2, near.density);
            let before = self.handled(&here, &motion);
            near = self.apply(&near, &nearly);
            (here, there) = (self.apply(&here, &motion), self.apply(&there, &turned(&motion, q)));
            let after = self.handled(&here, &motion);
            // Pressure-dependent stiffness carries earlier differences along.
            let own = 1e-12 + self.law.stress_tolerance();
            allowed = allowed * (after / before).max(1.0) + own * before.max(after);
            let amplified = AMPLIFIED * (near.stress - here.stress).norm();
            let difference = (there.stress - here.stress.rotated(q)).norm();
            if difference > allowed + amplified {
                return Err(format!("{difference} of {allowed} and {amplified}"));
            }
        }
        Ok(())
    }

    fn yield_value(&self, walker: &Walker) -> f64 {
        one(walker, |stress, block, out| self.law.yield_values(stress, block, out))
    }

    fn energy(&self, walker: &Walker) -> f64 {
        one(walker, |stress, block, out| {
            self.law.stored_energies(stress, block, out);
        })
    }

    /// Scale of the stress in a step (Pa): initial stress plus its elastic trial.
    fn handled(&self, walker: &Walker, motion: &Motion) -> f64 {
        let modulus = one(walker, |stress, block, out| self.law.wave_moduli(stress, block, out));
        walker.stress.norm() + modulus * motion.velocity_gradient_dt.sym().norm()
    }

    /// Point after the end of motion: a viscous stress ends with the motion, so for laws with a viscosity
    /// the remaining stress is the one that rest and rigid rotations must not change.
    fn stopped(&self, walker: Walker) -> Walker {
        let viscous = one(&walker, |stress, block, out| self.law.viscosities(stress, block, out)) > 0.0;
        if viscous && self.is_solid() { self.step(&walker, &Mat3::ZERO, 1e-3) } else { walker }
    }

    /// Whether the law is a solid: fluids have no memory of shear, so some tests of solids do not apply to them.
    fn is_solid(&self) -> bool {
        !self.spec.is_fluid()
    }

    fn tangent(&self, motion: &Motion, walker: &Walker) -> Tangent {
        self.law.tangent(motion, &walker.stress, &walker.states.blocks()[0], 0).expect("a tangent")
    }
}

fn one(walker: &Walker, read: impl Fn(&[SymTensor], &StateBlock, &mut [f64])) -> f64 {
    let mut out = [0.0];
    read(&[walker.stress], &walker.states.blocks()[0], &mut out);
    out[0]
}

/// Motion with mid-step gradient `a`, density following from the volume.
fn motion(a: &Mat3, dt: f64, density: f64) -> Motion {
    let mut motion = Motion::from_velocity_gradient(&(*a * (1.0 / dt)), dt, density, 0.1).expect("moderate");
    motion.density = density / motion.deformation.determinant();
    motion
}

/// Allowed ratio of the difference by a rotation, which rounds each entry several times, to that by the last digits of the input.
const AMPLIFIED: f64 = 16.0;

/// Gradient with other last digits, not all in proportion.
fn last_digits_changed(a: &Mat3) -> Mat3 {
    let size = 2.0 * f64::EPSILON * a.0.as_flattened().iter().map(|c| c * c).sum::<f64>().sqrt();
    *a + Mat3([[1.0, -0.4, 0.7], [0.2, -0.9, 0.5], [-0.6, 0.3, 0.8]]) * size
}

/// Motion rotated by `q`.
fn turned(motion: &Motion, q: &Mat3) -> Motion {
    let turn = |m: &Mat3| *q * *m * q.transpose();
    Motion {
        deformation: turn(&motion.deformation),
        velocity_gradient_dt: turn(&motion.velocity_gradient_dt),
        ..*motion
    }
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

/// Rotations that permute the axes, without reflections.
fn permutations() -> [Mat3; 3] {
    [
        Mat3([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
        Mat3([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        Mat3([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn no_motion_changes_nothing(path in gradients(3, 0.05)) {
        for subject in subjects() {
            let walker = subject.stopped(subject.walk(&path, 1e-3));
            let still = subject.step(&walker, &Mat3::ZERO, 1e-3);
            if subject.is_solid() {
                let change = (still.stress - walker.stress).norm();
                let own = 1e-14 + subject.law.stress_tolerance();
                prop_assert!(change <= own * walker.stress.norm(), "{}: {change}", subject.name());
            } else if subject.yield_value(&still) == f64::NEG_INFINITY {
                let shear = still.stress.deviator().norm();
                prop_assert!(shear <= 1e-14 * still.stress.norm(), "a resting fluid carries no shear");
            } else {
                let limit = walker.stress.deviator().norm() * (1.0 + 1e-14);
                prop_assert!(still.stress.deviator().norm() <= limit, "{}: shear grew at rest", subject.name());
            }
        }
    }

    #[test]
    fn a_turned_observer_sees_the_turned_stress(path in gradients(4, 0.1), q in rotation()) {
        for subject in isotropic() {
            let turned = subject.turned_with(&path, &q);
            prop_assert!(turned.is_ok(), "{}: {}", subject.name(), turned.unwrap_err());
        }
    }

    #[test]
    fn no_axis_is_special(path in gradients(3, 0.1), q in proptest::sample::select(permutations().to_vec())) {
        for subject in isotropic() {
            let turned = subject.turned_with(&path, &q);
            prop_assert!(turned.is_ok(), "{}: {}", subject.name(), turned.unwrap_err());
        }
    }

    #[test]
    fn a_rigid_turn_turns_the_stress(path in gradients(3, 0.05), axis in rotation(), angle in -3.0..3.0f64) {
        let q = axis * Mat3::rotation_z(angle) * axis.transpose();
        for subject in solids() {
            let walker = subject.stopped(subject.walk(&path, 1e-3));
            // The deformation alone: the step itself computes the spin.
            let motion = Motion::from_deformation(&q, 1e-3, walker.density, 0.1).expect("less than half a turn");
            let after = subject.apply(&walker, &motion);
            let difference = (after.stress - walker.stress.rotated(&q)).norm();
            // A rotation is given to the last digit of its entries, which the stiffness turns into stress; a
            // rotation by nearly 180° is known no better than the tangent of its half.
            let modulus = one(&walker, |stress, block, out| subject.law.wave_moduli(stress, block, out));
            let given = 32.0 * f64::EPSILON * modulus / (0.5 * angle).cos().powi(2);
            prop_assert!(difference <= 1e-12 * walker.stress.norm() + given, "{}: {difference}", subject.name());
        }
    }

    #[test]
    fn stress_stays_finite_and_inside_the_yield_surface(path in gradients(6, 0.1)) {
        for subject in subjects() {
            let mut walker = subject.walker();
            for a in &path {
                let next = subject.step(&walker, a, 1e-3);
                prop_assert!(next.stress.is_finite(), "{}", subject.name());
                let excess = subject.yield_value(&next);
                // p_ref = 1 kPa.
                let scale = next.stress.pressure().abs() + 1e3;
                prop_assert!(excess <= 1e-9 * scale, "{}: f = {excess} Pa at {scale} Pa", subject.name());
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
                velocity_gradient_dt: gradient,
                dt: 1e-3,
                density: walker.density,
                size: 0.1,
                pore: Default::default(),
            };
            match subject.try_apply(&walker, &motion) {
                Ok(_) if !gradient.is_finite() => {
                    prop_assert!(false, "{} took a motion that is not finite", subject.name());
                }
                Ok(new) => prop_assert!(new.stress.is_finite(), "{}: {:?}", subject.name(), new.stress),
                Err(_) => {}
            }
        }
    }

    #[test]
    fn plastic_flow_dissipates(path in gradients(5, 0.1)) {
        for subject in subjects() {
            let mut walker = subject.walker();
            for a in &path {
                let motion = subject.motion(a, 1e-3, walker.density);
                let next = subject.apply(&walker, &motion);
                let old = (&walker.stress, &walker.states.blocks()[0]);
                let new = (&next.stress, &next.states.blocks()[0]);
                if let Some(dissipated) = subject.law.dissipation(&motion, old, new) {
                    // Scale of the energy in a step.
                    let strain = motion.velocity_gradient_dt.sym().norm();
                    let scale = subject.handled(&walker, &motion) * strain + subject.energy(&walker);
                    prop_assert!(dissipated >= -1e-12 * scale, "{}: {dissipated} J/m³ of {scale}", subject.name());
                }
                walker = next;
            }
        }
    }
}

proptest! {
    // Each of these needs twenty-five updates of all laws.
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn tangents_are_the_slopes_of_the_update(
        before in gradients(1, 2e-3),
        direction in proptest::array::uniform6(-1.0..1.0f64),
        size in prop_oneof![Just(1e-5), Just(1e-3), Just(2e-2), Just(1e-1)],
    ) {
        for subject in solids() {
            let size = size * subject.scale;
            let gradient = SymTensor(direction).to_matrix() * size;
            let walker = subject.walk(&before, 1e-3);
            let at = motion(&gradient, 1e-3, walker.density);
            let tangent = subject.tangent(&at, &walker);
            let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
            let modulus = |at: &Walker| one(at, |stress, block, out| subject.law.wave_moduli(stress, block, out));
            let middle = subject.apply(&walker, &at);
            let stiffest = modulus(&walker).max(modulus(&middle));
            // First and second differences over the step.
            let differences = |step: f64| {
                let stress = |column: usize, amount: f64| {
                    let (i, j): (usize, usize) = pairs[column];
                    let mut a = gradient;
                    a.0[i][j] += 0.5 * amount;
                    a.0[j][i] += 0.5 * amount;
                    let mut moved = motion(&a, 1e-3, walker.density);
                    moved.density = at.density * at.deformation.determinant() / moved.deformation.determinant();
                    subject.apply(&walker, &moved).stress
                };
                std::array::from_fn::<_, 6, _>(|column| {
                    let (plus, minus) = (stress(column, step), stress(column, -step));
                    ((plus - minus) * (0.5 / step), (plus + minus - middle.stress * 2.0) * (1.0 / step))
                })
            };
            // A forward algorithm takes more steps for a larger strain: its stress is a staircase about the
            // slope of each tread, and neither difference resolves jumps on both sides.
            let allowed = if subject.name().contains("integration: Explicit") { 1e-5 } else { 1e-6 };
            let step = 1e-4 * size.max(1e-4);
            let (coarse, fine) = (differences(2.0 * step), differences(step));
            for column in 0..6 {
                for row in 0..6 {
                    // Where two steps of the difference disagree there is a switch of region between: first
                    // differences are unchanged, second ones double with the step, but not across a kink.
                    // A jump between, where a forward algorithm takes one more step, leaves 7/3 of their difference.
                    let (wide, near) = (coarse[column].0[row], fine[column].0[row]);
                    let kink = 2.0 * fine[column].1[row] - coarse[column].1[row];
                    if (wide - near).abs() > 4e-7 * stiffest || kink.abs() > 5e-7 * stiffest {
                        continue;
                    }
                    let slope = near + (near - wide) / 3.0;
                    let error = (tangent.0[row][column] - slope).abs();
                    prop_assert!(error <= allowed * stiffest, "{} [{row}][{column}]: {error} of {stiffest}", subject.name());
                }
            }
        }
    }
}

proptest! {
    // These comparisons are exact: few paths suffice.
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_same_input_gives_the_same_bits_on_any_thread(path in gradients(4, 0.1)) {
        for subject in subjects() {
            let walk = || {
                let walker = subject.walk(&path, 1e-3);
                (walker.stress.0.map(f64::to_bits), subject.law.save(&walker.states))
            };
            let here = walk();
            let there = std::thread::scope(|scope| {
                let threads = [scope.spawn(walk), scope.spawn(walk)];
                threads.map(|thread| thread.join().expect("no panic"))
            });
            prop_assert!(there.iter().all(|result| *result == here), "{}", subject.name());
        }
    }

    #[test]
    fn a_batch_gives_what_its_points_give_alone(gradients in gradients(24, 0.02), flat in any::<bool>()) {
        // Motion in the plane of the first two axes, with or without strain along the third.
        let in_plane = |a: &Mat3| {
            let [[xx, xy, _], [yx, yy, _], [.., zz]] = a.0;
            Mat3([[xx, xy, 0.0], [yx, yy, 0.0], [0.0, 0.0, zz]])
        };
        for subject in subjects() {
            let density = subject.spec.density();
            let gradient = |a: &Mat3| if flat { in_plane(a) } else { *a };
            let motions: Vec<Motion> =
                gradients.iter().map(|a| subject.motion(&gradient(a), 1e-3, density)).collect();
            let start = vec![InitialCondition { stress: subject.start, density }; motions.len()];
            let (mut stresses, mut states) = subject.law.initial(&start).expect("admissible");
            let mut block = MotionBlock::at_rest(motions[0].dt, motions[0].size, flat);
            // Entries behind the points must not count.
            block.velocity_gradient_dt[1].fill(f64::NAN);
            motions.iter().enumerate().for_each(|(i, motion)| block.set(i, motion));
            let (mut others, mut others_states) = (stresses.clone(), subject.law.initial(&start).expect("admissible").1);
            subject.law.update(&motions, &mut stresses, &mut states.blocks_mut()[0]).expect("a moderate step");
            subject.law.update_block(&block, &mut others, &mut others_states.blocks_mut()[0]).expect("the same step");
            prop_assert_eq!(&stresses, &others, "{}", subject.name());
            prop_assert_eq!(subject.law.save(&states), subject.law.save(&others_states), "{}", subject.name());
            for (motion, stress) in motions.iter().zip(&stresses) {
                let alone = subject.apply(&subject.walker(), motion);
                prop_assert_eq!(alone.stress, *stress, "{}", subject.name());
            }
        }
    }
}

/// Laws, and those with a cohesion also without it, where that is a valid law.
fn with_and_without_cohesion() -> Vec<Subject> {
    let bare = |subject: &Subject| {
        let mut spec = serde_json::to_value(&subject.spec).ok()?;
        *spec.get_mut("cohesion")? = 0.into();
        let spec: MaterialSpec = serde_json::from_value(spec).ok()?;
        Some(Subject { law: spec.build().ok()?, spec, start: SymTensor::ZERO, scale: 1.0 })
    };
    let subjects = all();
    let without: Vec<Subject> = subjects.iter().filter_map(bare).collect();
    assert!(without.len() >= 3, "laws have a cohesion");
    subjects.into_iter().chain(without).collect()
}

#[test]
fn what_is_next_to_nothing_stays_finite() {
    // Ahead of a wave stresses are near the least numbers, and products of them vanish in rounding.
    let shear = SymTensor([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let directions = [SymTensor::isotropic(1.0), SymTensor::isotropic(-1.0), shear];
    for subject in with_and_without_cohesion() {
        let start = InitialCondition { stress: SymTensor::ZERO, density: subject.spec.density() };
        if subject.law.initial(&[start]).is_err() {
            continue;
        }
        for power in (150..=320).step_by(5) {
            let size = 10f64.powi(-150) * 10f64.powi(150 - power);
            assert!(size > 0.0);
            for stress in directions {
                let mut walker = subject.walker_at(SymTensor::ZERO);
                walker.stress = stress * size;
                for strain in directions.into_iter().chain([SymTensor::ZERO]) {
                    let next = subject.step(&walker, &(strain * size).to_matrix(), 1e-3);
                    assert!(next.stress.is_finite(), "{}: {size} of {stress:?}, {strain:?}", subject.name());
                }
            }
        }
    }
}

#[test]
fn what_laws_say_of_themselves_is_what_they_are_wrapped_around() {
    for subject in subjects() {
        let (law, tolerance) = (&subject.law, subject.law.stress_tolerance());
        assert!((0.0..1e-3).contains(&tolerance), "{}: {tolerance}", subject.name());
        let Some(inner) = subject.spec.inner() else {
            assert_eq!(law.name(), subject.spec.name());
            continue;
        };
        let inner = inner.build().expect("it has built within another");
        assert_eq!((law.is_isotropic(), tolerance), (inner.is_isotropic(), inner.stress_tolerance()));
        assert!(law.is_time_dependent() || !inner.is_time_dependent(), "{}", subject.name());
    }
}

#[test]
fn only_laws_in_rate_form_keep_a_stress_changed_from_outside() {
    for subject in subjects() {
        let whole = subject.walker();
        let mut less = whole.clone();
        less.stress = whole.stress * 0.99;
        let strain = SymTensor([1e-5, -2e-5, 0.0, 1e-5, 0.0, 0.0]).to_matrix();
        let differs = subject.step(&whole, &strain, 1e-3).stress != subject.step(&less, &strain, 1e-3).stress;
        // Fluids whose shear is in rate form have their pressure from density: shear is the stress they keep.
        let shears = whole.stress.deviator() != SymTensor::ZERO;
        assert_eq!(differs, subject.law.is_hypoelastic() && shears, "{}", subject.name());
    }
}

#[test]
fn without_motion_only_time_dependent_laws_ask_how_long() {
    for subject in subjects().iter().filter(|s| s.law.is_hypoelastic()) {
        let mut beyond = subject.walker();
        // Beyond the yield surface of most laws.
        beyond.stress += SymTensor([2e4, -1e4, -1e4, 5e4, 0.0, 0.0]);
        let after = |dt: f64| {
            let motion = motion(&Mat3::ZERO, dt, beyond.density);
            subject.try_apply(&beyond, &motion).map(|walker| walker.stress)
        };
        let differs = after(1e-4) != after(1e-3);
        assert!(!differs || subject.law.is_time_dependent(), "{}", subject.name());
        // Without viscosity the stress of a flow is its yield stress at any rate.
        let flows = subject.spec.is_fluid() && !subject.name().contains("viscosity: 0.0");
        assert!(differs || !flows, "{}", subject.name());
    }
}

#[test]
fn two_half_steps_differ_from_one_by_the_square_of_the_step() {
    // From a state on the yield surface, in a direction that continues loading and rotates.
    let before = Mat3([[0.002, 0.002, 0.0], [0.001, -0.004, 0.0005], [0.0, 0.001, 0.001]]);
    let direction = Mat3([[0.2, 0.5, 0.0], [-0.1, -0.6, 0.1], [0.0, 0.2, 0.25]]);
    for subject in subjects() {
        let walker = subject.walk(&[before, before * 0.5], 1e-3);
        let difference = |size: f64| {
            let a = direction * size;
            let whole = subject.apply(&walker, &motion(&a, 1e-3 * size / 4e-4, walker.density));
            // Half of the logarithm of the motion, so that both paths end at the same deformation.
            let root = square_root(&motion(&a, 1.0, 1.0).deformation);
            let half = |density: f64| {
                let mut m =
                    Motion::from_deformation(&root, 0.5e-3 * size / 4e-4, density, 0.1).expect("small");
                m.density = density / root.determinant();
                m
            };
            let middle = subject.apply(&walker, &half(walker.density));
            let end = subject.apply(&middle, &half(middle.density));
            // A strain is given to the last digit of the deformation, which the stiffness turns into stress.
            let modulus = one(&walker, |stress, block, out| subject.law.wave_moduli(stress, block, out));
            ((end.stress - whole.stress).norm(), 64.0 * f64::EPSILON * modulus + 1e-12 * walker.stress.norm())
        };
        let mut size = 1e-5;
        let mut last = difference(size).0;
        for _ in 0..3 {
            size *= 0.5;
            let (now, floor) = difference(size);
            assert!(now <= 0.27 * last + floor, "{}: {last} to {now} at {size}", subject.name());
            last = now;
        }
    }
}

/// Square root of a matrix near the unit matrix (Denman–Beavers).
fn square_root(m: &Mat3) -> Mat3 {
    let (mut y, mut z) = (*m, Mat3::IDENTITY);
    for _ in 0..20 {
        let (a, b) = (z.inverse().expect("regular"), y.inverse().expect("regular"));
        (y, z) = ((y + a) * 0.5, (z + b) * 0.5);
    }
    y
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
        assert_eq!(subject.law.save(&twice), bytes, "{}", subject.name());
        // Distributed to three, one of which has none, and gathered again.
        let of = |kind: u32| (0..count as u32).filter(|i| i % 3 / 2 == kind).collect::<Vec<u32>>();
        let parts = [0, 1, 2].map(|kind| states.permuted(&of(kind)));
        let pick = |i: u32| (i % 3 / 2, if i % 3 == 2 { i / 3 } else { i / 3 * 2 + i % 3 });
        let picks: Vec<(u32, u32)> = (0..count as u32).map(pick).collect();
        let whole = States::gathered(&[&parts[0], &parts[1], &parts[2]], &picks);
        assert_eq!((subject.law.save(&whole), whole.len()), (bytes, states.len()), "{}", subject.name());
    }
}
