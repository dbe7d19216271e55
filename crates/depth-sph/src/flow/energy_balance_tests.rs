//! Energy balance of two phases, of layers, under pore pressure and during erosion: it closes, and reports broken forces.

use std::sync::Arc;

use colluvium_constitutive::basal::BasalSpec;

use crate::bed::test_terrain::RoughSlope;
use crate::bed::{Bed, TerrainBed};
use crate::config::choices::Phases;
use crate::config::settings::{BedZone, Consolidation, FlowSettings, Mixture, PoreColumn};
use crate::flow::{EnergyBalanceSummary, Flow, PlanBoundaries};
use crate::laws::erosion::Erosion;
use crate::laws::interphase_drag::{InterphaseDrag, MixtureDensities};
use crate::laws::pore_pressure_column::{LowerBound, PressureProfile};
use crate::points::phase_nodes::NewNode;

/// Share of the exchanged energy by which the balance may be off: drag and friction are split off at first order in time.
const BALANCE_TOLERANCE: f64 = 2e-3;

/// One phase with 15° of friction.
fn frictional_settings() -> FlowSettings<2> {
    let mut settings = FlowSettings::single_phase(1000.0);
    let spec: BasalSpec = serde_json::from_str(r#"{ "model": "coulomb", "friction_angle": 15 }"#).unwrap();
    settings.zones = vec![BedZone::unbounded(Some(spec.build().unwrap()))];
    settings
}

/// Grains and fluid, or a lower and an upper layer.
fn two_sets(phases: Phases, porosity: f64) -> FlowSettings<2> {
    let mut settings = frictional_settings();
    settings.phases = phases;
    let densities = MixtureDensities { grain: 2600.0, fluid: 1000.0, gravity: 9.81 };
    settings.material = Mixture { densities, porosity, is_saturated: phases == Phases::Two };
    settings
}

/// Columns of pore pressure on the nodes.
fn with_pore_pressure() -> FlowSettings<2> {
    let mut settings = frictional_settings();
    let densities = MixtureDensities { grain: 2600.0, fluid: 1000.0, gravity: 9.81 };
    settings.material = Mixture { densities, porosity: 0.4, is_saturated: true };
    settings.column = Some(PoreColumn {
        cells: 8,
        weight: 0.5,
        profile: PressureProfile::FiniteDifference,
        consolidation: Consolidation::Coefficient(0.01),
        lower_bound: LowerBound::NoSuction,
        excess_ratio: 0.5,
        stiffness: 1e7,
        dilatancy: None,
    });
    settings
}

/// Energy balance after 4 s down a rough slope, with resistance multiplied by `factor`; `None` where the run ended before.
fn account(settings: FlowSettings<2>, depths: &[f64], factor: f64) -> Option<EnergyBalanceSummary> {
    let slope = RoughSlope::new(0.577, 60.0, [40.0, 200.0], 0.1, 3);
    let raster = slope.raster([0.0; 2], [500.0, 120.0], 5.0);
    let bed = Bed::Surface(Arc::new(TerrainBed::new(TerrainBed::smoothed(&raster, 1)).unwrap()));
    let spacing = 2.0;
    let set = |depth: &f64| -> Vec<NewNode<2>> {
        let node = |k: i32| NewNode {
            body: 0,
            position: [20.5 + spacing * f64::from(k % 10), 50.5 + spacing * f64::from(k / 10)],
            velocity: [0.0; 2],
            volume: depth * spacing * spacing,
            length: 1.3 * spacing,
            scale: 1.69,
        };
        (0..100).map(node).collect()
    };
    let sets: Vec<_> = depths.iter().map(set).collect();
    let mut flow = Flow::new(settings, bed, PlanBoundaries::default(), &sets).unwrap();
    flow.settings.numerics.test_factors[0] = factor;
    while flow.clock.time < 4.0 {
        let dt = flow.limit().dt.min(4.0 - flow.clock.time + 1e-12);
        flow.advance(dt).ok()?;
    }
    Some(flow.energy_balance_summary())
}

/// Checks that the balance closes, and that a resistance which adds energy is reported.
fn check_energy_balance(name: &str, settings: &FlowSettings<2>, depths: &[f64]) {
    let own = account(settings.clone(), depths, 1.0).unwrap();
    let off = own.error.abs() / own.exchanged_energy;
    println!("{name}: off by {off:.1e}");
    assert!(off < BALANCE_TOLERANCE, "{name}: {off:e}, {own:?}");
    let pushed = account(settings.clone(), depths, -0.5);
    assert!(pushed.is_none_or(|broken| broken.is_off()), "{name}: {pushed:?}");
}

#[test]
fn energy_balance_of_grains_and_fluid_closes() {
    let mut settings = two_sets(Phases::Two, 0.4);
    settings.drag = InterphaseDrag::Anderson { settling_velocity: 2.0.into(), exponent: 1.0 };
    check_energy_balance("two phases", &settings, &[0.3, 0.2]);
}

#[test]
fn energy_balance_of_two_layers_closes() {
    let mut settings = two_sets(Phases::Layers, 0.0);
    settings.interface_friction = 0.05;
    check_energy_balance("layers", &settings, &[0.3, 0.2]);
}

#[test]
fn energy_balance_under_pore_pressure_closes() {
    check_energy_balance("pore pressure", &with_pore_pressure(), &[0.5]);
}

/// Erosion brings its energy, and slows the flow down by the energy booked as friction.
#[test]
fn energy_balance_of_an_eroding_flow_closes() {
    let mut settings = frictional_settings();
    settings.zones[0].erosion = Some(Erosion::Hungr { rate: 0.01, plan_speed: false });
    check_energy_balance("erosion", &settings, &[0.5]);
}
