//! Reader of IES LM-63: header, keywords, TILT and the numbers before the angles.

use super::description::Description;
use super::error::Fault;
use super::ies_web::{self, Kind};
use super::opening;
use super::text::{Commas, Words, comma_word, quoted};
use super::tilt::{LampPosition, Tilt};
use super::{Format, LampSet, Photometry};

/// Metres in a foot.
const FOOT: f64 = 0.3048;
/// More angles than any goniophotometer measures.
const MOST_ANGLES: usize = 7201;
/// More pairs than any TILT table has.
const MOST_TILTS: usize = 1000;
/// Openings beyond this many metres are mistakes of units.
const MOST_METRES: f64 = 1000.0;

/// What TILT= says.
enum TiltLine<'a> {
    None,
    Include,
    File(&'a str),
}

/// Whether the lines are LM-63: a TILT line, or a first line of its name.
pub(super) fn is_lm_63(lines: &[String]) -> bool {
    tilt_line(lines).is_some() || named_edition(lines).is_some()
}

/// Reads LM-63 of any edition.
pub(super) fn read(lines: &[String]) -> Result<Photometry, Fault> {
    let mut notes = Vec::new();
    let edition = named_edition(lines);
    let year = edition.map_or(1986, |(_, year)| year);
    let Some((tilt_at, tilt)) = tilt_line(lines) else {
        return Err(Fault::whole(
            "the file has the name of LM-63 in its first line but no TILT= line, so its numbers cannot be \
            found; add TILT=NONE before them",
        ));
    };
    if let TiltLine::File(file) = tilt {
        notes.push(format!(
            "the tilt factors are in another file, {}, which is not read: the light is taken as the same in \
            every position",
            quoted(file)
        ));
    }
    let labels = lines.get(edition.map_or(0, |(at, _)| at + 1)..tilt_at).unwrap_or_default();
    let description = describe(labels);
    let (body, first) = (lines.get(tilt_at + 1..).unwrap_or_default(), tilt_at + 2);
    let included = matches!(tilt, TiltLine::Include);
    let parse = |commas| {
        let mut words = Words::new(body, first, commas);
        numbers(&mut words, year, included).map(|found| (found, words.left(), words.line()))
    };
    let separated = parse(Commas::Separate);
    // Decimal commas give too many numbers, or wrong ones; where the other reading fits exactly, they are the
    // reason.
    if !matches!(separated, Ok((_, 0, _)))
        && let Some((line, word)) = comma_word(body, first)
        && matches!(parse(Commas::Decimal), Ok((_, 0, _)))
    {
        return Err(Fault::at(
            line,
            format!(
                "{} has a decimal comma, but commas separate numbers in LM-63; export the file with decimal \
                points",
                quoted(word)
            ),
        ));
    }
    let (mut found, left, line) = separated?;
    if left > 0 {
        notes.push(format!("everything from line {line} on, after the last intensity, is left out"));
    }
    notes.append(&mut found.notes);
    let lamp = description.lamp.clone();
    Ok(Photometry {
        format: Format::Lm63 { year },
        description,
        distribution: found.distribution,
        opening: found.opening,
        housing: None,
        lamps: vec![LampSet {
            count: found.lamps,
            kind: lamp,
            lumens: found.lamp_lumens,
            colour: String::new(),
            rendering: String::new(),
            watts: found.watts,
        }],
        stated_flux: None,
        lamp_flux: found.lamp_lumens.map(|lumens| lumens * found.ballast),
        stated_downward_share: None,
        watts: found.watts,
        tilt: found.tilt,
        measurement_tilt: 0.0,
        notes,
    })
}

/// The line of the edition's name and its year; unknown later years count as 2019.
fn named_edition(lines: &[String]) -> Option<(usize, u16)> {
    let (at, line) = lines.iter().enumerate().find(|(_, line)| !line.is_empty())?;
    let name = line.to_ascii_uppercase();
    let edition = name.split_once("LM-63-").map(|(_, year)| year).or(name.strip_prefix("IESNA"))?;
    let digits: String = edition.chars().take_while(char::is_ascii_digit).collect();
    let stated = match digits.parse::<u16>() {
        Ok(short @ 86..=99) => 1900 + short,
        Ok(short @ 0..=85) => 2000 + short,
        Ok(year) => year,
        // Free text that happens to begin so.
        Err(_) => return None,
    };
    let editions = [1986, 1991, 1995, 2002, 2019];
    Some((at, editions.into_iter().rev().find(|&edition| edition <= stated).unwrap_or(1986)))
}

fn tilt_line(lines: &[String]) -> Option<(usize, TiltLine<'_>)> {
    lines.iter().enumerate().find_map(|(at, line)| {
        let (key, value) = line.split_once('=')?;
        if !key.trim().eq_ignore_ascii_case("TILT") {
            return None;
        }
        let value = value.trim();
        let tilt = match value.to_ascii_uppercase().as_str() {
            "NONE" | "" => TiltLine::None,
            "INCLUDE" => TiltLine::Include,
            _ => TiltLine::File(value),
        };
        Some((at, tilt))
    })
}

/// The keywords between the first line and TILT; lines of 1986, which have none, become the luminaire's name.
fn describe(labels: &[String]) -> Description {
    let mut keywords: Vec<(String, String)> = Vec::new();
    let mut plain = Vec::new();
    for line in labels.iter().filter(|line| !line.is_empty()) {
        let Some((key, text)) = line.strip_prefix('[').and_then(|rest| rest.split_once(']')) else {
            plain.push(line.as_str());
            continue;
        };
        let (key, text) = (key.trim().to_ascii_uppercase(), text.trim());
        match keywords.last_mut() {
            Some((_, before)) if key == "MORE" => {
                before.push(' ');
                before.push_str(text);
            }
            _ => keywords.push((key, text.to_owned())),
        }
    }
    let mut description = Description::of_keywords(keywords);
    if description.keywords.is_empty() {
        description.luminaire = plain.join(" ");
    }
    description
}

/// Everything after the TILT line.
struct Numbers {
    tilt: Option<Tilt>,
    lamps: f64,
    lamp_lumens: Option<f64>,
    ballast: f64,
    watts: f64,
    opening: opening::Opening,
    distribution: super::Distribution,
    notes: Vec<String>,
}

fn numbers(words: &mut Words<'_>, year: u16, included: bool) -> Result<Numbers, Fault> {
    let mut notes = Vec::new();
    let tilt = if included { Some(read_tilt(words)?) } else { None };
    if let Some(factor) =
        tilt.as_ref().map(|tilt| tilt.factor(0.0)).filter(|&factor| (factor - 1.0).abs() > 1e-3)
    {
        notes.push(format!("the tilt factor of the level luminaire is {factor} instead of 1"));
    }
    let line = words.line();
    let lamps = words.number("the number of lamps")?;
    let lumens = words.number("the lumens per lamp")?;
    if lamps < 0.0 {
        return Err(Fault::at(
            line,
            format!("the number of lamps is {lamps}; write how many the luminaire has"),
        ));
    }
    // Minus one is the mark of absolute photometry.
    let lamp_lumens = (lumens >= 0.0).then_some(lamps * lumens);
    let multiplier = positive(words, "the candela multiplier")?;
    let vertical = words.count("the number of vertical angles", 1, MOST_ANGLES)?;
    let horizontal = words.count("the number of horizontal angles", 1, MOST_ANGLES)?;
    let kind = match words.count("the photometric type", 1, 3)? {
        1 => Kind::C,
        2 => Kind::B,
        _ => Kind::A,
    };
    let (opening, note) = read_opening(words, year)?;
    notes.extend(note);
    let ballast = positive(words, "the ballast factor")?;
    let lamp_factor = lamp_factor(words, year, &mut notes)?;
    let watts = words.number("the input watts")?;
    let factor = multiplier * ballast * lamp_factor;
    let distribution = ies_web::read(words, kind, (vertical, horizontal), factor, &mut notes)?;
    Ok(Numbers { tilt, lamps, lamp_lumens, ballast, watts: watts.max(0.0), opening, distribution, notes })
}

/// The field between ballast factor and watts: the ballast-lamp photometric factor until 1991, reserved in
/// 1995 and 2002, the file generation type in 2019.
fn lamp_factor(words: &mut Words<'_>, year: u16, notes: &mut Vec<String>) -> Result<f64, Fault> {
    if year < 1995 {
        return positive(words, "the ballast-lamp factor");
    }
    let value = words.number("the field after the ballast factor")?;
    if year < 2019 && value != 1.0 {
        notes.push(format!(
            "the field after the ballast factor is {value}: it is reserved since 1995 and multiplies nothing"
        ));
    }
    Ok(1.0)
}

fn positive(words: &mut Words<'_>, what: &str) -> Result<f64, Fault> {
    let line = words.line();
    let value = words.number(what)?;
    if value > 0.0 {
        return Ok(value);
    }
    Err(Fault::at(
        line,
        format!("{what} is {value}, but must be greater than 0; write 1 where nothing is to change"),
    ))
}

fn read_opening(words: &mut Words<'_>, year: u16) -> Result<(opening::Opening, Option<String>), Fault> {
    let line = words.line();
    let unit = words.number("the unit of length")?;
    let size_line = words.line();
    let sizes = [
        words.number("the opening's width")?,
        words.number("the opening's length")?,
        words.number("the opening's height")?,
    ];
    let metres = match unit {
        1.0 => FOOT,
        2.0 => 1.0,
        _ if sizes == [0.0; 3] => 1.0,
        _ => {
            return Err(Fault::at(
                line,
                format!("the unit of length is {unit}, but must be 1 (feet) or 2 (metres)"),
            ));
        }
    };
    let [width, length, height] = sizes.map(|size| size * metres);
    if let Some(size) = [width, length, height].into_iter().find(|size| size.abs() > MOST_METRES) {
        return Err(Fault::at(
            size_line,
            format!("the opening is {} m long, which no luminaire is; check the unit of length", size.abs()),
        ));
    }
    Ok(opening::of_lm_63(year, width, length, height))
}

fn read_tilt(words: &mut Words<'_>) -> Result<Tilt, Fault> {
    let position = match words.count("the lamp-to-luminaire geometry of TILT", 1, 3)? {
        1 => LampPosition::Vertical,
        2 => LampPosition::Horizontal,
        _ => LampPosition::TiltedWithLuminaire,
    };
    let count = words.count("the number of tilt angles", 1, MOST_TILTS)?;
    let mut angles: Vec<f64> = Vec::new();
    for _ in 0..count {
        let line = words.line();
        let angle = words.number("a tilt angle")?;
        if angles.last().is_some_and(|&last| last >= angle) {
            return Err(Fault::at(
                line,
                format!("the tilt angle {angle} does not ascend; put the angles in order"),
            ));
        }
        angles.push(angle);
    }
    let mut factors = Vec::new();
    for _ in 0..count {
        let line = words.line();
        let factor = words.number("a tilt factor")?;
        if factor < 0.0 {
            return Err(Fault::at(line, format!("the tilt factor {factor} is negative; correct it")));
        }
        factors.push(factor);
    }
    Ok(Tilt { position, angles, factors })
}
