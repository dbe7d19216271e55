//! Momentum solve: consistent mass, and nodes of small mass.

mod consistent_mass;
mod small_mass_nodes;
