//! What is served where, behind which checks.

use std::sync::Arc;

use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{DefaultBodyLimit, Path, Query, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{Html, IntoResponse, Redirect, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde::{Deserialize, Serialize};

use crate::access::Refusal;
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

/// Turns away requests for other hosts, and fixes what a browser may do with every answer.
async fn guard(State(shared): State<Arc<Shared>>, request: Request, next: Next) -> Response {
    let mut response = match shared.access.check_host(request.headers()) {
        Ok(()) => next.run(request).await,
        Err(refusal) => refusal.into_response(),
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        // The token in the first address must not travel on.
        (header::REFERRER_POLICY, "no-referrer"),
    ] {
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
    Query(query): Query<PageQuery>,
    headers: HeaderMap,
) -> Response {
    match query.token {
        Some(token) if shared.access.token_matches(&token) => {
            let mut response = Redirect::to("/").into_response();
            if let Some(cookie) = shared.access.set_cookie() {
                response.headers_mut().insert(header::SET_COOKIE, cookie);
            }
            response
        }
        Some(_) => Refusal::Cookie.into_response(),
        None => match shared.access.check_cookie(&headers) {
            Ok(()) => assets::page(),
            Err(refusal) => refusal.into_response(),
        },
    }
}

async fn asset(
    State(shared): State<Arc<Shared>>,
    Path(path): Path<String>,
    headers: HeaderMap,
) -> Response {
    match shared.access.check_cookie(&headers) {
        Ok(()) => assets::file(&path).unwrap_or_else(|| StatusCode::NOT_FOUND.into_response()),
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
    let checked = shared
        .access
        .check_origin(&headers)
        .and_then(|()| shared.access.check_cookie(&headers));
    if let Err(refusal) = checked {
        return refusal.into_response();
    }
    let Ok(seat) = Arc::clone(&shared.seats).try_acquire_owned() else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n").into_response();
    };
    upgrade
        .max_message_size(MESSAGE_BYTES_MAX)
        .max_frame_size(MESSAGE_BYTES_MAX)
        .on_upgrade(move |socket| async move {
            connection::serve(socket, &shared).await;
            drop(seat);
        })
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        tracing::warn!(refusal = ?self, "request refused");
        match self {
            Self::Host => (
                StatusCode::MISDIRECTED_REQUEST,
                "not the name of this server\n",
            )
                .into_response(),
            Self::Origin => (StatusCode::FORBIDDEN, "not a page of this server\n").into_response(),
            Self::Cookie => (StatusCode::UNAUTHORIZED, Html(REFUSED)).into_response(),
        }
    }
}
