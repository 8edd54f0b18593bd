//! Edits: from a page to whoever keeps the home, and the answer back to that page.

use std::time::Duration;

use factotum_protocol::{EditOutcome, EventLevel, ServerMessage};
use factotum_studio::{AskedEdit, Studio, StudioConfig, StudioHandle};

use crate::client::{PATIENCE, Page, event, start};

fn start_taking_edits() -> StudioHandle {
    Studio::start(StudioConfig {
        takes_edits: true,
        ..StudioConfig::default()
    })
    .unwrap()
}

/// Waits on another thread, so that the test's own can go on serving the page.
async fn next_edit(studio: &StudioHandle) -> AskedEdit {
    let edits = studio.edits();
    tokio::task::spawn_blocking(move || edits.next_within(PATIENCE))
        .await
        .unwrap()
        .unwrap()
}

fn remove(id: &str, object: &str) -> String {
    format!(
        r#"{{"type":"edit","id":"{id}","base":7,"edit":{{"kind":"remove_object","name":"{object}"}}}}"#
    )
}

fn accepted(entry: u32) -> EditOutcome {
    EditOutcome::Accepted {
        entry: Some(entry),
        what: "bottle_1".to_owned(),
    }
}

/// The next answer, and what came before it.
async fn until_answer(page: &mut Page) -> (Vec<ServerMessage>, String, EditOutcome) {
    let mut before = Vec::new();
    loop {
        match page.next().await {
            ServerMessage::EditAnswer(answer) => return (before, answer.id, answer.outcome),
            other => before.push(other),
        }
    }
}

#[tokio::test]
async fn edits_of_two_pages_come_in_order_and_each_hears_its_own_answer_after_the_news() {
    let studio = start_taking_edits();
    let mut ana = Page::open(&studio).await;
    let mut ben = Page::open(&studio).await;
    ana.send(&remove("a", "bottle_1")).await;
    let first = next_edit(&studio).await;
    ben.send(&remove("b", "bottle_1")).await;
    let second = next_edit(&studio).await;
    assert_eq!(first.request().id, "a");
    assert_eq!(first.request().base, Some(7));
    assert_eq!(second.request().id, "b");

    studio.publish(event("the bottle is gone"));
    first.answer(accepted(8));
    let refused = EditOutcome::Refused {
        reason: "somebody was faster".to_owned(),
    };
    second.answer(refused.clone());

    for (page, id, outcome) in [(&mut ana, "a", accepted(8)), (&mut ben, "b", refused)] {
        let (before, found, answer) = until_answer(page).await;
        assert_eq!((found.as_str(), answer), (id, outcome));
        assert!(
            before.contains(&event("the bottle is gone")),
            "the news come before the answer: {before:?}"
        );
    }
    studio.publish(event("last"));
    for page in [&mut ana, &mut ben] {
        assert_eq!(
            page.until_event("last").await,
            [],
            "nobody hears another's answer"
        );
    }
}

#[tokio::test]
async fn a_page_that_left_before_its_answer_may_ask_again() {
    let studio = start_taking_edits();
    let mut page = Page::open(&studio).await;
    page.send(&remove("a", "bottle_1")).await;
    let asked = next_edit(&studio).await;
    drop(page);
    asked.answer(accepted(8));
    let mut again = Page::open(&studio).await;
    again.send(&remove("a", "bottle_1")).await;
    let asked = next_edit(&studio).await;
    assert_eq!(asked.request().id, "a");
    asked.answer(accepted(8));
    assert_eq!(until_answer(&mut again).await.1, "a");
}

#[tokio::test]
async fn what_is_no_edit_is_told_to_its_page_and_reaches_nobody() {
    let studio = start_taking_edits();
    let mut page = Page::open(&studio).await;
    assert!(matches!(page.next().await, ServerMessage::Hello(_)));
    let moved = |x: &str, quaternion: &str| {
        format!(
            r#"{{"type":"edit","id":"a","base":null,"edit":{{"kind":"move_object","name":"bottle_1","pose":{{"position":[{x},0,0],"orientation_xyzw":{quaternion}}}}}}}"#
        )
    };
    // What a page sends for a number that is none; the page waits for the answer to its edit.
    for (text, found) in [
        (moved("null", "[0,0,0,1]"), "invalid type: null"),
        (moved("1", "[0,0,1]"), "invalid length 3"),
        (
            remove("a", "bottle_1").replace("remove_object", "explode"),
            "unknown variant `explode`",
        ),
        (
            remove("a", "bottle_1").replace(r#""base":7"#, r#""base":-1"#),
            "`-1`",
        ),
        (
            remove("a", "bottle_1").replace(r#""base":7"#, r#""base":7,"also":1"#),
            "unknown field `also`",
        ),
    ] {
        page.send(&text).await;
        let (_, id, outcome) = until_answer(&mut page).await;
        let EditOutcome::Refused { reason } = outcome else {
            panic!("{text} was taken");
        };
        assert_eq!(id, "a");
        assert!(
            reason.contains("of `bottle_1` cannot be read") && reason.contains(found),
            "{reason}"
        );
    }
    for text in [
        moved("NaN", "[0,0,0,1]"),
        moved("1e999", "[0,0,0,1]"),
        remove("a", &"x".repeat(20_000)),
        "[".repeat(10_000),
    ] {
        page.send(&text).await;
        match page.next().await {
            ServerMessage::Event(event) => assert_eq!(event.level, EventLevel::Warning),
            answer => panic!("{text} answered by {answer:?}"),
        }
    }
    page.send(&remove(&"i".repeat(65), "bottle_1")).await;
    let (_, _, outcome) = until_answer(&mut page).await;
    assert!(
        matches!(outcome, EditOutcome::Refused { .. }),
        "{outcome:?}"
    );
    assert!(studio.edits().next_within(Duration::ZERO).is_none());
    page.send(&remove("b", "bottle_1")).await;
    assert_eq!(
        next_edit(&studio).await.request().id,
        "b",
        "the page goes on"
    );
}

#[tokio::test]
async fn where_a_robot_is_at_work_no_edits_are_taken() {
    let studio = start();
    let mut page = Page::open(&studio).await;
    page.send(&remove("a", "bottle_1")).await;
    let (_, id, outcome) = until_answer(&mut page).await;
    let EditOutcome::Refused { reason } = outcome else {
        panic!("the edit was taken");
    };
    assert_eq!(id, "a");
    assert!(reason.contains("factotum studio"), "{reason}");
    assert!(studio.edits().next_within(Duration::ZERO).is_none());
}
