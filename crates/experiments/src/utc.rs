//! Calendar time in UTC, for the names and manifests of run folders.

use std::fmt;
use std::time::{SystemTime, UNIX_EPOCH};

const SECS_PER_DAY: u64 = 86_400;

/// An instant, to the second, after 1970.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UtcTime {
    unix_secs: u64,
}

impl UtcTime {
    /// The instant so many seconds after 1970-01-01 00:00 UTC.
    #[must_use]
    pub fn from_unix_secs(unix_secs: u64) -> Self {
        Self { unix_secs }
    }

    /// Seconds after 1970-01-01 00:00 UTC.
    #[must_use]
    pub fn unix_secs(self) -> u64 {
        self.unix_secs
    }

    /// `2026-11-22`.
    #[must_use]
    pub fn date(self) -> String {
        let (year, month, day) = self.calendar_date();
        format!("{year:04}-{month:02}-{day:02}")
    }

    /// Year, month from 1 and day from 1, in the Gregorian calendar.
    ///
    /// Years are counted from 1 March, so that the leap day comes last, in cycles of 400 years (146,097 days), as in
    /// H. Hinnant, "chrono-compatible low-level date algorithms", 2013.
    fn calendar_date(self) -> (u64, u64, u64) {
        // 719,468 days lie between 1 March of year 0 and 1970-01-01.
        let days = self.unix_secs / SECS_PER_DAY + 719_468;
        let (cycle, day_of_cycle) = (days / 146_097, days % 146_097);
        let leaps = day_of_cycle / 1_460 - day_of_cycle / 36_524 + day_of_cycle / 146_096;
        let year_of_cycle = (day_of_cycle - leaps) / 365;
        let day_of_year =
            day_of_cycle - (365 * year_of_cycle + year_of_cycle / 4 - year_of_cycle / 100);
        // Months from March have 31, 30, 31, 30, 31 days over and over: 153 days in five months.
        let month_from_march = (5 * day_of_year + 2) / 153;
        let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
        let month = if month_from_march < 10 {
            month_from_march + 3
        } else {
            month_from_march - 9
        };
        (
            cycle * 400 + year_of_cycle + u64::from(month <= 2),
            month,
            day,
        )
    }
}

impl From<SystemTime> for UtcTime {
    /// A time before 1970 becomes 1970-01-01.
    fn from(time: SystemTime) -> Self {
        Self {
            unix_secs: time
                .duration_since(UNIX_EPOCH)
                .map_or(0, |since| since.as_secs()),
        }
    }
}

impl fmt::Display for UtcTime {
    /// ISO 8601, `2026-11-22T08:35:12Z`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let second = self.unix_secs % SECS_PER_DAY;
        write!(
            f,
            "{}T{:02}:{:02}:{:02}Z",
            self.date(),
            second / 3_600,
            second / 60 % 60,
            second % 60
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_instants_have_their_known_dates() {
        // From `date -u -d @SECONDS` of GNU coreutils.
        for (unix_secs, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (951_868_800, "2000-03-01T00:00:00Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(UtcTime::from_unix_secs(unix_secs).to_string(), text);
        }
    }

    #[test]
    fn every_day_of_four_centuries_follows_the_one_before() {
        let days_in = |year: u64, month| match month {
            2 if year.is_multiple_of(4) && !year.is_multiple_of(100)
                || year.is_multiple_of(400) && month == 2 =>
            {
                29
            }
            2 => 28,
            4 | 6 | 9 | 11 => 30,
            _ => 31,
        };
        let (mut year, mut month, mut day) = (1970, 1, 1);
        for days in 0..146_097 {
            assert_eq!(
                UtcTime::from_unix_secs(days * SECS_PER_DAY).calendar_date(),
                (year, month, day)
            );
            (day, month) = if day == days_in(year, month) {
                (1, month + 1)
            } else {
                (day + 1, month)
            };
            (month, year) = if month == 13 {
                (1, year + 1)
            } else {
                (month, year)
            };
        }
    }
}
