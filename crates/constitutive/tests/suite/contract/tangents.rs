//! Tangents against differences of the stress update.

use colluvium_constitutive::SymTensor;
use proptest::prelude::*;

use super::laws::solids;
use super::{TestPoint, gradients, motion, value_of};

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
            let point = subject.end_of_path(&before, 1e-3);
            let at = motion(&gradient, 1e-3, point.density);
            let tangent = subject.tangent(&at, &point);
            let pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
            let modulus = |at: &TestPoint| value_of(at, |stress, block, out| subject.law.wave_moduli(stress, block, out));
            let middle = subject.apply(&point, &at);
            let stiffest = modulus(&point).max(modulus(&middle));
            // First and second differences over the step.
            let differences = |step: f64| {
                let stress = |column: usize, amount: f64| {
                    let (i, j): (usize, usize) = pairs[column];
                    let mut a = gradient;
                    a.0[i][j] += 0.5 * amount;
                    a.0[j][i] += 0.5 * amount;
                    let mut moved = motion(&a, 1e-3, point.density);
                    moved.density = at.density * at.deformation.determinant() / moved.deformation.determinant();
                    subject.apply(&point, &moved).stress
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
