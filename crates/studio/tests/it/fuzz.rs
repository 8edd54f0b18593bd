//! Messages that no page sends: malformed, huge, out of order and again, at the decoder and at a live studio.
//!
//! `FACTOTUM_FUZZ_MESSAGES` says how many, in place of some ten thousand.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use factotum_protocol::{ClientMessage, EditOutcome, ServerMessage};
use factotum_studio::{Studio, StudioConfig};
use futures_util::SinkExt as _;
use rand::{Rng as _, RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use tokio::io::AsyncWriteExt as _;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;

use crate::client::{Page, get, log_in};

/// What pages send, one of each kind.
const GOOD: [&str; 9] = [
    r#"{"type":"pause"}"#,
    r#"{"type":"resume"}"#,
    r#"{"type":"stop"}"#,
    r#"{"type":"drive","forward":0.5,"left":-0.25,"turn":0}"#,
    r#"{"type":"drive_done"}"#,
    r#"{"type":"edit","id":"a","base":null,"edit":{"kind":"undo"}}"#,
    r#"{"type":"edit","id":"b","base":7,"edit":{"kind":"move_object","name":"cup_1","pose":{"position":[1,2,0.5],"orientation_xyzw":[0,0,0,1]}}}"#,
    r#"{"type":"edit","id":"c","base":null,"edit":{"kind":"make_class","name":"cup","form":{"kind":"box","size_m":[0.1,0.1,0.2]},"movable":true}}"#,
    r#"{"type":"edit","id":"d","base":4294967295,"edit":{"kind":"put_action","class":"cup","action":{"name":"open","grasp":null,"motion":{"kind":"joint","joint":"lid","initiation":null,"termination":1.5,"contact":"push","effect":"open"},"approach":{"distance_m":[0.8,1.25]},"provenance":"taught"}}}"#,
];

/// What breaks readers of JSON, and of what is in it.
const POISON: [&str; 22] = [
    "null",
    "NaN",
    "-Infinity",
    "1e999",
    "-0",
    "1e-400",
    "18446744073709551616",
    "\"\"",
    "[]",
    "{}",
    "[[[[[[[[",
    "}}",
    "\\u0000",
    "\\ud800",
    "\u{0}",
    "\u{fffd}",
    "../../etc/passwd",
    "'; DROP TABLE entries; --",
    "{\"type\":",
    ",",
    "true",
    "\u{202e}",
];

fn n_messages() -> usize {
    let told = std::env::var("FACTOTUM_FUZZ_MESSAGES").ok();
    told.and_then(|told| told.parse().ok()).unwrap_or(12_000)
}

/// A good message with some damage.
fn damaged(rng: &mut ChaCha8Rng) -> String {
    let mut bytes = GOOD[rng.random_range(0..GOOD.len())].as_bytes().to_vec();
    for _ in 0..rng.random_range(0..4) {
        let at = rng.random_range(0..=bytes.len());
        let to = rng.random_range(at..=bytes.len().min(at + 24));
        match rng.random_range(0..7) {
            0 => drop(bytes.drain(at..to)),
            1 => bytes.truncate(at),
            2 => {
                let again = bytes[at..to].to_vec();
                bytes.splice(at..at, again);
            }
            3 => {
                let poison = POISON[rng.random_range(0..POISON.len())];
                bytes.splice(at..to, poison.bytes());
            }
            4 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..7),
            5 => {
                let other = GOOD[rng.random_range(0..GOOD.len())].as_bytes();
                bytes.splice(at..at, other[..rng.random_range(0..other.len())].to_vec());
            }
            _ => {
                let n = 10_usize.pow(rng.random_range(0..5));
                bytes.splice(
                    at..at,
                    std::iter::repeat_n(b"[{\"9a "[rng.random_range(0..6)], n),
                );
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn the_decoder_takes_what_is_a_message_and_refuses_the_rest() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut n_taken, mut n_refused) = (0, 0);
    for _ in 0..n_messages() {
        let text = damaged(&mut rng);
        match serde_json::from_str::<ClientMessage>(&text) {
            Ok(message) => {
                n_taken += 1;
                if let ClientMessage::Edit(request) = &message {
                    assert!(request.edit.is_finite(), "{text}");
                }
                let again = serde_json::to_string(&message).unwrap();
                let again: ClientMessage = serde_json::from_str(&again).unwrap();
                assert_eq!(again, message, "{text}");
            }
            Err(error) => {
                n_refused += 1;
                assert!(!error.to_string().is_empty());
            }
        }
    }
    // Some damage is none, or another message: both ways are tried.
    assert!(n_taken > n_messages() / 20, "{n_taken} taken");
    assert!(n_refused > n_messages() / 5, "{n_refused} refused");
}

/// Frames that no browser makes, after the handshake: random, not masked, of reserved kinds, and of 2^62 bytes.
fn no_frames(rng: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = vec![0; rng.random_range(1..200)];
    rng.fill_bytes(&mut bytes);
    match rng.random_range(0..4) {
        0 => {}
        1 => bytes.splice(0..0, [0x81, 0x05]).for_each(drop),
        2 => bytes.splice(0..0, [0xf3, 0x85]).for_each(drop),
        _ => bytes
            .splice(0..0, [0x82, 0xff, 0x40, 0, 0, 0, 0, 0, 0, 0])
            .for_each(drop),
    }
    bytes
}

/// Reads until the studio has accepted an edit.
async fn until_answer(page: &mut Page, id: &str) {
    loop {
        if let ServerMessage::EditAnswer(answer) = page.next().await
            && answer.id == id
        {
            assert!(
                matches!(answer.outcome, EditOutcome::Accepted { .. }),
                "{answer:?}"
            );
            return;
        }
    }
}

#[tokio::test]
async fn a_live_studio_loses_no_edit_and_does_not_panic() {
    /// As many as a page may send at once, less the good one before them.
    const N_OF_ONE_PAGE: usize = 38;
    let n_panics = Arc::new(AtomicUsize::new(0));
    let (counted, before) = (Arc::clone(&n_panics), std::panic::take_hook());
    std::panic::set_hook(Box::new(move |info| {
        counted.fetch_add(1, Ordering::SeqCst);
        before(info);
    }));
    let studio = Studio::start(StudioConfig {
        takes_edits: true,
        pages_max: 256,
        ..StudioConfig::default()
    })
    .unwrap();
    // Whoever keeps the home: takes each edit, and notes how often each id came.
    let (edits, commands, is_over) = (
        studio.edits(),
        studio.commands(),
        Arc::new(AtomicBool::new(false)),
    );
    let over = Arc::clone(&is_over);
    let keep = move || {
        let mut came: BTreeMap<String, u32> = BTreeMap::new();
        loop {
            let was_over = over.load(Ordering::SeqCst);
            while commands.try_next().is_some() {}
            match edits.next_within(Duration::from_millis(20)) {
                Some(asked) => {
                    *came.entry(asked.request().id.clone()).or_default() += 1;
                    asked.answer(EditOutcome::Accepted {
                        entry: Some(1),
                        what: String::new(),
                    });
                }
                None if was_over => return came,
                None => {}
            }
        }
    };
    let keeper = std::thread::Builder::new().name("keeper".to_owned());
    let keeper = keeper.spawn(keep).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let cookie = log_in(&studio).await;
    let origin = format!("http://{}", studio.local_address());
    let headers = [("cookie", cookie.as_str()), ("origin", origin.as_str())];
    let n_pages = n_messages().div_ceil(N_OF_ONE_PAGE);
    for number in 0..n_pages {
        let mut page = loop {
            match Page::open_with(&studio, &headers).await {
                Ok(page) => break page,
                // The pages before are still leaving.
                Err(status) => assert_eq!(status, 503),
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        };
        let good = format!(
            r#"{{"type":"edit","id":"good {number}","base":null,"edit":{{"kind":"redo"}}}}"#
        );
        let mut sent = String::new();
        let good_at = rng.random_range(0..N_OF_ONE_PAGE);
        for at in 0..N_OF_ONE_PAGE {
            if at == good_at {
                page.send(&good).await;
                until_answer(&mut page, &format!("good {number}")).await;
            }
            // Now and then the same again.
            if sent.is_empty() || rng.random_range(0..8) > 0 {
                sent = damaged(&mut rng);
            }
            let frame = match rng.random_range(0..12) {
                0 => Message::binary(sent.clone().into_bytes()),
                1 => Message::Pong(sent.bytes().take(100).collect::<Vec<u8>>().into()),
                _ => Message::text(sent.clone()),
            };
            page.socket.send(frame).await.unwrap();
        }
        if rng.random_range(0..3) == 0 {
            let wire = page.socket.get_mut();
            drop(wire.write_all(&no_frames(&mut rng)).await);
        }
        // It leaves with or without a word, its answers unread.
        if rng.random_range(0..2) == 0 {
            drop(page.socket.close(None).await);
        }
    }
    for _ in 0..200 {
        let mut stream = TcpStream::connect(studio.local_address()).await.unwrap();
        let mut bytes = no_frames(&mut rng);
        if rng.random_range(0..2) == 0 {
            bytes
                .splice(0..0, *b"GET /api/socket HTTP/1.1\r\nHost: ")
                .for_each(drop);
        }
        drop(stream.write_all(&bytes).await);
    }
    let health = get(studio.local_address(), "/api/health", &[]).await;
    assert_eq!(health.status, 200);
    is_over.store(true, Ordering::SeqCst);
    let came = tokio::task::spawn_blocking(|| keeper.join().unwrap())
        .await
        .unwrap();
    for number in 0..n_pages {
        let id = format!("good {number}");
        assert_eq!(came.get(&id), Some(&1), "edit `{id}`");
    }
    tokio::task::spawn_blocking(move || studio.shutdown())
        .await
        .unwrap();
    assert_eq!(n_panics.load(Ordering::SeqCst), 0);
}
