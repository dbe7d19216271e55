//! Contact laws of a stage, from the pairs of a case.

use std::f64::consts::PI;

use colluvium_case::description::{ObstacleWall, Wall as WallKind};
use colluvium_case::{Case, CaseError};

use crate::config::{
    Adhesion, ContactVelocity, DemOptions, NormalLaw, PairOverride, PairSpec, RollingSpec, TangentialSpec,
};
use crate::contact::bond::Beam;
use crate::contact::capillary::Capillary;
use crate::contact::cohesion::Cohesion;
use crate::contact::contact_laws::{GrainSizes, KindProperties, StageLaws};
use crate::contact::coulomb_friction::{Coulomb, ROUGH_FRICTION};
use crate::contact::hertz::Hertz;
use crate::contact::jkr::Jkr;
use crate::contact::linear_spring::LinearSpring;
use crate::contact::restitution::{damping_ratio_with_tension, damping_ratio_without_tension};
use crate::contact::rolling_resistance::RollingResistance;
use crate::contact::{AttractionLaw, NormalForceLaw, PairLaw};
use crate::specimen::pluviation::{GrainSource, sources};

/// Largest time step as a fraction of the stable step of a single undamped contact (sheet: dem §3.5).
const MAX_STEP_FRACTION: f64 = 0.2;

/// Damping ratio that is given or follows from a coefficient of restitution; zero if neither is given.
fn damping(restitution: Option<f64>, ratio: Option<f64>, clamp: bool) -> f64 {
    match (restitution, ratio) {
        (Some(e), _) if e >= 1.0 => 0.0,
        (Some(e), _) if clamp => damping_ratio_without_tension(e),
        (Some(e), _) => damping_ratio_with_tension(e),
        (None, ratio) => ratio.unwrap_or(0.0),
    }
}

/// Rolling or torsion resistance of its options.
fn resistance(spec: &RollingSpec) -> RollingResistance {
    RollingResistance {
        friction: spec.friction,
        stiffness: spec.stiffness_ratio,
        damping_ratio: spec.damping_ratio,
    }
}

/// Normal law of its options, and whether the force is never attractive (sheet: dem §3.11).
fn normal(law: &NormalLaw, tangential: &TangentialSpec) -> (NormalForceLaw, bool) {
    match law {
        NormalLaw::Linear { stiffness, grain_modulus, restitution, damping_ratio, clamp } => {
            // Sheet: dem §3.11.
            let across = tangential.stiffness_ratio.unwrap_or(0.5);
            let linear = LinearSpring {
                stiffness: stiffness.unwrap_or(0.0),
                modulus: 2.0 * grain_modulus.unwrap_or(0.0),
                damping_ratio: damping(*restitution, *damping_ratio, *clamp),
                tangential_ratio: across,
                tangential_damping_ratio: tangential.damping_ratio.unwrap_or(0.0),
                tangential_ratio_root: across.sqrt(),
            };
            (NormalForceLaw::Linear(linear), *clamp)
        }
        NormalLaw::Hertz {
            youngs_modulus,
            poissons_ratio,
            other_youngs_modulus,
            other_poissons_ratio,
            restitution,
            damping_ratio,
            clamp,
        } => {
            let youngs = [*youngs_modulus, other_youngs_modulus.unwrap_or(*youngs_modulus)];
            let poisson = [*poissons_ratio, other_poissons_ratio.unwrap_or(*poissons_ratio)];
            let ratio = damping(*restitution, *damping_ratio, *clamp);
            // Tangential damping equals normal damping (sheet: dem §2.8) where the case gives none.
            let hertz = Hertz::new(youngs, poisson, ratio, tangential.damping_ratio.unwrap_or(ratio));
            let ratio = tangential.stiffness_ratio;
            (NormalForceLaw::Hertz(ratio.map_or(hertz, |ratio| hertz.with_stiffness_ratio(ratio))), *clamp)
        }
    }
}

/// Attraction law of a pair, for grains with radii up to `largest` (m).
fn attraction(adhesion: &Adhesion, normal: &NormalForceLaw, largest: f64, dimension: usize) -> AttractionLaw {
    match *adhesion {
        Adhesion::Cohesive { tension, shear, fragile: is_fragile, new_contacts } => {
            let stiffness = match normal {
                NormalForceLaw::Linear(linear) => linear.stiffness(0.5 * largest),
                NormalForceLaw::Hertz(_) => f64::INFINITY,
            };
            let rupture_distance = 2.0 * tension * largest.powi(dimension as i32 - 1) / stiffness;
            AttractionLaw::Cohesion(Cohesion { tension, shear, is_fragile, new_contacts, rupture_distance })
        }
        Adhesion::Jkr { work_of_adhesion } => {
            let modulus = match normal {
                NormalForceLaw::Hertz(hertz) => hertz.modulus,
                NormalForceLaw::Linear(_) => f64::NAN,
            };
            AttractionLaw::Jkr(Jkr { work: work_of_adhesion, modulus })
        }
        Adhesion::Capillary { surface_tension, contact_angle, volume_ratio } => {
            let angle = contact_angle.to_radians();
            AttractionLaw::Capillary(Capillary {
                tension: surface_tension * angle.cos(),
                rupture: 1.0 + 0.5 * angle,
                volume: volume_ratio,
            })
        }
    }
}

/// Contact law of a pair, for grains of radius up to `largest` (m).
fn law(pair: &PairSpec, velocity: ContactVelocity, largest: f64, dimension: usize) -> PairLaw {
    let (normal, clamp) = normal(&pair.normal, &pair.tangential);
    let friction =
        pair.friction.map_or(Coulomb { coefficient: 0.0, at_rest: 0.0, reset: pair.tangential.reset }, |f| {
            Coulomb {
                coefficient: f.coefficient,
                at_rest: f.at_rest.unwrap_or(f.coefficient),
                reset: pair.tangential.reset,
            }
        });
    let attraction = pair.adhesion.as_ref().map(|own| attraction(own, &normal, largest, dimension));
    let bond = pair.bond.as_ref().map(|bond| Beam {
        normal: bond.normal_stiffness,
        shear: bond.shear_stiffness,
        radius: bond.radius_factor,
        moments: bond.moment_factor,
        tensile_strength: bond.tensile_strength.unwrap_or(f64::INFINITY),
        cohesion: bond.cohesion.unwrap_or(f64::INFINITY),
        friction: bond.friction_angle.to_radians().tan(),
        scatter: bond.scatter,
        gap: bond.gap,
    });
    PairLaw {
        normal,
        no_tension: clamp,
        velocity_lag: if velocity == ContactVelocity::Lagged { 1.0 } else { 0.0 },
        friction,
        rolling: pair.rolling.as_ref().map(resistance),
        torsion: pair.twisting.as_ref().map(resistance),
        attraction,
        bond,
    }
}

/// Whether a pair of names is `a` and `b`, in either order.
fn is_between(pair: &[String; 2], a: &str, b: &str) -> bool {
    (pair[0] == a && pair[1] == b) || (pair[0] == b && pair[1] == a)
}

/// Returns a pair with the overrides of a stage.
fn with_overrides(pair: &PairSpec, overrides: &[PairOverride]) -> PairSpec {
    let mut pair = pair.clone();
    let own =
        overrides.iter().filter(|change| is_between(&change.between, &pair.between[0], &pair.between[1]));
    for change in own.cloned().collect::<Vec<_>>() {
        pair.normal = change.normal.unwrap_or(pair.normal);
        pair.tangential = change.tangential.unwrap_or(pair.tangential);
        pair.friction = change.friction.or(pair.friction);
        pair.rolling = change.rolling.or(pair.rolling);
    }
    pair
}

/// Contact law of two different kinds, as a mean of the laws of each kind (sheet: dem §0).
fn mixed_law(a: &PairLaw, b: &PairLaw) -> Option<PairLaw> {
    let harmonic = |x: f64, y: f64| if x + y > 0.0 { 2.0 * x * y / (x + y) } else { 0.0 };
    let root = |x: f64, y: f64| (x * y).sqrt();
    let normal = match (&a.normal, &b.normal) {
        (NormalForceLaw::Linear(a), NormalForceLaw::Linear(b)) if (a.modulus > 0.0) == (b.modulus > 0.0) => {
            NormalForceLaw::Linear(LinearSpring {
                stiffness: harmonic(a.stiffness, b.stiffness),
                modulus: harmonic(a.modulus, b.modulus),
                damping_ratio: root(a.damping_ratio, b.damping_ratio),
                tangential_ratio: 0.5 * (a.tangential_ratio + b.tangential_ratio),
                tangential_damping_ratio: root(a.tangential_damping_ratio, b.tangential_damping_ratio),
                tangential_ratio_root: (0.5 * (a.tangential_ratio + b.tangential_ratio)).sqrt(),
            })
        }
        (NormalForceLaw::Hertz(a), NormalForceLaw::Hertz(b)) => {
            let modulus = harmonic(a.modulus, b.modulus);
            let shear_modulus = harmonic(a.shear_modulus, b.shear_modulus);
            let grain_shear_modulus = harmonic(a.grain_shear_modulus, b.grain_shear_modulus);
            NormalForceLaw::Hertz(Hertz {
                modulus,
                shear_modulus,
                grain_shear_modulus,
                damping: root(a.damping, b.damping),
                tangential_damping: root(a.tangential_damping, b.tangential_damping),
                tangential_stiffness_root: (4.0 * shear_modulus / modulus).sqrt(),
            })
        }
        _ => return None,
    };
    let smaller = if a.friction.coefficient < b.friction.coefficient { a } else { b };
    Some(PairLaw { normal, attraction: None, bond: None, rolling: None, torsion: None, ..*smaller })
}

/// Contact laws of stage number `stage` for grains of these sizes.
pub(super) fn laws<const D: usize>(
    case: &Case,
    options: &DemOptions,
    kinds: &[KindProperties],
    sizes: &GrainSizes,
    stage: usize,
) -> Result<StageLaws, CaseError> {
    let coming: Vec<_> = sources(case, options).iter().map(GrainSource::extremes::<D>).collect();
    let largest = coming.iter().map(|(_, [_, high])| high.0).fold(sizes.largest_radius, f64::max);
    let overrides = case.stages.get(stage).and_then(|stage| options.stages.get(&stage.name));
    let overrides = overrides.map_or(&[][..], |stage| &stage.pairs);
    let find = |a: &str, b: &str| options.pairs.iter().find(|pair| is_between(&pair.between, a, b));
    let own = |a: &str, b: &str| {
        find(a, b).map(|pair| law(&with_overrides(pair, overrides), options.velocity, largest, D))
    };
    let mut pairs = Vec::new();
    for a in kinds {
        for b in kinds {
            let found = match own(&a.name, &b.name) {
                None if options.mix && a.name != b.name => own(&a.name, &a.name)
                    .zip(own(&b.name, &b.name))
                    .and_then(|(first, second)| mixed_law(&first, &second)),
                found => found,
            };
            pairs.push(found.ok_or_else(|| {
                let mix = if options.mix { "" } else { "; give it, or set mix" };
                let problem = format!("has no pair between {:?} and {:?}{mix}", a.name, b.name);
                CaseError::new("methods.dem.pairs", problem)
            })?);
        }
    }
    let mut walls = Vec::new();
    for (name, coefficient) in frictions(case) {
        let mut of_kinds = Vec::new();
        for (number, kind) in kinds.iter().enumerate() {
            let like = pairs[number * kinds.len() + number];
            let mut law = own(&kind.name, name).unwrap_or(PairLaw { attraction: None, bond: None, ..like });
            let changed = overrides.iter().find(|change| is_between(&change.between, &kind.name, name));
            let friction = changed.and_then(|change| change.friction);
            law.friction.coefficient = friction.map_or(coefficient, |friction| friction.coefficient);
            law.friction.at_rest = friction.and_then(|f| f.at_rest).unwrap_or(law.friction.coefficient);
            of_kinds.push(law);
        }
        walls.push(of_kinds);
    }
    let smallest = smallest_grains(sizes, &coming);
    let step = stable_steps::<D>(&pairs, &walls, &smallest, sizes.any_held, options.step_fraction);
    let bridge = pairs
        .iter()
        .chain(walls.iter().flatten())
        .map(|law| max_rupture_distance(law, largest))
        .fold(0.0, f64::max);
    let all = || pairs.iter().chain(walls.iter().flatten());
    let impact = all().map(|law| impact(law, &smallest)).fold(0.0, f64::max);
    Ok(StageLaws { pairs, walls, step, impact, rupture_distance: bridge })
}

/// Names and friction coefficients of boundaries, obstacles and regions of obstacles, in this order.
fn frictions(case: &Case) -> Vec<(&str, f64)> {
    let walls = case.boundaries.iter().map(|boundary| {
        let coefficient = match boundary.wall {
            WallKind::Smooth => 0.0,
            WallKind::Frictional { friction_coefficient, .. } => friction_coefficient,
            WallKind::Rough | WallKind::Absorbing { .. } => ROUGH_FRICTION,
        };
        (boundary.name(), coefficient)
    });
    let of_wall = |wall: ObstacleWall| match wall {
        ObstacleWall::Smooth => 0.0,
        ObstacleWall::Frictional { friction_coefficient, .. } => friction_coefficient,
        ObstacleWall::Rough => ROUGH_FRICTION,
    };
    let obstacles = case.obstacles.iter().map(|obstacle| (obstacle.name.as_str(), of_wall(obstacle.wall)));
    let regions = case.obstacles.iter().flat_map(|obstacle| {
        obstacle.regions.iter().map(|region| (obstacle.name.as_str(), of_wall(region.wall)))
    });
    walls.chain(obstacles).chain(regions).collect()
}

/// Largest rupture distance (m) of a law, for grains of radius up to `largest` (m).
fn max_rupture_distance(law: &PairLaw, largest: f64) -> f64 {
    // At a wall the effective radius is that of the grain.
    let bridged = law.rupture_distance(crate::contact::ContactState::Bonded, largest);
    bridged.max(law.bond.map_or(0.0, |bond| 2.0 * bond.gap * largest))
}

/// Radius (m) and mass (kg) of the smallest grain of each kind, grains that will enter included.
fn smallest_grains(sizes: &GrainSizes, coming: &[(usize, [(f64, f64); 2])]) -> Vec<(f64, f64)> {
    let mut smallest = sizes.smallest.clone();
    for (kind, [low, _]) in coming {
        if low.0 < smallest[*kind].0 {
            smallest[*kind] = *low;
        }
    }
    smallest
}

/// Stable step of the stiffest contact (s), and upper bound of stable steps (sheet: dem §3.5). `minimum` are radius (m) and mass (kg) of
/// the smallest grain of each kind.
fn stable_steps<const D: usize>(
    pairs: &[PairLaw],
    walls: &[Vec<PairLaw>],
    minimum: &[(f64, f64)],
    held: bool,
    fraction: f64,
) -> [f64; 2] {
    let kinds = minimum.len();
    let mut limits = [f64::INFINITY; 2];
    let mut take = |law: &PairLaw, radius: f64, mass: f64, small: f64| {
        let own = limits_of::<D>(law, radius, mass, small, fraction);
        limits = [limits[0].min(own[0]), limits[1].min(own[1])];
    };
    for a in 0..kinds {
        if !minimum[a].0.is_finite() {
            continue;
        }
        for b in 0..kinds {
            if !minimum[b].0.is_finite() {
                continue;
            }
            let law = &pairs[a * kinds + b];
            let ((r, m), (s, n)) = (minimum[a], minimum[b]);
            take(law, r * s / (r + s), if held { m.min(n) } else { m * n / (m + n) }, r.min(s));
            if held {
                take(law, r * s / (r + s), m * n / (m + n), r.min(s));
            }
        }
        walls.iter().for_each(|laws| take(&laws[a], minimum[a].0, minimum[a].1, minimum[a].0));
    }
    limits
}

/// Largest impact factor, see [`StageLaws::impact`], of equal spheres with the radii (m) and masses (kg) of `minimum`.
fn impact(law: &PairLaw, minimum: &[(f64, f64)]) -> f64 {
    let NormalForceLaw::Hertz(hertz) = &law.normal else { return 0.0 };
    let sizes = minimum.iter().filter(|(radius, _)| radius.is_finite());
    let of = |&(radius, mass): &(f64, f64)| {
        (hertz.max_impact_overlap(0.5 * mass, 0.5 * radius, 2.0) / radius).powf(2.5)
    };
    sizes.map(of).fold(0.0, f64::max)
}

/// Step limits of a contact (s): fraction of the contact duration or Rayleigh time, and limit of stability.
fn limits_of<const D: usize>(law: &PairLaw, radius: f64, mass: f64, small: f64, fraction: f64) -> [f64; 2] {
    let bond = law.bond.map_or(0.0, |bond| bond.stiffness::<D>(small));
    match &law.normal {
        NormalForceLaw::Linear(linear) => {
            let frequency = ((linear.stiffness(radius) + bond) / mass).sqrt();
            [fraction * PI / frequency, MAX_STEP_FRACTION * 2.0 / frequency]
        }
        NormalForceLaw::Hertz(hertz) => {
            // Rayleigh wave over the smaller grain, with moduli from those of the contact.
            let ratio = hertz.modulus / hertz.grain_shear_modulus;
            let poisson = ((ratio - 4.0) / (ratio - 2.0)).clamp(-0.99, 0.5);
            let shear = hertz.grain_shear_modulus * 2.0 * (2.0 - poisson);
            // Two equal grains have half the mass of one, a contact with a wall has all of it.
            let density = mass / (4.0 / 3.0 * PI * small.powi(3)) * if radius < small { 2.0 } else { 1.0 };
            let rayleigh = PI * small * (density / shear).sqrt() / (0.1631 * poisson + 0.8766);
            let bonded = if bond > 0.0 { fraction * PI / (bond / mass).sqrt() } else { f64::INFINITY };
            [(6.0 * fraction * rayleigh).min(bonded), (0.8 * rayleigh).min(12.0 * bonded)]
        }
    }
}
