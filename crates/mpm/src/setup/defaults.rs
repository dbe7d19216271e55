//! Defaults that depend on the case. Values of the case file are not changed.

use colluvium_case::Case;
use colluvium_case::description::{Body, Space};
use colluvium_constitutive::MaterialSpec;

use crate::{
    LagrangianFormulation, MpmOptions, NodalMass, ObstacleCoupling, ShapeFunctions, VelocityTransfer,
    VolumetricStrain,
};

/// Points per cell and direction of liquids: with fewer, splashes separate into single points.
const POINTS_OF_LIQUIDS: usize = 3;
/// Fill ratio of cells below which liquids carry no stress (Anura3D manual 2021, after eq. 6.40).
const FREE_SURFACE_OF_LIQUIDS: f64 = 0.7;

/// Whether the material of a body is a Newtonian liquid.
fn is_newtonian(case: &Case, body: &Body) -> bool {
    let material = case.materials.get(&body.material);
    matches!(material, Some(MaterialSpec::NewtonianFluid(_))) && body.pore_fluid.is_none()
}

/// Whether all deformable bodies are Newtonian liquids.
pub(crate) fn is_liquid(case: &Case) -> bool {
    let mut soft = case.bodies.iter().filter(|body| !body.rigid).peekable();
    soft.peek().is_some() && soft.all(|body| is_newtonian(case, body))
}

/// Numbers of the liquid bodies in velocity fields that contain liquids only.
fn liquids_in_fields(case: &Case, options: &MpmOptions) -> Vec<usize> {
    let is_named = |body: &Body| options.contacts.iter().any(|contact| contact.bodies.contains(&body.name));
    let mut shared = case.bodies.iter().filter(|body| !body.rigid && !is_named(body));
    let all_shared = shared.all(|body| is_newtonian(case, body));
    let own = |body: &Body| !body.rigid && is_newtonian(case, body) && (is_named(body) || all_shared);
    (0..case.bodies.len()).filter(|number| own(&case.bodies[*number])).collect()
}

/// Whether liquids may have an affine transfer by default: the case gives no transfer, and no option excludes it.
fn may_use_affine(options: &MpmOptions, given: &dyn Fn(&str) -> bool) -> bool {
    let of_flip = ["transfer", "flip", "stage_flip", "residual_time", "xpic_order"];
    // With averaged volumetric strains and two points a cell TPIC adds energy to a liquid at rest.
    let own = options.volumetric_strain == VolumetricStrain::Point;
    let affine = own && options.shape != ShapeFunctions::DualDomain && options.mass == NodalMass::Lumped;
    affine && !of_flip.into_iter().any(given)
}

/// Enables free-surface detection for liquids, if it is available.
fn set_free_surface(case: &Case, options: &mut MpmOptions, given: &dyn Fn(&str) -> bool) {
    let opens = case.domain.periodic.is_empty() && case.space != Space::Axisymmetric;
    if !given("free_surface") && opens {
        options.free_surface = Some(FREE_SURFACE_OF_LIQUIDS);
    }
}

/// Sets TPIC and free-surface detection for liquids in a case with other bodies, if velocity fields are separate.
fn set_liquid_fields(case: &Case, options: &mut MpmOptions, given: &dyn Fn(&str) -> bool) {
    let liquids = liquids_in_fields(case, options);
    if liquids.is_empty() {
        return;
    }
    set_free_surface(case, options, given);
    if may_use_affine(options, given) {
        options.liquid_bodies = liquids;
    }
}

/// Sets the defaults of absent options for the bodies of the case, and removes a `free_surface` of 0.
pub(super) fn set_case_defaults(case: &Case, options: &mut MpmOptions) {
    let given = |key: &str| case.methods.get("mpm").is_some_and(|mpm| mpm.get(key).is_some());
    options.liquid_bodies.clear();
    let moves_in_space = options.formulation == LagrangianFormulation::UpdatedLagrangian;
    if is_liquid(case) && moves_in_space {
        if may_use_affine(options, &given) {
            options.transfer = VelocityTransfer::Tpic;
        }
        if !given("points_per_cell") && options.mesh.is_none() {
            options.points_per_cell = POINTS_OF_LIQUIDS;
        }
        if !given("obstacles") && !case.obstacles.is_empty() {
            options.obstacles = ObstacleCoupling::Points;
        }
        set_free_surface(case, options, &given);
    }
    let wet = case.bodies.iter().any(|body| body.pore_fluid.is_some());
    if !is_liquid(case) && moves_in_space && !wet {
        set_liquid_fields(case, options, &given);
    }
    options.free_surface = options.free_surface.filter(|factor| *factor != 0.0);
}

#[cfg(test)]
mod tests {
    use colluvium_case::Case;
    use serde_json::{Value, json};

    use super::super::options;
    use crate::{ObstacleCoupling, VelocityTransfer};

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
        assert_eq!((found.transfer, found.points_per_cell), (VelocityTransfer::Tpic, 3));
        assert_eq!((found.free_surface, found.obstacles), (Some(0.7), ObstacleCoupling::Points));
        let soil = json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
        let found = options(&case(&soil, &json!({ "cell_size": 0.1 }))).unwrap();
        assert_eq!((found.transfer, found.points_per_cell), (VelocityTransfer::Flip, 2));
        assert_eq!((found.free_surface, found.obstacles), (None, ObstacleCoupling::Nodes));
    }

    #[test]
    fn a_liquid_in_a_velocity_field_of_its_own_has_its_defaults_beside_soil() {
        let soil = json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
        let beside = |mpm: Value| {
            let mut text: Value = serde_json::from_str(&case(&water(), &mpm).to_json()).unwrap();
            text["materials"]["s"] = soil.clone();
            let block = json!({ "name": "s", "material": "s", "shape": { "kind": "box", "min": [0, 0.6], "max": [0.5, 0.8] } });
            text["bodies"].as_array_mut().unwrap().push(block);
            options(&Case::from_json(&text.to_string()).unwrap()).unwrap()
        };
        let contact = json!([{ "bodies": ["b", "s"], "friction_coefficient": 0 }]);
        let found = beside(json!({ "cell_size": 0.1, "contacts": contact }));
        assert_eq!(
            (found.transfer, found.liquid_bodies.clone(), found.free_surface),
            (VelocityTransfer::Flip, vec![0], Some(0.7))
        );
        assert_eq!(
            (found.transfer_of(0), found.transfer_of(1)),
            (VelocityTransfer::Tpic, VelocityTransfer::Flip)
        );
        assert_eq!((found.points_per_cell, found.obstacles), (2, ObstacleCoupling::Nodes));
        let found = beside(json!({ "cell_size": 0.1, "contacts": contact, "flip": 0.99 }));
        assert_eq!((found.liquid_bodies, found.free_surface), (vec![], Some(0.7)), "flip is asked for");
        let found = beside(json!({ "cell_size": 0.1 }));
        assert_eq!((found.liquid_bodies, found.free_surface), (vec![], None), "one field for both");
    }

    #[test]
    fn given_options_of_liquids_override_defaults() {
        let given = json!({ "cell_size": 0.1, "transfer": "flip", "points_per_cell": 2, "free_surface": 0, "obstacles": "nodes" });
        let found = options(&case(&water(), &given)).unwrap();
        assert_eq!((found.transfer, found.points_per_cell), (VelocityTransfer::Flip, 2));
        assert_eq!((found.free_surface, found.obstacles), (None, ObstacleCoupling::Nodes));
        for of_flip in [json!({ "flip": 0.9 }), json!({ "residual_time": 0.1 })] {
            let mut given = of_flip;
            given["cell_size"] = json!(0.1);
            assert_eq!(options(&case(&water(), &given)).unwrap().transfer, VelocityTransfer::Flip);
        }
    }
}
