//! Open sides of a flow, before its first step (sheet: depth-sph §3.9).

use crate::boundary::open::{
    Inlet, OpenBoundary, OpenSides, Opening, layers_of_sides, node_extent_beyond, open_sides, region_of,
    update_open_boundaries,
};
use crate::flow::Flow;
use crate::phases::failure::FlowFailure;

impl<const D: usize> Flow<D> {
    /// Makes an end of a profile an open boundary, before the first step. `spacing` is that of the nodes (m).
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn open_end(&mut self, coordinate: f64, outward: f64, spacing: f64) -> Result<(), FlowFailure> {
        self.open_sides(&[Opening {
            axis: 0,
            coordinate,
            outward,
            spacing,
            span: (0.0, 0.0),
            periodic: false,
            inlets: Vec::new(),
            absorbing_length: 0.0,
        }])
    }

    /// Makes sides of the domain open boundaries, before the first step. A common corner belongs to the first of its boundaries.
    ///
    /// # Errors
    /// As [`Flow::new`].
    pub fn open_sides(&mut self, openings: &[Opening]) -> Result<(), FlowFailure> {
        let known = self.boundary.open_sides.len();
        // Each of two layers has its sides.
        let layers = layers_of_sides(&self.settings);
        let mut sides = open_sides(&self.boundary.open_sides);
        for opening in openings {
            sides.extend(layers.iter().map(|_| (opening.axis, opening.coordinate, opening.outward)));
        }
        let inlets = self.add_open_sides(openings, &sides);
        let Self { clock, settings, boundary, nodes, .. } = self;
        update_open_boundaries(settings, clock, &mut boundary.open_sides, nodes, 0.0);
        self.reinitialise_thickness()?;
        let kernel = self.settings.numerics.kernel;
        let (open, sets) = (&mut self.boundary.open_sides, &self.nodes.sets);
        for (number, (end, inlet)) in (known..).zip(open[known..].iter_mut().zip(inlets)) {
            end.calibrate_lattice_sum(kernel, sets, &|x| region_of(&sides, number, x));
            end.store_undisturbed(sets, &|x| region_of(&sides, number, x));
            if inlet.is_some() {
                end.inlet = inlet;
            }
        }
        Ok(())
    }

    /// Adds open boundaries with their initial states. Returns the inlets, which start after the sums of the initial state are known.
    fn add_open_sides(&mut self, openings: &[Opening], sides: &OpenSides) -> Vec<Option<Inlet>> {
        let Self { clock, settings, boundary, nodes, limits, .. } = self;
        let longest = nodes.sets.iter().flat_map(|set| &set.nodes.first_length).copied().fold(0.0, f64::max);
        let reach = node_extent_beyond(settings, longest);
        let (gravity, time, known) = (settings.gravity, clock.time, boundary.open_sides.len());
        let layers = layers_of_sides(settings);
        let all = openings.iter().flat_map(|opening| layers.iter().map(move |layer| (opening, *layer)));
        let mut later = Vec::new();
        for (number, (opening, layer)) in (known..).zip(all) {
            let mut end = OpenBoundary::new(opening, reach, openings, layer);
            let set = layer.map(|layer| layer.set);
            let inlet = opening.inlets.iter().find(|inlet| inlet.layer == set).cloned();
            end.initialise(&nodes.sets, &|x| region_of(sides, number, x), gravity, time, inlet.as_ref());
            let max_speed = inlet.as_ref().map_or(0.0, |inlet| inlet.max_speed(gravity));
            limits.max_initial_speed = limits.max_initial_speed.max(max_speed);
            let (now, then) = if end.is_filled() { (None, inlet) } else { (inlet, None) };
            end.inlet = now;
            later.push(then);
            boundary.open_sides.push(end);
        }
        later
    }
}
