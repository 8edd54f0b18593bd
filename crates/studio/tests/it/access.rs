//! Who gets in, and what a browser may do with what it gets.

use crate::client::{Page, get, log_in, path_with_token, request, start};

#[tokio::test]
async fn the_token_is_exchanged_for_a_cookie_and_leaves_the_address() {
    let studio = start();
    let address = studio.local_address();
    let answer = get(address, &path_with_token(&studio), &[]).await;
    assert_eq!(answer.status, 303);
    assert_eq!(answer.header("location"), Some("/"));
    let cookie = answer.header("set-cookie").unwrap();
    for attribute in ["; HttpOnly", "; SameSite=Strict", "; Path=/"] {
        assert!(cookie.contains(attribute), "{cookie}");
    }
    let token = path_with_token(&studio);
    let token = token.strip_prefix("/?token=").unwrap();
    assert_eq!(token.len(), 32, "128 bits in hexadecimal");
    assert!(
        !cookie.contains(token),
        "the cookie is another secret than the token"
    );

    let cookie = log_in(&studio).await;
    let page = get(address, "/", &[("Cookie", &cookie)]).await;
    assert_eq!(page.status, 200);
    assert!(
        page.header("content-type")
            .unwrap()
            .starts_with("text/html")
    );
    assert!(page.body.contains("Factotum"));
}

#[tokio::test]
async fn without_token_or_cookie_nothing_but_health_is_served() {
    let studio = start();
    let address = studio.local_address();
    let cases = [
        ("/", None),
        ("/index.html", None),
        ("/assets/index.js", None),
        ("/?token=", None),
        ("/?token=00000000000000000000000000000000", None),
        ("/", Some("factotum=1")),
    ];
    for (path, cookie) in cases {
        let headers: Vec<_> = cookie.iter().map(|cookie| ("Cookie", *cookie)).collect();
        let answer = get(address, path, &headers).await;
        assert_eq!(answer.status, 401, "{path}");
        assert!(answer.body.contains("address that Factotum printed"));
        assert_eq!(answer.header("set-cookie"), None);
    }
    let health = get(address, "/api/health", &[]).await;
    assert_eq!(health.status, 200);
    assert_eq!(health.body, r#"{"status":"ok","protocol_version":3}"#);
}

#[tokio::test]
async fn another_host_is_refused_even_with_the_cookie() {
    let studio = start();
    let address = studio.local_address();
    let cookie = log_in(&studio).await;
    let rebound = format!("evil.example:{}", address.port());
    for host in [rebound.as_str(), "127.0.0.1", ""] {
        for path in ["/", "/api/health", &path_with_token(&studio)] {
            let headers = [("Host", host), ("Cookie", cookie.as_str())];
            let answer = get(address, path, &headers).await;
            assert_eq!(answer.status, 421, "{host} {path}");
            assert_eq!(answer.header("set-cookie"), None);
        }
    }
    let localhost = format!("localhost:{}", address.port());
    let headers = [("Host", localhost.as_str()), ("Cookie", cookie.as_str())];
    assert_eq!(get(address, "/", &headers).await.status, 200);
}

#[tokio::test]
async fn sockets_of_others_are_refused() {
    let studio = start();
    let address = studio.local_address();
    let cookie = log_in(&studio).await;
    let cookie = cookie.as_str();
    let ours = format!("http://{address}");
    let ours = ours.as_str();
    let rebound_host = format!("evil.example:{}", address.port());
    let rebound_origin = format!("http://{rebound_host}");
    type Headers<'a> = &'a [(&'a str, &'a str)];
    let cases: [(&str, Headers<'_>, u16); 7] = [
        ("no cookie", &[("origin", ours)], 401),
        (
            "wrong cookie",
            &[("origin", ours), ("cookie", "factotum_1=0")],
            401,
        ),
        ("no origin", &[("cookie", cookie)], 403),
        (
            "other origin",
            &[("origin", "http://evil.example"), ("cookie", cookie)],
            403,
        ),
        ("no site", &[("origin", "null"), ("cookie", cookie)], 403),
        (
            "other port",
            &[("origin", "http://127.0.0.1:1"), ("cookie", cookie)],
            403,
        ),
        (
            "rebound name",
            &[
                ("origin", &rebound_origin),
                ("host", &rebound_host),
                ("cookie", cookie),
            ],
            421,
        ),
    ];
    for (what, headers, status) in cases {
        let refused = Page::open_with(&studio, headers).await.err();
        assert_eq!(refused, Some(status), "{what}");
    }
    let accepted = Page::open_with(&studio, &[("origin", ours), ("cookie", cookie)]).await;
    assert!(accepted.is_ok());
}

#[tokio::test]
async fn every_answer_limits_what_a_browser_may_do() {
    let studio = start();
    let address = studio.local_address();
    let cookie = log_in(&studio).await;
    let headers = [("Cookie", cookie.as_str())];
    for path in [
        "/",
        "/nothing/here",
        "/api/health",
        "/api/socket",
        "/?token=x",
    ] {
        let answer = get(address, path, &headers).await;
        let policy = answer.header("content-security-policy").unwrap();
        for part in [
            "default-src 'none'",
            "script-src 'self'",
            "frame-ancestors 'none'",
        ] {
            assert!(policy.contains(part), "{path}: {policy}");
        }
        assert!(!policy.contains("unsafe"), "{policy}");
        assert_eq!(answer.header("x-content-type-options"), Some("nosniff"));
        assert_eq!(answer.header("referrer-policy"), Some("no-referrer"));
        assert!(answer.header("cache-control").is_some(), "{path}");
    }
}

#[tokio::test]
async fn paths_lead_nowhere_but_into_the_page() {
    let studio = start();
    let cookie = log_in(&studio).await;
    for path in [
        "/../Cargo.toml",
        "/..%2f..%2fCargo.toml",
        "/%2e%2e/%2e%2e/Cargo.toml",
        "//etc/passwd",
        "/assets/../../Cargo.toml",
    ] {
        let answer = get(studio.local_address(), path, &[("Cookie", &cookie)]).await;
        assert_eq!(answer.status, 404, "{path}: {}", answer.body);
    }
}

#[tokio::test]
async fn a_request_from_another_page_is_refused_on_every_route() {
    let studio = start();
    let address = studio.local_address();
    let cookie = log_in(&studio).await;
    let ours = format!("http://{address}");
    for path in ["/", "/api/health", "/assets/index.js", "/nothing/here"] {
        for origin in ["http://evil.example", "null", "http://localhost:1"] {
            let headers = [("Cookie", cookie.as_str()), ("Origin", origin)];
            assert_eq!(
                get(address, path, &headers).await.status,
                403,
                "{path} {origin}"
            );
        }
        let headers = [("Cookie", cookie.as_str())];
        let refused = request("POST", address, path, &headers).await;
        assert_eq!(refused.status, 403, "{path} without an origin");
        let headers = [("Cookie", cookie.as_str()), ("Origin", ours.as_str())];
        assert_ne!(get(address, path, &headers).await.status, 403, "{path}");
        assert_eq!(
            request("POST", address, path, &headers).await.status,
            405,
            "{path}"
        );
    }
}

#[tokio::test]
async fn wrong_tokens_are_counted_and_the_right_one_has_to_wait_too() {
    let studio = start();
    let address = studio.local_address();
    let mut statuses = Vec::new();
    for number in 0..12 {
        let answer = get(address, &format!("/?token={number}"), &[]).await;
        if answer.status == 429 {
            assert_eq!(answer.header("retry-after"), Some("60"));
        }
        statuses.push(answer.status);
    }
    assert_eq!(statuses, [[401; 10].as_slice(), &[429; 2]].concat());
    assert_eq!(
        get(address, &path_with_token(&studio), &[]).await.status,
        429
    );
}
