//! Pair lists of grains near each other, each pair once, with the contact histories.

use colluvium_points::struct_of_arrays;

use crate::contact::bond::Bond;
use crate::contact::{ContactHistory, ContactState, PairLaw};

/// Number of values in the record of a tangential spring and its damping force, which a SIMD load reads.
pub const SPRING_WIDTH: usize = 4;

struct_of_arrays! {
    /// Contact histories, column by column. Columns that no law needs are empty.
    pub struct ContactHistories<const R: usize> {
        /// State of each contact.
        pub state: ContactState,
        /// Records of the tangential springs: [`ContactHistory::shear_displacement`] in the first `R` values (m),
        /// [`ContactHistory::damping_force`] in the last one (N).
        pub spring: [f64; SPRING_WIDTH],
        /// Rolling angle (rad), see [`ContactHistory::rolling_angle`].
        pub roll: [f64; R],
        /// Torsion angle (rad), see [`ContactHistory::torsion_angle`].
        pub twist: f64,
        /// Bonds.
        pub bond: Bond<R>,
    }
}

/// Optional columns of the contact histories.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HistoryColumns {
    /// Whether the histories have columns for rolling and torsion springs.
    pub has_rolling: bool,
    /// Whether the histories have a column for bonds.
    pub bonds: bool,
}

impl HistoryColumns {
    /// Columns that a set of contact laws needs.
    pub fn for_laws(laws: &[PairLaw]) -> Self {
        Self {
            has_rolling: laws.iter().any(|law| law.rolling.is_some() || law.torsion.is_some()),
            bonds: laws.iter().any(|law| law.bond.is_some()),
        }
    }
}

impl<const R: usize> ContactHistories<R> {
    /// Resets the histories to those of `count` new contacts.
    pub fn clear(&mut self, count: usize, columns: HistoryColumns) {
        let of = |on: bool| if on { count } else { 0 };
        fill(&mut self.state, count, ContactState::Apart);
        fill(&mut self.spring, count, [0.0; SPRING_WIDTH]);
        fill(&mut self.roll, of(columns.has_rolling), [0.0; R]);
        fill(&mut self.twist, of(columns.has_rolling && R == 3), 0.0);
        fill(&mut self.bond, of(columns.bonds), Bond::default());
    }

    /// History of contact `k`.
    #[inline]
    pub fn get(&self, k: usize) -> ContactHistory<R> {
        ContactHistory {
            state: self.state[k],
            shear_displacement: shear_displacement(&self.spring[k]),
            damping_force: self.spring[k][SPRING_WIDTH - 1],
            rolling_angle: self.roll.get(k).copied().unwrap_or([0.0; R]),
            torsion_angle: self.twist.get(k).copied().unwrap_or(0.0),
        }
    }

    /// Whether contact `k` has a history.
    #[inline]
    pub fn is_kept(&self, k: usize) -> bool {
        self.state[k] != ContactState::Apart || self.bond.get(k).is_some_and(|bond| bond.strength != 0.0)
    }

    /// Copies the history of another contact. With `flip` the two grains of the contact are exchanged.
    pub fn copy_from(&mut self, k: usize, from: &Self, of: usize, flip: bool) {
        // Seen from the other grain, in the plane slip is unchanged and a rotation changes sign; in space both change sign.
        let (slide, turn) = match (flip, R) {
            (false, _) => (1.0, 1.0),
            (true, 1) => (1.0, -1.0),
            (true, _) => (-1.0, -1.0),
        };
        self.state[k] = from.state[of];
        self.spring[k] = from.spring[of].map(|c| slide * c);
        self.spring[k][SPRING_WIDTH - 1] = from.spring[of][SPRING_WIDTH - 1];
        if !self.roll.is_empty() {
            self.roll[k] = from.roll[of].map(|c| turn * c);
        }
        if !self.twist.is_empty() {
            // The twist is about the normal, which changes sign too.
            self.twist[k] = from.twist[of];
        }
        if !self.bond.is_empty() {
            let bond = from.bond[of];
            self.bond[k] = Bond {
                shear: bond.shear.map(|c| slide * c),
                bending: bond.bending.map(|c| turn * c),
                ..bond
            };
        }
    }

    /// Mutable view of all histories.
    pub fn view(&mut self) -> ContactHistoriesMut<'_, R> {
        ContactHistoriesMut {
            state: &mut self.state,
            spring: &mut self.spring,
            roll: &mut self.roll,
            twist: &mut self.twist,
            bond: &mut self.bond,
        }
    }

    /// Appends the history of contact `of` of another list.
    pub fn push(&mut self, from: &Self, of: usize) {
        self.state.push(from.state[of]);
        self.spring.push(from.spring[of]);
        self.roll.extend(from.roll.get(of));
        self.twist.extend(from.twist.get(of));
        self.bond.extend(from.bond.get(of));
    }
}

/// Shear displacement of a stored spring (m).
fn shear_displacement<const R: usize>(spring: &[f64; SPRING_WIDTH]) -> [f64; R] {
    std::array::from_fn(|c| spring[c])
}

/// Sets a column to `count` copies of a value.
fn fill<T: Clone>(column: &mut Vec<T>, count: usize, value: T) {
    column.clear();
    column.resize(count, value);
}

/// Mutable view of the histories of a range of contacts.
pub struct ContactHistoriesMut<'a, const R: usize> {
    /// State of each contact.
    pub state: &'a mut [ContactState],
    /// Tangential springs, see [`ContactHistories::spring`].
    pub spring: &'a mut [[f64; SPRING_WIDTH]],
    /// Rolling springs; empty without rolling resistance.
    pub roll: &'a mut [[f64; R]],
    /// Torsion springs; empty without torsion resistance.
    pub twist: &'a mut [f64],
    /// Bonds.
    pub bond: &'a mut [Bond<R>],
}

/// Splits a column at an index; an empty column is split into two empty ones.
fn split_column<T>(column: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
    let at = at.min(column.len());
    column.split_at_mut(at)
}

impl<'a, const R: usize> ContactHistoriesMut<'a, R> {
    /// Reborrows the view.
    pub fn reborrow(&mut self) -> ContactHistoriesMut<'_, R> {
        ContactHistoriesMut {
            state: self.state,
            spring: self.spring,
            roll: self.roll,
            twist: self.twist,
            bond: self.bond,
        }
    }

    /// Splits the view before the contact with index `at`.
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let (a, b) = split_column(self.state, at);
        let (c, d) = split_column(self.spring, at);
        let (g, h) = split_column(self.roll, at);
        let (i, j) = split_column(self.twist, at);
        let (k, l) = split_column(self.bond, at);
        (
            Self { state: a, spring: c, roll: g, twist: i, bond: k },
            Self { state: b, spring: d, roll: h, twist: j, bond: l },
        )
    }

    /// History of contact `k`.
    #[inline]
    pub fn get(&self, k: usize) -> ContactHistory<R> {
        ContactHistory {
            state: self.state[k],
            shear_displacement: shear_displacement(&self.spring[k]),
            damping_force: self.spring[k][SPRING_WIDTH - 1],
            rolling_angle: if self.roll.is_empty() { [0.0; R] } else { self.roll[k] },
            torsion_angle: if self.twist.is_empty() { 0.0 } else { self.twist[k] },
        }
    }

    /// Sets the history of contact `k`.
    #[inline]
    pub fn set(&mut self, k: usize, history: &ContactHistory<R>) {
        self.state[k] = history.state;
        self.spring[k][..R].copy_from_slice(&history.shear_displacement);
        self.spring[k][SPRING_WIDTH - 1] = history.damping_force;
        if !self.roll.is_empty() {
            self.roll[k] = history.rolling_angle;
        }
        if !self.twist.is_empty() {
            self.twist[k] = history.torsion_angle;
        }
    }
}

/// Pair list, ordered by the first grain.
#[derive(Clone, Debug, Default)]
pub struct PairList<const R: usize> {
    /// First pair of each grain, and the number of pairs.
    pub row_offsets: Vec<u32>,
    /// Second grain of each pair.
    pub second: Vec<u32>,
    /// Image index of the second grain; empty in a cell that is not periodic.
    pub image: Vec<u8>,
    /// Contact histories of the pairs.
    pub histories: ContactHistories<R>,
}

/// View of a pair list without its contact histories; see [`PairList`].
#[derive(Clone, Copy)]
pub struct PairListView<'a> {
    /// First pair of each grain, and the number of pairs.
    pub row_offsets: &'a [u32],
    /// Second grain of each pair.
    pub second: &'a [u32],
    /// Image index of the second grain; empty in a cell that is not periodic.
    pub image: &'a [u8],
}

impl<const R: usize> PairList<R> {
    /// Views of the pairs and of their contact histories.
    pub fn view_and_histories(&mut self) -> (PairListView<'_>, ContactHistoriesMut<'_, R>) {
        let Self { row_offsets, second, image, histories: history } = self;
        (PairListView { row_offsets, second, image }, history.view())
    }

    /// First grain of each pair, with the number of the pair.
    pub fn first_grains(&self) -> impl Iterator<Item = (usize, usize)> {
        let rows = self.row_offsets.windows(2).enumerate();
        rows.flat_map(|(i, ends)| (ends[0] as usize..ends[1] as usize).map(move |k| (i, k)))
    }
}
