//! Texts of files in whatever encoding they were written.

use encoding_rs::{Encoding, WINDOWS_1252};
use std::borrow::Cow;

/// The text of a file: in UTF-8, in UTF-16 with a byte order mark, or else in Windows-1252, in which any
/// bytes are a text and different bytes are different characters.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    if let Some((encoding, _)) = Encoding::for_bom(bytes) {
        return encoding.decode_with_bom_removal(bytes).0;
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => WINDOWS_1252.decode_without_bom_handling(bytes).0,
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
        assert_eq!(decode(b"\xef\xbb\xbfv 1"), "v 1");
        // Half a character at the end is no reason to refuse.
        assert!(decode(&utf16(true)[..5]).starts_with('v'));
    }
}
