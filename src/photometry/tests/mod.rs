//! Tests against closed forms, quadrature and hand-written files.

mod eulumdat;
mod faults;
mod fuzz;
mod geometry;
mod lm_63;

use super::{Photometry, read};
use std::fmt::Write;

/// A table as words, ten in a line.
fn wrapped(values: impl IntoIterator<Item = f64>) -> String {
    let words: Vec<String> = values.into_iter().map(|value| format!("{value}")).collect();
    words.chunks(10).map(|line| line.join(" ") + "\n").collect()
}

/// LM-63-2002 of photometric type `kind` with intensities from `candela(vertical, horizontal)`.
fn ies_of(kind: u8, vertical: &[f64], horizontal: &[f64], candela: impl Fn(f64, f64) -> f64) -> String {
    let mut text = format!(
        "IESNA:LM-63-2002\n[MANUFAC] Lumen Works\n[LUMCAT] LW 7\n[LUMINAIRE] Test lamp\n[LAMP] LED 3000 \
        K\nTILT=NONE\n\
         1 -1 1 {} {} {kind} 2 0.1 1.2 0\n1 1 20\n",
        vertical.len(),
        horizontal.len()
    );
    text += &wrapped(vertical.iter().copied());
    text += &wrapped(horizontal.iter().copied());
    for &h in horizontal {
        text += &wrapped(vertical.iter().map(|&v| candela(v, h)));
    }
    text
}

/// EULUMDAT with `planes` C angles all round and intensities in cd/klm of 1000 lm lamps.
fn ldt_of(
    symmetry: u8,
    planes: usize,
    stored: &[f64],
    gammas: &[f64],
    candela: impl Fn(f64, f64) -> f64,
) -> String {
    let step = 360.0 / planes as f64;
    let mut text = format!(
        "Lumen Works\n3\n{symmetry}\n{planes}\n{step}\n{}\n0\nreport\nTest lamp\nLW \
        7\nlw7.ldt\n2024-05-01\n1200\n100\n40\n1200\n\
         100\n0\n0\n0\n0\n100\n80\n1\n0\n1\n1\nLED\n1000\n3000\n80\n20\n",
        gammas.len()
    );
    text += &"0.5\n".repeat(10);
    for plane in 0..planes {
        let _ = writeln!(text, "{}", plane as f64 * step);
    }
    for gamma in gammas {
        let _ = writeln!(text, "{gamma}");
    }
    for &c in stored {
        for &gamma in gammas {
            let _ = writeln!(text, "{}", candela(c, gamma));
        }
    }
    text
}

fn good(text: &str) -> Photometry {
    match read("test", text.as_bytes()) {
        Ok(photometry) => photometry,
        Err(error) => panic!("{error}\n{text}"),
    }
}

/// Evenly spaced angles, both ends included.
fn every(step: f64, from: f64, to: f64) -> Vec<f64> {
    let count = ((to - from) / step).round() as usize;
    (0..=count).map(|i| from + i as f64 * step).collect()
}

#[track_caller]
fn near(found: f64, wanted: f64, within: f64) {
    assert!((found - wanted).abs() <= within, "{found} instead of {wanted}, more than {within} apart");
}
