use crate::stress::dual_domain::*;
use colluvium_grid::{LinearBasis, NodeSupport, Stencil};
use proptest::prelude::*;

/// Grid of `cells` of 0.5 m an axis with points at `places`, and the interpolation of a nodal field on it.
struct Ground<const D: usize> {
    grid: Grid<D>,
    layout: Layout<D>,
    dual: DualDomainNodes,
}

impl<const D: usize> Ground<D> {
    fn new(cells: usize, mut places: Vec<[f64; D]>) -> Self {
        let grid = Grid::new([0.0; D], [0.5 * cells as f64; D], 0.5).unwrap();
        let order = colluvium_grid::sort_by_cell(&grid, &places);
        places = order.iter().map(|i| places[*i as usize]).collect();
        let mut layout = Layout::new::<2, LinearBasis>(&grid);
        let bounds = layout.add_points(&places);
        let options = serde_json::json!({ "cell_size": 0.5, "shape": "dual-domain" });
        let options: MpmOptions = serde_json::from_value(options).unwrap();
        let mut dual = DualDomainNodes::new(&options, &layout, 1);
        let (stresses, volumes) = (vec![SymTensor::ZERO; places.len()], vec![0.1; places.len()]);
        dual.add_points(0, &grid, &layout, &|slab, visit| {
            let points = bounds[slab]..bounds[slab + 1];
            visit(&places[points.clone()], &stresses[points.clone()], &volumes[points]);
        });
        Self { grid, layout, dual }
    }

    /// Grid with a point in every cell.
    fn with_full_cells(cells: usize) -> Self {
        let count = cells.pow(D as u32);
        let place = |mut n: usize| {
            std::array::from_fn(|_| {
                let x = 0.5 * ((n % cells) as f64 + 0.5);
                n /= cells;
                x
            })
        };
        Self::new(cells, (0..count).map(place).collect())
    }

    fn node_position(&self, number: usize) -> [f64; D] {
        let mut rest = number;
        self.layout.strides().map(|stride| {
            let index = rest / stride;
            rest %= stride;
            0.5 * index as f64
        })
    }

    /// Gradient at a position of the field with the nodal values of `of`.
    fn gradient(&mut self, x: &[f64; D], of: &(dyn Fn([f64; D]) -> [f64; 3] + Sync)) -> [[f64; 3]; D] {
        let values: Vec<Vector4> = (0..self.layout.len())
            .map(|n| {
                let [a, b, c] = of(self.node_position(n));
                Vector4::new([a, b, c, 0.0])
            })
            .collect();
        self.dual.average_gradients(0, &self.grid, &self.layout, |n| values[n]);
        let stencil = Stencil::<D, 2>::new::<LinearBasis>(&self.grid, x, &[0.1; D]);
        let mut gradient = stencil.g2p_velocity(&values, &self.layout.strides()).gradient;
        self.dual.blend(0, &self.grid, &self.layout, x, &mut gradient);
        gradient.map(|column| {
            let [a, b, c, _] = column.to_array();
            [a, b, c]
        })
    }
}

#[test]
fn on_a_line_the_gradients_have_their_closed_form() {
    // At s of a cell of h, with α = 4 s (1 - s): the linear ± 1/h, and of the nodes the central differences.
    let mut line = Ground::<1>::with_full_cells(8);
    for s in [0.0, 0.1, 0.25, 0.5, 0.8] {
        let x = 0.5 * (3.0 + s);
        let alpha = 4.0 * s * (1.0 - s);
        let exact = [
            -(1.0 - alpha) * 0.5 * (1.0 - s),
            -alpha - (1.0 - alpha) * 0.5 * s,
            alpha + (1.0 - alpha) * 0.5 * (1.0 - s),
            (1.0 - alpha) * 0.5 * s,
        ];
        for (k, exact) in exact.into_iter().enumerate() {
            let node = 0.5 * (2 + k) as f64;
            let found =
                line.gradient(&[x], &|at| [if (at[0] - node).abs() < 1e-9 { 1.0 } else { 0.0 }, 0.0, 0.0]);
            assert!((found[0][0] - exact / 0.5).abs() < 1e-13, "{s}, node {k}: {found:?} for {exact}");
        }
    }
}

#[test]
fn the_own_share_is_one_in_the_middle_and_none_on_faces() {
    assert!((own_share(&[0.5; 3]) - 1.0).abs() < 1e-15 && own_share(&[0.5, 0.0]) == 0.0);
    // 2^D weights over each other: 256 × (1/4 × 3/4 × 1/2)² / 16 at (1/4, 1/2).
    let [w, n] = [own_share(&[0.25, 0.5]), (0..4).map(|k| weight(k, &[0.25, 0.5])).product::<f64>()];
    assert!((w - 256.0 * n).abs() < 1e-14, "{w}");
    let cube = (0..8).map(|k| weight(k, &[0.3, 0.4, 0.6])).product::<f64>();
    assert!((own_share(&[0.3, 0.4, 0.6]) / (8f64.powi(8) * cube) - 1.0).abs() < 1e-12);
}

/// Gradients of a constant and of the coordinates at `x`.
fn linear_fields<const D: usize>(ground: &mut Ground<D>, x: &[f64; D]) {
    for (j, column) in ground.gradient(x, &|_| [1.0, -2.0, 3.0]).into_iter().enumerate() {
        assert!(column.iter().all(|c| c.abs() < 1e-12), "∂/∂x_{j}: {column:?}");
    }
    let found = ground.gradient(x, &|at| std::array::from_fn(|c| if c < D { at[c] } else { 0.0 }));
    for (j, column) in found.into_iter().enumerate() {
        for (i, c) in column.into_iter().enumerate() {
            assert!((c - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12, "∂x_{i}/∂x_{j}: {c}");
        }
    }
}

/// Irregular field.
pub fn rough<const D: usize>(x: [f64; D]) -> [f64; 3] {
    let phase: f64 = x.iter().enumerate().map(|(a, x)| (7.3 + 3.1 * a as f64) * x * x).sum();
    [phase.sin(), (1.7 * phase).cos(), (phase + 0.4).sin()]
}

fn continuous<const D: usize>(mut place: [f64; D], axis: usize) {
    let mut ground = Ground::<D>::with_full_cells(5);
    let face = 1.0;
    let mut at = |x: f64| {
        place[axis] = x;
        ground.gradient(&place, &rough)
    };
    let (below, above) = (at(face - 1e-9), at(face + 1e-9));
    for (a, b) in below.as_flattened().iter().zip(above.as_flattened()) {
        assert!((a - b).abs() < 1e-6, "{place:?}: {a} and {b}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn linear_fields_have_their_gradients_at_the_surface_too(
        places in proptest::collection::vec(proptest::array::uniform3(0.0..2.0f64), 1..20),
    ) {
        linear_fields(&mut Ground::<1>::new(4, places.iter().map(|x| [x[0]]).collect()), &[places[0][0]]);
        let plane = places.iter().map(|x| [x[0], x[1]]).collect();
        linear_fields(&mut Ground::<2>::new(4, plane), &[places[0][0], places[0][1]]);
        linear_fields(&mut Ground::<3>::new(4, places.clone()), &places[0]);
    }

    #[test]
    fn gradients_pass_through_faces_without_a_jump(x in proptest::array::uniform3(0.0..2.5f64)) {
        continuous::<1>([x[0]], 0);
        (0..2).for_each(|axis| continuous::<2>([x[0], x[1]], axis));
        (0..3).for_each(|axis| continuous::<3>(x, axis));
    }
}
