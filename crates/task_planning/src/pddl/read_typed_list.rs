//! `a b - t c`: names with their types.

use super::error::PddlError;
use super::s_expression::Items;
use crate::operator::{OBJECT, TypedName};

/// Reads the rest of the list as plain names with types; names without a type are objects.
pub(super) fn read_names(items: Items<'_>, what: &str) -> Result<Vec<TypedName>, PddlError> {
    read(items, what, |word| Some(word))
}

/// Reads the rest of the list as variables with types; the `?` is dropped.
pub(super) fn read_variables(items: Items<'_>) -> Result<Vec<TypedName>, PddlError> {
    read(items, "a variable such as `?x`", |word| {
        word.strip_prefix('?')
    })
}

fn read(
    mut items: Items<'_>,
    what: &str,
    name_of: impl Fn(&str) -> Option<&str>,
) -> Result<Vec<TypedName>, PddlError> {
    let mut names: Vec<TypedName> = Vec::new();
    let mut n_typed = 0;
    while let Some(node) = items.next() {
        let word = node.word(what)?;
        if word == "-" {
            if n_typed == names.len() {
                return Err(PddlError::syntax(node.at, what, "`-`"));
            }
            let type_node = items.expect("a type name")?;
            if type_node.head().as_deref() == Some("either") {
                let hint = "declare a common parent type";
                return Err(PddlError::unsupported(
                    type_node.at,
                    "an `either` type",
                    hint,
                ));
            }
            let type_name = type_node.word("a type name")?;
            for name in &mut names[n_typed..] {
                type_name.clone_into(&mut name.type_name);
            }
            n_typed = names.len();
            continue;
        }
        let name = name_of(word).ok_or_else(|| PddlError::syntax(node.at, what, node.shown()))?;
        names.push(TypedName::new(name, OBJECT));
    }
    Ok(names)
}
