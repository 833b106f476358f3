//! The window: driven by the names of its controls, its keys and its mouse, and looked at.

mod doctor;
mod files;
mod microscope;
mod panels;
mod pictures;
mod requests;
mod support;
