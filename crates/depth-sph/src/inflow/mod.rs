//! Inflow across a line, by a hydrograph (sheet: depth-sph §3.9; §0 for dry beds and lines in plan).
//!
//! Rows of nodes of one volume fill the space behind the line as far as their kernels reach. Each row moves so that it crosses the line
//! when the volume before it has entered: the entered volume is the integral of the discharge but for part of a row. Depth and speed of the
//! rows follow from the discharge and, for subcritical inflow, from the flow before the line.

pub mod cross_section;

use serde::{Deserialize, Serialize};

use crate::inflow::cross_section::CrossSection;
use crate::points::phase_nodes::{NewNode, PlanVector};

/// Distance outside the kernel range within which rows behind an inflow line are kept (rows), so that no row is removed and added again.
const MARGIN_ROWS: f64 = 1.0;

/// Value of a hydrograph at a time (s): linear between its pairs, zero before the first and after the last.
pub fn at_time(hydrograph: &[[f64; 2]], time: f64) -> f64 {
    let part = hydrograph.windows(2).find(|pair| (pair[0][0]..=pair[1][0]).contains(&time));
    part.map_or(0.0, |pair| {
        pair[0][1] + (time - pair[0][0]) / (pair[1][0] - pair[0][0]) * (pair[1][1] - pair[0][1])
    })
}

/// Integral of a hydrograph up to a time (s).
pub fn volume(hydrograph: &[[f64; 2]], time: f64) -> f64 {
    let part = |pair: &[[f64; 2]]| {
        let end = time.clamp(pair[0][0], pair[1][0]);
        let slope = (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
        let span = end - pair[0][0];
        span * (pair[0][1] + 0.5 * slope * span)
    };
    hydrograph.windows(2).map(part).sum()
}

/// Depth (m) and speed (m/s) of a discharge per width (m²/s) with a Froude number, under gravity (m/s²).
pub fn section_by_froude(flux: f64, froude: f64, gravity: f64) -> (f64, f64) {
    let depth = (flux / (froude * gravity.sqrt())).powf(2.0 / 3.0);
    (depth, if depth > 0.0 { flux / depth } else { 0.0 })
}

/// Flow that arrives at an inflow section from the flow domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrivingFlow {
    /// Riemann invariant `u + 2c` of the outward speed `u` (m/s).
    pub outgoing: f64,
    /// Effective gravity (m/s²).
    pub effective_gravity: f64,
}

impl ArrivingFlow {
    /// Creates the arriving flow of a depth (m) and an outward speed (m/s) under `effective_gravity` (m/s²).
    pub fn from_depth_and_speed(depth: f64, speed: f64, effective_gravity: f64) -> Self {
        Self { outgoing: speed + 2.0 * (effective_gravity * depth.max(0.0)).sqrt(), effective_gravity }
    }

    /// Depth (m) and speed into the flow domain (m/s) of a subcritical inflow with a discharge per width (m²/s): `c² (2c - R) = g q` with
    /// the Riemann invariant `R` of the arriving flow. `None` for supercritical inflow and for a dry section.
    pub fn depth_and_speed(&self, flux: f64) -> Option<(f64, f64)> {
        let Self { outgoing, effective_gravity } = *self;
        // Start above the root, from where Newton's steps decrease to it.
        let mut celerity = (0.5 * outgoing).max(0.0) + (effective_gravity * flux).cbrt();
        if celerity <= 0.0 {
            return None;
        }
        for _ in 0..60 {
            let value = celerity * celerity * (2.0 * celerity - outgoing) - effective_gravity * flux;
            let change = value / (6.0 * celerity * celerity - 2.0 * celerity * outgoing);
            if !(change.abs() > 1e-14 * celerity) {
                break;
            }
            celerity -= change;
        }
        let speed = outgoing - 2.0 * celerity;
        (-speed <= celerity).then_some((celerity * celerity / effective_gravity, speed))
    }
}

/// Depth (m) and inward speed (m/s) of a discharge per width (m²/s). They follow from the Riemann invariant of the arriving flow. For a dry
/// section and for supercritical inflow they follow from the Froude number, which is then at least 1.
pub fn inflow_section(flux: f64, arriving: Option<ArrivingFlow>, froude: f64, gravity: f64) -> (f64, f64) {
    match arriving {
        None => section_by_froude(flux, froude, gravity),
        Some(arriving) => match arriving.depth_and_speed(flux) {
            Some((depth, outward)) => (depth, -outward),
            None => section_by_froude(flux, froude.max(1.0), gravity),
        },
    }
}

/// Inflow of material across a line by a hydrograph. In plan only.
#[derive(Clone, Debug, PartialEq)]
pub struct Inflow<const D: usize> {
    /// Begin of the line (m).
    pub start: PlanVector<D>,
    /// End of the inflow line (m); the flow is to the right of the direction from start to end.
    pub end: PlanVector<D>,
    /// Hydrograph: times (s) and discharges (m³/s), linear between them and zero before and after.
    pub hydrograph: Vec<[f64; 2]>,
    /// Froude number `u/√(g h)` of the inflow, used if the line is dry or the inflow supercritical.
    pub froude: f64,
    /// Depth at which the distance of the rows equals the node spacing along the line (m).
    pub depth: f64,
    /// Gravity (m/s²).
    pub gravity: f64,
    /// Node spacing along the line, which is also the distance of rows at the largest discharge (m).
    pub spacing: f64,
    /// Smoothing length over `spacing`.
    pub ratio: f64,
    /// Width of the zone of rows behind the line (m).
    pub row_extent: f64,
    /// Number of the body to which the inflow nodes belong.
    pub body: u32,
    /// Porosity of an inflow of grains and fluid; `None` for a single phase.
    pub porosity: Option<f64>,
    /// Number of the layer that flows in (0 lower, 1 upper); `None` for flows that are not of two layers.
    pub layer: Option<usize>,
    /// Cross-section of the bed, over which the inflow has one water level; `None` for an inflow of one depth.
    pub channel: Option<CrossSection>,
    /// Rows of nodes and flow state of the inflow.
    pub state: InflowState,
}

/// Rows of nodes behind an inflow line, and the flow state there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InflowState {
    /// Number of rows that have crossed the line.
    pub crossed_rows: u64,
    /// Rows behind the line, the nearest first: number of the row, and position along the line and number of each of its nodes.
    pub waiting_rows: Vec<(u64, Vec<(usize, u64)>)>,
    /// State of the flow at the line.
    pub section: InflowSection,
}

/// State of the flow at a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InflowSection {
    /// Mean depth over the whole length of the line (m).
    pub depth: f64,
    /// Speed (m/s).
    pub speed: f64,
    /// Largest depth (m).
    pub max_depth: f64,
}

/// Positions and velocities of the nodes behind the inflow lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WaitingNodes<const D: usize> {
    /// Number, position (m) and velocity (m/s) of each, by number.
    pub nodes: Vec<(u64, PlanVector<D>, PlanVector<D>)>,
}

impl<const D: usize> WaitingNodes<D> {
    /// Prescribed position and velocity of a node; `None` for a node in the flow.
    pub fn position_and_velocity(&self, id: u64) -> Option<(PlanVector<D>, PlanVector<D>)> {
        let found = self.nodes.binary_search_by_key(&id, |node| node.0).ok()?;
        let (_, place, velocity) = self.nodes[found];
        Some((place, velocity))
    }
}

impl<const D: usize> Inflow<D> {
    /// Vector from the start to the end of the inflow line (m).
    fn direction(&self) -> PlanVector<D> {
        std::array::from_fn(|c| self.end[c] - self.start[c])
    }

    /// Length of the line (m).
    pub fn width(&self) -> f64 {
        self.direction().iter().map(|c| c * c).sum::<f64>().sqrt()
    }

    /// Direction of the inflow: normal to the right of the line.
    pub fn normal(&self) -> PlanVector<D> {
        let (along, width) = (self.direction(), self.width());
        std::array::from_fn(|c| if c == 0 { along[D - 1] / width } else { -along[0] / width })
    }

    /// Discharge at a time (m³/s).
    pub fn discharge(&self, time: f64) -> f64 {
        at_time(&self.hydrograph, time)
    }

    /// Inflow volume until a time (m³).
    pub fn volume(&self, time: f64) -> f64 {
        volume(&self.hydrograph, time)
    }

    /// Distances of a position from the line, positive on the flow side, and along it (m).
    pub fn distances(&self, x: &PlanVector<D>) -> (f64, f64) {
        let [normal, along] = self.normal_and_tangential(&std::array::from_fn(|c| x[c] - self.start[c]));
        (normal, along)
    }

    /// Components of a velocity against the inflow direction and along the line (m/s).
    pub fn outward_and_tangential(&self, velocity: &PlanVector<D>) -> [f64; 2] {
        let [normal, along] = self.normal_and_tangential(velocity);
        [-normal, along]
    }

    /// Components of a vector in the inflow direction and along the line.
    fn normal_and_tangential(&self, vector: &PlanVector<D>) -> [f64; 2] {
        let dot = |a: &PlanVector<D>| -> f64 { (0..D).map(|c| a[c] * vector[c]).sum() };
        [dot(&self.normal()), dot(&self.direction()) / self.width()]
    }

    /// Flow state at the line for a discharge (m³/s) and the arriving flow; by the Froude number if the line is dry.
    pub fn section(&self, discharge: f64, arriving: Option<ArrivingFlow>) -> InflowSection {
        let section = |width: f64| inflow_section(discharge / width, arriving, self.froude, self.gravity);
        let Some(channel) = &self.channel else {
            let (depth, speed) = section(self.width());
            return InflowSection { depth, speed, max_depth: depth };
        };
        let deepest = channel.level(|width| section(width).0);
        let (area, _) = channel.wetted_area_and_width(deepest);
        let speed = if area > 0.0 { discharge / area } else { 0.0 };
        InflowSection { depth: area / self.width(), speed, max_depth: deepest }
    }

    /// Positions of the nodes of a row along the line, with the volume of each over all phases (m³).
    fn volumes(&self) -> Vec<(usize, f64)> {
        let (whole, count) = (self.row_volume(), self.count());
        let Some(channel) = &self.channel else {
            return (0..count).map(|k| (k, whole / count as f64)).collect();
        };
        let shares = channel.wetted_shares(self.state.section.max_depth).into_iter();
        shares.map(|(k, share)| (k, whole * share)).collect()
    }

    /// Height of a node behind the line from its volume (m).
    pub fn height(&self, volume: f64) -> f64 {
        volume / self.row_volume() * self.count() as f64 * self.state.section.depth
    }

    /// Number of node positions along the line.
    pub fn count(&self) -> usize {
        (self.width() / self.spacing).round().max(1.0) as usize
    }

    /// Volume of a row (m³), close to that of rows at the node spacing, such that the total volume is a whole number of rows.
    pub fn row_volume(&self) -> f64 {
        let whole = self.volume(f64::INFINITY);
        whole / (whole / (self.depth * self.width() * self.spacing)).round().max(1.0)
    }

    /// Flow state at the line at the largest discharge, by the Froude number.
    pub fn max_section(&self) -> InflowSection {
        self.section(self.hydrograph.iter().map(|pair| pair[1]).fold(0.0, f64::max), None)
    }

    /// Position of node `k` of a row at the distance `behind` the line (m).
    pub fn node_position(&self, k: usize, behind: f64) -> PlanVector<D> {
        let (share, along, normal) =
            ((k as f64 + 0.5) / self.count() as f64, self.direction(), self.normal());
        std::array::from_fn(|c| self.start[c] + share * along[c] - behind * normal[c])
    }

    /// Distance of a row behind the line (m) after the inflow of a volume (m³) at a depth (m).
    fn row_distance(&self, row: u64, volume: f64, depth: f64) -> f64 {
        ((row as f64 + 0.5) * self.row_volume() - volume) / (depth * self.width())
    }

    /// Node sets of the inflow with their shares of the volume.
    fn set_shares(&self) -> Vec<(usize, f64)> {
        match (self.layer, self.porosity) {
            (Some(set), _) => vec![(set, 1.0)],
            (None, None) => vec![(0, 1.0)],
            (None, Some(porosity)) => vec![(0, 1.0 - porosity), (1, porosity)],
        }
    }

    /// Whether a node set has inflow.
    pub fn is_of(&self, number: usize) -> bool {
        self.layer.is_none_or(|own| own == number)
    }

    /// Releases the rows that have crossed the line by `time` (s) to the flow, and adds rows behind it. `section` is the flow state at the
    /// line. Returns new nodes with their sets and numbers, from `next_id` on, and the numbers of nodes that are no longer needed. A row of
    /// two phases has the nodes of the grains first.
    pub fn advance(
        &mut self,
        time: f64,
        section: InflowSection,
        next_id: &mut u64,
    ) -> (Vec<(usize, u64, NewNode<D>)>, Vec<u64>) {
        self.state.section = section;
        let (volume, InflowSection { depth, speed, .. }) = (self.volume(time), self.state.section);
        let row_volume = self.row_volume();
        while (self.state.crossed_rows as f64 + 0.5) * row_volume <= volume {
            let row = self.state.crossed_rows;
            self.state.waiting_rows.retain(|(held, _)| *held != row);
            self.state.crossed_rows += 1;
        }
        let (mut fresh, mut stale) = (Vec::new(), Vec::new());
        let farthest = self.row_extent + MARGIN_ROWS * self.spacing;
        let far =
            |inflow: &Self, row: u64| !(depth > 0.0) || inflow.row_distance(row, volume, depth) > farthest;
        while let Some((row, _)) = self.state.waiting_rows.last()
            && far(self, *row)
        {
            stale
                .extend(self.state.waiting_rows.pop().into_iter().flat_map(|(_, own)| own).map(|(_, id)| id));
        }
        let mut row = self.state.waiting_rows.last().map_or(self.state.crossed_rows, |(row, _)| row + 1);
        while depth > 0.0 && self.row_distance(row, volume, depth) <= self.row_extent {
            let (behind, normal) = (self.row_distance(row, volume, depth), self.normal());
            let node = |k: usize, volume: f64| NewNode {
                body: self.body,
                position: self.node_position(k, behind),
                velocity: normal.map(|c| c * speed),
                volume,
                length: self.ratio * self.spacing,
                scale: self.ratio.powi(D as i32),
            };
            let mut own = Vec::new();
            for (set, share) in self.set_shares() {
                for (k, volume) in self.volumes() {
                    fresh.push((set, *next_id, node(k, share * volume)));
                    own.push((k, *next_id));
                    *next_id += 1;
                }
            }
            self.state.waiting_rows.push((row, own));
            row += 1;
        }
        (fresh, stale)
    }

    /// Numbers, positions (m) and velocities (m/s) of the nodes behind the line at a time (s).
    pub fn waiting_nodes(&self, time: f64) -> Vec<(u64, PlanVector<D>, PlanVector<D>)> {
        let (volume, InflowSection { depth, speed, .. }) = (self.volume(time), self.state.section);
        let velocity = self.normal().map(|c| c * speed);
        let row = |(row, own): &(u64, Vec<(usize, u64)>)| {
            let behind = self.row_distance(*row, volume, depth);
            let place = move |(k, id): &(usize, u64)| (*id, self.node_position(*k, behind), velocity);
            own.iter().map(place).collect::<Vec<_>>()
        };
        self.state.waiting_rows.iter().flat_map(row).collect()
    }

    /// Volume of the nodes that have crossed the line (m³).
    pub fn entered_volume(&self) -> f64 {
        self.state.crossed_rows as f64 * self.row_volume()
    }

    /// Volume of the nodes behind the line (m³).
    pub fn waiting_volume(&self) -> f64 {
        self.state.waiting_rows.len() as f64 * self.row_volume()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inflow() -> Inflow<2> {
        let mut inflow = Inflow {
            start: [0.0, 0.0],
            end: [0.0, 4.0],
            hydrograph: vec![[1.0, 0.0], [3.0, 8.0], [7.0, 0.0]],
            froude: 2.0,
            depth: 0.0,
            gravity: 9.81,
            spacing: 0.5,
            ratio: 1.3,
            row_extent: 2.0,
            body: 0,
            porosity: None,
            layer: None,
            channel: None,
            state: InflowState::default(),
        };
        inflow.depth = inflow.max_section().depth;
        inflow
    }

    #[test]
    fn volume_is_the_integral_of_the_discharge() {
        let inflow = inflow();
        assert_eq!((inflow.discharge(2.0), inflow.discharge(0.5), inflow.discharge(8.0)), (4.0, 0.0, 0.0));
        for (time, volume) in [(0.0, 0.0), (2.0, 2.0), (3.0, 8.0), (5.0, 20.0), (9.0, 24.0)] {
            assert!((inflow.volume(time) - volume).abs() < 1e-12, "{time}");
        }
        let InflowSection { depth, speed, .. } = inflow.section(8.0, None);
        assert!((depth * speed - 2.0).abs() < 1e-12 && (speed / (9.81 * depth).sqrt() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn inflow_rows_cross_when_their_volume_has_entered() {
        let (mut inflow, mut next_id) = (inflow(), 0);
        let mut there = std::collections::BTreeSet::new();
        for step in 0..900 {
            let time = 0.01 * f64::from(step);
            let section = inflow.section(inflow.discharge(time), None);
            let (fresh, stale) = inflow.advance(time, section, &mut next_id);
            there.extend(fresh.iter().map(|(_, id, _)| *id));
            stale.iter().for_each(|id| assert!(there.remove(id)));
            assert!(
                (inflow.entered_volume() - inflow.volume(time)).abs() <= 0.5 * inflow.row_volume() + 1e-9
            );
            assert!(
                inflow.waiting_nodes(time).iter().all(|(_, x, _)| x[0] <= 1e-9 && x[0] >= -2.0 - 0.5 - 1e-9)
            );
        }
        assert_eq!(
            there.len() as u64,
            8 * inflow.state.crossed_rows,
            "no more and no less than have crossed"
        );
        assert!(inflow.state.waiting_rows.is_empty(), "{:?}", inflow.state);
        assert!((inflow.entered_volume() - 24.0).abs() < 1e-12, "{} m³", inflow.entered_volume());
    }

    /// A hydrograph gives its integral at any spacing, however few rows that is.
    #[test]
    fn inflow_volume_is_the_integral_of_the_hydrograph_at_any_spacing() {
        for spacing in [0.1, 0.5, 0.7, 1.3, 2.0, 4.0, 9.0] {
            let mut inflow = Inflow { spacing, row_extent: 3.0 * spacing, ..inflow() };
            let mut next_id = 0;
            let mut brought = std::collections::BTreeMap::new();
            for step in 0..400 {
                let time = 0.02 * f64::from(step);
                let section = inflow.section(inflow.discharge(time), None);
                let (fresh, stale) = inflow.advance(time, section, &mut next_id);
                brought.extend(fresh.iter().map(|(_, id, node)| (*id, node.volume)));
                stale.iter().for_each(|id| assert!(brought.remove(id).is_some()));
            }
            let whole: f64 = brought.values().sum();
            assert!((whole / 24.0 - 1.0).abs() < 1e-12, "{spacing} m: {whole} m³");
        }
    }
}
