//! What is served where, behind which checks.

use std::sync::Arc;
use std::time::Instant;

use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{ConnectInfo, DefaultBodyLimit, Path, Query, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Redirect, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde::{Deserialize, Serialize};

use crate::access::Refusal;
use crate::audit::{Kind, Line};
use crate::door::Peer;
use crate::server::Shared;
use crate::{assets, connection};

/// No request has a body that matters; this only keeps one from filling the memory.
const BODY_BYTES_MAX: usize = 16 * 1024;
/// What is larger than this is not even read: the connection is closed.
const MESSAGE_BYTES_MAX: usize = 256 * 1024;

/// Scripts, styles and connections of this server only; the page is never framed.
const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self' data: blob:; font-src 'self'; connect-src 'self'; manifest-src 'self'; \
    base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What a browser may do with every answer.
const HEADERS: [(HeaderName, &str); 6] = [
    (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    // The token in the first address must not travel on.
    (header::REFERRER_POLICY, "no-referrer"),
    // No other page shares its memory or embeds what it is made of.
    (
        HeaderName::from_static("cross-origin-opener-policy"),
        "same-origin",
    ),
    (
        HeaderName::from_static("cross-origin-resource-policy"),
        "same-origin",
    ),
    (
        HeaderName::from_static("permissions-policy"),
        "camera=(), geolocation=(), microphone=(), payment=(), usb=(), xr-spatial-tracking=(self)",
    ),
];

const REFUSED: &str = include_str!("refused.html");

/// All routes of the studio.
pub(crate) fn router(shared: Arc<Shared>) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/{*path}", get(asset))
        .route("/api/health", get(health))
        .route("/api/socket", get(socket))
        .layer(DefaultBodyLimit::max(BODY_BYTES_MAX))
        .layer(middleware::from_fn_with_state(Arc::clone(&shared), guard))
        .with_state(shared)
}

/// Turns away requests for other hosts and from other pages, fixes what a browser may do with every answer, and notes
/// who was refused.
async fn guard(
    State(shared): State<Arc<Shared>>,
    ConnectInfo(Peer(peer)): ConnectInfo<Peer>,
    request: Request,
    next: Next,
) -> Response {
    let (access, headers) = (&shared.access, request.headers());
    let checked = access
        .check_host(headers)
        .and_then(|()| access.check_origin(request.method(), headers));
    let mut response = match checked {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.into_response(),
    };
    if let Some(refusal) = response.extensions().get::<Refusal>() {
        tracing::warn!(?refusal, %peer, "request refused");
        // A browser without a cookie is nobody's attack: it is told where the address is.
        if *refusal != Refusal::Cookie {
            let line = Line::new(Kind::Refusal, refusal.words());
            shared.audit.note(&line.from(peer));
        }
    }
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers
        .entry(header::CACHE_CONTROL)
        .or_insert(HeaderValue::from_static("no-store"));
    response
}

#[derive(Deserialize)]
struct PageQuery {
    token: Option<String>,
}

/// The page; a token in the address is exchanged for the cookie and taken out of the address.
async fn page(
    State(shared): State<Arc<Shared>>,
    ConnectInfo(Peer(peer)): ConnectInfo<Peer>,
    Query(query): Query<PageQuery>,
    headers: HeaderMap,
) -> Response {
    let Some(token) = query.token else {
        return match shared.access.visitor(&headers) {
            Ok(_) => assets::page(),
            Err(refusal) => refusal.into_response(),
        };
    };
    match shared.access.exchange(&token, peer, Instant::now()) {
        Ok((visitor, cookie)) => {
            let line = Line::new(Kind::Pairing, "");
            shared
                .audit
                .note(&line.of(&visitor.name, visitor.role).from(peer));
            let mut response = Redirect::to("/").into_response();
            response.headers_mut().insert(header::SET_COOKIE, cookie);
            response
        }
        Err(refusal) => refusal.into_response(),
    }
}

async fn asset(
    State(shared): State<Arc<Shared>>,
    Path(path): Path<String>,
    headers: HeaderMap,
) -> Response {
    match shared.access.visitor(&headers) {
        Ok(_) => assets::file(&path).unwrap_or_else(|| StatusCode::NOT_FOUND.into_response()),
        Err(refusal) => refusal.into_response(),
    }
}

#[derive(Serialize)]
struct Health {
    status: &'static str,
    protocol_version: u32,
}

/// For scripts that wait until the studio is up; says nothing of the job.
async fn health() -> Json<Health> {
    Json(Health {
        status: "ok",
        protocol_version: factotum_protocol::VERSION,
    })
}

async fn socket(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    let visitor = match shared.access.visitor(&headers) {
        Ok(visitor) => visitor,
        Err(refusal) => return refusal.into_response(),
    };
    let Ok(seat) = Arc::clone(&shared.seats).try_acquire_owned() else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n").into_response();
    };
    upgrade
        .max_message_size(MESSAGE_BYTES_MAX)
        .max_frame_size(MESSAGE_BYTES_MAX)
        .on_upgrade(move |socket| async move {
            connection::serve(socket, &shared, visitor).await;
            drop(seat);
        })
}

impl Refusal {
    fn words(self) -> &'static str {
        match self {
            Self::Host => "not the name of this server",
            Self::Origin => "not a page of this server",
            Self::Cookie => "no cookie of this server",
            Self::Token => "a token that is wrong or used up",
            Self::TooManyAttempts => "too many wrong tokens; wait a minute",
        }
    }
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let status = match self {
            Self::Host => StatusCode::MISDIRECTED_REQUEST,
            Self::Origin => StatusCode::FORBIDDEN,
            Self::Cookie | Self::Token => StatusCode::UNAUTHORIZED,
            Self::TooManyAttempts => StatusCode::TOO_MANY_REQUESTS,
        };
        let mut response = match self {
            Self::Cookie | Self::Token => (status, Html(REFUSED)).into_response(),
            _ => (status, format!("{}\n", self.words())).into_response(),
        };
        if self == Self::TooManyAttempts {
            let wait = HeaderValue::from_static("60");
            response.headers_mut().insert(header::RETRY_AFTER, wait);
        }
        // For the guard, which knows where the request came from.
        response.extensions_mut().insert(self);
        response
    }
}
