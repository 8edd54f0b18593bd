//! The home folder (in the making).
