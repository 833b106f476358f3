//! Tests against published tables, closed forms and quadrature.

mod cie_171;
mod openings;
mod picture;
mod skies;
mod sun;
mod weather;
