//! Who gets in: the token, the cookie it is exchanged for, and the names this server answers to.

use std::net::{IpAddr, SocketAddr};

use axum::http::{HeaderMap, HeaderValue, header};

use crate::StudioError;

/// Random bytes in a token or a cookie: 128 bits cannot be guessed.
const SECRET_BYTES: usize = 16;
/// Shortest token a caller may choose, in characters; 22 of 62 kinds carry 128 bits.
const TOKEN_CHARS_MIN: usize = 22;

/// The secrets and names of one running server.
#[derive(Debug)]
pub(crate) struct Access {
    token: Secret,
    cookie: Secret,
    cookie_name: String,
    hosts: Vec<String>,
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
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

impl Access {
    /// For a server at `address`, with a token of the caller's choice or a random one.
    pub(crate) fn new(address: SocketAddr, token: Option<String>) -> Result<Self, StudioError> {
        let token = match token {
            None => Secret::random()?,
            Some(token) => checked_token(token)?,
        };
        let port = address.port();
        let ip = match address.ip() {
            IpAddr::V4(ip) => ip.to_string(),
            IpAddr::V6(ip) => format!("[{ip}]"),
        };
        Ok(Self {
            token,
            cookie: Secret::random()?,
            // Cookies know no ports: two studios on one machine must not share a name.
            cookie_name: format!("factotum_{port}"),
            hosts: vec![format!("{ip}:{port}"), format!("localhost:{port}")],
        })
    }

    /// The address to open, with the token.
    pub(crate) fn url(&self) -> String {
        format!("http://{}/?token={}", self.hosts[0], self.token.0)
    }

    /// Whether this is the token.
    pub(crate) fn token_matches(&self, candidate: &str) -> bool {
        self.token.matches(candidate)
    }

    /// The `Set-Cookie` that a valid token is exchanged for.
    pub(crate) fn set_cookie(&self) -> Option<HeaderValue> {
        let cookie = format!(
            "{}={}; HttpOnly; SameSite=Strict; Path=/",
            self.cookie_name, self.cookie.0
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

    /// Whether the request comes from a page of this server, by the name that it also calls.
    pub(crate) fn check_origin(&self, headers: &HeaderMap) -> Result<(), Refusal> {
        let origin =
            text(headers, header::ORIGIN).and_then(|origin| origin.strip_prefix("http://"));
        match origin {
            Some(host) if self.is_ours(host) && text(headers, header::HOST) == Some(host) => Ok(()),
            _ => Err(Refusal::Origin),
        }
    }

    /// Whether the request carries the cookie.
    pub(crate) fn check_cookie(&self, headers: &HeaderMap) -> Result<(), Refusal> {
        let cookies = headers.get_all(header::COOKIE);
        let valid = cookies
            .iter()
            .filter_map(|value| value.to_str().ok())
            .flat_map(|value| value.split(';'))
            .filter_map(|pair| pair.trim().split_once('='))
            .any(|(name, value)| name == self.cookie_name && self.cookie.matches(value));
        if valid { Ok(()) } else { Err(Refusal::Cookie) }
    }

    fn is_ours(&self, host: &str) -> bool {
        self.hosts
            .iter()
            .any(|ours| ours.eq_ignore_ascii_case(host))
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
        Access::new(SocketAddr::from(([127, 0, 0, 1], 8080)), None).unwrap()
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
            access.check_origin(&headers(&[("host", "localhost:8080"), ("origin", origin)]))
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
        let none = headers(&[("host", "localhost:8080")]);
        assert_eq!(access.check_origin(&none), Err(Refusal::Origin));
    }

    #[test]
    fn only_the_whole_cookie_of_this_server_counts() {
        let access = access();
        let secret = access.cookie.0.clone();
        let check = |cookie: String| access.check_cookie(&headers(&[("cookie", &cookie)]));
        assert_eq!(check(format!("factotum_8080={secret}")), Ok(()));
        assert_eq!(check(format!("a=b; factotum_8080={secret}")), Ok(()));
        for cookie in [
            format!("factotum_8081={secret}"),
            format!("factotum_8080={secret}0"),
            format!("factotum_8080={}", &secret[1..]),
            "factotum_8080=".to_owned(),
            secret,
        ] {
            assert_eq!(check(cookie.clone()), Err(Refusal::Cookie), "{cookie}");
        }
    }

    #[test]
    fn tokens_are_random_and_chosen_ones_are_checked() {
        assert_ne!(access().url(), access().url());
        let address = SocketAddr::from(([127, 0, 0, 1], 8080));
        let chosen = "abcdefghijklmnopqrstuv";
        let access = Access::new(address, Some(chosen.to_owned())).unwrap();
        assert!(access.token_matches(chosen));
        assert!(!access.token_matches("abcdefghijklmnopqrstuw"));
        for weak in ["short", "abcdefghijklmnopqrst&v=", ""] {
            let refused = Access::new(address, Some(weak.to_owned()));
            assert!(
                matches!(refused, Err(StudioError::WeakToken { .. })),
                "{weak}"
            );
        }
    }

    #[test]
    fn secrets_do_not_show() {
        let shown = format!("{:?}", access());
        assert!(!shown.contains(&access().token.0));
        assert_eq!(shown.matches("Secret(..)").count(), 2);
    }
}
