//! Hexadecimal text, in the strict form the protocols of the gateways use: digits only.

use std::fmt::Write as _;

/// The value of `text`, which is 1 to 8 hexadecimal digits of either case.
#[must_use]
pub(crate) fn number(text: &[u8]) -> Option<u32> {
    const DIGITS_MAX: usize = 8;
    if text.is_empty() || text.len() > DIGITS_MAX {
        return None;
    }
    text.iter().try_fold(0, |value, &byte| Some((value << 4) | u32::from(digit(byte)?)))
}

/// The bytes written in `text` as pairs of hexadecimal digits of either case.
#[must_use]
pub(crate) fn bytes(text: &[u8]) -> Option<Vec<u8>> {
    let (pairs, rest) = text.as_chunks::<2>();
    if !rest.is_empty() {
        return None;
    }
    pairs.iter().map(|&[high, low]| Some((digit(high)? << 4) | digit(low)?)).collect()
}

/// `bytes` as lower-case digits.
#[must_use]
pub(crate) fn lower(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// `bytes` as upper-case digits.
#[must_use]
pub(crate) fn upper(bytes: &[u8]) -> String {
    lower(bytes).to_ascii_uppercase()
}

const fn digit(byte: u8) -> Option<u8> {
    match byte {
        b'0'..=b'9' => Some(byte - b'0'),
        b'a'..=b'f' => Some(byte - b'a' + 10),
        b'A'..=b'F' => Some(byte - b'A' + 10),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_one_to_eight_digits() {
        for (text, expected) in [
            ("0", Some(0)),
            ("7fF", Some(0x7FF)),
            ("1FFFFFFF", Some(0x1FFF_FFFF)),
            ("", None),
            ("+7", None),
            ("0x7", None),
            ("123456789", None),
        ] {
            assert_eq!(number(text.as_bytes()), expected, "{text:?}");
        }
    }

    #[test]
    fn bytes_are_pairs_of_digits() {
        assert_eq!(bytes(b""), Some(vec![]));
        assert_eq!(bytes(b"00fFa5"), Some(vec![0x00, 0xFF, 0xA5]));
        assert_eq!(bytes(b"0"), None);
        assert_eq!(bytes(b"0 1 "), None);
        assert_eq!(lower(&[0x00, 0xFF, 0xA5]), "00ffa5");
        assert_eq!(upper(&[0x00, 0xFF, 0xA5]), "00FFA5");
    }
}
