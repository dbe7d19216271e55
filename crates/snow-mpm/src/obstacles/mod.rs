//! Obstacles on grid nodes: separation, friction and adhesion of the snow.

pub(crate) mod node_obstacles;
