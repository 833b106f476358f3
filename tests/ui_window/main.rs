//! The window: driven by the names of its controls, its keys and its mouse, and looked at.

mod colours;
mod daylight;
mod doctor;
mod files;
mod lampless;
mod leaving;
mod microscope;
mod panels;
mod pictures;
mod requests;
mod scenes;
mod support;
