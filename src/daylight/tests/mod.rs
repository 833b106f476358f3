//! Tests against published tables, closed forms and quadrature.

mod cie_171;
mod openings;
mod skies;
mod sun;
mod weather;
