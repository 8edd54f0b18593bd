//! Starting and stopping the server, and the handle by which the rest of the program uses it.

use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use factotum_protocol::{Role, ServerMessage};
use rustls::ServerConfig;
use tokio::runtime::Runtime;
use tokio::sync::{Semaphore, watch};

use crate::access::{Access, Link, random_hex};
use crate::audit::{Audit, since_epoch};
use crate::certificate::Certificate;
use crate::commands::Commands;
use crate::control::Ownership;
use crate::door::{Door, Peer};
use crate::edits::Edits;
use crate::picture::Picture;
use crate::{StudioError, routes};

/// How long connections may take to end when the studio shuts down.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(2);

/// What a studio may be told. The default is a free port on loopback and a random token.
#[derive(Clone, Debug)]
pub struct StudioConfig {
    /// Address to listen on; without a [`Lan`] it must be on loopback. Port 0 takes a free one.
    pub bind: SocketAddr,
    /// Token that lets a browser in on loopback: at least 22 letters and digits. `None` makes a random one,
    /// which is what everybody but a test should use.
    pub token: Option<String>,
    /// Serves other machines too, encrypted.
    pub lan: Option<Lan>,
    /// File to which is written who did what, a JSON document a line. It is put aside when it has grown.
    pub audit: Option<PathBuf>,
    /// How many past events a late page is shown.
    pub events_max: usize,
    /// How many pages may be open at once.
    pub pages_max: u16,
    /// Whether somebody takes the pages' edits. If not, they are refused.
    pub takes_edits: bool,
}

impl Default for StudioConfig {
    fn default() -> Self {
        Self {
            bind: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
            token: None,
            lan: None,
            audit: None,
            events_max: 200,
            pages_max: 32,
            takes_edits: false,
        }
    }
}

/// How a studio serves other machines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lan {
    /// Addresses and names by which browsers may call it; the first is printed. See [`lan_names`](crate::lan_names).
    pub names: Vec<String>,
    /// File in which certificate and key are kept from one run to the next. Its owner alone may read it.
    pub certificate: PathBuf,
    /// For each a link is made.
    pub roles: Vec<Role>,
}

/// The server. See the crate's documentation.
#[derive(Debug)]
pub struct Studio;

/// What routes and connections share with the handle.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) access: Access,
    pub(crate) picture: Picture,
    pub(crate) commands: Commands,
    /// None where nobody takes them.
    pub(crate) edits: Option<Edits>,
    pub(crate) ownership: Ownership,
    pub(crate) audit: Arc<Audit>,
    n_clients: AtomicU64,
    pub(crate) session: String,
    pub(crate) seats: Arc<Semaphore>,
    n_seats: u32,
    pub(crate) closing: watch::Sender<bool>,
}

impl Shared {
    /// A name for another connection of a browser.
    pub(crate) fn client_name(&self, session: &str) -> String {
        let number = self.n_clients.fetch_add(1, Ordering::Relaxed) + 1;
        format!("{session}-{number}")
    }
}

impl Studio {
    /// Serves until the handle is shut down or dropped. The address is open when this returns.
    ///
    /// # Errors
    ///
    /// When the configuration is refused, the address is taken, the certificate cannot be made or kept, or the system
    /// has no thread or no random numbers left.
    pub fn start(config: StudioConfig) -> Result<StudioHandle, StudioError> {
        let address = config.bind;
        if config.lan.is_none() && !address.ip().is_loopback() {
            return Err(StudioError::NotLoopback { address });
        }
        let bind_error = |source| StudioError::Bind { address, source };
        let listener = TcpListener::bind(address).map_err(bind_error)?;
        listener.set_nonblocking(true).map_err(bind_error)?;
        let address = listener.local_addr().map_err(bind_error)?;
        let (mut tls, mut fingerprint) = (None, None);
        let access = match &config.lan {
            None => Access::on_loopback(address, config.token)?,
            Some(lan) => {
                let kept =
                    Certificate::kept(&lan.certificate, &lan.names, since_epoch().as_secs())?;
                tls = Some(kept.tls().map_err(|source| StudioError::Tls { source })?);
                fingerprint = Some(kept.fingerprint());
                Access::on_lan(&lan.names, address.port(), &lan.roles)?
            }
        };
        let shared = Arc::new(Shared {
            access,
            picture: Picture::new(config.events_max),
            commands: Commands::default(),
            edits: config.takes_edits.then(Edits::default),
            ownership: Ownership::default(),
            audit: Arc::new(Audit::new(config.audit)),
            n_clients: AtomicU64::new(0),
            session: random_hex()?,
            seats: Arc::new(Semaphore::new(usize::from(config.pages_max))),
            n_seats: u32::from(config.pages_max),
            closing: watch::Sender::new(false),
        });
        // One thread is plenty for the pages that may be open, and leaves the rest to the robot.
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|source| StudioError::Thread { source })?;
        let served = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("studio".to_owned())
            .spawn(move || serve(runtime, listener, tls, served))
            .map_err(|source| StudioError::Thread { source })?;
        Ok(StudioHandle {
            address,
            fingerprint,
            shared,
            thread: Some(thread),
        })
    }
}

/// The studio's thread: serves until `closing`, then lets connections say goodbye.
fn serve(
    runtime: Runtime,
    listener: TcpListener,
    tls: Option<Arc<ServerConfig>>,
    shared: Arc<Shared>,
) {
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener);
        let door = match listener.and_then(|listener| Door::open(listener, tls)) {
            Ok(door) => door,
            Err(error) => {
                tracing::error!(%error, "studio cannot use its socket");
                return;
            }
        };
        let mut closing = shared.closing.subscribe();
        let router = routes::router(Arc::clone(&shared));
        let server = axum::serve(door, router.into_make_service_with_connect_info::<Peer>())
            .with_graceful_shutdown(async move {
                // An error means that all handles are gone, which ends the server as well.
                drop(closing.wait_for(|closing| *closing).await);
            })
            .into_future();
        let mut closing = shared.closing.subscribe();
        let deadline = async move {
            drop(closing.wait_for(|closing| *closing).await);
            tokio::time::sleep(SHUTDOWN_TIMEOUT).await;
        };
        // Sockets have left the server's care; they are gone when all seats are free again.
        let ended = async {
            let ended = server.await;
            drop(shared.seats.acquire_many(shared.n_seats).await);
            ended
        };
        tokio::select! {
            ended = ended => if let Err(error) = ended {
                tracing::error!(%error, "studio ended");
            },
            () = deadline => tracing::debug!("pages were slow to leave"),
        }
    });
    runtime.shutdown_background();
}

/// A running studio. Dropping it shuts the studio down.
#[derive(Debug)]
pub struct StudioHandle {
    address: SocketAddr,
    fingerprint: Option<String>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl StudioHandle {
    /// The address to open in a browser. It carries a token: print it for the person at the
    /// terminal, and for nobody else. Of an encrypted studio, the first of [`links`](Self::links).
    #[must_use]
    pub fn url(&self) -> String {
        let first = self.links().into_iter().next();
        first.map_or_else(String::new, |link| link.url)
    }

    /// What lets browsers in now: on loopback one link, of an encrypted studio one for each role.
    #[must_use]
    pub fn links(&self) -> Vec<Link> {
        self.shared.access.links()
    }

    /// The links that were made since this was last asked: at first all, then one for each that was used up.
    #[must_use]
    pub fn take_new_links(&self) -> Vec<Link> {
        self.shared.access.take_new_links()
    }

    /// SHA-256 of the certificate, as browsers show it; none on loopback, where there is none.
    #[must_use]
    pub fn fingerprint(&self) -> Option<&str> {
        self.fingerprint.as_deref()
    }

    /// The address listened on.
    #[must_use]
    pub fn local_address(&self) -> SocketAddr {
        self.address
    }

    /// Shows something to all pages, open now or later. Never waits for a page.
    ///
    /// The latest message of a kind (of a source for scenes) and the last events are kept;
    /// a [`State`](factotum_protocol::State) that no page has time for costs next to nothing.
    /// A greeting, or a state with a number that is not finite, is dropped with a warning.
    pub fn publish(&self, message: ServerMessage) {
        if let Err(reason) = self.shared.picture.put(message) {
            tracing::warn!(reason, "message not published");
        }
    }

    /// The pages' commands.
    #[must_use]
    pub fn commands(&self) -> Commands {
        self.shared.commands.clone()
    }

    /// The pages' edits; none ever where the studio does not take them.
    #[must_use]
    pub fn edits(&self) -> Edits {
        self.shared.edits.clone().unwrap_or_default()
    }

    /// How many pages are open.
    #[must_use]
    pub fn n_pages(&self) -> usize {
        self.shared.n_seats as usize - self.shared.seats.available_permits()
    }

    /// Tells all pages that this is the end and waits until the studio's thread has ended.
    pub fn shutdown(mut self) {
        self.end();
    }

    fn end(&mut self) {
        self.shared.closing.send_replace(true);
        if let Some(Err(_panic)) = self.thread.take().map(JoinHandle::join) {
            tracing::error!("the studio's thread panicked");
        }
    }
}

impl Drop for StudioHandle {
    fn drop(&mut self) {
        self.end();
    }
}

/// Handles travel between threads.
const _: () = {
    const fn is_send_and_sync<T: Send + Sync>() {}
    is_send_and_sync::<StudioHandle>();
    is_send_and_sync::<Commands>();
    is_send_and_sync::<Edits>();
};
