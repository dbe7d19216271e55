//! Drop and roll of disks, one by one until two supports hold each (ballistic deposition; sheet: dem §3.8).

use std::f64::consts::FRAC_PI_2;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::specimen::{Container, GrainHeap};

/// Largest number of supports over which a disk rolls before it is discarded.
const MAX_ROLLS: usize = 1000;
/// Relative tolerance of lengths, below which a distance is regarded as zero.
const NEGLIGIBLE: f64 = 1e-9;

/// Support at which the motion of a disk stops.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RestingOn {
    /// The floor.
    Floor,
    /// A disk.
    Disk(usize),
    /// A side; no disk rests on a side alone.
    Side,
    /// No support: it has rolled to the height of the centre of its support, and falls.
    Unsupported,
}

/// Disks at rest, sorted into columns along the floor.
struct RestingDisks<'a> {
    container: &'a Container<2>,
    disks: Vec<([f64; 2], f64)>,
    columns: Vec<Vec<u32>>,
    width: f64,
}

impl<'a> RestingDisks<'a> {
    /// Empty set of disks in a container; `largest` is the largest radius (m).
    fn new(container: &'a Container<2>, largest: f64) -> Self {
        let length = container.width(0);
        // As wide as two of the largest disks, so that contacts of a disk are in its column or beside it.
        let count = (length / (2.0 * largest)).floor().max(1.0) as usize;
        Self { container, disks: Vec::new(), columns: vec![Vec::new(); count], width: length / count as f64 }
    }

    /// Column of a horizontal position `x` (m).
    fn column(&self, x: f64) -> usize {
        (((x - self.container.low[0]) / self.width).max(0.0) as usize).min(self.columns.len() - 1)
    }

    /// Disks within two of the largest diameters along the floor.
    fn nearby_disks(&self, x: f64) -> impl Iterator<Item = usize> {
        let (count, own) = (self.columns.len() as i64, self.column(x) as i64);
        let round = self.container.periodic[0];
        let reach = if count < 5 { 0..=count - 1 } else { own - 2..=own + 2 };
        let real = reach.filter(move |k| round || (0..count).contains(k));
        real.flat_map(move |k| self.columns[k.rem_euclid(count) as usize].iter().map(|&i| i as usize))
    }

    /// Distance along the floor to a disk, over the period (m).
    fn horizontal_distance(&self, x: f64, other: usize) -> f64 {
        let offset = self.disks[other].0[0] - x;
        if !self.container.periodic[0] {
            return offset;
        }
        let length = self.container.width(0);
        offset - length * (offset / length).round()
    }

    /// First contact of a disk that falls from a height at `x`: height of its centre (m), and the support.
    fn first_contact(&self, [x, from]: [f64; 2], radius: f64) -> (f64, RestingOn) {
        let mut found = (self.container.low[1] + radius, RestingOn::Floor);
        for other in self.nearby_disks(x) {
            let (offset, reach) = (self.horizontal_distance(x, other), radius + self.disks[other].1);
            if offset.abs() >= reach * (1.0 - NEGLIGIBLE) {
                continue;
            }
            let height = self.disks[other].0[1] + (reach * reach - offset * offset).sqrt();
            if height > found.0 && height <= from + NEGLIGIBLE * reach {
                found = (height, RestingOn::Disk(other));
            }
        }
        found
    }

    /// Rolls a disk at `x` over a lower disk towards one side (1 or -1). Returns its end position (m) and the support that stops it.
    fn roll(&self, x: [f64; 2], radius: f64, on: usize, side: f64) -> ([f64; 2], RestingOn) {
        let reach = radius + self.disks[on].1;
        let centre = [x[0] + self.horizontal_distance(x[0], on), self.disks[on].0[1]];
        let start = (side * (x[0] - centre[0])).atan2(x[1] - centre[1]);
        let mut end = (FRAC_PI_2.max(start), RestingOn::Unsupported);
        let mut stop = |angle: f64, held: RestingOn| {
            if angle >= start - NEGLIGIBLE && angle < end.0 {
                end = (angle.max(start), held);
            }
        };
        let floor = (self.container.low[1] + radius - centre[1]) / reach;
        if floor > 0.0 {
            stop(floor.min(1.0).acos(), RestingOn::Floor);
        }
        if !self.container.periodic[0] {
            let wall =
                if side > 0.0 { self.container.high[0] - radius } else { self.container.low[0] + radius };
            let off = side * (wall - centre[0]) / reach;
            if off < 1.0 {
                stop(off.max(-1.0).asin(), RestingOn::Side);
            }
        }
        for other in self.nearby_disks(centre[0]).filter(|other| *other != on) {
            let (offset, up) =
                (self.horizontal_distance(centre[0], other), self.disks[other].0[1] - centre[1]);
            let (apart, to) = (offset.hypot(up), radius + self.disks[other].1);
            let cosine = (reach * reach + apart * apart - to * to) / (2.0 * reach * apart);
            if cosine.abs() < 1.0 {
                // First intersection of the circles about both.
                stop((side * offset).atan2(up) - cosine.acos(), RestingOn::Disk(other));
            }
        }
        ([centre[0] + side * reach * end.0.sin(), centre[1] + reach * end.0.cos()], end.1)
    }
}

impl GrainHeap<2> for RestingDisks<'_> {
    fn resting_position(&self, over: [f64; 2], radius: f64, random: &mut ChaCha8Rng) -> Option<[f64; 2]> {
        let (height, mut held) = self.first_contact(over, radius);
        let mut place = [over[0], height];
        let mut side = 0.0;
        for _ in 0..MAX_ROLLS {
            let on = match held {
                RestingOn::Floor | RestingOn::Side => return Some(place),
                RestingOn::Unsupported => {
                    let (height, next) = self.first_contact(place, radius);
                    (place[1], held, side) = (height, next, 0.0);
                    continue;
                }
                RestingOn::Disk(on) => on,
            };
            let off = -self.horizontal_distance(place[0], on);
            if side * off < 0.0 {
                // It rests on the disk from which it has rolled and on this support, one on either side of it.
                return Some(place);
            }
            side = if off == 0.0 { if random.random::<bool>() { 1.0 } else { -1.0 } } else { off.signum() };
            let (next, stopped) = self.roll(place, radius, on, side);
            (place, held) = ([self.container.wrapped_coordinate(0, next[0]), next[1]], stopped);
        }
        None
    }

    fn add(&mut self, place: [f64; 2], radius: f64) {
        let column = self.column(place[0]);
        self.columns[column].push(self.disks.len() as u32);
        self.disks.push((place, radius));
    }
}

/// Drops disks at random positions over a container until it is full. `draw` gives the radius of each disk (m). Returns positions and radii
/// (m), the lowest first. Each disk rests on two disks with its centre between them, on a disk and a side wall, or on the floor.
///
/// # Errors
/// When the container is narrower than two of the largest disks (`largest`, m), or would hold more than `limit` of them.
pub fn drop_and_roll(
    container: &Container<2>,
    largest: f64,
    limit: usize,
    random: &mut ChaCha8Rng,
    draw: impl FnMut(&mut ChaCha8Rng) -> f64,
) -> Result<Vec<([f64; 2], f64)>, String> {
    container.check_width(0..1, largest)?;
    let mut bed = RestingDisks::new(container, largest);
    container.drop_grains(&mut bed, limit, random, draw)?;
    Ok(bed.disks)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    fn drop_and_roll_packing(
        periodic: bool,
        seed: u64,
        [low, span]: [f64; 2],
    ) -> (Container<2>, Vec<([f64; 2], f64)>) {
        let container =
            Container { low: [-3.0, 2.0], high: [27.0, 22.0], periodic: [periodic, false], round_wall: None };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let draw = |random: &mut ChaCha8Rng| low + span * random.random::<f64>();
        let placed = drop_and_roll(&container, low + span, 100_000, &mut random, draw).unwrap();
        (container, placed)
    }

    #[test]
    fn each_disk_rests_on_two_supports_and_touches_no_other_deeper() {
        for (periodic, seed, sizes) in [(true, 1, [0.4, 0.2]), (false, 2, [0.4, 0.2]), (false, 3, [0.1, 0.6])]
        {
            let (container, placed) = drop_and_roll_packing(periodic, seed, sizes);
            assert!(placed.len() > 300);
            for (i, (x, radius)) in placed.iter().enumerate() {
                let (mut left, mut right) = (0, 0);
                for (y, other) in &placed[..i] {
                    let apart = container.separation(y, x);
                    let gap = apart[0].hypot(apart[1]) - radius - other;
                    assert!(gap > -1e-7, "{i}: {gap}");
                    // Disks placed before it came to rest, and not above it.
                    if gap < 1e-7 {
                        if apart[0] <= 0.0 { left += 1 } else { right += 1 }
                    }
                }
                let floor = x[1] - radius - container.low[1];
                let sides = [x[0] - radius - container.low[0], container.high[0] - radius - x[0]];
                assert!(floor > -1e-9 && x[1] + radius <= container.high[1]);
                if !periodic {
                    assert!(sides[0] > -1e-9 && sides[1] > -1e-9);
                    left += usize::from(sides[0] < 1e-7);
                    right += usize::from(sides[1] < 1e-7);
                }
                assert!(floor < 1e-7 || (left > 0 && right > 0), "{i}: {left} {right}");
            }
        }
    }

    #[test]
    fn a_bed_of_nearly_equal_disks_has_four_contacts_a_disk_and_is_seeded() {
        // Equal disks may have three supports in a lattice.
        let sizes = [0.25, 5e-4];
        let (container, placed) = drop_and_roll_packing(true, 7, sizes);
        let on_floor = |(x, r): &([f64; 2], f64)| x[1] - r - container.low[1] < 1e-9;
        let mut contacts = 0;
        for (i, (x, radius)) in placed.iter().enumerate().filter(|(_, own)| !on_floor(own)) {
            for (y, other) in &placed[..i] {
                let apart = container.separation(y, x);
                contacts += usize::from(apart[0].hypot(apart[1]) < (radius + other) * (1.0 + 1e-9));
            }
        }
        // Two supports each but for the row on the floor, whose disks may touch each other.
        let above = placed.iter().filter(|own| !on_floor(own)).count();
        assert_eq!(contacts, 2 * above);
        // Away from floor and surface: 0.82 for dropped equal disks (Visscher and Bolsterli 1972).
        let (low, high) = (7.0, 17.0);
        let inner = placed.iter().filter(|(x, _)| x[1] > low && x[1] < high).count() as f64;
        let solid = inner * std::f64::consts::PI * 0.0625 / (container.width(0) * (high - low));
        assert!((0.79..0.85).contains(&solid), "{solid}");
        assert_eq!(drop_and_roll_packing(true, 7, sizes).1, placed);
        assert_ne!(drop_and_roll_packing(true, 8, sizes).1, placed);
    }

    #[test]
    fn narrow_boxes_and_too_many_grains_are_refused() {
        let container = Container { low: [0.0; 2], high: [1.0, 9.0], periodic: [false; 2], round_wall: None };
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let narrow = drop_and_roll(&container, 0.3, 10, &mut random, |_| 0.3).unwrap_err();
        assert!(narrow.contains("less than two"), "{narrow}");
        let many = drop_and_roll(&container, 0.1, 10, &mut random, |_| 0.1).unwrap_err();
        assert!(many.contains("more than 10"), "{many}");
    }
}
