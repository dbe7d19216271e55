//! Parts of a surface, as they are seen in plan.

use std::sync::Arc;

use colluvium_points::{Outline, Shape};

use crate::Case;

/// A part of the plan.
#[derive(Clone, Debug)]
pub enum PlanRegion {
    /// A shape in the coordinates of the plan.
    Shape(Shape),
    /// An outline in the two coordinates of a plan.
    Outline(Arc<Outline>),
}

impl PlanRegion {
    /// Whether it holds a place with these coordinates in plan (m).
    #[inline]
    pub fn holds(&self, place: &[f64]) -> bool {
        match self {
            Self::Shape(shape) => shape.contains(place),
            Self::Outline(outline) => matches!(place, [x, y] if outline.contains([*x, *y])),
        }
    }
}

impl Case {
    /// The part of the plan in a shape with coordinates from `domain.origin`, or in the outline of a file.
    ///
    /// # Errors
    /// The key, `shape` or `outline`, with what is below it, and what is wrong: none is given, or both; a shape that is none in plan;
    /// an outline where the plan is a line, or whose file cannot be read; what lies beyond the domain.
    pub fn plan_region(
        &self,
        shape: Option<Shape>,
        outline: Option<&str>,
    ) -> Result<PlanRegion, (String, String)> {
        let wrong = |key: &str, problem: String| Err((key.to_owned(), problem));
        match (shape, outline) {
            (Some(shape), None) => match shape.validate(self.dimension() - 1) {
                Ok(()) => {
                    let (low, high) = shape.bounds(self.dimension() - 1);
                    match self.beyond_the_plan(&low, &high) {
                        Some(problem) => wrong("shape", problem),
                        None => Ok(PlanRegion::Shape(shape)),
                    }
                }
                Err(error) => wrong(&format!("shape.{}", error.path), error.problem),
            },
            (None, Some(_)) if self.dimension() != 3 => {
                wrong("outline", "an outline in plan needs a space of 3d: give a shape".to_owned())
            }
            (None, Some(file)) => match self.outline(file) {
                Ok(outline) => {
                    let (low, high) = outline.bounds();
                    match self.beyond_the_plan(&low, &high) {
                        Some(problem) => wrong("outline", format!("{file}: {problem}")),
                        None => Ok(PlanRegion::Outline(Arc::new(outline))),
                    }
                }
                Err(problem) => wrong("outline", problem),
            },
            _ => wrong("shape", "give either a shape or an outline".to_owned()),
        }
    }

    /// What is wrong with a part of the plan between these corners (m), where none of it lies in the domain.
    fn beyond_the_plan(&self, low: &[f64], high: &[f64]) -> Option<String> {
        let origin = self.origin();
        let ends = (0..self.dimension() - 1).map(|c| (c, self.domain.min[c], self.domain.max[c]));
        let apart = ends.into_iter().find(|(c, min, max)| high[*c] <= *min || low[*c] >= *max);
        apart.map(|(c, min, max)| {
            let [from, to, min, max] = [low[c], high[c], min, max].map(|x| x + origin[c]);
            let axis = ["x", "y"][c];
            format!("reaches from {from} to {to} m along {axis}, and the domain from {min} to {max} m: none of it lies there")
        })
    }
}
