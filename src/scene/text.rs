//! Texts of model files: their lines, words, names and numbers.

use super::names;
use crate::watch::Watch;
use std::borrow::Cow;
use std::io::{self, BufRead, Read};
use unicode_normalization::UnicodeNormalization;

/// Splits text into logical lines: continuations joined, each with its (first) number from one. A comment
/// ends with its line, whatever its last character.
pub(super) fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (index, first) = lines.next()?;
        let mut line = Cow::Borrowed(first.trim());
        while line.ends_with('\\') && !line.split_whitespace().any(|word| word.starts_with('#')) {
            let joined = line.to_mut();
            joined.pop();
            joined.push(' ');
            joined.push_str(lines.next().map_or("", |(_, next)| next.trim()));
        }
        Some((index + 1, line))
    })
}

/// The first word of a line in lower case, as programs differ there, and the trimmed rest.
pub(super) fn keyword(line: &str) -> (Cow<'_, str>, &str) {
    let (word, rest) = match line.split_once(char::is_whitespace) {
        Some((word, rest)) => (word, rest.trim()),
        None => (line, ""),
    };
    let has_capitals = word.bytes().any(|b| b.is_ascii_uppercase());
    (if has_capitals { Cow::Owned(word.to_ascii_lowercase()) } else { Cow::Borrowed(word) }, rest)
}

/// The words of a line up to a comment.
pub(super) fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|word| !word.starts_with('#'))
}

/// A number of a file, or what is wrong with it.
pub(super) fn number(word: &str) -> Result<f64, String> {
    word.parse().map_err(|_| {
        let name = names::short(word);
        if word.matches(',').count() == 1 && word.replacen(',', ".", 1).parse::<f64>().is_ok() {
            return format!(
                "'{name}' is not a number: it has a decimal comma; export the file with decimal points"
            );
        }
        format!("'{name}' is not a number")
    })
}

/// What some programs put around names.
const QUOTES: [char; 2] = ['"', '\''];

/// A name without the quotation marks that some programs put around it.
pub(super) fn unquoted(name: &str) -> &str {
    let name = name.trim();
    let inner = QUOTES.into_iter().find_map(|mark| name.strip_prefix(mark)?.strip_suffix(mark));
    inner.map(str::trim).filter(|inner| !inner.is_empty()).unwrap_or(name)
}

/// A name without a comment behind it. Names may hold `#` themselves, so that the whole is tried first.
pub(super) fn uncommented(name: &str) -> &str {
    let starts = name
        .char_indices()
        .filter(|&(at, c)| c == '#' && name[..at].chars().next_back().is_some_and(char::is_whitespace));
    starts.map(|(at, _)| name[..at].trim_end()).next().unwrap_or(name)
}

/// The names in a list up to a comment: separated by blanks, or in quotation marks where they hold some.
pub(super) fn listed(list: &str) -> Vec<&str> {
    let mut rest = list.trim();
    let mut found = Vec::new();
    while !rest.is_empty() && !rest.starts_with('#') {
        let quoted = QUOTES.into_iter().find_map(|mark| rest.strip_prefix(mark)?.split_once(mark));
        let (name, after) = match quoted {
            Some((name, after)) => (name.trim(), after),
            None => rest.split_once(char::is_whitespace).unwrap_or((rest, "")),
        };
        if !name.is_empty() {
            found.push(name);
        }
        rest = after.trim_start();
    }
    found
}

/// A name as it is compared where its exact form is not found: in lower case, without blanks, underscores and hyphens,
/// accents written in one way.
pub(super) fn folded(name: &str) -> String {
    lowered(name).chars().filter(|c| !(c.is_whitespace() || matches!(c, '_' | '-'))).collect()
}

/// A name in lower case, its accents composed with their letters: some systems write them apart.
pub(super) fn lowered(name: &str) -> String {
    name.nfc().collect::<String>().to_lowercase()
}

/// Bytes read between two looks at whether to go on.
const WATCHED_BYTES: usize = 1 << 16;

/// A file in memory that is watched while it is read.
pub(super) struct WatchedBytes<'a, 'w> {
    whole: &'a [u8],
    read: usize,
    watch: Watch<'w>,
}

impl<'a, 'w> WatchedBytes<'a, 'w> {
    pub(super) fn new(whole: &'a [u8], watch: Watch<'w>) -> Self {
        Self { whole, read: 0, watch }
    }
}

impl BufRead for WatchedBytes<'_, '_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        let left = &self.whole[self.read..];
        let share = self.read as f64 / self.whole.len().max(1) as f64;
        self.watch.done(share).map_err(|_| io::Error::other("cancelled"))?;
        Ok(&left[..left.len().min(WATCHED_BYTES)])
    }

    fn consume(&mut self, amount: usize) {
        self.read = (self.read + amount).min(self.whole.len());
    }
}

impl Read for WatchedBytes<'_, '_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_alike_whatever_their_accents_blanks_and_capitals() {
        assert_eq!(folded("Stehlampe_Büro"), folded("stehlampe bu\u{308}ro"));
        assert_eq!(folded("LAMP-STUDY"), folded("Lamp study"));
        assert_eq!(folded("LAMPSTUDY"), folded("Lamp study"));
        assert_ne!(folded("büro"), folded("buro"));
    }

    #[test]
    fn lines_are_continued_and_comments_are_not() {
        let text = "v 1 \\\n 2 \\\r\n 3\n# C:\\rooms\\\nv 4 # D:\\\nf 1\\";
        let lines: Vec<(usize, String)> =
            logical_lines(text).map(|(n, line)| (n, words(&line).collect::<Vec<_>>().join(" "))).collect();
        let expected = [(1, "v 1 2 3"), (4, ""), (5, "v 4"), (6, "f 1")];
        assert_eq!(lines, expected.map(|(n, line)| (n, line.to_owned())));
    }

    #[test]
    fn names_lose_quotes_and_comments_and_numbers_tell_of_commas() {
        assert_eq!(keyword("Map_KD  a B"), ("map_kd".into(), "a B"));
        assert_eq!(unquoted("\"my room.mtl\""), "my room.mtl");
        assert_eq!(unquoted("'my room.mtl'"), "my room.mtl");
        assert_eq!(unquoted("Peter's"), "Peter's");
        assert_eq!(unquoted("\""), "\"");
        assert_eq!(listed("'my room.mtl' b.mtl \"c d.mtl\" # e"), ["my room.mtl", "b.mtl", "c d.mtl"]);
        assert_eq!(uncommented("wall   # plaster"), "wall");
        assert_eq!(uncommented("Material#25"), "Material#25");
        assert_eq!(listed("a.mtl \"b c.mtl\" \"\" d # e"), ["a.mtl", "b c.mtl", "d"]);
        assert_eq!(listed("\"open"), ["\"open"]);
        assert_eq!(folded(" Lamp_study  Ü"), "lampstudyü");
        assert!(number("0,5").unwrap_err().contains("decimal comma"));
        assert!(!number("a,b").unwrap_err().contains("decimal comma"));
        assert_eq!(number("1e3"), Ok(1000.0));
    }
}
