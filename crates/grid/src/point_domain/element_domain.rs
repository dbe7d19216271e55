//! Point domains in the elements of a mesh (sheet: mpm §3.2).

use crate::point_domain::{GridView, PointDomain, RightStretchDiagonal};
use crate::{Basis, NodeList};

/// Element that contains a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ElementDomain {
    element: u32,
}

impl<const D: usize> PointDomain<D> for ElementDomain {
    type Support<const S: usize> = NodeList<D, S>;

    const CHECKPOINT_NUMBERS: usize = 1;

    crate::point_domain::domain_columns::domain_column!(Elements);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        position: &[f64; D],
        _initial: &[f64; D],
    ) -> NodeList<D, S> {
        ground.mesh.support(self.element, position)
    }

    #[inline(always)]
    fn cell(&self, _ground: &GridView<'_, D>, _position: &[f64; D]) -> usize {
        self.element as usize
    }

    #[inline(always)]
    fn extent(&self, initial: &[f64; D], _cell: f64) -> [f64; D] {
        *initial
    }

    #[inline(always)]
    fn spacing(&self, ground: &GridView<'_, D>) -> f64 {
        ground.mesh.elements()[self.element as usize].height
    }

    fn initialise(&mut self, ground: &GridView<'_, D>, position: &[f64; D]) -> Result<(), String> {
        self.element = ground.mesh.locate(position).ok_or("it lies outside the mesh")?;
        Ok(())
    }

    #[inline(always)]
    fn relocate(&mut self, ground: &GridView<'_, D>, position: &[f64; D]) -> Result<(), String> {
        let found = ground.mesh.locate_from(self.element, position);
        self.element = found.ok_or("it left the mesh: enlarge the mesh or add a wall on that side")?;
        Ok(())
    }

    fn append_numbers(self, numbers: &mut Vec<f64>) {
        numbers.push(f64::from(self.element));
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretchDiagonal<D>) -> Self {
        Self { element: numbers[0] as u32 }
    }
}
