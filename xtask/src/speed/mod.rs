//! `cargo xtask bench`: point updates per second of methods and laws, compared with textbook kernels in the same program.

pub(crate) mod case;
pub(crate) mod laws;
pub(crate) mod mpm;
pub(crate) mod sph;
pub(crate) mod textbook_mpm;
