//! A sweep as a chart: form factors on the left, the whole picture on the right.

use super::sweep::pareto;
use super::table::Row;
use crate::export::{Chart, ChartPoint, Panel, Series};
use crate::form_factors::{Method, ReceivingPoints};

/// Curves: method, receiving points, name and colour.
pub(super) const CURVES: [(Method, ReceivingPoints, &str, &str); 8] = [
    (Method::Lines, ReceivingPoints::Auto, "lines", "#cf6a17"),
    (Method::Lines, ReceivingPoints::One, "lines, 1 point", "#e6b48a"),
    (Method::Lines, ReceivingPoints::Sixteen, "lines, 16 points", "#8c4209"),
    (Method::Hemicube, ReceivingPoints::Auto, "hemicube, turned", "#2c6fb3"),
    (Method::Hemicube, ReceivingPoints::Sixteen, "hemicube, turned, 16 points", "#173f68"),
    (Method::AlignedHemicube, ReceivingPoints::One, "hemicube (1985)", "#8a5fb0"),
    (Method::AlignedHemicube, ReceivingPoints::Sixteen, "hemicube (1985), 16 points", "#553a70"),
    (Method::Rays, ReceivingPoints::Auto, "rays", "#5f9150"),
];

/// Draws the rows of one scene. Left: the error of form factors against the seconds of the rows, at
/// the scene's usual number of patches (that with most rows). Right: the error as shown against all
/// seconds, a curve through the best of each method and number of receiving points.
pub fn chart(rows: &[Row]) -> Chart {
    let scene = rows.first().map_or("", |row| row.scene.as_str());
    let threads = rows.first().map_or(1, |row| row.threads);
    let count = |wanted: usize| rows.iter().filter(|r| r.entry.patches == wanted).count();
    let usual = rows.iter().map(|r| r.entry.patches).max_by_key(|&n| (count(n), n)).unwrap_or(0);
    let at_usual: Vec<&Row> = rows.iter().filter(|r| r.entry.patches == usual).collect();
    let patches = at_usual.first().map_or(0, |r| r.patches);

    let form_factors = panel(
        &at_usual,
        format!("Form factors and visibility, {patches} patches"),
        "seconds for all rows",
        |r| (r.seconds[1], r.budget.form_factors),
    );
    let all: Vec<&Row> = rows.iter().collect();
    let shown =
        panel(&all, "The picture as shown, any patch size".into(), "seconds for the whole solve", |r| {
            (r.total_seconds, r.budget.total)
        });
    let plural = if threads == 1 { "" } else { "s" };
    Chart {
        title: format!("{scene}: what accuracy costs"),
        note: format!(
            "RMS error of irradiance over the receiving area, relative to its mean, found by independent rays; \
             bars: 95 % intervals; {threads} thread{plural}."
        ),
        panels: vec![form_factors, shown],
    }
}

fn panel(
    rows: &[&Row],
    title: String,
    x_label: &str,
    of: impl Fn(&Row) -> (f64, crate::accuracy::Estimate),
) -> Panel {
    let place = |r: &Row| {
        let (seconds, e) = of(r);
        [seconds, 100.0 * e.error]
    };
    let places: Vec<[f64; 2]> = rows.iter().map(|r| place(r)).collect();
    let front = pareto(&places).into_iter().map(|i| places[i]).collect();
    let series = CURVES
        .into_iter()
        .filter_map(|(method, points, name, colour)| {
            let is_own = |r: &&Row| r.entry.method == method && r.entry.points == points;
            let mut own: Vec<&Row> = rows.iter().copied().filter(is_own).collect();
            own.retain(|r| place(r).iter().all(|v| *v > 0.0));
            own.sort_by(|a, b| place(a)[0].total_cmp(&place(b)[0]));
            let best = pareto(&own.iter().map(|r| place(r)).collect::<Vec<_>>());
            let points = own
                .iter()
                .enumerate()
                .map(|(i, r)| {
                    let (x, e) = of(r);
                    let range = [e.low, e.high].map(|v| 100.0 * v);
                    ChartPoint { x, y: 100.0 * e.error, range, on_curve: best.contains(&i) }
                })
                .collect::<Vec<_>>();
            (!points.is_empty()).then(|| Series { name: name.to_owned(), colour, points })
        })
        .collect();
    Panel { title, x_label: x_label.to_owned(), y_label: "error, %".to_owned(), series, front }
}
