//! The names by which other machines find this one.

use std::net::{IpAddr, UdpSocket};

/// Addresses and names of this machine in its networks, the address that other machines reach it by first, loopback last.
/// What a certificate cannot carry, or what holds for one link alone, is left out.
#[must_use]
pub fn lan_names() -> Vec<String> {
    let interfaces = if_addrs::get_if_addrs().unwrap_or_else(|error| {
        tracing::warn!(%error, "the addresses of this machine are not known");
        Vec::new()
    });
    let addresses = interfaces.iter().map(if_addrs::Interface::ip);
    let host_name = rustix::system::uname();
    names_of(
        outward_address(),
        addresses,
        host_name.nodename().to_str().unwrap_or_default(),
    )
}

fn names_of(
    outward: Option<IpAddr>,
    addresses: impl Iterator<Item = IpAddr>,
    host_name: &str,
) -> Vec<String> {
    let is_lan = |ip: &IpAddr| match ip {
        IpAddr::V4(ip) => !ip.is_loopback() && !ip.is_link_local() && !ip.is_unspecified(),
        IpAddr::V6(ip) => !ip.is_loopback() && !ip.is_unicast_link_local() && !ip.is_unspecified(),
    };
    let mut inward: Vec<IpAddr> = addresses.filter(is_lan).collect();
    inward.sort_unstable();
    let addresses = outward.into_iter().filter(is_lan).chain(inward);
    let mut names: Vec<String> = addresses.map(|ip| ip.to_string()).collect();
    let host_name = host_name.to_ascii_lowercase();
    if is_host_name(&host_name) {
        if !host_name.contains('.') {
            names.push(format!("{host_name}.local"));
        }
        names.push(host_name);
    }
    names.extend(["localhost", "127.0.0.1", "::1"].map(str::to_owned));
    let mut seen = std::collections::BTreeSet::new();
    names.retain(|name| seen.insert(name.clone()));
    names
}

/// Letters, digits and hyphens between dots (RFC 952, RFC 1123).
fn is_host_name(name: &str) -> bool {
    let is_label = |label: &str| {
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '-';
        (1..=63).contains(&label.len())
            && label.chars().all(is_part)
            && !label.starts_with('-')
            && !label.ends_with('-')
    };
    name.len() <= 253 && name.split('.').all(is_label)
}

/// The address that the way out of this network begins at. A datagram socket is only told where it would send to (an
/// address that is nobody's, RFC 5737): nothing is sent.
fn outward_address() -> Option<IpAddr> {
    let socket = UdpSocket::bind("0.0.0.0:0").ok()?;
    socket.connect("192.0.2.1:9").ok()?;
    Some(socket.local_addr().ok()?.ip())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ips(texts: &[&str]) -> Vec<IpAddr> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn the_outward_address_comes_first_and_each_name_once() {
        let found = ips(&[
            "127.0.0.1",
            "::1",
            "172.17.0.1",
            "192.168.1.7",
            "169.254.3.4",
            "fe80::1",
        ]);
        let names = names_of(
            Some(IpAddr::from([192, 168, 1, 7])),
            found.into_iter(),
            "Robot",
        );
        let wanted = [
            "192.168.1.7",
            "172.17.0.1",
            "robot.local",
            "robot",
            "localhost",
            "127.0.0.1",
            "::1",
        ];
        assert_eq!(names, wanted);
    }

    #[test]
    fn a_machine_without_network_or_name_is_found_on_loopback() {
        for host_name in ["", "(none)", "häuschen", "-a", "a..b", "localhost"] {
            let names = names_of(None, ips(&["127.0.0.1"]).into_iter(), host_name);
            let kept = names.iter().filter(|name| !name.starts_with("localhost"));
            assert_eq!(
                kept.collect::<Vec<_>>(),
                ["127.0.0.1", "::1"],
                "{host_name}"
            );
        }
    }

    #[test]
    fn a_whole_name_gets_no_other_ending() {
        let names = names_of(None, [].into_iter(), "robot.example.org");
        assert_eq!(
            names,
            ["robot.example.org", "localhost", "127.0.0.1", "::1"]
        );
    }
}
