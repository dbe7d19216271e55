//! Transfers with the affine velocity fields in one sweep, against each part by itself.

use colluvium_grid::{
    Affine, Deposit, Gathered, Grid, Ground, Lanes, Layout, Mesh, Node, Points, Shape, Square, Sweeps, Window,
};

/// Numbers that have nothing to do with each other, between -1 and 1.
fn noise(seed: usize) -> f64 {
    (seed as f64 * 12.9898 + 4.1414).sin() * 0.9
}

fn lanes(seed: usize) -> Lanes {
    Lanes::new([noise(4 * seed), noise(4 * seed + 1), noise(4 * seed + 2), noise(4 * seed + 3)])
}

fn square<const D: usize>(seed: usize) -> Square<D> {
    let mut square = [[0.0; D]; D];
    square.as_flattened_mut().iter_mut().enumerate().for_each(|(k, entry)| *entry = noise(9 * seed + k));
    square
}

const COUNT: usize = 20;

fn one_sweep_does_both<const D: usize>(sweeps: &dyn Sweeps<D>, moments: bool) {
    let grid = Grid::new([0.0; D], [1.0; D], 0.125).unwrap();
    let layout = Layout::<D>::of(&grid, &sweeps.axis());
    let mesh = Mesh::default();
    let ground = Ground::new(&grid, &mesh, &layout);
    let position: Vec<[f64; D]> =
        (0..COUNT).map(|p| std::array::from_fn(|c| 0.5 + 0.2 * noise(7 * p + c))).collect();
    let domain = sweeps.domains(COUNT);
    let points = Points { position: &position, domain: domain.as_slice(), extent: &[0.06; D] };

    let nodes: Vec<Node> =
        (0..layout.len()).map(|k| Node { motion: lanes(k), force: lanes(k + 1000) }).collect();
    let (mut read, mut both) = (vec![Gathered::<D>::ZERO; COUNT], vec![Gathered::<D>::ZERO; COUNT]);
    let (mut field, mut fields) = (vec![[[0.0; D]; D]; COUNT], vec![[[0.0; D]; D]; COUNT]);
    sweeps.gather(&ground, &points, &nodes, &mut read);
    sweeps.gather_affine(&ground, &points, &nodes, moments, &mut field);
    sweeps.gather_both(&ground, &points, &nodes, moments, (&mut both, &mut fields));
    assert_eq!(field, fields, "{sweeps:?}");
    for (a, b) in read.iter().zip(&both) {
        assert_eq!(
            (a.velocity, a.acceleration, a.gradient),
            (b.velocity, b.acceleration, b.gradient),
            "{sweeps:?}"
        );
    }

    let motion: Vec<Lanes> = (0..COUNT).map(lanes).collect();
    let columns: Vec<[Lanes; D]> = (0..COUNT).map(|p| std::array::from_fn(|j| lanes(31 * p + j))).collect();
    let (affine, mass): (Vec<Square<D>>, Vec<f64>) =
        (0..COUNT).map(|p| (square(p), 1.0 + 0.5 * noise(p))).unzip();
    let affine = Affine { moments, fields: &affine, mass: &mass };
    let deposit = |affine| {
        let mut nodes = vec![Node::default(); layout.len()];
        let given = Deposit { motion: &motion, columns: &columns, body: &[], affine };
        sweeps.deposit(&ground, &points, Window { nodes: &mut nodes, first: 0 }, &given);
        nodes
    };
    let (plain, whole) = (deposit(None), deposit(Some(affine)));
    let mut momenta = vec![Lanes::ZERO; layout.len()];
    let to = Window { nodes: &mut momenta[..], first: 0 };
    sweeps.deposit_values(&ground, &points, to, &[Lanes::ZERO; COUNT], Some(affine));
    let size = momenta.iter().map(|m| m.abs().reduce_add()).fold(1.0, f64::max);
    let mut moved = 0.0f64;
    for ((plain, whole), momentum) in plain.iter().zip(&whole).zip(&momenta) {
        let apart = (whole.motion - plain.motion - *momentum).abs().reduce_add();
        assert!(apart <= 1e-13 * size, "{sweeps:?}: {apart:e} of {size:e}");
        assert!((whole.force - plain.force).abs().reduce_add() <= 1e-11, "{sweeps:?}");
        moved = moved.max(momentum.abs().reduce_add());
    }
    assert!(moved > 0.01, "{sweeps:?}: the fields carry momentum");
}

#[test]
fn a_sweep_with_affine_fields_is_the_sum_of_its_parts() {
    for shape in [Shape::Linear, Shape::Quadratic, Shape::Cubic, Shape::StretchingGimp, Shape::Convected] {
        for moments in [true, false] {
            shape.on_line().into_iter().for_each(|sweeps| one_sweep_does_both(sweeps, moments));
            shape.in_plane().into_iter().for_each(|sweeps| one_sweep_does_both(sweeps, moments));
            shape.in_space().into_iter().for_each(|sweeps| one_sweep_does_both(sweeps, moments));
        }
    }
}
