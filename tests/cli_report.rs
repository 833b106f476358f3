//! `lumenwalk report`: one page that needs nothing beside it, and the table of its points.

mod cli_support;

use cli_support::Workplace;

fn number(text: &str, before: &str) -> f64 {
    let rest = &text[text.find(before).unwrap_or_else(|| panic!("{before}: {text}")) + before.len()..];
    rest.split(|c: char| c != '.' && !c.is_ascii_digit()).next().unwrap().parse().unwrap()
}

#[test]
fn a_page_tells_what_the_table_holds_and_whether_it_is_enough() {
    let place = Workplace::with_room(0.5);
    let quick = ["--patches", "200", "--size", "160x100"];
    let ask = |more: &[&str]| {
        place.succeed(&[&["report", "room.obj", "--out", "pages/first"], &quick[..], more].concat())
    };
    let told = ask(&["--use", "office"]);
    let page = place.text("pages/first/room.html");
    let table = place.text("pages/first/room-grid.csv");
    let column = table.lines().next().unwrap().split(',').position(|name| name == "lux").unwrap();
    let lux: Vec<f64> =
        table.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect();
    let mean = lux.iter().sum::<f64>() / lux.len() as f64;
    assert!(lux.len() > 10 && (number(&told, "mean ") / mean - 1.0).abs() < 6e-3, "{mean}: {told}");
    // All that is shown is in the page: plan, picture, lamp, materials, accuracy, and nothing from elsewhere.
    for words in [
        "<svg class=\"plan\"",
        "data:image/png;base64,",
        "Entrance",
        "Desk lamp",
        "paint",
        "Irradiance is off by",
        "5.26.2",
    ] {
        assert!(page.contains(words), "{words}");
    }
    assert!(!page.contains("http") && !page.contains("<script"), "nothing is fetched and nothing runs");
    assert_eq!(page.matches("class=\"lux\"").count(), lux.len(), "a number at each point");
    assert!(told.contains("Room 1: too dark") == (mean < 500.0), "{told}");
    // A corridor asks for less; dimming is heeded.
    let bright = ask(&["--use", "corridor"]);
    let dim = ask(&["--use", "corridor", "--dim", "Desk lamp=0.5"]);
    assert!((number(&dim, "mean ") / number(&bright, "mean ") - 0.5).abs() < 6e-3, "{bright}{dim}");
    assert!(place.text("pages/first/room.html").contains("<td class=\"n\">50 %</td>"));
    assert_eq!(place.files().iter().filter(|name| name.starts_with("pages")).count(), 1);
}

#[test]
fn what_cannot_be_written_up_is_refused_before_the_solve() {
    let place = Workplace::with_room(0.5);
    place.put("dark.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nf 1 2 3\n");
    let refused = |arguments: &[&str]| {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refused(&["report", "dark.obj", "--out", "a"]).contains("add --ceiling-lamps or --daylight"));
    assert!(refused(&["report", "room.obj", "--out", "a", "--use", "ballroom"]).contains("office"));
    assert!(refused(&["report", "room.obj", "--out", "a", "--height", "5000"]).contains("no room was found"));
    std::fs::remove_dir(place.path("a")).unwrap();
    place.put("taken", "");
    assert!(refused(&["report", "room.obj", "--out", "taken"]).contains("taken"));
    assert!(!place.path("a").exists(), "no folder is left behind");
}
