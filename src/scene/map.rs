//! An image as a `map_` statement of an MTL names it, with its options.

use super::text::{keyword, unquoted};
use glam::DVec2;
use std::fmt::Write as _;

/// No texture is moved or repeated more than this.
const LARGEST: f64 = 1e6;
/// Options behind a name are looked for at so many dashes of it.
const MOST_DASHES: usize = 16;

/// How an image lies on a surface: the image's coordinates are `uv * scale + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    pub(super) scale: DVec2,
    pub(super) offset: DVec2,
}

impl Default for Placement {
    fn default() -> Self {
        Self { scale: DVec2::ONE, offset: DVec2::ZERO }
    }
}

impl Placement {
    /// Coordinates in the image of those in the file.
    pub(super) fn apply(&self, uv: DVec2) -> DVec2 {
        uv * self.scale + self.offset
    }

    /// The placement with the same result for coordinates to which `other` was applied already.
    pub(super) fn after(&self, other: &Self) -> Self {
        // Coordinates that `other` made all alike cannot be told apart any more.
        let ratio = |a: f64, b: f64| if b == 0.0 { 1.0 } else { a / b };
        let scale = DVec2::new(ratio(self.scale.x, other.scale.x), ratio(self.scale.y, other.scale.y));
        Self { scale, offset: self.offset - other.offset * scale }
    }
}

/// A `map_` statement.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Map {
    /// The name of the image; empty where the statement gives none.
    pub(super) image: String,
    pub(super) placement: Placement,
    /// The image is there once, and its border goes on for ever (`-clamp on`).
    pub(super) clamped: bool,
    /// Linear values become `base + gain * value` (`-mm`).
    pub(super) range: Option<[f64; 2]>,
    /// All other options, as they are written.
    pub(super) others: Vec<String>,
}

impl Map {
    /// Reads what follows the keyword. Options come before the name, in any order; some programs write them behind it.
    pub(super) fn parse(rest: &str) -> Self {
        let mut map = Self::default();
        let mut name = map.take_options(rest.trim());
        let is_quoted = |at: usize| name[..at].matches('"').count() % 2 == 1;
        let mut behind = name.match_indices(" -").map(|(at, _)| at).take(MOST_DASHES);
        let options = behind
            .find(|&at| !is_quoted(at) && Self::default().take_options(name[at..].trim_start()).is_empty());
        if let Some(at) = options {
            map.take_options(name[at..].trim_start());
            name = name[..at].trim_end();
        }
        map.image = unquoted(name).trim_matches('"').to_owned();
        map
    }

    /// Reads the options at the beginning; what follows them.
    fn take_options<'a>(&mut self, mut rest: &'a str) -> &'a str {
        while let Some(option) = rest.strip_prefix('-') {
            let (name, mut tail) = keyword(option);
            let most = match &*name {
                "o" | "s" | "t" => 3,
                "mm" => 2,
                "blendu" | "blendv" | "bm" | "boost" | "cc" | "clamp" | "imfchan" | "texres" | "type" => 1,
                // Not an option: a file name that starts with a dash.
                _ => break,
            };
            let mut values: Vec<&str> = Vec::new();
            while values.len() < most && !tail.is_empty() {
                let (value, after) = tail.split_once(char::is_whitespace).unwrap_or((tail, ""));
                // -o, -s, -t and -mm take one number or more.
                if most > 1 && value.parse::<f64>().is_err() {
                    break;
                }
                values.push(value);
                tail = after.trim_start();
            }
            self.take(&name, &values);
            rest = tail;
        }
        rest
    }

    fn take(&mut self, name: &str, values: &[&str]) {
        let numbers: Vec<f64> = values.iter().filter_map(|value| value.parse().ok()).collect();
        let usable = !numbers.is_empty() && numbers.iter().all(|n| n.is_finite() && n.abs() <= LARGEST);
        let pair = |default: f64| DVec2::new(numbers[0], numbers.get(1).copied().unwrap_or(default));
        match name {
            "o" if usable => self.placement.offset = pair(0.0),
            "s" if usable => self.placement.scale = pair(1.0),
            "mm" if usable => {
                let range = [numbers[0], numbers.get(1).copied().unwrap_or(1.0)];
                self.range = Some(range).filter(|range| *range != [0.0, 1.0]);
            }
            "clamp" if matches!(values, [on] if on.eq_ignore_ascii_case("on")) => self.clamped = true,
            "clamp" if matches!(values, [off] if off.eq_ignore_ascii_case("off")) => self.clamped = false,
            _ => self.others.push(format!("-{name} {}", values.join(" ")).trim_end().to_owned()),
        }
    }

    /// The options that change what the image means and are not heeded for reflectances, as written.
    pub(super) fn unheeded(&self) -> impl Iterator<Item = &str> {
        let means_nothing = |option: &str| {
            let (name, value) = keyword(option);
            let numbers = value.split_whitespace().map(|v| v.parse::<f64>().ok());
            match &*name {
                "-blendu" | "-blendv" => value.eq_ignore_ascii_case("on"),
                "-cc" => value.eq_ignore_ascii_case("off"),
                "-boost" | "-t" => !value.is_empty() && numbers.into_iter().all(|n| n == Some(0.0)),
                "-bm" => !value.is_empty() && numbers.into_iter().all(|n| n == Some(1.0)),
                _ => false,
            }
        };
        self.others.iter().map(String::as_str).filter(move |option| !means_nothing(option))
    }

    /// What follows the keyword in a library that names the image so.
    pub(super) fn text(&self, image: &str) -> String {
        let mut text = String::new();
        let Placement { scale, offset } = self.placement;
        if offset != DVec2::ZERO {
            let _ = write!(text, "-o {} {} 0 ", offset.x, offset.y);
        }
        if scale != DVec2::ONE {
            let _ = write!(text, "-s {} {} 1 ", scale.x, scale.y);
        }
        if let Some([base, gain]) = self.range {
            let _ = write!(text, "-mm {base} {gain} ");
        }
        if self.clamped {
            text += "-clamp on ";
        }
        for option in &self.others {
            let _ = write!(text, "{option} ");
        }
        text + image
    }
}

/// Whether a keyword in lower case names an image.
pub(super) fn is_map(keyword: &str) -> bool {
    keyword.starts_with("map_") || matches!(keyword, "bump" | "disp" | "decal" | "refl" | "norm")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_before_an_image_are_read() {
        for (given, image, options) in [
            ("wall.png", "wall.png", ""),
            ("-s 2 2 1 my wall.png", "my wall.png", "-s 2 2 1 "),
            ("-S 2 -Clamp ON wall.png", "wall.png", "-s 2 1 1 -clamp on "),
            ("-mm 0 1 \"a b.jpg\"", "a b.jpg", ""),
            ("-mm 0.1 0.5 -o .5 0 0 a", "a", "-o 0.5 0 0 -mm 0.1 0.5 "),
            ("-o 0.5 -s 1e9 1 1 a", "a", "-o 0.5 0 0 -s 1e9 1 1 "),
            ("-s nan a", "a", "-s nan "),
            ("-s a", "a", "-s "),
            ("-odd.png", "-odd.png", ""),
            ("-clamp on", "", "-clamp on "),
            ("-bm 0.2 -imfchan l a.png", "a.png", "-bm 0.2 -imfchan l "),
            ("a b.png -s 2 3 -clamp on", "a b.png", "-s 2 3 1 -clamp on "),
            ("-o 1 a - b.png -s 2", "a - b.png", "-o 1 0 0 -s 2 1 1 "),
            ("\"a -s 2\"", "a -s 2", ""),
            ("a -s b.png", "a -s b.png", ""),
            ("", "", ""),
        ] {
            let map = Map::parse(given);
            assert_eq!((map.image.as_str(), map.text("")), (image, options.to_owned()), "{given}");
            assert_eq!(Map::parse(&map.text("x.png")).text("x.png"), map.text("x.png"), "{given}");
        }
    }

    #[test]
    fn options_that_cannot_be_heeded_are_named_and_those_without_effect_are_not() {
        let all =
            "-blendu on -blendv off -cc on -boost 0 -t 0 0 0 -t 1 0 0 -bm 1 -bm 2 -texres 64 -type sphere x";
        let map = Map::parse(all);
        let unheeded: Vec<&str> = map.unheeded().collect();
        assert_eq!(unheeded, ["-blendv off", "-cc on", "-t 1 0 0", "-bm 2", "-texres 64", "-type sphere"]);
        assert_eq!(map.image, "x");
    }

    #[test]
    fn placements_follow_one_another() {
        let first = Map::parse("-s 2 4 -o 0.5 0.25 x").placement;
        let other = Map::parse("-s 3 0.5 -o 0.1 x").placement;
        let uv = DVec2::new(0.3, 0.7);
        assert_eq!(first.apply(uv), DVec2::new(1.1, 3.05));
        assert!(other.after(&first).apply(first.apply(uv)).abs_diff_eq(other.apply(uv), 1e-12));
        assert_eq!(first.after(&first), Placement::default());
    }
}
