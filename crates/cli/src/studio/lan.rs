//! Serving other machines: the names and the certificate of this one, and the links that let browsers in.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use clap::Args;
use factotum_protocol::Role;
use factotum_studio::{Lan, Link, StudioConfig, StudioHandle, lan_names};
use qrcode::QrCode;
use qrcode::render::unicode::Dense1x2;

use crate::console::{Console, usage};

/// Port for other machines: browsers remember by the port what they were told to trust.
const LAN_PORT: u16 = 8443;

/// Where a studio serves, and whom.
#[derive(Debug, Args)]
pub(crate) struct ServeArgs {
    /// Let other machines in too: encrypted, each browser by a link of its own, shown as a QR code.
    #[arg(long)]
    lan: bool,
    /// Address and port to serve at; port 0 takes a free one. Without --lan it must be on loopback. [default:
    /// 127.0.0.1:0, with --lan 0.0.0.0:8443]
    #[arg(long, value_name = "IP:PORT")]
    address: Option<SocketAddr>,
    /// Make a link for this role alone: view, teach or execute. May be given more than once. Without it there is one for
    /// each.
    #[arg(long = "role", value_name = "ROLE", requires = "lan", value_parser = role)]
    roles: Vec<Role>,
}

fn role(text: &str) -> Result<Role, String> {
    let found = Role::ALL.into_iter().find(|role| role.name() == text);
    found.ok_or_else(|| format!("expected one of {}", Role::ALL.map(Role::name).join(", ")))
}

impl ServeArgs {
    /// What the studio is told of it.
    pub(crate) fn config(&self) -> anyhow::Result<StudioConfig> {
        let loopback = StudioConfig::default();
        if !self.lan {
            let bind = self.address.unwrap_or(loopback.bind);
            if !bind.ip().is_loopback() {
                return Err(usage(format!(
                    "--address {bind} is not on loopback, expected 127.0.0.1 or [::1]; with --lan the studio is encrypted \
                     and serves at any address"
                )));
            }
            return Ok(StudioConfig { bind, ..loopback });
        }
        let any = SocketAddr::from((Ipv4Addr::UNSPECIFIED, LAN_PORT));
        let bind = self.address.unwrap_or(any);
        let mut roles = self.roles.clone();
        roles.sort_unstable();
        roles.dedup();
        if roles.is_empty() {
            roles = Role::ALL.to_vec();
        }
        let lan = Lan {
            names: names_at(bind, lan_names()),
            certificate: own_folder()?.join("studio-certificate.json"),
            roles,
        };
        Ok(StudioConfig {
            bind,
            lan: Some(lan),
            ..loopback
        })
    }
}

/// The names of this machine, the address that is served first.
fn names_at(bind: SocketAddr, mut names: Vec<String>) -> Vec<String> {
    if !bind.ip().is_unspecified() {
        let first = bind.ip().to_string();
        names.retain(|name| *name != first);
        names.insert(0, first);
    }
    names
}

/// The folder of what is this user's and of no home (XDG Base Directory Specification).
fn own_folder() -> anyhow::Result<PathBuf> {
    let folder = |name: &str| {
        let path = PathBuf::from(std::env::var_os(name)?);
        path.is_absolute().then_some(path)
    };
    let data = folder("XDG_DATA_HOME").or_else(|| Some(folder("HOME")?.join(".local/share")));
    let data = data.ok_or_else(|| {
        usage("--lan keeps its certificate in $XDG_DATA_HOME or $HOME/.local/share; expected one of these to be set")
    })?;
    Ok(data.join("factotum"))
}

/// Shows the links that are new: all at first, later one for each that was used up.
pub(crate) fn show_new_links(studio: &StudioHandle, console: &Console) {
    let Some(fingerprint) = studio.fingerprint() else {
        return;
    };
    let links = studio.take_new_links();
    if links.is_empty() {
        return;
    }
    for link in &links {
        console.say(text_of(link));
    }
    console.say(format_args!(
        "Each link lets one browser in; another is shown then. The browser warns of a certificate that it does not know: \
         it is this one if its SHA-256 is\n{fingerprint}"
    ));
}

/// A link as text and as a QR code, light on dark as terminals are.
fn text_of(link: &Link) -> String {
    let what = match link.role {
        Role::View => "to look, and to stop the robot",
        Role::Teach => "to teach",
        Role::Execute => "to teach and to command the robot",
    };
    let mut text = format!("{what}: {}", link.url);
    if let Ok(code) = QrCode::new(&link.url) {
        let mut picture = code.render::<Dense1x2>();
        let picture = picture
            .dark_color(Dense1x2::Light)
            .light_color(Dense1x2::Dark);
        text.push('\n');
        text.push_str(&picture.build());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_is_shown_as_text_and_as_a_code_of_it() {
        let link = Link {
            role: Role::Teach,
            url: format!("https://192.168.1.7:8443/?token={}", "a".repeat(32)),
        };
        let text = text_of(&link);
        let (first, picture) = text.split_once('\n').unwrap();
        assert_eq!(first, format!("to teach: {}", link.url));
        let widths: Vec<usize> = picture.lines().map(|line| line.chars().count()).collect();
        // Version 5 has 37 modules a side (ISO/IEC 18004), with 4 around it; two of them are one character high.
        assert_eq!(widths, vec![45; 23]);
        assert!(
            picture.lines().next().unwrap().chars().all(|c| c == '█'),
            "a light edge"
        );
    }

    #[test]
    fn the_served_address_is_printed_first() {
        let names = ["192.168.1.7", "robot", "127.0.0.1"]
            .map(str::to_owned)
            .to_vec();
        let at = |address: &str| names_at(address.parse().unwrap(), names.clone());
        assert_eq!(at("0.0.0.0:8443"), names);
        assert_eq!(at("127.0.0.1:0"), ["127.0.0.1", "192.168.1.7", "robot"]);
    }

    #[test]
    fn roles_are_named() {
        assert_eq!(role("teach"), Ok(Role::Teach));
        let refused = role("admin").unwrap_err();
        assert!(refused.contains("view, teach, execute"), "{refused}");
    }
}
