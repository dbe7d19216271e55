//! Shapes, sampling and neighbour search for point-based methods.

mod shape;

pub use shape::Shape;
