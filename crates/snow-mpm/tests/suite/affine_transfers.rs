//! Transfers with the affine velocity fields in one sweep, against each part by itself.

use colluvium_grid::{
    AffineFields, Grid, GridView, InterpolatedMotion, Layout, Mesh, NodalState, NodeRange, P2gInput,
    PointSlice, ShapeFunctionKind, SquareMatrix, Transfers, Vector4,
};

/// Numbers that have nothing to do with each other, between -1 and 1.
fn noise(seed: usize) -> f64 {
    (seed as f64 * 12.9898 + 4.1414).sin() * 0.9
}

fn lanes(seed: usize) -> Vector4 {
    Vector4::new([noise(4 * seed), noise(4 * seed + 1), noise(4 * seed + 2), noise(4 * seed + 3)])
}

fn square<const D: usize>(seed: usize) -> SquareMatrix<D> {
    let mut square = [[0.0; D]; D];
    square.as_flattened_mut().iter_mut().enumerate().for_each(|(k, entry)| *entry = noise(9 * seed + k));
    square
}

const COUNT: usize = 20;

fn one_sweep_does_both<const D: usize>(sweeps: &dyn Transfers<D>, moments: bool) {
    let grid = Grid::new([0.0; D], [1.0; D], 0.125).unwrap();
    let layout = Layout::<D>::with_basis(&grid, &sweeps.basis_1d());
    let mesh = Mesh::default();
    let ground = GridView::new(&grid, &mesh, &layout);
    let position: Vec<[f64; D]> =
        (0..COUNT).map(|p| std::array::from_fn(|c| 0.5 + 0.2 * noise(7 * p + c))).collect();
    let domain = sweeps.domains(COUNT);
    let points = PointSlice { position: &position, domain: domain.as_slice(), extent: &[0.06; D] };

    let nodes: Vec<NodalState> = (0..layout.len())
        .map(|k| NodalState { momentum_and_mass: lanes(k), force: lanes(k + 1000) })
        .collect();
    let (mut read, mut both) =
        (vec![InterpolatedMotion::<D>::ZERO; COUNT], vec![InterpolatedMotion::<D>::ZERO; COUNT]);
    let (mut field, mut fields) = (vec![[[0.0; D]; D]; COUNT], vec![[[0.0; D]; D]; COUNT]);
    sweeps.g2p(&ground, &points, &nodes, &mut read);
    sweeps.g2p_affine(&ground, &points, &nodes, moments, &mut field);
    sweeps.g2p_with_affine(&ground, &points, &nodes, moments, (&mut both, &mut fields));
    assert_eq!(field, fields, "{sweeps:?}");
    for (a, b) in read.iter().zip(&both) {
        assert_eq!(
            (a.velocity, a.acceleration, a.gradient),
            (b.velocity, b.acceleration, b.gradient),
            "{sweeps:?}"
        );
    }

    let motion: Vec<Vector4> = (0..COUNT).map(lanes).collect();
    let columns: Vec<[Vector4; D]> = (0..COUNT).map(|p| std::array::from_fn(|j| lanes(31 * p + j))).collect();
    let (affine_fields, mass): (Vec<SquareMatrix<D>>, Vec<f64>) =
        (0..COUNT).map(|p| (square(p), 1.0 + 0.5 * noise(p))).unzip();
    let affine_fields = AffineFields { moments, fields: &affine_fields, mass: &mass };
    let deposit = |affine_fields| {
        let mut nodes = vec![NodalState::default(); layout.len()];
        let given =
            P2gInput { momentum_and_mass: &motion, stress_columns: &columns, body_force: &[], affine_fields };
        sweeps.p2g(&ground, &points, NodeRange { nodes: &mut nodes, first: 0 }, &given);
        nodes
    };
    let (plain, whole) = (deposit(None), deposit(Some(affine_fields)));
    let mut momenta = vec![Vector4::ZERO; layout.len()];
    let to = NodeRange { nodes: &mut momenta[..], first: 0 };
    sweeps.p2g_values(&ground, &points, to, &[Vector4::ZERO; COUNT], Some(affine_fields));
    let size = momenta.iter().map(|m| m.abs().reduce_add()).fold(1.0, f64::max);
    let mut moved = 0.0f64;
    for ((plain, whole), momentum) in plain.iter().zip(&whole).zip(&momenta) {
        let apart = (whole.momentum_and_mass - plain.momentum_and_mass - *momentum).abs().reduce_add();
        assert!(apart <= 1e-13 * size, "{sweeps:?}: {apart:e} of {size:e}");
        assert!((whole.force - plain.force).abs().reduce_add() <= 1e-11, "{sweeps:?}");
        moved = moved.max(momentum.abs().reduce_add());
    }
    assert!(moved > 0.01, "{sweeps:?}: the fields carry momentum");
}

#[test]
fn a_sweep_with_affine_fields_is_the_sum_of_its_parts() {
    for shape in [
        ShapeFunctionKind::Linear,
        ShapeFunctionKind::Quadratic,
        ShapeFunctionKind::Cubic,
        ShapeFunctionKind::StretchingGimp,
        ShapeFunctionKind::Convected,
    ] {
        for moments in [true, false] {
            shape.on_line().into_iter().for_each(|sweeps| one_sweep_does_both(sweeps, moments));
            shape.in_plane().into_iter().for_each(|sweeps| one_sweep_does_both(sweeps, moments));
            shape.in_space().into_iter().for_each(|sweeps| one_sweep_does_both(sweeps, moments));
        }
    }
}
