//! Zones of the bed with their laws.

use colluvium_case::{Case, CaseError, PlanRegion};
use colluvium_constitutive::basal::BasalRheology;

use crate::config::settings::{BedZone, FluidResistance};
use crate::config::{DepthOptions, FluidResistanceOptions};
use crate::setup::bed::case_bed::{bed_friction, obstacle_friction};
use crate::setup::{material, option_error};

/// Region in plan of an obstacle with specified friction, and its basal law.
type ObstacleZone = (PlanRegion, Option<BasalRheology>);

/// Zones of the bed in the order of priority: regions of the options, obstacles, and the remaining bed.
pub fn zones(case: &Case, options: &DepthOptions) -> Result<Vec<BedZone>, CaseError> {
    let rest = BedZone {
        regions: Vec::new(),
        law: material::basal_law(case, options, bed_friction(case))?,
        drainage: options.drainage,
        fluid: fluid_resistance(options.mixture.as_ref().map(|mixture| mixture.fluid_resistance)),
        erosion: options.erosion,
        erodible_depth: options.erodible_depth.unwrap_or(f64::INFINITY),
    };
    let held = of_obstacles(case, options)?;
    let mut zones = Vec::new();
    for (number, region) in options.regions.iter().enumerate() {
        let key = |name: &str| format!("regions[{number}].{name}");
        let shape = region.shape.clone().map(|shape| case.relative_to_origin(shape));
        let part = case.plan_region(shape, region.outline.as_deref(), region.raster.as_ref());
        let part = part.map_err(|(below, problem)| option_error(&key(&below), problem))?;
        let zone = |regions: Vec<PlanRegion>, law| BedZone {
            regions,
            law,
            drainage: region.drainage.unwrap_or(options.drainage),
            fluid: region.fluid_resistance.map_or(rest.fluid, |own| fluid_resistance(Some(own))),
            erosion: region.erosion,
            erodible_depth: region.erodible_depth.or(options.erodible_depth).unwrap_or(f64::INFINITY),
        };
        if let Some(spec) = &region.basal {
            let law = material::build_basal_law(options, spec, &key("basal"))?;
            zones.push(zone(vec![part], Some(law)));
            continue;
        }
        zones.extend(held.iter().map(|(within, law)| zone(vec![part.clone(), within.clone()], *law)));
        zones.push(zone(vec![part], rest.law));
    }
    zones.extend(held.into_iter().map(|(part, law)| BedZone { regions: vec![part], law, ..rest.clone() }));
    zones.push(rest);
    Ok(zones)
}

/// Fluid resistance of the options; none without.
fn fluid_resistance(options: Option<FluidResistanceOptions>) -> FluidResistance {
    match options.unwrap_or_default() {
        FluidResistanceOptions::None => FluidResistance::None,
        FluidResistanceOptions::Laminar { viscosity } => FluidResistance::Laminar(viscosity),
        FluidResistanceOptions::Manning { coefficient } => FluidResistance::Manning(coefficient),
        FluidResistanceOptions::Turbulent { turbulence } => FluidResistance::Turbulent(turbulence),
    }
}

/// Zones from the regions of the obstacle that is the bed.
fn of_obstacles(case: &Case, options: &DepthOptions) -> Result<Vec<ObstacleZone>, CaseError> {
    let Some(number) = case.obstacles.iter().position(|obstacle| !obstacle.regions.is_empty()) else {
        return Ok(Vec::new());
    };
    let path = format!("obstacles[{number}].regions");
    let refuse = |problem: &str| Err(CaseError::new(path.clone(), problem));
    if case.obstacles.len() > 1 {
        return refuse(
            "several obstacles are the bed: give the parts of it that differ in methods.depth-sph.regions",
        );
    }
    if options.basal.is_some() {
        return refuse(
            "methods.depth-sph.basal applies to the whole bed: give the parts of it that differ in \
             methods.depth-sph.regions",
        );
    }
    let held = case.obstacles[number].regions.iter().enumerate().map(|(part, region)| {
        let made = case.plan_region(region.shape.clone(), region.outline.as_deref(), region.raster.as_ref());
        let place =
            made.map_err(|(key, problem)| CaseError::new(format!("{path}[{part}].{key}"), problem))?;
        Ok((place, material::basal_law(case, options, Some(obstacle_friction(region.wall)))?))
    });
    held.collect()
}
