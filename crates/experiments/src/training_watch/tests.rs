use std::fs::{self, File};
use std::time::{Duration, UNIX_EPOCH};

use factotum_skills::cip::setting::Ablation;

use super::*;

/// Long enough ago for nothing to be under way.
const LATER: u64 = 1_000_000;

/// A line of an episode of 20 steps; those with an even number have a violation.
pub(super) fn episode(number: u64, success: bool) -> String {
    let (env_steps, violation) = (20 * number, number.is_multiple_of(2));
    format!(
        "{{\"episode\":{number},\"env_steps\":{env_steps},\"success\":{success},\"violation\":{violation},\
         \"steps\":20,\"peak_force_n\":60.5,\"grasp\":null,\"failure\":null}}\n"
    )
}

/// A line of an evaluation.
pub(super) fn evaluation(episode: u64, success_rate: f64) -> String {
    format!(
        "{{\"episode\":{episode},\"env_steps\":{},\"rollouts\":10,\"success_rate\":{success_rate},\"violation_rate\":0.25,\
         \"peak_force_n\":61.5,\"time_to_success_secs\":1.25}}\n",
        20 * episode
    )
}

fn begin(skills: &Path, name: &str, begun_secs: u64) -> SkillFolder {
    let folder = SkillFolder::at(&skills.join(name));
    let record = SkillRecord::new(PathBuf::from("tasks/door.toml"), Ablation::Fast, 7);
    folder.begin(&record).unwrap();
    set_time(&folder.record_file(), begun_secs);
    folder
}

/// Writes metrics, as of a time in seconds after 1970.
fn write(folder: &SkillFolder, text: &str, secs: u64) {
    fs::write(folder.metrics(), text).unwrap();
    set_time(&folder.metrics(), secs);
}

fn set_time(file: &Path, secs: u64) {
    let opened = File::options().append(true).open(file).unwrap();
    opened
        .set_modified(UNIX_EPOCH + Duration::from_secs(secs))
        .unwrap();
}

fn at(secs: u64) -> UtcTime {
    UtcTime::from_unix_secs(secs)
}

fn names(look: &Look) -> Vec<&str> {
    let trainings = look.changed.iter().flat_map(|all| &all.trainings);
    trainings.map(|one| one.name.as_str()).collect()
}

#[test]
fn a_training_is_shown_as_it_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let skills = dir.path().join("skills");
    let mut watch = TrainingWatch::new(&skills);
    let look = watch.look(at(100));
    assert!(look.changed.is_none() && look.troubles.is_empty());

    let folder = begin(&skills, "door", 100);
    let look = watch.look(at(101));
    let expected = wire::Training {
        name: "door".to_owned(),
        task: "door".to_owned(),
        ablation: "fast".to_owned(),
        seed: "7".to_owned(),
        running: true,
        episodes: 0,
        env_steps: 0,
        violations: 0,
        recent_success_rate: None,
        evaluations: Vec::new(),
    };
    assert_eq!(
        look.changed.unwrap().trainings,
        std::slice::from_ref(&expected)
    );
    assert!(watch.look(at(102)).changed.is_none(), "nothing new");

    let text = episode(1, true) + &episode(2, false) + &evaluation(2, 0.5);
    write(&folder, &text, 103);
    let expected = wire::Training {
        episodes: 2,
        env_steps: 40,
        violations: 1,
        recent_success_rate: Some(0.5),
        evaluations: vec![wire::Evaluation {
            episode: 2,
            success_rate: 0.5,
            violation_rate: 0.25,
            peak_force_n: 61.5,
            time_to_success_secs: Some(1.25),
        }],
        ..expected
    };
    let look = watch.look(at(104));
    assert_eq!(
        look.changed.unwrap().trainings,
        std::slice::from_ref(&expected)
    );
    assert!(watch.look(at(103 + RUNNING_SECS - 1)).changed.is_none());
    let look = watch.look(at(103 + RUNNING_SECS));
    let expected = wire::Training {
        running: false,
        ..expected
    };
    assert_eq!(look.changed.unwrap().trainings, [expected]);

    fs::remove_dir_all(&skills).unwrap();
    assert_eq!(
        watch.look(at(LATER)).changed,
        Some(wire::Trainings::default())
    );
}

#[test]
fn those_under_way_come_first_then_the_latest_begun_and_not_too_many() {
    let dir = tempfile::tempdir().unwrap();
    for number in 0..TRAININGS_MAX as u64 + 5 {
        begin(dir.path(), &format!("door-{number:02}"), 1000 + number);
    }
    let oldest = begin(dir.path(), "oldest", 10);
    write(&oldest, &episode(1, true), LATER);
    fs::create_dir(dir.path().join("no-skill")).unwrap();
    fs::write(dir.path().join("notes.txt"), "").unwrap();
    let look = TrainingWatch::new(dir.path()).look(at(LATER));
    let names = names(&look);
    assert_eq!(names.len(), TRAININGS_MAX);
    assert_eq!(names[..3], ["oldest", "door-54", "door-53"]);
}

#[test]
fn a_broken_folder_is_told_once_and_the_others_are_shown() {
    let dir = tempfile::tempdir().unwrap();
    begin(dir.path(), "good", 10);
    let broken = begin(dir.path(), "broken", 20);
    write(&broken, "no metrics\n", 20);
    let other = begin(dir.path(), "other", 30);
    fs::write(other.record_file(), "format = 9").unwrap();

    let mut watch = TrainingWatch::new(dir.path());
    let look = watch.look(at(LATER));
    assert_eq!(names(&look), ["good"]);
    let said: Vec<String> = look.troubles.iter().map(ToString::to_string).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said.iter().any(|text| text.contains("metrics.jsonl")));
    assert!(said.iter().any(|text| text.contains("skill.toml")));
    assert!(watch.look(at(LATER)).troubles.is_empty());
    write(&broken, "no metrics\n{}\n", 21);
    assert!(watch.look(at(LATER)).troubles.is_empty(), "the same line");

    write(&broken, &episode(1, true), 22);
    let look = watch.look(at(LATER));
    assert_eq!(names(&look), ["broken", "good"], "mended");
}

#[test]
fn what_is_no_folder_is_told_once() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("skills");
    fs::write(&file, "").unwrap();
    let mut watch = TrainingWatch::new(&file);
    let look = watch.look(at(LATER));
    assert!(look.changed.is_none());
    assert!(
        matches!(look.troubles[..], [TrainingWatchError::List(_)]),
        "{look:?}"
    );
    assert!(watch.look(at(LATER)).troubles.is_empty());
}

#[test]
fn another_training_in_the_same_folder_begins_anew() {
    let dir = tempfile::tempdir().unwrap();
    let folder = begin(dir.path(), "door", 10);
    write(&folder, &(episode(1, true) + &episode(2, true)), 20);
    let mut watch = TrainingWatch::new(dir.path());
    watch.look(at(LATER));
    fs::remove_dir_all(folder.dir()).unwrap();
    let folder = begin(dir.path(), "door", 30);
    let text = episode(1, false) + &evaluation(1, 0.0) + &episode(2, false) + &episode(3, false);
    write(&folder, &text, 40);
    let trainings = watch.look(at(LATER)).changed.unwrap().trainings;
    assert_eq!(trainings[0].episodes, 3);
    assert_eq!(trainings[0].recent_success_rate, Some(0.0));
}

#[test]
fn of_very_many_evaluations_some_are_shown_and_the_last() {
    let dir = tempfile::tempdir().unwrap();
    let folder = begin(dir.path(), "door", 10);
    let n_evaluations = 2 * EVALUATIONS_MAX as u64 + 2;
    let text: String = (1..=n_evaluations)
        .map(|number| episode(number, true) + &evaluation(number, 1.0))
        .collect();
    write(&folder, &text, 20);
    let look = TrainingWatch::new(dir.path()).look(at(LATER));
    let trainings = look.changed.unwrap().trainings;
    let evaluations = &trainings[0].evaluations;
    assert_eq!(evaluations.len(), 134);
    assert_eq!(
        evaluations.last().map(|last| last.episode),
        Some(count(n_evaluations))
    );
    assert!(evaluations.is_sorted_by_key(|one| one.episode));
}
