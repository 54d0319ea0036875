//! Durations as people write them.

/// Seconds of a duration such as `90s`, `1m30s`, `500ms` or `2h`.
pub fn parse_duration(text: &str) -> Result<f64, String> {
    let wrong =
        || format!("`{text}` is no duration; expected such as 30s, 2m or 1m30s, above zero");
    let mut rest = text.trim();
    let mut total = 0.0;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !(c.is_ascii_digit() || c == '.'));
        let (number, tail) = rest.split_at(digits.ok_or_else(wrong)?);
        let units = tail.find(|c: char| !c.is_ascii_alphabetic());
        let (unit, tail) = tail.split_at(units.unwrap_or(tail.len()));
        let factor = match unit {
            "ms" => 1e-3,
            "s" => 1.0,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            _ => return Err(wrong()),
        };
        total += factor * number.parse::<f64>().map_err(|_| wrong())?;
        rest = tail;
    }
    if total > 0.0 && total.is_finite() {
        Ok(total)
    } else {
        Err(wrong())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_parsed() {
        for (text, seconds) in [
            ("30s", 30.0),
            ("2m", 120.0),
            ("1m30s", 90.0),
            ("250ms", 0.25),
        ] {
            let parsed = parse_duration(text).expect("a duration");
            assert!((parsed - seconds).abs() < 1e-12, "{text}");
        }
        for wrong in ["", "30", "s", "0s", "-1s", "1x", "1.2.3s", "infs"] {
            assert!(parse_duration(wrong).is_err(), "{wrong}");
        }
    }
}
