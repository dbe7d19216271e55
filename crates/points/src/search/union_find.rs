//! Union–find: disjoint sets that are merged pair by pair.

/// Disjoint sets of the numbers from zero on. The smallest number of a set is its root, so that the result does not depend on the order of
/// merges.
#[derive(Clone, Debug, Default)]
pub struct UnionFind {
    /// Number of the same set that is no larger.
    parent: Vec<u32>,
}

impl UnionFind {
    /// `count` sets of one number each.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// Root (smallest number) of the set of `of`.
    pub fn root(&mut self, of: usize) -> usize {
        let mut of = of as u32;
        while self.parent[of as usize] != of {
            // Path halving.
            let next = self.parent[self.parent[of as usize] as usize];
            self.parent[of as usize] = next;
            of = next;
        }
        of as usize
    }

    /// Merges the sets of two numbers.
    pub fn union(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_independent_of_the_order_of_unions() {
        let pairs = [(7, 3), (1, 2), (3, 8), (2, 7), (5, 6)];
        let of = |order: &mut dyn Iterator<Item = &(usize, usize)>| {
            let mut pieces = UnionFind::new(9);
            order.for_each(|(a, b)| pieces.union(*a, *b));
            (0..9).map(|k| pieces.root(k)).collect::<Vec<_>>()
        };
        let exact = [0, 1, 1, 1, 4, 5, 5, 1, 1];
        assert_eq!(of(&mut pairs.iter()), exact);
        assert_eq!(of(&mut pairs.iter().rev()), exact);
    }
}
