//! Pore fluid of the bodies, as options of the method: one description serves the case and the method.

use std::borrow::Cow;

use colluvium_case::description::{Body, PoreFluid, PorePressure};
use colluvium_case::{Case, CaseError};
use serde_json::{Map, Value, json};

use crate::config::DepthOptions;
use crate::config::choices::{DepthFrame, Phases};
use crate::laws::interphase_drag::{InterphaseDrag, MixtureDensities};
use crate::laws::pore_pressure_column::Drainage;
use crate::setup::bed::case_bed::highest_wall;
use crate::setup::{NAME, option_error};
use colluvium_case::CaseErrorKind;
use colluvium_case::Warning;

/// Relative tolerance of densities and permeabilities that are given twice, of which one is derived.
const DERIVED_TOLERANCE: f64 = 0.01;
/// Relative tolerance of other values that are given twice.
const EQUAL_TOLERANCE: f64 = 1e-9;
/// Largest tension of the pore fluid in a pore-pressure column (Pa; sheet: depth-sph §2.7).
const MAX_TENSION: f64 = 1e5;

/// Data of a pore fluid for a flow.
struct PoreFluidData {
    grain: f64,
    fluid: f64,
    porosity: f64,
    conductivity: f64,
    excess: Option<f64>,
    cavitation: Option<f64>,
}

impl PoreFluidData {
    /// Densities, porosity and conductivity of the pore fluid of a body.
    fn of_body(case: &Case, body: &Body, fluid: &PoreFluid) -> Self {
        let weight = fluid.density * case.gravity_magnitude();
        Self {
            grain: case.materials[&body.material].density() / (1.0 - fluid.porosity),
            fluid: fluid.density,
            porosity: fluid.porosity,
            conductivity: fluid
                .permeability
                .unwrap_or_else(|| weight / fluid.resistance(case.gravity_magnitude())),
            excess: fluid.excess_ratio,
            cavitation: fluid.cavitation_strength,
        }
    }
}

/// Density of the flow of a body (kg/m³): with its pore fluid, where its material is the skeleton.
pub fn density(case: &Case, body: &Body) -> f64 {
    let own = case.materials[&body.material].density();
    body.pore_fluid.as_ref().map_or(own, |fluid| fluid.saturated_density(own))
}

/// Adds the pore fluid of the bodies of a case to the options of the method: values that both give must agree.
pub fn with_pore_fluid_options(case: &Case) -> Result<Cow<'_, Case>, CaseError> {
    let Some(first) = case.bodies.iter().position(|body| body.pore_fluid.is_some()) else {
        return Ok(Cow::Borrowed(case));
    };
    let mut options = case.methods.get(NAME).cloned().unwrap_or_else(|| json!({}));
    let phases = options["phases"].as_str().unwrap_or("one").to_owned();
    if phases == "layers" {
        let problem = "is not available for two layers: give their densities in methods.depth-sph.mixture";
        return Err(CaseError::new(
            format!("bodies[{first}].pore_fluid"),
            CaseErrorKind::coded("incompatible-options", problem),
        ));
    }
    let facts = common_pore_fluid(case, &phases)?;
    let Some(all) = options.as_object_mut() else { return Ok(Cow::Borrowed(case)) };
    let mixture = all.entry("mixture").or_insert_with(|| json!({}));
    if let Some(mixture) = mixture.as_object_mut() {
        fill_mixture_options(case, &facts, mixture)?;
        if phases == "two" {
            fill_porosities(case, facts.porosity, mixture)?;
        }
    }
    match all.get_mut("column").and_then(Value::as_object_mut) {
        Some(column) => fill_pore_column_options(case, &facts, column)?,
        None if facts.excess.is_some() => {
            let problem = "applies only with pore-pressure columns: give methods.depth-sph.column, or \
                           leave this out";
            return Err(CaseError::new(
                format!("bodies[{first}].pore_fluid.excess_ratio"),
                CaseErrorKind::coded("conflicting-keys", problem),
            ));
        }
        None => {}
    }
    fill_drainage(case, all)?;
    let mut stated = case.clone();
    stated.methods.insert(NAME.to_owned(), options);
    Ok(Cow::Owned(stated))
}

/// Pore fluid of all bodies. A flow has one kind of grains and one fluid, and in a single phase one porosity.
fn common_pore_fluid(case: &Case, phases: &str) -> Result<PoreFluidData, CaseError> {
    let mut found: Option<(PoreFluidData, &str)> = None;
    for (number, body) in case.bodies.iter().enumerate() {
        let path = |key: &str| format!("bodies[{number}].pore_fluid{key}");
        let Some(fluid) = &body.pore_fluid else {
            let problem = "is missing, but another body has one: either all bodies of depth-sph have a \
                           pore fluid, or none";
            return Err(CaseError::new(path(""), CaseErrorKind::coded("needs-other-key", problem)));
        };
        let own = PoreFluidData::of_body(case, body, fluid);
        if own.grain <= own.fluid {
            let problem = format!(
                "{} kg/m³ is not below the density of the grains, {:.1} kg/m³, the density of {:?} over 1 \
                 - porosity: the grains would float",
                own.fluid, own.grain, body.material
            );
            return Err(CaseError::new(path(".density"), problem));
        }
        if own.cavitation.is_some_and(|strength| strength > MAX_TENSION) {
            let problem = format!("is above {MAX_TENSION} Pa, the largest tension of a pore fluid");
            return Err(CaseError::new(path(".cavitation_strength"), problem));
        }
        let Some((other, name)) = &found else {
            found = Some((own, &body.name));
            continue;
        };
        let number_of = |value: Option<f64>| value.unwrap_or(-1.0);
        let pairs = [
            (".density", own.fluid, other.fluid, EQUAL_TOLERANCE),
            (
                ".porosity",
                own.porosity,
                other.porosity,
                if phases == "two" { f64::INFINITY } else { EQUAL_TOLERANCE },
            ),
            (".permeability", own.conductivity, other.conductivity, EQUAL_TOLERANCE),
            (".excess_ratio", number_of(own.excess), number_of(other.excess), EQUAL_TOLERANCE),
            (".cavitation_strength", number_of(own.cavitation), number_of(other.cavitation), EQUAL_TOLERANCE),
            ("", own.grain, other.grain, DERIVED_TOLERANCE),
        ];
        for (key, own, other, close) in pairs {
            if !are_equal(own, other, close) {
                let problem = match key {
                    "" => format!(
                        "has grains of {own:.1} kg/m³, the density of the material over 1 - porosity, but \
                         those of the body {name:?} have {other:.1} kg/m³: all grains of a flow of \
                         depth-sph have one density"
                    ),
                    ".porosity" => format!(
                        "{own} is not that of the body {name:?}, {other}: set methods.depth-sph.phases to \
                         `two`, or give both bodies the same porosity"
                    ),
                    _ => format!("is not that of the body {name:?}: a flow of depth-sph has one pore fluid"),
                };
                return Err(CaseError::new(path(key), problem));
            }
        }
    }
    found.map(|(facts, _)| facts).ok_or_else(|| CaseError::new("bodies", "there is none"))
}

/// Whether two numbers are equal within the relative tolerance `close`.
fn are_equal(one: f64, two: f64, close: f64) -> bool {
    (one - two).abs() <= close * one.abs().max(two.abs())
}

/// Writes a number under a key of the options, or checks the number given there.
fn set_option(
    into: &mut Map<String, Value>,
    path: &str,
    key: &str,
    value: f64,
    close: f64,
) -> Result<(), CaseError> {
    match into.get(key).map(Value::as_f64) {
        None => {
            into.insert(key.to_owned(), json!(value));
            Ok(())
        }
        // A value that is not a number is rejected by the options.
        Some(None) => Ok(()),
        Some(Some(given)) if are_equal(given, value, close) => Ok(()),
        Some(Some(given)) => {
            let problem = CaseErrorKind::coded(
                "conflicting-keys",
                format!(
                    "{given} differs from the value that follows from bodies[].pore_fluid, {value}: leave one \
                 of them out"
                ),
            );
            Err(option_error(&format!("{path}.{key}"), problem))
        }
    }
}

/// Writes the densities, porosity and drag of the pore fluid to the options of the mixture, or checks those given.
fn fill_mixture_options(
    case: &Case,
    facts: &PoreFluidData,
    mixture: &mut Map<String, Value>,
) -> Result<(), CaseError> {
    set_option(mixture, "mixture", "grain_density", facts.grain, DERIVED_TOLERANCE)?;
    set_option(mixture, "mixture", "fluid_density", facts.fluid, EQUAL_TOLERANCE)?;
    set_option(mixture, "mixture", "porosity", facts.porosity, EQUAL_TOLERANCE)?;
    let conductivity = facts.conductivity;
    let Some(given) = mixture.get("drag") else {
        mixture.insert("drag".to_owned(), json!({ "law": "darcy", "permeability": conductivity }));
        return Ok(());
    };
    let Ok(drag) = serde_json::from_value::<InterphaseDrag>(given.clone()) else { return Ok(()) };
    let gravity = case.gravity_magnitude();
    let densities = MixtureDensities { grain: facts.grain, fluid: facts.fluid, gravity };
    let own_law = drag.permeability(facts.porosity, &densities) * facts.fluid * gravity;
    if are_equal(own_law, conductivity, DERIVED_TOLERANCE) || drag.validate().is_err() {
        return Ok(());
    }
    let problem = format!(
        "gives a permeability of {own_law:.3e} m/s at a porosity of {}, but bodies[].pore_fluid gives \
         {conductivity:.3e} m/s: leave this out, or make the two equal",
        facts.porosity
    );
    Err(option_error("mixture.drag", CaseErrorKind::coded("conflicting-keys", problem)))
}

/// Writes the porosities of bodies that differ from that of the first body.
fn fill_porosities(case: &Case, first: f64, mixture: &mut Map<String, Value>) -> Result<(), CaseError> {
    for body in &case.bodies {
        let Some(fluid) = &body.pore_fluid else { continue };
        let listed = mixture.get("porosities").is_some_and(|all| all.get(&body.name).is_some());
        if !listed && are_equal(fluid.porosity, first, EQUAL_TOLERANCE) {
            continue;
        }
        let all = mixture.entry("porosities").or_insert_with(|| json!({}));
        if let Some(all) = all.as_object_mut() {
            set_option(all, "mixture.porosities", &body.name, fluid.porosity, EQUAL_TOLERANCE)?;
        }
    }
    Ok(())
}

/// Writes excess ratio and cavitation strength of the pore fluid to the options of the column, or checks those given.
fn fill_pore_column_options(
    case: &Case,
    facts: &PoreFluidData,
    column: &mut Map<String, Value>,
) -> Result<(), CaseError> {
    if let Some(ratio) = facts.excess {
        set_option(column, "column", "excess_ratio", ratio, EQUAL_TOLERANCE)?;
    }
    if let Some(strength) = facts.cavitation {
        let bound = column.entry("lower_bound").or_insert_with(|| json!({ "kind": "total" }));
        if let Some(bound) = bound.as_object_mut().filter(|bound| bound.get("kind") == Some(&json!("total")))
        {
            set_option(bound, "column.lower_bound", "cavitation", strength, EQUAL_TOLERANCE)?;
        }
    }
    if column.contains_key("consolidation") || column.contains_key("skeleton") {
        return Ok(());
    }
    // The material is the skeleton.
    let material = serde_json::to_value(&case.materials[&case.bodies[0].material]).unwrap_or_default();
    let [youngs_modulus, poissons_ratio] =
        ["youngs_modulus", "poissons_ratio"].map(|key| material[key].as_f64());
    if let (Some(youngs_modulus), Some(poissons_ratio)) = (youngs_modulus, poissons_ratio) {
        let skeleton = json!({ "youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio });
        column.insert("skeleton".to_owned(), skeleton);
    }
    Ok(())
}

/// Writes the drainage of walls to the options; a `drained` bed has atmospheric pressure.
fn fill_drainage(case: &Case, options: &mut Map<String, Value>) -> Result<(), CaseError> {
    let bed = highest_wall(case).map(|(number, ..)| number);
    for (number, boundary) in case.boundaries.iter().enumerate().filter(|(_, boundary)| boundary.drained) {
        let wrong = |problem: &str| Err(CaseError::new(format!("boundaries[{number}].drained"), problem));
        if boundary.side.axis() + 1 < case.dimension() {
            return wrong(
                "a side wall of depth-sph cannot be drained, because columns drain along their depth only: \
                 leave this out, or leave out the wall if the flow may leave through this side",
            );
        }
        if !case.obstacles.is_empty() {
            return wrong(
                "the obstacles are the bed: give their drainage in methods.depth-sph.drainage, and that of \
                 parts of them in methods.depth-sph.regions",
            );
        }
        if Some(number) != bed {
            return wrong("the flow is not on this wall: only the bed can be drained");
        }
        if !options.contains_key("column") {
            return wrong(
                "applies only with pore-pressure columns: give methods.depth-sph.column, or leave this out",
            );
        }
        let open = json!(Drainage::Atmospheric);
        let given = options.entry("drainage").or_insert_with(|| open.clone());
        if *given != open {
            let problem = format!(
                "{given} differs from boundaries[{number}].drained, a bed that is open to the air: leave \
                 one of them out"
            );
            return Err(option_error("drainage", CaseErrorKind::coded("conflicting-keys", problem)));
        }
    }
    Ok(())
}

/// Rejects parts of a pore fluid that the flow cannot represent.
pub fn check_supported(case: &Case, options: &DepthOptions) -> Result<(), CaseError> {
    for (number, body) in case.bodies.iter().enumerate() {
        let Some(fluid) = &body.pore_fluid else { continue };
        let path = |key: &str| format!("bodies[{number}].pore_fluid.{key}");
        if let Some(velocity) = &fluid.velocity {
            crate::setup::capabilities::check_velocity_along_bed(
                velocity,
                &path("velocity"),
                case.dimension() - 1,
            )?;
            if options.phases != Phases::Two && *velocity != body.velocity {
                let problem = "applies only to a fluid with separate nodes: set methods.depth-sph.phases \
                               to `two`, or leave this out";
                return Err(CaseError::new(
                    path("velocity"),
                    CaseErrorKind::coded("conflicting-keys", problem),
                ));
            }
        }
        let is_field = match fluid.pressure {
            PorePressure::None | PorePressure::Hydrostatic { .. } => false,
            PorePressure::Uniform { value } => value != 0.0,
            PorePressure::Formula { .. } => true,
        };
        if is_field && options.column.is_none() {
            let problem = "applies only with pore-pressure columns: without methods.depth-sph.column the \
                           pressure is hydrostatic below the surface of the flow";
            return Err(CaseError::new(path("pressure"), CaseErrorKind::coded("needs-other-key", problem)));
        }
    }
    Ok(())
}

/// Warnings for bodies without an initial pore pressure.
pub fn warnings(case: &Case) -> Vec<Warning> {
    let without = |body: &Body| {
        body.points.is_none()
            && body
                .pore_fluid
                .as_ref()
                .is_some_and(|fluid| fluid.pressure == PorePressure::None && fluid.excess_ratio.is_none())
    };
    let found = case.bodies.iter().position(without);
    let warning = |number: usize| {
        Warning::new(
            "default-pore-pressure",
            format!(
                "bodies[{number}].pore_fluid.pressure: is not given: the initial pore pressure is hydrostatic \
             below the surface of the flow. For another one give `pressure` or `excess_ratio`"
            ),
        )
    };
    found.map(warning).into_iter().collect()
}

/// Field of pore pressure (Pa) of a body at a position above the bed; `None` without a field.
pub struct PorePressureField<'a> {
    fluid: &'a PoreFluid,
    gravity: [f64; 3],
    /// Whether the pressure is hydrostatic and grows with the effective gravity of the slope.
    follows_slope: bool,
}

impl<'a> PorePressureField<'a> {
    /// Initial pore-pressure field of a body, if it has one.
    pub fn for_body(case: &Case, frame: Option<DepthFrame>, body: &'a Body) -> Option<Self> {
        let fluid = body.pore_fluid.as_ref().filter(|fluid| fluid.pressure != PorePressure::None)?;
        let follows_slope = fluid.surface().is_some() && frame.unwrap_or_default() == DepthFrame::Horizontal;
        Some(Self { fluid, gravity: case.gravity3(), follows_slope })
    }

    /// Pressure at a position (Pa), for the steepness `1 + |∇Z|²` of the bed.
    pub fn pressure_at(&self, x: [f64; 3], steepness: f64) -> f64 {
        let pressure = self.fluid.pressure_at(x, self.gravity);
        if self.follows_slope { pressure / steepness } else { pressure }
    }

    /// Level of the surface of the fluid (m), of a hydrostatic pressure.
    pub fn surface(&self) -> Option<f64> {
        self.fluid.surface()
    }
}
