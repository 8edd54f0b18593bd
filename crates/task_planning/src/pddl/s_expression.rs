//! Nested lists of words, each with its place in the text: the layer below PDDL's grammar.

use super::error::{PddlError, Position};

/// Nesting beyond which a text is refused, so that hostile input cannot exhaust the stack.
const DEPTH_MAX: usize = 128;

/// A word or a list.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) at: Position,
    pub(super) kind: NodeKind,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum NodeKind {
    Word(String),
    List {
        items: Vec<Node>,
        /// Where the closing parenthesis stands.
        end: Position,
    },
}

impl Node {
    /// How the node reads in an error message.
    pub(super) fn shown(&self) -> String {
        match &self.kind {
            NodeKind::Word(word) => format!("`{word}`"),
            NodeKind::List { items, .. } => match items.first().map(|n| &n.kind) {
                None => "`()`".to_owned(),
                Some(NodeKind::Word(head)) if items.len() == 1 => format!("`({head})`"),
                Some(NodeKind::Word(head)) => format!("`({head} ...)`"),
                Some(NodeKind::List { .. }) => "`((...) ...)`".to_owned(),
            },
        }
    }

    /// The word, if it is one.
    pub(super) fn as_word(&self) -> Option<&str> {
        match &self.kind {
            NodeKind::Word(word) => Some(word),
            NodeKind::List { .. } => None,
        }
    }

    /// The word in lower case.
    pub(super) fn keyword(&self) -> Option<String> {
        self.as_word().map(str::to_ascii_lowercase)
    }

    /// The first word of a list, in lower case.
    pub(super) fn head(&self) -> Option<String> {
        match &self.kind {
            NodeKind::List { items, .. } => items.first().and_then(Self::keyword),
            NodeKind::Word(_) => None,
        }
    }

    /// The word, or an error that says what was expected.
    pub(super) fn word(&self, expected: &str) -> Result<&str, PddlError> {
        self.as_word()
            .ok_or_else(|| PddlError::syntax(self.at, expected, self.shown()))
    }

    /// The list's items in turn, or an error that says what was expected.
    pub(super) fn items(&self, expected: &str) -> Result<Items<'_>, PddlError> {
        match &self.kind {
            NodeKind::List { items, end } => Ok(Items {
                rest: items,
                end: *end,
            }),
            NodeKind::Word(_) => Err(PddlError::syntax(self.at, expected, self.shown())),
        }
    }
}

/// The rest of a list while it is being read.
#[derive(Debug, Clone)]
pub(super) struct Items<'a> {
    rest: &'a [Node],
    end: Position,
}

impl<'a> Items<'a> {
    /// The next item, if any.
    pub(super) fn next(&mut self) -> Option<&'a Node> {
        let (first, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(first)
    }

    /// The next item, or an error at the closing parenthesis.
    pub(super) fn expect(&mut self, expected: &str) -> Result<&'a Node, PddlError> {
        self.next()
            .ok_or_else(|| PddlError::syntax(self.end, expected, "`)`"))
    }

    /// The next item as a word.
    pub(super) fn word(&mut self, expected: &str) -> Result<&'a str, PddlError> {
        self.expect(expected)?.word(expected)
    }

    /// The next item as exactly this word, whatever its case.
    pub(super) fn literal(&mut self, word: &str) -> Result<(), PddlError> {
        let expected = format!("`{word}`");
        let node = self.expect(&expected)?;
        if node.keyword().as_deref() == Some(word) {
            return Ok(());
        }
        Err(PddlError::syntax(node.at, expected, node.shown()))
    }

    /// Fails if anything is left.
    pub(super) fn finish(&self) -> Result<(), PddlError> {
        match self.rest.first() {
            None => Ok(()),
            Some(node) => Err(PddlError::syntax(node.at, "`)`", node.shown())),
        }
    }
}

/// Reads a text that holds exactly one list; comments run from `;` to the end of the line.
pub(super) fn parse(text: &str, expected: &str) -> Result<Node, PddlError> {
    let mut open: Vec<(Position, Vec<Node>)> = Vec::new();
    let mut root: Option<Node> = None;
    let mut scanner = Scanner::new(text);
    while let Some((at, token)) = scanner.next_token() {
        if let Some(root) = &root {
            let hint = format!("end of file (the list opened at {} is complete)", root.at);
            return Err(PddlError::syntax(at, hint, format!("`{token}`")));
        }
        let node = match token {
            "(" => {
                if open.len() == DEPTH_MAX {
                    let expected = format!("at most {DEPTH_MAX} nested lists");
                    return Err(PddlError::syntax(at, expected, "`(`"));
                }
                open.push((at, Vec::new()));
                continue;
            }
            ")" => {
                let Some((start, items)) = open.pop() else {
                    return Err(PddlError::syntax(at, expected, "`)`"));
                };
                Node {
                    at: start,
                    kind: NodeKind::List { items, end: at },
                }
            }
            word => Node {
                at,
                kind: NodeKind::Word(word.to_owned()),
            },
        };
        match open.last_mut() {
            Some((_, items)) => items.push(node),
            None if node.as_word().is_some() => {
                return Err(PddlError::syntax(at, expected, node.shown()));
            }
            None => root = Some(node),
        }
    }
    let at = scanner.position;
    match (open.pop(), root) {
        (Some((start, _)), _) => {
            let wanted = format!("`)` for the list opened at {start}");
            Err(PddlError::syntax(at, wanted, "end of file"))
        }
        (None, Some(root)) => Ok(root),
        (None, None) => Err(PddlError::syntax(at, expected, "end of file")),
    }
}

/// Cuts a text into parentheses and words.
struct Scanner<'a> {
    rest: &'a str,
    position: Position,
}

impl<'a> Scanner<'a> {
    fn new(text: &'a str) -> Self {
        let rest = text.strip_prefix('\u{feff}').unwrap_or(text);
        Self {
            rest,
            position: Position { line: 1, column: 1 },
        }
    }

    fn next_token(&mut self) -> Option<(Position, &'a str)> {
        self.skip_blanks();
        let first = self.rest.chars().next()?;
        let at = self.position;
        let len = match first {
            '(' | ')' => 1,
            _ => self.rest.find(ends_word).unwrap_or(self.rest.len()),
        };
        Some((at, self.take(len)))
    }

    fn skip_blanks(&mut self) {
        loop {
            let blank = self
                .rest
                .find(|c: char| !c.is_whitespace())
                .unwrap_or(self.rest.len());
            self.take(blank);
            if !self.rest.starts_with(';') {
                return;
            }
            self.take(self.rest.find('\n').unwrap_or(self.rest.len()));
        }
    }

    fn take(&mut self, len: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(len);
        for c in taken.chars() {
            if c == '\n' {
                self.position = Position {
                    line: self.position.line + 1,
                    column: 1,
                };
            } else {
                self.position.column += 1;
            }
        }
        self.rest = rest;
        taken
    }
}

fn ends_word(c: char) -> bool {
    c.is_whitespace() || matches!(c, '(' | ')' | ';')
}
