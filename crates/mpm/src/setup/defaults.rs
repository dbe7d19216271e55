//! Defaults that depend on the case. What the case file gives stands.

use colluvium_case::Case;
use colluvium_case::description::Space;
use colluvium_constitutive::MaterialSpec;

use crate::{Formulation, Mass, MpmOptions, ObstacleContact, ShapeFunctions, Transfer, VolumetricStrain};

/// Points per cell and direction of liquids: with fewer, splashes fall apart into single points.
const POINTS_OF_LIQUIDS: usize = 3;
/// Fill ratio of cells below which liquids carry no stress (Anura3D manual 2021, after eq. 6.40).
const FREE_SURFACE_OF_LIQUIDS: f64 = 0.7;

/// Whether all bodies that deform are Newtonian liquids.
fn is_liquid(case: &Case) -> bool {
    let newtonian = |name: &String| matches!(case.materials.get(name), Some(MaterialSpec::NewtonianFluid(_)));
    let mut soft = case.bodies.iter().filter(|body| !body.rigid).peekable();
    soft.peek().is_some() && soft.all(|body| newtonian(&body.material) && body.pore_fluid.is_none())
}

/// Gives the options that the case leaves out what fits its bodies, and turns a `free_surface` of 0 into none.
pub(super) fn fit(case: &Case, options: &mut MpmOptions) {
    let given = |key: &str| case.methods.get("mpm").is_some_and(|mpm| mpm.get(key).is_some());
    let moves_in_space = options.formulation == Formulation::UpdatedLagrangian;
    if is_liquid(case) && moves_in_space {
        let of_flip = ["transfer", "flip", "stage_flip", "residual_time", "xpic_order"];
        // With shared volumetric strains and two points a cell TPIC makes energy in a liquid at rest.
        let own = options.volumetric_strain == VolumetricStrain::Point;
        let affine = own && options.shape != ShapeFunctions::DualDomain && options.mass == Mass::Lumped;
        if affine && !of_flip.into_iter().any(given) {
            options.transfer = Transfer::Tpic;
        }
        if !given("points_per_cell") && options.mesh.is_none() {
            options.points_per_cell = POINTS_OF_LIQUIDS;
        }
        if !given("obstacles") && !case.obstacles.is_empty() {
            options.obstacles = ObstacleContact::Points;
        }
        let opens = case.domain.periodic.is_empty() && case.space != Space::Axisymmetric;
        if !given("free_surface") && opens {
            options.free_surface = Some(FREE_SURFACE_OF_LIQUIDS);
        }
    }
    options.free_surface = options.free_surface.filter(|factor| *factor != 0.0);
}

#[cfg(test)]
mod tests {
    use colluvium_case::Case;
    use serde_json::{Value, json};

    use super::super::options;
    use crate::{ObstacleContact, Transfer};

    fn case(model: &Value, mpm: &Value) -> Case {
        let text = json!({
            "title": "defaults", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, -9.81],
            "materials": { "m": model },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.5, 0.5] } }],
            "obstacles": [{ "name": "o", "shape": { "kind": "plane", "point": [0.7, 0], "normal": [-1, 0] },
                            "wall": { "kind": "smooth" } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": mpm }
        });
        Case::from_json(&text.to_string()).unwrap()
    }

    fn water() -> Value {
        json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6, "viscosity": 1e-3 })
    }

    #[test]
    fn options_left_out_follow_the_material_of_liquids() {
        let found = options(&case(&water(), &json!({ "cell_size": 0.1 }))).unwrap();
        assert_eq!((found.transfer, found.points_per_cell), (Transfer::Tpic, 3));
        assert_eq!((found.free_surface, found.obstacles), (Some(0.7), ObstacleContact::Points));
        let soil = json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
        let found = options(&case(&soil, &json!({ "cell_size": 0.1 }))).unwrap();
        assert_eq!((found.transfer, found.points_per_cell), (Transfer::Flip, 2));
        assert_eq!((found.free_surface, found.obstacles), (None, ObstacleContact::Nodes));
    }

    #[test]
    fn options_of_liquids_that_are_given_stand() {
        let given = json!({ "cell_size": 0.1, "transfer": "flip", "points_per_cell": 2, "free_surface": 0, "obstacles": "nodes" });
        let found = options(&case(&water(), &given)).unwrap();
        assert_eq!((found.transfer, found.points_per_cell), (Transfer::Flip, 2));
        assert_eq!((found.free_surface, found.obstacles), (None, ObstacleContact::Nodes));
        for of_flip in [json!({ "flip": 0.9 }), json!({ "residual_time": 0.1 })] {
            let mut given = of_flip;
            given["cell_size"] = json!(0.1);
            assert_eq!(options(&case(&water(), &given)).unwrap().transfer, Transfer::Flip);
        }
    }
}
