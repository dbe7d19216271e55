//! Points: sampling, domains, frames.

mod frames;
mod point_domains;
mod sampling;
