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
//! On loopback, which is the default, [`url`](StudioHandle::url) carries a random 128-bit token, which is exchanged for
//! a cookie (`HttpOnly`, `SameSite=Strict`) and leaves the address bar. Another address is refused unless the studio is
//! told to serve a [`Lan`]: it then speaks TLS with a certificate of its own, and each [`Link`] lets one browser in, as
//! what its role says. Every request must name this server in `Host` (against DNS rebinding), and whatever does more
//! than look also in `Origin` (against other pages). What is promised and what is not: `docs/security.md`.
//!
//! # Who may do what
//!
//! A page looks, teaches or commands, as its [`Role`](factotum_protocol::Role) says. One page at a time has the robot:
//! the first that commands it. While it drives, its commands are the heartbeat; when they stop or it is gone, the robot
//! is told to come to rest. A stop is taken from everybody. Who did what is written to
//! [`audit`](StudioConfig::audit).
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
mod attempts;
mod audit;
mod certificate;
mod commands;
mod connection;
mod control;
mod door;
mod edits;
mod error;
mod lan;
mod picture;
mod routes;
mod server;

pub use access::Link;
pub use assets::is_page_built;
pub use commands::Commands;
pub use edits::{AskedEdit, Edits};
pub use error::StudioError;
pub use lan::lan_names;
pub use server::{Lan, Studio, StudioConfig, StudioHandle};
