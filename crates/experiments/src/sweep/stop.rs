//! A wish to end a sweep.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Raised once, no new run begins and those under way end; raised again, those under way are ended, and no result of
/// theirs is kept, so that they run anew another time.
#[derive(Debug, Default)]
pub struct StopWish(AtomicUsize);

impl StopWish {
    /// Raises it, from any thread.
    pub fn raise(&self) {
        self.0.fetch_add(1, Ordering::SeqCst);
    }

    /// Whether it was raised.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::SeqCst) > 0
    }

    /// Whether it was raised more than once.
    #[must_use]
    pub fn is_urgent(&self) -> bool {
        self.0.load(Ordering::SeqCst) > 1
    }
}
