//! Pictures of frames of any kind.

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::{ForceChains, Picture, PointCloud};

/// Picture of a frame: points or lines.
#[derive(Clone, Debug, PartialEq)]
pub enum FramePicture {
    /// Points coloured by a field.
    Points(PointCloud),
    /// Lines of a width proportional to a field.
    Lines(ForceChains),
}

impl Picture for FramePicture {
    fn size(&self) -> (u32, u32) {
        match self {
            Self::Points(cloud) => cloud.size(),
            Self::Lines(chains) => chains.size(),
        }
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Result<(), String> {
        match self {
            Self::Points(cloud) => cloud.draw(area),
            Self::Lines(chains) => chains.draw(area),
        }
    }
}
