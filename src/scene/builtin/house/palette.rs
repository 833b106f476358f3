//! The house's materials: linear Rec. 709 reflectances of common finishes.

use crate::scene::builtin::writer::Paint;

// Linings of the rooms: only their front is ever lit.
pub(crate) const PLASTER: Paint = Paint::solid("plaster_white", [0.78, 0.76, 0.72]);
pub(crate) const CEILING: Paint = Paint::solid("ceiling_white", [0.82, 0.81, 0.79]);
pub(crate) const CLAY: Paint = Paint::solid("clay_plaster", [0.54, 0.43, 0.35]);
pub(crate) const TERRACOTTA: Paint = Paint::solid("terracotta_wall", [0.48, 0.20, 0.12]);
pub(crate) const DUSK_BLUE: Paint = Paint::solid("dusk_blue_wall", [0.20, 0.28, 0.38]);
pub(crate) const SAGE: Paint = Paint::solid("sage_wall", [0.40, 0.46, 0.36]);
pub(crate) const PINE_GREEN: Paint = Paint::solid("pine_green_wall", [0.11, 0.20, 0.16]);
pub(crate) const BATH_TILE: Paint = Paint::solid("petrol_tile", [0.14, 0.36, 0.38]);
pub(crate) const KITCHEN_TILE: Paint = Paint::solid("cream_tile", [0.74, 0.70, 0.60]);
pub(crate) const OAK_FLOOR: Paint = Paint::solid("oak_floor", [0.46, 0.35, 0.24]);
pub(crate) const STONE_FLOOR: Paint = Paint::solid("limestone_floor", [0.48, 0.44, 0.38]);
pub(crate) const SLATE_FLOOR: Paint = Paint::solid("slate_floor", [0.20, 0.21, 0.22]);

// Wood and painted joinery.
pub(crate) const OAK: Paint = Paint::solid("oak", [0.48, 0.34, 0.21]);
pub(crate) const WALNUT: Paint = Paint::solid("walnut", [0.20, 0.11, 0.06]);
pub(crate) const JOINERY: Paint = Paint::solid("joinery_white", [0.76, 0.75, 0.72]);
pub(crate) const SAGE_FRONT: Paint = Paint::solid("sage_front", [0.28, 0.38, 0.30]);
pub(crate) const DARK_FRAME: Paint = Paint::solid("anthracite_frame", [0.07, 0.07, 0.08]);

// Stone, ceramics, metal.
pub(crate) const WORKTOP: Paint = Paint::solid("worktop_stone", [0.60, 0.58, 0.54]);
pub(crate) const CERAMIC: Paint = Paint::solid("white_ceramic", [0.82, 0.82, 0.81]);
pub(crate) const BLACK: Paint = Paint::solid("black_metal", [0.05, 0.05, 0.05]);
pub(crate) const BRASS: Paint = Paint::solid("brass", [0.60, 0.43, 0.16]);
pub(crate) const STEEL: Paint = Paint::solid("steel", [0.50, 0.50, 0.51]);
pub(crate) const MIRROR: Paint = Paint::solid("mirror_glass", [0.66, 0.69, 0.69]);
/// A window with nothing lit behind it: of the light that falls on it little comes back.
pub(crate) const NIGHT_GLASS: Paint = Paint::solid("night_glass", [0.04, 0.045, 0.05]);
/// Double glazing with a coating that keeps heat in.
pub(crate) const WINDOW_GLASS: Paint = Paint::glass("window_glass", 0.78, 2);
pub(crate) const POT: Paint = Paint::solid("pot_terracotta", [0.52, 0.24, 0.14]);
pub(crate) const SOIL: Paint = Paint::solid("soil", [0.08, 0.06, 0.04]);
pub(crate) const LEAF: Paint = Paint::sheet("leaf", [0.12, 0.30, 0.08]);

// Textiles and paper.
pub(crate) const SOFA: Paint = Paint::solid("sofa_blue_grey", [0.16, 0.24, 0.31]);
pub(crate) const MUSTARD: Paint = Paint::solid("mustard_wool", [0.68, 0.42, 0.07]);
pub(crate) const RUST: Paint = Paint::solid("rust_wool", [0.48, 0.19, 0.10]);
pub(crate) const CREAM: Paint = Paint::solid("cream_wool", [0.72, 0.66, 0.55]);
pub(crate) const CHARCOAL: Paint = Paint::solid("charcoal_wool", [0.13, 0.13, 0.14]);
pub(crate) const LINEN: Paint = Paint::solid("bed_linen", [0.80, 0.77, 0.72]);
pub(crate) const BLUE_WOOL: Paint = Paint::solid("blue_wool", [0.10, 0.17, 0.36]);
pub(crate) const CURTAIN: Paint = Paint::sheet("linen_curtain", [0.66, 0.58, 0.47]);
pub(crate) const PAPER: Paint = Paint::solid("paper", [0.78, 0.75, 0.68]);
