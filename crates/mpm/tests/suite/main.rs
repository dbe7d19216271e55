//! Tests of the solver and its parts against closed forms, conservation laws and bitwise reproducibility, in the folders of the crate.

mod boundary;
mod contact;
mod examples;
mod mesh;
mod momentum;
mod obstacles;
mod phases;
mod points;
mod solver;
mod stress;
mod transfer;
