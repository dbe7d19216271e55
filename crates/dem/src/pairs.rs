//! Pairs of grains near each other, each once, with what their contacts remember.

use colluvium_points::columns;

use crate::contact::bond::Bond;
use crate::contact::{APART, Law, Memory};

/// Numbers of a spring across with its dashpot: as many as are read at once.
pub const SPRING: usize = 4;

columns! {
    /// What contacts remember, column by column. Columns that no law needs are empty.
    pub struct Memories<const R: usize> {
        /// State of each contact.
        pub state: u8,
        /// The first `R`: see [`Memory::slide`]. The last: see [`Memory::dash`].
        pub spring: [f64; SPRING],
        /// See [`Memory::roll`].
        pub roll: [f64; R],
        /// See [`Memory::twist`].
        pub twist: f64,
        /// Bonds.
        pub bond: Bond<R>,
    }
}

/// Which columns there are beside those that all laws need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    /// Springs against rolling and twisting.
    pub rolls: bool,
    /// Bonds.
    pub bonds: bool,
}

impl Columns {
    /// Those that these laws need.
    pub fn of(laws: &[Law]) -> Self {
        Self {
            rolls: laws.iter().any(|law| law.rolling.is_some() || law.twisting.is_some()),
            bonds: laws.iter().any(|law| law.bond.is_some()),
        }
    }
}

impl<const R: usize> Memories<R> {
    /// Forgets all, for `count` contacts.
    pub fn clear(&mut self, count: usize, columns: Columns) {
        let of = |on: bool| if on { count } else { 0 };
        fill(&mut self.state, count, APART);
        fill(&mut self.spring, count, [0.0; SPRING]);
        fill(&mut self.roll, of(columns.rolls), [0.0; R]);
        fill(&mut self.twist, of(columns.rolls && R == 3), 0.0);
        fill(&mut self.bond, of(columns.bonds), Bond::default());
    }

    /// What contact `k` remembers.
    #[inline]
    pub fn get(&self, k: usize) -> Memory<R> {
        Memory {
            state: self.state[k],
            slide: slide_of(&self.spring[k]),
            dash: self.spring[k][SPRING - 1],
            roll: self.roll.get(k).copied().unwrap_or([0.0; R]),
            twist: self.twist.get(k).copied().unwrap_or(0.0),
        }
    }

    /// Whether contact `k` has something to remember.
    #[inline]
    pub fn is_kept(&self, k: usize) -> bool {
        self.state[k] != APART || self.bond.get(k).is_some_and(|bond| bond.strength != 0.0)
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
        self.spring[k][SPRING - 1] = from.spring[of][SPRING - 1];
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
    pub fn view(&mut self) -> MemoriesMut<'_, R> {
        MemoriesMut {
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

fn slide_of<const R: usize>(spring: &[f64; SPRING]) -> [f64; R] {
    std::array::from_fn(|c| spring[c])
}

fn fill<T: Clone>(column: &mut Vec<T>, count: usize, value: T) {
    column.clear();
    column.resize(count, value);
}

/// Part of what contacts remember, to be changed.
pub struct MemoriesMut<'a, const R: usize> {
    /// State of each contact.
    pub state: &'a mut [u8],
    /// See [`Memories::spring`].
    pub spring: &'a mut [[f64; SPRING]],
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

impl<'a, const R: usize> MemoriesMut<'a, R> {
    /// The same for a while.
    pub fn again(&mut self) -> MemoriesMut<'_, R> {
        MemoriesMut {
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
    pub fn get(&self, k: usize) -> Memory<R> {
        Memory {
            state: self.state[k],
            slide: slide_of(&self.spring[k]),
            dash: self.spring[k][SPRING - 1],
            roll: if self.roll.is_empty() { [0.0; R] } else { self.roll[k] },
            twist: if self.twist.is_empty() { 0.0 } else { self.twist[k] },
        }
    }

    /// Sets what contact `k` remembers.
    #[inline]
    pub fn set(&mut self, k: usize, memory: &Memory<R>) {
        self.state[k] = memory.state;
        self.spring[k][..R].copy_from_slice(&memory.slide);
        self.spring[k][SPRING - 1] = memory.dash;
        if !self.roll.is_empty() {
            self.roll[k] = memory.roll;
        }
        if !self.twist.is_empty() {
            self.twist[k] = memory.twist;
        }
    }
}

/// Pairs under their first grain.
#[derive(Clone, Debug, Default)]
pub struct Pairs<const R: usize> {
    /// Where the pairs of each grain begin, and their number.
    pub starts: Vec<u32>,
    /// The other grain.
    pub other: Vec<u32>,
    /// Which image of it; empty in a cell that does not repeat itself.
    pub image: Vec<u8>,
    /// What their contacts remember.
    pub memory: Memories<R>,
}

/// Pairs without what their contacts remember; see [`Pairs`].
#[derive(Clone, Copy)]
pub struct Listed<'a> {
    /// Where the pairs of each grain begin, and their number.
    pub starts: &'a [u32],
    /// The other grain.
    pub other: &'a [u32],
    /// Which image of it; empty in a cell that does not repeat itself.
    pub image: &'a [u8],
}

impl<const R: usize> Pairs<R> {
    /// The pairs, and what their contacts remember.
    pub fn apart(&mut self) -> (Listed<'_>, MemoriesMut<'_, R>) {
        let Self { starts, other, image, memory } = self;
        (Listed { starts, other, image }, memory.view())
    }

    /// The first grain of each pair, with the number of the pair.
    pub fn firsts(&self) -> impl Iterator<Item = (usize, usize)> {
        let rows = self.starts.windows(2).enumerate();
        rows.flat_map(|(i, ends)| (ends[0] as usize..ends[1] as usize).map(move |k| (i, k)))
    }
}
