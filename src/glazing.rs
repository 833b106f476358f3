//! Glass panes: what passes, what is mirrored and what is absorbed, by angle.
//!
//! A pane is a plane-parallel plate, thin against its size, with clear or tinted glass between two smooth
//! surfaces. Unpolarised light arrives; all reflections between the surfaces, and between the panes of a
//! unit, are added up for either polarisation (G. Stokes 1862; Duffie & Beckman, "Solar Engineering of
//! Thermal Processes", section 5.3). Directions are given by the cosine of the angle of incidence, 1 for
//! light that arrives along the normal.

mod table;

pub use table::AngleTable;

use crate::geometry::gauss_legendre;

/// Refractive index of window glass.
pub const WINDOW_GLASS: f64 = 1.52;

/// Points of the rule for hemispherical values; more change nothing in ten digits.
const POINTS: usize = 48;

/// Why there is no such pane, in one sentence without a full stop.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GlazingError {
    /// A refractive index that glass does not have.
    #[error("the refractive index is {0}, but must lie between 1 and 4")]
    Index(f64),
    /// A transmissivity that cannot be.
    #[error("the transmissivity is {0}, but must lie between 0 and 1")]
    Transmissivity(f64),
    /// More light than passes between two surfaces that mirror some of it.
    #[error(
        "the transmittance is {0}, but two surfaces of index {1} let at most {2:.4} pass, and none is below 0"
    )]
    Transmittance(f64, f64, f64),
    /// The same of a unit, with the number of its surfaces.
    #[error(
        "the transmittance is {0}, but {1} surfaces of index {2} let at most {3:.4} pass, and none is below 0"
    )]
    Unit(f64, u32, f64, f64),
    /// No pane at all.
    #[error("a glazing unit needs at least one pane")]
    NoPane,
}

/// Shares of light for either polarisation: perpendicular to the plane of incidence (s) and in it (p).
type Polarised = [f64; 2];

/// Reflectances of one surface between air and a medium of refractive `index` (1 or above) for s and p, at
/// the cosine `cos` of the angle of incidence in air, 0 to 1 (Fresnel 1823). Both are 1 at grazing incidence.
pub fn fresnel(cos: f64, index: f64) -> [f64; 2] {
    let c = held(cos);
    // Cosine of the angle in the medium.
    let c2 = (1.0 - (1.0 - c * c) / (index * index)).max(0.0).sqrt();
    let s = (c - index * c2) / (c + index * c2);
    let p = (index * c - c2) / (index * c + c2);
    [s * s, p * p]
}

/// A cosine that is one; NaN counts as grazing.
fn held(cos: f64) -> f64 {
    if cos > 0.0 { cos.min(1.0) } else { 0.0 }
}

/// One pane of glass, tinted or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pane {
    index: f64,
    transmissivity: [f64; 3],
}

impl Pane {
    /// A pane from the transmissivity of its glass in each band: the share of light that gets from one
    /// surface to the other along the normal, 0 to 1, reflection apart (tn of the program Radiance). The
    /// index is 1 to 4.
    ///
    /// # Errors
    /// A value outside its range.
    pub fn new(index: f64, transmissivity: [f64; 3]) -> Result<Self, GlazingError> {
        if !(1.0..=4.0).contains(&index) {
            return Err(GlazingError::Index(index));
        }
        match transmissivity.iter().find(|&share| !(0.0..=1.0).contains(share)) {
            Some(&wrong) => Err(GlazingError::Transmissivity(wrong)),
            None => Ok(Self { index, transmissivity }),
        }
    }

    /// A pane from its transmittance in each band at normal incidence (Tn, what a maker states), 0 to
    /// [`greatest_transmittance`].
    ///
    /// # Errors
    /// A value outside its range.
    pub fn from_transmittance(index: f64, transmittance: [f64; 3]) -> Result<Self, GlazingError> {
        if !(1.0..=4.0).contains(&index) {
            return Err(GlazingError::Index(index));
        }
        let most = greatest_transmittance(index);
        let mut transmissivity = [0.0; 3];
        for (found, &wanted) in transmissivity.iter_mut().zip(&transmittance) {
            // A stated value may be rounded up in its last digit.
            if !(0.0..=most + 5e-5).contains(&wanted) {
                return Err(GlazingError::Transmittance(wanted, index, most));
            }
            *found = transmissivity_of(wanted.min(most), index);
        }
        Self::new(index, transmissivity)
    }

    /// The refractive index.
    pub fn index(&self) -> f64 {
        self.index
    }

    /// Share of light in each band that gets from surface to surface along the normal.
    pub fn transmissivity(&self) -> [f64; 3] {
        self.transmissivity
    }

    /// Transmittance in each band at a cosine of the angle of incidence.
    pub fn transmittance(&self, cos: f64) -> [f64; 3] {
        self.bands(cos).map(|shares| mean(shares.passed))
    }

    /// Reflectance in each band at a cosine of the angle of incidence; it mirrors.
    pub fn reflectance(&self, cos: f64) -> [f64; 3] {
        self.bands(cos).map(|shares| mean(shares.front))
    }

    /// Transmittance in each band for light from all directions of a hemisphere alike.
    pub fn hemispherical_transmittance(&self) -> [f64; 3] {
        hemispherical(|cos| self.transmittance(cos))
    }

    /// Reflectance in each band for light from all directions of a hemisphere alike.
    pub fn hemispherical_reflectance(&self) -> [f64; 3] {
        hemispherical(|cos| self.reflectance(cos))
    }

    fn bands(&self, cos: f64) -> [Shares; 3] {
        let r = fresnel(cos, self.index);
        let c = held(cos);
        let c2 = (1.0 - (1.0 - c * c) / (self.index * self.index)).sqrt();
        self.transmissivity.map(|tn| {
            // The way through the glass is longer at a slant.
            let t = tn.powf(1.0 / c2);
            let passed = r.map(|r| fraction((1.0 - r) * (1.0 - r) * t, 1.0 - r * r * t * t));
            // At grazing incidence nothing enters, and all is mirrored.
            let front = r.map(|r| {
                if r >= 1.0 { 1.0 } else { r * (1.0 + (1.0 - 2.0 * r) * t * t) / (1.0 - r * r * t * t) }
            });
            Shares { passed, front, back: front }
        })
    }
}

/// The greatest transmittance of a pane of this refractive index at normal incidence, of glass that absorbs
/// nothing: (1 - r)/(1 + r); 0.9183 for window glass.
pub fn greatest_transmittance(index: f64) -> f64 {
    let [r, _] = fresnel(1.0, index);
    (1.0 - r) / (1.0 + r)
}

/// Transmissivity from the transmittance at normal incidence, both 0 to 1: the root of
/// r² T t² + (1 - r)² t - T = 0.
fn transmissivity_of(transmittance: f64, index: f64) -> f64 {
    let [r, _] = fresnel(1.0, index);
    let linear = (1.0 - r) * (1.0 - r);
    let root = (linear * linear + 4.0 * r * r * transmittance * transmittance).sqrt();
    // In the form that divides by no small number.
    (2.0 * transmittance / (linear + root)).clamp(0.0, 1.0)
}

/// Several panes one behind the other with air between them, from the outside in.
#[derive(Clone, Debug, PartialEq)]
pub struct Glazing {
    panes: Vec<Pane>,
}

impl Glazing {
    /// A unit of one pane or more.
    ///
    /// # Errors
    /// No pane.
    pub fn new(panes: Vec<Pane>) -> Result<Self, GlazingError> {
        if panes.is_empty() { Err(GlazingError::NoPane) } else { Ok(Self { panes }) }
    }

    /// A single pane.
    pub fn single(pane: Pane) -> Self {
        Self { panes: vec![pane] }
    }

    /// So many panes alike, 1 or more, that together let this share of each band pass along the normal: what a maker
    /// states of a unit.
    ///
    /// # Errors
    /// More than so many surfaces of this index let pass, or a share below 0.
    pub fn of_unit(panes: u32, index: f64, transmittance: [f64; 3]) -> Result<Self, GlazingError> {
        let of = |tn: f64| Pane::new(index, [tn; 3]).map(|pane| Self { panes: vec![pane; panes as usize] });
        if panes == 0 {
            return Err(GlazingError::NoPane);
        }
        let most = of(1.0)?.transmittance(1.0)[0];
        let mut transmissivity = [0.0; 3];
        for (found, &wanted) in transmissivity.iter_mut().zip(&transmittance) {
            if !(0.0..=most + 5e-5).contains(&wanted) {
                return Err(GlazingError::Unit(wanted, 2 * panes, index, most));
            }
            // It rises with the transmissivity of a pane.
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let is_more = of(middle)?.transmittance(1.0)[0] > wanted;
                (low, high) = if is_more { (low, middle) } else { (middle, high) };
            }
            *found = 0.5 * (low + high);
        }
        Ok(Self { panes: vec![Pane::new(index, transmissivity)?; panes as usize] })
    }

    /// Two panes alike.
    pub fn double(pane: Pane) -> Self {
        Self { panes: vec![pane; 2] }
    }

    /// The panes from the outside in.
    pub fn panes(&self) -> &[Pane] {
        &self.panes
    }

    /// Transmittance in each band at a cosine of the angle of incidence, the same either way.
    pub fn transmittance(&self, cos: f64) -> [f64; 3] {
        self.bands(cos).map(|shares| mean(shares.passed))
    }

    /// Reflectance in each band of what arrives from outside at a cosine of the angle of incidence.
    pub fn outer_reflectance(&self, cos: f64) -> [f64; 3] {
        self.bands(cos).map(|shares| mean(shares.front))
    }

    /// Reflectance in each band of what arrives from inside at a cosine of the angle of incidence.
    pub fn inner_reflectance(&self, cos: f64) -> [f64; 3] {
        self.bands(cos).map(|shares| mean(shares.back))
    }

    /// Transmittance in each band for light from all directions of a hemisphere alike.
    pub fn hemispherical_transmittance(&self) -> [f64; 3] {
        hemispherical(|cos| self.transmittance(cos))
    }

    /// Reflectance in each band of light from all directions of the outer hemisphere alike.
    pub fn hemispherical_outer_reflectance(&self) -> [f64; 3] {
        hemispherical(|cos| self.outer_reflectance(cos))
    }

    fn bands(&self, cos: f64) -> [Shares; 3] {
        let mut whole = [Shares::OPEN; 3];
        for pane in &self.panes {
            for (whole, next) in whole.iter_mut().zip(pane.bands(cos)) {
                *whole = whole.before(&next);
            }
        }
        whole
    }
}

/// What becomes of light at a stack of surfaces, for either polarisation.
#[derive(Clone, Copy)]
struct Shares {
    passed: Polarised,
    front: Polarised,
    back: Polarised,
}

impl Shares {
    /// A hole.
    const OPEN: Self = Self { passed: [1.0; 2], front: [0.0; 2], back: [0.0; 2] };

    /// This in front of the next: the geometric series of the reflections between them.
    fn before(&self, next: &Self) -> Self {
        let mut both = Self::OPEN;
        for k in 0..2 {
            let between = 1.0 - self.back[k] * next.front[k];
            both.passed[k] = fraction(self.passed[k] * next.passed[k], between);
            both.front[k] =
                self.front[k] + fraction(self.passed[k] * self.passed[k] * next.front[k], between);
            both.back[k] = next.back[k] + fraction(next.passed[k] * next.passed[k] * self.back[k], between);
        }
        both
    }
}

/// A quotient whose numerator vanishes with its denominator, at grazing incidence.
fn fraction(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 { numerator / denominator } else { 0.0 }
}

fn mean([s, p]: Polarised) -> f64 {
    0.5 * (s + p)
}

/// Mean over a hemisphere of equal radiance: the integral of 2 cos value(cos) over cos.
fn hemispherical(value: impl Fn(f64) -> [f64; 3]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (cos, weight) in gauss_legendre(POINTS) {
        for (sum, value) in sum.iter_mut().zip(value(cos)) {
            *sum += 2.0 * cos * weight * value;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANGLES: [f64; 8] = [0.0, 20.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0];

    fn stated(transmittance: f64) -> Pane {
        Pane::from_transmittance(WINDOW_GLASS, [transmittance; 3]).unwrap()
    }

    fn clear() -> Pane {
        Pane::new(WINDOW_GLASS, [0.96; 3]).unwrap()
    }

    #[track_caller]
    fn compare(value: impl Fn(f64) -> f64, wanted: [f64; 8], what: &str) {
        for (angle, wanted) in ANGLES.into_iter().zip(wanted) {
            let found = value(angle.to_radians().cos());
            assert!((found - wanted).abs() < 6e-7, "{what} at {angle}: {found} is not {wanted}");
        }
    }

    #[track_caller]
    fn near(found: f64, wanted: f64) {
        assert!((found - wanted).abs() < 6e-7, "{found} is not {wanted}");
    }

    #[test]
    fn transmissivity_follows_from_transmittance_and_back() {
        #[rustfmt::skip]
        let pairs = [(0.50, 0.545_168_693), (0.65, 0.708_456_143), (0.78, 0.849_807_565),
            (0.80, 0.871_538_314), (0.88, 0.958_415_433), (0.90, 0.980_122_695)];
        for (transmittance, transmissivity) in pairs {
            let pane = stated(transmittance);
            // The published formula has its constants rounded.
            assert!((pane.transmissivity()[0] - transmissivity).abs() < 3e-8, "{pane:?}");
            assert!((pane.transmittance(1.0)[1] - transmittance).abs() < 1e-14, "{pane:?}");
        }
        assert_eq!(stated(0.0).transmissivity(), [0.0; 3]);
        near(stated(0.0).transmittance(0.5)[0], 0.0);
        let most = greatest_transmittance(WINDOW_GLASS);
        assert!((most - 0.918_318).abs() < 1e-6 && (stated(most).transmissivity()[0] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn one_pane_has_its_known_values() {
        #[rustfmt::skip]
        let rows = [
            (0.88, [0.880000, 0.878613, 0.867562, 0.847907, 0.799868, 0.683852, 0.423546, 0.218882],
                0.805554),
            (0.78, [0.780000, 0.776293, 0.759209, 0.736686, 0.688749, 0.581579, 0.348043, 0.166286],
                0.701070),
            (0.65, [0.650000, 0.643808, 0.620655, 0.595908, 0.550136, 0.457305, 0.264555, 0.118394],
                0.569399),
        ];
        for (normal, by_angle, all) in rows {
            let pane = stated(normal);
            compare(|cos| pane.transmittance(cos)[0], by_angle, &format!("T of Tn {normal}"));
            near(pane.hemispherical_transmittance()[2], all);
        }
        #[rustfmt::skip]
        let mirrored = [
            (0.88, [0.078492, 0.078813, 0.086758, 0.104264, 0.150045, 0.264205, 0.524328, 0.731454],
                0.147539),
            (0.78, [0.070804, 0.070936, 0.077793, 0.093551, 0.135104, 0.239331, 0.483061, 0.689394],
                0.133893),
        ];
        for (normal, by_angle, all) in mirrored {
            let pane = stated(normal);
            compare(|cos| pane.reflectance(cos)[0], by_angle, &format!("R of Tn {normal}"));
            near(pane.hemispherical_reflectance()[0], all);
        }
        let by_angle = [0.881460, 0.880109, 0.869154, 0.849548, 0.801519, 0.685392, 0.424743, 0.219815];
        compare(|cos| clear().transmittance(cos)[0], by_angle, "T of tn 0.96");
    }

    #[test]
    fn two_panes_have_their_known_values() {
        let unit = Glazing::double(clear());
        let passed = [0.781803, 0.779693, 0.766126, 0.743181, 0.684897, 0.539334, 0.262962, 0.107795];
        compare(|cos| unit.transmittance(cos)[0], passed, "T of two panes");
        let mirrored = [0.140070, 0.140217, 0.148102, 0.167173, 0.221523, 0.364290, 0.642485, 0.805832];
        compare(|cos| unit.outer_reflectance(cos)[0], mirrored, "R of two panes");
        near(unit.hemispherical_transmittance()[0], 0.694331);
        // What passes, is mirrored and is absorbed is all there is.
        assert!(unit.hemispherical_transmittance()[0] + unit.hemispherical_outer_reflectance()[0] < 1.0);
    }

    #[test]
    fn a_unit_has_the_transmittance_that_its_maker_states() {
        let unit = Glazing::of_unit(2, WINDOW_GLASS, [0.781_803, 0.6, 0.0]).unwrap();
        let [red, green, blue] = unit.transmittance(1.0);
        near(red, 0.781_803);
        near(green, 0.6);
        assert!(blue < 1e-12);
        assert!((unit.panes()[0].transmissivity()[0] - 0.96).abs() < 1e-5, "{unit:?}");
        assert_eq!(Glazing::of_unit(1, WINDOW_GLASS, [0.78; 3]).unwrap().panes().len(), 1);
        let refused = Glazing::of_unit(2, WINDOW_GLASS, [0.9; 3]).unwrap_err().to_string();
        assert!(refused.contains("4 surfaces") && refused.contains("at most 0.8490"), "{refused}");
        assert_eq!(Glazing::of_unit(0, WINDOW_GLASS, [0.5; 3]), Err(GlazingError::NoPane));
    }

    #[test]
    fn surfaces_reflect_as_fresnel_says() {
        let s = [0.042580, 0.050007, 0.081351, 0.117396, 0.183438, 0.307890, 0.546363, 0.737674];
        let p = [0.042580, 0.035700, 0.015551, 0.003790, 0.001527, 0.041534, 0.235537, 0.492173];
        let both = [0.042580, 0.042854, 0.048451, 0.060593, 0.092483, 0.174712, 0.390950, 0.614923];
        compare(|cos| fresnel(cos, WINDOW_GLASS)[0], s, "s");
        compare(|cos| fresnel(cos, WINDOW_GLASS)[1], p, "p");
        compare(|cos| mean(fresnel(cos, WINDOW_GLASS)), both, "mean");
        near(hemispherical(|cos| [mean(fresnel(cos, WINDOW_GLASS)); 3])[0], 0.094707);
        // Brewster's angle: nothing of p.
        assert!(fresnel(1.0 / (1.0 + WINDOW_GLASS * WINDOW_GLASS).sqrt(), WINDOW_GLASS)[1] < 1e-30);
    }

    #[test]
    fn grazing_light_is_mirrored_and_glass_of_index_1_is_air() {
        for cos in [0.0, -0.3, f64::NAN] {
            assert_eq!(clear().transmittance(cos), [0.0; 3]);
            assert_eq!(clear().reflectance(cos), [1.0; 3]);
            assert_eq!(Glazing::double(clear()).outer_reflectance(cos), [1.0; 3]);
            assert_eq!(Glazing::double(clear()).transmittance(cos), [0.0; 3]);
        }
        // Glass that absorbs nothing loses nothing, even just above the plane of the pane.
        let ideal = Glazing::double(Pane::new(WINDOW_GLASS, [1.0; 3]).unwrap());
        for cos in [1e-12, 1e-6, 0.01, 0.5, 1.0, 7.0] {
            let sum = ideal.transmittance(cos)[0] + ideal.outer_reflectance(cos)[0];
            assert!((sum - 1.0).abs() < 1e-9, "{cos}: {sum}");
        }
        let air = Pane::new(1.0, [1.0; 3]).unwrap();
        assert_eq!((air.transmittance(0.4), air.reflectance(0.4)), ([1.0; 3], [0.0; 3]));
    }

    #[test]
    fn tints_and_units_of_different_panes_keep_their_sides_apart() {
        let tinted = Pane::from_transmittance(WINDOW_GLASS, [0.2, 0.5, 0.9]).unwrap();
        let unit = Glazing::new(vec![tinted, clear()]).unwrap();
        let turned = Glazing::new(vec![clear(), tinted]).unwrap();
        for cos in [1.0, 0.7, 0.2] {
            for band in 0..3 {
                let (a, b) = (unit.transmittance(cos)[band], turned.transmittance(cos)[band]);
                assert!((a - b).abs() < 1e-15, "light passes alike both ways");
                assert_eq!(unit.outer_reflectance(cos)[band], turned.inner_reflectance(cos)[band]);
            }
            // The dark pane hides what the clear one behind it mirrors.
            assert!(unit.outer_reflectance(cos)[0] < unit.inner_reflectance(cos)[0]);
            let [red, green, blue] = unit.transmittance(cos);
            assert!(red < green && green < blue);
        }
        assert_eq!(Glazing::single(tinted).transmittance(0.6), tinted.transmittance(0.6));
        assert_eq!(unit.panes().len(), 2);
    }

    #[test]
    fn panes_that_cannot_be_are_refused() {
        assert_eq!(Glazing::new(Vec::new()), Err(GlazingError::NoPane));
        let too_clear = Pane::from_transmittance(WINDOW_GLASS, [0.95; 3]).unwrap_err().to_string();
        assert!(too_clear.contains("at most 0.9183"), "{too_clear}");
        assert!(Pane::from_transmittance(WINDOW_GLASS, [0.5, f64::NAN, 0.5]).is_err());
        assert!(Pane::from_transmittance(WINDOW_GLASS, [-0.1; 3]).is_err());
        assert!(Pane::from_transmittance(WINDOW_GLASS, [0.9183; 3]).is_ok());
        assert!(Pane::new(0.9, [1.0; 3]).is_err() && Pane::new(f64::NAN, [1.0; 3]).is_err());
        assert_eq!(Pane::new(WINDOW_GLASS, [1.1; 3]), Err(GlazingError::Transmissivity(1.1)));
    }
}
