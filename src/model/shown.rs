//! Makes text from a file fit for an error message: short, and free of terminal commands.

/// The most characters shown.
const MOST: usize = 120;

/// The beginning of `text` on one line, with unprintable characters escaped.
pub(super) fn shown(text: &str) -> String {
    // One more than is shown, to detect the cut: the text may be megabytes long.
    let begin: String = text.chars().take(MOST + 1).collect();
    let mut shown: String = begin.chars().map(one).collect();
    if shown.chars().count() > MOST {
        shown = shown.chars().take(MOST).chain(['…']).collect();
    }
    shown
}

/// Whether a character prints as itself and has no other effect.
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
