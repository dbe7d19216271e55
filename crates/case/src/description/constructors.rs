//! Constructors of a case in Rust: required values are arguments, chained setters add the rest.
//!
//! A case that is described here is checked when a solver is built from it, with the errors and the paths that its file would have.

use std::sync::Arc;

use colluvium_constitutive::{ExternalSpec, Material, MaterialSpec};
use colluvium_points::{Sampling, Shape};
use serde::Serialize;
use serde_json::Value;

use crate::Measure;
use crate::description::{
    Body, Boundary, Case, Domain, InitialStress, Load, Obstacle, ObstacleRegion, ObstacleShape, ObstacleWall,
    Output, Patch, PoreFluid, PorePressure, PrescribedMotion, ProfilePiece, RasterCellSelection,
    RemovalShape, Side, Space, Stage, Velocity, Wall,
};
use crate::files::finite_numbers::mark_first_non_finite;

/// Options of a method as values of a program.
pub trait MethodOptions: Serialize + Sized {
    /// Name of the method, the key under `methods` in a case file.
    const METHOD: &'static str;
    /// Keys that a case file must contain.
    const REQUIRED: &'static [&'static str];

    /// Options with the same required values, and the defaults of a case file for all others.
    #[must_use]
    fn default_options(&self) -> Self;
}

impl Case {
    /// Case without bodies, walls, loads and stages, without gravity. Positions are relative to the origin of the domain, which is zero
    /// unless given.
    #[must_use]
    pub fn new(space: Space, domain: Domain) -> Self {
        Self {
            schema: None,
            title: "untitled".to_owned(),
            notes: Vec::new(),
            space,
            domain,
            gravity: vec![0.0; space.dimension()],
            materials: Default::default(),
            bodies: Vec::new(),
            boundaries: Vec::new(),
            obstacles: Vec::new(),
            loads: Vec::new(),
            patches: Vec::new(),
            removal_shapes: Vec::new(),
            stages: Vec::new(),
            output: Output::default(),
            measures: Default::default(),
            methods: Default::default(),
        }
    }

    /// Sets the title, one line.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Sets the acceleration of gravity (m/s²), one number per space dimension.
    #[must_use]
    pub fn gravity(mut self, gravity: impl Into<Vec<f64>>) -> Self {
        self.gravity = gravity.into();
        self
    }

    /// Adds a material of the constitutive core by its parameters; a later material of the same name replaces an earlier one.
    #[must_use]
    pub fn material(mut self, name: impl Into<String>, spec: impl Into<MaterialSpec>) -> Self {
        self.materials.insert(name.into(), spec.into());
        self
    }

    /// Adds a material of an initial density (kg/m³) with a law of the program. A file of the case names the law only: a program that
    /// reads it needs [`colluvium_constitutive::laws::register_material`].
    #[must_use]
    pub fn law(mut self, name: impl Into<String>, density: f64, law: Arc<dyn Material>) -> Self {
        let name = name.into();
        let spec = ExternalSpec::from_law(name.clone(), density, law);
        self.materials.insert(name, spec.into());
        self
    }

    /// Adds a body.
    #[must_use]
    pub fn body(mut self, body: Body) -> Self {
        self.bodies.push(body);
        self
    }

    /// Adds a wall on a side of the domain.
    #[must_use]
    pub fn wall(self, side: Side, wall: Wall) -> Self {
        self.boundary(Boundary::new(side, wall))
    }

    /// Adds a wall with all its options.
    #[must_use]
    pub fn boundary(mut self, boundary: Boundary) -> Self {
        self.boundaries.push(boundary);
        self
    }

    /// Adds an obstacle.
    #[must_use]
    pub fn obstacle(mut self, obstacle: Obstacle) -> Self {
        self.obstacles.push(obstacle);
        self
    }

    /// Adds a load.
    #[must_use]
    pub fn load(mut self, load: Load) -> Self {
        self.loads.push(load);
        self
    }

    /// Adds a patch of prescribed velocity.
    #[must_use]
    pub fn patch(mut self, patch: Patch) -> Self {
        self.patches.push(patch);
        self
    }

    /// Adds a shape that removes the points that it covers.
    #[must_use]
    pub fn removal_shape(mut self, shape: RemovalShape) -> Self {
        self.removal_shapes.push(shape);
        self
    }

    /// Adds a stage after those before.
    #[must_use]
    pub fn stage(mut self, stage: Stage) -> Self {
        self.stages.push(stage);
        self
    }

    /// Sets the output.
    #[must_use]
    pub fn output(mut self, output: Output) -> Self {
        self.output = output;
        self
    }

    /// Adds a measure; a later one of the same name replaces an earlier one.
    #[must_use]
    pub fn measure(mut self, name: impl Into<String>, measure: impl Into<Measure>) -> Self {
        self.measures.insert(name.into(), measure.into());
        self
    }

    /// Sets the options of a method, as in a case file: options at the values of `new` count as absent there, and have the default that
    /// the method chooses for the case.
    #[must_use]
    pub fn method<O: MethodOptions>(mut self, options: &O) -> Self {
        self.methods.insert(O::METHOD.to_owned(), given_options(options));
        self
    }
}

/// Options as a case file contains them: without those at the values of [`MethodOptions::default_options`]. JSON has no NaN and no
/// infinity: such a number becomes a text, which the check of the case refuses at its path.
fn given_options<O: MethodOptions>(options: &O) -> Value {
    let to_value = |options: &O| serde_json::to_value(options).expect("options are plain data");
    let (mut given, defaults) = (to_value(options), to_value(&options.default_options()));
    mark_first_non_finite(options, &mut given);
    if let Value::Object(given) = &mut given {
        given.retain(|key, value| O::REQUIRED.contains(&key.as_str()) || defaults.get(key) != Some(value));
    }
    given
}

impl Domain {
    /// Box between two corners (m).
    #[must_use]
    pub fn new(min: impl Into<Vec<f64>>, max: impl Into<Vec<f64>>) -> Self {
        Self { min: min.into(), max: max.into(), origin: Vec::new(), periodic: Vec::new() }
    }
}

impl Body {
    /// Deformable body of a material in a shape, at rest and stress-free.
    #[must_use]
    pub fn new(name: impl Into<String>, material: impl Into<String>, shape: Shape) -> Self {
        Self {
            name: name.into(),
            shape,
            points: None,
            sampling: Sampling::default(),
            sampling_seed: 0,
            material: material.into(),
            velocity: Velocity::Rest,
            stress: InitialStress::None,
            rigid: false,
            pore_fluid: None,
            remove_outside: false,
        }
    }

    /// Body in an axis-aligned box between two corners (m).
    #[must_use]
    pub fn block(
        name: impl Into<String>,
        material: impl Into<String>,
        min: impl Into<Vec<f64>>,
        max: impl Into<Vec<f64>>,
    ) -> Self {
        Self::new(name, material, Shape::Box { min: min.into(), max: max.into() })
    }

    /// Body in a ball (disk in two dimensions) about a centre (m).
    #[must_use]
    pub fn ball(
        name: impl Into<String>,
        material: impl Into<String>,
        centre: impl Into<Vec<f64>>,
        radius: f64,
    ) -> Self {
        Self::new(name, material, Shape::Ball { centre: centre.into(), radius })
    }

    /// Sets a uniform initial velocity (m/s).
    #[must_use]
    pub fn velocity(self, velocity: impl Into<Vec<f64>>) -> Self {
        Self { velocity: Velocity::Uniform { value: velocity.into() }, ..self }
    }
}

impl Wall {
    /// Wall with Coulomb friction of a coefficient (-), from which material may separate.
    #[must_use]
    pub fn frictional(friction_coefficient: f64) -> Self {
        Self::Frictional { friction_coefficient, bilateral: false }
    }
}

impl Boundary {
    /// Wall at rest on a side of the domain.
    #[must_use]
    pub fn new(side: Side, wall: Wall) -> Self {
        Self {
            name: None,
            side,
            group: None,
            position: None,
            wall,
            separation: false,
            velocity: None,
            drained: false,
        }
    }
}

impl Stage {
    /// Stage of a duration (s), without damping, with full gravity from its start.
    #[must_use]
    pub fn new(name: impl Into<String>, duration: f64) -> Self {
        Self {
            name: name.into(),
            duration,
            damping: 0.0,
            damping_axes: None,
            rayleigh_damping: 0.0,
            gravity_ramp: 0.0,
            equilibrium: None,
            motions: Vec::new(),
            reset: Vec::new(),
            remove_boundaries: Vec::new(),
            remove_bodies: Vec::new(),
            excavate: Vec::new(),
            weakening: None,
        }
    }
}

impl Obstacle {
    /// Obstacle at rest.
    #[must_use]
    pub fn new(name: impl Into<String>, shape: ObstacleShape, wall: ObstacleWall) -> Self {
        Self { name: name.into(), shape, wall, separation: false, motion: None, regions: Vec::new() }
    }
}

impl ObstacleRegion {
    /// Region of a wall in a shape.
    #[must_use]
    pub fn in_shape(shape: Shape, wall: ObstacleWall) -> Self {
        Self { shape: Some(shape), outline: None, raster: None, wall }
    }

    /// Region of a wall in the outlines of a file.
    #[must_use]
    pub fn in_outline(file: impl Into<String>, wall: ObstacleWall) -> Self {
        Self { shape: None, outline: Some(file.into()), raster: None, wall }
    }

    /// Region of a wall in the cells of a raster.
    #[must_use]
    pub fn in_raster(cells: RasterCellSelection, wall: ObstacleWall) -> Self {
        Self { shape: None, outline: None, raster: Some(cells), wall }
    }
}

impl RasterCellSelection {
    /// All cells of a file that have data.
    #[must_use]
    pub fn new(file: impl Into<String>) -> Self {
        Self { file: file.into(), value: None }
    }
}

impl ProfilePiece {
    /// Straight piece to a position (m).
    #[must_use]
    pub fn new(to: [f64; 2]) -> Self {
        Self { to, centre: None }
    }
}

impl Patch {
    /// Patch that stays at its initial position, through which no pore fluid passes.
    #[must_use]
    pub fn new(name: impl Into<String>, region: Shape) -> Self {
        Self { name: name.into(), region, moves: false, drained: false }
    }
}

impl PrescribedMotion {
    /// Prescribed velocity (m/s) of a rigid body or patch from the beginning of the stage.
    #[must_use]
    pub fn new(target: impl Into<String>, velocity: impl Into<Vec<f64>>) -> Self {
        Self {
            target: target.into(),
            velocity: velocity.into().into_iter().map(Some).collect(),
            force: Vec::new(),
            moment: Vec::new(),
            rotates: false,
            ramp: 0.0,
        }
    }
}

impl PoreFluid {
    /// Water in pores of an initial porosity (-), with a hydraulic conductivity (m/s).
    #[must_use]
    pub fn new(porosity: f64, permeability: f64) -> Self {
        Self {
            porosity,
            permeability: Some(permeability),
            intrinsic_permeability: None,
            density: PoreFluid::water_density(),
            bulk_modulus: PoreFluid::water_bulk_modulus(),
            viscosity: PoreFluid::water_viscosity(),
            pressure: PorePressure::None,
            excess_ratio: None,
            velocity: None,
            cavitation_strength: None,
        }
    }
}
