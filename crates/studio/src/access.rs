//! Who gets in, and as what: tokens, the sessions they are exchanged for, and the names this server answers to.

use std::collections::VecDeque;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use axum::http::{HeaderMap, HeaderValue, Method, header};
use factotum_protocol::Role;

use crate::StudioError;
use crate::attempts::Attempts;

/// Random bytes in a token or a cookie: 128 bits cannot be guessed.
const SECRET_BYTES: usize = 16;
/// Shortest token a caller may choose, in characters; 22 of 62 kinds carry 128 bits.
const TOKEN_CHARS_MIN: usize = 22;
/// Sessions that are remembered. The browser that was let in first is forgotten for another.
const SESSIONS_MAX: usize = 256;
/// Digits of a session's name: enough to tell browsers apart, and no secret.
const NAME_DIGITS: usize = 6;

/// The secrets and names of one running server.
#[derive(Debug)]
pub(crate) struct Access {
    /// `http://` or `https://`.
    scheme: &'static str,
    /// Hosts with their port, the one to print first.
    hosts: Vec<String>,
    cookie_name: String,
    secrets: Mutex<Secrets>,
    attempts: Mutex<Attempts>,
}

#[derive(Debug)]
struct Secrets {
    tokens: Vec<Token>,
    /// Links that nobody has asked for yet.
    new_links: Vec<Link>,
    sessions: VecDeque<Session>,
}

/// What lets a browser in.
#[derive(Debug)]
struct Token {
    secret: Secret,
    role: Role,
    /// Whether it lets one browser in and no more.
    is_once: bool,
}

/// A browser that was let in.
#[derive(Debug)]
struct Session {
    cookie: Secret,
    visitor: Visitor,
}

/// Who stands behind a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Visitor {
    /// Name of the browser's session.
    pub(crate) name: String,
    pub(crate) role: Role,
}

/// An address that lets a browser in.
#[derive(Clone, PartialEq, Eq)]
pub struct Link {
    /// What the browser may do.
    pub role: Role,
    /// The address, with a token: show it to the person at the terminal, and to nobody else.
    pub url: String,
}

impl std::fmt::Debug for Link {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "Link({}, ..)", self.role.name())
    }
}

/// Why a request is turned away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// It names another host, as after DNS rebinding.
    Host,
    /// It comes from the page of another site, or from no page.
    Origin,
    /// It carries no valid cookie.
    Cookie,
    /// It carries a token that is wrong or used up.
    Token,
    /// Too many wrong tokens came from there.
    TooManyAttempts,
}

/// A secret, which does not show in logs and compares in constant time.
struct Secret(String);

impl std::fmt::Debug for Secret {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("Secret(..)")
    }
}

impl Secret {
    fn random() -> Result<Self, StudioError> {
        random_hex().map(Self)
    }

    /// Looks at every character whatever the first ones are, so that time tells nothing.
    fn matches(&self, candidate: &str) -> bool {
        let (ours, theirs) = (self.0.as_bytes(), candidate.as_bytes());
        let differing = ours.iter().zip(theirs).fold(0, |all, (a, b)| all | (a ^ b));
        ours.len() == theirs.len() && differing == 0
    }
}

/// 128 random bits in hexadecimal digits.
pub(crate) fn random_hex() -> Result<String, StudioError> {
    let mut bytes = [0_u8; SECRET_BYTES];
    getrandom::fill(&mut bytes).map_err(|source| StudioError::Entropy { source })?;
    Ok(hex(&bytes))
}

pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Access {
    /// For a server on loopback: a token of the caller's choice or a random one lets any number of browsers in, to do
    /// everything.
    pub(crate) fn on_loopback(
        address: SocketAddr,
        token: Option<String>,
    ) -> Result<Self, StudioError> {
        let secret = match token {
            None => Secret::random()?,
            Some(token) => checked_token(token)?,
        };
        let token = Token {
            secret,
            role: Role::Execute,
            is_once: false,
        };
        let names = [address.ip().to_string(), "localhost".to_owned()];
        Ok(Self::new(
            "http://",
            &names,
            address.port(),
            format!("factotum_{}", address.port()),
            vec![token],
        ))
    }

    /// For a server that is encrypted, by these names: for each role a token that lets one browser in, and makes place
    /// for another.
    pub(crate) fn on_lan(names: &[String], port: u16, roles: &[Role]) -> Result<Self, StudioError> {
        let once = |role: &Role| {
            Ok(Token {
                secret: Secret::random()?,
                role: *role,
                is_once: true,
            })
        };
        let tokens = roles.iter().map(once).collect::<Result<_, StudioError>>()?;
        // By its name the browser takes it only over TLS, and from this host alone (RFC 6265bis, 4.1.3).
        let cookie_name = format!("__Host-factotum_{port}");
        Ok(Self::new("https://", names, port, cookie_name, tokens))
    }

    /// Cookies know no ports: two studios on one machine must not share a name.
    fn new(
        scheme: &'static str,
        names: &[String],
        port: u16,
        cookie_name: String,
        tokens: Vec<Token>,
    ) -> Self {
        let access = Self {
            scheme,
            hosts: names.iter().map(|name| host(name, port)).collect(),
            cookie_name,
            secrets: Mutex::new(Secrets {
                tokens,
                new_links: Vec::new(),
                sessions: VecDeque::new(),
            }),
            attempts: Mutex::default(),
        };
        let links = access.links();
        access.lock().new_links = links;
        access
    }

    /// What lets browsers in now.
    pub(crate) fn links(&self) -> Vec<Link> {
        let secrets = self.lock();
        secrets
            .tokens
            .iter()
            .map(|token| self.link(token))
            .collect()
    }

    /// The links that were made since this was last asked.
    pub(crate) fn take_new_links(&self) -> Vec<Link> {
        std::mem::take(&mut self.lock().new_links)
    }

    fn link(&self, token: &Token) -> Link {
        let host = self.hosts.first().map_or("", String::as_str);
        Link {
            role: token.role,
            url: format!("{}{host}/?token={}", self.scheme, token.secret.0),
        }
    }

    /// Lets a browser in that shows a token: the session and its `Set-Cookie`. A token for one browser is used up then,
    /// and another takes its place.
    pub(crate) fn exchange(
        &self,
        candidate: &str,
        peer: IpAddr,
        now: Instant,
    ) -> Result<(Visitor, HeaderValue), Refusal> {
        let mut attempts = self.attempts.lock().unwrap_or_else(PoisonError::into_inner);
        if !attempts.may_try(peer, now) {
            return Err(Refusal::TooManyAttempts);
        }
        let mut secrets = self.lock();
        // All are compared, whichever it is.
        let matching = secrets
            .tokens
            .iter()
            .enumerate()
            .fold(None, |found, (index, token)| {
                if token.secret.matches(candidate) {
                    Some(index)
                } else {
                    found
                }
            });
        let Some(token) = matching.and_then(|index| secrets.tokens.get_mut(index)) else {
            attempts.fail(peer, now);
            return Err(Refusal::Token);
        };
        // Without random numbers nobody comes in.
        let fresh = || random_hex().map_err(|_no_entropy| Refusal::Token);
        let (cookie, mut name, next) = (fresh()?, fresh()?, fresh()?);
        let role = token.role;
        if token.is_once {
            token.secret = Secret(next);
            let link = self.link(token);
            secrets.new_links.push(link);
        }
        name.truncate(NAME_DIGITS);
        let visitor = Visitor { name, role };
        let header = self.set_cookie(&cookie).ok_or(Refusal::Cookie)?;
        if secrets.sessions.len() >= SESSIONS_MAX {
            secrets.sessions.pop_front();
        }
        secrets.sessions.push_back(Session {
            cookie: Secret(cookie),
            visitor: visitor.clone(),
        });
        Ok((visitor, header))
    }

    fn set_cookie(&self, cookie: &str) -> Option<HeaderValue> {
        let secure = if self.scheme == "https://" {
            "; Secure"
        } else {
            ""
        };
        let cookie = format!(
            "{}={cookie}; HttpOnly; SameSite=Strict; Path=/{secure}",
            self.cookie_name
        );
        HeaderValue::from_str(&cookie).ok()
    }

    /// Whether the request names this server.
    pub(crate) fn check_host(&self, headers: &HeaderMap) -> Result<(), Refusal> {
        match text(headers, header::HOST) {
            Some(host) if self.is_ours(host) => Ok(()),
            _ => Err(Refusal::Host),
        }
    }

    /// Whether the request comes from a page of this server, by the name that it also calls. A browser may leave the
    /// origin out only where it looks at something; opening a socket is more than that.
    pub(crate) fn check_origin(&self, method: &Method, headers: &HeaderMap) -> Result<(), Refusal> {
        let looks =
            matches!(*method, Method::GET | Method::HEAD) && !headers.contains_key(header::UPGRADE);
        if looks && !headers.contains_key(header::ORIGIN) {
            return Ok(());
        }
        let origin =
            text(headers, header::ORIGIN).and_then(|origin| origin.strip_prefix(self.scheme));
        match origin {
            Some(host) if self.is_ours(host) && text(headers, header::HOST) == Some(host) => Ok(()),
            _ => Err(Refusal::Origin),
        }
    }

    /// Whose cookie the request carries.
    pub(crate) fn visitor(&self, headers: &HeaderMap) -> Result<Visitor, Refusal> {
        let secrets = self.lock();
        let cookies = headers.get_all(header::COOKIE);
        cookies
            .iter()
            .filter_map(|value| value.to_str().ok())
            .flat_map(|value| value.split(';'))
            .filter_map(|pair| pair.trim().split_once('='))
            .filter(|(name, _)| *name == self.cookie_name)
            .find_map(|(_, value)| {
                let known = |session: &&Session| session.cookie.matches(value);
                secrets.sessions.iter().find(known)
            })
            .map(|session| session.visitor.clone())
            .ok_or(Refusal::Cookie)
    }

    fn is_ours(&self, host: &str) -> bool {
        self.hosts
            .iter()
            .any(|ours| ours.eq_ignore_ascii_case(host))
    }

    /// Nothing that holds this lock can panic half way, so a poisoned one is as good as new.
    fn lock(&self) -> MutexGuard<'_, Secrets> {
        self.secrets.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A name with its port, as a browser writes it.
fn host(name: &str, port: u16) -> String {
    match name.parse() {
        Ok(IpAddr::V6(ip)) => format!("[{ip}]:{port}"),
        _ => format!("{name}:{port}"),
    }
}

fn checked_token(token: String) -> Result<Secret, StudioError> {
    let alphanumeric = token.chars().all(|char| char.is_ascii_alphanumeric());
    if alphanumeric && token.len() >= TOKEN_CHARS_MIN {
        return Ok(Secret(token));
    }
    Err(StudioError::WeakToken {
        found: token.chars().filter(char::is_ascii_alphanumeric).count(),
        wanted: TOKEN_CHARS_MIN,
    })
}

/// The only value of a header; two values are as bad as none.
fn text(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    match (values.next(), values.next()) {
        (Some(value), None) => value.to_str().ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn access() -> Access {
        Access::on_loopback(SocketAddr::from(([127, 0, 0, 1], 8080)), None).unwrap()
    }

    fn on_lan(roles: &[Role]) -> Access {
        let names = ["192.168.1.7", "::1", "robot.local"].map(str::to_owned);
        Access::on_lan(&names, 8443, roles).unwrap()
    }

    const PEER: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(192, 168, 1, 9));

    fn token_of(link: &Link) -> String {
        link.url.split_once("token=").unwrap().1.to_owned()
    }

    /// The cookie that a token is exchanged for, as the browser sends it back.
    fn let_in(access: &Access) -> String {
        let token = token_of(&access.links()[0]);
        let (_, cookie) = access.exchange(&token, PEER, Instant::now()).unwrap();
        let cookie = cookie.to_str().unwrap();
        cookie.split(';').next().unwrap().to_owned()
    }

    fn headers(pairs: &[(&str, &str)]) -> HeaderMap {
        let mut map = HeaderMap::new();
        for (name, value) in pairs {
            map.append(
                header::HeaderName::from_bytes(name.as_bytes()).unwrap(),
                HeaderValue::from_str(value).unwrap(),
            );
        }
        map
    }

    #[test]
    fn hosts_other_than_ours_are_refused() {
        let access = access();
        for host in ["127.0.0.1:8080", "localhost:8080", "LOCALHOST:8080"] {
            assert_eq!(
                access.check_host(&headers(&[("host", host)])),
                Ok(()),
                "{host}"
            );
        }
        for host in [
            "127.0.0.1",
            "127.0.0.1:8081",
            "evil.example:8080",
            "localhost:8080.evil.example",
            "127.0.0.1:8080@evil.example",
            "",
        ] {
            let refused = access.check_host(&headers(&[("host", host)]));
            assert_eq!(refused, Err(Refusal::Host), "{host}");
        }
        let twice = headers(&[("host", "localhost:8080"), ("host", "localhost:8080")]);
        assert_eq!(access.check_host(&twice), Err(Refusal::Host));
        assert_eq!(access.check_host(&HeaderMap::new()), Err(Refusal::Host));
    }

    #[test]
    fn origins_other_than_the_called_host_are_refused() {
        let access = access();
        let check = |origin: &str| {
            let headers = headers(&[("host", "localhost:8080"), ("origin", origin)]);
            access.check_origin(&Method::GET, &headers)
        };
        assert_eq!(check("http://localhost:8080"), Ok(()));
        for origin in [
            "http://127.0.0.1:8080",
            "https://localhost:8080",
            "http://localhost",
            "http://localhost:8080/",
            "http://evil.example",
            "null",
        ] {
            assert_eq!(check(origin), Err(Refusal::Origin), "{origin}");
        }
    }

    #[test]
    fn only_who_looks_may_leave_the_origin_out() {
        let access = access();
        let none = headers(&[("host", "localhost:8080")]);
        let socket = headers(&[("host", "localhost:8080"), ("upgrade", "websocket")]);
        assert_eq!(access.check_origin(&Method::GET, &none), Ok(()));
        for (method, headers) in [
            (Method::GET, &socket),
            (Method::POST, &none),
            (Method::PUT, &none),
        ] {
            let refused = access.check_origin(&method, headers);
            assert_eq!(refused, Err(Refusal::Origin), "{method}");
        }
    }

    #[test]
    fn an_encrypted_server_has_its_own_names_and_no_plain_origin() {
        let access = on_lan(&[Role::View]);
        for host in ["192.168.1.7:8443", "[::1]:8443", "Robot.local:8443"] {
            assert_eq!(
                access.check_host(&headers(&[("host", host)])),
                Ok(()),
                "{host}"
            );
        }
        let from = |origin: &str| {
            let headers = headers(&[("host", "robot.local:8443"), ("origin", origin)]);
            access.check_origin(&Method::GET, &headers)
        };
        assert_eq!(from("https://robot.local:8443"), Ok(()));
        assert_eq!(from("http://robot.local:8443"), Err(Refusal::Origin));
        assert_eq!(from("https://192.168.1.7:8443"), Err(Refusal::Origin));
        assert_eq!(
            access.check_host(&headers(&[("host", "localhost:8443")])),
            Err(Refusal::Host)
        );
    }

    #[test]
    fn only_the_whole_cookie_of_this_server_counts() {
        let access = access();
        let cookie = let_in(&access);
        let (_, secret) = cookie.split_once('=').unwrap();
        let check = |cookie: &str| access.visitor(&headers(&[("cookie", cookie)]));
        let visitor = check(&cookie).unwrap();
        assert_eq!(visitor.role, Role::Execute);
        assert_eq!(check(&format!("a=b; {cookie}")), Ok(visitor));
        for cookie in [
            format!("factotum_8081={secret}"),
            format!("factotum_8080={secret}0"),
            format!("factotum_8080={}", &secret[1..]),
            "factotum_8080=".to_owned(),
            secret.to_owned(),
        ] {
            assert_eq!(check(&cookie), Err(Refusal::Cookie), "{cookie}");
        }
    }

    #[test]
    fn tokens_are_random_and_chosen_ones_are_checked() {
        assert_ne!(access().links(), access().links());
        let address = SocketAddr::from(([127, 0, 0, 1], 8080));
        let chosen = "abcdefghijklmnopqrstuv";
        let access = Access::on_loopback(address, Some(chosen.to_owned())).unwrap();
        let now = Instant::now();
        // On loopback it lets in as often as it is shown.
        for _ in 0..3 {
            assert!(access.exchange(chosen, PEER, now).is_ok());
        }
        let wrong = access.exchange("abcdefghijklmnopqrstuw", PEER, now);
        assert_eq!(wrong, Err(Refusal::Token));
        for weak in ["short", "abcdefghijklmnopqrst&v=", ""] {
            let refused = Access::on_loopback(address, Some(weak.to_owned()));
            assert!(
                matches!(refused, Err(StudioError::WeakToken { .. })),
                "{weak}"
            );
        }
    }

    #[test]
    fn a_pairing_token_lets_one_browser_in_and_makes_place_for_another() {
        let access = on_lan(&Role::ALL);
        let links = access.take_new_links();
        assert_eq!(links, access.links());
        assert_eq!(
            links.iter().map(|link| link.role).collect::<Vec<_>>(),
            Role::ALL
        );
        assert!(links[0].url.starts_with("https://192.168.1.7:8443/?token="));
        let now = Instant::now();
        let token = token_of(&links[1]);
        let (visitor, cookie) = access.exchange(&token, PEER, now).unwrap();
        assert_eq!(visitor.role, Role::Teach);
        let cookie = cookie.to_str().unwrap();
        assert!(cookie.starts_with("__Host-factotum_8443="), "{cookie}");
        for attribute in ["; HttpOnly", "; Secure", "; SameSite=Strict", "; Path=/"] {
            assert!(cookie.contains(attribute), "{cookie}");
        }
        assert_eq!(access.exchange(&token, PEER, now), Err(Refusal::Token));
        let new = access.take_new_links();
        assert_eq!((new.len(), new[0].role), (1, Role::Teach));
        assert_ne!(token_of(&new[0]), token);
        assert!(access.exchange(&token_of(&new[0]), PEER, now).is_ok());
    }

    #[test]
    fn after_many_wrong_tokens_the_right_one_has_to_wait() {
        let access = on_lan(&[Role::View]);
        let now = Instant::now();
        let refusals: Vec<Refusal> = std::iter::repeat_with(|| access.exchange("0", PEER, now))
            .take(50)
            .filter_map(Result::err)
            .collect();
        assert_eq!(refusals.len(), 50);
        assert_eq!(refusals[0], Refusal::Token);
        assert_eq!(refusals[49], Refusal::TooManyAttempts);
        let token = token_of(&access.links()[0]);
        let refused = access.exchange(&token, PEER, now);
        assert_eq!(refused, Err(Refusal::TooManyAttempts));
        let elsewhere = IpAddr::from([192, 168, 1, 10]);
        assert!(access.exchange(&token, elsewhere, now).is_ok());
        let token = token_of(&access.links()[0]);
        let later = now + std::time::Duration::from_secs(60);
        assert!(access.exchange(&token, PEER, later).is_ok());
    }

    #[test]
    fn sessions_are_bounded() {
        let access = access();
        let first = let_in(&access);
        let cookies: Vec<String> = (0..SESSIONS_MAX).map(|_| let_in(&access)).collect();
        let known = |cookie: &str| access.visitor(&headers(&[("cookie", cookie)])).is_ok();
        assert!(!known(&first));
        assert!(cookies.iter().all(|cookie| known(cookie)));
    }

    #[test]
    fn secrets_do_not_show() {
        let access = on_lan(&Role::ALL);
        let_in(&access);
        let shown = format!("{access:?} {:?}", access.links());
        for link in access.links() {
            assert!(!shown.contains(&token_of(&link)), "{shown}");
        }
        assert_eq!(shown.matches("Secret(..)").count(), 4);
    }
}
