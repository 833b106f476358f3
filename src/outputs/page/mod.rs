//! A solved scene as one page of HTML that needs nothing beside it: plans, pictures, lamps, materials, and how sure all of
//! it is. It prints on A4.

mod plan;

pub use plan::LitPlane;

use super::target::Target;
use crate::scene::{LUMINOUS_EFFICACY, Lighting, Scene, Summary, luminance_weighted};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write as _;

/// What a page holds.
pub struct Page<'a> {
    /// What was solved.
    pub scene: &'a Scene,
    /// As its lamps were switched.
    pub lighting: &'a Lighting,
    /// Name of each picture, and its PNG file.
    pub pictures: Vec<(String, Vec<u8>)>,
    /// Work planes, room by room.
    pub planes: Vec<LitPlane>,
    /// What all rooms are to have.
    pub target: Option<Target>,
    /// Estimated error of what is shown: a headline and lines below it.
    pub accuracy: Vec<String>,
    /// Settings and what the solve took, each a name and a value.
    pub settings: Vec<(String, String)>,
    /// What is doubtful about the model.
    pub doubts: Vec<String>,
}

const STYLE: &str = "\
:root{color-scheme:light}body{font:14px/1.5 system-ui,sans-serif;color:#1c1c1e;max-width:900px;margin:32px auto;\
padding:0 24px}h1{font-size:28px;margin:0 0 4px}h2{font-size:19px;margin:36px 0 8px;border-bottom:1px solid #d8d8dc;\
padding-bottom:4px}h3{font-size:15px;margin:20px 0 6px}p{margin:6px 0}.quiet{color:#63636a}\
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}th{text-align:left;font-weight:600;\
color:#63636a}th,td{padding:3px 12px 3px 0;border-bottom:1px solid #ececf0;vertical-align:top}\
td.n,th.n{text-align:right}figure{margin:14px 0;break-inside:avoid}figure img{width:100%;border-radius:4px}\
figcaption{color:#63636a}.plan{max-width:100%;height:auto;display:block;background:#f6f6f8;border-radius:4px}\
.wall{stroke:#1c1c1e;stroke-width:1.4;fill:none}.lamp{stroke:#c77700;stroke-width:1.4;fill:none}\
.isolux{stroke:#fff;stroke-width:1.2;fill:none;opacity:.85}.lux{fill:#fff;text-anchor:middle;paint-order:stroke;\
stroke:#0006;stroke-width:2}.level{fill:#ffd479;font-size:11px;font-weight:600;paint-order:stroke;stroke:#000a;\
stroke-width:2.5}.ruler{stroke:#1c1c1e;fill:none}.metre{font-size:11px}.met{color:#1a7f37;font-weight:600}\
.missed{color:#b3261e;font-weight:600}.swatch{display:inline-block;width:14px;height:14px;border-radius:3px;\
border:1px solid #0003;vertical-align:-2px;margin-right:8px}section{break-inside:avoid}\
@media print{body{margin:0;max-width:none;padding:0}h2{break-after:avoid}}@page{size:A4;margin:16mm}";

/// The page as HTML.
pub fn html(page: &Page<'_>) -> String {
    let summary = Summary::of(page.scene);
    let title = escaped(&page.scene.name);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{title} - light</title><style>{STYLE}</style></head><body>\n\
         <h1>{title}</h1>\n"
    );
    let size = summary.bounds.size();
    let _ = writeln!(
        out,
        "<p class=\"quiet\">{:.2} &times; {:.2} &times; {:.2} m, {} surfaces, {} lamps. Computed by Lumenwalk {}.</p>",
        size.x,
        size.y,
        size.z,
        grouped(summary.surfaces as f64),
        summary.luminaires.len(),
        env!("CARGO_PKG_VERSION")
    );
    rooms(&mut out, page);
    pictures(&mut out, page);
    lamps(&mut out, page, &summary);
    materials(&mut out, &summary);
    list(&mut out, "Accuracy", &page.accuracy);
    let settings: Vec<String> =
        page.settings.iter().map(|(name, value)| row(&[escaped(name), escaped(value)], 2)).collect();
    table(&mut out, "Settings", "", &settings);
    list(&mut out, "What is doubtful about the model", &page.doubts);
    out += "</body></html>\n";
    out
}

fn rooms(out: &mut String, page: &Page<'_>) {
    if page.planes.is_empty() {
        *out += "<h2>Rooms</h2><p>No room was found: a room has a floor, a ceiling and walls.</p>\n";
        return;
    }
    *out += "<h2>Rooms</h2>\n";
    if let Some(target) = page.target {
        let _ = writeln!(
            out,
            "<p>Held against EN 12464-1:2011, {} &ldquo;{}&rdquo;: at least {} lx in the mean, uniformity U<sub>0</sub> \
             of at least {:.2}. Values are those of new lamps in a clean room: a maintenance factor is not applied.{}</p>",
            target.clause,
            escaped(target.name),
            target.lux,
            target.uniformity,
            if is_day(page) { " The present sky and sun count as well: at night there is less." } else { "" }
        );
    }
    let verdict_head = if page.target.is_some() { "<th></th>" } else { "" };
    let daylight = page.planes.iter().any(|plane| plane.report.daylight_factor_percent.is_some());
    let daylight_head = if daylight { "<th class=\"n\">mean DF</th>" } else { "" };
    let rows: Vec<String> = page
        .planes
        .iter()
        .map(|plane| {
            let lux = plane.report.illuminance_lx;
            let uniformity =
                plane.report.uniformity.map_or_else(|| "none".to_owned(), |u0| format!("{u0:.2}"));
            let mut cells = vec![
                escaped(&plane.report.name),
                format!("{:.2} &times; {:.2} m", plane.report.size_m[0], plane.report.size_m[1]),
                format!("{:.2} m", plane.report.height_m),
                format!("{} lx", significant(lux.mean)),
                format!("{} lx", significant(lux.minimum)),
                format!("{} lx", significant(lux.maximum)),
                uniformity,
            ];
            if daylight {
                let factor = plane.report.daylight_factor_percent;
                cells.push(factor.map_or_else(String::new, |df| format!("{} %", significant(df.mean))));
            }
            if let Some(target) = page.target {
                cells.push(verdict(&target, plane));
            }
            row(&cells, 2)
        })
        .collect();
    let head = format!(
        "<th>room</th><th>size</th><th class=\"n\">plane</th><th class=\"n\">mean</th><th class=\"n\">min</th>\
         <th class=\"n\">max</th><th class=\"n\">U<sub>0</sub></th>{daylight_head}{verdict_head}"
    );
    let _ = writeln!(out, "<table><tr>{head}</tr>{}</table>", rows.concat());
    for plane in &page.planes {
        let [dx, dy] = plane.report.spacing_m;
        let _ = writeln!(
            out,
            "<section><h3>{}</h3>\n{}\n<p class=\"quiet\">Lux at {} points {dx:.2} &times; {dy:.2} m apart, {:.2} m above \
             the floor; lines of equal illuminance in lux; in black what stands at that height, in orange lamps.</p></section>",
            escaped(&plane.report.name),
            plan::svg(plane, page.scene),
            plane.report.points,
            plane.report.height_m
        );
    }
}

/// Whether sky or sun are on.
fn is_day(page: &Page<'_>) -> bool {
    let outdoors = page.scene.outdoors.as_ref();
    outdoors.is_some_and(|outdoors| {
        [outdoors.sky, outdoors.sun].iter().any(|&lamp| {
            page.lighting.lamps.get(lamp as usize).is_some_and(|state| state.output() != [0.0; 3])
        })
    })
}

fn verdict(target: &Target, plane: &LitPlane) -> String {
    let class = if target.met(&plane.report) == [true, true] { "met" } else { "missed" };
    format!("<span class=\"{class}\">{}</span>", target.verdict(&plane.report))
}

fn pictures(out: &mut String, page: &Page<'_>) {
    if page.pictures.is_empty() {
        return;
    }
    *out += "<h2>Views</h2>\n";
    for (name, png) in &page.pictures {
        let _ = writeln!(
            out,
            "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>",
            escaped(name),
            STANDARD.encode(png)
        );
    }
}

fn lamps(out: &mut String, page: &Page<'_>, summary: &Summary) {
    let mut total = 0.0;
    let rows: Vec<String> = summary
        .luminaires
        .iter()
        .zip(&page.lighting.lamps)
        .map(|(lamp, state)| {
            let share = if state.on { state.dimmer } else { 0.0 };
            let state_now = match (state.on, state.dimmer) {
                (false, _) => "off".to_owned(),
                (true, dimmer) if dimmer < 1.0 => format!("{:.0} %", 100.0 * dimmer),
                _ => "on".to_owned(),
            };
            let strength = match lamp.lux {
                Some(_) => {
                    format!(
                        "{} lx outdoors",
                        significant(LUMINOUS_EFFICACY * luminance_weighted(state.output()))
                    )
                }
                None => {
                    total += share * lamp.lumens;
                    format!("{} lm", grouped(share * lamp.lumens))
                }
            };
            row(&[escaped(&lamp.name), state_now, strength], 1)
        })
        .collect();
    let head = "<th>lamp</th><th class=\"n\">state</th><th class=\"n\">gives</th>";
    table(out, "Lamps", head, &rows);
    if !rows.is_empty() {
        let _ = writeln!(out, "<p class=\"quiet\">{} lm in all, without daylight.</p>", grouped(total));
    }
}

fn materials(out: &mut String, summary: &Summary) {
    let used = summary.materials.iter().filter(|material| material.surfaces > 0);
    let rows: Vec<String> = used
        .map(|material| {
            let code = |linear: f64| (255.0 * linear.clamp(0.0, 1.0).powf(1.0 / 2.2)).round() as u8;
            let [r, g, b] = material.reflectance.map(code);
            let name = format!(
                "<span class=\"swatch\" style=\"background:#{r:02x}{g:02x}{b:02x}\"></span>{}",
                escaped(&material.name)
            );
            let image = if material.textured { ", times its image" } else { "" };
            let reflectance = format!("{:.2}{image}", luminance_weighted(material.reflectance));
            row(&[name, reflectance, format!("{} m&sup2;", significant(material.area))], 1)
        })
        .collect();
    let head = "<th>material</th><th class=\"n\">reflectance</th><th class=\"n\">area</th>";
    table(out, "Materials", head, &rows);
}

/// A row of which the cells from `numbers` on stand on the right.
fn row(cells: &[String], numbers: usize) -> String {
    let cell = |(k, text): (usize, &String)| match k >= numbers {
        true => format!("<td class=\"n\">{text}</td>"),
        false => format!("<td>{text}</td>"),
    };
    format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
}

fn table(out: &mut String, title: &str, head: &str, rows: &[String]) {
    if !rows.is_empty() {
        let head = if head.is_empty() { String::new() } else { format!("<tr>{head}</tr>") };
        let _ = writeln!(out, "<h2>{title}</h2>\n<table>{head}{}</table>", rows.concat());
    }
}

fn list(out: &mut String, title: &str, lines: &[String]) {
    if !lines.is_empty() {
        let items: String = lines.iter().map(|line| format!("<p>{}</p>\n", escaped(line))).collect();
        let _ = writeln!(out, "<h2>{title}</h2>\n{items}");
    }
}

/// Text as HTML has it.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Three digits.
fn significant(value: f64) -> String {
    match value.abs() {
        v if v >= 99.95 => grouped(value),
        v if v >= 9.995 => format!("{value:.1}"),
        v if v > 0.0 => format!("{value:.2}"),
        _ => "0".to_owned(),
    }
}

/// A whole number with its thousands apart.
fn grouped(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    if value < 0.0 && digits != "0" { format!("-{text}") } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{GridReport, WorkPlaneReport};
    use crate::scene::from_text;
    use glam::DVec3;

    fn page(scene: &Scene, lighting: &Lighting, target: Option<&str>) -> String {
        let lux = [400.0, 600.0, 500.0, 700.0];
        let found = GridReport::of(&lux).expect("values");
        let report = WorkPlaneReport {
            name: "Room <1>".to_owned(),
            size_m: [4.0, 3.0],
            height_m: 0.8,
            spacing_m: [1.0, 1.0],
            points: 4,
            illuminance_lx: found,
            uniformity: Some(found.minimum / found.mean),
            daylight_factor_percent: None,
        };
        let points = (0..4).map(|k| DVec3::new(f64::from(k % 2), 0.8, f64::from(k / 2))).zip(lux).collect();
        html(&Page {
            scene,
            lighting,
            pictures: vec![("From & to".to_owned(), vec![1, 2, 3])],
            planes: vec![LitPlane { report, points }],
            target: target.and_then(Target::of),
            accuracy: vec!["error 2 %".to_owned()],
            settings: vec![("patches".to_owned(), "3,000".to_owned())],
            doubts: Vec::new(),
        })
    }

    #[test]
    fn a_page_holds_what_was_found_and_names_cannot_break_it() {
        let text = "mtllib m.mtl\nusemtl a<b\nv 0 0 0\nv 4 0 0\nv 4 0 4\nf 3 2 1\no lamp\nusemtl light\nv 1 2 1\nv 2 2 1\nv 2 2 2\nf 4 5 6\n";
        let mtl = "newmtl a<b\nKd .5 .5 .5\nnewmtl light\nKd 0 0 0\nKe 10 10 10\n";
        let scene = from_text("t", text, mtl, None).expect("a scene");
        let mut lighting = scene.lighting();
        lighting.lamps[0].dimmer = 0.5;
        let page = page(&scene, &lighting, Some("office"));
        for words in [
            "Room &lt;1&gt;",
            "From &amp; to",
            "data:image/png;base64,AQID",
            "a&lt;b",
            "5.26.2",
            "<span class=\"met\">met</span>",
            "<td class=\"n\">50 %</td>",
            "<td class=\"n\">550 lx</td>",
            "error 2 %",
        ] {
            assert!(page.contains(words), "{words}: {page}");
        }
        // Half of pi times 10 W/(m2 sr) from half a square metre, at 179 lm/W.
        assert!(page.contains("1,406 lm in all"), "{page}");
        assert!(!page.contains("What is doubtful") && !page.contains("http"), "{page}");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [0.0, 0.123, 12.34, 123.4, 12345.6, 99.97].map(significant),
            ["0", "0.12", "12.3", "123", "12,346", "100"]
        );
    }
}
