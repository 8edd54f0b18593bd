//! Starting and stopping the server, and the handle by which the rest of the program uses it.

use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use factotum_protocol::ServerMessage;
use tokio::runtime::Runtime;
use tokio::sync::{Semaphore, watch};

use crate::access::{Access, random_hex};
use crate::commands::Commands;
use crate::edits::Edits;
use crate::picture::Picture;
use crate::{StudioError, routes};

/// How long connections may take to end when the studio shuts down.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(2);

/// What a studio may be told. The default is a free port on loopback and a random token.
#[derive(Clone, Debug)]
pub struct StudioConfig {
    /// Address to listen on; it must be on loopback. Port 0 takes a free one.
    pub bind: SocketAddr,
    /// Token that lets a browser in: at least 22 letters and digits. `None` makes a random one,
    /// which is what everybody but a test should use.
    pub token: Option<String>,
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
            events_max: 200,
            pages_max: 32,
            takes_edits: false,
        }
    }
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
    pub(crate) session: String,
    pub(crate) seats: Arc<Semaphore>,
    n_seats: u32,
    pub(crate) closing: watch::Sender<bool>,
}

impl Studio {
    /// Serves until the handle is shut down or dropped. The address is open when this returns.
    ///
    /// # Errors
    ///
    /// When the configuration is refused, the address is taken, or the system has no thread or no
    /// random numbers left.
    pub fn start(config: StudioConfig) -> Result<StudioHandle, StudioError> {
        let address = config.bind;
        if !address.ip().is_loopback() {
            return Err(StudioError::NotLoopback { address });
        }
        let bind_error = |source| StudioError::Bind { address, source };
        let listener = TcpListener::bind(address).map_err(bind_error)?;
        listener.set_nonblocking(true).map_err(bind_error)?;
        let address = listener.local_addr().map_err(bind_error)?;
        let shared = Arc::new(Shared {
            access: Access::new(address, config.token)?,
            picture: Picture::new(config.events_max),
            commands: Commands::default(),
            edits: config.takes_edits.then(Edits::default),
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
            .spawn(move || serve(runtime, listener, served))
            .map_err(|source| StudioError::Thread { source })?;
        Ok(StudioHandle {
            url: shared.access.url(),
            address,
            shared,
            thread: Some(thread),
        })
    }
}

/// The studio's thread: serves until `closing`, then lets connections say goodbye.
fn serve(runtime: Runtime, listener: TcpListener, shared: Arc<Shared>) {
    runtime.block_on(async {
        let listener = match tokio::net::TcpListener::from_std(listener) {
            Ok(listener) => listener,
            Err(error) => {
                tracing::error!(%error, "studio cannot use its socket");
                return;
            }
        };
        let mut closing = shared.closing.subscribe();
        let server = axum::serve(listener, routes::router(Arc::clone(&shared)))
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
    url: String,
    address: SocketAddr,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl StudioHandle {
    /// The address to open in a browser. It carries the token: print it for the person at the
    /// terminal, and for nobody else.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.url
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
