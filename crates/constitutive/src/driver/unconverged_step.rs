//! Element test of a step whose stress update did not converge.

use crate::UnconvergedStep;
use crate::driver::{ElementTest, LoadingPath, TestStage};
use crate::laws::spec::MaterialSpec;

impl UnconvergedStep {
    /// Element test of `material` that consists of this step, for an examination outside the simulation. Internal variables are those of a
    /// point that starts with this stress.
    pub fn element_test(&self, material: MaterialSpec) -> ElementTest {
        let velocity_gradient = (self.gradient * (1.0 / self.dt)).0;
        ElementTest {
            title: self.to_string(),
            material,
            initial_stress: self.stress.0,
            stages: vec![TestStage {
                path: LoadingPath::Flow { velocity_gradient },
                steps: 1,
                duration: self.dt,
            }],
        }
    }
}
