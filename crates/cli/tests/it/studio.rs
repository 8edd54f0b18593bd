//! `factotum studio` as a process: killed between the acceptance of an edit and its answer, and serving other machines.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use factotum_descriptions::Form;
use factotum_geometry::Pose2;
use factotum_geometry::grid::{Cell, OccupancyGrid};
use factotum_semantic_map::{Aosm, Edit, Home};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use crate::driven::page::Page;
use crate::{assert_refused, factotum, factotum_in, repository};

/// A home with a class of which things can be put down.
fn make_home(dir: &Path) {
    let grid = OccupancyGrid::filled(40, 40, 0.1, Pose2::identity(), Cell::FREE).unwrap();
    let mut home = Home::create(dir, "flat", &Aosm::new([], grid), 0.0).unwrap();
    let flask = Edit::MakeClass {
        name: "flask".to_owned(),
        form: Form::Cylinder {
            diameter_m: 0.065,
            height_m: 0.2,
        },
        movable: true,
    };
    home.edit(&flask, "test", 1.0).unwrap();
}

/// A studio at work, killed when it is dropped.
struct Studio {
    process: Child,
    /// What it says, line by line.
    said: BufReader<std::process::ChildStderr>,
}

impl Studio {
    fn start(dir: &Path, options: &[&str]) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_factotum"))
            .args(["studio", "--home", "home"])
            .args(options)
            .current_dir(dir)
            .env("FACTOTUM_ASSETS", repository().join("assets"))
            .env("XDG_DATA_HOME", dir.join("data"))
            .env("NO_COLOR", "1")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let said = BufReader::new(process.stderr.take().unwrap());
        Self { process, said }
    }

    /// The rest of the first line that has these words.
    fn until(&mut self, words: &str) -> String {
        loop {
            let mut line = String::new();
            assert!(self.said.read_line(&mut line).unwrap() > 0, "it ended");
            if let Some((_, rest)) = line.trim_end().split_once(words) {
                return rest.to_owned();
            }
        }
    }

    fn url(&mut self) -> String {
        let line = self.until("flat at ");
        line.split(' ').next().unwrap().to_owned()
    }

    /// SIGKILL: it has no time for anything.
    fn kill(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        // Either may fail when the process is already gone.
        self.process.kill().ok();
        self.process.wait().ok();
    }
}

fn add_flask(number: u32) -> String {
    format!(
        r#"{{"type":"edit","id":"flask {number}","base":null,"edit":{{"kind":"add_object","class":"flask","pose":{{"position":[1.0,{}.5,0.0],"orientation_xyzw":[0.0,0.0,0.0,1.0]}}}}}}"#,
        number % 4
    )
}

/// When the journal was last written to, and how long it is.
fn stamp(home: &Path) -> Option<(SystemTime, u64)> {
    let found = std::fs::metadata(home.join("journal.sqlite-wal")).ok()?;
    Some((found.modified().ok()?, found.len()))
}

/// A page sends an edit, hears nothing of it since the studio is killed, and sends it again to the next studio, under the
/// same id. It is there once, whenever the kill came. `FACTOTUM_TEST_KILLS` says how many.
#[test]
fn killed_before_the_answer_a_studio_applies_an_edit_that_is_sent_again_once() {
    let n_kills: u32 = std::env::var("FACTOTUM_TEST_KILLS")
        .ok()
        .and_then(|told| told.parse().ok())
        .unwrap_or(8);
    let dir = tempfile::tempdir().unwrap();
    let home = dir.path().join("home");
    make_home(&home);
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut n_accepted = 0;
    let mut studio = Studio::start(dir.path(), &[]);
    let mut url = studio.url();
    for number in 0..n_kills {
        let mut page = Page::open(&url);
        page.until(|message| message["type"] == "teaching");
        let before = stamp(&home);
        page.send(&add_flask(number));
        if number % 4 == 3 {
            // Perhaps before it was accepted.
            std::thread::sleep(Duration::from_micros(rng.random_range(0..3000)));
        } else {
            let sent = Instant::now();
            while stamp(&home) == before {
                assert!(
                    sent.elapsed() < Duration::from_secs(60),
                    "edit {number} not written"
                );
            }
            std::thread::sleep(Duration::from_micros(rng.random_range(0..2000)));
        }
        studio.kill();
        let kept = Home::open(&home, 2.0).unwrap();
        let n_kept = kept.aosm().objects.len() as u32;
        drop(kept);
        assert!(
            (number..=number + 1).contains(&n_kept),
            "{n_kept} after {number}"
        );
        n_accepted += n_kept - number;

        studio = Studio::start(dir.path(), &[]);
        url = studio.url();
        let mut page = Page::open(&url);
        page.send(&add_flask(number));
        let answer = page.until(|message| message["type"] == "edit_answer");
        assert_eq!(answer["outcome"]["kind"], "accepted", "{answer}");
        assert_eq!(answer["outcome"]["what"], format!("flask_{}", number + 1));
    }
    studio.kill();
    let kept = Home::open(&home, 3.0).unwrap();
    assert_eq!(kept.aosm().objects.len() as u32, n_kills);
    // Made, one class, and an entry for each thing: nothing was done twice and undone.
    assert_eq!(kept.last_entry().unwrap(), i64::from(n_kills) + 2);
    assert!(
        n_accepted > 0,
        "none of {n_kills} was accepted and not answered"
    );
    let log = std::fs::read_to_string(home.join("audit.jsonl")).unwrap();
    let edits = log.lines().filter(|line| line.contains(r#""kind":"edit""#));
    assert!(edits.count() as u32 >= n_kills, "{log}");
}

#[test]
fn with_lan_it_shows_links_and_keeps_its_key_to_its_owner() {
    let dir = tempfile::tempdir().unwrap();
    make_home(&dir.path().join("home"));
    let options = [
        "--lan",
        "--address",
        "127.0.0.1:0",
        "--role",
        "teach",
        "--role",
        "view",
    ];
    let fingerprint = |studio: &mut Studio| {
        let look = studio.until("to look, and to stop the robot: ");
        let teach = studio.until("to teach: ");
        for link in [&look, &teach] {
            assert!(link.starts_with("https://127.0.0.1:"), "{link}");
        }
        assert_ne!(look.split_once('?'), teach.split_once('?'));
        studio.until("SHA-256 is");
        studio.until("")
    };
    let mut studio = Studio::start(dir.path(), &options);
    let first = fingerprint(&mut studio);
    assert_eq!(first.split(':').count(), 32, "{first}");
    studio.kill();
    assert_eq!(fingerprint(&mut Studio::start(dir.path(), &options)), first);
    let file = dir.path().join("data/factotum/studio-certificate.json");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = std::fs::metadata(&file).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }
    let home = std::fs::read_dir(dir.path().join("home")).unwrap();
    let mut names = home.map(|entry| entry.unwrap().file_name());
    assert!(names.all(|name| !name.to_string_lossy().contains("certificate")));
}

#[test]
fn without_lan_it_serves_nobody_else() {
    let dir = tempfile::tempdir().unwrap();
    make_home(&dir.path().join("home"));
    let studio = ["studio", "--home", "home"];
    let said = factotum_in(
        dir.path(),
        &[&studio[..], &["--address", "0.0.0.0:0"]].concat(),
    );
    assert_refused(&said, &["0.0.0.0:0", "not on loopback", "--lan"]);
    let said = factotum(&["studio", "--home", "home", "--role", "view"]);
    assert_refused(&said, &["--lan"]);
    let said = factotum(&["studio", "--home", "home", "--lan", "--role", "admin"]);
    assert_refused(&said, &["admin", "view, teach, execute"]);
}
