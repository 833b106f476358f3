//! Texts of files in whatever encoding they were written.

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};
use std::borrow::Cow;

/// The text of a file: in UTF-8, in UTF-16, or else in Windows-1252, in which any
/// bytes are a text and different bytes are different characters.
///
/// Lines that end in a carriage return alone, as on old systems, end in a line feed afterwards.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let text = decoded(bytes);
    if text.contains('\r') && !text.contains('\n') { Cow::Owned(text.replace('\r', "\n")) } else { text }
}

fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    if let Some((encoding, _)) = Encoding::for_bom(bytes) {
        return encoding.decode_with_bom_removal(bytes).0;
    }
    if let Some(encoding) = utf_16(bytes) {
        return encoding.decode_without_bom_handling(bytes).0;
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => WINDOWS_1252.decode_without_bom_handling(bytes).0,
    }
}

/// UTF-16 without a mark is told by its zeros: the numbers and keywords of a model have one in every other byte, and no
/// other encoding has any.
fn utf_16(bytes: &[u8]) -> Option<&'static Encoding> {
    const LOOKED_AT: usize = 4096;
    let start = &bytes[..bytes.len().min(LOOKED_AT)];
    let zeros = |odd: usize| start.iter().skip(odd).step_by(2).filter(|byte| **byte == 0).count();
    let [even, odd] = [zeros(0), zeros(1)];
    let most = 3 * start.len() / 8;
    match (even, odd) {
        (0, odd) if odd > most => Some(UTF_16LE),
        (even, 0) if even > most => Some(UTF_16BE),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_told_apart_and_names_stay_different() {
        assert_eq!(decode("möbel".as_bytes()), "möbel");
        assert_eq!(decode(b"m\xf6bel \x80 \x81"), "möbel € \u{81}");
        assert_ne!(decode(b"wall \xe4"), decode(b"wall \xf6"));
        let utf16 = |big: bool| -> Vec<u8> {
            let units = "\u{feff}v ö 🏠".encode_utf16();
            units.flat_map(|u| if big { u.to_be_bytes() } else { u.to_le_bytes() }).collect()
        };
        assert_eq!(decode(&utf16(true)), "v ö 🏠");
        assert_eq!(decode(&utf16(false)), "v ö 🏠");
        let unmarked = "v 1 0 0\nv ö".encode_utf16();
        assert_eq!(decode(&unmarked.clone().flat_map(u16::to_le_bytes).collect::<Vec<u8>>()), "v 1 0 0\nv ö");
        assert_eq!(decode(&unmarked.flat_map(u16::to_be_bytes).collect::<Vec<u8>>()), "v 1 0 0\nv ö");
        assert_eq!(decode(b"\xef\xbb\xbfv 1"), "v 1");
        assert_eq!(
            (decode(b"v 1\rv 2\r").as_ref(), decode(b"v 1\r\nv 2").as_ref()),
            ("v 1\nv 2\n", "v 1\r\nv 2")
        );
        // Half a character at the end is no reason to refuse.
        assert!(decode(&utf16(true)[..5]).starts_with('v'));
    }
}
