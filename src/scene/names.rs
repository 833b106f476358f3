//! Names and numbers in messages: lists that stay short, the nearest names to one that is not there, and
//! thousands set apart.

use std::collections::HashSet;

/// `'a', 'b' and 3 more`: at most four names, each once, in the order given.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut seen = HashSet::new();
    let distinct = names.into_iter().filter(|name| seen.insert(*name));
    joined(&distinct.map(|name| format!("'{}'", short(name))).collect::<Vec<_>>())
}

/// `a, b and 3 more`: at most four things, as they are.
pub(super) fn joined(things: &[String]) -> String {
    const SHOWN: usize = 4;
    // "and 1 more" would take as much room as the name itself.
    let shown = if things.len() == SHOWN + 1 { SHOWN + 1 } else { SHOWN.min(things.len()) };
    match &things[..shown] {
        [] => "none".to_owned(),
        shown if shown.len() < things.len() => {
            format!("{} and {} more", shown.join(", "), things.len() - shown.len())
        }
        [one] => one.clone(),
        [others @ .., last] => format!("{} and {last}", others.join(", ")),
    }
}

/// A whole number with commas between thousands: `20,312`.
pub(crate) fn grouped(value: i64) -> String {
    let digits = value.unsigned_abs().to_string();
    let mut text = String::new();
    if value < 0 {
        text.push('-');
    }
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A word of a file made fit for a message: at most 40 characters, none of them control characters.
pub(super) fn short(word: &str) -> String {
    const LONGEST: usize = 40;
    let mut text: String = word.chars().filter(|c| !c.is_control()).take(LONGEST).collect();
    if word.chars().nth(LONGEST).is_some() {
        text.push('…');
    }
    text
}

/// The (at most three) names nearest to `wanted` by edit distance, ignoring case.
pub fn nearest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = wanted.to_lowercase();
    let mut ranked: Vec<(usize, &str)> = names
        .into_iter()
        .map(|name| {
            let lower = name.to_lowercase();
            // A part of a name counts as near, however long the rest is.
            let part = !wanted.is_empty() && (lower.contains(&wanted) || wanted.contains(&lower));
            (if part { 1 } else { distance(&wanted, &lower) }, name)
        })
        .collect();
    ranked.sort();
    ranked.dedup();
    ranked.into_iter().take(3).map(|(_, name)| name).collect()
}

/// Levenshtein 1966, on the first 64 characters.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().take(64).collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// What a person reads instead of an identifier: underscores become spaces, the first letter large.
pub(super) fn pretty(identifier: &str) -> String {
    let spaced = identifier.replace(['_', '/'], " ");
    let text = spaced.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => "Lamp".to_owned(),
    }
}

/// `name`, or `name 2`, `name 3`... where it is taken already; records what it returns.
pub(super) fn unique(name: &str, taken: &mut HashSet<String>) -> String {
    let mut candidate = name.to_owned();
    let mut number = 2;
    while !taken.insert(candidate.clone()) {
        candidate = format!("{name} {number}");
        number += 1;
    }
    candidate
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_stay_short_and_name_each_once() {
        assert_eq!(list(["a", "b", "a"]), "'a' and 'b'");
        assert_eq!(list(["a", "b", "c", "d", "e", "f", "g"]), "'a', 'b', 'c', 'd' and 3 more");
        assert_eq!(list(["a", "b", "c", "d", "e"]), "'a', 'b', 'c', 'd' and 'e'");
        assert_eq!(list([]), "none");
    }

    #[test]
    fn the_nearest_name_comes_first() {
        let names = ["Kitchen pendant", "Desk lamp", "Hall"];
        assert_eq!(nearest("kichen pendnat", names)[0], "Kitchen pendant");
        assert_eq!(nearest("desk", names)[0], "Desk lamp");
        assert_eq!(distance("kitten", "sitting"), 3);
    }

    #[test]
    fn identifiers_become_readable_and_unique() {
        assert_eq!(pretty("kitchen_pendant"), "Kitchen pendant");
        let mut taken = HashSet::new();
        let names: Vec<String> = (0..3).map(|_| unique("Lamp", &mut taken)).collect();
        assert_eq!(names, ["Lamp", "Lamp 2", "Lamp 3"]);
    }
}
