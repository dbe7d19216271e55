//! Energy balance of one phase: it closes, and reports broken forces.

use std::sync::Arc;

use colluvium_constitutive::basal::BasalSpec;

use crate::bed::test_terrain::RoughSlope;
use crate::bed::{Bed, TerrainBed};
use crate::config::choices::PressureForceForm;
use crate::config::settings::{BedZone, FlowSettings};
use crate::flow::{EnergyBalanceSummary, Flow, PlanBoundaries};
use crate::points::phase_nodes::NewNode;

fn rough() -> Bed<2> {
    let slope = RoughSlope::new(0.577, 60.0, [40.0, 200.0], 0.1, 3);
    let raster = slope.raster([0.0; 2], [500.0, 120.0], 5.0);
    Bed::Surface(Arc::new(TerrainBed::new(TerrainBed::smoothed(&raster, 1)).unwrap()))
}

fn heap(bed: Bed<2>, friction: Option<f64>, depth: f64, spacing: f64) -> Flow<2> {
    heap_of(PressureForceForm::Automatic, bed, friction, depth, spacing)
}

fn heap_of(form: PressureForceForm, bed: Bed<2>, friction: Option<f64>, depth: f64, spacing: f64) -> Flow<2> {
    let mut nodes = Vec::new();
    for k in 0..100 {
        let position = [20.5 + spacing * f64::from(k % 10), 50.5 + spacing * f64::from(k / 10)];
        let volume = depth * spacing * spacing;
        let length = 1.3 * spacing;
        nodes.push(NewNode { body: 0, position, velocity: [0.0; 2], volume, length, scale: 1.69 });
    }
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.numerics.momentum = form;
    if let Some(angle) = friction {
        let spec = format!(r#"{{ "model": "coulomb", "friction_angle": {angle} }}"#);
        let spec: BasalSpec = serde_json::from_str(&spec).unwrap();
        settings.zones = vec![BedZone::unbounded(Some(spec.build().unwrap()))];
    }
    Flow::new(settings, bed, PlanBoundaries::default(), &[nodes]).unwrap()
}

fn run(flow: &mut Flow<2>, end: f64) -> EnergyBalanceSummary {
    while flow.clock.time < end {
        let dt = flow.limit().dt.min(end - flow.clock.time + 1e-12);
        flow.advance(dt).unwrap();
    }
    flow.energy_balance_summary()
}

/// Without pressure and friction only gravity does work.
#[test]
fn a_node_that_slides_freely_keeps_its_energy() {
    let mut flow = heap(rough(), None, 1e-9, 3.0);
    while flow.clock.time < 6.0 {
        flow.advance(flow.limit().dt.min(0.01)).unwrap();
    }
    let account = flow.energy_balance_summary();
    assert!(account.error.abs() < 1e-5 * account.exchanged_energy, "{account:?}");
}

#[test]
fn energy_balance_of_a_flow_with_friction_closes_and_friction_only_dissipates() {
    let mut flow = heap(rough(), Some(15.0), 0.5, 2.0);
    let account = run(&mut flow, 8.0);
    assert!(account.error.abs() < 2e-3 * account.exchanged_energy, "{account:?}");
    assert!(flow.records.energy_balance.friction > 0.2 * account.exchanged_energy && !account.is_off());
}

#[test]
fn accelerating_friction_is_detected_by_the_energy_balance() {
    let mut flow = heap(rough(), Some(5.0), 0.5, 2.0);
    flow.settings.numerics.test_factors[0] = -1.0;
    assert!(run(&mut flow, 4.0).is_off());
}

/// Pressure of the form that keeps energy, so that only the fault has an effect.
#[test]
fn pressure_that_generates_energy_is_detected_by_the_energy_balance() {
    let spreading = || heap_of(PressureForceForm::Variational, Bed::Flat(0.0), None, 2.0, 1.0);
    let mut flow = spreading();
    assert!(!run(&mut flow, 1.0).is_off(), "{:?}", flow.energy_balance_summary());
    let mut flow = spreading();
    flow.settings.numerics.test_factors[1] = 1.2;
    assert!(run(&mut flow, 1.0).is_off(), "{:?}", flow.energy_balance_summary());
}
