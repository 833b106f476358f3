//! What a glazing unit passes and mirrors, tabulated over the cosine of the angle of incidence.

use super::Glazing;

/// Steps of the root of the cosine from 0 to 1, as glass changes fast near grazing angles; linear between them all shares are right to 5e-5 (tested).
const STEPS: usize = 1024;

/// Shares of light by angle, for use at every ray and span: cosines 0 to 1, shares 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct AngleTable {
    /// Passed and mirrored, the latter as the mean of both sides, a band each.
    steps: Vec<([f32; 3], [f32; 3])>,
    is_tinted: bool,
}

impl AngleTable {
    /// Of a unit.
    pub fn new(glazing: &Glazing) -> Self {
        let at = |k: usize| {
            let root = k as f64 / STEPS as f64;
            let cos = root * root;
            let (outer, inner) = (glazing.outer_reflectance(cos), glazing.inner_reflectance(cos));
            let mirrored: [f64; 3] = std::array::from_fn(|b| 0.5 * (outer[b] + inner[b]));
            (glazing.transmittance(cos).map(|t| t as f32), mirrored.map(|r| r as f32))
        };
        let is_tinted = {
            let [r, g, b] = glazing.transmittance(1.0);
            (r - g).abs().max((g - b).abs()) > 1e-9
        };
        Self { steps: (0..=STEPS).map(at).collect(), is_tinted }
    }

    /// Whether bands differ.
    pub fn is_tinted(&self) -> bool {
        self.is_tinted
    }

    /// Transmittance in each band at a cosine of the angle of incidence; its sign does not count, NaN counts as grazing.
    pub fn transmittance(&self, cos: f64) -> [f64; 3] {
        self.at(cos, |step| step.0)
    }

    /// Reflectance in each band, likewise.
    pub fn reflectance(&self, cos: f64) -> [f64; 3] {
        self.at(cos, |step| step.1)
    }

    fn at(&self, cos: f64, share: impl Fn(&([f32; 3], [f32; 3])) -> [f32; 3]) -> [f64; 3] {
        // NaN is above nothing.
        let held = if cos.abs() > 0.0 { cos.abs().min(1.0) } else { 0.0 };
        let place = held.sqrt() * STEPS as f64;
        let low = (place as usize).min(STEPS - 1);
        let part = place - low as f64;
        let (a, b) = (share(&self.steps[low]), share(&self.steps[low + 1]));
        std::array::from_fn(|k| f64::from(a[k]) + part * (f64::from(b[k]) - f64::from(a[k])))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Pane;
    use super::*;

    #[test]
    fn the_table_has_the_values_of_the_formula_at_every_angle() {
        let pane = Pane::from_transmittance(1.52, [0.88, 0.5, 0.7]).unwrap();
        for unit in [Glazing::single(pane), Glazing::double(pane)] {
            let table = AngleTable::new(&unit);
            assert!(table.is_tinted());
            for k in 0..=5000 {
                let cos = f64::from(k) / 5000.0;
                let (passed, mirrored) = (unit.transmittance(cos), unit.outer_reflectance(cos));
                for band in 0..3 {
                    assert!((table.transmittance(cos)[band] - passed[band]).abs() < 5e-5, "{cos}");
                    assert!((table.reflectance(-cos)[band] - mirrored[band]).abs() < 5e-5, "{cos}");
                }
            }
        }
        assert_eq!(AngleTable::new(&Glazing::single(pane)).transmittance(f64::NAN), [0.0; 3]);
    }
}
