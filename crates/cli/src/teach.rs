//! The desk at which a home is edited: applies the pages' edits to the home folder, one journaled transaction each, and
//! tells what has become of the home.
//!
//! Edits are applied in the order in which they come. One that names the revision of the class or object on which it was
//! made is refused if that has been changed since; one that names none is applied to whatever there is. A request that
//! was accepted and comes again under the same id is not applied again, whatever happened to this process meanwhile: the
//! journal keeps the id in the transaction of the edit.

mod from_wire;
mod to_wire;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use factotum_descriptions::ObjectClass;
use factotum_protocol::{self as wire, EditOutcome};
use factotum_semantic_map::{Aosm, By, Edit, Home, MapError, Remembered, Request, Thing};

use crate::belief::BeliefScene;
use crate::class_look::parts_of;
use crate::{assets, home};

/// Author, in the journal, of what is done on the page.
const AUTHOR: &str = "page";
/// Entries of the journal that the page shows.
const HISTORY_SHOWN: usize = 30;

/// A home and what is needed to edit it.
#[derive(Debug)]
pub(crate) struct Desk {
    kept: Kept,
    /// Folders of the classes that can be taken into the home, by name.
    catalogue: BTreeMap<String, PathBuf>,
    /// Descriptions of these.
    described: Vec<wire::CatalogueClass>,
    /// What the classes look like, with the revision that was looked at.
    looks: BTreeMap<String, (Option<i64>, Vec<wire::ClassPart>)>,
    aperture_max_m: f64,
}

/// A home that may be edited, or only be looked at.
#[derive(Debug)]
enum Kept {
    Open(Box<Home>),
    Closed {
        name: String,
        aosm: Box<Aosm>,
        why: String,
    },
}

impl Desk {
    /// Opens a home to be edited for a robot whose gripper opens so far. A home that another process is at work on, or
    /// whose journal cannot be written, can still be looked at.
    pub(crate) fn open(dir: &Path, aperture_max_m: f64, when_secs: f64) -> anyhow::Result<Self> {
        let kept = match Home::open(dir, when_secs) {
            Ok(home) => Kept::Open(Box::new(home)),
            Err(error) => {
                let (name, aosm) = home::read(dir)?;
                Kept::Closed {
                    name,
                    aosm: Box::new(aosm),
                    why: error.to_string(),
                }
            }
        };
        let catalogue: BTreeMap<String, PathBuf> = assets::object_classes()?.into_iter().collect();
        let described = catalogue.iter().filter_map(|(name, folder)| {
            let class = ObjectClass::load(folder).ok()?;
            Some(wire::CatalogueClass {
                name: name.clone(),
                description: class.description,
            })
        });
        let described = described.collect();
        Ok(Self {
            kept,
            catalogue,
            described,
            looks: BTreeMap::new(),
            aperture_max_m,
        })
    }

    /// Name of the home.
    pub(crate) fn name(&self) -> &str {
        match &self.kept {
            Kept::Open(home) => home.name(),
            Kept::Closed { name, .. } => name,
        }
    }

    /// The home as it is now.
    pub(crate) fn aosm(&self) -> &Aosm {
        match &self.kept {
            Kept::Open(home) => home.aosm(),
            Kept::Closed { aosm, .. } => aosm,
        }
    }

    /// Why no edits are taken, if none are.
    pub(crate) fn closed(&self) -> Option<&str> {
        match &self.kept {
            Kept::Open(_) => None,
            Kept::Closed { why, .. } => Some(why),
        }
    }

    /// The objects, to be drawn.
    pub(crate) fn belief(&mut self) -> BeliefScene {
        self.look_at_classes();
        let parts = self.looks.iter();
        BeliefScene::of_parts(parts.map(|(name, (_, parts))| (name.clone(), parts.clone())))
    }

    /// Applies what a page asks for, and answers what has become of it. A request that was accepted before gets the same
    /// answer; one that was refused is looked at again.
    pub(crate) fn answer(&mut self, request: &wire::EditRequest, when_secs: f64) -> EditOutcome {
        match self.apply(request, when_secs) {
            Ok((entry, what)) => EditOutcome::Accepted {
                entry: entry.and_then(|entry| u32::try_from(entry).ok()),
                what,
            },
            Err(reason) => EditOutcome::Refused { reason },
        }
    }

    /// The entry of the journal, if anything has changed, and what was made or changed.
    fn apply(
        &mut self,
        request: &wire::EditRequest,
        when_secs: f64,
    ) -> Result<(Option<i64>, String), String> {
        let home = match &mut self.kept {
            Kept::Open(home) => home,
            Kept::Closed { why, .. } => return Err(why.clone()),
        };
        let in_words = |error: MapError| error.to_string();
        let content = serde_json::to_vec(request).map_err(|error| error.to_string())?;
        if let Some(before) = home.remembered(&request.id).map_err(in_words)? {
            return answer_again(before, &request.id, &content);
        }
        let by = |answer| By {
            author: AUTHOR,
            request: Some(Request {
                id: &request.id,
                content: &content,
                answer,
            }),
        };
        if matches!(request.edit, wire::Edit::Undo | wire::Edit::Redo) {
            let [undo, redo] = home.undo_redo().map_err(in_words)?;
            let is_undo = request.edit == wire::Edit::Undo;
            let (what, word) = if is_undo {
                (undo, "undo")
            } else {
                (redo, "do again")
            };
            let what = what.ok_or_else(|| format!("there is nothing to {word}"))?;
            let done = if is_undo {
                home.undo(by(&what), when_secs)
            } else {
                home.redo(by(&what), when_secs)
            };
            let done = done.map_err(in_words)?;
            return Ok((home.last_entry().ok(), done.unwrap_or(what)));
        }
        let edit = from_wire::edit_of(&request.edit, home.aosm(), &self.catalogue)?;
        let what = match (&edit, edit.thing()) {
            (Edit::Rename { to, .. }, _) => to.clone(),
            (_, Some(Thing::Class(name) | Thing::Object(name))) => name,
            (_, None) => edit.summary(),
        };
        let made = match request.base {
            Some(base) => home.edit_on(i64::from(base), &edit, by(&what), when_secs),
            None => home.edit(&edit, by(&what), when_secs),
        };
        Ok((made.map_err(in_words)?, what))
    }

    /// The home as it can be taught.
    pub(crate) fn teaching(&mut self) -> Result<wire::Teaching, MapError> {
        self.look_at_classes();
        let (mut undo, mut redo, mut history) = (None, None, Vec::new());
        if let Kept::Open(home) = &self.kept {
            [undo, redo] = home.undo_redo()?;
            history = home
                .history(HISTORY_SHOWN)?
                .iter()
                .map(to_wire::entry)
                .collect();
        }
        let aosm = self.aosm();
        let classes = aosm.classes.values().map(|class| {
            let parts = self.looks.get(&class.name);
            let parts = parts.map_or_else(Vec::new, |(_, parts)| parts.clone());
            let thing = Thing::Class(class.name.clone());
            to_wire::class(class, self.revision(&thing), parts)
        });
        let objects = aosm.objects.values().enumerate().map(|(index, object)| {
            let revision = self.revision(&Thing::Object(object.name.clone()));
            let rank = match &self.kept {
                Kept::Open(home) => home.object_rank(&object.name),
                Kept::Closed { .. } => None,
            };
            to_wire::object(object, revision, rank.unwrap_or(index))
        });
        let in_catalogue = self.described.iter();
        let catalogue = in_catalogue.filter(|class| !aosm.classes.contains_key(&class.name));
        Ok(wire::Teaching {
            closed: self.closed().unwrap_or_default().to_owned(),
            classes: classes.collect(),
            objects: objects.collect(),
            catalogue: catalogue.cloned().collect(),
            undo,
            redo,
            history,
            aperture_max_m: self.aperture_max_m,
        })
    }

    fn revision(&self, thing: &Thing) -> Option<i64> {
        match &self.kept {
            Kept::Open(home) => home.revision(thing),
            Kept::Closed { .. } => None,
        }
    }

    /// Samples the models of classes that are new or have changed.
    fn look_at_classes(&mut self) {
        let mut looks = BTreeMap::new();
        for class in self.aosm().classes.values() {
            let revision = self.revision(&Thing::Class(class.name.clone()));
            let look = match self.looks.get(&class.name) {
                Some((at, parts)) if *at == revision => parts.clone(),
                _ => parts_of(class),
            };
            looks.insert(class.name.clone(), (revision, look));
        }
        self.looks = looks;
    }
}

/// The answer to a request that was journaled before.
fn answer_again(
    before: Remembered,
    id: &str,
    content: &[u8],
) -> Result<(Option<i64>, String), String> {
    if before.is_of(content) {
        return Ok((Some(before.entry), before.answer));
    }
    Err(format!(
        "id `{id}` was that of another edit; ask under a new one"
    ))
}

#[cfg(test)]
mod tests;
