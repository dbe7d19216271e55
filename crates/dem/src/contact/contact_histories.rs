//! Pairs of grains near each other, each once, with what their contacts remember.

use colluvium_points::struct_of_arrays;

use crate::contact::bond::Bond;
use crate::contact::{CONTACT_APART, ContactHistory, PairLaw};

/// Numbers of a spring across with its dashpot: as many as are read at once.
pub const SPRING_WIDTH: usize = 4;

struct_of_arrays! {
    /// What contacts remember, column by column. Columns that no law needs are empty.
    pub struct ContactHistories<const R: usize> {
        /// State of each contact.
        pub state: u8,
        /// The first `R`: see [`ContactHistory::shear_displacement`]. The last: see [`ContactHistory::damping_force`].
        pub spring: [f64; SPRING_WIDTH],
        /// See [`ContactHistory::rolling_angle`].
        pub roll: [f64; R],
        /// See [`ContactHistory::torsion_angle`].
        pub twist: f64,
        /// Bonds.
        pub bond: Bond<R>,
    }
}

/// Which columns there are beside those that all laws need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HistoryColumns {
    /// Springs against rolling and twisting.
    pub has_rolling: bool,
    /// Bonds.
    pub bonds: bool,
}

impl HistoryColumns {
    /// Those that these laws need.
    pub fn of(laws: &[PairLaw]) -> Self {
        Self {
            has_rolling: laws.iter().any(|law| law.rolling.is_some() || law.twisting.is_some()),
            bonds: laws.iter().any(|law| law.bond.is_some()),
        }
    }
}

impl<const R: usize> ContactHistories<R> {
    /// Forgets all, for `count` contacts.
    pub fn clear(&mut self, count: usize, columns: HistoryColumns) {
        let of = |on: bool| if on { count } else { 0 };
        fill(&mut self.state, count, CONTACT_APART);
        fill(&mut self.spring, count, [0.0; SPRING_WIDTH]);
        fill(&mut self.roll, of(columns.has_rolling), [0.0; R]);
        fill(&mut self.twist, of(columns.has_rolling && R == 3), 0.0);
        fill(&mut self.bond, of(columns.bonds), Bond::default());
    }

    /// What contact `k` remembers.
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

    /// Whether contact `k` has something to remember.
    #[inline]
    pub fn is_kept(&self, k: usize) -> bool {
        self.state[k] != CONTACT_APART || self.bond.get(k).is_some_and(|bond| bond.strength != 0.0)
    }

    /// Takes what another contact remembers, seen from the other side where `flip`.
    pub fn take(&mut self, k: usize, from: &Self, of: usize, flip: bool) {
        // In the plane slip is the same seen from either side, and a rotation is the opposite; in space both are.
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
            // About the normal, which is the opposite too.
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

    /// All of it, to be changed.
    pub fn view(&mut self) -> ContactHistoriesMut<'_, R> {
        ContactHistoriesMut {
            state: &mut self.state,
            spring: &mut self.spring,
            roll: &mut self.roll,
            twist: &mut self.twist,
            bond: &mut self.bond,
        }
    }

    /// Adds a contact that remembers what contact `of` of another list does.
    pub fn push(&mut self, from: &Self, of: usize) {
        self.state.push(from.state[of]);
        self.spring.push(from.spring[of]);
        self.roll.extend(from.roll.get(of));
        self.twist.extend(from.twist.get(of));
        self.bond.extend(from.bond.get(of));
    }
}

fn shear_displacement<const R: usize>(spring: &[f64; SPRING_WIDTH]) -> [f64; R] {
    std::array::from_fn(|c| spring[c])
}

fn fill<T: Clone>(column: &mut Vec<T>, count: usize, value: T) {
    column.clear();
    column.resize(count, value);
}

/// Part of what contacts remember, to be changed.
pub struct ContactHistoriesMut<'a, const R: usize> {
    /// State of each contact.
    pub state: &'a mut [u8],
    /// See [`ContactHistories::spring`].
    pub spring: &'a mut [[f64; SPRING_WIDTH]],
    /// Springs against rolling; empty where there are none.
    pub roll: &'a mut [[f64; R]],
    /// Springs against twisting; empty where there are none.
    pub twist: &'a mut [f64],
    /// Bonds.
    pub bond: &'a mut [Bond<R>],
}

fn cut<T>(column: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
    let at = at.min(column.len());
    column.split_at_mut(at)
}

impl<'a, const R: usize> ContactHistoriesMut<'a, R> {
    /// The same for a while.
    pub fn reborrow(&mut self) -> ContactHistoriesMut<'_, R> {
        ContactHistoriesMut {
            state: self.state,
            spring: self.spring,
            roll: self.roll,
            twist: self.twist,
            bond: self.bond,
        }
    }

    /// Parts before and from contact `at` on.
    pub fn split_at(self, at: usize) -> (Self, Self) {
        let (a, b) = cut(self.state, at);
        let (c, d) = cut(self.spring, at);
        let (g, h) = cut(self.roll, at);
        let (i, j) = cut(self.twist, at);
        let (k, l) = cut(self.bond, at);
        (
            Self { state: a, spring: c, roll: g, twist: i, bond: k },
            Self { state: b, spring: d, roll: h, twist: j, bond: l },
        )
    }

    /// What contact `k` remembers.
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

    /// Sets what contact `k` remembers.
    #[inline]
    pub fn set(&mut self, k: usize, memory: &ContactHistory<R>) {
        self.state[k] = memory.state;
        self.spring[k][..R].copy_from_slice(&memory.shear_displacement);
        self.spring[k][SPRING_WIDTH - 1] = memory.damping_force;
        if !self.roll.is_empty() {
            self.roll[k] = memory.rolling_angle;
        }
        if !self.twist.is_empty() {
            self.twist[k] = memory.torsion_angle;
        }
    }
}

/// Pairs under their first grain.
#[derive(Clone, Debug, Default)]
pub struct PairList<const R: usize> {
    /// Where the pairs of each grain begin, and their number.
    pub starts: Vec<u32>,
    /// The other grain.
    pub other: Vec<u32>,
    /// Which image of it; empty in a cell that does not repeat itself.
    pub image: Vec<u8>,
    /// What their contacts remember.
    pub histories: ContactHistories<R>,
}

/// Pairs without what their contacts remember; see [`PairList`].
#[derive(Clone, Copy)]
pub struct PairListView<'a> {
    /// Where the pairs of each grain begin, and their number.
    pub starts: &'a [u32],
    /// The other grain.
    pub other: &'a [u32],
    /// Which image of it; empty in a cell that does not repeat itself.
    pub image: &'a [u8],
}

impl<const R: usize> PairList<R> {
    /// The pairs, and what their contacts remember.
    pub fn view_and_histories(&mut self) -> (PairListView<'_>, ContactHistoriesMut<'_, R>) {
        let Self { starts, other, image, histories: memory } = self;
        (PairListView { starts, other, image }, memory.view())
    }

    /// The first grain of each pair, with the number of the pair.
    pub fn firsts(&self) -> impl Iterator<Item = (usize, usize)> {
        let rows = self.starts.windows(2).enumerate();
        rows.flat_map(|(i, ends)| (ends[0] as usize..ends[1] as usize).map(move |k| (i, k)))
    }
}
