use super::colour_map::ColourMap;
use super::tone::luminance;
use crate::scene::illuminance;

/// How values become colours: a map over a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseColour {
    /// The colours.
    pub map: ColourMap,
    /// The values of the first and the last colour, in the unit of the values; the first smaller.
    pub range: [f64; 2],
    /// Equal ratios, rather than equal steps, have equal distances. Needs a range above zero; a
    /// lower end that is not becomes a ten-thousandth of the upper one.
    pub logarithmic: bool,
}

/// Stands for "no value" among the numbers that false colours show: drawn in grey.
///
/// Far below any value and far from overflow, so that it can be interpolated.
pub const NO_VALUE: f32 = -1e30;

/// A mark on a legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Along the legend, 0 to 1.
    pub position: f64,
    /// The value there.
    pub value: f64,
    /// The value as a person writes it.
    pub label: String,
}

impl FalseColour {
    /// A range that fits `values`, one as much as the other; see [`FalseColour::fitted_by_area`].
    pub fn fitted(map: ColourMap, logarithmic: bool, values: &[f32]) -> Self {
        let even: Vec<(f32, f64)> = values.iter().map(|&v| (v, 1.0)).collect();
        Self::fitted_by_area(map, logarithmic, &even)
    }

    /// A range that fits values, each with the area (or another weight, above zero) that has it: the
    /// upper end is not exceeded on 97 % of the area, rounded up to a round number; the lower end is
    /// zero, or a round number below the lowest hundredth of the area where `logarithmic`.
    /// [`ColourMap::BlueRed`] gets a range symmetric about zero. Values that are not finite, and
    /// [`NO_VALUE`], do not count; 0 to 1 where none is left.
    pub fn fitted_by_area(map: ColourMap, logarithmic: bool, values: &[(f32, f64)]) -> Self {
        let signed = map == ColourMap::BlueRed;
        let mut sorted: Vec<(f32, f64)> = values
            .iter()
            .filter(|(v, area)| v.is_finite() && *v > NO_VALUE && *area > 0.0 && area.is_finite())
            .map(|&(v, area)| (if signed { v.abs() } else { v }, area))
            .collect();
        if logarithmic {
            sorted.retain(|(v, _)| *v > 0.0);
        }
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = sorted.iter().map(|(_, area)| area).sum();
        let at = |share: f64| {
            let mut passed = 0.0;
            let reaches = |&&(_, area): &&(f32, f64)| {
                passed += area;
                passed >= share * total
            };
            sorted.iter().find(reaches).or(sorted.last()).map_or(0.0, |&(v, _)| f64::from(v))
        };
        let high = round_up(at(0.97));
        let range = match map {
            ColourMap::BlueRed => [-high, high],
            ColourMap::Viridis if logarithmic => {
                [10_f64.powf(at(0.01).max(high * 1e-4).log10().floor()).min(high / 10.0), high]
            }
            ColourMap::Viridis => [0.0, high],
        };
        Self { map, range, logarithmic: logarithmic && !signed }
    }

    /// The range in force: finite, rising, and above zero where logarithmic.
    pub fn effective_range(&self) -> [f64; 2] {
        let [low, high] = self.range.map(|x| if x.is_finite() { x.clamp(-1e30, 1e30) } else { 0.0 });
        if self.logarithmic {
            let high = if high > 0.0 { high.max(1e-30) } else { 1.0 };
            return [if low > 0.0 && low < high { low } else { high * 1e-4 }, high];
        }
        let step = (high.abs().max(low.abs()) * 1e-9).max(1e-30);
        [low, if high > low + step { high } else { low + step.max(1.0) }]
    }

    /// Where a value lies along the map: 0 to 1 inside the range, beyond it clamped. 0 for NaN.
    pub fn position(&self, value: f64) -> f64 {
        let [scale, offset] = self.coefficients();
        let x = if self.logarithmic { value.max(1e-37).log2() } else { value };
        let position = x * scale + offset;
        if position.is_nan() { 0.0 } else { position.clamp(0.0, 1.0) }
    }

    /// Scale and offset with which a value (its base-2 logarithm where logarithmic) becomes a position.
    pub fn coefficients(&self) -> [f64; 2] {
        let range = self.effective_range();
        let [low, high] = if self.logarithmic { range.map(f64::log2) } else { range };
        let scale = 1.0 / (high - low);
        [scale, -low * scale]
    }

    /// The display-linear colour of a value.
    pub fn colour(&self, value: f64) -> [f32; 3] {
        self.map.linear(self.position(value))
    }

    /// Round values for a legend, at most `most` of them (two at least), rising.
    pub fn ticks(&self, most: usize) -> Vec<Tick> {
        let [low, high] = self.effective_range();
        let most = most.max(2);
        let values = if self.logarithmic { decades(low, high, most) } else { even_steps(low, high, most) };
        let tick = |value: f64| Tick { position: self.position(value), value, label: label(value) };
        values.into_iter().map(tick).collect()
    }
}

/// The smallest of 1, 2, 5, 10, 20, .. (or their fractions) that is not below `value`; 1 for zero.
fn round_up(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return 1.0;
    }
    let decade = 10_f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * decade)
        .into_iter()
        .find(|&r| r >= value * (1.0 - 1e-9))
        .unwrap_or(value)
}

fn even_steps(low: f64, high: f64, most: usize) -> Vec<f64> {
    let mut step = round_up((high - low) / most as f64);
    let count = |step: f64| (high / step + 1e-9).floor() - (low / step - 1e-9).ceil() + 1.0;
    while count(step) > most as f64 {
        step = round_up(step * 1.5);
    }
    let first = (low / step - 1e-9).ceil();
    // Adding zero turns -0 into 0.
    let values: Vec<f64> =
        (0..count(step).max(0.0) as usize).map(|k| (first + k as f64) * step + 0.0).collect();
    if values.len() < 2 { vec![low, high] } else { values }
}

fn decades(low: f64, high: f64, most: usize) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let inside = |v: &f64| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9);
    for multiples in [&[1.0, 2.0, 5.0][..], &[1.0, 3.0][..], &[1.0][..]] {
        let values: Vec<f64> = (first..=last)
            .flat_map(|e| multiples.iter().map(move |m| m * 10_f64.powi(e)))
            .filter(inside)
            .collect();
        if (2..=most).contains(&values.len()) {
            return values;
        }
    }
    let stride = ((last - first) as usize / most + 1).max(1);
    let values: Vec<f64> = (first..=last).step_by(stride).map(|e| 10_f64.powi(e)).filter(inside).collect();
    if values.is_empty() { vec![low, high] } else { values }
}

/// Three significant digits, thousands without an exponent.
fn label(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    if !(-4..=6).contains(&digits) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let text = format!("{value:.0$}", digits.max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Illuminance of each patch in lux from its irradiance in W/m² per band.
pub fn patch_illuminance(irradiance: &[[f32; 3]]) -> Vec<f32> {
    irradiance.iter().map(|h| illuminance(h.map(f64::from)) as f32).collect()
}

/// Luminance of each patch in cd/m² from its radiosity in W/m² per band.
pub fn patch_luminance(radiosity: &[[f32; 3]]) -> Vec<f32> {
    radiosity.iter().map(|b| luminance(*b) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(range: [f64; 2]) -> FalseColour {
        FalseColour { map: ColourMap::Viridis, range, logarithmic: false }
    }

    fn labels(scale: FalseColour, most: usize) -> Vec<String> {
        scale.ticks(most).into_iter().map(|t| t.label).collect()
    }

    #[test]
    fn positions_run_from_end_to_end() {
        let scale = linear([100.0, 300.0]);
        assert!((scale.position(150.0) - 0.25).abs() < 1e-12);
        assert_eq!((scale.position(0.0), scale.position(1e9)), (0.0, 1.0));
        let log = FalseColour { logarithmic: true, range: [1.0, 10_000.0], ..scale };
        assert!((log.position(100.0) - 0.5).abs() < 1e-12);
        assert_eq!((log.position(0.0), log.position(-1.0), log.position(f64::NAN)), (0.0, 0.0, 0.0));
    }

    #[test]
    fn senseless_ranges_are_mended() {
        for range in [[5.0, 5.0], [5.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [-1.0, 0.0]] {
            for logarithmic in [false, true] {
                let scale = FalseColour { logarithmic, ..linear(range) };
                let [low, high] = scale.effective_range();
                assert!(low < high && low.is_finite() && high.is_finite(), "{range:?}: {low} {high}");
                assert!(scale.position(1.0).is_finite());
                assert!(!scale.ticks(6).is_empty());
            }
        }
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(labels(linear([0.0, 500.0]), 6), ["0", "100", "200", "300", "400", "500"]);
        assert_eq!(labels(linear([-0.05, 0.05]), 5), ["-0.04", "-0.02", "0", "0.02", "0.04"]);
        assert_eq!(labels(linear([0.0, 2e-6]), 5), ["0", "5e-7", "1e-6", "1.5e-6", "2e-6"]);
        let log = FalseColour { logarithmic: true, ..linear([1.0, 1000.0]) };
        assert_eq!(labels(log, 5), ["1", "10", "100", "1000"]);
        assert_eq!(labels(FalseColour { range: [10.0, 200.0], ..log }, 6), ["10", "20", "50", "100", "200"]);
        for most in 2..12 {
            let ticks = linear([3.0, 777.0]).ticks(most);
            assert!(ticks.len() <= most && ticks.len() >= 2, "{most}: {ticks:?}");
            assert!(ticks.is_sorted_by(|a, b| a.position < b.position));
        }
    }

    #[test]
    fn fitted_ranges_ignore_the_lamp_and_broken_values() {
        let mut values: Vec<f32> = (0..1000).map(|i| 0.4 * i as f32).collect();
        values[7] = 1e6;
        values[8] = f32::NAN;
        values[9] = NO_VALUE;
        assert_eq!(FalseColour::fitted(ColourMap::Viridis, false, &values).range, [0.0, 500.0]);
        assert_eq!(FalseColour::fitted(ColourMap::BlueRed, false, &[-3.0, 1.0, NO_VALUE]).range, [-5.0, 5.0]);
        assert_eq!(FalseColour::fitted(ColourMap::Viridis, false, &[]).range, [0.0, 1.0]);
        let log = FalseColour::fitted(ColourMap::Viridis, true, &[0.0, 3.0, 40.0, 300.0]);
        assert_eq!((log.range, log.logarithmic), ([1.0, 500.0], true));
    }

    #[test]
    fn a_range_fits_areas_and_not_counts() {
        // Many small bright patches on a lamp, few large ones on walls.
        let lamp = (0..500).map(|_| (9_000.0, 1e-4));
        let walls = (0..100).map(|i| (3.0 * i as f32, 0.5));
        let values: Vec<(f32, f64)> = lamp.chain(walls).collect();
        assert_eq!(FalseColour::fitted_by_area(ColourMap::Viridis, false, &values).range, [0.0, 500.0]);
        let counted: Vec<f32> = values.iter().map(|v| v.0).collect();
        assert_eq!(FalseColour::fitted(ColourMap::Viridis, false, &counted).range, [0.0, 10_000.0]);
    }

    #[test]
    fn one_watt_of_white_is_179_lux() {
        assert!((patch_illuminance(&[[1.0; 3]])[0] - 179.0).abs() < 1e-3);
        assert!((patch_luminance(&[[1.0; 3]])[0] - 179.0 / std::f32::consts::PI).abs() < 1e-3);
    }
}
