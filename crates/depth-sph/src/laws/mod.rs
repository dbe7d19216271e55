//! Laws of the material: drag between phases, erosion, pore pressure of a column, resistance that grows with the speed.
//!
//! A law is a function of numbers; it knows neither nodes nor neighbours (sheet: depth-sph §2.4 to §2.8).

pub mod erosion;
pub mod implicit_resistance;
pub mod interphase_drag;
pub mod pore_pressure_column;
