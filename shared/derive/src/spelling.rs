//! Attributes with a misspelled name.
//!
//! The compiler refuses such an attribute and suggests the right name. A second error about the same field would
//! not help.

use proc_macro2::TokenTree;
use syn::{Attribute, Meta};

/// Returns whether the attribute is `#[name]` with at most one mistake in the name, and has the form of it: a number
/// first, for an object and a sub-index, or the name alone.
pub fn resembles(attribute: &Attribute, name: &str) -> bool {
    let has_form = match (&attribute.meta, name) {
        (Meta::List(list), "object" | "sub") => {
            matches!(list.tokens.clone().into_iter().next(), Some(TokenTree::Literal(_)))
        }
        (Meta::Path(_), "objects" | "skip") => true,
        _ => false,
    };
    has_form && attribute.path().get_ident().is_some_and(|ident| is_near(&ident.to_string(), name))
}

/// Returns whether at most one letter is missing, too many or wrong, or two letters side by side are swapped.
fn is_near(word: &str, name: &str) -> bool {
    let (word, name): (Vec<char>, Vec<char>) = (word.chars().collect(), name.chars().collect());
    let same = word.iter().zip(&name).take_while(|(one, other)| one == other).count();
    let (word, name) = (&word[same..], &name[same..]);
    match (word, name) {
        ([], []) | ([_], []) | ([], [_]) => true,
        ([_, word @ ..], _) if word == name => true,
        (_, [_, name @ ..]) if word == name => true,
        ([_, word @ ..], [_, name @ ..]) if word == name => true,
        ([one, other, word @ ..], [first, second, name @ ..]) => {
            one == second && other == first && word == name
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::is_near;

    #[test]
    fn one_mistake_is_near_and_two_are_not() {
        for word in ["object", "objct", "oobject", "objekt", "Object", "boject", "objetc", "objec", "objects"]
        {
            assert!(is_near(word, "object"), "{word}");
        }
        for word in ["obct", "obekt", "subject", "doc", "", "tcejbo", "Objekt"] {
            assert!(!is_near(word, "object"), "{word}");
        }
    }
}
