//! Writer of specimen files, from a solver.

use colluvium_case::output::Table;
use serde::Serialize;

use crate::boundary::walls::RigidWall;
use crate::contact::contact_histories::ContactHistories;
use crate::contact::{AttractionLaw, PairLaw};
use crate::obstacles::facet::FacetContact;
use crate::output::packing_view::PackingView;
use crate::specimen::file::{
    FORMAT, NO_INDEX, SpecimenHeader, StoredCell, StoredSpecimen, StoredWall, names,
};

/// Name and unit of a column.
type Heading = (String, String);

/// Adds the columns of a quantity.
fn add_headings<const N: usize>(columns: &mut Vec<Heading>, name: &str, unit: &str) {
    columns.extend(names::<N>(name).map(|name| (name, unit.to_owned())));
}

/// Plain data as formatted JSON.
fn json(value: &impl Serialize) -> String {
    serde_json::to_string_pretty(value).expect("plain data always serialises")
}

/// Table as JSON, one row per line.
fn lines(table: &Table) -> String {
    let line = |row: &Vec<f64>| serde_json::to_string(row).expect("plain data always serialises");
    let columns = serde_json::to_string(&table.columns).expect("plain data always serialises");
    let rows: Vec<String> = table.rows.iter().map(line).collect();
    format!("{{ \"columns\": {columns}, \"rows\": [\n{}\n] }}", rows.join(",\n"))
}

impl<const D: usize, const R: usize> PackingView<'_, D, R> {
    /// Text of a specimen file: grains, contact histories, cell and walls, with which another case can start.
    pub(crate) fn specimen_text(&self) -> String {
        let stored = StoredSpecimen {
            head: self.specimen_header(),
            grains: self.grain_rows(),
            contacts: self.contact_rows(),
        };
        format!(
            "{{\n\"head\": {},\n\"grains\": {},\n\"contacts\": {}\n}}\n",
            json(&stored.head),
            lines(&stored.grains),
            lines(&stored.contacts)
        )
    }

    /// Head of a specimen file: cell, walls, materials and largest overlap.
    fn specimen_header(&self) -> SpecimenHeader {
        let cell = &self.cell.geometry;
        let column = |k: usize| cell.h.iter().map(|row| row[k]).collect();
        let side = |wall: &RigidWall<D>| StoredWall {
            name: wall.name.clone(),
            plane: wall.surface.is_none().then_some((wall.axis, wall.is_upper, wall.position)),
            velocity: wall.velocity.to_vec(),
        };
        let moving = self.boundary.walls.iter().filter(|wall| wall.motion.is_some());
        let sticks =
            |law: &PairLaw| law.bond.is_some() || matches!(law.attraction, Some(AttractionLaw::Cohesion(_)));
        let mut overlap = 0.0f64;
        self.for_each_contact(|contact, _, _| overlap = overlap.max(self.overlap_of(&contact)));
        SpecimenHeader {
            format: FORMAT.to_owned(),
            title: self.clock.case.title.clone(),
            dimension: D,
            time: self.clock.time,
            step: self.clock.last_step,
            origin: self.clock.case.origin()[..D].to_vec(),
            cell: StoredCell {
                periodic: cell.periodic.to_vec(),
                corner: cell.origin.to_vec(),
                vectors: (0..D).map(column).collect(),
                rates: cell.velocity_gradient.iter().map(|row| row.to_vec()).collect(),
                mean_rates: cell.mean_velocity_gradient.iter().map(|row| row.to_vec()).collect(),
                motion: self.cell.virial[1].iter().map(|row| row.to_vec()).collect(),
            },
            bodies: self.clock.case.bodies.iter().map(|body| body.name.clone()).collect(),
            kinds: self.clock.case.bodies.iter().map(|body| body.material.clone()).collect(),
            walls: self.boundary.walls.iter().map(side).collect(),
            omitted_obstacles: moving.map(|wall| wall.name.clone()).collect(),
            has_bonds: self.laws.stage.pairs.iter().any(sticks),
            overlap,
        }
    }

    /// Table of the grains with their motion and forces.
    fn grain_rows(&self) -> Table {
        let (g, mut columns) = (self.grains, Vec::new());
        add_headings::<1>(&mut columns, "id", "");
        add_headings::<1>(&mut columns, "body", "");
        add_headings::<1>(&mut columns, "radius", "m");
        add_headings::<D>(&mut columns, "", "m");
        add_headings::<D>(&mut columns, "velocity", "m/s");
        add_headings::<R>(&mut columns, "spin", "rad/s");
        add_headings::<D>(&mut columns, "force", "N");
        add_headings::<R>(&mut columns, "torque", "N m");
        if !g.orientation.is_empty() {
            add_headings::<4>(&mut columns, "orientation", "");
        }
        let row = |i: usize| {
            let mut row = vec![f64::from(g.id[i]), f64::from(g.body[i]), g.radius[i]];
            row.extend(g.position[i]);
            row.extend(g.velocity[i]);
            row.extend(g.spin[i]);
            row.extend(g.force[i]);
            row.extend(g.torque[i]);
            row.extend(g.orientation.get(i).into_iter().flatten());
            row
        };
        Table { rows: (0..g.len()).map(row).collect(), columns }
    }

    /// Table of the contacts with their histories.
    fn contact_rows(&self) -> Table {
        let mut columns = Vec::new();
        for name in ["grain", "other", "wall", "state"] {
            add_headings::<1>(&mut columns, name, "");
        }
        add_headings::<R>(&mut columns, "slide", "m");
        add_headings::<1>(&mut columns, "dashpot", "N");
        if self.laws.columns.has_rolling {
            add_headings::<R>(&mut columns, "roll", "rad");
        }
        if self.laws.columns.has_rolling && R == 3 {
            add_headings::<1>(&mut columns, "twist", "rad");
        }
        if self.laws.columns.bonds {
            add_headings::<1>(&mut columns, "bond_strength", "");
            add_headings::<1>(&mut columns, "bond_tension", "N");
            add_headings::<R>(&mut columns, "bond_shear", "N");
            add_headings::<R>(&mut columns, "bond_bending", "N m");
            add_headings::<1>(&mut columns, "bond_twist", "N m");
        }
        let facets = !self.neighbours.walls.facet_key.is_empty();
        if facets {
            add_headings::<1>(&mut columns, "facet_high", "");
            add_headings::<1>(&mut columns, "facet_low", "");
            add_headings::<1>(&mut columns, "facet_distance", "m");
            add_headings::<3>(&mut columns, "facet_normal", "");
        }
        let (g, mut rows) = (self.grains, Vec::new());
        for pairs in [&self.neighbours.pairs.slab_pairs, &self.neighbours.pairs.periodic_pairs] {
            for (i, k) in pairs.first_grains().filter(|(_, k)| pairs.histories.is_kept(*k)) {
                let ends = [f64::from(g.id[i]), f64::from(g.id[pairs.second[k] as usize]), NO_INDEX];
                rows.push(row(
                    ends,
                    &pairs.histories,
                    k,
                    facets.then_some((0, FacetContact { distance: 0.0, normal: [0.0; 3] })),
                ));
            }
        }
        let near = &self.neighbours.walls;
        for k in (0..near.grain.len()).filter(|&k| near.history.is_kept(k)) {
            if self.boundary.walls[near.wall[k] as usize].motion.is_none() {
                let ends = [f64::from(g.id[near.grain[k] as usize]), NO_INDEX, f64::from(near.wall[k])];
                rows.push(row(
                    ends,
                    &near.history,
                    k,
                    near.facet_key.get(k).map(|key| (*key, near.facet[k])),
                ));
            }
        }
        Table { columns, rows }
    }
}

/// Table row of contact `k`; `ends` are the indices of its grain, other grain and wall.
fn row<const R: usize>(
    ends: [f64; 3],
    history: &ContactHistories<R>,
    k: usize,
    facet: Option<(u64, FacetContact)>,
) -> Vec<f64> {
    let own = history.get(k);
    let mut row = ends.to_vec();
    row.push(f64::from(own.state as u8));
    row.extend(own.shear_displacement);
    row.push(own.damping_force);
    row.extend(history.roll.get(k).into_iter().flatten());
    row.extend(history.twist.get(k));
    if let Some(bond) = history.bond.get(k) {
        row.extend([bond.strength, bond.tension]);
        row.extend(bond.shear);
        row.extend(bond.bending);
        row.push(bond.twist);
    }
    if let Some((key, FacetContact { distance, normal })) = facet {
        // An f64 represents integers of 53 bits.
        row.extend([(key >> 32) as f64, (key & 0xffff_ffff) as f64]);
        // Walls without facets have no distance.
        row.push(if distance.is_finite() { distance } else { 0.0 });
        row.extend(normal);
    }
    row
}
