//! Charts of cost against error, both on logarithmic axes, as SVG and PNG.

use super::{ExportError, atomic};
use resvg::{tiny_skia, usvg};
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::Path;
use std::sync::Arc;

/// A point of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChartPoint {
    /// Along the horizontal axis; above zero.
    pub x: f64,
    /// Along the vertical axis; above zero.
    pub y: f64,
    /// Ends of the interval of `y`.
    pub range: [f64; 2],
    /// Whether the curve goes through it; else it is a faint dot.
    pub on_curve: bool,
}

/// Points of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// `#rrggbb`.
    pub colour: &'static str,
    /// In rising order of x.
    pub points: Vec<ChartPoint>,
}

/// One diagram.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Above it.
    pub title: String,
    /// Below the horizontal axis.
    pub x_label: String,
    /// Beside the vertical axis.
    pub y_label: String,
    /// What is drawn.
    pub series: Vec<Series>,
    /// Points that no other beats in both, marked by rings.
    pub front: Vec<[f64; 2]>,
}

/// Diagrams side by side under one title.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Above all.
    pub title: String,
    /// One line of small print below.
    pub note: String,
    /// From left to right.
    pub panels: Vec<Panel>,
}

const PANEL: [f64; 2] = [500.0, 430.0];
/// Above the panels, with a legend of one line.
const TOP: f64 = 64.0;
const BOTTOM: f64 = 34.0;
/// Left end of the legend, and from one line of it to the next.
const LEFT: f64 = 24.0;
const LEGEND_LINE: f64 = 20.0;
/// Room for axis texts: left, right, above, below.
const MARGIN: [f64; 4] = [66.0, 22.0, 34.0, 52.0];
const INK: &str = "#2b2b2b";
const FAINT: &str = "#767676";
/// Pixels a unit in the PNG.
const PNG_SCALE: f32 = 2.0;

/// A name of the legend and its place.
struct LegendEntry<'a> {
    name: &'a str,
    /// `None` for the ring that marks the front.
    colour: Option<&'a str>,
    /// Left end.
    x: f64,
    /// Counted from above.
    line: usize,
}

impl Chart {
    /// The whole chart as an SVG document.
    pub fn svg(&self) -> String {
        let width = PANEL[0] * self.panels.len().max(1) as f64;
        let top = TOP + LEGEND_LINE * (self.legend_places(width).0 - 1) as f64;
        let height = top + PANEL[1] + BOTTOM;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"Ubuntu, Helvetica, Arial, sans-serif\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
        );
        text(&mut svg, [24.0, 28.0], 17.0, INK, "start", &self.title);
        self.legend(&mut svg, width);
        for (index, panel) in self.panels.iter().enumerate() {
            panel.draw(&mut svg, [PANEL[0] * index as f64, top]);
        }
        text(&mut svg, [24.0, height - 14.0], 11.0, FAINT, "start", &self.note);
        svg.push_str("</svg>\n");
        svg
    }

    /// Lines of the legend, and what stands in it.
    fn legend_places(&self, width: f64) -> (usize, Vec<LegendEntry<'_>>) {
        let mut names: Vec<(&str, Option<&str>)> = Vec::new();
        for series in self.panels.iter().flat_map(|p| &p.series) {
            if names.iter().all(|(known, _)| *known != series.name) {
                names.push((&series.name, Some(series.colour)));
            }
        }
        names.push(("best for its time", None));
        let (mut x, mut line) = (LEFT, 0);
        let mut places = Vec::new();
        for (name, colour) in names {
            let wide = 29.0 + 7.0 * name.chars().count() as f64;
            if x > LEFT && x + wide > width {
                (x, line) = (LEFT, line + 1);
            }
            places.push(LegendEntry { name, colour, x, line });
            x += wide + 26.0;
        }
        (line + 1, places)
    }

    fn legend(&self, svg: &mut String, width: f64) {
        for LegendEntry { name, colour, x, line } in self.legend_places(width).1 {
            let (y, middle) = (47.0 + LEGEND_LINE * line as f64, x + 11.0);
            let mark = match colour {
                Some(colour) => format!(
                    "<path d=\"M{x} {y}h22\" stroke=\"{colour}\" stroke-width=\"2.4\"/>\
                     <circle cx=\"{middle}\" cy=\"{y}\" r=\"3.4\" fill=\"{colour}\"/>"
                ),
                None => format!(
                    "<circle cx=\"{middle}\" cy=\"{y}\" r=\"6.5\" fill=\"none\" stroke=\"{INK}\" \
                     stroke-width=\"1.2\"/>"
                ),
            };
            svg.push_str(&mark);
            svg.push('\n');
            text(svg, [x + 29.0, y + 4.0], 12.5, INK, "start", name);
        }
    }

    /// Writes the chart as SVG.
    ///
    /// # Errors
    /// A refusal of the system.
    pub fn write_svg(&self, path: &Path) -> Result<(), ExportError> {
        let svg = self.svg();
        atomic::write(path, |file| file.write_all(svg.as_bytes()))
    }

    /// Writes the chart as PNG, with letters of its own: no font of the system is needed.
    ///
    /// # Errors
    /// A refusal of the system.
    pub fn write_png(&self, path: &Path) -> Result<(), ExportError> {
        let png = self.png().map_err(|what| ExportError::shape(path, what))?;
        atomic::write(path, |file| file.write_all(&png).map_err(io::Error::other))
    }

    fn png(&self) -> Result<Vec<u8>, String> {
        let mut fonts = usvg::fontdb::Database::new();
        fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
        fonts.set_sans_serif_family("Ubuntu");
        let options = usvg::Options {
            fontdb: Arc::new(fonts),
            font_family: "Ubuntu".to_owned(),
            ..usvg::Options::default()
        };
        let tree = usvg::Tree::from_str(&self.svg(), &options).map_err(|e| e.to_string())?;
        let size = tree.size().to_int_size().scale_by(PNG_SCALE).ok_or("the chart has no size")?;
        let mut pixels =
            tiny_skia::Pixmap::new(size.width(), size.height()).ok_or("the chart is too large")?;
        resvg::render(&tree, tiny_skia::Transform::from_scale(PNG_SCALE, PNG_SCALE), &mut pixels.as_mut());
        pixels.encode_png().map_err(|e| e.to_string())
    }
}

/// Whole decades around values, a little beyond them; never empty.
fn axis(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values
        .filter(|v| v.is_finite() && *v > 0.0)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    if high <= 0.0 {
        return [0.1, 10.0];
    }
    [low / 1.5, (high * 1.5).max(low * 4.0)]
}

impl Panel {
    fn draw(&self, svg: &mut String, [left, top]: [f64; 2]) {
        let [x0, x1] = [left + MARGIN[0], left + PANEL[0] - MARGIN[1]];
        let [y0, y1] = [top + PANEL[1] - MARGIN[3], top + MARGIN[2]];
        let all = || self.series.iter().flat_map(|s| &s.points);
        let [x_low, x_high] = axis(all().map(|p| p.x));
        // Interval ends may reach down to nothing; they do not stretch the axis beyond a factor two.
        let [y_low, y_high] = axis(all().map(|p| p.y));
        let place = |value: f64, [low, high]: [f64; 2], [from, to]: [f64; 2]| {
            from + (to - from) * (value.max(1e-300) / low).ln() / (high / low).ln()
        };
        let at_x = |v: f64| place(v, [x_low, x_high], [x0, x1]);
        let at_y = |v: f64| place(v, [y_low, y_high], [y0, y1]).clamp(y1, y0);
        text(svg, [x0, y1 - 12.0], 13.5, INK, "start", &self.title);

        // 1. Grid and numbers.
        for (value, major) in ticks([x_low, x_high]) {
            let x = at_x(value);
            let tone = if major { "#d4d4d4" } else { "#eeeeee" };
            let _ = writeln!(svg, "<path d=\"M{x:.1} {y0:.1}V{y1:.1}\" stroke=\"{tone}\"/>");
            if major {
                text(svg, [x, y0 + 17.0], 11.5, INK, "middle", &number(value));
            }
        }
        for (value, major) in ticks([y_low, y_high]) {
            let y = at_y(value);
            let tone = if major { "#d4d4d4" } else { "#eeeeee" };
            let _ = writeln!(svg, "<path d=\"M{x0:.1} {y:.1}H{x1:.1}\" stroke=\"{tone}\"/>");
            if major {
                text(svg, [x0 - 8.0, y + 4.0], 11.5, INK, "end", &number(value));
            }
        }
        let _ =
            writeln!(svg, "<path d=\"M{x0:.1} {y1:.1}V{y0:.1}H{x1:.1}\" fill=\"none\" stroke=\"{FAINT}\"/>");
        text(svg, [0.5 * (x0 + x1), y0 + 38.0], 12.0, INK, "middle", &self.x_label);
        let [x, y] = [left + 18.0, 0.5 * (y0 + y1)];
        let _ = writeln!(
            svg,
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" font-size=\"12\" fill=\"{INK}\" \
             text-anchor=\"middle\">{}</text>",
            escaped(&self.y_label)
        );

        // 2. Intervals, curves, points; then rings around the front.
        for series in &self.series {
            let colour = series.colour;
            for p in &series.points {
                let faint = if p.on_curve { 0.45 } else { 0.18 };
                let [low, high] = p.range.map(at_y);
                let x = at_x(p.x);
                let _ = writeln!(
                    svg,
                    "<path d=\"M{x:.1} {low:.1}V{high:.1}\" stroke=\"{colour}\" stroke-width=\"1.4\" \
                     opacity=\"{faint}\"/>"
                );
            }
            let curve: Vec<String> = series
                .points
                .iter()
                .filter(|p| p.on_curve)
                .map(|p| format!("{:.1} {:.1}", at_x(p.x), at_y(p.y)))
                .collect();
            if curve.len() > 1 {
                let _ = writeln!(
                    svg,
                    "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.4\" \
                     stroke-linejoin=\"round\"/>",
                    curve.join("L")
                );
            }
            for p in &series.points {
                let (radius, opacity) = if p.on_curve { (3.6, 1.0) } else { (2.6, 0.35) };
                let _ = writeln!(
                    svg,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\" fill=\"{colour}\" opacity=\"{opacity}\"/>",
                    at_x(p.x),
                    at_y(p.y)
                );
            }
        }
        for &[x, y] in &self.front {
            let _ = writeln!(
                svg,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"6.5\" fill=\"none\" stroke=\"{INK}\" \
                 stroke-width=\"1.2\"/>",
                at_x(x),
                at_y(y)
            );
        }
    }
}

/// Values to mark between two ends, and whether each gets a number: decades, and 2 and 5 between them
/// where there are few decades.
fn ticks([low, high]: [f64; 2]) -> Vec<(f64, bool)> {
    let few = (high / low).log10() < 2.5;
    let mut marks = Vec::new();
    let first = low.log10().floor() as i32;
    let last = high.log10().ceil() as i32;
    for decade in first..=last {
        for step in 1..10 {
            let value = f64::from(step) * 10.0_f64.powi(decade);
            if value >= low && value <= high {
                marks.push((value, step == 1 || few && (step == 2 || step == 5)));
            }
        }
    }
    marks
}

/// `0.05`, `2`, `1,000`.
fn number(value: f64) -> String {
    if value >= 1000.0 {
        let whole = value.round() as u64;
        return format!("{},{:03}", whole / 1000, whole % 1000);
    }
    let decimals = (-value.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}")
}

fn text(svg: &mut String, [x, y]: [f64; 2], size: f64, colour: &str, anchor: &str, what: &str) {
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{colour}\" text-anchor=\"{anchor}\">{}</text>",
        escaped(what)
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> Chart {
        let point = |x: f64, y: f64, on_curve| ChartPoint { x, y, range: [0.5 * y, 2.0 * y], on_curve };
        let panel = Panel {
            title: "Form factors & <visibility>".into(),
            x_label: "seconds".into(),
            y_label: "error, %".into(),
            series: vec![Series {
                name: "lines".into(),
                colour: "#c8641b",
                points: vec![point(0.1, 2.0, true), point(1.0, 0.2, true), point(1.0, 5.0, false)],
            }],
            front: vec![[0.1, 2.0], [1.0, 0.2]],
        };
        Chart { title: "room".into(), note: "as measured".into(), panels: vec![panel] }
    }

    #[test]
    fn the_svg_is_well_formed_and_points_lie_where_logarithms_put_them() {
        let svg = chart().svg();
        let tree = usvg::roxmltree::Document::parse(&svg).unwrap();
        assert!(svg.contains("Form factors &amp; &lt;visibility&gt;"));
        let dots: Vec<[f64; 2]> = tree
            .descendants()
            .filter(|n| n.attribute("fill") == Some("#c8641b") && n.attribute("r") != Some("3.4"))
            .map(|n| ["cx", "cy"].map(|a| n.attribute(a).unwrap().parse().unwrap()))
            .collect();
        assert_eq!(dots.len(), 3);
        assert!(dots[0][0] < dots[1][0], "more seconds lie further right");
        assert!(dots[0][1] < dots[1][1] && dots[2][1] < dots[0][1], "smaller errors lie lower");
        assert!((dots[1][0] - dots[2][0]).abs() < 0.2);
        let rings = tree.descendants().filter(|n| n.attribute("r") == Some("6.5")).count();
        assert_eq!(rings, 3, "two on the front, one in the legend");
    }

    #[test]
    fn the_png_shows_letters_without_any_font_of_the_system() {
        let png = chart().png().unwrap();
        let picture = image::load_from_memory(&png).unwrap().to_rgb8();
        assert_eq!(picture.width(), 1000);
        // Dark ink where the title stands.
        let dark = (40..200).any(|x| (30..60).any(|y| picture.get_pixel(x, y)[0] < 120));
        assert!(dark, "no title");
    }

    #[test]
    fn axes_are_marked_by_decades() {
        let numbers: Vec<String> =
            ticks([0.02, 30.0]).into_iter().filter(|t| t.1).map(|t| number(t.0)).collect();
        assert_eq!(numbers, ["0.1", "1", "10"]);
        assert_eq!(number(0.05), "0.05");
        assert_eq!(number(2000.0), "2,000");
        assert_eq!(axis(std::iter::empty()), [0.1, 10.0]);
    }
}
