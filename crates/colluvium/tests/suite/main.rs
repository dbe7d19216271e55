//! The facade and the command line as their users meet them. What has to be alone in its process stands beside this suite.

mod broken_files;
mod cli;
mod compare;
mod debris_flow;
mod elements;
mod grains;
mod library;
mod methods_agree;
mod points;
mod reference;
mod strength;
