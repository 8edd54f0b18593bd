//! The certificate of an encrypted studio: self-signed, by the names of this machine, kept from one run to the next so that
//! a browser which was told to trust it goes on doing so.

use std::collections::BTreeSet;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rcgen::{CertificateParams, DnType, ExtendedKeyUsagePurpose, KeyPair};
use rustls::ServerConfig;
use rustls::pki_types::{CertificateDer, PrivatePkcs8KeyDer};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::StudioError;
use crate::access::hex;

/// How long a certificate holds: less than the 398 days beyond which browsers object.
const VALID: Duration = Duration::from_secs(390 * 86_400);
/// How old one may be at the start of a run.
const OLD: Duration = Duration::from_secs(360 * 86_400);
/// It holds from before it was made, for machines whose clocks are late.
const BEFORE: Duration = Duration::from_secs(86_400);

/// A certificate with its key, as it is kept: one file, so that they are never of two kinds.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Certificate {
    names: Vec<String>,
    made_unix_secs: u64,
    /// In hexadecimal digits.
    certificate_der: String,
    /// In hexadecimal digits; PKCS #8.
    key_der: String,
}

impl Certificate {
    /// The certificate in a file, or a new one where it is missing, for other names, old, not readable, or where others
    /// than its owner could read its key.
    pub(crate) fn kept(
        file: &Path,
        names: &[String],
        now_unix_secs: u64,
    ) -> Result<Self, StudioError> {
        match Self::read(file) {
            Some(kept) if kept.serves(names, now_unix_secs) => return Ok(kept),
            Some(_) => {
                tracing::info!("the certificate is old or has other names; making a new one")
            }
            None => tracing::info!("making a certificate"),
        }
        let made = Self::make(names, now_unix_secs)
            .map_err(|source| StudioError::Certificate { source })?;
        made.write(file)
            .map_err(|source| StudioError::CertificateFile {
                path: file.to_owned(),
                source,
            })?;
        Ok(made)
    }

    fn serves(&self, names: &[String], now_unix_secs: u64) -> bool {
        // One from the future was made by a clock that was wrong.
        let age = now_unix_secs.checked_sub(self.made_unix_secs);
        // Which of them comes first changes with the network and means nothing here.
        let set = |names: &[String]| names.iter().cloned().collect::<BTreeSet<String>>();
        set(&self.names) == set(names)
            && age.is_some_and(|age| age < OLD.as_secs())
            && self.tls().is_ok()
    }

    fn read(file: &Path) -> Option<Self> {
        if !is_private(file) {
            return None;
        }
        serde_json::from_str(&std::fs::read_to_string(file).ok()?).ok()
    }

    fn make(names: &[String], now_unix_secs: u64) -> Result<Self, rcgen::Error> {
        let key = KeyPair::generate()?;
        let mut params = CertificateParams::new(names)?;
        let epoch = rcgen::date_time_ymd(1970, 1, 1);
        params.not_before = epoch + Duration::from_secs(now_unix_secs).saturating_sub(BEFORE);
        params.not_after = epoch + Duration::from_secs(now_unix_secs) + VALID;
        params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
        params
            .distinguished_name
            .push(DnType::CommonName, "Factotum");
        let certificate = params.self_signed(&key)?;
        Ok(Self {
            names: names.to_vec(),
            made_unix_secs: now_unix_secs,
            certificate_der: hex(certificate.der()),
            key_der: hex(&key.serialize_der()),
        })
    }

    /// Puts it where the old one was, readable for its owner alone from the first moment.
    fn write(&self, file: &Path) -> std::io::Result<()> {
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder)?;
        }
        let part = PathBuf::from(format!("{}.part", file.display()));
        match std::fs::remove_file(&part) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let mut options = std::fs::OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let mut written = options.open(&part)?;
        written.write_all(serde_json::to_string_pretty(self)?.as_bytes())?;
        written.sync_all()?;
        std::fs::rename(&part, file)
    }

    /// What a server needs of it.
    pub(crate) fn tls(&self) -> Result<Arc<ServerConfig>, rustls::Error> {
        let damaged = || rustls::Error::General("the certificate's file is damaged".to_owned());
        let certificate = CertificateDer::from(unhex(&self.certificate_der).ok_or_else(damaged)?);
        let key = PrivatePkcs8KeyDer::from(unhex(&self.key_der).ok_or_else(damaged)?);
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let mut config = ServerConfig::builder_with_provider(provider)
            .with_safe_default_protocol_versions()?
            .with_no_client_auth()
            .with_single_cert(vec![certificate], key.into())?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Arc::new(config))
    }

    /// SHA-256 of the certificate, as browsers show it.
    pub(crate) fn fingerprint(&self) -> String {
        let digest = Sha256::digest(unhex(&self.certificate_der).unwrap_or_default());
        let pairs: Vec<String> = digest.iter().map(|byte| format!("{byte:02X}")).collect();
        pairs.join(":")
    }
}

impl std::fmt::Debug for Certificate {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "Certificate({:?}, ..)", self.names)
    }
}

fn unhex(text: &str) -> Option<Vec<u8>> {
    let pairs = text.as_bytes().chunks(2).map(|pair| {
        let pair = std::str::from_utf8(pair).ok()?;
        (pair.len() == 2).then(|| u8::from_str_radix(pair, 16).ok())?
    });
    pairs.collect()
}

/// Whether nobody but its owner may read a file that is there.
fn is_private(file: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        std::fs::metadata(file).is_ok_and(|found| found.permissions().mode() & 0o077 == 0)
    }
    #[cfg(not(unix))]
    file.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: u64 = 1_800_000_000;

    fn names(last: &str) -> Vec<String> {
        ["192.168.1.7", "::1", "localhost", last]
            .map(str::to_owned)
            .to_vec()
    }

    #[test]
    fn it_is_kept_and_renewed_when_names_change_or_it_is_old() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("deep/certificate.json");
        let at = |names: &[String], now: u64| {
            Certificate::kept(&file, names, now).unwrap().fingerprint()
        };
        let first = at(&names("a.local"), NOW);
        assert_eq!(first.len(), 32 * 3 - 1);
        assert_eq!(at(&names("a.local"), NOW + OLD.as_secs() - 1), first);
        let mut turned = names("a.local");
        turned.reverse();
        assert_eq!(at(&turned, NOW), first);
        let renamed = at(&names("b.local"), NOW);
        assert_ne!(renamed, first);
        let renewed = at(&names("b.local"), NOW + OLD.as_secs());
        assert_ne!(renewed, renamed);
        assert_ne!(at(&names("b.local"), NOW), renewed, "made in the future");
        assert_eq!(
            std::fs::read_dir(file.parent().unwrap()).unwrap().count(),
            1
        );
    }

    #[test]
    fn what_is_damaged_is_made_anew() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("certificate.json");
        let first = Certificate::kept(&file, &names("a"), NOW).unwrap();
        let whole = std::fs::read_to_string(&file).unwrap();
        for damaged in [
            String::new(),
            whole[..whole.len() / 2].to_owned(),
            whole.replace(&first.key_der, "00"),
            whole.replace(&first.key_der, "ä"),
            whole.replace(&first.certificate_der, "zz"),
        ] {
            std::fs::write(&file, damaged).unwrap();
            let again = Certificate::kept(&file, &names("a"), NOW).unwrap();
            assert!(again.tls().is_ok());
            assert_ne!(again.fingerprint(), first.fingerprint());
        }
    }

    #[cfg(unix)]
    #[test]
    fn its_key_is_for_its_owner_alone() {
        use std::os::unix::fs::PermissionsExt as _;
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("certificate.json");
        let first = Certificate::kept(&file, &names("a"), NOW).unwrap();
        let mode = || std::fs::metadata(&file).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(), 0o600);
        assert!(!format!("{first:?}").contains(&first.key_der));
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o644)).unwrap();
        let again = Certificate::kept(&file, &names("a"), NOW).unwrap();
        assert_ne!(
            again.fingerprint(),
            first.fingerprint(),
            "others may know the first"
        );
        assert_eq!(mode(), 0o600);
    }

    #[test]
    fn a_name_that_no_certificate_can_carry_is_an_error() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("certificate.json");
        let refused = Certificate::kept(&file, &["häuschen".to_owned()], NOW);
        assert!(
            matches!(refused, Err(StudioError::Certificate { .. })),
            "{refused:?}"
        );
        assert!(!file.exists());
    }
}
