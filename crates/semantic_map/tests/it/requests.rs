//! Requests that may come again, kept with the entries that they made.

use factotum_semantic_map::{By, Edit, Home, Request};

use crate::home::{move_bottle, new_home};

/// Asked by a request that may come again.
fn by<'a>(id: &'a str, content: &'a [u8]) -> By<'a> {
    By {
        author: "ada",
        request: Some(Request {
            id,
            content,
            answer: "bottle_1",
        }),
    }
}

#[test]
fn a_request_is_remembered_with_its_entry_across_processes() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    let entry = home.edit(&move_bottle(7.0), by("a", b"to 7"), 1.0).unwrap();
    // What was refused, or changed nothing, made no entry.
    let missing = Edit::RemoveObject {
        name: "unicorn_1".to_owned(),
    };
    home.edit(&missing, by("b", b"gone"), 2.0).unwrap_err();
    home.edit(&move_bottle(7.0), by("c", b"to 7"), 3.0).unwrap();
    home.undo(by("d", b"undo"), 4.0).unwrap();
    home.edit(&move_bottle(8.0), "ben", 5.0).unwrap();
    drop(home);
    let home = Home::open(dir.path(), 6.0).unwrap();
    let remembered = home.remembered("a").unwrap().unwrap();
    assert_eq!(Some(remembered.entry), entry);
    assert_eq!(remembered.answer, "bottle_1");
    assert!(remembered.is_of(b"to 7") && !remembered.is_of(b"to 8"));
    let undone = home.remembered("d").unwrap().unwrap();
    assert_eq!(undone.entry, entry.unwrap() + 1);
    for id in ["b", "c", "e"] {
        assert_eq!(home.remembered(id).unwrap(), None, "{id}");
    }
}

#[test]
fn the_requests_asked_last_are_remembered() {
    let dir = tempfile::tempdir().unwrap();
    let mut home = new_home(dir.path());
    for number in 0..1030_u32 {
        let id = number.to_string();
        let edit = move_bottle(f64::from(number) + 10.0);
        home.edit(&edit, by(&id, b""), 1.0).unwrap();
    }
    let is_remembered = |number: u32| home.remembered(&number.to_string()).unwrap().is_some();
    assert!(!is_remembered(5) && is_remembered(6) && is_remembered(1029));
}
