//! Determinism, batches of points, and stored states.

use colluvium_constitutive::{InitialCondition, Mat3, Motion, MotionBlock, States, SymTensor};
use proptest::prelude::*;

use super::gradients;
use super::laws::subjects;

proptest! {
    // These comparisons are exact: few paths suffice.
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_same_input_gives_the_same_bits_on_any_thread(path in gradients(4, 0.1)) {
        for subject in subjects() {
            let run = || {
                let point = subject.end_of_path(&path, 1e-3);
                (point.stress.0.map(f64::to_bits), subject.law.save(&point.states))
            };
            let here = run();
            let there = std::thread::scope(|scope| {
                let threads = [scope.spawn(run), scope.spawn(run)];
                threads.map(|thread| thread.join().expect("no panic"))
            });
            prop_assert!(there.iter().all(|result| *result == here), "{}", subject.name());
        }
    }

    #[test]
    fn a_batch_gives_the_stresses_of_single_points(gradients in gradients(24, 0.02), flat in any::<bool>()) {
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
                let alone = subject.apply(&subject.point(), motion);
                prop_assert_eq!(alone.stress, *stress, "{}", subject.name());
            }
        }
    }
}

#[test]
fn states_are_unchanged_by_saving_and_reordering() {
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
