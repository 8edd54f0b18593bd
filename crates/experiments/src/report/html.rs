//! Building HTML as text, with every word from outside escaped.

/// A page under construction.
#[derive(Debug)]
pub(super) struct Markup {
    text: String,
}

impl Markup {
    pub(super) fn new() -> Self {
        Self {
            text: String::new(),
        }
    }

    pub(super) fn into_string(self) -> String {
        self.text
    }

    /// Adds HTML as it is.
    pub(super) fn raw(&mut self, html: &str) {
        self.text.push_str(html);
    }

    /// Adds an element around words.
    pub(super) fn element(&mut self, tag: &str, words: &str) {
        self.raw(&format!("<{tag}>{}</{tag}>\n", escape(words)));
    }

    pub(super) fn section(&mut self, title: &str, fill: impl FnOnce(&mut Self)) {
        self.raw("<section>\n");
        self.element("h2", title);
        fill(self);
        self.raw("</section>\n");
    }

    /// Adds a table that scrolls by itself where the screen is narrow.
    pub(super) fn table(&mut self, heads: &[&str], fill: impl FnOnce(&mut Self)) {
        self.raw("<div class=\"scroll\"><table>\n<thead><tr>");
        for head in heads {
            self.raw(&format!("<th scope=\"col\">{}</th>", escape(head)));
        }
        self.raw("</tr></thead>\n<tbody>\n");
        fill(self);
        self.raw("</tbody>\n</table></div>\n");
    }

    /// Adds a row of cells, each a class and its words.
    pub(super) fn row(&mut self, cells: &[(&str, &str)]) {
        self.raw("<tr>");
        for (class, words) in cells {
            self.raw(&format!("<td class=\"{class}\">{}</td>", escape(words)));
        }
        self.raw("</tr>\n");
    }
}

/// Words as HTML text or a quoted attribute's value.
pub(crate) fn escape(words: &str) -> String {
    let mut html = String::with_capacity(words.len());
    for character in words.chars() {
        match character {
            '&' => html.push_str("&amp;"),
            '<' => html.push_str("&lt;"),
            '>' => html.push_str("&gt;"),
            '"' => html.push_str("&quot;"),
            '\'' => html.push_str("&#39;"),
            other => html.push(other),
        }
    }
    html
}
