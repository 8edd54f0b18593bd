//! A small browser: HTTP by hand, WebSockets by tokio-tungstenite.

use std::net::SocketAddr;
use std::time::Duration;

use factotum_protocol::{Event, EventLevel, ServerMessage};
use factotum_studio::{Studio, StudioConfig, StudioHandle};
use futures_util::{SinkExt as _, StreamExt as _};
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::tungstenite::http::{HeaderName, HeaderValue};
use tokio_tungstenite::tungstenite::{self, Message};

/// Far longer than anything here takes; a test that waits so long has failed.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);

pub(crate) fn start() -> StudioHandle {
    Studio::start(StudioConfig::default()).unwrap()
}

pub(crate) fn event(text: &str) -> ServerMessage {
    ServerMessage::Event(Event {
        level: EventLevel::Info,
        text: text.to_owned(),
        time_secs: 0.0,
    })
}

/// An HTTP answer: status, headers as they came, body.
#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    head: String,
    pub(crate) body: String,
}

impl Answer {
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.head
            .lines()
            .filter_map(|line| line.split_once(": "))
            .find(|(found, _)| found.eq_ignore_ascii_case(name))
            .map(|(_, value)| value)
    }
}

/// Asks for `path`, with the server's own name as `Host` unless `headers` give another.
pub(crate) async fn get(address: SocketAddr, path: &str, headers: &[(&str, &str)]) -> Answer {
    request("GET", address, path, headers).await
}

/// Asks with another method.
pub(crate) async fn request(
    method: &str,
    address: SocketAddr,
    path: &str,
    headers: &[(&str, &str)],
) -> Answer {
    let mut stream = TcpStream::connect(address).await.unwrap();
    exchange(&mut stream, method, address, path, headers).await
}

/// One request and its answer.
pub(crate) async fn exchange(
    stream: &mut (impl AsyncRead + AsyncWrite + Unpin),
    method: &str,
    address: SocketAddr,
    path: &str,
    headers: &[(&str, &str)],
) -> Answer {
    let mut request = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
    if !headers.iter().any(|(name, _)| *name == "Host") {
        request.push_str(&format!("Host: {address}\r\n"));
    }
    for (name, value) in headers {
        request.push_str(&format!("{name}: {value}\r\n"));
    }
    request.push_str("\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).await.unwrap();
    let answer = String::from_utf8(answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    Answer {
        status: head.split(' ').nth(1).unwrap().parse().unwrap(),
        head: head.to_owned(),
        body: body.to_owned(),
    }
}

/// Path and token of the address that the studio prints.
pub(crate) fn path_with_token(studio: &StudioHandle) -> String {
    let host = format!("http://{}", studio.local_address());
    studio.url().strip_prefix(&host).unwrap().to_owned()
}

/// Opens the printed address and returns the cookie.
pub(crate) async fn log_in(studio: &StudioHandle) -> String {
    let answer = get(studio.local_address(), &path_with_token(studio), &[]).await;
    let cookie = answer.header("set-cookie").unwrap();
    cookie.split(';').next().unwrap().to_owned()
}

/// What a page's socket runs over.
pub(crate) trait Wire: AsyncRead + AsyncWrite + Unpin + Send {}

impl<W: AsyncRead + AsyncWrite + Unpin + Send> Wire for W {}

/// A page's socket.
pub(crate) struct Page {
    pub(crate) socket: WebSocketStream<Box<dyn Wire>>,
}

impl Page {
    /// Connects as the studio's own page does.
    pub(crate) async fn open(studio: &StudioHandle) -> Self {
        let cookie = log_in(studio).await;
        let origin = format!("http://{}", studio.local_address());
        let headers = [("cookie", cookie.as_str()), ("origin", origin.as_str())];
        Self::open_with(studio, &headers).await.unwrap()
    }

    /// Connects with these headers; an error is the status with which the studio refused.
    pub(crate) async fn open_with(
        studio: &StudioHandle,
        headers: &[(&str, &str)],
    ) -> Result<Self, u16> {
        let stream = TcpStream::connect(studio.local_address()).await.unwrap();
        Self::open_over(Box::new(stream), studio, headers).await
    }

    /// Connects over a connection that is there already.
    pub(crate) async fn open_over(
        wire: Box<dyn Wire>,
        studio: &StudioHandle,
        headers: &[(&str, &str)],
    ) -> Result<Self, u16> {
        let url = format!("ws://{}/api/socket", studio.local_address());
        let mut request = url.into_client_request().unwrap();
        for (name, value) in headers {
            request.headers_mut().insert(
                HeaderName::from_bytes(name.as_bytes()).unwrap(),
                HeaderValue::from_str(value).unwrap(),
            );
        }
        match tokio_tungstenite::client_async(request, wire).await {
            Ok((socket, _)) => Ok(Self { socket }),
            Err(tungstenite::Error::Http(refusal)) => Err(refusal.status().as_u16()),
            Err(error) => panic!("{error}"),
        }
    }

    pub(crate) async fn send(&mut self, text: &str) {
        self.socket.send(Message::text(text)).await.unwrap();
    }

    /// The next message of the studio.
    pub(crate) async fn next(&mut self) -> ServerMessage {
        match self.next_frame().await {
            Some(Message::Text(text)) => serde_json::from_str(text.as_str()).unwrap(),
            other => panic!("expected a message, found {other:?}"),
        }
    }

    /// The code with which the studio closes the connection, whatever comes before.
    pub(crate) async fn close_code(&mut self) -> Option<u16> {
        while let Some(message) = self.next_frame().await {
            if let Message::Close(frame) = message {
                return frame.map(|frame| frame.code.into());
            }
        }
        None
    }

    async fn next_frame(&mut self) -> Option<Message> {
        let next = tokio::time::timeout(PATIENCE, self.socket.next());
        next.await.unwrap()?.ok()
    }

    /// Skips messages until the event with this text, and returns what was skipped.
    pub(crate) async fn until_event(&mut self, text: &str) -> Vec<ServerMessage> {
        let mut skipped = Vec::new();
        loop {
            match self.next().await {
                ServerMessage::Event(event) if event.text == text => return skipped,
                other => skipped.push(other),
            }
        }
    }
}
