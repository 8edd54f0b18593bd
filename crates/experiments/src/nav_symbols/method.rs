//! Ways to find base poses, and the two settings in which they are compared (dissertation 5.4, Fig. 5.3).

use std::fmt;

use factotum_symbols::navigation_learner::{PoseFrame, Weights};
use serde::{Deserialize, Serialize};

/// How far from the object the geometric heuristic of the dissertation proposes.
const RADIUS_NARROW_M: f64 = 1.5;

/// The same, widened: the narrow one is all but the label of the action maps itself, "visible within 1.5 m".
const RADIUS_WIDE_M: f64 = 3.0;

/// What ours counts. Chosen on the tuning kitchens, where the tries hardly depend on them: any information from 0 to 0.5 and
/// any way from 0 to 0.01 gives 1.02 to 1.05 times the oracle's.
const WEIGHTS: Weights = Weights {
    teach_per_nat: 0.2,
    travel_per_m: 0.01,
};

/// Which kitchen coffee is made in next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Setting {
    /// Another one; none again before all were.
    Multi,
    /// The same.
    Single,
}

impl Setting {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Multi, Self::Single];
}

/// A way to find base poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Any feasible place: knows the answers.
    Oracle,
    /// Weighs success, what a try teaches, and the way; polar frame, all skills share one process.
    Ours,
    /// The same in the object's frame.
    OursObject,
    /// The same in the polar frame, but each skill learns alone.
    OursApart,
    /// Proposed within 3 m and facing, accepted by the symbol; the object's frame.
    HeuristicObject,
    /// The same, polar frame.
    HeuristicPolar,
    /// The same, the map's frame.
    HeuristicGlobal,
    /// The object's frame, proposed within 1.5 m.
    #[serde(rename = "heuristic_object_1_5_m")]
    NarrowObject,
    /// Proposed anywhere; the object's frame.
    RandomObject,
    /// The same, polar frame.
    RandomPolar,
    /// The same, the map's frame.
    RandomGlobal,
}

/// Which places are proposed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Proposal {
    /// All.
    Random,
    /// Those near the object that face it as well as four headings can.
    Heuristic {
        /// How near.
        radius_m: f64,
    },
    /// Those where the step succeeds.
    Feasible,
}

/// Which of them is tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Chooser {
    /// Any.
    Any,
    /// Any, accepted with the symbol's probability (dissertation 5.4, with the fixed kernel of its code).
    Accepted,
    /// The one worth most.
    Weighed(Weights),
}

impl Method {
    /// All.
    pub const ALL: [Self; 11] = [
        Self::Oracle,
        Self::Ours,
        Self::OursObject,
        Self::OursApart,
        Self::HeuristicObject,
        Self::HeuristicPolar,
        Self::HeuristicGlobal,
        Self::NarrowObject,
        Self::RandomObject,
        Self::RandomPolar,
        Self::RandomGlobal,
    ];

    /// As in files and answers.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Oracle => "oracle",
            Self::Ours => "ours",
            Self::OursObject => "ours_object",
            Self::OursApart => "ours_apart",
            Self::HeuristicObject => "heuristic_object",
            Self::HeuristicPolar => "heuristic_polar",
            Self::HeuristicGlobal => "heuristic_global",
            Self::NarrowObject => "heuristic_object_1_5_m",
            Self::RandomObject => "random_object",
            Self::RandomPolar => "random_polar",
            Self::RandomGlobal => "random_global",
        }
    }

    pub(super) fn proposal(self) -> Proposal {
        match self {
            Self::Oracle => Proposal::Feasible,
            Self::NarrowObject => Proposal::Heuristic {
                radius_m: RADIUS_NARROW_M,
            },
            Self::RandomObject | Self::RandomPolar | Self::RandomGlobal => Proposal::Random,
            _ => Proposal::Heuristic {
                radius_m: RADIUS_WIDE_M,
            },
        }
    }

    pub(super) fn chooser(self) -> Chooser {
        match self {
            Self::Oracle => Chooser::Any,
            Self::Ours | Self::OursObject | Self::OursApart => Chooser::Weighed(WEIGHTS),
            _ => Chooser::Accepted,
        }
    }

    pub(super) fn frame(self) -> PoseFrame {
        match self {
            Self::HeuristicGlobal | Self::RandomGlobal => PoseFrame::Global,
            Self::OursObject | Self::HeuristicObject | Self::NarrowObject | Self::RandomObject => {
                PoseFrame::Object
            }
            Self::Oracle | Self::Ours | Self::OursApart => PoseFrame::Polar,
            Self::HeuristicPolar | Self::RandomPolar => PoseFrame::Polar,
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Multi => "multi-scene",
            Self::Single => "single-scene",
        })
    }
}
