//! Starting and ending.

use std::net::{SocketAddr, TcpListener};

use factotum_studio::{Studio, StudioConfig, StudioError};

use crate::client::{Page, get, log_in, start};

#[test]
fn only_loopback_is_listened_on() {
    for address in ["0.0.0.0:0", "[::]:0", "192.0.2.1:80"] {
        let config = StudioConfig {
            bind: address.parse().unwrap(),
            ..StudioConfig::default()
        };
        let error = Studio::start(config).unwrap_err();
        assert!(matches!(error, StudioError::NotLoopback { .. }));
        assert!(
            error.to_string().contains("expected 127.0.0.1 or [::1]"),
            "{error}"
        );
    }
}

#[test]
fn a_port_in_use_is_named() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let config = StudioConfig {
        bind: address,
        ..StudioConfig::default()
    };
    let error = Studio::start(config).unwrap_err();
    assert!(matches!(error, StudioError::Bind { .. }));
    let text = error.to_string();
    assert!(
        text.contains(&address.to_string()) && text.contains("another port"),
        "{text}"
    );
}

#[test]
fn a_weak_token_is_refused() {
    let config = StudioConfig {
        token: Some("hunter2".to_owned()),
        ..StudioConfig::default()
    };
    let error = Studio::start(config).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("7 characters, expected at least 22"),
        "{error}"
    );
}

#[tokio::test]
async fn shutting_down_says_goodbye_and_frees_the_port() {
    let studio = start();
    let address = studio.local_address();
    let mut page = Page::open(&studio).await;
    page.next().await;
    let ended = tokio::task::spawn_blocking(move || studio.shutdown());
    assert_eq!(page.close_code().await, Some(1001));
    drop(page);
    ended.await.unwrap();
    assert!(tokio::net::TcpStream::connect(address).await.is_err());
}

#[tokio::test]
async fn dropping_the_handle_ends_the_studio() {
    let studio = start();
    let address: SocketAddr = studio.local_address();
    assert_eq!(get(address, "/api/health", &[]).await.status, 200);
    tokio::task::spawn_blocking(move || drop(studio))
        .await
        .unwrap();
    assert!(tokio::net::TcpStream::connect(address).await.is_err());
}

#[tokio::test]
async fn no_more_pages_than_allowed_are_open() {
    let studio = Studio::start(StudioConfig {
        pages_max: 2,
        ..StudioConfig::default()
    })
    .unwrap();
    let mut first = Page::open(&studio).await;
    let mut second = Page::open(&studio).await;
    first.next().await;
    second.next().await;
    assert_eq!(studio.n_pages(), 2);
    let cookie = log_in(&studio).await;
    let origin = format!("http://{}", studio.local_address());
    let headers = [("cookie", cookie.as_str()), ("origin", origin.as_str())];
    assert_eq!(Page::open_with(&studio, &headers).await.err(), Some(503));
    drop(first);
    let started_at = std::time::Instant::now();
    while Page::open_with(&studio, &headers).await.is_err() {
        assert!(
            started_at.elapsed() < crate::client::PATIENCE,
            "the seat is not free again"
        );
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
}
