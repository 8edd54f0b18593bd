//! An encrypted studio: its certificate, its links, and its roles. The tests call it on loopback.

use std::path::Path;
use std::sync::Arc;

use factotum_protocol::{ClientMessage, Control, EditOutcome, EventLevel, Role, ServerMessage};
use factotum_studio::{Lan, Link, Studio, StudioConfig, StudioHandle};
use serde_json::Value;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::client::danger::{
    HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier,
};
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use tokio_rustls::rustls::{self, ClientConfig, DigitallySignedStruct, SignatureScheme};

use crate::client::{Answer, PATIENCE, Page, event, exchange};

fn start(dir: &Path, takes_edits: bool) -> StudioHandle {
    Studio::start(StudioConfig {
        lan: Some(Lan {
            names: ["127.0.0.1", "localhost"].map(str::to_owned).to_vec(),
            certificate: dir.join("certificate.json"),
            roles: Role::ALL.to_vec(),
        }),
        audit: Some(dir.join("audit.jsonl")),
        takes_edits,
        ..StudioConfig::default()
    })
    .unwrap()
}

/// Trusts whoever holds the key of the certificate that it shows, as a person does who has compared its fingerprint.
#[derive(Debug)]
struct TrustsAny;

impl ServerCertVerifier for TrustsAny {
    fn verify_server_cert(
        &self,
        _end_entity: &CertificateDer<'_>,
        _intermediates: &[CertificateDer<'_>],
        _server_name: &ServerName<'_>,
        _ocsp: &[u8],
        _now: UnixTime,
    ) -> Result<ServerCertVerified, rustls::Error> {
        Ok(ServerCertVerified::assertion())
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        let provider = rustls::crypto::ring::default_provider();
        let known = &provider.signature_verification_algorithms;
        rustls::crypto::verify_tls12_signature(message, certificate, signed, known)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        let provider = rustls::crypto::ring::default_provider();
        let known = &provider.signature_verification_algorithms;
        rustls::crypto::verify_tls13_signature(message, certificate, signed, known)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        rustls::crypto::ring::default_provider()
            .signature_verification_algorithms
            .supported_schemes()
    }
}

fn client() -> rustls::ConfigBuilder<ClientConfig, rustls::WantsVerifier> {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()
        .unwrap()
}

async fn connect(studio: &StudioHandle) -> TlsStream<TcpStream> {
    let config = client()
        .dangerous()
        .with_custom_certificate_verifier(Arc::new(TrustsAny))
        .with_no_client_auth();
    let stream = TcpStream::connect(studio.local_address()).await.unwrap();
    let name = ServerName::try_from("127.0.0.1").unwrap();
    let connector = TlsConnector::from(Arc::new(config));
    connector.connect(name, stream).await.unwrap()
}

async fn get(studio: &StudioHandle, path: &str, headers: &[(&str, &str)]) -> Answer {
    let mut stream = connect(studio).await;
    exchange(&mut stream, "GET", studio.local_address(), path, headers).await
}

fn path_of(link: &Link) -> String {
    let (_, token) = link.url.split_once("token=").unwrap();
    format!("/?token={token}")
}

fn link(studio: &StudioHandle, role: Role) -> Link {
    let mut links = studio.links().into_iter();
    links.find(|link| link.role == role).unwrap()
}

/// Opens the link of a role and returns the cookie.
async fn pair(studio: &StudioHandle, role: Role) -> String {
    let answer = get(studio, &path_of(&link(studio, role)), &[]).await;
    assert_eq!(answer.status, 303, "{}", answer.body);
    let cookie = answer.header("set-cookie").unwrap();
    cookie.split(';').next().unwrap().to_owned()
}

async fn open(studio: &StudioHandle, role: Role) -> Page {
    let cookie = pair(studio, role).await;
    let origin = format!("https://{}", studio.local_address());
    let headers = [("cookie", cookie.as_str()), ("origin", origin.as_str())];
    let wire = Box::new(connect(studio).await);
    let mut page = Page::open_over(wire, studio, &headers).await.unwrap();
    let ServerMessage::Hello(hello) = page.next().await else {
        panic!("no greeting");
    };
    assert_eq!(hello.role, role);
    page
}

/// Waits on another thread, so that the test's own can go on serving the page.
async fn next_command(studio: &StudioHandle) -> Option<ClientMessage> {
    let commands = studio.commands();
    let next = tokio::task::spawn_blocking(move || commands.next_within(PATIENCE));
    next.await.unwrap()
}

async fn warning(page: &mut Page) -> String {
    loop {
        if let ServerMessage::Event(event) = page.next().await
            && event.level == EventLevel::Warning
        {
            return event.text;
        }
    }
}

fn audit(dir: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(dir.join("audit.jsonl")).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

#[tokio::test]
async fn a_link_lets_one_browser_in_and_leaves_no_secret_behind() {
    let dir = tempfile::tempdir().unwrap();
    let studio = start(dir.path(), false);
    let links = studio.take_new_links();
    assert_eq!(links.len(), 3);
    let used = &links[2];
    assert!(
        used.url
            .starts_with(&format!("https://{}/?token=", studio.local_address()))
    );
    let answer = get(&studio, &path_of(used), &[]).await;
    assert_eq!(answer.status, 303);
    assert_eq!(answer.header("location"), Some("/"));
    let cookie = answer.header("set-cookie").unwrap();
    for part in [
        "__Host-factotum_",
        "; HttpOnly",
        "; Secure",
        "; SameSite=Strict",
        "; Path=/",
    ] {
        assert!(cookie.contains(part), "{cookie}");
    }
    assert_eq!(
        get(&studio, &path_of(used), &[]).await.status,
        401,
        "used up"
    );
    let new = studio.take_new_links();
    assert_eq!(
        new.iter().map(|link| link.role).collect::<Vec<_>>(),
        [Role::Execute]
    );
    let cookie = cookie.split(';').next().unwrap();
    let page = get(&studio, "/", &[("Cookie", cookie)]).await;
    assert_eq!(page.status, 200);
    for link in links.iter().chain(&new) {
        let (_, token) = link.url.split_once("token=").unwrap();
        assert!(!page.body.contains(token));
    }
}

#[tokio::test]
async fn what_is_not_encrypted_gets_nothing_and_keeps_nobody_waiting() {
    let dir = tempfile::tempdir().unwrap();
    let studio = start(dir.path(), false);
    // One that says nothing, one that speaks plain HTTP, one that speaks nonsense.
    let silent = TcpStream::connect(studio.local_address()).await.unwrap();
    for words in [b"GET / HTTP/1.1\r\n\r\n".as_slice(), &[0xff; 600]] {
        let mut plain = TcpStream::connect(studio.local_address()).await.unwrap();
        plain.write_all(words).await.unwrap();
        let mut answer = Vec::new();
        // The other end may have closed before all was read, which resets the connection.
        drop(plain.read_to_end(&mut answer).await);
        assert!(!answer.starts_with(b"HTTP"), "{}", answer.escape_ascii());
    }
    assert_eq!(get(&studio, "/api/health", &[]).await.status, 200);
    drop(silent);
}

#[tokio::test]
async fn the_certificate_holds_for_its_names_and_stays_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let studio = start(dir.path(), false);
    let fingerprint = studio.fingerprint().unwrap().to_owned();
    let stream = connect(&studio).await;
    let (_, session) = stream.get_ref();
    let certificate = session.peer_certificates().unwrap()[0].clone().into_owned();
    drop(stream);
    let mut roots = rustls::RootCertStore::empty();
    roots.add(certificate).unwrap();
    let config = Arc::new(client().with_root_certificates(roots).with_no_client_auth());
    for (name, is_ours) in [
        ("127.0.0.1", true),
        ("localhost", true),
        ("evil.example", false),
    ] {
        let connector = TlsConnector::from(Arc::clone(&config));
        let stream = TcpStream::connect(studio.local_address()).await.unwrap();
        let found = connector
            .connect(ServerName::try_from(name).unwrap(), stream)
            .await;
        assert_eq!(found.is_ok(), is_ours, "{name}: {:?}", found.err());
    }
    tokio::task::spawn_blocking(move || drop(studio))
        .await
        .unwrap();
    assert_eq!(
        start(dir.path(), false).fingerprint(),
        Some(fingerprint.as_str())
    );
}

#[tokio::test]
async fn a_role_does_what_it_says_and_no_more() {
    let dir = tempfile::tempdir().unwrap();
    let studio = start(dir.path(), true);
    let mut viewer = open(&studio, Role::View).await;
    let mut teacher = open(&studio, Role::Teach).await;
    let edit = r#"{"type":"edit","id":"a","base":null,"edit":{"kind":"undo"}}"#;
    viewer.send(edit).await;
    let ServerMessage::EditAnswer(answer) = viewer.next().await else {
        panic!("no answer");
    };
    let EditOutcome::Refused { reason } = answer.outcome else {
        panic!("a viewer taught");
    };
    assert!(
        reason.contains("opened to view") && reason.contains("link to teach"),
        "{reason}"
    );
    for (page, role) in [(&mut viewer, "view"), (&mut teacher, "teach")] {
        for command in ["pause", "resume", "drive_done"] {
            page.send(&format!(r#"{{"type":"{command}"}}"#)).await;
            let said = warning(page).await;
            assert!(said.contains(&format!("opened to {role}")), "{said}");
            assert!(said.contains("link to execute"), "{said}");
        }
    }
    assert_eq!(studio.commands().try_next(), None);
    teacher.send(edit).await;
    let edits = studio.edits();
    let asked = tokio::task::spawn_blocking(move || edits.next_within(PATIENCE));
    let accepted = EditOutcome::Accepted {
        entry: Some(3),
        what: "undone".to_owned(),
    };
    asked.await.unwrap().unwrap().answer(accepted);
    assert!(matches!(teacher.next().await, ServerMessage::EditAnswer(_)));
    // Whoever sees that something goes wrong may stop it.
    viewer.send(r#"{"type":"stop"}"#).await;
    assert_eq!(next_command(&studio).await, Some(ClientMessage::Stop));

    let lines = audit(dir.path());
    let kinds = |kind: &str| lines.iter().filter(|line| line["kind"] == kind).count();
    assert_eq!(kinds("pairing"), 2);
    assert_eq!(kinds("refusal"), 7);
    assert_eq!(kinds("command"), 1);
    let taught = lines.iter().find(|line| line["kind"] == "edit").unwrap();
    assert_eq!(taught["role"], "teach");
    assert_eq!(taught["outcome"]["entry"], 3);
    for line in &lines {
        let secs = line["unix_secs"].as_f64().unwrap();
        assert!(secs > 1.7e9 && line["client"] != "", "{line}");
    }
}

#[tokio::test]
async fn one_page_has_the_robot_and_pause_and_stop_are_for_all_who_may() {
    let dir = tempfile::tempdir().unwrap();
    let studio = start(dir.path(), false);
    let mut ana = open(&studio, Role::Execute).await;
    let mut ben = open(&studio, Role::Execute).await;
    let ahead = r#"{"type":"drive","forward":0.5,"left":0,"turn":0}"#;
    ana.send(ahead).await;
    assert!(matches!(
        next_command(&studio).await,
        Some(ClientMessage::Drive(_))
    ));
    let ServerMessage::Control(Control { owner: Some(owner) }) = ben.next().await else {
        panic!("ben does not hear who drives");
    };
    ben.send(ahead).await;
    let said = warning(&mut ben).await;
    assert!(
        said.contains(&format!("page {owner} has the robot")),
        "{said}"
    );
    ben.send(r#"{"type":"pause"}"#).await;
    let commands: Vec<_> = [next_command(&studio).await, next_command(&studio).await].into();
    assert!(
        commands.contains(&Some(ClientMessage::Pause)),
        "{commands:?}"
    );
    drop(ana);
    loop {
        if ben.next().await == ServerMessage::Control(Control { owner: None }) {
            break;
        }
    }
    ben.send(r#"{"type":"resume"}"#).await;
    while next_command(&studio).await != Some(ClientMessage::Resume) {}
}

/// The heartbeat of one who drives is that it goes on saying so.
#[tokio::test]
async fn a_page_that_drives_and_falls_silent_or_leaves_brings_the_robot_to_rest() {
    let dir = tempfile::tempdir().unwrap();
    let studio = start(dir.path(), false);
    let mut other = open(&studio, Role::View).await;
    let mut driver = open(&studio, Role::Execute).await;
    let ahead = r#"{"type":"drive","forward":0.5,"left":0,"turn":0}"#;
    for (leaves, wanted) in [(false, "has fallen silent"), (true, "is gone")] {
        driver.send(ahead).await;
        let moving = next_command(&studio).await;
        assert!(matches!(moving, Some(ClientMessage::Drive(drive)) if drive.forward == 0.5));
        if leaves {
            driver.socket.close(None).await.unwrap();
        }
        let rest = next_command(&studio).await;
        assert_eq!(rest, Some(ClientMessage::Drive(Default::default())));
        let said = warning(&mut other).await;
        assert!(
            said.contains(wanted) && said.contains("comes to rest"),
            "{said}"
        );
    }
    studio.publish(event("last"));
    other.until_event("last").await;
}
