//! Grains of bodies: filling, ids, initial velocities.

use std::collections::HashSet;

use colluvium_case::description::Body;
use colluvium_case::{Case, CaseError, PlacedObstacle, PointList, spatial};
use colluvium_points::Shape;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::config::{BodyGrains, DemOptions, Diameters, Fill, GrainKind, LatticePacking};
use crate::points::grains::{Grains, volume};
use crate::setup::sleeve_rings::rings;
use crate::specimen::file::StoredSpecimen;
use crate::specimen::pluviation::contains_ball;
use crate::specimen::undercompaction::{UndercompactedLayers, pack_layers};
use crate::specimen::{Container, RoundWall, pack};
use crate::specimen::{drop_and_roll_2d, drop_and_roll_3d};
use colluvium_case::CaseErrorKind;

/// Largest number of grains, limited by the integer type.
const MAX_GRAINS: usize = u32::MAX as usize / 2;

/// Overlap with an obstacle over the radius, up to which a grain is regarded as in contact only.
const OVERLAP_TOLERANCE: f64 = 1e-6;

/// Position (m) and radius (m) of a placed grain.
type PlacedGrain<const D: usize> = ([f64; D], f64);

/// Whether a grain with its centre outside an obstacle overlaps it; centres inside are checked elsewhere.
fn overlaps_obstacle<const D: usize>(
    obstacles: &[PlacedObstacle<'_, D>],
    (x, radius): &PlacedGrain<D>,
) -> bool {
    obstacles.iter().any(|PlacedObstacle { surface, .. }| {
        surface
            .gap(x, *radius)
            .is_some_and(|gap| gap.distance > 0.0 && gap.distance < radius * (1.0 - OVERLAP_TOLERANCE))
    })
}

/// Fills all bodies; grains that the case does not list must not overlap obstacles.
pub(super) fn fill<const D: usize, const R: usize>(
    case: &Case,
    options: &DemOptions,
    stored: Option<&StoredSpecimen>,
    obstacles: &[PlacedObstacle<'_, D>],
    grains: &mut Grains<D, R>,
) -> Result<(), CaseError> {
    stored.map_or(Ok(()), |stored| stored.fill(case, options, grains))?;
    let count = grains.len();
    let listed = (0..case.bodies.len()).map(|body| case.point_list(body)).collect::<Result<Vec<_>, _>>()?;
    let mut ids = Vec::new();
    let given = stored.map(StoredSpecimen::counts).unwrap_or_default();
    for (number, body) in case.bodies.iter().enumerate() {
        let path = format!("bodies[{number}]");
        let enters_later = options.bodies.get(&body.name).is_some_and(|own| own.pluviation.is_some());
        if enters_later || given.contains_key(body.name.as_str()) {
            continue;
        }
        let kind = &options.grains[&body.material];
        let index = options.grains.keys().position(|name| *name == body.material).unwrap_or(0) as u32;
        let mut random = ChaCha8Rng::seed_from_u64(options.seed.wrapping_add(number as u64));
        let placed = match &listed[number] {
            Some(list) => listed_grains(list),
            None => {
                let mut placed = place_grains::<D>(case, options, (body, &path), kind, &mut random)?;
                if !matches!(options.fill_of_body(body), Some(Fill::Single)) {
                    placed.retain(|grain| !overlaps_obstacle(obstacles, grain));
                }
                placed
            }
        };
        if placed.is_empty() {
            let problem = "has no grain: it is smaller than the grains, or than the pitch of their lattice";
            return Err(CaseError::new(format!("{path}.shape"), CaseErrorKind::coded("empty-body", problem)));
        }
        if grains.len() + placed.len() > MAX_GRAINS {
            return Err(CaseError::new(format!("{path}.shape"), format!("more than {MAX_GRAINS} grains")));
        }
        let start = grains.len();
        for (position, radius) in &placed {
            grains.push(number as u32, index, *position, *radius, kind.density);
        }
        let own = options.bodies.get(&body.name).cloned().unwrap_or_default();
        initialise_motion(number, body, &own, start, listed[number].as_ref(), grains)?;
        if let Some(list) = &listed[number] {
            kinds_as_listed(list, options, &path, start, grains)?;
        }
        ids.extend(ids_as_listed(listed[number].as_ref(), placed.len()));
    }
    assign_ids(&ids, count, grains)?;
    if options.orientation {
        grains.orientation.resize(grains.len(), initial_orientation::<D>());
    }
    Ok(())
}

/// Id of the next grain.
pub(super) fn next_id<const D: usize, const R: usize>(grains: &Grains<D, R>) -> u32 {
    grains.id.iter().max().map_or(0, |last| last + 1)
}

/// Radius of a grain (m) from its area (m²) or volume (m³).
fn radius_of<const D: usize>(amount: f64) -> f64 {
    let unit = amount / volume(D, 1.0);
    if D == 2 { unit.sqrt() } else { unit.cbrt() }
}

/// Grains that a program adds to body number `number`, with numbers from 0 on.
///
/// # Errors
/// An unknown kind of grains, and columns that the body excludes.
pub(super) fn added_grains<const D: usize, const R: usize>(
    case: &Case,
    options: &DemOptions,
    number: usize,
    list: &PointList,
) -> Result<Grains<D, R>, CaseError> {
    let (body, mut grains) = (&case.bodies[number], Grains::default());
    let kind = &options.grains[&body.material];
    let index = options.grains.keys().position(|name| *name == body.material).unwrap_or(0) as u32;
    for (position, radius) in listed_grains(list) {
        grains.push(number as u32, index, position, radius, kind.density);
    }
    let own = options.bodies.get(&body.name).cloned().unwrap_or_default();
    initialise_motion(number, body, &own, 0, Some(list), &mut grains)?;
    kinds_as_listed(list, options, &format!("bodies[{number}]"), 0, &mut grains)?;
    if options.orientation {
        grains.orientation.resize(grains.len(), initial_orientation::<D>());
    }
    Ok(grains)
}

/// Orientation of a grain at the start: an angle, or a quaternion.
fn initial_orientation<const D: usize>() -> [f64; 4] {
    if D == 2 { [0.0; 4] } else { [1.0, 0.0, 0.0, 0.0] }
}

/// Grains of a point list; a point without a radius has that of its volume.
fn listed_grains<const D: usize>(list: &PointList) -> Vec<PlacedGrain<D>> {
    let radius =
        |i: usize, volume: f64| list.grains.radii.as_ref().map_or(radius_of::<D>(volume), |all| all[i]);
    let samples = list.samples::<D>().into_iter().enumerate();
    samples.map(|(i, sample)| (sample.position, radius(i, sample.volume))).collect()
}

/// Sets kinds and masses of listed grains, from index `start` on. Masses that are not listed are computed.
fn kinds_as_listed<const D: usize, const R: usize>(
    list: &PointList,
    options: &DemOptions,
    path: &str,
    start: usize,
    grains: &mut Grains<D, R>,
) -> Result<(), CaseError> {
    for (i, name) in (start..).zip(list.grains.grain_types.iter().flatten()) {
        let found = options.grains.iter().enumerate().find(|(_, (known, _))| *known == name);
        let Some((index, (_, kind))) = found else {
            let known = options.grains.keys().cloned().collect::<Vec<_>>().join(", ");
            let problem = format!("the kind {name:?} is not one of methods.dem.grains, which are {known}");
            return Err(CaseError::new(format!("{path}.points.file"), problem));
        };
        grains.kind[i] = index as u32;
        grains.mass[i] = kind.density * volume(D, grains.radius[i]);
    }
    for (i, mass) in (start..).zip(list.masses.iter().flatten()) {
        grains.mass[i] = *mass;
    }
    Ok(())
}

/// Ids of the grains in a point list; `None` for grains without an id.
fn ids_as_listed(list: Option<&PointList>, count: usize) -> Vec<Option<u32>> {
    let ids = list.and_then(|list| list.grains.ids.as_ref());
    ids.map_or_else(|| vec![None; count], |ids| ids.iter().copied().map(Some).collect())
}

/// Assigns ids to the grains from index `first` on: the listed ones, and consecutive numbers for the others.
fn assign_ids<const D: usize, const R: usize>(
    ids: &[Option<u32>],
    first: usize,
    grains: &mut Grains<D, R>,
) -> Result<(), CaseError> {
    let mut taken: HashSet<u32> = grains.id[..first].iter().copied().collect();
    for id in ids.iter().flatten() {
        if !taken.insert(*id) {
            return Err(CaseError::new(
                "bodies",
                CaseErrorKind::coded("duplicate-name", format!("two grains have the number {id}")),
            ));
        }
    }
    let mut next = taken.iter().max().map_or(0, |last| last + 1);
    for (own, id) in grains.id[first..].iter_mut().zip(ids) {
        *own = id.unwrap_or(next);
        next += u32::from(id.is_none());
    }
    Ok(())
}

/// Sets initial velocities and spins, and the grains with prescribed motion.
fn initialise_motion<const D: usize, const R: usize>(
    number: usize,
    body: &Body,
    own: &BodyGrains,
    start: usize,
    list: Option<&PointList>,
    grains: &mut Grains<D, R>,
) -> Result<(), CaseError> {
    if list.is_some_and(|list| list.pore_pressures.is_some()) {
        let problem = "the points have pore pressures, but dem has no pore fluid: leave the column out";
        return Err(CaseError::new(
            format!("bodies[{number}].points.file"),
            CaseErrorKind::coded("conflicting-keys", problem),
        ));
    }
    let of_grains = list.map(|list| &list.grains);
    let velocities = list.and_then(|list| list.velocities.as_ref());
    let (spins, held) = (
        of_grains.and_then(|grains| grains.spins.as_ref()),
        of_grains.and_then(|grains| grains.is_held.as_ref()),
    );
    if spins.is_some() && !own.spin.is_empty() {
        let problem = format!(
            "the points have spins, and methods.dem.bodies.{} has `spin` too: leave one of them out",
            body.name
        );
        return Err(CaseError::new(
            format!("bodies[{number}].points.file"),
            CaseErrorKind::coded("conflicting-keys", problem),
        ));
    }
    for i in start..grains.len() {
        let velocity = match velocities {
            Some(velocities) => velocities[i - start],
            None => body.velocity.velocity_at(spatial(&grains.position[i])),
        };
        grains.velocity[i] = std::array::from_fn(|c| velocity[c]);
        grains.is_held[i] = own.held || body.rigid || held.is_some_and(|held| held[i - start]);
        for (c, spin) in own.spin.iter().enumerate().take(R) {
            grains.spin[i][c] = *spin;
        }
        if let Some(spins) = spins {
            // In the plane grains turn about z.
            grains.spin[i] = std::array::from_fn(|c| spins[i - start][3 - R + c]);
        }
    }
    if body.rigid && own.held {
        let path = format!("methods.dem.bodies.{}.held", body.name);
        return Err(CaseError::new(
            path,
            CaseErrorKind::coded(
                "conflicting-keys",
                "motions prescribe the velocity of a rigid body: leave held out",
            ),
        ));
    }
    Ok(())
}

/// Places the grains of a body by the filling that the case selects.
fn place_grains<const D: usize>(
    case: &Case,
    options: &DemOptions,
    (body, path): (&Body, &str),
    kind: &GrainKind,
    random: &mut ChaCha8Rng,
) -> Result<Vec<PlacedGrain<D>>, CaseError> {
    let Some(fill) = options.fill_of_body(body) else {
        let problem = format!("is missing: it defines how grains fill the body {:?}", body.name);
        return Err(CaseError::new(
            format!("methods.dem.grains.{}.fill", body.material),
            CaseErrorKind::coded("needs-other-key", problem),
        ));
    };
    if let Fill::Single = fill {
        let Shape::Ball { centre, radius } = &body.shape else {
            return Err(CaseError::new(format!("{path}.shape"), "a single grain must be a ball"));
        };
        return Ok(vec![(std::array::from_fn(|c| centre[c]), *radius)]);
    }
    let Some(sizes) = &kind.diameter else {
        let path = format!("methods.dem.grains.{}.diameter", body.material);
        return Err(CaseError::new(
            path,
            CaseErrorKind::coded(
                "needs-other-key",
                format!("is missing: the body {:?} is filled with grains", body.name),
            ),
        ));
    };
    let placed = match fill {
        Fill::Lattice { packing, pitch, jitter } => {
            let pitch = pitch.unwrap_or(sizes.range().1);
            lattice(&body.shape, sizes, (packing, pitch, jitter), random)
        }
        Fill::Random { solid_fraction } => {
            let round = round_wall(&body.shape);
            pack_to_solid_fraction(case, (body, round), sizes, solid_fraction, random, pack)
        }
        Fill::Layers { solid_fraction, layers, first_solid_fraction } => {
            let layers =
                UndercompactedLayers { count: layers, first: first_solid_fraction, last: solid_fraction };
            // A lid moves down along the last axis: the sections that it passes must be equal.
            let round = round_wall(&body.shape).filter(|round| round.axis == Some(D - 1));
            pack_to_solid_fraction(
                case,
                (body, round),
                sizes,
                solid_fraction,
                random,
                |container, radii, random| pack_layers(container, radii, layers, random),
            )
        }
        Fill::DropAndRoll => dropped_grains(case, body, sizes, random),
        Fill::Sleeve { columns } => rings(&body.shape, sizes, columns),
        Fill::Single => Ok(Vec::new()),
    };
    placed.map_err(|problem| CaseError::new(format!("{path}.shape"), problem))
}

/// Sites of a lattice whose first site is half a pitch from the lower corner (m).
fn sites<const D: usize>(
    low: &[f64],
    high: &[f64],
    packing: LatticePacking,
    pitch: f64,
) -> Result<Vec<[f64; D]>, String> {
    let (root3, root2) = (3f64.sqrt(), 2f64.sqrt());
    // Spacings of rows along the axes, and shifts of odd rows and layers.
    let steps: [f64; 3] = match (packing, D) {
        (LatticePacking::Hexagonal, 2) => [pitch, 0.5 * root3 * pitch, 1.0],
        (LatticePacking::Hexagonal, _) => [pitch, 0.5 * root3 * pitch, root2 / root3 * pitch],
        (LatticePacking::BodyCentred, 3) => [2.0 / root3 * pitch, 2.0 / root3 * pitch, 1.0 / root3 * pitch],
        (LatticePacking::FaceCentred, 3) => [root2 * pitch, pitch / root2, pitch / root2],
        (LatticePacking::Square, _) => [pitch; 3],
        _ => return Err("this lattice is for 3d only: use square or hexagonal in the plane".to_owned()),
    };
    let counts: Vec<usize> = (0..D)
        .map(|c| (((high[c] - low[c] - pitch) / steps[c] + 1e-9).floor() + 1.0).max(0.0) as usize)
        .collect();
    let total = counts.iter().map(|count| *count as f64).product::<f64>();
    if total > MAX_GRAINS as f64 {
        return Err(format!("its lattice would have {total:.1e} grains"));
    }
    let mut all = Vec::with_capacity(total as usize);
    for number in 0..total as usize {
        let mut rest = number;
        // The first axis runs fastest.
        let index: [usize; D] = std::array::from_fn(|c| {
            let own = rest % counts[c];
            rest /= counts[c];
            own
        });
        let mut x: [f64; D] = std::array::from_fn(|c| low[c] + 0.5 * pitch + steps[c] * index[c] as f64);
        match packing {
            LatticePacking::Square => {}
            LatticePacking::Hexagonal => {
                let layer = if D == 3 { index[2] % 3 } else { 0 };
                x[0] += 0.5 * pitch * (((index[1] + layer) % 2) as f64);
                x[1] += pitch * root3 / 6.0 * layer as f64;
            }
            LatticePacking::BodyCentred => {
                let odd = (index[D - 1] % 2) as f64;
                x[0] += 0.5 * steps[0] * odd;
                x[1] += 0.5 * steps[1] * odd;
            }
            LatticePacking::FaceCentred => x[0] += 0.5 * steps[0] * (((index[1] + index[D - 1]) % 2) as f64),
        }
        all.push(x);
    }
    Ok(all)
}

/// Grains on the sites of a lattice inside a shape, with random deviations up to `jitter` times the pitch (m).
fn lattice<const D: usize>(
    shape: &Shape,
    sizes: &Diameters,
    (packing, pitch, jitter): (LatticePacking, f64, f64),
    random: &mut ChaCha8Rng,
) -> Result<Vec<PlacedGrain<D>>, String> {
    let (low, high) = shape.bounds(D);
    let mut all = sites::<D>(&low, &high, packing, pitch)?;
    for x in &mut all {
        for c in x.iter_mut() {
            *c += jitter * pitch * (2.0 * random.random::<f64>() - 1.0);
        }
    }
    let diameters = sizes.sample(all.len(), D, random)?;
    let placed = all.into_iter().zip(diameters.into_iter().map(|d| 0.5 * d));
    // Half a pitch contains a grain, less the share that jitter lets protrude.
    let slack = jitter * pitch;
    Ok(placed.filter(|(x, radius)| contains_ball(shape, x, (radius - slack).max(0.0))).collect())
}

/// Container around a body, with the periodic axes of the domain that the body spans.
fn container<const D: usize>(case: &Case, body: &Body) -> Container<D> {
    let (low, high) = body.shape.bounds(D);
    let periodic: [bool; D] = std::array::from_fn(|axis| {
        let (from, to) = (case.domain.min[axis], case.domain.max[axis]);
        case.domain.is_periodic(axis)
            && low[axis] <= from + 1e-9 * (to - from)
            && high[axis] >= to - 1e-9 * (to - from)
    });
    let [low, high] = [low, high].map(|corner| std::array::from_fn(|c| corner[c]));
    Container { low, high, periodic, round_wall: None }
}

/// Round wall of a ball or cylinder; `None` for other shapes.
fn round_wall<const D: usize>(shape: &Shape) -> Option<RoundWall<D>> {
    let (axis, centre, radius) = match shape {
        Shape::Ball { centre, radius } => (None, &centre[..], *radius),
        Shape::Cylinder { base, axis, radius, .. } => (Some(*axis), &base[..], *radius),
        _ => return None,
    };
    Some(RoundWall { axis, centre: std::array::from_fn(|c| centre[c]), radius })
}

/// Packs grains to a solid fraction with the algorithm `pack`. The container is the round wall of a body, if it has one. Otherwise it is
/// the bounding box of the body, and grains outside the shape are removed.
fn pack_to_solid_fraction<const D: usize>(
    case: &Case,
    (body, round): (&Body, Option<RoundWall<D>>),
    sizes: &Diameters,
    solid_fraction: f64,
    random: &mut ChaCha8Rng,
    pack: impl Fn(&Container<D>, &[f64], &mut ChaCha8Rng) -> Result<Vec<[f64; D]>, String>,
) -> Result<Vec<PlacedGrain<D>>, String> {
    let mut container: Container<D> = container(case, body);
    container.round_wall = round;
    let space = container.volume();
    let mean = sizes.mean_power(D, D as i32) * volume(D, 0.5);
    let count = (solid_fraction * space / mean).round().max(1.0);
    if count > MAX_GRAINS as f64 {
        return Err(format!("it would have {count:.1e} grains"));
    }
    let mut radii: Vec<f64> = sizes.sample(count as usize, D, random)?.iter().map(|d| 0.5 * d).collect();
    // Exactly that fraction, with all sizes scaled slightly.
    let filled: f64 = radii.iter().map(|r| volume(D, *r)).sum();
    let factor = (solid_fraction * space / filled).powf(1.0 / D as f64);
    radii.iter_mut().for_each(|r| *r *= factor);
    let placed = pack(&container, &radii, random)?.into_iter().zip(radii);
    Ok(if round.is_some() { placed.collect() } else { cut_to_shape(body, placed) })
}

/// Grains whose centres are in the shape of a body.
fn cut_to_shape<const D: usize>(
    body: &Body,
    placed: impl Iterator<Item = PlacedGrain<D>>,
) -> Vec<PlacedGrain<D>> {
    let whole = matches!(body.shape, Shape::Box { .. });
    placed.filter(|(x, radius)| whole || contains_ball(&body.shape, x, *radius)).collect()
}

/// Grains deposited by drop and roll in the box around the body, cut to its shape.
fn dropped_grains<const D: usize>(
    case: &Case,
    body: &Body,
    sizes: &Diameters,
    random: &mut ChaCha8Rng,
) -> Result<Vec<PlacedGrain<D>>, String> {
    let largest = 0.5 * sizes.range().1;
    let draw = |random: &mut ChaCha8Rng| 0.5 * sizes.draw(D, random);
    if D == 2 {
        let placed =
            drop_and_roll_2d::drop_and_roll(&container(case, body), largest, MAX_GRAINS, random, draw)?;
        return Ok(cut_to_shape(body, placed.into_iter().map(to_dimension)));
    }
    let placed = drop_and_roll_3d::drop_and_roll(&container(case, body), largest, MAX_GRAINS, random, draw)?;
    Ok(cut_to_shape(body, placed.into_iter().map(to_dimension)))
}

/// Position in `D` coordinates, which must equal `N`.
fn to_dimension<const N: usize, const D: usize>((x, radius): ([f64; N], f64)) -> PlacedGrain<D> {
    (std::array::from_fn(|c| x[c]), radius)
}
