//! Just enough of Rust's lexical structure to look for words in code and not in comments or strings.

/// The code with every comment, string and character literal replaced by a blank; line breaks stay.
pub(super) fn code(source: &str) -> String {
    let bytes = source.as_bytes();
    let mut out = String::with_capacity(source.len());
    let mut at = 0;
    while at < bytes.len() {
        let length = literal_or_comment(&bytes[at..], bytes[..at].last().copied());
        if length == 0 {
            // Multi-byte characters occur in identifiers alone; keep them whole.
            let width = source[at..].chars().next().map_or(1, char::len_utf8);
            out.push_str(&source[at..at + width]);
            at += width;
        } else {
            out.push(' ');
            out.extend(source[at..at + length].chars().filter(|&c| c == '\n'));
            at += length;
        }
    }
    out
}

/// Whether the word stands in the code on its own, not as part of a longer name.
pub(super) fn has_word(code: &str, word: &str) -> bool {
    occurrences(code, word).next().is_some()
}

/// Whether the word stands in the code as a part of a path: before or after `::`, or after `use`.
pub(super) fn has_path_segment(code: &str, word: &str) -> bool {
    occurrences(code, word).any(|at| {
        let (before, after) = (code[..at].trim_end(), code[at + word.len()..].trim_start());
        before.ends_with("::")
            || after.starts_with("::")
            || before.ends_with("use")
            || before.ends_with("extern crate")
    })
}

fn occurrences<'a>(code: &'a str, word: &'a str) -> impl Iterator<Item = usize> + 'a {
    let in_name = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(word)
        .map(|(at, _)| at)
        .filter(move |&at| {
            !code[..at].chars().next_back().is_some_and(in_name)
                && !code[at + word.len()..].chars().next().is_some_and(in_name)
        })
}

/// Length of the comment or literal that begins here, 0 if none does.
fn literal_or_comment(rest: &[u8], before: Option<u8>) -> usize {
    let in_name = before.is_some_and(|b| b.is_ascii_alphanumeric() || b == b'_');
    match rest {
        [b'/', b'/', ..] => rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len()),
        [b'/', b'*', ..] => block_comment(rest),
        [b'"', ..] => quoted(rest),
        [b'r', b'"' | b'#', ..] if !in_name => raw_string(rest),
        [b'b' | b'c', b'r', b'"' | b'#', ..] if !in_name => match raw_string(&rest[1..]) {
            0 => 0,
            length => length + 1,
        },
        [b'\'', ..] => character(rest),
        _ => 0,
    }
}

fn block_comment(rest: &[u8]) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while at < rest.len() {
        match &rest[at..] {
            [b'/', b'*', ..] => (depth, at) = (depth + 1, at + 2),
            [b'*', b'/', ..] => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at
}

fn quoted(rest: &[u8]) -> usize {
    let mut at = 1;
    while at < rest.len() {
        match rest[at] {
            b'\\' => at += 2,
            b'"' => return at + 1,
            _ => at += 1,
        }
    }
    rest.len()
}

/// `r"..."` with any number of hashes; 0 for a raw identifier such as `r#type`.
fn raw_string(rest: &[u8]) -> usize {
    let n_hashes = rest[1..].iter().take_while(|&&b| b == b'#').count();
    if rest.get(1 + n_hashes) != Some(&b'"') {
        return 0;
    }
    let mut end = vec![b'"'];
    end.resize(1 + n_hashes, b'#');
    let body = 2 + n_hashes;
    rest[body..]
        .windows(end.len())
        .position(|window| window == end)
        .map_or(rest.len(), |at| body + at + end.len())
}

/// A character literal; 0 for a lifetime.
fn character(rest: &[u8]) -> usize {
    match rest {
        [_, b'\\', _, tail @ ..] => tail
            .iter()
            .position(|&b| b == b'\'')
            .map_or(rest.len(), |at| 4 + at),
        // One character of one to four bytes, then the closing quote.
        _ => (2..=5)
            .find(|&at| rest.get(at) == Some(&b'\'') && is_one_character(&rest[1..at]))
            .map_or(0, |at| at + 1),
    }
}

fn is_one_character(bytes: &[u8]) -> bool {
    std::str::from_utf8(bytes).is_ok_and(|text| text.chars().count() == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_literals_are_not_code() {
        for source in [
            "// unsafe",
            "/// unsafe",
            "/* unsafe /* unsafe */ unsafe */",
            r#"let a = "unsafe \" unsafe";"#,
            r###"let a = r#"unsafe " unsafe"#;"###,
            r###"let a = br#"unsafe"#;"###,
            "let a = '\"'; // unsafe",
            "let a = '\\''; // unsafe",
            "let a = 'é'; /* unsafe */",
        ] {
            assert!(!has_word(&code(source), "unsafe"), "{source}");
        }
    }

    #[test]
    fn code_is_code() {
        for source in [
            "unsafe { x }",
            "let a = \"text\"; unsafe { a }",
            "fn f<'a>(x: &'a str) -> &'a str { unsafe { x } }",
            "let r#type = 1; unsafe {}",
            "let c = '\\u{1F600}'; unsafe {}",
            "let grösse = 'ß'; unsafe {}",
        ] {
            assert!(has_word(&code(source), "unsafe"), "{source}");
        }
    }

    #[test]
    fn words_are_whole() {
        assert!(!has_word("unsafe_code", "unsafe"));
        assert!(has_word("(unsafe)", "unsafe"));
    }

    #[test]
    fn path_segments_are_told_from_variables() {
        assert!(has_path_segment("use physics;", "physics"));
        assert!(has_path_segment("a::physics::b", "physics"));
        assert!(!has_path_segment("let physics = 1;", "physics"));
    }

    #[test]
    fn lines_keep_their_numbers() {
        assert_eq!(code("a /*\n\n*/ b\n").lines().count(), 3);
    }
}
