//! The server behind Factotum's page: HTTP and WebSocket, sessions, auth and the page's assets.
//!
//! [`Studio::start`] serves the page from threads of its own and returns a [`StudioHandle`]. What
//! runs a job tells the handle what there is to see with [`publish`](StudioHandle::publish), which
//! never waits for a network, and asks it for the page's [`commands`](StudioHandle::commands).
//!
//! # How what is published reaches a page
//!
//! The studio keeps one *picture*: the latest message of each kind (of each source for scenes) and
//! the last events. Every connection remembers how much of the picture it has sent and is woken
//! when there is more. So a late or returning page gets the whole picture, a slow one skips what
//! was overtaken meanwhile, and no connection has a queue that could grow.
//!
//! # How a home is edited
//!
//! A studio with [`takes_edits`](StudioConfig::takes_edits) hands the pages' edits out by
//! [`edits`](StudioHandle::edits), in the order in which they arrive: that is the order in which they are applied.
//! Whoever keeps the home applies one, publishes what it made of the home, and then answers it; the answer goes to the
//! page that asked, after what was published before. An edit that was made on a state that somebody has changed since
//! is refused: see [`EditRequest::base`](factotum_protocol::EditRequest::base). A page whose connection broke asks
//! again under the same id, and whoever keeps the home answers without applying the edit twice.
//!
//! # Who gets in
//!
//! The studio listens on loopback only and refuses anything else: its traffic is not encrypted.
//! [`url`](StudioHandle::url) carries a random 128-bit token, which is exchanged once for a cookie
//! (`HttpOnly`, `SameSite=Strict`) and leaves the address bar. Every request must name this server
//! in `Host` (against DNS rebinding), and a WebSocket also in `Origin` (against other pages).
//!
//! # Example
//!
//! ```
//! use factotum_studio::{Studio, StudioConfig};
//! use factotum_protocol::{ClientMessage, Event, EventLevel, ServerMessage};
//!
//! let studio = Studio::start(StudioConfig::default())?;
//! assert!(studio.url().starts_with("http://127.0.0.1:"));
//! studio.publish(ServerMessage::Event(Event {
//!     level: EventLevel::Info,
//!     text: "exploring the kitchen".to_owned(),
//!     time_secs: 1.5,
//! }));
//! if studio.commands().try_next() == Some(ClientMessage::Stop) {
//!     // stop the robot
//! }
//! studio.shutdown();
//! # Ok::<(), factotum_studio::StudioError>(())
//! ```

mod access;
mod assets;
mod commands;
mod connection;
mod edits;
mod error;
mod picture;
mod routes;
mod server;

pub use assets::is_page_built;
pub use commands::Commands;
pub use edits::{AskedEdit, Edits};
pub use error::StudioError;
pub use server::{Studio, StudioConfig, StudioHandle};
