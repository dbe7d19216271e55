//! Initial state of a body's material law and its output fields, for all solvers.

use std::sync::Arc;

use colluvium_constitutive::{BLOCK_SIZE, InitialCondition, Material, StateBlock, States, SymTensor};

use crate::CaseErrorKind;
use crate::solver::reset_error;
use crate::{Case, CaseError, Field, FieldData, FrameRequest, PointList, spatial};

/// State of the material law of a body at its points before the first step.
pub struct InitialLawState {
    /// Material law of the body.
    pub material: Arc<dyn Material>,
    /// Stresses of the points (Pa).
    pub stress: Vec<SymTensor>,
    /// States of the material law.
    pub states: States,
}

impl Case {
    /// Initialises the law of body number `number` at its points at `positions` (m); `listed` is their list where they come from a file.
    ///
    /// # Errors
    /// When the law cannot be built, or cannot start at a point with the given initial stress; when the points have pore pressures and the
    /// body has no pore fluid.
    pub fn initialise_law<const D: usize>(
        &self,
        number: usize,
        listed: Option<&PointList>,
        positions: &[[f64; D]],
    ) -> Result<InitialLawState, CaseError> {
        let body = &self.bodies[number];
        if body.pore_fluid.is_none() && listed.is_some_and(|list| list.pore_pressures.is_some()) {
            let problem = "the points have pore pressures, but the body has no `pore_fluid` (an undrained \
                           material has its own pore pressure). Give the body a `pore_fluid`, or leave the \
                           column out";
            return Err(CaseError::new(
                format!("bodies[{number}].points.file"),
                CaseErrorKind::coded("conflicting-keys", problem),
            ));
        }
        let spec = &self.materials[&body.material];
        let material =
            spec.build().map_err(|error| CaseError::new(format!("materials.{}", body.material), error))?;
        let initial: Vec<InitialCondition> = positions
            .iter()
            .enumerate()
            .map(|(point, x)| {
                let stress = self.initial_stress_of(body, listed, point, spatial(x));
                Ok(InitialCondition { stress, density: self.density_at(number, listed, point)? })
            })
            .collect::<Result<_, CaseError>>()?;
        let (stress, states) = material.initial(&initial).map_err(|error| {
            let place = &positions[error.index];
            CaseError::new(format!("bodies[{number}].stress"), format!("at {place:?} m: {}", error.source))
        })?;
        Ok(InitialLawState { material, stress, states })
    }
}

/// Points of a body with the data of its material law.
#[derive(Clone, Copy)]
pub struct LawPoints<'a> {
    /// Material law of the body.
    pub material: &'a dyn Material,
    /// Stresses of the points (Pa).
    pub stress: &'a [SymTensor],
    /// States of the material law.
    pub states: &'a States,
}

/// Index of a point in its body, and the reason why its law rejects its state.
pub type LawRefusal = (usize, String);

impl LawPoints<'_> {
    /// Computes `width` numbers for each point, in the order of the points. `values` computes them for a block of points of the law.
    pub fn law_values(
        &self,
        width: usize,
        mut values: impl FnMut(&[SymTensor], &StateBlock, &mut [f64]),
    ) -> Vec<f64> {
        let mut out = vec![0.0; self.stress.len() * width];
        if width > 0 {
            let blocks = self.stress.chunks(BLOCK_SIZE).zip(self.states.blocks());
            for ((stress, states), out) in blocks.zip(out.chunks_mut(BLOCK_SIZE * width)) {
                values(stress, states, out);
            }
        }
        out
    }

    /// Recoverable energies per volume (J/m³), zero where the law defines none.
    pub fn stored_energies(&self) -> Vec<f64> {
        self.law_values(1, |stress, states, out| {
            self.material.stored_energies(stress, states, out);
        })
    }

    /// Whether the law defines a recoverable energy.
    pub fn defines_energy(&self) -> bool {
        let mut out = vec![0.0; BLOCK_SIZE];
        let first = self.stress.chunks(BLOCK_SIZE).zip(self.states.blocks()).next();
        first.is_none_or(|(stress, states)| {
            self.material.stored_energies(stress, states, &mut out[..stress.len()])
        })
    }

    /// Restarts the law from the current stresses, and returns the stresses and initial states of the points. `density` gives the density
    /// (kg/m³) of a point by its index.
    ///
    /// # Errors
    /// The first point at which the law cannot start.
    pub fn restarted_states(
        &self,
        density: impl Fn(usize) -> f64,
    ) -> Result<(Vec<SymTensor>, States), LawRefusal> {
        let condition =
            |(i, stress): (usize, &SymTensor)| InitialCondition { stress: *stress, density: density(i) };
        let initial: Vec<InitialCondition> = self.stress.iter().enumerate().map(condition).collect();
        let begun = self.material.initial(&initial);
        begun.map_err(|error| (error.index, reset_error(&error.source.to_string())))
    }
}

/// Values of an output of the laws, by its name, at the points of bodies, one body after another; NaN where the law of a body has no such
/// output, `None` where no law has.
pub fn law_output<'a>(bodies: impl Iterator<Item = LawPoints<'a>>, name: &str) -> Option<Vec<f64>> {
    let (mut values, mut is_known) = (Vec::new(), false);
    for body in bodies {
        let names = body.material.output_names();
        match names.iter().position(|own| *own == name) {
            Some(column) => {
                is_known = true;
                let table = body.law_values(names.len(), |stress, states, out| {
                    body.material.outputs(stress, states, out);
                });
                values.extend(table.chunks(names.len()).map(|row| row[column]));
            }
            None => values.resize(values.len() + body.stress.len(), f64::NAN),
        }
    }
    is_known.then_some(values)
}

/// Scalar output fields of the laws at the points of `order`, each given by the index of its body and its index in the body. NaN where the
/// law of a point has no such output. Laws without a field in `wanted` are not asked.
pub fn law_fields(
    bodies: &[LawPoints<'_>],
    order: &[(usize, usize)],
    wanted: FrameRequest<'_>,
) -> Vec<Field> {
    let names: Vec<&[&'static str]> = bodies.iter().map(|body| body.material.output_names()).collect();
    let table = |(body, names): (&LawPoints<'_>, &&[&'static str])| {
        if !names.iter().any(|name| wanted.includes(name)) {
            return Vec::new();
        }
        body.law_values(names.len(), |stress, states, out| body.material.outputs(stress, states, out))
    };
    let tables: Vec<Vec<f64>> = bodies.iter().zip(&names).map(table).collect();
    let mut known: Vec<&'static str> = Vec::new();
    for &name in names.iter().copied().flatten() {
        if wanted.includes(name) && !known.contains(&name) {
            known.push(name);
        }
    }
    let field = |name: &'static str| {
        let column = |names: &&[&'static str]| names.iter().position(|own| *own == name);
        let columns: Vec<Option<usize>> = names.iter().map(column).collect();
        let value = |&(body, i): &(usize, usize)| {
            columns[body].map_or(f64::NAN, |column| tables[body][i * names[body].len() + column])
        };
        let data = FieldData::Scalar(order.iter().map(value).collect());
        Field { name: name.to_owned(), unit: "", data }
    };
    known.into_iter().map(field).collect()
}
