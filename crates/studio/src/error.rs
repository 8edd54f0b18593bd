//! What can go wrong when a studio starts.

use std::net::SocketAddr;
use std::path::PathBuf;

use thiserror::Error;

/// A studio that could not start.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StudioError {
    /// The address is not a loopback address.
    #[error(
        "studio address {address} is not on loopback, expected 127.0.0.1 or [::1]: \
         without --lan its traffic is not encrypted"
    )]
    NotLoopback {
        /// Address asked for.
        address: SocketAddr,
    },
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}; choose another port, or 0 for a free one")]
    Bind {
        /// Address asked for.
        address: SocketAddr,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A token that is too easy to guess or does not fit in an address.
    #[error(
        "studio token has {found} characters, expected at least {wanted} of the letters \
         a to z and A to Z and the digits"
    )]
    WeakToken {
        /// Length found.
        found: usize,
        /// Length wanted.
        wanted: usize,
    },
    /// The operating system has no random numbers.
    #[error("no random numbers for the studio's token: {source}")]
    Entropy {
        /// What the operating system said.
        source: getrandom::Error,
    },
    /// The server's thread or its runtime could not be made.
    #[error("cannot start the studio's thread: {source}")]
    Thread {
        /// What the operating system said.
        source: std::io::Error,
    },
    /// No certificate could be made for the names, or it could not be used.
    #[error("cannot make a certificate: {source}")]
    Certificate {
        /// What was wrong.
        source: rcgen::Error,
    },
    /// The certificate could not be written.
    #[error("cannot write the certificate `{path}`: {source}")]
    CertificateFile {
        /// Its file.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// TLS refuses the certificate.
    #[error("cannot serve with the certificate: {source}")]
    Tls {
        /// What was wrong.
        source: rustls::Error,
    },
}
