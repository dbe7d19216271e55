//! State of a contact, and its history: springs and damping force.

use colluvium_points::struct_of_arrays::FixedBytes;

/// State and springs of a contact, which continue from step to step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactHistory<const R: usize> {
    /// State of the contact: separate, in contact or bonded.
    pub state: ContactState,
    /// Elongation of the tangential spring in tangent coordinates (m).
    pub shear_displacement: [f64; R],
    /// Dissipative part of the normal force in the last step (N).
    pub damping_force: f64,
    /// Elongation of the rolling spring (rad).
    pub rolling_angle: [f64; R],
    /// Elongation of the torsion spring (rad).
    pub torsion_angle: f64,
}

/// State of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum ContactState {
    /// Pair without contact.
    #[default]
    Apart = 0,
    /// Pair in contact.
    Touching = 1,
    /// Contact with intact cohesion.
    Bonded = 2,
}

impl ContactState {
    /// Contact state of its number in a file; `None` for other numbers.
    pub fn from_number(number: u32) -> Option<Self> {
        [Self::Apart, Self::Touching, Self::Bonded].into_iter().find(|state| *state as u32 == number)
    }
}

impl FixedBytes for ContactState {
    const BYTE_COUNT: usize = 1;

    fn append_bytes(self, out: &mut Vec<u8>) {
        out.push(self as u8);
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        Self::from_number(u32::from(bytes[0])).unwrap_or_default()
    }
}

impl<const R: usize> Default for ContactHistory<R> {
    fn default() -> Self {
        Self {
            state: ContactState::Apart,
            shear_displacement: [0.0; R],
            damping_force: 0.0,
            rolling_angle: [0.0; R],
            torsion_angle: 0.0,
        }
    }
}
