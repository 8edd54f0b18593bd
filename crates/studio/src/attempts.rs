//! How many wrong tokens may come from one place.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::time::{Duration, Instant};

/// Wrong tokens that may come from one place at once.
const FAILURES_MAX: u32 = 10;
/// One of them is forgotten so often.
const FORGET: Duration = Duration::from_secs(6);
/// Places that are remembered; the one that failed longest ago is forgotten for another.
const PLACES_MAX: usize = 1024;

/// The failures that count now, by the place they came from.
#[derive(Debug, Default)]
pub(crate) struct Attempts {
    places: BTreeMap<IpAddr, Failures>,
}

#[derive(Clone, Copy, Debug)]
struct Failures {
    n: u32,
    /// When the last of them came.
    last: Instant,
}

impl Failures {
    fn at(self, now: Instant) -> u32 {
        let forgotten = now.saturating_duration_since(self.last).as_secs() / FORGET.as_secs();
        self.n
            .saturating_sub(u32::try_from(forgotten).unwrap_or(u32::MAX))
    }
}

impl Attempts {
    /// Whether a token that comes from there is looked at.
    pub(crate) fn may_try(&self, peer: IpAddr, now: Instant) -> bool {
        self.places
            .get(&place_of(peer))
            .is_none_or(|failures| failures.at(now) < FAILURES_MAX)
    }

    /// Notes a wrong one.
    pub(crate) fn fail(&mut self, peer: IpAddr, now: Instant) {
        let place = place_of(peer);
        let before = self
            .places
            .get(&place)
            .map_or(0, |failures| failures.at(now));
        if self.places.len() >= PLACES_MAX && !self.places.contains_key(&place) {
            let oldest = self.places.iter().min_by_key(|(_, failures)| failures.last);
            if let Some(oldest) = oldest.map(|(place, _)| *place) {
                self.places.remove(&oldest);
            }
        }
        let failures = Failures {
            n: before + 1,
            last: now,
        };
        self.places.insert(place, failures);
    }
}

/// A machine has a whole network of IPv6 addresses (RFC 4291, 2.5.4): its first 64 bits count.
fn place_of(peer: IpAddr) -> IpAddr {
    match peer.to_canonical() {
        IpAddr::V6(ip) => IpAddr::from((u128::from(ip) >> 64 << 64).to_be_bytes()),
        v4 @ IpAddr::V4(_) => v4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_are_forgotten_one_by_one() {
        let (mut attempts, now) = (Attempts::default(), Instant::now());
        let peer = IpAddr::from([10, 0, 0, 1]);
        for _ in 0..FAILURES_MAX {
            assert!(attempts.may_try(peer, now));
            attempts.fail(peer, now);
        }
        assert!(!attempts.may_try(peer, now));
        assert!(!attempts.may_try(peer, now + FORGET / 2));
        assert!(attempts.may_try(peer, now + FORGET));
        attempts.fail(peer, now + FORGET);
        assert!(!attempts.may_try(peer, now + FORGET));
    }

    #[test]
    fn a_machine_cannot_change_its_place_by_another_address() {
        let (mut attempts, now) = (Attempts::default(), Instant::now());
        let address = |text: &str| text.parse::<IpAddr>().unwrap();
        for number in 0..FAILURES_MAX {
            attempts.fail(address(&format!("fd00::{number:x}")), now);
        }
        assert!(!attempts.may_try(address("fd00::ffff"), now));
        assert!(attempts.may_try(address("fd00:0:0:1::"), now));
        for _ in 0..FAILURES_MAX {
            attempts.fail(address("10.0.0.1"), now);
        }
        assert!(!attempts.may_try(address("::ffff:10.0.0.1"), now));
    }

    #[test]
    fn memory_is_bounded() {
        let (mut attempts, now) = (Attempts::default(), Instant::now());
        for number in 0..4 * PLACES_MAX as u32 {
            attempts.fail(IpAddr::from(number.to_be_bytes()), now);
        }
        assert_eq!(attempts.places.len(), PLACES_MAX);
    }
}
