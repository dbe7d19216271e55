//! Adapters that make a finite-strain law of a return map in small strain: co-rotational rates and Hencky strain.
//!
//! A law in `laws` is wrapped by one of them (sheet: constitutive §3.2, §3.3).

pub(crate) mod corotational;
pub(crate) mod hencky;
pub(crate) mod wrapper;
