//! Texts of photometric files: encoding, lines, words and numbers.

use super::error::Fault;

/// Larger numbers are not measurements of a luminaire; products of a few such numbers stay finite.
const MOST: f64 = 1e12;
/// Smaller numbers count as zero, so that quotients stay finite.
const LEAST: f64 = 1e-12;

/// The text of a file. The end-of-file mark of DOS and zero bytes become blanks.
pub(super) fn decode(bytes: &[u8]) -> String {
    crate::encoding::decode(bytes).replace(['\u{1a}', '\0'], " ")
}

/// The lines of a text whatever its line ends: CRLF, LF, CR, and the doubled CR of broken transfers.
pub(super) fn lines(text: &str) -> Vec<String> {
    let joined = text.replace("\r\r\n", "\n").replace("\r\n", "\n").replace("\n\r", "\n").replace('\r', "\n");
    joined.lines().map(|line| line.trim().to_owned()).collect()
}

/// What a comma between two digits means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Commas {
    /// The end of a number.
    Separate,
    /// A decimal point, as many languages write it.
    Decimal,
}

/// A finite number of a plausible size; decimal commas and Fortran exponents (1.5D+02) are accepted.
pub(super) fn number(word: &str) -> Option<f64> {
    let word = word.trim();
    let parse = |text: &str| {
        let value = text.parse::<f64>().ok().filter(|value| value.abs() <= MOST)?;
        Some(if value.abs() < LEAST { 0.0 } else { value })
    };
    let with_digits = word.bytes().any(|byte| byte.is_ascii_digit());
    if !with_digits {
        return None;
    }
    parse(word).or_else(|| {
        let plain = word.replacen(',', ".", 1).replace(['d', 'D'], "e");
        parse(&plain)
    })
}

/// A word of a message: short, without control characters, in quotation marks.
pub(super) fn quoted(word: &str) -> String {
    let short: String = word.chars().take(24).map(|c| if c.is_control() { '?' } else { c }).collect();
    let more = if word.chars().count() > 24 { "..." } else { "" };
    format!("'{short}{more}'")
}

/// The numbers of a text in order, regardless of line breaks.
pub(super) struct Words<'a> {
    words: Vec<(usize, &'a str)>,
    next: usize,
    last_line: usize,
}

impl<'a> Words<'a> {
    /// The words of `lines`, the first of which has the number `first` in the file.
    pub(super) fn new(lines: &'a [String], first: usize, commas: Commas) -> Self {
        let separates =
            move |c: char| c.is_whitespace() || c == ';' || (c == ',' && commas == Commas::Separate);
        let words = lines
            .iter()
            .enumerate()
            .flat_map(|(index, line)| line.split(separates).map(move |word| (first + index, word)))
            .filter(|(_, word)| !word.is_empty())
            .collect();
        Self { words, next: 0, last_line: (first + lines.len()).saturating_sub(1) }
    }

    /// How many words follow.
    pub(super) fn left(&self) -> usize {
        self.words.len().saturating_sub(self.next)
    }

    /// The line of the next word, or the last line of the file.
    pub(super) fn line(&self) -> usize {
        self.words.get(self.next).map_or(self.last_line, |&(line, _)| line)
    }

    /// The next number; `what` names it in the fault.
    pub(super) fn number(&mut self, what: &str) -> Result<f64, Fault> {
        let Some(&(line, word)) = self.words.get(self.next) else {
            return Err(Fault::at(
                self.last_line,
                format!(
                    "the file ends where {what} should stand; it is incomplete, get it again from its source"
                ),
            ));
        };
        self.next += 1;
        number(word).ok_or_else(|| {
            Fault::at(
                line,
                format!("{what} should stand here, but {} is not a number; correct it", quoted(word)),
            )
        })
    }

    /// The next number as a count from `least` to `most`; files of 1986 may write 3.0 for 3.
    pub(super) fn count(&mut self, what: &str, least: usize, most: usize) -> Result<usize, Fault> {
        let line = self.line();
        let value = self.number(what)?;
        // Casting saturates, so that the comparison below catches everything.
        let count = value as usize;
        if count as f64 == value && (least..=most).contains(&count) {
            return Ok(count);
        }
        Err(Fault::at(
            line,
            format!(
                "{what} is {value}, but must be a whole number from {least} to {most}; check the order of \
                the numbers"
            ),
        ))
    }
}

/// The first word with a comma between two digits, which may be a decimal comma.
pub(super) fn comma_word(lines: &[String], first: usize) -> Option<(usize, &str)> {
    let has_comma = |word: &&str| {
        let bytes = word.as_bytes();
        bytes.windows(3).any(|w| matches!(w, [a, b',', b] if a.is_ascii_digit() && b.is_ascii_digit()))
    };
    lines
        .iter()
        .enumerate()
        .find_map(|(index, line)| line.split_whitespace().find(has_comma).map(|word| (first + index, word)))
}
