//! Conditional parts of a module: `@if`, `@elif` and `@else`.

use super::problem::Problem;
use super::syntax::{split_group, split_node, split_word};

/// The features of a kernel.
#[derive(Clone, Copy)]
pub(super) struct Features<'a> {
    /// All features that conditions may name.
    pub(super) known: &'a [&'a str],
    /// The enabled ones.
    pub(super) enabled: &'a [&'a str],
}

/// Resolves the conditions in a text: removes them and everything they exclude.
pub(super) fn select(text: &str, features: Features<'_>) -> Result<String, Problem> {
    let (mut selected, mut rest) = (String::new(), text);
    // `None` outside a chain; inside, whether a branch has been taken.
    let mut chain = None;
    while let Some((before, keyword, after)) = next_condition(rest) {
        selected += before;
        chain = chain.filter(|_| before.trim().is_empty());
        let taken = if keyword == "if" { false } else { chain.ok_or(Problem::NoIf)? };
        let (holds, after) = match keyword {
            "else" => (true, after),
            _ => {
                split_group(after).and_then(|(group, after)| Ok((features.hold(group)?, after)))?
            }
        };
        let (node, after) = split_node(after)?;
        if holds && !taken {
            selected += select(node, features)?.trim_start();
        }
        chain = (keyword != "else").then_some(taken || holds);
        rest = after;
    }
    Ok(selected + rest)
}

/// Splits the text into the part before the next condition, its keyword, and the part after that.
fn next_condition(text: &str) -> Option<(&str, &str, &str)> {
    text.match_indices('@').find_map(|(at, _)| {
        let (keyword, after) = split_word(&text[at + 1..]);
        matches!(keyword, "if" | "elif" | "else").then_some((&text[..at], keyword, after))
    })
}

impl Features<'_> {
    /// Whether a condition holds.
    fn hold(self, condition: &str) -> Result<bool, Problem> {
        let mut rest = condition.trim();
        let holds = self.any(&mut rest).and_then(|holds| match rest {
            "" => Ok(holds),
            _ => Err(Problem::Condition(String::new())),
        });
        holds.map_err(|problem| match problem {
            Problem::Condition(_) => Problem::Condition(condition.into()),
            other => other,
        })
    }

    fn any(self, rest: &mut &str) -> Result<bool, Problem> {
        let mut holds = self.all(rest)?;
        while eat(rest, "||") {
            holds |= self.all(rest)?;
        }
        Ok(holds)
    }

    fn all(self, rest: &mut &str) -> Result<bool, Problem> {
        let mut holds = self.one(rest)?;
        while eat(rest, "&&") {
            holds &= self.one(rest)?;
        }
        Ok(holds)
    }

    fn one(self, rest: &mut &str) -> Result<bool, Problem> {
        if eat(rest, "!") {
            return Ok(!self.one(rest)?);
        }
        if eat(rest, "(") {
            let holds = self.any(rest)?;
            return if eat(rest, ")") { Ok(holds) } else { Err(Problem::Condition(String::new())) };
        }
        let (word, after) = split_word(rest);
        *rest = after.trim_start();
        match word {
            "" => Err(Problem::Condition(String::new())),
            "true" | "false" => Ok(word == "true"),
            _ if self.known.contains(&word) => Ok(self.enabled.contains(&word)),
            _ => Err(Problem::UnknownFeature(word.into())),
        }
    }
}

fn eat(rest: &mut &str, token: &str) -> bool {
    let after = rest.strip_prefix(token);
    *rest = after.map_or(*rest, str::trim_start);
    after.is_some()
}
