//! The table of facts, and what is known of each.

use std::collections::HashMap;

use super::formula::{Formula, Known};
use super::{FactId, Instance};

/// A fact as numbers: the predicate's index, then the objects' indices.
pub(super) type Row = Vec<u32>;

/// Every fact that some formula or effect mentions.
#[derive(Debug, Default)]
pub(super) struct Facts {
    rows: Vec<Row>,
    ids: HashMap<Row, FactId>,
    /// Whether the fact holds at first.
    pub(super) initially: Vec<bool>,
    /// Whether the fact was reached with deletes ignored.
    pub(super) reached: Vec<bool>,
}

impl Facts {
    /// The fact's index, given a new one if need be.
    pub(super) fn id(&mut self, row: Row) -> FactId {
        if let Some(id) = self.ids.get(&row) {
            return *id;
        }
        let id = self.rows.len();
        self.rows.push(row.clone());
        self.ids.insert(row, id);
        self.initially.push(false);
        self.reached.push(false);
        id
    }

    pub(super) fn row(&self, id: FactId) -> &Row {
        &self.rows[id]
    }

    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// What is known of each fact, given all actions that could ever run.
    pub(super) fn knowledge(&self, instances: &[Instance]) -> Vec<Known> {
        let mut deleted = vec![false; self.len()];
        for effect in instances.iter().flat_map(|i| &i.effects) {
            deleted[effect.fact] |= !effect.adds && effect.when != Formula::False;
        }
        (0..self.len())
            .map(
                |id| match (self.reached[id], self.initially[id] && !deleted[id]) {
                    (false, _) => Known::Never,
                    (true, true) => Known::Always,
                    (true, false) => Known::Varies,
                },
            )
            .collect()
    }
}
