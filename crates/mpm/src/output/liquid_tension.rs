//! Liquids in tension.

use colluvium_case::spatial;

use crate::points::point_set::PointSet;
use crate::points::vectors::square;
use crate::setup::fall_time::body_height;
use crate::solver::MpmSolver;
use colluvium_case::Warning;

/// Mass fraction of a liquid in tension above which a warning is given.
const NOTABLE: f64 = 0.01;

impl<const D: usize> MpmSolver<D> {
    /// Warning for a liquid in which a notable part is under more tension than its weight and motion can cause. With a high
    /// `cavitation_strength` it does not separate where a real liquid does. Without gravity there is no reference value and no warning.
    pub(crate) fn tension_warning(&self) -> Option<Warning> {
        self.bodies.sets.iter().find_map(|set| self.tension_in_set(set))
    }

    /// Warning if points of a liquid body are under more tension than its weight and motion explain.
    fn tension_in_set(&self, set: &PointSet<D>) -> Option<Warning> {
        let body = &self.clock.case.bodies[set.body as usize];
        let spec = &self.clock.case.materials[&body.material];
        let gravity = square(&self.clock.gravity).sqrt();
        if !spec.is_fluid() || set.rigid.is_some() || gravity == 0.0 {
            return None;
        }
        let height = body_height(&self.clock.case, body);
        let speed = set.points.velocity.iter().map(square).fold(0.0, f64::max);
        let allowed = spec.density() * (gravity * height + 0.5 * speed);
        let tension = |i: usize| -set.points.stress[i].pressure();
        let mass = |i: usize| set.points.mass[i];
        let tense: f64 = (0..set.len()).filter(|&i| tension(i) > allowed).map(mass).sum();
        let share = tense / set.points.mass.iter().sum::<f64>();
        if !(share > NOTABLE) {
            return None;
        }
        let worst = (0..set.len()).max_by(|&a, &b| tension(a).total_cmp(&tension(b)))?;
        Some(Warning::new(
            "liquid-in-tension",
            format!(
                "t = {} s: {:.0} % of the liquid {:?} are in tension of more than {allowed:.3e} Pa, the pressure \
             of its weight and motion. The tension is largest at point {} at {:?} m, with {:.3e} Pa. A real \
             liquid opens there: lower materials.{}.cavitation_strength, or give the liquid an initial \
             pressure",
                self.clock.time,
                100.0 * share,
                body.name,
                set.points.id[worst],
                spatial(&set.points.position[worst]),
                tension(worst),
                body.material
            ),
        ))
    }
}
