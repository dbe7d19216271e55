//! Points of a depth-resolved model from the columns of a flow, for a model downstream (sheet: depth-sph §3.2, 4).

use colluvium_case::{Case, CaseError, PointList, Snapshot};
use colluvium_constitutive::SymTensor;
use colluvium_points::{CellList, SearchError};

use crate::config::DepthOptions;
use crate::config::choices::Phases;
use crate::kernel::Kernel;
use crate::points::phase_nodes::norm;
use colluvium_case::CaseErrorKind;

/// Points of a depth-resolved model from the nodes of a flow: each node becomes a stack of points about as high as wide. Points have mass,
/// velocity and the isotropic stress of the weight above them. With columns of pore pressure they have pore pressure: means of `(1 - ζ)(a +
/// b ζ)` of the height `ζ` over the depth, whose base and mean are those of the column, and effective stresses. Of grains and fluid the
/// nodes are those of the grains: each node of the fluid gives its mass and momentum to the grains within its kernel.
///
/// # Errors
/// When the frame is not one of depth-integrated flow of one phase, or of grains and fluid.
pub fn point_stacks(
    case: &Case,
    options: &DepthOptions,
    snapshot: &Snapshot,
) -> Result<PointList, CaseError> {
    let wrong = |problem: &str| CaseError::new("methods.depth-sph.phases", problem);
    if options.phases == Phases::Layers {
        return Err(wrong(
            "`layers` cannot be exported as points of one material: only one phase, or grains and fluid, \
             can be exported",
        ));
    }
    let scalars = |name: &str| snapshot.scalars(name).ok_or_else(|| missing_field(name));
    let (depth, volume, mass) = (scalars("depth")?, scalars("volume")?, scalars("mass")?);
    let velocity = snapshot.vectors("velocity").ok_or_else(|| missing_field("velocity"))?;
    let stress = snapshot.tensors("stress").ok_or_else(|| missing_field("stress"))?;
    let columns = column_nodes(case, options, snapshot)?;
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
    for (i, fluid) in columns {
        let x = &snapshot.positions[i];
        let (whole, weighs) = (volume[i] + fluid.volume, mass[i] + fluid.mass);
        let moves = fluid.mean_velocity(mass[i], &velocity[i]);
        let width = (whole / depth[i]).powf(1.0 / up as f64);
        let count = (depth[i] / width).round().max(1.0);
        for k in 0..count as usize {
            let zeta = (k as f64 + 0.5) / count;
            let rest = 1.0 - zeta;
            let mut place = *x;
            place[up] += (zeta - 0.5) * depth[i];
            list.positions.push(place);
            list.volumes.push(whole / count);
            masses.push(weighs / count);
            velocities.push(moves);
            let mut bears = 2.0 * rest * stress[i].pressure();
            if let (Some([base, excess, mean]), Some(all)) = (pore, &mut list.pore_pressures) {
                let slope = 6.0 * mean[i] - 3.0 * excess[i];
                // Mean over the height of the point.
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

/// Error of a snapshot without a field of this name.
fn missing_field(name: &str) -> CaseError {
    CaseError::new("output.fields", format!("the frame has no field {name:?}"))
}

/// Nodes that become stacks of points: in two-phase flow the grains, with their shares of the fluid.
fn column_nodes(
    case: &Case,
    options: &DepthOptions,
    snapshot: &Snapshot,
) -> Result<Vec<(usize, FluidShare)>, CaseError> {
    // Material that has not entered yet, or has left through an open side, is not part of the flow.
    let outside = snapshot.scalars("outside");
    let is_inside = |node: &usize| outside.is_none_or(|outside| outside[*node] == 0.0);
    let all = (0..snapshot.positions.len()).filter(is_inside);
    if options.phases != Phases::Two {
        return Ok(all.map(|node| (node, FluidShare::default())).collect());
    }
    let scalars = |name: &str| snapshot.scalars(name).ok_or_else(|| missing_field(name));
    let phase = scalars("phase")?;
    let (grains, fluid): (Vec<usize>, Vec<usize>) = all.partition(|node| phase[*node] == 0.0);
    let pores = GrainsAndFluid {
        kernel: options.kernel,
        grains: &grains,
        fluid: &fluid,
        volumes: scalars("volume")?,
        heights: scalars("height")?,
        depths: scalars("depth")?,
        lengths: scalars("smoothing_length")?,
        masses: scalars("mass")?,
        velocities: snapshot.vectors("velocity").ok_or_else(|| missing_field("velocity"))?,
    };
    let shares = match case.dimension() {
        3 => pores.fluid_shares::<2>(snapshot),
        _ => pores.fluid_shares::<1>(snapshot),
    };
    let shares = shares.map_err(|problem| {
        CaseError::new("output.fields", CaseErrorKind::coded(problem.code(), problem.to_string()))
    })?;
    Ok(grains.into_iter().zip(shares).collect())
}

/// Pore fluid of a node of the grains.
#[derive(Clone, Copy, Default)]
struct FluidShare {
    /// Volume (m³; m² in a profile).
    volume: f64,
    /// Mass (kg).
    mass: f64,
    /// Momentum (kg m/s).
    momentum: [f64; 3],
}

impl FluidShare {
    /// Mean velocity of the fluid and grains (m/s), for a mass (kg) and velocity (m/s) of the grains.
    fn mean_velocity(&self, mass: f64, velocity: &[f64; 3]) -> [f64; 3] {
        if self.mass == 0.0 {
            return *velocity;
        }
        std::array::from_fn(|c| (mass * velocity[c] + self.momentum[c]) / (mass + self.mass))
    }
}

/// Number of Sinkhorn iterations that distribute the mass of the fluid nodes among the nodes of grains.
const SINKHORN_ITERATIONS: usize = 40;

/// Nodes of grains and of pore fluid in a snapshot.
struct GrainsAndFluid<'a> {
    kernel: Kernel,
    /// Indices of the grains, and of the fluid.
    grains: &'a [usize],
    fluid: &'a [usize],
    volumes: &'a [f64],
    heights: &'a [f64],
    depths: &'a [f64],
    lengths: &'a [f64],
    masses: &'a [f64],
    velocities: &'a [[f64; 3]],
}

impl GrainsAndFluid<'_> {
    /// Grains within the kernel of each node of the fluid, with their weights.
    fn nearby_grains<const D: usize>(
        &self,
        snapshot: &Snapshot,
    ) -> Result<Vec<Vec<(usize, f64)>>, SearchError> {
        let place = |node: &usize| -> [f64; D] { std::array::from_fn(|c| snapshot.positions[*node][c]) };
        let places: Vec<[f64; D]> = self.grains.iter().map(place).collect();
        let reach = |node: usize| self.kernel.support() * self.lengths[node];
        let longest = self.fluid.iter().map(|&node| reach(node)).fold(0.0, f64::max);
        if places.is_empty() || self.fluid.is_empty() {
            return Ok(vec![Vec::new(); self.fluid.len()]);
        }
        let mut cells = CellList::<D>::new();
        cells.build(&places, longest)?;
        let around = |node: &usize| {
            let (x, mut near) = (place(node), Vec::new());
            cells.visit_within(&x, reach(*node), |k| {
                let apart: [f64; D] = std::array::from_fn(|c| x[c] - places[k as usize][c]);
                let weight = self.kernel.value::<D>(norm(&apart), self.lengths[*node]);
                if weight > 0.0 {
                    near.push((k as usize, weight));
                }
            });
            near
        };
        Ok(self.fluid.iter().map(around).collect())
    }

    /// Shares of the fluid for each node of grains. Each fluid node distributes its mass among the grains within its kernel, by Sinkhorn's
    /// scaling of rows and columns towards the heights of both phases. Mass is conserved, and fluid without grains nearby keeps its node.
    fn fluid_shares<const D: usize>(&self, snapshot: &Snapshot) -> Result<Vec<FluidShare>, SearchError> {
        let near = self.nearby_grains::<D>(snapshot)?;
        let stands = |&node: &usize| self.volumes[node] * (self.depths[node] / self.heights[node] - 1.0);
        let mut wanted: Vec<f64> = self.grains.iter().map(stands).collect();
        let given = self.fluid.iter().zip(&near).filter(|(_, near)| !near.is_empty());
        let whole = given.map(|(node, _)| self.volumes[*node]).sum::<f64>() / wanted.iter().sum::<f64>();
        wanted.iter_mut().for_each(|wanted| *wanted *= whole);
        let mut scale: Vec<f64> = self.grains.iter().map(|node| self.volumes[*node]).collect();
        let sum = |scale: &[f64], near: &[(usize, f64)]| -> f64 {
            near.iter().map(|(k, weight)| scale[*k] * weight).sum()
        };
        for _ in 0..SINKHORN_ITERATIONS {
            let mut got = vec![0.0; scale.len()];
            for (node, near) in self.fluid.iter().zip(&near) {
                let all = sum(&scale, near);
                near.iter().for_each(|(k, weight)| got[*k] += self.volumes[*node] * scale[*k] * weight / all);
            }
            for ((scale, wanted), got) in scale.iter_mut().zip(&wanted).zip(got) {
                *scale *= if got > 0.0 && *wanted > 0.0 { wanted / got } else { 1.0 };
            }
        }
        let mut shares = vec![FluidShare::default(); self.grains.len()];
        for (&node, near) in self.fluid.iter().zip(&near) {
            let all = sum(&scale, near);
            for (k, weight) in near {
                let (part, own) = (scale[*k] * weight / all, &mut shares[*k]);
                own.volume += part * self.volumes[node];
                own.mass += part * self.masses[node];
                (0..3).for_each(|c| own.momentum[c] += part * self.masses[node] * self.velocities[node][c]);
            }
        }
        Ok(shares)
    }
}
