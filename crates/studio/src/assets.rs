//! The built page, embedded in the binary.

use axum::body::Body;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{Html, IntoResponse as _, Response};
use rust_embed::RustEmbed;

#[derive(RustEmbed)]
#[folder = "../../web/dist"]
struct Dist;

/// Shown when the binary was built without the page.
const NOT_BUILT: &str = include_str!("not_built.html");
/// Names of files in this folder carry a hash of what is in them, so they never change.
const HASHED: &str = "assets/";

/// Whether the page was built before this program, so that it could be embedded.
#[must_use]
pub fn is_page_built() -> bool {
    Dist::get("index.html").is_some()
}

/// The page itself.
pub(crate) fn page() -> Response {
    match file("index.html") {
        Some(response) => response,
        None => Html(NOT_BUILT).into_response(),
    }
}

/// A file of the page by its path, without a leading slash.
pub(crate) fn file(path: &str) -> Option<Response> {
    let file = Dist::get(path)?;
    let cache = if path.starts_with(HASHED) {
        "private, max-age=31536000, immutable"
    } else {
        "no-cache"
    };
    let headers = [
        (
            header::CONTENT_TYPE,
            HeaderValue::from_static(media_type(path)),
        ),
        (header::CACHE_CONTROL, HeaderValue::from_static(cache)),
    ];
    Some((StatusCode::OK, headers, Body::from(file.data.into_owned())).into_response())
}

/// The media type of the few kinds of file that a built page has.
fn media_type(path: &str) -> &'static str {
    match path.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("json") => "application/json",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("webmanifest") => "application/manifest+json",
        Some("woff2") => "font/woff2",
        _ => "application/octet-stream",
    }
}
