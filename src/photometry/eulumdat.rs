//! Reader of EULUMDAT (.ldt): one value per line (A. Stockmar, 1990; "EULUMDAT/2", 1998).

use super::description::Description;
use super::distribution::Distribution;
use super::error::Fault;
use super::planes::{Closing, HEMISPHERES, Noise, Planes, SAME, uncovered};
use super::text::{number, quoted};
use super::{Format, Housing, LampSet, Photometry, opening};

/// Metres in a millimetre.
const MILLIMETRE: f64 = 0.001;
/// More C planes and gamma angles than any goniophotometer takes.
const MOST_ANGLES: usize = 3601;
/// More sets of lamps than the format allows (20), with room for extensions.
const MOST_SETS: usize = 100;
/// Direct ratios for room indices 0.6 to 5.
const RATIOS: usize = 10;
/// Luminaires longer than this many metres are mistakes of units.
const MOST_METRES: f64 = 1000.0;

/// Whether lines 2 to 7 hold the numbers that they must: type, symmetry, counts and steps.
pub(super) fn is_eulumdat(lines: &[String]) -> bool {
    let head: Vec<Option<f64>> = lines.iter().skip(1).take(6).map(|line| number(line)).collect();
    // One spoilt number of the six still tells the format, and its fault is then named by its line.
    head.len() == 6 && head.iter().flatten().count() >= 5
}

/// The lines of the file, read in order.
struct Fields<'a> {
    lines: &'a [String],
    next: usize,
}

impl<'a> Fields<'a> {
    /// The next line as text, and its number from one.
    fn text(&mut self, what: &str) -> Result<(usize, &'a str), Fault> {
        let Some(line) = self.lines.get(self.next) else {
            return Err(Fault::at(
                self.lines.len(),
                format!(
                    "the file ends where {what} should stand; it is incomplete, get it again from its source"
                ),
            ));
        };
        self.next += 1;
        Ok((self.next, line.as_str()))
    }

    fn number(&mut self, what: &str) -> Result<f64, Fault> {
        let (line, text) = self.text(what)?;
        number(text).ok_or_else(|| {
            let found = if text.is_empty() {
                "the line is empty".to_owned()
            } else {
                format!("{} is not a number", quoted(text))
            };
            Fault::at(
                line,
                format!(
                    "{what} should stand here, but {found}; correct it, or remove a surplus line before it"
                ),
            )
        })
    }

    /// A number that makers leave out: nothing counts as 0.
    fn number_or_zero(&mut self, what: &str) -> Result<f64, Fault> {
        if self.lines.get(self.next).is_some_and(String::is_empty) {
            self.next += 1;
            return Ok(0.0);
        }
        self.number(what)
    }

    fn count(&mut self, what: &str, least: usize, most: usize) -> Result<usize, Fault> {
        let value = self.number(what)?;
        // Casting saturates, so that the comparison catches everything.
        let count = value as usize;
        if count as f64 == value && (least..=most).contains(&count) {
            return Ok(count);
        }
        Err(Fault::at(
            self.next,
            format!("{what} is {value}, but must be a whole number from {least} to {most}; correct it"),
        ))
    }

    /// A length in millimetres as metres.
    fn length(&mut self, what: &str) -> Result<f64, Fault> {
        let metres = self.number_or_zero(what)? * MILLIMETRE;
        if (0.0..=MOST_METRES).contains(&metres) {
            return Ok(metres);
        }
        Err(Fault::at(
            self.next,
            format!("{what} is {metres} m, which no luminaire has; lengths are in millimetres"),
        ))
    }
}

/// Reads EULUMDAT.
pub(super) fn read(lines: &[String]) -> Result<Photometry, Fault> {
    let end = lines.iter().rposition(|line| !line.is_empty()).map_or(0, |last| last + 1);
    let mut fields = Fields { lines: lines.get(..end).unwrap_or_default(), next: 0 };
    let mut notes = Vec::new();
    let manufacturer = fields.text("the manufacturer")?.1.to_owned();
    fields.number_or_zero("the type indicator Ityp")?;
    let symmetry = fields.count("the symmetry indicator Isym", 0, 4)?;
    let planes = fields.count("the number of C planes Mc", 1, MOST_ANGLES)?;
    fields.number_or_zero("the step of C Dc")?;
    let gammas = fields.count("the number of intensities in a plane Ng", 2, MOST_ANGLES)?;
    fields.number_or_zero("the step of gamma Dg")?;
    let mut text = |what: &str| fields.text(what).map(|(_, text)| text.to_owned());
    let (report, luminaire) = (text("the report number")?, text("the luminaire's name")?);
    let (catalogue_number, _file, date) =
        (text("the luminaire's number")?, text("the file's name")?, text("the date")?);
    let [length, width, height] = lengths(&mut fields, ["length", "width", "height"], "luminaire's")?;
    let [area_length, area_width] = lengths(&mut fields, ["length", "width"], "luminous area's")?;
    let heights = lengths(&mut fields, ["C0", "C90", "C180", "C270"], "luminous height at")?;
    let downward = fields.number_or_zero("the downward flux fraction")?;
    let output_ratio = fields.number_or_zero("the light output ratio")?;
    let conversion = conversion(&mut fields, &mut notes)?;
    let measurement_tilt = fields.number_or_zero("the tilt during the measurement")?;
    if measurement_tilt != 0.0 {
        notes.push(format!("the luminaire was tilted by {measurement_tilt} degrees during the measurement"));
    }
    let lamps = lamp_sets(&mut fields, &mut notes)?;
    let total: f64 = lamps.iter().map(|set| set.flux).sum();
    if total <= 0.0 {
        return Err(Fault::at(
            fields.next,
            "the lamps have no luminous flux, so cd/klm cannot become candela; enter the lumens of the lamps",
        ));
    }
    for _ in 0..RATIOS {
        fields.number_or_zero("a direct ratio")?;
    }
    let web = Web { symmetry, planes, gammas, factor: total / 1000.0 * conversion };
    let distribution = web.read(&mut fields, &mut notes)?;
    let left = fields.lines.len().saturating_sub(fields.next);
    if left > 0 {
        notes.push(format!("everything after line {}, the last intensity, is left out", fields.next));
    }
    let absolute = lamps.iter().any(|set| set.absolute);
    let share = |percent: f64| (percent > 0.0).then_some(percent / 100.0);
    Ok(Photometry {
        format: Format::Eulumdat,
        description: Description {
            manufacturer,
            luminaire,
            catalogue_number,
            lamp: lamps.first().map(|set| set.set.kind.clone()).unwrap_or_default(),
            report,
            date,
            keywords: Vec::new(),
        },
        distribution,
        opening: opening::of_eulumdat(area_length, area_width, heights.into_iter().fold(0.0, f64::max)),
        housing: (length > 0.0).then_some(Housing {
            along_c0: if width > 0.0 { width } else { length },
            along_c90: length,
            height,
            round: width == 0.0,
        }),
        stated_flux: if absolute { Some(total) } else { share(output_ratio).map(|ratio| total * ratio) },
        lamp_flux: (!absolute).then_some(total),
        stated_downward_share: share(downward),
        watts: lamps.iter().map(|set| set.set.watts).sum(),
        lamps: lamps.into_iter().map(|set| set.set).collect(),
        tilt: None,
        measurement_tilt,
        notes,
    })
}

fn lengths<const N: usize>(fields: &mut Fields<'_>, names: [&str; N], of: &str) -> Result<[f64; N], Fault> {
    let mut lengths = [0.0; N];
    for (length, name) in lengths.iter_mut().zip(names) {
        *length = fields.length(&format!("the {of} {name}"))?;
    }
    Ok(lengths)
}

fn conversion(fields: &mut Fields<'_>, notes: &mut Vec<String>) -> Result<f64, Fault> {
    let factor = fields.number_or_zero("the conversion factor")?;
    if factor < 0.0 {
        return Err(Fault::at(
            fields.next,
            format!("the conversion factor is {factor}; write 1 where nothing is to change"),
        ));
    }
    if factor == 0.0 {
        notes.push("the conversion factor is 0 or missing: it is taken as 1".to_owned());
        return Ok(1.0);
    }
    if factor != 1.0 {
        notes.push(format!("all intensities are multiplied by the file's conversion factor {factor}"));
    }
    Ok(factor)
}

/// A set of lamps, and what it means for the intensities.
struct Set {
    set: LampSet,
    flux: f64,
    absolute: bool,
}

/// Six values per set, field by field (all numbers, all types ...); where that order does not parse, set by
/// set, as some programs write them.
fn lamp_sets(fields: &mut Fields<'_>, notes: &mut Vec<String>) -> Result<Vec<Set>, Fault> {
    let count = fields.count("the number of lamp sets", 1, MOST_SETS)?;
    let start = fields.next;
    let at = |line: usize| fields.lines.get(line).and_then(|text| number(text)).is_some();
    let by_field = (0..count).all(|set| at(start + set) && at(start + 2 * count + set));
    let by_set = (0..count).all(|set| at(start + 6 * set) && at(start + 6 * set + 2));
    let set_by_set = count > 1 && by_set && !by_field;
    if count > 1 {
        notes.push(format!("the fluxes of the file's {count} lamp sets are added"));
    }
    let mut sets = Vec::with_capacity(count);
    for set in 0..count {
        let mut seek = |field: usize| {
            fields.next = start + if set_by_set { 6 * set + field } else { field * count + set };
            Fields { lines: fields.lines, next: fields.next }
        };
        let lamps = seek(0).number_or_zero("the number of lamps")?;
        let kind = seek(1).text("the type of lamp")?.1.to_owned();
        let mut flux_at = seek(2);
        let flux = flux_at.number("the flux of the lamps")?;
        if flux < 0.0 {
            return Err(Fault::at(flux_at.next, format!("the flux of the lamps is {flux} lm; correct it")));
        }
        let colour = seek(3).text("the colour of the lamps")?.1.to_owned();
        let rendering = seek(4).text("the colour rendering of the lamps")?.1.to_owned();
        let watts = seek(5).number_or_zero("the power of the lamps")?.max(0.0);
        // A negative number of lamps marks absolute photometry: the flux is that of the luminaire.
        let absolute = lamps < 0.0;
        let lumens = (!absolute).then_some(flux);
        let set = LampSet { count: lamps.abs(), kind, lumens, colour, rendering, watts };
        sets.push(Set { set, flux, absolute });
    }
    fields.next = start + 6 * count;
    Ok(sets)
}

/// The table of intensities.
struct Web {
    symmetry: usize,
    planes: usize,
    gammas: usize,
    factor: f64,
}

impl Web {
    fn read(&self, fields: &mut Fields<'_>, notes: &mut Vec<String>) -> Result<Distribution, Fault> {
        let c_line = fields.next + 1;
        let c = angles(fields, self.planes, "C", 360.0)?;
        let gamma = angles(fields, self.gammas, "gamma", 180.0)?;
        let stored = self.stored(&c).map_err(|message| Fault::at(c_line, message))?;
        let left = fields.lines.len().saturating_sub(fields.next);
        let wanted = stored.len() * self.gammas;
        if left < wanted {
            return Err(Fault::at(
                fields.lines.len(),
                format!(
                    "{} planes of {} intensities must follow the angles, but the file ends after {left} of \
                    {wanted} values; get it again from its source",
                    stored.len(),
                    self.gammas
                ),
            ));
        }
        let mut rows = Vec::with_capacity(stored.len());
        let mut noise = Noise::default();
        for angle in &stored {
            let mut row = Vec::with_capacity(self.gammas);
            for index in 1..=self.gammas {
                let what = format!("intensity {index} of {} at C {}", self.gammas, angle.rem_euclid(360.0));
                let value = fields.number(&what)? * self.factor;
                row.push(noise.without(value, fields.next));
            }
            rows.push(row);
        }
        noise.judge(notes)?;
        notes.extend(uncovered(&gamma, "gamma", &HEMISPHERES));
        let (made, closing) = Distribution::type_c(Planes { angles: stored, rows }, gamma)
            .map_err(|invalid| Fault::at(c_line, format!("{invalid}; correct the C angles or Isym")))?;
        if let Closing::Bridged { last } = closing {
            notes.push(format!("the C angles end at {last} degrees: the rest of the circle is interpolated"));
        }
        Ok(made)
    }

    /// The C angles of the planes whose intensities are stored, ascending: all, one, or those of a half or
    /// quarter.
    fn stored(&self, c: &[f64]) -> Result<Vec<f64>, String> {
        let near = |angle: f64, wanted: f64| (angle - wanted).abs() <= SAME;
        let (half, quarter) = (self.planes / 2, self.planes / 4);
        let (from, count, first, last) = match self.symmetry {
            0 => return Ok(c.to_vec()),
            1 => return Ok(vec![0.0]),
            2 => (0, half + 1, 0.0, 180.0),
            // From C270 over C0 to C90; the planes after C0 are those of the next turn.
            3 => (3 * quarter, half + 1, 270.0, 450.0),
            _ => (0, quarter + 1, 0.0, 90.0),
        };
        let turned = c.iter().copied().chain(c.iter().map(|angle| angle + 360.0));
        let stored: Vec<f64> = turned.skip(from).take(count).collect();
        let fits = stored.first().is_some_and(|&angle| near(angle, first))
            && stored.last().is_some_and(|&angle| near(angle, last));
        if fits && stored.len() == count {
            return Ok(stored);
        }
        Err(format!(
            "with Isym {} the stored planes must run from C{first} to C{}, but the {} listed C angles do \
            not divide so; correct Isym, Mc or the C angles",
            self.symmetry,
            last.rem_euclid(360.0),
            self.planes
        ))
    }
}

fn angles(fields: &mut Fields<'_>, count: usize, which: &str, most: f64) -> Result<Vec<f64>, Fault> {
    let mut angles: Vec<f64> = Vec::with_capacity(count);
    for index in 1..=count {
        let what = format!("{which} angle {index} of {count}");
        let angle = fields.number(&what)?;
        if !(-SAME..=most + SAME).contains(&angle) {
            return Err(Fault::at(
                fields.next,
                format!(
                    "{what} is {angle} degrees, but must lie within 0 to {most}; check Mc and Ng against \
                    the lines"
                ),
            ));
        }
        let angle = angle.clamp(0.0, most);
        if let Some(&last) = angles.last().filter(|&&last| last >= angle) {
            return Err(Fault::at(
                fields.next,
                format!(
                    "{what} is {angle} degrees and does not ascend after {last}; check Mc and Ng against \
                    the lines"
                ),
            ));
        }
        angles.push(angle);
    }
    Ok(angles)
}
