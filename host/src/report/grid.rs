//! A table of short texts, and its three looks: for a terminal, as Markdown, as HTML.

use comfy_table::{ContentArrangement, Table, presets};
use maud::{Markup, html};

/// A cell.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) text: String,
    /// The one to look at: `*` in a terminal, bold elsewhere.
    pub(super) strong: bool,
}

impl From<String> for Field {
    fn from(text: String) -> Self {
        Self { text, strong: false }
    }
}

/// A head and rows of as many cells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Grid {
    pub(super) head: Vec<String>,
    pub(super) rows: Vec<Vec<Field>>,
}

/// Width where there is no terminal: that of a page.
const PAGE: u16 = 110;

impl Grid {
    /// For a terminal; readable without colour.
    pub(super) fn text(&self) -> String {
        let mut table = Table::new();
        table
            .load_style(presets::UTF8_FULL_CONDENSED)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_header(&self.head);
        if table.width().is_none() {
            table.set_width(PAGE);
        }
        for row in &self.rows {
            table.add_row(row.iter().map(|cell| {
                if cell.strong { format!("{} *", cell.text) } else { cell.text.clone() }
            }));
        }
        table.to_string() + "\n"
    }

    /// As a table of Markdown.
    pub(super) fn markdown(&self) -> String {
        let line = |cells: &mut dyn Iterator<Item = String>| {
            let cells: Vec<String> = cells.map(|c| c.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let mut text = line(&mut self.head.iter().cloned());
        text += &line(&mut self.head.iter().map(|_| "---".to_owned()));
        for row in &self.rows {
            text += &line(&mut row.iter().map(|cell| {
                if cell.strong { format!("**{}**", cell.text) } else { cell.text.clone() }
            }));
        }
        text
    }

    /// As a table of HTML that scrolls in a box of its own; the first column names the rows.
    pub(super) fn html(&self, caption: &str) -> Markup {
        html! {
            div.table tabindex="0" role="region" aria-label=(caption) {
                table {
                    caption { (caption) }
                    thead { tr { @for name in &self.head { th scope="col" { (name) } } } }
                    tbody { @for row in &self.rows {
                        tr.best[row.iter().any(|cell| cell.strong)] {
                            @for (k, cell) in row.iter().enumerate() {
                                @if k == 0 { th scope="row" { (text(cell)) } }
                                @else { td { (text(cell)) } }
                            }
                        }
                    } }
                }
            }
        }
    }
}

fn text(cell: &Field) -> Markup {
    html! { @if cell.strong { b { (cell.text) } } @else { (cell.text) } }
}

#[cfg(test)]
mod tests {
    use super::{Field, Grid};

    #[test]
    fn the_three_looks_hold_the_same() {
        let best = Field { text: "0.26 %".into(), strong: true };
        let grid = Grid {
            head: vec!["sample".into(), "ggx".into()],
            rows: vec![vec!["a | <b>".to_owned().into(), best]],
        };
        assert_eq!(
            grid.markdown(),
            "| sample | ggx |\n| --- | --- |\n| a \\| <b> | **0.26 %** |\n"
        );
        let html = grid.html("caption").into_string();
        assert!(
            html.contains("<th scope=\"row\">a | &lt;b&gt;</th><td><b>0.26 %</b></td>"),
            "{html}"
        );
        let text = grid.text();
        assert!(text.contains("sample") && text.contains("0.26 % *"), "{text}");
    }
}
