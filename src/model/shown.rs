//! Text out of a file, made fit for a sentence: short, and nothing that a terminal would obey.

/// Most characters that are shown.
const MOST: usize = 120;

/// The beginning of `text`, on one line, with what cannot be printed escaped.
pub(super) fn shown(text: &str) -> String {
    // No longer than what is cut off below: the text may have megabytes.
    let begin: String = text.chars().take(MOST + 1).collect();
    let mut shown: String = begin.chars().map(one).collect();
    if shown.chars().count() > MOST {
        shown = shown.chars().take(MOST).chain(['…']).collect();
    }
    shown
}

/// Whether a character means no more than what it looks like.
pub(super) fn is_printable(c: char) -> bool {
    matches!(c, '"' | '\'' | '\\') || c.escape_debug().len() == 1
}

fn one(c: char) -> String {
    if is_printable(c) { c.into() } else { c.escape_debug().collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_text_stays_and_the_rest_is_escaped_and_cut() {
        assert_eq!(shown("naïve `a\\b` \"c\" – 画"), "naïve `a\\b` \"c\" – 画");
        assert_eq!(shown("a\u{1b}[2J\n\0\u{202e}"), "a\\u{1b}[2J\\n\\0\\u{202e}");
        assert_eq!(shown(&"x".repeat(MOST)), "x".repeat(MOST));
        assert_eq!(shown(&"\u{7f}".repeat(1 << 20)).chars().count(), MOST + 1);
    }
}
