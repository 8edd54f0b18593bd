//! A learning curve in one line of a terminal.

/// Successes so far, and grasps before them.
#[derive(Debug, Default)]
pub(super) struct Curve {
    pub(super) n_grasps: usize,
    successes: Vec<bool>,
}

impl Curve {
    /// Episodes in one mark.
    const WINDOW: usize = 10;

    /// Marks shown: the latest.
    const WIDTH: usize = 40;

    pub(super) fn add(&mut self, success: bool) {
        self.successes.push(success);
    }

    /// The share of successes of every ten episodes, low to high.
    pub(super) fn line(&self) -> String {
        const MARKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
        let windows: Vec<&[bool]> = self.successes.chunks(Self::WINDOW).collect();
        let shown = windows.len().saturating_sub(Self::WIDTH);
        windows[shown..]
            .iter()
            .map(|window| {
                let n = window.iter().filter(|success| **success).count();
                MARKS[n * (MARKS.len() - 1) / window.len()]
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Curve;

    #[test]
    fn it_rises_with_success() {
        let mut curve = Curve::default();
        assert_eq!(curve.line(), "");
        for episode in 0..30 {
            curve.add(episode >= 10 && episode % 2 == 0 || episode >= 20);
        }
        assert_eq!(curve.line(), "▁▄█");
    }
}
