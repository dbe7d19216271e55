//! Contact histories and wall positions of a specimen file.

use std::collections::{HashMap, HashSet};

use colluvium_case::{Case, CaseError};

use crate::boundary::controlled_cell::ControlledCell;
use crate::boundary::periodic_cell::PeriodicCell;
use crate::boundary::walls::RigidWall;
use crate::contact::ContactState;
use crate::contact::bond::Bond;
use crate::contact::contact_histories::{ContactHistories, HistoryColumns, PairList, SPRING_WIDTH};
use crate::neighbours::grain_neighbours::GrainNeighbours;
use crate::neighbours::wall_list::WallList;
use crate::obstacles::facet::{FacetContact, NO_FACET};
use crate::points::grains::Grains;
use crate::specimen::file::read::{NamedTable, columns_of_row};
use crate::specimen::file::{KEY, NO_INDEX, StoredSpecimen};
use crate::specimen::specimen_preparation::SpecimenSource;
use colluvium_case::Warning;

/// Number of values of half of a facet key, `2³²`.
const HALF_KEY_VALUES: u64 = 1 << 32;

/// Column indices of a contact history.
struct HistoryColumnIndices<const R: usize> {
    state: usize,
    slide: [usize; R],
    dashpot: usize,
    roll: Option<[usize; R]>,
    twist: Option<usize>,
    bond: Option<BondColumnIndices<R>>,
}

/// Column indices of a bond.
struct BondColumnIndices<const R: usize> {
    strength: usize,
    tension: usize,
    shear: [usize; R],
    bending: [usize; R],
    twist: usize,
}

impl<const R: usize> BondColumnIndices<R> {
    /// Indices of the bond columns in a table of contacts.
    fn new(rows: &NamedTable<'_>) -> Result<Self, String> {
        Ok(Self {
            strength: rows.column("bond_strength")?,
            tension: rows.column("bond_tension")?,
            shear: rows.columns("bond_shear")?,
            bending: rows.columns("bond_bending")?,
            twist: rows.column("bond_twist")?,
        })
    }

    /// Bond of a row of the table.
    fn read_bond(&self, row: &[f64]) -> Bond<R> {
        Bond {
            strength: row[self.strength],
            tension: row[self.tension],
            shear: columns_of_row(row, &self.shear),
            bending: columns_of_row(row, &self.bending),
            twist: row[self.twist],
        }
    }
}

impl<const R: usize> HistoryColumnIndices<R> {
    /// Indices of the contact-history columns in a table of contacts.
    fn new(rows: &NamedTable<'_>) -> Result<Self, String> {
        let rolls = rows.has_column(&crate::specimen::file::names::<R>("roll")[0]);
        let twist = rows.has_column("twist").then(|| rows.column("twist")).transpose()?;
        let bond = rows.has_column("bond_strength").then(|| BondColumnIndices::new(rows)).transpose()?;
        Ok(Self {
            state: rows.column("state")?,
            slide: rows.columns("slide")?,
            dashpot: rows.column("dashpot")?,
            roll: rolls.then(|| rows.columns("roll")).transpose()?,
            twist,
            bond,
        })
    }

    /// Adds a contact with the history in a row of the table, in the columns that the laws of the case need.
    fn push(
        &self,
        rows: &NamedTable<'_>,
        number: usize,
        history: &mut ContactHistories<R>,
    ) -> Result<(), String> {
        let k = history.len();
        let row = &rows.table.rows[number];
        let state = rows.integer(number, self.state, ContactState::Bonded as u64 + 1)?;
        history.state.push(ContactState::from_number(state).unwrap_or_default());
        let mut spring = [0.0; SPRING_WIDTH];
        spring[..R].copy_from_slice(&columns_of_row(row, &self.slide));
        spring[SPRING_WIDTH - 1] = row[self.dashpot];
        history.spring.push(spring);
        if let (Some(roll), Some(own)) = (history.roll.get_mut(k), &self.roll) {
            *roll = columns_of_row(row, own);
        }
        if let (Some(twist), Some(own)) = (history.twist.get_mut(k), self.twist) {
            *twist = row[own];
        }
        if let (Some(bond), Some(own)) = (history.bond.get_mut(k), &self.bond) {
            *bond = own.read_bond(row);
        }
        Ok(())
    }
}

impl StoredSpecimen {
    /// Length of the last step of the run that wrote the file (s).
    ///
    /// # Errors
    /// When it is negative or not a number.
    pub fn last_step(&self, case: &Case) -> Result<f64, CaseError> {
        if !(self.head.step >= 0.0) {
            return Err(self.file_error(
                case,
                &format!("its last time step, {} s, must not be negative", self.head.step),
            ));
        }
        Ok(self.head.step)
    }

    /// Restores contact histories, wall positions and the kinetic stress of the cell, for grains that have no lists yet, and adds the notes
    /// for the user.
    ///
    /// # Errors
    /// When the contacts or walls of the file fit neither its grains nor the case.
    pub fn restore_contacts<const D: usize, const R: usize>(
        &self,
        case: &Case,
        (grains, columns): (&Grains<D, R>, HistoryColumns),
        cell: &mut ControlledCell<D>,
        walls: &mut [RigidWall<D>],
        neighbours: &mut GrainNeighbours<D, R>,
        source: &mut SpecimenSource,
    ) -> Result<(), CaseError> {
        let failed = |problem: String| self.file_error(case, &problem);
        cell.virial[1] = std::array::from_fn(|row| std::array::from_fn(|k| self.head.cell.motion[row][k]));
        let counts = self.counts();
        source.bodies = case.bodies.iter().map(|body| counts.contains_key(body.name.as_str())).collect();
        (source.has_bonds, source.overlap) = (self.head.has_bonds, self.head.overlap);
        let mut notes: Vec<Warning> = self.cell_note::<D>(case).into_iter().collect();
        let numbers = self.place_walls(case, &cell.geometry, walls, &mut notes).map_err(failed)?;
        let lost = self.restore_histories(grains, columns, &numbers, neighbours).map_err(failed)?;
        notes.extend(self.missing_contact_notes(&lost, columns));
        source.notes = notes;
        Ok(())
    }

    /// Notes on contacts of the file that the case does not have.
    fn missing_contact_notes(&self, lost: &[usize], columns: HistoryColumns) -> Vec<Warning> {
        let mut notes = Vec::new();
        for (wall, count) in self.head.walls.iter().zip(lost).filter(|(_, count)| **count > 0) {
            notes.push(Warning::new(
                "specimen-contacts-lost",
                format!(
                    "{KEY}: {count} contacts of the specimen are with the wall {:?}, which the case does not \
                 have: they are left out. Give the case that wall, or let the specimen come to rest again",
                    wall.name
                ),
            ));
        }
        for name in &self.head.omitted_obstacles {
            notes.push(Warning::new("specimen-contacts-lost", format!(
                "{KEY}: the contacts with the obstacle {name:?}, which moved, start without their history. \
                 Let the specimen come to rest again"
            )));
        }
        if self.contacts.columns.iter().any(|(name, _)| name == "bond_strength") && !columns.bonds {
            notes.push(Warning::new(
                "specimen-contacts-lost",
                format!(
                    "{KEY}: grains are bonded in the specimen, but no pair of the case has a \
                               `bond`: the bonds are left out. Give the pair its bond to keep them"
                ),
            ));
        }
        notes
    }

    /// Moves the walls to their stored positions; returns the number of each wall of the file.
    fn place_walls<const D: usize>(
        &self,
        case: &Case,
        cell: &PeriodicCell<D>,
        walls: &mut [RigidWall<D>],
        notes: &mut Vec<Warning>,
    ) -> Result<Vec<Option<u32>>, String> {
        let shift = self.shift::<D>(case);
        let mut numbers = Vec::new();
        for side in &self.head.walls {
            let found = walls.iter().position(|wall| wall.name == side.name);
            numbers.push(found.map(|number| number as u32));
            let Some(wall) = found.map(|number| &mut walls[number]) else { continue };
            let own = wall.surface.is_none().then_some((wall.axis, wall.is_upper));
            if own != side.plane.map(|(axis, upper, _)| (axis, upper)) || side.velocity.len() != D {
                return Err(format!(
                    "its wall {:?} is on another side in the case, or is a wall in one and an obstacle in \
                     the other",
                    side.name
                ));
            }
            let Some((axis, _, position)) = side.plane else { continue };
            let position = position + shift[axis];
            if (position - wall.position).abs() > 1e-9 * cell.h[axis][axis].abs() {
                notes.push(Warning::new("specimen-wall-moved", format!(
                    "{KEY}: the wall {:?} starts at {position} m, its position in the specimen, instead of \
                     {} m",
                    side.name, wall.position
                )));
            }
            wall.position = position;
            wall.velocity = std::array::from_fn(|c| side.velocity[c]);
        }
        Ok(numbers)
    }

    /// Lists the contacts with their histories; returns the number of contacts of each wall of the file that the case does not have.
    fn restore_histories<const D: usize, const R: usize>(
        &self,
        grains: &Grains<D, R>,
        columns: HistoryColumns,
        walls: &[Option<u32>],
        neighbours: &mut GrainNeighbours<D, R>,
    ) -> Result<Vec<usize>, String> {
        let rows = NamedTable::new("the contacts", &self.contacts)?;
        let [grain, other, wall] = [rows.column("grain")?, rows.column("other")?, rows.column("wall")?];
        let places = HistoryColumnIndices::<R>::new(&rows)?;
        let at: HashMap<u32, u32> = (0u32..).zip(&grains.id).map(|(i, id)| (*id, i)).collect();
        let find = |number: usize, column: usize| {
            let id = rows.integer(number, column, u64::from(u32::MAX))?;
            at.get(&id)
                .copied()
                .ok_or_else(|| format!("row {} of the contacts: there is no grain {id}", number + 1))
        };
        let (mut pairs, mut known_pairs, mut lost) = (Vec::new(), HashSet::new(), vec![0; walls.len()]);
        let mut of_walls = Vec::new();
        for (number, row) in rows.table.rows.iter().enumerate() {
            let i = find(number, grain)?;
            if row[other] == NO_INDEX {
                let side = rows.integer(number, wall, walls.len() as u64)? as usize;
                match walls[side] {
                    Some(wall) => of_walls.push((i, wall, number)),
                    None => lost[side] += 1,
                }
                continue;
            }
            let j = find(number, other)?;
            if i == j || !known_pairs.insert((i.min(j), i.max(j))) {
                return Err(format!(
                    "row {} of the contacts: the contact is of a grain with itself, or repeats an earlier \
                     row",
                    number + 1
                ));
            }
            pairs.push((i, j, number));
        }
        neighbours.pairs.slab_pairs = pair_list((grains.len(), columns), &rows, &places, pairs)?;
        neighbours.pairs.active_pairs.clear();
        list_walls((&mut neighbours.walls, columns), &rows, &places, of_walls)?;
        Ok(lost)
    }
}

/// Resets the histories to empty ones of `count` contacts.
fn empty<const R: usize>(history: &mut ContactHistories<R>, count: usize, columns: HistoryColumns) {
    history.clear(count, columns);
    history.state.clear();
    history.spring.clear();
}

/// Pair list of `count` grains, from the grains and the table row of each pair.
fn pair_list<const R: usize>(
    (count, columns): (usize, HistoryColumns),
    rows: &NamedTable<'_>,
    places: &HistoryColumnIndices<R>,
    mut pairs: Vec<(u32, u32, usize)>,
) -> Result<PairList<R>, String> {
    pairs.sort_unstable();
    let mut list = PairList { row_offsets: vec![0; count + 1], ..PairList::default() };
    empty(&mut list.histories, pairs.len(), columns);
    for (i, j, number) in pairs {
        list.row_offsets[i as usize + 1] += 1;
        list.second.push(j);
        places.push(rows, number, &mut list.histories)?;
    }
    for i in 0..count {
        list.row_offsets[i + 1] += list.row_offsets[i];
    }
    Ok(list)
}

/// Adds wall contacts to the list, from the grain, wall and table row of each contact.
fn list_walls<const R: usize>(
    (near, columns): (&mut WallList<R>, HistoryColumns),
    rows: &NamedTable<'_>,
    places: &HistoryColumnIndices<R>,
    of_walls: Vec<(u32, u32, usize)>,
) -> Result<(), String> {
    empty(&mut near.history, of_walls.len(), columns);
    let facets = FacetColumnIndices::new(rows)?;
    for (i, wall, number) in of_walls {
        near.grain.push(i);
        near.wall.push(wall);
        places.push(rows, number, &mut near.history)?;
        if let Some(facets) = &facets {
            let (key, facet) = facets.read_facet(rows, number)?;
            near.facet_key.push(key);
            near.facet.push(facet);
        }
    }
    Ok(())
}

/// Column indices of a facet.
struct FacetColumnIndices {
    key: [usize; 2],
    distance: usize,
    normal: [usize; 3],
}

impl FacetColumnIndices {
    /// Finds the columns; `None` where no contact has a facet.
    fn new(rows: &NamedTable<'_>) -> Result<Option<Self>, String> {
        if !rows.has_column("facet_high") {
            return Ok(None);
        }
        let key = [rows.column("facet_high")?, rows.column("facet_low")?];
        Ok(Some(Self {
            key,
            distance: rows.column("facet_distance")?,
            normal: rows.columns("facet_normal")?,
        }))
    }

    /// Facet key of a table row, with distance and normal of the facet.
    fn read_facet(&self, rows: &NamedTable<'_>, number: usize) -> Result<(u64, FacetContact), String> {
        let [high, low] = [
            rows.integer(number, self.key[0], HALF_KEY_VALUES)?,
            rows.integer(number, self.key[1], HALF_KEY_VALUES)?,
        ];
        let key = u64::from(high) << 32 | u64::from(low);
        let row = &rows.table.rows[number];
        let facet = FacetContact { distance: row[self.distance], normal: columns_of_row(row, &self.normal) };
        Ok((key, if key == NO_FACET { FacetContact::OUT_OF_REACH } else { facet }))
    }
}
