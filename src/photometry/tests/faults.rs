//! Each fault is one sentence that names the file, the line, what is wrong and what to do.

use super::*;

const IES: &str = "IESNA:LM-63-2002\n[LUMINAIRE] Spot\nTILT=NONE\n1 1000 1 3 3 1 2 0.1 0.2 0\n1 1 18\n0 45 \
90\n0 45 90\n\
    500 400 0\n510 410 0\n520 420 0\n";

#[track_caller]
fn fault(text: &str, wanted: &str) {
    let error = read("lamp.ies", text.as_bytes()).expect_err("should be refused").to_string();
    assert!(error.starts_with("lamp.ies") && error.contains(wanted), "'{error}' does not say '{wanted}'");
    // One sentence: a place, what is wrong and, after a semicolon or comma, what to do.
    assert!(!error.ends_with('.') && !error.contains('\n') && !error.contains(". "), "{error}");
}

#[test]
fn faults_of_lm_63() {
    good(IES);
    let broken = |from: &str, to: &str, wanted: &str| {
        assert!(IES.contains(from));
        fault(&IES.replacen(from, to, 1), wanted);
    };
    broken("TILT=NONE\n", "", "no TILT= line");
    broken(
        "1 1000 1 3",
        "1 many 1 3",
        "line 4: the lumens per lamp should stand here, but 'many' is not a number",
    );
    broken("1 1000 1 3", "-1 1000 1 3", "line 4: the number of lamps is -1");
    broken("1 1000 1 3", "1 1000 0 3", "line 4: the candela multiplier is 0, but must be greater than 0");
    broken(
        "1 1000 1 3 3",
        "1 1000 1 2.5 3",
        "line 4: the number of vertical angles is 2.5, but must be a whole number",
    );
    broken("1 1000 1 3 3", "1 1000 1 3 -3", "the number of horizontal angles is -3");
    broken("1 1000 1 3 3", "1 1000 1 1e9 3", "the number of vertical angles is 1000000000");
    broken("1 1000 1 3 3", "1 1000 1 7000 7000", "49014000 numbers must follow, but only 15 do");
    broken("1 1000 1 3 3", "1 1000 1 3 4", "line 6: 3 vertical and 4 horizontal angles are announced");
    broken(
        "1 1000 1 3 3 1",
        "1 1000 1 3 3 4",
        "the photometric type is 4, but must be a whole number from 1 to 3",
    );
    broken("1 2 0.1", "1 3 0.1", "the unit of length is 3, but must be 1 (feet) or 2 (metres)");
    broken("0.1 0.2 0", "100 2000 0", "2000 m long");
    broken("1 1 18", "0 1 18", "line 5: the ballast factor is 0");
    broken(
        "0 45 90\n0 45",
        "0 90 45\n0 45",
        "line 6: vertical angle 3 of 3 is 45 degrees and does not ascend after 90",
    );
    broken(
        "0 45 90\n0 45",
        "0 45 190\n0 45",
        "line 6: vertical angle 3 of 3 is 190 degrees, but must lie within 0 to 180",
    );
    broken(
        "0 45 90\n500",
        "0 45 45\n500",
        "line 7: horizontal angle 3 of 3 is 45 degrees and does not ascend",
    );
    broken(
        "0 45 90\n500",
        "0 45 100\n500",
        "line 7: the horizontal angles run from 0 to 100 degrees, but must be 0 alone",
    );
    broken(
        "510 410",
        "510 abc",
        "line 9: intensity 2 of 3 at the horizontal angle 45 should stand here, but 'abc'",
    );
    broken("510 410", "510 inf", "'inf' is not a number");
    broken("510 410", "510 1e300", "'1e300' is not a number");
    broken("510 410", "510 -410", "line 9: the intensity -410 cd is negative");
    broken("520 420 0\n", "520 420\n", "15 numbers must follow, but only 14 do");
    broken("1 1000 1 3 3 1 2 0.1 0.2 0\n1 1 18", "1 1000", "candela multiplier");
    fault("IESNA91\nTILT=NONE\n1 1000", "line 3: the file ends where the candela multiplier should stand");
    // Decimal commas: here the commas make too many words.
    let commas = IES.replace("0.1 0.2", "0,1 0,2").replace("500 400", "500,5 400,5");
    fault(&commas, "line 4: '0,1' has a decimal comma, but commas separate numbers in LM-63");
    // The signs and angles of types A and B.
    fault(&ies_of(2, &[0.0, 90.0], &[0.0], |_, _| 1.0), "types A and B need two or more horizontal angles");
    fault(&ies_of(2, &[0.0, 90.0], &[0.0, 120.0], |_, _| 1.0), "must lie within -90 to 90");
    fault(&ies_of(3, &[0.0, 120.0], &[0.0, 90.0], |_, _| 1.0), "must lie within -90 to 90");
    fault(&ies_of(1, &[0.0], &[0.0], |_, _| 1.0), "two or more vertical angles");
    let tilt = |table: &str, wanted: &str| {
        fault(&IES.replace("TILT=NONE", &format!("TILT=INCLUDE\n{table}")), wanted)
    };
    tilt("4\n1\n0\n1", "line 4: the lamp-to-luminaire geometry of TILT is 4");
    tilt("1\n2\n90 0\n1 1", "line 6: the tilt angle 0 does not ascend");
    tilt("1\n2\n0 90\n1 -1", "line 7: the tilt factor -1 is negative");
}

#[test]
fn faults_of_eulumdat() {
    let text = ldt_of(4, 8, &[0.0, 45.0, 90.0], &[0.0, 45.0, 90.0], |_, _| 100.0);
    let lamp = good(&text);
    near(lamp.distribution.intensity_at(200.0, 20.0), 100.0, 1e-9);
    let lines: Vec<&str> = text.lines().collect();
    let with = |line: usize, value: &str| {
        let mut changed = lines.clone();
        changed[line - 1] = value;
        changed.join("\n")
    };
    let broken = |line: usize, value: &str, wanted: &str| fault(&with(line, value), wanted);
    broken(3, "5", "line 3: the symmetry indicator Isym is 5, but must be a whole number from 0 to 4");
    broken(4, "many", "line 4: the number of C planes Mc should stand here, but 'many' is not a number");
    broken(4, "0", "line 4: the number of C planes Mc is 0");
    broken(4, "1e6", "line 4: the number of C planes Mc is 1000000");
    broken(6, "", "line 6: the number of intensities in a plane Ng should stand here, but the line is empty");
    broken(13, "-5", "line 13: the luminaire's length is -0.005 m");
    broken(16, "12000000", "line 16: the luminous area's length is 12000 m");
    broken(24, "-1", "line 24: the conversion factor is -1");
    broken(26, "0", "line 26: the number of lamp sets is 0");
    broken(29, "1e-300", "the lamps have no luminous flux");
    broken(29, "0", "the lamps have no luminous flux");
    broken(29, "-7", "line 29: the flux of the lamps is -7 lm");
    broken(29, "LED", "line 29: the flux of the lamps should stand here, but 'LED' is not a number");
    broken(44, "0", "line 44: C angle 2 of 8 is 0 degrees and does not ascend after 0");
    broken(44, "400", "line 44: C angle 2 of 8 is 400 degrees, but must lie within 0 to 360");
    broken(45, "80", "line 43: with Isym 4 the stored planes must run from C0 to C90");
    broken(52, "190", "must lie within 0 to 180");
    broken(55, "?", "line 55: intensity 2 of 3 at C 0 should stand here, but '?' is not a number");
    broken(55, "-50", "line 55: the intensity -50 cd is negative");
    fault(&lines[..lines.len() - 2].join("\n"), "the file ends after 7 of 9 values");
    fault(&lines[..29].join("\n"), "line 29: the file ends where the colour of the lamps should stand");
    // Listed planes of one half only do not make a circle.
    let half = ldt_of(0, 8, &every(45.0, 0.0, 315.0), &[0.0, 90.0], |_, _| 1.0);
    let mut lines: Vec<String> = half.lines().map(str::to_owned).collect();
    for (plane, line) in lines[42..50].iter_mut().enumerate() {
        *line = (15 * plane).to_string();
    }
    fault(&lines.join("\n"), "the horizontal angles run from 0 to 105 degrees");
}

#[test]
fn other_files_are_refused() {
    fault("", "the file is empty");
    fault("\r\n \r\n", "the file is empty");
    fault("v 0 0 0\nf 1 2 3\n", "neither IES LM-63 (no line starts with TILT=) nor EULUMDAT");
    let error = read("x", &[0xff, 0xd8, 0xff, 0xe0, 0, 0x10]).unwrap_err();
    assert_eq!(error.line, None);
    assert!(read("x", &vec![b' '; 9 << 20]).unwrap_err().message.contains("8 MiB"));
}
