//! Known values of small problems, the same bytes for the same seed, and what stops a learner.

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::{Counters, ParamsError, Policy, Td3, Td3Error, Td3Params};
use crate::environment::{Environment, Step, evaluate_episode, train_episode};
use crate::panels::WIDTH;
use crate::replay::{Ending, Transition};

/// Small and quick to learn; the numbers are not tuned beyond that.
fn quick() -> Td3Params {
    Td3Params {
        learning_rate: 3e-3,
        hidden: vec![32, 32],
        batch_size: 64,
        replay_capacity: 10_000,
        target_share: 0.05,
        warmup_steps: 0,
        ..Td3Params::default()
    }
}

/// A learner with one transition that leads to where it began and earns 1.
fn loop_of_one(ending: Ending) -> Td3 {
    let params = Td3Params {
        discount: 0.5,
        // With noise the value of the next action would be learned from no data.
        target_noise: 0.0,
        // Targets move at every update.
        policy_delay: 1,
        // All rows of a batch are the same.
        batch_size: 8,
        ..quick()
    };
    let mut learner = Td3::new(3, 1, params, 1).unwrap();
    learner
        .record(&Transition {
            observation: &[0.5, -0.5, 1.0],
            action: &[0.0],
            reward: 1.0,
            next_observation: &[0.5, -0.5, 1.0],
            ending,
        })
        .unwrap();
    learner
}

#[test]
fn the_end_of_a_task_ends_the_future_and_a_time_limit_does_not() {
    let value_after = |ending, n: usize| {
        let mut learner = loop_of_one(ending);
        let mut value = 0.0;
        for _ in 0..n {
            // The policy is kept at the action that was tried, the only one whose value is known.
            learner.policy.network.scale_output(0.0);
            learner.policy.target.scale_output(0.0);
            value = learner.update().unwrap().mean_value;
        }
        value
    };
    let terminal = value_after(Ending::Terminal, 600);
    assert!((terminal - 1.0).abs() < 0.02, "{terminal}");
    for ending in [Ending::Goes, Ending::Cut] {
        // 1 + 1/2 + 1/4 + ...
        let value = value_after(ending, 1_500);
        assert!((value - 2.0).abs() < 0.04, "{ending:?}: {value}");
    }
}

/// One step, reward `-|a - best(s)|²`: the policy becomes `best`. The action's columns straddle two panels of the
/// critics' input.
#[test]
fn the_policy_goes_to_the_best_action() {
    const N_OBSERVATION: usize = WIDTH - 1;
    let best = |observation: &[f32]| [0.5 * observation[0], -0.4, 0.6 * observation[1]];
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut learner = Td3::new(N_OBSERVATION, 3, quick(), 2).unwrap();
    let mut observation = [0.0; N_OBSERVATION];
    for _ in 0..3_000 {
        observation.fill_with(|| rng.random_range(-1.0..1.0));
        let action: [f32; 3] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        let reward = best(&observation)
            .iter()
            .zip(&action)
            .map(|(best, action)| -(best - action).powi(2))
            .sum();
        learner
            .record(&Transition {
                observation: &observation,
                action: &action,
                reward,
                next_observation: &observation,
                ending: Ending::Terminal,
            })
            .unwrap();
    }
    let mut error = |policy: &mut Policy| {
        let mut total = 0.0;
        for _ in 0..100 {
            observation.fill_with(|| rng.random_range(-1.0..1.0));
            let mut action = [0.0; 3];
            policy.act_into(&observation, &mut action).unwrap();
            for (best, action) in best(&observation).iter().zip(action) {
                total += (best - action).abs() / 300.0;
            }
        }
        total
    };
    let before = error(&mut learner.policy());
    for _ in 0..2_000 {
        learner.update().unwrap();
    }
    let after = error(&mut learner.policy());
    // Seeds 0 to 4: before 0.29 to 0.38, after 0.03 to 0.05.
    assert!(
        before > 0.2 && after < 0.1,
        "{before} before, {after} after"
    );
}

/// A mass on a line that is to come to rest at zero: `x' = v`, `v' = 2 a - v`, 40 steps of 0.1 s from |x| <= 1.
struct Mass {
    x: f32,
    v: f32,
    n_steps: u32,
}

impl Environment for Mass {
    type Error = std::convert::Infallible;

    fn n_observation(&self) -> usize {
        2
    }

    fn n_action(&self) -> usize {
        1
    }

    fn reset_into(
        &mut self,
        rng: &mut ChaCha8Rng,
        observation: &mut [f32],
    ) -> Result<(), Self::Error> {
        let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
        *self = Self {
            x: side * rng.random_range(0.5..1.0),
            v: 0.0,
            n_steps: 0,
        };
        observation.copy_from_slice(&[self.x, self.v]);
        Ok(())
    }

    fn step_into(&mut self, action: &[f32], observation: &mut [f32]) -> Result<Step, Self::Error> {
        self.v += 0.1 * (2.0 * action[0] - self.v);
        self.x += 0.1 * self.v;
        self.n_steps += 1;
        observation.copy_from_slice(&[self.x, self.v]);
        let ending = if self.n_steps == 40 {
            Ending::Cut
        } else {
            Ending::Goes
        };
        let reward = -(self.x.powi(2) + 0.1 * self.v.powi(2));
        Ok(Step { reward, ending })
    }
}

/// Mean distance from rest at the end of 20 episodes.
fn distance(policy: &mut Policy) -> f32 {
    let mut rng = ChaCha8Rng::seed_from_u64(99);
    let mut mass = Mass {
        x: 0.0,
        v: 0.0,
        n_steps: 0,
    };
    let mut total = 0.0;
    for _ in 0..20 {
        evaluate_episode(policy, &mut mass, &mut rng).unwrap();
        total += (mass.x.abs() + mass.v.abs()) / 20.0;
    }
    total
}

#[test]
fn a_mass_learns_to_come_to_rest() {
    let params = Td3Params {
        exploration_noise: 0.2,
        warmup_steps: 200,
        ..quick()
    };
    let mut learner = Td3::new(2, 1, params, 3).unwrap();
    let before = distance(&mut learner.policy());
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut mass = Mass {
        x: 0.0,
        v: 0.0,
        n_steps: 0,
    };
    let untouched = learner.clone();
    distance(&mut learner.policy());
    assert!(learner == untouched, "an evaluation changes nothing");
    for _ in 0..75 {
        train_episode(&mut learner, &mut mass, &mut rng).unwrap();
    }
    let after = distance(&mut learner.policy());
    // Seeds 0 to 4: before 0.83 to 1.59, after 0.05 to 0.09.
    assert!(
        before > 0.6 && after < 0.25,
        "{before} before, {after} after"
    );
    let counters = learner.counters();
    assert_eq!((counters.n_env_steps, counters.n_updates), (3_000, 2_800));
}

#[test]
fn the_same_seed_gives_the_same_weights() {
    let train = |seed| {
        let mut learner = loop_of_one(Ending::Goes);
        learner = Td3 {
            replay: learner.replay.clone(),
            ..Td3::new(3, 1, quick(), seed).unwrap()
        };
        for _ in 0..20 {
            learner.update().unwrap();
        }
        learner
    };
    assert!(train(5) == train(5));
    assert!(train(5).policy != train(6).policy);
}

#[test]
fn warm_up_steps_explore_everywhere_and_earn_nothing() {
    let params = Td3Params {
        warmup_steps: 400,
        updates_per_step: 0.5,
        exploration_noise: 0.01,
        ..quick()
    };
    let mut learner = Td3::new(2, 1, params, 7).unwrap();
    let observation = [0.3, -0.2];
    let mut policy_says = [0.0];
    learner
        .policy()
        .act_into(&observation, &mut policy_says)
        .unwrap();
    let mut actions = Vec::new();
    for _ in 0..405 {
        let mut action = [0.0];
        learner.explore_into(&observation, &mut action).unwrap();
        actions.push(action[0]);
        learner
            .record(&Transition {
                observation: &observation,
                action: &action,
                reward: 0.0,
                next_observation: &observation,
                ending: Ending::Goes,
            })
            .unwrap();
    }
    let (warm, later) = actions.split_at(400);
    assert!(warm.iter().any(|action| *action < -0.9) && warm.iter().any(|action| *action > 0.9));
    for action in later {
        assert!(
            (action - policy_says[0]).abs() < 0.06,
            "{action} for {policy_says:?}"
        );
    }
    learner
        .record_of_another(&Transition {
            observation: &observation,
            action: &[0.0],
            reward: 0.0,
            next_observation: &observation,
            ending: Ending::Goes,
        })
        .unwrap();
    assert_eq!(learner.replay().len(), 406);
    assert!(learner.update_owed().unwrap().is_some());
    let wanted = Counters {
        n_env_steps: 405,
        n_updates: 2,
        n_updates_owed: 0.5,
    };
    assert_eq!(*learner.counters(), wanted);
}

#[test]
fn a_number_that_is_not_finite_stops_learning_and_spoils_nothing() {
    let mut learner = loop_of_one(Ending::Goes);
    for _ in 0..5 {
        learner.update().unwrap();
    }
    let refused = learner.record(&Transition {
        observation: &[0.0, f32::NAN, 0.0],
        action: &[0.0],
        reward: 0.0,
        next_observation: &[0.0; 3],
        ending: Ending::Goes,
    });
    assert_eq!(
        refused.unwrap_err().to_string(),
        "observation is not finite at step 2"
    );
    assert_eq!(learner.replay().len(), 1);

    // The square of this reward is beyond f32.
    learner
        .record(&Transition {
            observation: &[0.0; 3],
            action: &[0.0],
            reward: 1e30,
            next_observation: &[0.0; 3],
            ending: Ending::Goes,
        })
        .unwrap();
    let good = learner.clone();
    let stopped = learner.update().unwrap_err();
    assert_eq!(
        stopped.to_string(),
        "loss of the critics is not finite at step 6"
    );
    assert!(learner.policy.network == good.policy.network);
    assert!(learner.critics.network == good.critics.network);
    assert!(learner.critics.adam == good.critics.adam);
    assert_eq!(learner.counters, good.counters);
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut learner = Td3::new(3, 2, quick(), 1).unwrap();
    assert_eq!(learner.update().unwrap_err(), Td3Error::NothingRecorded);
    let size = |what, found, wanted| Td3Error::Size {
        what,
        found,
        wanted,
    };
    let found = learner.explore_into(&[0.0; 4], &mut [0.0; 2]);
    assert_eq!(found.unwrap_err(), size("observation", 4, 3));
    let found = learner.policy().act_into(&[0.0; 3], &mut [0.0; 1]);
    assert_eq!(found.unwrap_err(), size("action", 1, 2));
    let blind = [0.0, f32::INFINITY, 0.0];
    let says = "component 1 of the observation is inf, expected a finite number";
    let found = learner.explore_into(&blind, &mut [0.0; 2]);
    assert_eq!(found.unwrap_err().to_string(), says);
    let found = learner.policy().act_into(&blind, &mut [0.0; 2]);
    assert_eq!(found.unwrap_err().to_string(), says);
    let endless = Td3Params {
        replay_capacity: u32::MAX as usize,
        ..quick()
    };
    // 4e9 transitions of forty thousand numbers: more than a processor can address.
    let found = Td3::new(20_000, 2, endless, 1).unwrap_err();
    let capacity = u32::MAX as usize;
    assert_eq!(found, Td3Error::Memory { capacity });
    assert!(matches!(
        Td3::new(0, 2, quick(), 1),
        Err(Td3Error::Network(_))
    ));
}

#[test]
fn a_policy_begins_about_its_first_action() {
    let params = Td3Params {
        policy_output_scale: 0.0,
        policy_first_action: vec![0.5, -0.9],
        ..quick()
    };
    let learner = Td3::new(3, 2, params.clone(), 1).unwrap();
    let mut action = [0.0; 2];
    learner
        .policy()
        .act_into(&[0.3, -4.0, 1.0], &mut action)
        .unwrap();
    assert!((action[0] - 0.5).abs() < 1e-6 && (action[1] + 0.9).abs() < 1e-6);
    assert!(matches!(
        Td3::new(3, 3, params, 1),
        Err(Td3Error::Size {
            found: 2,
            wanted: 3,
            ..
        })
    ));
}

#[test]
fn a_parameter_out_of_range_is_named() {
    type Spoil = fn(&mut Td3Params);
    let cases: [(&str, &str, Spoil); 14] = [
        ("learning_rate", "0", |p| p.learning_rate = 0.0),
        ("learning_rate", "NaN", |p| p.learning_rate = f64::NAN),
        ("hidden", "[64, 0]", |p| p.hidden = vec![64, 0]),
        ("policy_output_scale", "inf", |p| {
            p.policy_output_scale = f32::INFINITY
        }),
        ("policy_first_action", "[1.0]", |p| {
            p.policy_first_action = vec![1.0]
        }),
        ("batch_size", "0", |p| p.batch_size = 0),
        ("replay_capacity", "0", |p| p.replay_capacity = 0),
        ("discount", "1", |p| p.discount = 1.0),
        ("target_share", "1.5", |p| p.target_share = 1.5),
        ("policy_delay", "0", |p| p.policy_delay = 0),
        ("exploration_noise", "-0.1", |p| p.exploration_noise = -0.1),
        ("target_noise", "-1", |p| p.target_noise = -1.0),
        ("target_noise_clip", "NaN", |p| {
            p.target_noise_clip = f64::NAN
        }),
        ("updates_per_step", "-2", |p| p.updates_per_step = -2.0),
    ];
    for (field, found, spoil) in cases {
        let mut params = Td3Params::default();
        params.check().unwrap();
        spoil(&mut params);
        let Err(Td3Error::Params(ParamsError {
            field: f, found: n, ..
        })) = Td3::new(3, 1, params, 1)
        else {
            panic!("{field} = {found} is accepted");
        };
        assert_eq!((f, n.as_str()), (field, found));
    }
    let wrong = Td3Params {
        discount: 1.0,
        ..Td3Params::default()
    };
    assert_eq!(
        wrong.check().unwrap_err().to_string(),
        "`discount` is 1, expected a number of at least 0 and below 1"
    );
}

#[test]
fn parameters_are_data() {
    let read: Td3Params = serde_json::from_str(r#"{"hidden": [400, 300]}"#).unwrap();
    assert_eq!(read, Td3Params::as_in_the_code());
    let unknown = serde_json::from_str::<Td3Params>(r#"{"gamma": 0.9}"#).unwrap_err();
    assert!(unknown.to_string().contains("`gamma`"), "{unknown}");
}

#[test]
fn a_policy_is_cloned_from_what_was_recorded() {
    let params = Td3Params {
        hidden: vec![16, 16],
        batch_size: 32,
        replay_capacity: 200,
        warmup_steps: 0,
        learning_rate: 1e-3,
        ..Td3Params::default()
    };
    let mut learner = Td3::new(2, 3, params, 1).unwrap();
    assert!(matches!(
        learner.clone_recorded(1),
        Err(Td3Error::NothingRecorded)
    ));
    // What is done is a function of what is seen.
    let shown = |x: f32, y: f32| [0.5 * x, -0.3, 0.4 * y * x];
    let seen = |i: u16| {
        let share = f32::from(i) / 100.0;
        [2.0 * share - 1.0, 1.0 - share]
    };
    for i in 0..100 {
        let [x, y] = seen(i);
        let transition = Transition {
            observation: &[x, y],
            action: &shown(x, y),
            reward: 0.0,
            next_observation: &[x, y],
            ending: Ending::Goes,
        };
        learner.record_of_another(&transition).unwrap();
    }
    let critics = learner.critics.clone();
    let difference = learner.clone_recorded(1500).unwrap();
    assert!(difference < 1e-3, "{difference}");
    assert_eq!(learner.critics, critics, "nothing else has changed");
    assert_eq!(
        learner.policy.network.parameters(),
        learner.policy.target.parameters()
    );
    let mut policy = learner.policy();
    for i in [0, 30, 77, 99] {
        let [x, y] = seen(i);
        let mut action = [0.0; 3];
        policy.act_into(&[x, y], &mut action).unwrap();
        for (found, wanted) in action.iter().zip(shown(x, y)) {
            assert!((found - wanted).abs() < 0.08, "{action:?} at {i}");
        }
    }
}
