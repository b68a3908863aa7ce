//! Finds where comments, brackets, declarations and names begin and end.

use super::problem::Problem;

/// Splits after the first import, directive, declaration or statement.
pub(super) fn split_node(text: &str) -> Result<(&str, &str), Problem> {
    let continues = |after: &str| {
        let after = after.trim_start();
        after.starts_with(';') || split_word(after).0 == "else"
    };
    split_outside(text, |c, after| c == ';' || (c == '}' && !continues(after)))
}

/// Splits after the first parenthesised group.
pub(super) fn split_group(text: &str) -> Result<(&str, &str), Problem> {
    split_outside(text, |c, _| c == ')')
}

/// Splits after the first character outside brackets for which `ends` holds, given the text that
/// follows it.
fn split_outside(text: &str, ends: impl Fn(char, &str) -> bool) -> Result<(&str, &str), Problem> {
    let mut depth = 0_usize;
    for (i, c) in text.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.checked_sub(1).ok_or(Problem::Unbalanced)?,
            _ => {}
        }
        let (before, after) = text.split_at(i + c.len_utf8());
        if depth == 0 && ends(c, after) {
            return Ok((before, after));
        }
    }
    Err(Problem::Unbalanced)
}

pub(super) fn split_word(text: &str) -> (&str, &str) {
    text.split_at(text.find(|c| !is_word(c)).unwrap_or(text.len()))
}

/// The word at the beginning of a text.
pub(super) fn first_word(text: &str) -> &str {
    split_word(text).0
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// Removes comments. Block comments can be nested.
pub(super) fn without_comments(text: &str) -> Result<String, Problem> {
    let (mut code, mut rest, mut depth) = (String::new(), text, 0);
    while let Some(c) = rest.chars().next() {
        let length = match rest.as_bytes() {
            [b'/', b'/', ..] if depth == 0 => rest.find('\n').unwrap_or(rest.len()),
            [b'/', b'*', ..] => {
                depth += 1;
                2
            }
            [b'*', b'/', ..] if depth > 0 => {
                depth -= 1;
                code.push(' ');
                2
            }
            _ => {
                code.extend((depth == 0).then_some(c));
                c.len_utf8()
            }
        };
        rest = &rest[length..];
    }
    if depth == 0 { Ok(code) } else { Err(Problem::Unbalanced) }
}

/// The name before the first of `(`, `:`, `=`, `{` and `;`, after all attributes.
pub(super) fn declared_name(declaration: &str) -> &str {
    let mut rest = declaration;
    while let Some(attribute) = rest.strip_prefix('@') {
        let arguments = attribute.trim_start_matches(is_word).trim_start();
        let is_call = arguments.starts_with('(');
        let after = is_call.then(|| split_group(arguments).ok()).flatten();
        rest = after.map_or(arguments, |(_, after)| after).trim_start();
    }
    let head = rest.split(['(', ':', '=', '{', ';']).next().unwrap_or_default();
    head.trim_end().rsplit(|c| !is_word(c)).next().unwrap_or_default()
}
