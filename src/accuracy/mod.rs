//! How wrong the answer is, found out by a witness that shares no sampling with it.
//!
//! # What is estimated
//!
//! Errors are those of irradiance (Rec. 709 luminance of it), as the root of their mean square over
//! the receiving area (all patches that neither shine nor lie buried, weighted by area), relative to
//! the irradiance there, or to its mean over that area where that is more. With H_i the stored
//! irradiance of patch i, B its radiosity, s(x) the irradiance that the picture shows at a point x
//! (direct light interpolated on its elements, the rest from patch values over the triangles; of
//! curved surfaces with their normals), D(x) its direct part, and K the true gathering operator over
//! the true polygons:
//!
//! * direct light: D(x) less what arrives from the lamps by themselves; left out of the next two;
//! * form factors and visibility: G_i - T_i, where G_i is gathered by the stored row from the patch
//!   radiosities, and T_i is the mean over the whole patch of what the witness gathers from the very
//!   same patchwise constant radiosities;
//! * mesh: (s(x) - G_i) - (K B_s(x) - T_i): what replacing a function by patch values does. It holds
//!   the shape that the picture gives to the light within a patch, and what a constant radiosity
//!   instead of B_s = E + rho s, the radiosity as shown, does to those who receive it;
//! * solver: what further sweeps would still change.
//!
//! The first three add up to s(x) - K B_s(x), the error of the picture in the rendering equation at one
//! gathering, whose mean square is estimated by itself: the total. The mean of an error is passed on
//! by later reflections, as a constant over the scene (see [`Interreflection`]); its fluctuations
//! cancel in the next gathering.
//!
//! # How
//!
//! Receivers are drawn stratified, and more often where the picture changes within a patch; each
//! counts by the inverse of its probability. The witness gathers by scrambled Sobol sequences, half
//! along the cosine and half towards the lamps, weighted by the balance heuristic (Veach & Guibas
//! 1995). Its own noise is not taken for the answer's error: every square is the product of two
//! deviations from two independent randomisations, whose expectation is the square alone.

mod algebraic;
mod audit;
mod interval;
mod map;
mod openings;
mod points;
mod sobol;
mod spread;
mod witness;

pub use algebraic::{AlgebraicError, algebraic_error};
pub use audit::{Answer, Audit, AuditSettings, Checked, ErrorBudget, Findings, Interreflection};
pub use interval::{Estimate, Sample, estimate};
pub use map::ErrorMap;
pub use points::{PointIrradiance, irradiance_at};
pub use sobol::Sobol;
pub use spread::{DARKEST, Dominant, LEVELS, Ranged, Spread};
pub use witness::{Receiver, Shown, Witness};
