//! Sums over neighbours: kernels, neighbour lists, pair data, gradients and their corrections.
//!
//! The module uses positions, masses and fields, no material law (sheet: sph §2.2, §2.3).
