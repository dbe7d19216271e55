//! Averaging cells: cells of a grid or elements of a mesh, with their volumes, corners and neighbours (sheet: mpm §2.16–2.18).
//!
//! A cell of a grid has the index of its lowest node, an element its own number: its entry in an array.

use colluvium_grid::{Grid, Mesh};

/// Cells by entry, and the nodes at their corners.
pub trait AveragingCells<const D: usize>: Sync {
    /// Number of corners of a cell.
    const CORNERS: usize;

    /// Volume of a cell (m³; m² in the plane, m³ per radian in axisymmetry).
    fn volume(&self, cell: usize) -> f64;

    /// Calls `visit(cell, which of its corners the node is)` for the cells around a node. On a grid some may lie outside of it, without
    /// points.
    fn for_each_cell_around(&self, node: usize, visit: impl FnMut(usize, usize));

    /// Calls `visit(node)` for the corners of a cell.
    fn corners(&self, cell: usize, visit: impl FnMut(usize));

    /// Calls `visit(cell)` for each cell that has a face in common with the given one.
    fn neighbours(&self, cell: usize, visit: impl FnMut(usize));

    /// Integrals over a cell of the gradient of a corner's shape function (m²; m in the plane, m² per radian in axisymmetry), and in
    /// axisymmetry of the shape function over the radius (m² per radian).
    fn gradient_integrals(&self, cell: usize, corner: usize) -> ([f64; D], f64);
}

/// Cells of a structured grid.
pub struct GridCells<'a, const D: usize> {
    /// The grid.
    pub grid: &'a Grid<D>,
    /// Differences of node numbers between neighbours along each axis.
    pub strides: [usize; D],
    /// Layers of nodes outside the domain.
    pub ghosts: usize,
    /// Whether the first axis is a radius.
    pub axisymmetric: bool,
}

impl<const D: usize> GridCells<'_, D> {
    /// Distance of the cell centre from the axis of rotation (m); 1 without axisymmetry.
    fn radius(&self, cell: usize) -> f64 {
        if self.axisymmetric {
            let column = (cell / self.strides[0]) as f64 - self.ghosts as f64;
            self.grid.origin[0] + (column + 0.5) * self.grid.cell
        } else {
            1.0
        }
    }

    /// Difference of node numbers from the first corner of a cell to another corner.
    fn offset(&self, corner: usize) -> usize {
        (0..D).map(|axis| (corner >> axis & 1) * self.strides[axis]).sum()
    }
}

impl<const D: usize> AveragingCells<D> for GridCells<'_, D> {
    const CORNERS: usize = 1 << D;

    fn volume(&self, cell: usize) -> f64 {
        self.grid.cell.powi(D as i32) * self.radius(cell)
    }

    fn for_each_cell_around(&self, node: usize, mut visit: impl FnMut(usize, usize)) {
        for corner in 0..Self::CORNERS {
            if let Some(cell) = node.checked_sub(self.offset(corner)) {
                visit(cell, corner);
            }
        }
    }

    fn corners(&self, cell: usize, mut visit: impl FnMut(usize)) {
        (0..Self::CORNERS).for_each(|corner| visit(cell + self.offset(corner)));
    }

    fn neighbours(&self, cell: usize, mut visit: impl FnMut(usize)) {
        let mut rest = cell;
        for (axis, stride) in self.strides.into_iter().enumerate() {
            let index = rest / stride - self.ghosts;
            rest %= stride;
            if index > 0 {
                visit(cell - stride);
            }
            if index + 1 < self.grid.cells[axis] {
                visit(cell + stride);
            }
        }
    }

    fn gradient_integrals(&self, cell: usize, corner: usize) -> ([f64; D], f64) {
        let half = 0.5 * self.grid.cell;
        let share = half.powi(D as i32 - 1) * self.radius(cell);
        let slope = |axis: usize| if corner >> axis & 1 == 1 { share } else { -share };
        let section = if self.axisymmetric { half.powi(D as i32) } else { 0.0 };
        (std::array::from_fn(slope), section)
    }
}

/// Elements of an unstructured mesh as averaging cells.
pub struct MeshCells<'a, const D: usize> {
    /// The mesh.
    pub mesh: &'a Mesh<D>,
    /// Whether the first axis is a radius.
    pub axisymmetric: bool,
}

impl<const D: usize> MeshCells<'_, D> {
    /// Nodes of a mesh element.
    fn nodes(&self, cell: usize) -> &[u32] {
        &self.mesh.elements()[cell].nodes[..=D]
    }
}

impl<const D: usize> AveragingCells<D> for MeshCells<'_, D> {
    const CORNERS: usize = D + 1;

    fn volume(&self, cell: usize) -> f64 {
        let section = self.mesh.elements()[cell].volume;
        if !self.axisymmetric {
            return section;
        }
        let radii = self.nodes(cell).iter().map(|&node| self.mesh.nodes()[node as usize][0]);
        section * radii.sum::<f64>() / Self::CORNERS as f64
    }

    fn for_each_cell_around(&self, node: usize, mut visit: impl FnMut(usize, usize)) {
        for &cell in self.mesh.elements_around(node as u32) {
            let corner = self.nodes(cell as usize).iter().position(|&n| n as usize == node);
            visit(cell as usize, corner.unwrap_or(0));
        }
    }

    fn corners(&self, cell: usize, mut visit: impl FnMut(usize)) {
        self.nodes(cell).iter().for_each(|&node| visit(node as usize));
    }

    fn neighbours(&self, cell: usize, mut visit: impl FnMut(usize)) {
        self.mesh.neighbours(cell as u32).for_each(|other| visit(other as usize));
    }

    fn gradient_integrals(&self, cell: usize, corner: usize) -> ([f64; D], f64) {
        let element = &self.mesh.elements()[cell];
        let volume = self.volume(cell);
        let section = if self.axisymmetric { element.volume / Self::CORNERS as f64 } else { 0.0 };
        (element.gradients[corner].map(|g| volume * g), section)
    }
}

#[cfg(test)]
mod tests {
    use crate::momentum::velocity_fields::VelocitySource;
    use crate::points::point_set::PointSet;
    use crate::points::vectors::vector4;
    use crate::setup::tests::initial_solver;
    use crate::solver::MpmSolver;
    use crate::stress::volumetric_strain::average_strains_of_one_phase;
    use crate::transfer::point_update::{UpdateSelection, update_points};
    use colluvium_case::Case;
    use colluvium_points::ScratchBuffers;
    use serde_json::{Value, json};

    /// A block of the material "m" that fills the domain of two cells of 1 m a side, and above it one of "n"; `options` are
    /// those of the method, `body` replaces or adds keys of the bodies.
    fn solver<const D: usize>(options: &Value, body: &Value) -> MpmSolver<D> {
        let corner =
            |last: f64| -> Vec<f64> { (0..D).map(|c| if c + 1 == D { last } else { 2.0 }).collect() };
        let low = |last: f64| -> Vec<f64> { (0..D).map(|c| if c + 1 == D { last } else { 0.0 }).collect() };
        let law =
            json!({ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0.25 });
        let mut text = json!({
            "title": "block", "space": if D == 2 { "plane-strain" } else { "3d" },
            "domain": { "min": low(0.0), "max": corner(4.0) }, "gravity": vec![0; D],
            "materials": { "m": law, "n": law },
            "bodies": [{ "name": "a", "material": "m", "shape": { "kind": "box", "min": low(0.0), "max": corner(2.0) } },
                       { "name": "b", "material": "n", "shape": { "kind": "box", "min": low(2.0), "max": corner(4.0) } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 1, "points_per_cell": 2, "shape": "linear", "mesh": { "kind": "box" } } }
        });
        for (key, value) in options.as_object().unwrap() {
            text["methods"]["mpm"][key] = value.clone();
        }
        for (key, value) in body.as_object().unwrap() {
            (0..2).for_each(|number| text["bodies"][number][key] = value.clone());
        }
        let case = Case::from_json(&text.to_string()).unwrap();
        initial_solver(&case)
    }

    /// Sets the velocities of the nodes, and the strains of the points in a step of 1 s.
    fn strain<const D: usize>(solver: &mut MpmSolver<D>, velocity: impl Fn(&[f64; D]) -> [f64; D]) {
        let mesh = solver.background.mesh.clone();
        for (node, x) in mesh.nodes().iter().enumerate() {
            solver.nodes.remapped_velocities[node] = vector4(&velocity(x), 0.0);
        }
        let MpmSolver { clock, background, bodies, nodes, boundary, averages, .. } = solver;
        clock.dt = 1.0;
        let strains = &mut averages.strains;
        average_strains_of_one_phase(clock, background, bodies, (nodes, VelocitySource::Remapped), strains);
        let what = UpdateSelection::STRESS;
        update_points(clock, background, bodies, (nodes, VelocitySource::Remapped), boundary, averages, what)
            .unwrap();
    }

    /// Averaged volumetric strains of skeleton and liquid at a point.
    fn shared_strain<const D: usize>(solver: &MpmSolver<D>, set: &PointSet<D>, p: usize) -> [f64; 2] {
        let cell = set.domain.as_slice().cell(p, &solver.background.grid_view(), &set.points.position[p]);
        solver.averages.strains.cell_strains(set.body, solver.background.cell_layout().len(), cell)
    }

    /// A velocity field of uniform symmetric gradient, small enough to add to 1 without loss.
    const RATES: [[f64; 3]; 3] = [[3e-9, 1e-9, -2e-9], [1e-9, -5e-9, 4e-9], [-2e-9, 4e-9, 7e-9]];

    fn uniform_strain_stays<const D: usize>() {
        // sheet: mpm A-35; E = 1, ν = 0.25: λ = μ = 0.4.
        let trace: f64 = (0..D).map(|c| RATES[c][c]).sum();
        for kind in ["nodal", "cell-average"] {
            let mut solver = solver::<D>(&json!({ "volumetric_strain": kind }), &json!({}));
            strain(&mut solver, |x| std::array::from_fn(|i| (0..D).map(|j| RATES[i][j] * x[j]).sum()));
            for set in &solver.bodies.sets {
                for p in 0..set.len() {
                    let [shared, _] = shared_strain(&solver, set, p);
                    assert!((shared / trace - 1.0).abs() < 1e-12, "{kind}: {shared} for {trace}");
                    let s = &set.points.stress[p].0;
                    for (place, [i, j]) in
                        [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]].into_iter().enumerate()
                    {
                        let rate = if i < D && j < D { RATES[i][j] } else { 0.0 };
                        let exact = 0.4 * if i == j { trace } else { 0.0 } + 0.8 * rate;
                        assert!((s[place] - exact).abs() < 1e-12 * 1e-8, "{kind}: {s:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn averaging_preserves_uniform_strain_in_triangles_and_tetrahedra() {
        uniform_strain_stays::<2>();
        uniform_strain_stays::<3>();
    }

    fn shared_strain_is_the_mean_of_means<const D: usize>() {
        // sheet: mpm §2.17, eqs. 6.35 and 6.36, element by element; A-35 for the rest.
        let mut solver = solver::<D>(&json!({ "volumetric_strain": "nodal" }), &json!({}));
        let velocity =
            |x: &[f64; D]| std::array::from_fn(|c| 1e-9 * (1.0 + c as f64 + x[0] * x[D - 1] + x[c] * x[c]));
        strain(&mut solver, velocity);
        let mesh = solver.background.mesh.clone();
        let own: Vec<[[f64; D]; D]> = (mesh.elements().iter())
            .map(|e| {
                let at = |k: usize| velocity(&mesh.nodes()[e.nodes[k] as usize]);
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| (0..=D).map(|k| at(k)[i] * e.gradients[k][j]).sum())
                })
            })
            .collect();
        let trace = |e: usize| (0..D).map(|c| own[e][c][c]).sum::<f64>();
        let mut differs = false;
        let material = |e: usize| mesh.element_point(e as u32, &[1.0 / (D + 1) as f64; 4][..=D])[D - 1] > 2.0;
        for set in &solver.bodies.sets {
            for p in 0..set.len() {
                let element = mesh.locate(&set.points.position[p]).unwrap() as usize;
                let of_node = |node: u32| {
                    let same = mesh.elements_around(node).iter().map(|&e| e as usize);
                    let same: Vec<usize> = same.filter(|&e| material(e) == material(element)).collect();
                    let volume = |e: usize| mesh.elements()[e].volume;
                    same.iter().map(|&e| trace(e) * volume(e)).sum::<f64>()
                        / same.iter().map(|&e| volume(e)).sum::<f64>()
                };
                let mean = mesh.elements()[element].nodes[..=D].iter().map(|&n| of_node(n)).sum::<f64>()
                    / (D + 1) as f64;
                let [shared, _] = shared_strain(&solver, set, p);
                assert!((shared / mean - 1.0).abs() < 1e-12, "{shared} for {mean}");
                differs |= (mean / trace(element) - 1.0).abs() > 0.1;
                // λ = μ = 0.4: σ_ii = λ tr ε + 2 μ ε_ii. Rotations of 1e-9 change the ninth digit.
                let (s, own) = (&set.points.stress[p].0, &own[element]);
                let close = |a: f64, b: f64| (a - b).abs() < 1e-7 * 1e-9;
                assert!(close(s[0] + s[1] + s[2], 3.0 * (0.4 + 0.8 / 3.0) * mean), "trace");
                assert!(close(s[0] - s[1], 0.8 * (own[0][0] - own[1][1])), "deviator");
                assert!(close(s[3], 0.4 * (own[0][1] + own[1][0])), "shear");
                if D == 2 {
                    assert!(close(s[2], 0.4 * mean), "nothing strains out of the plane");
                }
            }
        }
        assert!(differs, "not all have their own");
    }

    #[test]
    fn shared_strain_is_the_mean_over_nodes_of_means_over_elements_of_the_material() {
        shared_strain_is_the_mean_of_means::<2>();
        shared_strain_is_the_mean_of_means::<3>();
    }

    /// Forces at the nodes of the block under 7 Pa on all sides, without the points where `gap` is true.
    fn forces<const D: usize>(options: &Value, gap: impl Fn(&[f64; D]) -> bool) -> Vec<[f64; 4]> {
        let stress = json!({ "stress": { "kind": "uniform", "value": [7, 7, 7, 0, 0, 0] } });
        let mut solver = solver::<D>(options, &stress);
        solver.bodies.sets.iter_mut().for_each(|set| {
            set.retain_where(|points, i| !gap(&points.position[i]), &mut ScratchBuffers::default());
        });
        solver.sort();
        solver.p2g_for_tests();
        solver.nodes.nodal_states.iter().map(|node| node.force.to_array()).collect()
    }

    fn check_full_element_averages<const D: usize>() {
        // sheet: mpm S-04: one point less in an element within the block.
        let whole = solver::<D>(&json!({}), &json!({}));
        let mesh = whole.background.mesh.clone();
        let within = |x: &[f64; D]| {
            x.iter().enumerate().all(|(c, x)| *x > 0.5 && *x < if c + 1 == D { 3.5 } else { 1.5 })
        };
        let missing = *whole.bodies.sets[0].points.position.iter().find(|x| within(x)).unwrap();
        let element = mesh.locate(&missing).unwrap();
        let share = mesh.elements()[element as usize].volume / (D + 1) as f64;
        let inner = |x: &[f64; D]| (0..D).all(|c| x[c] > 0.0 && x[c] < if c + 1 == D { 4.0 } else { 2.0 });
        let [by_points, by_cells] =
            ["points", "mixed"].map(|kind| forces::<D>(&json!({ "integration": kind }), |x| *x == missing));
        for (node, x) in mesh.nodes().iter().enumerate().filter(|(_, x)| inner(x)) {
            let e = &mesh.elements()[element as usize];
            let corner = e.nodes[..=D].iter().position(|&n| n as usize == node);
            for c in 0..D {
                let exact = corner.map_or(0.0, |k| 7.0 * share * e.gradients[k][c]);
                assert!(
                    (by_points[node][c] - exact).abs() < 1e-13,
                    "{x:?}: {} for {exact}",
                    by_points[node][c]
                );
                assert!(by_cells[node][c].abs() < 1e-13, "{x:?}: {}", by_cells[node][c]);
            }
        }
        assert!(by_points.iter().zip(&by_cells).any(|(a, b)| (a[0] - b[0]).abs() > 0.1), "they differ");
    }

    #[test]
    fn averages_of_full_elements_are_independent_of_the_number_of_points() {
        check_full_element_averages::<2>();
        check_full_element_averages::<3>();
    }

    #[test]
    fn a_surface_element_counts_as_full_above_its_fill_threshold() {
        // A triangle on the surface that keeps one of its three points.
        let gap = |x: &[f64; 2]| x[1] > 1.0 || (x[1] > 0.5 && x[0] < 1.0);
        let at = |options: Value| {
            let nodes = solver::<2>(&json!({}), &json!({})).background.mesh.nodes().to_vec();
            let node = nodes.iter().position(|x| *x == [0.0, 1.0]).unwrap();
            forces::<2>(&options, gap)[node]
        };
        let points = at(json!({ "integration": "points" }));
        let strict = at(json!({ "integration": "mixed" }));
        let lenient = at(json!({ "integration": "mixed", "full_cell": 0.3 }));
        // The element (0,0), (0,1), (1,1), the only one left at the node (0,1), has points at 1/3, 5/6 and 5/6.
        for c in 0..2 {
            assert!((points[c] - strict[c]).abs() < 1e-14 && (lenient[c] - 3.0 * points[c]).abs() < 1e-13);
        }
        assert!(points[0].abs() > 0.1, "{points:?}");
    }
}
