//! Intensities, fluxes and angles against closed forms and quadrature.

use super::*;
use crate::photometry::{Distribution, MainPlane, Opening, direction};
use glam::{DVec3, dvec3};
use std::f64::consts::PI;

/// A distribution without any symmetry, whose intensity everyone can compute.
fn lopsided(e: DVec3) -> f64 {
    1000.0 * (-e.z).max(0.0).powi(2) * (1.0 + 0.5 * e.x + 0.3 * e.y)
}

fn rotational(gammas: &[f64], candela: impl Fn(f64) -> f64) -> Distribution {
    let candelas: Vec<f64> = gammas.iter().map(|gamma| candela(gamma.to_radians()).max(0.0)).collect();
    Distribution::new(&[0.0], gammas, &candelas).unwrap()
}

#[test]
fn lambert_sphere_and_cosine_powers_have_their_fluxes() {
    let lambert = rotational(&every(0.25, 0.0, 90.0), |gamma| 100.0 * gamma.cos());
    near(lambert.flux(), 100.0 * PI, 100.0 * PI * 2e-6);
    near(lambert.upward_flux(), 0.0, 0.0);
    near(rotational(&[0.0, 180.0], |_| 100.0).flux(), 400.0 * PI, 1e-9);
    // 1000 cos^k in steps of 5 and 10 degrees: the integral of the straight lines between the samples.
    for (k, five, ten) in [
        (1, 3139.5974, 3133.5934),
        (2, 2097.0497, 2104.9686),
        (4, 1259.8201, 1269.2855),
        (8, 701.6630, 712.0952),
    ] {
        for (step, wanted) in [(5.0, five), (10.0, ten)] {
            let made = rotational(&every(step, 0.0, 90.0), |gamma| 1000.0 * gamma.cos().powi(k));
            near(made.flux(), wanted, 6e-5);
        }
    }
}

#[test]
fn a_steep_edge_integrates_without_cancellation() {
    // The light ends within a billionth of a degree.
    let cut =
        Distribution::new(&[0.0], &[0.0, 45.0, 45.0 + 1e-9, 90.0], &[1000.0, 1000.0, 0.0, 0.0]).unwrap();
    near(cut.flux(), 2000.0 * PI * (1.0 - 0.5_f64.sqrt()), 1e-6);
}

#[test]
fn flux_is_the_integral_of_the_intensity() {
    let (c, gammas) = (every(40.0, 0.0, 360.0), [0.0, 10.0, 35.0, 80.0, 120.0, 180.0]);
    let candelas: Vec<f64> = (0..c.len() * gammas.len()).map(|i| ((i * 37) % 101) as f64).collect();
    let made = Distribution::new(&c, &gammas, &candelas).unwrap();
    // Midpoints of a fine grid over C and cos gamma, by directions alone.
    let (turns, levels) = (720, 4000);
    let mut sum = 0.0;
    for level in 0..levels {
        let z = 1.0 - (level as f64 + 0.5) * 2.0 / levels as f64;
        for turn in 0..turns {
            let (sin, cos) = ((turn as f64 + 0.5) * 2.0 * PI / turns as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            sum += made.intensity(dvec3(r * cos, r * sin, z));
        }
    }
    let wanted = sum * 4.0 * PI / (turns * levels) as f64;
    near(made.flux(), wanted, 2e-5 * wanted);
    let zones = made.zonal_fluxes(7.0);
    near(zones.iter().map(|zone| zone.lumens).sum(), made.flux(), 1e-9 * wanted);
    near(made.downward_flux() + made.upward_flux(), made.flux(), 1e-9 * wanted);
}

#[test]
fn intensity_is_exact_at_samples_and_bilinear_between() {
    let made = Distribution::new(&[0.0, 90.0, 180.0, 270.0, 360.0], &[0.0, 45.0, 90.0], &{
        let mut table = vec![0.0; 15];
        table[3..6].copy_from_slice(&[8.0, 40.0, 16.0]);
        table
    })
    .unwrap();
    near(made.intensity_at(90.0, 45.0), 40.0, 0.0);
    near(made.intensity(dvec3(0.0, 3.0, -3.0)), 40.0, 1e-12);
    near(made.intensity_at(45.0, 45.0), 20.0, 1e-12);
    near(made.intensity_at(90.0 - 360.0, 67.5), 28.0, 1e-12);
    near(made.intensity_at(135.0, 22.5), 12.0, 1e-12);
    near(made.intensity_at(90.0, 90.0), 16.0, 0.0);
    near(made.intensity(dvec3(0.0, 1.0, 0.0)), 16.0, 1e-9);
    for dark in [dvec3(0.0, 1.0, 1e-3), DVec3::ZERO, DVec3::NAN, DVec3::Z] {
        near(made.intensity(dark), 0.0, 0.0);
    }
    let peak = made.maximum();
    assert_eq!((peak.candela, peak.gamma), (40.0, 45.0));
    near(peak.c, 90.0, 1e-12);
}

#[test]
fn types_a_and_b_give_the_light_of_type_c() {
    let c = good(&ies_of(1, &every(1.0, 0.0, 180.0), &every(2.0, 0.0, 360.0), |gamma, c| {
        lopsided(direction(c, gamma))
    }));
    let b = good(&ies_of(2, &every(1.0, -90.0, 90.0), &every(1.0, -90.0, 90.0), |v, h| {
        let ((sv, cv), (sh, ch)) = (v.to_radians().sin_cos(), h.to_radians().sin_cos());
        lopsided(dvec3(ch * sv, -sh, -ch * cv))
    }));
    let a = good(&ies_of(3, &every(1.0, -90.0, 90.0), &every(2.0, -180.0, 180.0), |v, h| {
        let ((sv, cv), (sh, ch)) = (v.to_radians().sin_cos(), h.to_radians().sin_cos());
        lopsided(dvec3(cv * ch, -cv * sh, sv))
    }));
    for (gamma, turn) in [(0.0, 0.0), (17.3, 10.0), (44.4, 95.0), (61.2, 200.5), (80.9, 333.3), (88.0, 271.0)]
    {
        let e = direction(turn, gamma);
        for photometry in [&a, &b, &c] {
            near(photometry.intensity(e), lopsided(e), 0.4);
        }
    }
    // The linear terms vanish over a turn: the flux is that of 1000 cos^2.
    for photometry in [&a, &b, &c] {
        near(photometry.flux(), 2000.0 * PI / 3.0, 0.3);
        near(photometry.distribution.downward_flux(), photometry.flux(), 0.1);
        let zones = photometry.distribution.zonal_fluxes(30.0);
        // From 30 to 60 degrees: 2000 pi / 3 (cos^3 30 - cos^3 60).
        near(zones[1].lumens, 2000.0 * PI / 3.0 * (0.75_f64.powf(1.5) - 0.125), 0.2);
        let curve = photometry.distribution.polar_curve(MainPlane::C90C270, 10.0);
        near(curve.iter().find(|point| point[0] == -30.0).unwrap()[1], lopsided(direction(270.0, 30.0)), 0.1);
    }
    assert!(a.notes.is_empty() && b.notes.is_empty() && c.notes.is_empty());
}

#[test]
fn types_a_and_b_have_their_axes_where_the_standard_puts_them() {
    // One sample of 100 cd each; everything else is dark.
    let only = |v0: f64, h0: f64| move |v: f64, h: f64| if v == v0 && h == h0 { 100.0 } else { 0.0 };
    let tens = every(10.0, -90.0, 90.0);
    // Type B: the vertical angle turns from nadir towards C0, horizontal angles are clockwise: towards C270.
    let b = good(&ies_of(2, &tens, &tens, only(30.0, 0.0)));
    near(b.distribution.intensity_at(0.0, 30.0), 100.0, 1e-9);
    let b = good(&ies_of(2, &tens, &tens, only(0.0, 20.0)));
    near(b.distribution.intensity_at(270.0, 20.0), 100.0, 1e-9);
    near(b.distribution.intensity_at(90.0, 20.0), 0.0, 1e-9);
    // Type A: both 0 is level and ahead (C0); vertical angles rise, horizontal angles are clockwise.
    let a = good(&ies_of(3, &tens, &tens, only(10.0, 30.0)));
    near(a.distribution.intensity_at(330.0, 100.0), 100.0, 1e-9);
    let peak = a.distribution.maximum();
    near(peak.c, 330.0, 1e-9);
    near(peak.gamma, 100.0, 1e-9);
    // Behind the luminaire, half a turn away, nothing is tabulated.
    near(a.distribution.intensity_at(150.0, 100.0), 0.0, 0.0);
    // The edges of an open circle belong to it, whatever rounding does to a direction.
    for kind in [2, 3] {
        let edged = good(&ies_of(kind, &tens, &tens, |_, _| 7.0));
        let edges = if kind == 2 { [0.0, 180.0] } else { [90.0, 270.0] };
        for c in edges.iter().flat_map(|c| [c - 360.0, *c, c + 720.0]) {
            near(edged.distribution.intensity_at(c, 90.0), 7.0, 1e-12);
            near(edged.intensity(5.0 * direction(c, 90.0)), 7.0, 1e-12);
        }
    }
    // Horizontal angles from 0 on stand for both sides.
    let b = good(&ies_of(2, &tens, &every(10.0, 0.0, 90.0), only(0.0, 20.0)));
    near(b.distribution.intensity_at(90.0, 20.0), 100.0, 1e-9);
    near(b.distribution.intensity_at(270.0, 20.0), 100.0, 1e-9);
    let a = good(&ies_of(3, &tens, &every(10.0, 0.0, 90.0), only(0.0, 30.0)));
    near(a.distribution.intensity_at(30.0, 90.0), 100.0, 1e-9);
    near(a.distribution.intensity_at(330.0, 90.0), 100.0, 1e-9);
}

#[test]
fn a_full_sphere_of_every_type_has_four_pi() {
    let (half, full) = (every(30.0, -90.0, 90.0), every(30.0, -180.0, 180.0));
    for (kind, v, h) in [(2, &full, &half), (3, &half, &full)] {
        let sphere = good(&ies_of(kind, v, h, |_, _| 10.0));
        near(sphere.flux(), 40.0 * PI, 1e-9);
        assert!(sphere.notes.is_empty(), "{:?}", sphere.notes);
        near(sphere.distribution.upward_flux(), 20.0 * PI, 1e-6);
        for e in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            near(sphere.intensity(e), 10.0, 1e-9);
        }
    }
}

#[test]
fn beam_and_field_angles_are_those_of_the_curve() {
    let lambert = rotational(&every(0.5, 0.0, 90.0), |gamma| 100.0 * gamma.cos());
    for plane in MainPlane::ALL {
        near(lambert.beam(plane).unwrap().angle(), 120.0, 1e-3);
        near(lambert.field(plane).unwrap().angle(), 2.0 * 0.1_f64.acos().to_degrees(), 1e-3);
    }
    // Light upwards only: the angle runs over the zenith.
    let up = rotational(&every(0.5, 90.0, 180.0), |gamma| -100.0 * gamma.cos());
    near(up.beam(MainPlane::C0C180).unwrap().angle(), 120.0, 1e-3);
    near(up.upward_flux(), 100.0 * PI, 0.01);
    // Never below a half, and cut off where the table ends.
    near(rotational(&[0.0, 180.0], |_| 1.0).beam(MainPlane::C0C180).unwrap().angle(), 360.0, 0.0);
    near(rotational(&[0.0, 70.0], |_| 1.0).field(MainPlane::C0C180).unwrap().angle(), 140.0, 0.0);
    assert_eq!(rotational(&[0.0, 90.0], |_| 0.0).beam(MainPlane::C0C180), None);
    // A triangle to one side: up from 0 at nadir to the peak at 40 of C90, down to 0 at 60.
    let table =
        [[0.0, 0.0, 0.0], [0.0, 80.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]].concat();
    let side = Distribution::new(&[0.0, 90.0, 180.0, 270.0, 360.0], &[0.0, 40.0, 60.0], &table).unwrap();
    let beam = side.beam(MainPlane::C90C270).unwrap();
    assert_eq!((beam.from, beam.peak, beam.to), (20.0, 40.0, 50.0));
    assert_eq!(side.beam(MainPlane::C0C180), None);
}

#[test]
fn polar_curves_run_from_side_to_side() {
    let made = rotational(&[0.0, 33.0, 90.0], |gamma| gamma.cos());
    let curve = made.polar_curve(MainPlane::C0C180, 10.0);
    assert!(curve.windows(2).all(|pair| pair[0][0] < pair[1][0]));
    assert_eq!((curve[0][0], curve[curve.len() - 1][0]), (-180.0, 180.0));
    let at = |angle: f64| curve.iter().find(|point| point[0] == angle).map(|point| point[1]);
    assert_eq!(at(-33.0), Some(33.0_f64.to_radians().cos()));
    assert_eq!((at(0.0), at(100.0)), (Some(1.0), Some(0.0)));
}

#[test]
fn scaling_keeps_the_shape() {
    let made = Photometry::made("lamp", rotational(&[0.0, 90.0], |_| 2.0), Opening::POINT);
    let scaled = made.with_flux(1000.0).unwrap();
    near(scaled.flux(), 1000.0, 1e-9);
    near(scaled.distribution.intensity_at(10.0, 10.0), 500.0 / PI, 1e-9);
    for wrong in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(made.with_flux(wrong).is_none());
    }
    assert_eq!(made.with_flux(0.0).unwrap().flux(), 0.0);
    assert!(scaled.with_flux(0.0).unwrap().with_flux(5.0).is_none());
}

#[test]
fn tables_that_are_none_are_refused() {
    let refused = |c: &[f64], gammas: &[f64], count: usize, value: f64| {
        Distribution::new(c, gammas, &vec![value; count]).unwrap_err().to_string()
    };
    assert!(refused(&[0.0], &[0.0, 90.0], 3, 1.0).contains("do not hold 3"));
    assert!(refused(&[0.0], &[], 0, 1.0).contains("do not hold"));
    assert!(refused(&[], &[0.0], 0, 1.0).contains("no half-plane"));
    assert!(refused(&[0.0], &[0.0, 190.0], 2, 1.0).contains("within 0 to 180"));
    assert!(refused(&[0.0], &[90.0, 0.0], 2, 1.0).contains("must ascend"));
    assert!(refused(&[0.0, f64::NAN], &[0.0, 90.0], 4, 1.0).contains("not finite"));
    assert!(refused(&[0.0, 400.0], &[0.0, 90.0], 4, 1.0).contains("horizontal angles run"));
    assert!(refused(&[0.0], &[0.0, 90.0], 2, f64::INFINITY).contains("finite"));
    assert!(refused(&[0.0], &[0.0, 90.0], 2, -1.0).contains("negative"));
}
