//! Tests of the solver and its parts against closed forms, conservation laws and bitwise reproducibility.

mod bands;
mod diagnostics;
mod flows;
mod interfaces;
mod liquids;
mod loads;
mod moving;
mod obstacles;
mod operators;
mod plates;
mod ranks;
mod regularisation;
mod rigid;
mod rings;
mod schemes;
mod smooth_bodies;
mod solids;
mod solver;
mod tensile;
mod walls;
