//! Photometric files of luminaires: readers of IES LM-63 and EULUMDAT, and the mathematics of what they hold.
//!
//! [`read`] identifies the format from the content and returns a [`Photometry`] for either: a
//! [`Distribution`] of luminous intensity over the sphere, the luminous [`Opening`], the stated flux, and the
//! descriptive texts.
//!
//! Sources of the formats: LM-63 in its editions of 1986, 1991, 1995, 2002 and 2019; I. Ashdown, "Parsing the
//! IESNA LM-63 photometric data file" (1998); A. Stockmar, "EULUMDAT" (1990) and "EULUMDAT/2" (1998).

mod description;
mod distribution;
mod error;
mod eulumdat;
mod ies;
mod ies_web;
mod made;
mod measures;
mod opening;
mod planes;
mod summary;
mod text;
mod tilt;

#[cfg(test)]
mod tests;

pub use description::Description;
pub use distribution::{Distribution, Peak, direction};
pub use error::{InvalidDistribution, ReadError};
pub use made::MadeKind;
pub use measures::{MainPlane, Spread, Zone};
pub use opening::{Opening, OpeningShape};
pub use summary::{FLUX_TOLERANCE, FluxCheck, Summary};
pub use tilt::{LampPosition, Tilt};

use error::Fault;
use glam::DVec3;

/// Larger files are not photometric files.
const MOST_BYTES: usize = 8 << 20;

/// Where the numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// IES LM-63 of the edition of `year`: 1986, 1991, 1995, 2002 or 2019.
    Lm63 {
        /// Year of the edition.
        year: u16,
    },
    /// EULUMDAT.
    Eulumdat,
    /// Made by the program.
    Made,
}

/// One set of lamps of a luminaire.
#[derive(Clone, Debug, PartialEq)]
pub struct LampSet {
    /// Number of lamps; 0 or more.
    pub count: f64,
    /// Type of lamp, empty where the file has none.
    pub kind: String,
    /// Luminous flux of all lamps of the set in lumens; none where the photometry is absolute.
    pub lumens: Option<f64>,
    /// Colour as the file words it: a temperature or a name.
    pub colour: String,
    /// Colour rendering as the file words it.
    pub rendering: String,
    /// Electric power in watts with ballast.
    pub watts: f64,
}

/// Outer size of a luminaire in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Housing {
    /// Extent along C0-C180, metres.
    pub along_c0: f64,
    /// Extent along C90-C270, metres.
    pub along_c90: f64,
    /// Extent upwards, metres.
    pub height: f64,
    /// Whether it is round as seen from below.
    pub round: bool,
}

/// A photometric file, whatever its format.
#[derive(Clone, Debug, PartialEq)]
pub struct Photometry {
    /// The format.
    pub format: Format,
    /// The texts.
    pub description: Description,
    /// Intensities in candela, with all factors of the file applied except [`Photometry::tilt`].
    pub distribution: Distribution,
    /// The luminous opening. Makers disagree on the axis of a luminaire's length: between files of LM-63 and
    /// EULUMDAT of one luminaire, C commonly differs by 90 degrees.
    pub opening: Opening,
    /// Outer size, where the file has it.
    pub housing: Option<Housing>,
    /// The lamps, one entry per set.
    pub lamps: Vec<LampSet>,
    /// Flux of the luminaire in lumens as the file states it, with lamps and ballast taken into account; none
    /// where the file states none (absolute photometry of LM-63) or only that of its lamps.
    pub stated_flux: Option<f64>,
    /// Flux of all lamps in lumens, ballast factor included; none where the photometry is absolute.
    pub lamp_flux: Option<f64>,
    /// Share of the flux below the horizontal as the file states it (EULUMDAT DFF), 0 to 1.
    pub stated_downward_share: Option<f64>,
    /// Electric power in watts, 0 where the file leaves it out.
    pub watts: f64,
    /// How the light depends on the tilt of the luminaire, where the file says so.
    pub tilt: Option<Tilt>,
    /// Tilt of the luminaire during the measurement, degrees (EULUMDAT). The intensities are those of the
    /// tilted luminaire.
    pub measurement_tilt: f64,
    /// What the reader assumed, corrected or ignored; one sentence each, without a full stop.
    pub notes: Vec<String>,
}

impl Photometry {
    /// Photometry made by the program rather than read from a file.
    pub fn made(name: &str, distribution: Distribution, opening: Opening) -> Self {
        Self {
            format: Format::Made,
            description: Description { luminaire: name.to_owned(), ..Description::default() },
            distribution,
            opening,
            housing: None,
            lamps: Vec::new(),
            stated_flux: None,
            lamp_flux: None,
            stated_downward_share: None,
            watts: 0.0,
            tilt: None,
            measurement_tilt: 0.0,
            notes: Vec::new(),
        }
    }

    /// Intensity in candela in the direction `e` of any length that points away from the luminaire, in its
    /// frame: nadir -z, C0 +x, C90 +y.
    pub fn intensity(&self, e: DVec3) -> f64 {
        self.distribution.intensity(e)
    }

    /// Luminous flux in lumens, integrated over the intensities.
    pub fn flux(&self) -> f64 {
        self.distribution.flux()
    }

    /// The same luminaire with another flux in lumens; none if `lumens` is negative or not finite, or
    /// if the distribution is dark. The stated fluxes are kept.
    pub fn with_flux(&self, lumens: f64) -> Option<Self> {
        let flux = self.flux();
        let distribution = (flux > 0.0).then(|| self.distribution.scaled(lumens / flux)).flatten()?;
        Some(Self { distribution, ..self.clone() })
    }
}

/// Reads a photometric file. `name` appears in messages only; the format is identified from the content:
/// LM-63 by its `TILT=` line, EULUMDAT by the numbers in lines 2 to 7.
pub fn read(name: &str, bytes: &[u8]) -> Result<Photometry, ReadError> {
    if bytes.len() > MOST_BYTES {
        let fault =
            Fault::whole("the file is larger than 8 MiB, which no photometric file is; choose another one");
        return Err(fault.in_file(name));
    }
    read_lines(&text::lines(&text::decode(bytes))).map_err(|fault| fault.in_file(name))
}

fn read_lines(lines: &[String]) -> Result<Photometry, Fault> {
    if lines.iter().all(String::is_empty) {
        return Err(Fault::whole("the file is empty; get it again from its source"));
    }
    if ies::is_lm_63(lines) {
        return ies::read(lines);
    }
    if eulumdat::is_eulumdat(lines) {
        return eulumdat::read(lines);
    }
    Err(Fault::whole(
        "this is neither IES LM-63 (no line starts with TILT=) nor EULUMDAT (lines 2 to 7 are not its \
        numbers); choose an .ies or .ldt file",
    ))
}
