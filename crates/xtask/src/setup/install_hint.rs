//! The command that installs a program, in the words of this machine's package manager.

use crate::process;

/// Package managers we know, with the names they give to what we need.
struct PackageManager {
    program: &'static str,
    install: &'static str,
    chromium: &'static str,
    node: &'static str,
    pip: &'static str,
}

const PACKAGE_MANAGERS: [PackageManager; 5] = [
    PackageManager {
        program: "apt-get",
        install: "sudo apt-get install",
        chromium: "chromium",
        node: "nodejs npm",
        pip: "python3 python3-pip",
    },
    PackageManager {
        program: "dnf",
        install: "sudo dnf install",
        chromium: "chromium",
        node: "nodejs npm",
        pip: "python3 python3-pip",
    },
    PackageManager {
        program: "pacman",
        install: "sudo pacman -S",
        chromium: "chromium",
        node: "nodejs npm",
        pip: "python python-pip",
    },
    PackageManager {
        program: "zypper",
        install: "sudo zypper install",
        chromium: "chromium",
        node: "nodejs npm",
        pip: "python3 python3-pip",
    },
    PackageManager {
        program: "brew",
        install: "brew install",
        chromium: "--cask chromium",
        node: "node",
        pip: "python",
    },
];

fn here() -> Option<&'static PackageManager> {
    PACKAGE_MANAGERS
        .iter()
        .find(|manager| process::find_on_path(manager.program).is_some())
}

pub(super) fn chromium() -> String {
    let by_hand = "install Chromium or Chrome, or set CHROMIUM to the path of one";
    here().map_or_else(
        || by_hand.to_owned(),
        |m| format!("{} {}; or set CHROMIUM to its path", m.install, m.chromium),
    )
}

pub(super) fn node() -> String {
    let by_hand = format!(
        "install Node.js {} or later from https://nodejs.org",
        super::page::NODE_MAJOR_MIN
    );
    here().map_or_else(
        || by_hand.clone(),
        |m| format!("{by_hand} (here perhaps: {} {})", m.install, m.node),
    )
}

pub(super) fn pip() -> String {
    here().map_or_else(
        || "install Python 3 with pip".to_owned(),
        |m| format!("{} {}", m.install, m.pip),
    )
}
