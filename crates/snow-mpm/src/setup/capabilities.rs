//! Supported and rejected features of a case, and warnings.

use colluvium_case::description::min_extent;
use colluvium_case::measure::{CrackTip, Fragments, Measure};
use colluvium_case::{Capabilities, Case, CaseError, Feature};
use colluvium_constitutive::MaterialSpec;
use colluvium_points::Shape;

use crate::config::{NAME, SnowOptions};
use crate::solver::saw_test;
use colluvium_case::Warning;

/// Message for adhesion to an obstacle whose coupling has no contact area.
const ADHESION: &str = "snow-mpm has no contact area for obstacles on nodes: leave out the adhesion";

/// Features that the method supports in addition to those of all point methods.
const SUPPORTED: &[Feature] = &[
    Feature::DomainOrigin,
    Feature::BodiesRemoveOutside,
    Feature::Boundaries,
    Feature::BoundariesName,
    Feature::BoundariesPosition,
    Feature::BoundariesSeparation,
    Feature::BoundariesVelocity,
    Feature::BoundariesWallRough,
    Feature::BoundariesWallSmooth,
    Feature::BoundariesWallFrictional,
    Feature::BoundariesWallBilateral,
    Feature::Obstacles,
    Feature::ObstaclesWallRough,
    Feature::ObstaclesWallSmooth,
    Feature::ObstaclesWallFrictional,
    Feature::ObstaclesSeparation,
    Feature::StagesDamping,
    Feature::StagesDampingAxes,
    Feature::MeasuresDissipation,
    Feature::MeasuresReaction,
    Feature::MeasuresImpactPressure,
];

/// Features that the method supports with all their variants and keys, in addition to those of all point methods.
const SUPPORTED_WHOLLY: &[Feature] = &[
    Feature::DomainPeriodic,
    Feature::BoundariesSide,
    Feature::ObstaclesShape,
    Feature::ObstaclesMotion,
    Feature::ObstaclesRegions,
    Feature::RemovalShapes,
    Feature::OutputRasters,
];

/// Support of the features of a case.
pub(crate) fn capabilities(case: &Case) -> Capabilities {
    let honours = Capabilities::for_point_methods(NAME)
        .supports(SUPPORTED)
        .supports_all_of(SUPPORTED_WHOLLY)
        .rejects(Feature::OutputRastersMapped, "only depth-sph compares rasters with a mapped outline")
        .rejects(Feature::SpaceAxisymmetric, "snow-mpm has no axisymmetric form: use plane-strain or 3d")
        .rejects(Feature::BodiesRigid, "snow-mpm has no rigid bodies: use a boundary with a velocity")
        .rejects(Feature::BodiesPoreFluid, "snow-mpm has one phase only: use mpm")
        .rejects(Feature::BoundariesGroup, "snow-mpm has no mesh with groups of nodes")
        .rejects(Feature::BoundariesWallAbsorbing, "snow-mpm has no absorbing boundaries: use mpm")
        .rejects(Feature::ObstaclesWallAdhesion, ADHESION)
        .rejects(Feature::ObstaclesRegionsWallAdhesion, ADHESION)
        .rejects(
            Feature::Loads,
            "snow-mpm has no loads on surfaces: use a body that lies on it, a boundary with a velocity, or \
             mpm",
        )
        .rejects(Feature::Patches, "snow-mpm has no patches of nodes: use a boundary with a velocity")
        .rejects(Feature::StagesExcavate, "snow-mpm removes whole bodies only: use remove_bodies")
        .rejects(Feature::StagesRayleighDamping, "snow-mpm has local damping only: use damping");
    if case.domain.periodic.is_empty() {
        return honours;
    }
    honours
        .rejects(Feature::Obstacles, "an obstacle has no periodic image: use boundaries, and tilt gravity")
        .rejects(Feature::RemovalShapes, "a cut has no periodic image: use walls")
}

/// Warnings about permitted but doubtful values of a case (sheet: snow-mpm §7).
pub(super) fn warnings(case: &Case, options: &SnowOptions) -> Vec<Warning> {
    let mut warnings = case.warnings();
    warnings.extend(options.warnings());
    warnings.extend(poissons_ratio_warnings(case));
    let dimension = case.dimension();
    for (number, cut) in case.removal_shapes.iter().enumerate() {
        let thinnest = min_extent(&cut.bounds(dimension));
        // Sheet: snow-mpm P12.
        if thinnest < 2.0 * options.cell_size * (1.0 - 1e-9) {
            warnings.push(Warning::new("thin-cut", format!(
                "removal_shapes[{number}].shape: its smallest width is {thinnest} m, less than two cells. The \
                 material on both sides of such a thin cut stays in contact: make the cut wider, or the cells \
                 smaller"
            )));
        }
    }
    for (number, body) in case.bodies.iter().enumerate() {
        let cells = body.shape.min_thickness(dimension) / options.cell_size;
        // Sheet: snow-mpm P10.
        let (minimum, why) = if may_soften(&case.materials[&body.material]) {
            (
                4.0,
                "a layer that softens needs 4 or more, and its resistance to fracture depends on their number. Use smaller cells or a thicker layer",
            )
        } else {
            (
                2.0,
                "shape functions extend across it: with 2 or more it bends and shears independently. Use smaller cells or a thicker body",
            )
        };
        if cells < minimum - 1e-9 {
            warnings.push(Warning::new(
                "thin-body",
                format!("bodies[{number}].shape: its smallest thickness is {cells:.2} cells; {why}"),
            ));
        }
        warnings.extend(weak_layer_base_warning(case, number, options));
    }
    warnings.extend(saw_test::warnings(case));
    warnings.extend(
        case.measures.iter().filter_map(|(name, measure)| measure_warning(case, name, measure, options)),
    );
    warnings
}

/// Warning for a weak layer with less than two cells of other snow between it and the ground.
fn weak_layer_base_warning(case: &Case, number: usize, options: &SnowOptions) -> Option<Warning> {
    let body = &case.bodies[number];
    let Shape::ArcLayer { from, .. } = &body.shape else { return None };
    let cells = from / options.cell_size;
    (saw_test::is_weak(case, body) && cells < 2.0 - 1e-9).then(|| {
        Warning::new("weak-layer-on-steps", format!(
            "bodies[{number}].shape.from: the weak layer lies {cells:.2} cells above the ground. Where the \
             ground is not parallel to an axis, its nodes form steps of a cell, and points at a step collapse \
             under the slab alone: add two cells or more of old, elastic snow below the layer"
        ))
    })
}

/// Warning for a measure whose lengths are not resolved by the cell size (sheet: snow-mpm §3.11), or for a crack in a body that cannot
/// collapse.
fn measure_warning(case: &Case, name: &str, measure: &Measure, options: &SnowOptions) -> Option<Warning> {
    let cell = options.cell_size;
    match measure {
        Measure::Fragments(Fragments { link, .. }) if !(1.0 - 1e-9..=1.5 + 1e-9).contains(&(link / cell)) => {
            let cells = link / cell;
            Some(Warning::new(
                "unresolved-measure",
                format!(
                    "measures.{name}.link: {link} m is {cells:.2} cells, but points of one fragment lie up to \
                 1 to 1.5 cells apart. Give {cell} to {:.4} m",
                    1.5 * cell
                ),
            ))
        }
        Measure::CrackTip(CrackTip { bin, .. })
            if *bin < cell / options.points_per_cell as f64 * (1.0 - 1e-9) =>
        {
            Some(Warning::new(
                "unresolved-measure",
                format!(
                    "measures.{name}.bin: {bin} m is less than the spacing of the points, so that some bins \
                 contain no points: use a cell, {cell} m"
                ),
            ))
        }
        Measure::CrackTip(CrackTip { field, body, .. })
            if field == "collapsed"
                && !case.bodies.iter().any(|own| own.name == *body && saw_test::is_weak(case, own)) =>
        {
            Some(Warning::new(
                "option-without-effect",
                format!(
                    "measures.{name}.body: the material of {body:?} does not collapse, so that the crack has no \
                     length. Give a body of `cohesive-cam-clay` that softens as a weak layer"
                ),
            ))
        }
        _ => None,
    }
}

/// Warnings for unusual Poisson's ratios of laws that have no such warning (sheet: snow-mpm §7).
fn poissons_ratio_warnings(case: &Case) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for (name, spec) in &case.materials {
        let Some((_, ratio)) = saw_test::elastic_constants(spec) else { continue };
        if spec.warnings().iter().any(|warning| warning.text.starts_with("poissons_ratio")) {
            continue;
        }
        if ratio > 0.45 {
            warnings.push(Warning::new(
                "locking",
                format!(
                    "materials.{name}.poissons_ratio: {ratio} is above 0.45: low-order grids lock. Give 0.45 \
                 or less"
                ),
            ));
        } else if ratio < 0.0 {
            warnings.push(Warning::new(
                "negative-poissons-ratio",
                format!(
                    "materials.{name}.poissons_ratio: {ratio} is negative: the material contracts laterally \
                 under compression. Give 0 or more"
                ),
            ));
        }
    }
    warnings
}

/// Whether a law may lose strength: neither elastic nor a fluid.
fn may_soften(spec: &MaterialSpec) -> bool {
    use MaterialSpec::{FixedCorotated, LinearElastic, NeoHookean, PressureElastic, StVenantKirchhoff};
    let elastic = |spec: &MaterialSpec| {
        matches!(
            spec,
            LinearElastic(_) | NeoHookean(_) | StVenantKirchhoff(_) | FixedCorotated(_) | PressureElastic(_)
        )
    };
    !spec.is_fluid() && !elastic(spec.inner().unwrap_or(spec))
}

/// Rejects weak layers thinner than two cells, across which nodal shape functions extend (sheet: snow-mpm §7).
pub(super) fn check_layer_thickness(case: &Case, options: &SnowOptions) -> Result<(), CaseError> {
    for (number, body) in case.bodies.iter().enumerate() {
        let weak = saw_test::is_weak(case, body);
        let thickness = body.shape.min_thickness(case.dimension());
        if weak && thickness < 2.0 * options.cell_size * (1.0 - 1e-9) {
            let problem = format!(
                "the weak layer is {thickness} m thick, less than two cells of {} m, so that the bodies above \
                 and below it are in contact: make the cells smaller",
                options.cell_size
            );
            return Err(CaseError::new(format!("bodies[{number}].shape"), problem));
        }
    }
    Ok(())
}
