//! Contact between bodies (sheet: mpm §2.12).

mod body_contact;
mod mesh_contact;
