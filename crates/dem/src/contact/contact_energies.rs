//! Sums over contacts: energies, counts and stress.

/// Stress times volume (J), one array per row.
pub type Virial<const D: usize> = [[f64; D]; D];

/// Sums over contacts (sheet: dem §2.14). Elastic energies are those at the time of the forces; the other sums accumulate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactEnergies {
    /// Elastic energy of overlaps (J).
    pub elastic: f64,
    /// Elastic energy of the tangential springs (J).
    pub elastic_tangential: f64,
    /// Elastic energy of the rolling and torsion springs (J).
    pub elastic_rolling: f64,
    /// Elastic energy of bonds (J).
    pub elastic_bonds: f64,
    /// Energy dissipated by friction in this step (J).
    pub friction: f64,
    /// Energy dissipated by dashpots (J).
    pub dashpots: f64,
    /// Energy dissipated by rolling and torsion resistance at its largest moment (J).
    pub rolling: f64,
    /// Energy lost where tangential springs are rescaled or their contact ends (J).
    pub spring_loss: f64,
    /// Work done against attraction (J); negative where attraction does work on the grains.
    pub attraction: f64,
    /// Energy of bonds that broke (J).
    pub broken: f64,
    /// Work of walls and of the periodic images of a moving cell on the grains (J).
    pub boundary: f64,
    /// Number of contacts with a force.
    pub contacts: u64,
    /// Number of contacts that slip.
    pub sliding: u64,
    /// Number of bonds that broke in this step.
    pub bonds_broken: u64,
    /// Sum of the squares of contact forces (N²).
    pub squares: f64,
    /// Largest overlap over the smaller radius.
    pub overlap: f64,
    /// First grain of the contact with the largest overlap.
    pub max_overlap_grain: u32,
}

impl ContactEnergies {
    /// Adds the sums over other contacts.
    pub fn add(&mut self, other: &Self) {
        self.elastic += other.elastic;
        self.elastic_tangential += other.elastic_tangential;
        self.elastic_rolling += other.elastic_rolling;
        self.elastic_bonds += other.elastic_bonds;
        self.friction += other.friction;
        self.dashpots += other.dashpots;
        self.rolling += other.rolling;
        self.spring_loss += other.spring_loss;
        self.attraction += other.attraction;
        self.broken += other.broken;
        self.boundary += other.boundary;
        self.contacts += other.contacts;
        self.sliding += other.sliding;
        self.bonds_broken += other.bonds_broken;
        self.squares += other.squares;
        if other.overlap > self.overlap {
            (self.overlap, self.max_overlap_grain) = (other.overlap, other.max_overlap_grain);
        }
    }
}
