//! Points of a model in depth from the columns of a flow: what it hands over downstream (sheet: depth-sph §3.2, 4).

use colluvium_case::{Case, CaseError, PointList, Snapshot};
use colluvium_constitutive::SymTensor;

use crate::choices::Phases;
use crate::setup;

/// Points of a model in depth from the nodes of a frame: each column a stack of points about as high as they are wide, with their
/// mass, their velocity, and the stress of the weight above them, taken isotropic. With columns of pore pressure they have it: means of
/// `(1 - ζ)(a + b ζ)` of the height `ζ` over the depth, whose base and mean are those of the column, and effective stresses. Of grains and fluid these are the
/// nodes of the grains with the fluid around them.
///
/// # Errors
/// When the frame is not one of depth-integrated flow of one phase, or of grains and fluid.
pub fn stacks(case: &Case, snapshot: &Snapshot) -> Result<PointList, CaseError> {
    let options = setup::options(case)?;
    let wrong = |problem: &str| CaseError::new("methods.depth-sph.phases", problem);
    if options.phases == Phases::Layers {
        return Err(wrong(
            "two layers are no material of a model in depth: points of them are not handed over",
        ));
    }
    let lacks = |name: &str| CaseError::new("output.fields", format!("the frame has no {name:?}"));
    let scalars = |name: &str| snapshot.scalars(name).ok_or_else(|| lacks(name));
    let (depth, volume, mass) = (scalars("depth")?, scalars("volume")?, scalars("mass")?);
    let velocity = snapshot.vectors("velocity").ok_or_else(|| lacks("velocity"))?;
    let stress = snapshot.tensors("stress").ok_or_else(|| lacks("stress"))?;
    let phases =
        if options.phases == Phases::Two { Some((scalars("phase")?, scalars("height")?)) } else { None };
    let pore = match options.column {
        Some(_) => Some([
            scalars("pore_pressure")?,
            scalars("excess_pore_pressure")?,
            scalars("mean_excess_pore_pressure")?,
        ]),
        None => None,
    };
    let up = case.dimension() - 1;
    let mut list = PointList { pore_pressures: pore.map(|_| Vec::new()), ..PointList::default() };
    let (mut masses, mut velocities, mut stresses) = (Vec::new(), Vec::new(), Vec::new());
    for (i, x) in snapshot.positions.iter().enumerate() {
        let share = match phases {
            Some((phase, _)) if phase[i] != 0.0 => continue,
            Some((_, height)) => height[i] / depth[i],
            None => 1.0,
        };
        let whole = volume[i] / share;
        let fluid =
            options.mixture.as_ref().map_or(0.0, |mixture| mixture.fluid_density * (whole - volume[i]));
        let width = (whole / depth[i]).powf(1.0 / up as f64);
        let count = (depth[i] / width).round().max(1.0);
        for k in 0..count as usize {
            let zeta = (k as f64 + 0.5) / count;
            let rest = 1.0 - zeta;
            let mut place = *x;
            place[up] += (zeta - 0.5) * depth[i];
            list.positions.push(place);
            list.volumes.push(whole / count);
            masses.push((mass[i] + fluid) / count);
            velocities.push(velocity[i]);
            let mut bears = 2.0 * rest * stress[i].pressure();
            if let (Some([base, excess, mean]), Some(all)) = (pore, &mut list.pore_pressures) {
                let slope = 6.0 * mean[i] - 3.0 * excess[i];
                // The mean over the height of the point.
                let own = rest * (base[i] + slope * zeta) - slope / (12.0 * count * count);
                all.push(own);
                bears -= own;
            }
            stresses.push(SymTensor::isotropic(-bears));
        }
    }
    (list.masses, list.velocities, list.stresses) = (Some(masses), Some(velocities), Some(stresses));
    Ok(list)
}
