//! From the page to the job.

use factotum_protocol::{ClientMessage, EventLevel, ServerMessage};

use futures_util::SinkExt as _;
use tokio_tungstenite::tungstenite::Message;

use crate::client::{PATIENCE, Page, event, start};

/// Waits on another thread, so that the test's own can go on serving the page.
async fn next_command(studio: &factotum_studio::StudioHandle) -> Option<ClientMessage> {
    let commands = studio.commands();
    tokio::task::spawn_blocking(move || commands.next_within(PATIENCE))
        .await
        .unwrap()
}

#[tokio::test]
async fn commands_reach_the_job_in_order() {
    let studio = start();
    let mut page = Page::open(&studio).await;
    for json in [
        r#"{"type":"pause"}"#,
        r#"{"type":"resume"}"#,
        r#"{"type":"pause"}"#,
    ] {
        page.send(json).await;
    }
    for command in [
        ClientMessage::Pause,
        ClientMessage::Resume,
        ClientMessage::Pause,
    ] {
        assert_eq!(next_command(&studio).await, Some(command));
    }
    page.send(r#"{"type":"stop"}"#).await;
    assert_eq!(next_command(&studio).await, Some(ClientMessage::Stop));
    assert_eq!(studio.commands().try_next(), None);
}

#[tokio::test]
async fn a_message_that_is_no_command_is_answered_and_changes_nothing() {
    let studio = start();
    let mut page = Page::open(&studio).await;
    let mut other = Page::open(&studio).await;
    assert!(matches!(page.next().await, ServerMessage::Hello(_)));
    let too_fast = r#"{"type":"drive","forward":2,"left":0,"turn":0}"#;
    let explode = r#"{"type":"explode"}"#;
    for text in ["", "pause", explode, too_fast, "[[[[[[[[", "\u{0}"] {
        page.send(text).await;
        match page.next().await {
            ServerMessage::Event(event) => {
                assert_eq!(event.level, EventLevel::Warning);
                assert!(event.text.contains("is not a command"), "{}", event.text);
            }
            answer => panic!("{text:?} answered by {answer:?}"),
        }
    }
    page.send(r#"{"type":"stop"}"#).await;
    assert_eq!(next_command(&studio).await, Some(ClientMessage::Stop));
    studio.publish(event("last"));
    let seen = other.until_event("last").await;
    assert_eq!(seen.len(), 1, "the others hear nothing of it: {seen:?}");
}

#[tokio::test]
async fn a_page_that_floods_is_closed() {
    let studio = start();
    let mut page = Page::open(&studio).await;
    for _ in 0..60 {
        page.send(r#"{"type":"pause"}"#).await;
    }
    assert_eq!(page.close_code().await, Some(1008));
}

#[tokio::test]
async fn a_message_too_large_closes_the_connection_and_nothing_else() {
    let studio = start();
    let mut page = Page::open(&studio).await;
    let mut other = Page::open(&studio).await;
    let too_large = Message::text("x".repeat(1 << 20));
    // The studio reads no more of it than it takes, so it may have closed before all was sent.
    let _cut_short = page.socket.send(too_large).await.is_err();
    page.close_code().await;
    other.send(r#"{"type":"resume"}"#).await;
    assert_eq!(next_command(&studio).await, Some(ClientMessage::Resume));
}
