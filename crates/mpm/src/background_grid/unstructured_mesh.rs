//! Meshes of triangles and tetrahedra in place of the structured grid (sheet: mpm §2.5b, §2.11, §3.1, §3.2).

use std::path::Path;
use std::sync::Arc;

use colluvium_case::description::{Body, Boundary, Wall as CaseWall};
use colluvium_case::{Case, CaseError};
use colluvium_grid::{Basis1d, Grid, Layout, Mesh};
use colluvium_points::Sample;

use crate::background_grid::structured_grid;
use crate::config::{InternalForceIntegration, MeshSource, ShapeFunctions, VolumetricStrain};
use crate::{LagrangianFormulation, MpmOptions, VelocityTransfer};
use colluvium_case::CaseErrorKind;

/// Rejects features that meshes do not support.
pub fn check_supported(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    let refuse = |key: &str, problem: &str| Err(CaseError::new(format!("methods.mpm.{key}"), problem));
    not_axis_by_axis(case, options)?;
    let grouped = case.boundaries.iter().position(|boundary| boundary.group.is_some());
    let Some(source) = &options.mesh else {
        return match grouped {
            Some(number) => {
                let problem = "needs methods.mpm.mesh from a file: a structured grid has no groups of nodes";
                Err(CaseError::new(
                    format!("boundaries[{number}].group"),
                    CaseErrorKind::coded("needs-other-key", problem),
                ))
            }
            None => Ok(()),
        };
    };
    if let (Some(number), MeshSource::Box) = (grouped, source) {
        let problem = "needs methods.mpm.mesh from a file: a box has no groups of nodes";
        return Err(CaseError::new(
            format!("boundaries[{number}].group"),
            CaseErrorKind::coded("needs-other-key", problem),
        ));
    }
    if case.dimension() == 1 {
        return refuse("mesh", "needs two or three dimensions");
    }
    if options.shape != ShapeFunctions::Linear {
        let problem = "a mesh of triangles or tetrahedra has linear shape functions only: gimp, cpdi and splines need \
             a structured grid";
        return refuse("shape", problem);
    }
    if options.transfer == VelocityTransfer::Apic {
        return refuse("transfer", "apic is not available on a mesh: use tpic");
    }
    if options.formulation == LagrangianFormulation::TotalLagrangian {
        return refuse("formulation", "total-lagrangian is not available on a mesh");
    }
    if !(1..=3).contains(&options.points_per_cell) {
        let problem = format!(
            "{} is not in 1..=3 (1, 3 or 6 points a triangle; 1, 4 or 10 a tetrahedron)",
            options.points_per_cell
        );
        return refuse("points_per_cell", &problem);
    }
    Ok(())
}

/// Rejects absorbing boundaries, periodic domains and free surfaces with options that lack the structured grid they require.
fn not_axis_by_axis(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    let refuse = |path: &str, problem: &str| Err(CaseError::new(path, problem));
    let special = options.mesh.is_some()
        || options.formulation == LagrangianFormulation::TotalLagrangian
        || matches!(options.shape, ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2);
    let absorbing = |boundary: &Boundary| matches!(boundary.wall, CaseWall::Absorbing { .. });
    if let Some(number) = case.boundaries.iter().position(absorbing).filter(|_| special) {
        let problem = "an absorbing boundary needs a structured grid with shape linear, ugimp, cpgimp, quadratic or cubic";
        return refuse(&format!("boundaries[{number}].wall"), problem);
    }
    let shared = options.volumetric_strain == VolumetricStrain::Nodal
        || options.integration != InternalForceIntegration::Points;
    if !case.domain.periodic.is_empty() && (special || shared) {
        let problem = "is not available with a mesh, total-lagrangian, cpdi, cpdi2, nodal volumetric strain or \
                       integration by cells";
        return refuse("domain.periodic", problem);
    }
    if options.free_surface.is_some() && options.formulation == LagrangianFormulation::TotalLagrangian {
        return refuse("methods.mpm.free_surface", "is not available with total-lagrangian");
    }
    Ok(())
}

/// Grid, mesh and order of the nodes of a case; the mesh is empty for a structured grid.
pub fn grid_mesh_and_layout<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    axis: &Basis1d,
) -> Result<(Grid<D>, Arc<Mesh<D>>, Layout<D>), CaseError> {
    let Some(source) = &options.mesh else {
        let grid = structured_grid::grid::<D>(case, options)?;
        let layout = structured_grid::layout(case, &grid, axis, options)?;
        return Ok((grid, Arc::default(), layout));
    };
    let mesh = match source {
        MeshSource::Box => Mesh::of_grid(&structured_grid::grid::<D>(case, options)?).map_err(|error| {
            CaseError::new("methods.mpm.mesh", CaseErrorKind::coded(error.code(), error.to_string()))
        })?,
        MeshSource::File { file } => read(Path::new(file))?,
    };
    let Some(grid) = mesh.cells() else {
        return Err(CaseError::new("methods.mpm.mesh", "is empty"));
    };
    let beyond = |x: &[f64; D], c: usize| {
        let (low, high) = (case.domain.min[c], case.domain.max[c]);
        let slack = 1e-9 * (high - low);
        x[c] < low - slack || x[c] > high + slack
    };
    if let Some(x) = mesh.nodes().iter().find(|x| (0..D).any(|c| beyond(x, c))) {
        let problem = format!("the mesh has a node at {x:?} m, outside the domain");
        return Err(CaseError::new("domain", problem));
    }
    let layout = Layout::of_mesh(&mesh, &grid);
    Ok((grid, Arc::new(mesh), layout))
}

/// Reads an unstructured mesh from a Gmsh file.
fn read<const D: usize>(file: &Path) -> Result<Mesh<D>, CaseError> {
    let fail =
        |problem: String| CaseError::new("methods.mpm.mesh.file", format!("{}: {problem}", file.display()));
    let bytes = std::fs::read(file).map_err(|error| fail(format!("cannot be read: {error}")))?;
    Mesh::from_msh(&bytes).map_err(|error| fail(error.to_string()))
}

/// Barycentric coordinates of the points of an element on a regular lattice: 1, 3 or 6 in a triangle, 1, 4 or 10 in a tetrahedron.
fn lattice_coordinates<const D: usize>(count: usize) -> Vec<[f64; 4]> {
    // Of the rules of second order with three and four points.
    let inset = if D == 2 { 1.0 / 3.0 } else { 0.5 * (5f64.sqrt() - 1.0) / 2.0 };
    let sum = (count - 1) as f64 + (D + 1) as f64 * inset;
    let mut points = Vec::new();
    let mut index = [0usize; 4];
    'all: loop {
        let used: usize = index[1..=D].iter().sum();
        if used < count {
            index[0] = count - 1 - used;
            points.push(std::array::from_fn(|k| if k <= D { (index[k] as f64 + inset) / sum } else { 0.0 }));
        }
        for k in 1..=D {
            index[k] += 1;
            if index[k] < count {
                continue 'all;
            }
            index[k] = 0;
        }
        return points;
    }
}

/// Number of points of a body in each element.
pub fn points_per_element<const D: usize>(options: &MpmOptions) -> usize {
    lattice_coordinates::<D>(options.points_per_cell).len()
}

/// Points of a body: the lattice points of all elements that are in its shape.
pub fn sample_body<const D: usize>(mesh: &Mesh<D>, options: &MpmOptions, body: &Body) -> Vec<Sample<D>> {
    let points = lattice_coordinates::<D>(options.points_per_cell);
    let mut samples = Vec::new();
    for (number, element) in mesh.elements().iter().enumerate() {
        for local in &points {
            let position = mesh.element_point(number as u32, &local[..=D]);
            if body.shape.contains(&position) {
                samples.push(Sample { position, volume: element.volume / points.len() as f64 });
            }
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lattice_coordinates_of_points_in_elements_are_those_of_the_sheet() {
        assert_eq!([1, 2, 3].map(|n| lattice_coordinates::<2>(n).len()), [1, 3, 6]);
        assert_eq!([1, 2, 3].map(|n| lattice_coordinates::<3>(n).len()), [1, 4, 10]);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-7;
        for point in lattice_coordinates::<2>(2) {
            assert!(point[..3].iter().all(|c| close(*c, 1.0 / 6.0) || close(*c, 2.0 / 3.0)), "{point:?}");
        }
        for point in lattice_coordinates::<3>(2) {
            assert!(point.iter().all(|c| close(*c, 0.585_410_2) || close(*c, 0.138_196_6)), "{point:?}");
        }
        for count in 1..=3 {
            for point in lattice_coordinates::<3>(count) {
                assert!((point.iter().sum::<f64>() - 1.0).abs() < 1e-15 && point.iter().all(|c| *c > 0.0));
            }
        }
    }
}
