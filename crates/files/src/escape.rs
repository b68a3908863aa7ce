//! Text from files, made safe to print.
//!
//! A layer's name can hold anything: escape sequences that a terminal obeys, line breaks that forge
//! a message, and bidirectional controls that reorder the rest of the line.

use std::fmt::Write as _;

/// Replaces control and invisible formatting characters, line breaks included, by escapes such as
/// `\u{1b}`.
#[must_use]
pub fn escaped(text: &str) -> String {
    escape(text, is_unsafe)
}

/// Like [`escaped`], but keeps line breaks: for whole messages.
#[must_use]
pub fn escaped_lines(text: &str) -> String {
    escape(text, |c| c != '\n' && is_unsafe(c))
}

/// Escapes the characters that JSON allows in strings but a terminal should not see. They occur
/// nowhere else in JSON, so the value stays the same.
#[must_use]
pub fn escaped_json(json: &str) -> String {
    let mut escaped = String::with_capacity(json.len());
    for c in json.chars() {
        if c == '\n' || !is_unsafe(c) {
            escaped.push(c);
            continue;
        }
        for unit in c.encode_utf16(&mut [0; 2]) {
            let _ = write!(escaped, "\\u{unit:04x}");
        }
    }
    escaped
}

fn escape(text: &str, must: impl Fn(char) -> bool) -> String {
    text.chars()
        .map(|c| if must(c) { c.escape_default().to_string() } else { c.to_string() })
        .collect()
}

/// Whether a character is a control, a line or paragraph separator, or one of Unicode's category Cf
/// that reorders or hides text.
fn is_unsafe(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e007f}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_obey_is_escaped() {
        assert_eq!(escaped("a\u{1b}[2J\r\u{9b}1m\u{7}"), r"a\u{1b}[2J\r\u{9b}1m\u{7}");
        assert_eq!(escaped("a\nwgdenoise: done"), r"a\nwgdenoise: done");
        assert_eq!(escaped("rxe.\u{202e}gnp\u{2066}\u{200b}"), r"rxe.\u{202e}gnp\u{2066}\u{200b}");
    }

    #[test]
    fn ordinary_text_in_any_script_stays() {
        let text = "naïve `a\\b` \"c\" – 画 שלום e\u{301}";
        assert_eq!(escaped(text), text);
        assert_eq!(escaped_lines("two\nlines\u{202e}"), "two\nlines\\u{202e}");
    }

    #[test]
    fn json_keeps_its_value() {
        assert_eq!(
            escaped_json("{\"a\u{202e}\": \"\u{e0041}\"}"),
            r#"{"a\u202e": "\udb40\udc41"}"#
        );
    }
}
