use std::io::Write as _;

use super::*;

const TABLE: &str = "\
episode,option,mask,reward,goal_achieved,s:x,s:y,n:x,n:y,init:push,init:pull,next_options
0,push,0,-2,0,0.5,1,0.75,1,1,0,1 1
0,pull,0 1,-1.5,1,0.75,1,0,-0.0,1,1,0 0
7,push,,0,False,0,0,0,0,True,0,1 0
";

fn read(text: &str) -> Result<Transitions, ReadError> {
    read_csv(text.as_bytes())
}

#[test]
fn a_table_is_read_as_it_stands() {
    let transitions = read(TABLE).unwrap();
    assert_eq!(transitions.variables(), ["x", "y"]);
    assert_eq!(transitions.options(), ["push", "pull"]);
    assert_eq!(transitions.len(), 3);
    assert_eq!(transitions.states().row(1), [0.75, 1.0]);
    assert_eq!(transitions.next_states().row(1), [0.0, 0.0]);
    assert_eq!(transitions.option(1), 1);
    assert_eq!(transitions.mask(1), [0, 1]);
    assert!(transitions.mask(2).is_empty());
    assert_eq!(transitions.reward(1), Some(-1.5));
    assert!(transitions.goal_achieved(1) && !transitions.goal_achieved(2));
    assert!(transitions.is_executable(1, 1) && !transitions.is_executable(0, 1));
    assert_eq!(transitions.starts(), [0, 2]);
    assert_eq!(transitions.first(2).len(), 2);
    assert_eq!(transitions.first(9), transitions);
}

#[test]
fn gzip_reads_as_plain_text_does() {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(TABLE.as_bytes()).unwrap();
    let packed = packed.finish().unwrap();
    assert_eq!(read_csv(packed.as_slice()).unwrap(), read(TABLE).unwrap());
    let cut = read_csv(&packed[..packed.len() / 2]).unwrap_err();
    assert!(matches!(cut, ReadError::Io(_)), "{cut}");
}

#[test]
fn without_masks_what_differs_is_the_mask() {
    let text: String = TABLE
        .lines()
        .map(|line| {
            let mut fields: Vec<_> = line.split(',').collect();
            fields.remove(2);
            fields.join(",") + "\n"
        })
        .collect();
    let transitions = read(&text).unwrap();
    assert_eq!(transitions.mask(0), [0]);
    assert_eq!(transitions.mask(1), [0, 1]);
    assert!(transitions.mask(2).is_empty());
}

/// Every complaint names the place, what stands there and what should.
#[test]
fn bad_tables_are_refused_with_the_place() {
    let check = |from: &str, to: &str, message: &str| {
        assert!(TABLE.contains(from), "{from}");
        let error = read(&TABLE.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(error.contains(message), "{error}\nwanted: {message}");
    };
    check("0,push,0,-2", "0,push,0", "row 2 has 11 fields, wanted 12");
    check(
        "0.5,1,0.75",
        "NaN,1,0.75",
        "row 2, column `s:x`: found `NaN`, wanted a finite number",
    );
    check("0.5,1,0.75", "0.5,,0.75", "row 2, column `s:y`: found ``");
    check(
        "0,push",
        "0,kick",
        "row 2, column `option`: found `kick`, wanted `push`, `pull`",
    );
    check(
        "0 1,-1.5",
        "0 2,-1.5",
        "row 3, column `mask`: found `0 2`, wanted indices below 2",
    );
    check("0 1,-1.5", "0 -1,-1.5", "row 3, column `mask`");
    check(
        "7,push",
        "seven,push",
        "row 4, column `episode`: found `seven`",
    );
    check(
        "False",
        "no",
        "row 4, column `goal_achieved`: found `no`, wanted 1 or 0",
    );
    check(
        "1,0,1 1",
        "2,0,1 1",
        "row 2, column `init:push`: found `2`, wanted 1 or 0",
    );
    check(
        "goal_achieved",
        "goal_acheived",
        "did you mean `goal_achieved`?",
    );
    check(
        "episode",
        "epoch",
        "column `epoch` of the transitions is not known",
    );
    check("n:y", "n:z", "no column `n:y`");
    check("s:y", "n:z", "no column `s:z`");
    check(
        "s:y",
        "s:x",
        "column `s:x` of the transitions stands there twice",
    );
    assert!(matches!(read("").unwrap_err(), ReadError::Empty { .. }));
    let error = read("episode,option,s0,n0\n").unwrap_err().to_string();
    assert!(error.contains("no column `init0`"), "{error}");
}

#[test]
fn transitions_from_elsewhere_are_checked_too() {
    let names = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
    let mut transitions = Transitions::new(names(&["x", "y"]), names(&["push"]));
    let good = Transition {
        state: &[0.0, 1.0],
        option: 0,
        next_state: &[1.0, 1.0],
        mask: None,
        executable: &[true],
        episode: 0,
        reward: None,
        goal_achieved: false,
    };
    transitions.push(&good).unwrap();
    let bad = [
        Transition {
            state: &[0.0],
            ..good
        },
        Transition {
            next_state: &[0.0, f64::NAN],
            ..good
        },
        Transition { option: 1, ..good },
        Transition {
            mask: Some(&[0, 2]),
            ..good
        },
        Transition {
            executable: &[],
            ..good
        },
        Transition {
            reward: Some(f64::INFINITY),
            ..good
        },
    ];
    for bad in bad {
        assert!(transitions.push(&bad).is_err(), "{bad:?}");
    }
    assert_eq!(transitions.len(), 1);
}
