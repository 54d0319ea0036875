//! URIs of buffers and images: data in the JSON itself, or names of files.

use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

/// A URI without its scheme.
pub(super) enum Uri<'a> {
    /// Media type, comma and data of a `data:` URI (RFC 2397).
    Data(&'a str),
    /// An address with a scheme.
    Address,
    /// A file's name.
    Name,
}

/// What kind of URI `uri` is.
pub(super) fn kind(uri: &str) -> Uri<'_> {
    match uri.get(..5) {
        Some(scheme) if scheme.eq_ignore_ascii_case("data:") => Uri::Data(&uri[5..]),
        _ if uri.contains("://") => Uri::Address,
        _ => Uri::Name,
    }
}

/// The bytes of a `data:` URI, or what is wrong with it.
pub(super) fn data(text: &str) -> Result<Vec<u8>, String> {
    let (media_type, data) = text
        .split_once(',')
        .ok_or("is a data URI without a comma before its data")?;
    let last = media_type.rsplit(';').next().unwrap_or_default();
    if last.trim().eq_ignore_ascii_case("base64") {
        from_base64(data)
    } else {
        Ok(percent_decoded(data))
    }
}

/// base64 as files have it: in either alphabet (RFC 4648, sections 4 and 5), with or without
/// padding, broken into lines, or percent-encoded.
fn from_base64(text: &str) -> Result<Vec<u8>, String> {
    let config = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::RequireNone)
        .with_decode_allow_trailing_bits(true);
    let mut plain = percent_decoded(text);
    plain.retain(|byte| !byte.is_ascii_whitespace());
    for byte in &mut plain {
        match byte {
            b'-' => *byte = b'+',
            b'_' => *byte = b'/',
            _ => {}
        }
    }
    while plain.pop_if(|byte| *byte == b'=').is_some() {}
    GeneralPurpose::new(&alphabet::STANDARD, config)
        .decode(plain)
        .map_err(|e| format!("is not valid base64: {e}"))
}

/// The names that a file may have which a URI stands for, likeliest first: decoded; as it is
/// written, by exporters that encode nothing; with a path of another system; without a query or a
/// fragment.
pub(super) fn file_names(uri: &str) -> Vec<String> {
    let decoded = decoded_name(uri);
    let bare = &uri[..uri.find(['?', '#']).unwrap_or(uri.len())];
    let mut names = vec![
        decoded.clone(),
        uri.to_owned(),
        decoded.replace('\\', "/"),
        decoded_name(bare),
    ];
    let mut seen = std::collections::HashSet::new();
    names.retain(|name| !name.is_empty() && seen.insert(name.clone()));
    if names.is_empty() {
        names.push(decoded);
    }
    names
}

/// `uri` with `%20` and its like decoded.
pub(super) fn decoded_name(uri: &str) -> String {
    String::from_utf8_lossy(&percent_decoded(uri)).into_owned()
}

/// The bytes of `text`, `%20` and its like decoded; a `%` that starts no such code stays.
fn percent_decoded(text: &str) -> Vec<u8> {
    let mut out = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let code = (first == b'%')
            .then(|| tail.get(..2))
            .flatten()
            .filter(|hex| hex.iter().all(u8::is_ascii_hexdigit))
            .and_then(|hex| std::str::from_utf8(hex).ok())
            .and_then(|hex| u8::from_str_radix(hex, 16).ok());
        out.push(code.unwrap_or(first));
        rest = if code.is_some() { &tail[2..] } else { tail };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_decoded() {
        assert_eq!(decoded_name("a%20b.bin"), "a b.bin");
        assert_eq!(decoded_name("100%.bin"), "100%.bin");
        assert_eq!(decoded_name("%2"), "%2");
        assert_eq!(decoded_name("%+1"), "%+1");
        assert_eq!(decoded_name("%c3%a4"), "ä");
        let names = file_names("folder\\a%20b.bin?v=2");
        assert_eq!(names[0], "folder\\a b.bin?v=2");
        assert!(names.contains(&"folder/a b.bin?v=2".to_owned()));
        assert!(names.contains(&"folder\\a b.bin".to_owned()));
        assert_eq!(file_names("a.bin"), ["a.bin"]);
        assert_eq!(file_names(""), [""]);
    }

    /// 0xfb 0xff 0xfe is `+//+` in base64, `-__-` in the alphabet for URLs.
    #[test]
    fn base64_is_read_however_it_is_spelt() {
        let three = [0xfb, 0xff, 0xfe];
        for uri in [
            "application/octet-stream;base64,+//+",
            "application/gltf-buffer;base64,-__-",
            ";base64,%2B%2f/%2B",
            "image/png;charset=utf-8;BASE64,+/\n\t /+",
            "model/x;name=a.bin; Base64,+//+",
        ] {
            assert_eq!(data(uri).as_deref(), Ok(&three[..]), "{uri}");
        }
        for two in [
            ";base64,+/8=",
            ";base64,+/8",
            ";base64,-_8",
            ";base64,-_8%3D",
            ";base64,+/9",
        ] {
            assert_eq!(data(two).as_deref(), Ok(&three[..2]), "{two}");
        }
        assert_eq!(data(",%00%ffa").as_deref(), Ok(&[0, 255, b'a'][..]));
        assert!(data(";base64,+/?8").is_err_and(|e| e.contains("base64")));
        assert!(data(";base64,A").is_err());
        assert!(data("base64").is_err_and(|e| e.contains("comma")));
    }

    #[test]
    fn schemes_are_told_apart() {
        assert!(matches!(kind("DATA:,x"), Uri::Data(",x")));
        assert!(matches!(kind("https://example.org/a"), Uri::Address));
        assert!(matches!(kind("däta.bin"), Uri::Name));
    }
}
