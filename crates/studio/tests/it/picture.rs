//! From the job to the page: the whole picture for the late, the latest for the slow.

use std::time::{Duration, Instant};

use factotum_protocol::{
    Activity, Aosm, BodyPose, Done, OccupancyMap, Plan, Pose, PosePlanar, Scene, SceneSource,
    ServerMessage, State, Status,
};
use factotum_studio::{Studio, StudioConfig};

use crate::client::{PATIENCE, Page, event, start};

fn state(time_secs: f64, n_bodies: usize) -> ServerMessage {
    let body_poses = (0..n_bodies).map(|index| BodyPose {
        name: format!("body {index}"),
        pose: Pose::IDENTITY,
    });
    ServerMessage::State(State {
        time_secs,
        sim_speed: 1.0,
        base: PosePlanar {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
        },
        body_poses: body_poses.collect(),
        joints: Vec::new(),
    })
}

fn scene(source: SceneSource) -> ServerMessage {
    ServerMessage::Scene(Scene {
        source,
        bodies: Vec::new(),
    })
}

fn status(paused: bool) -> ServerMessage {
    ServerMessage::Status(Status {
        goal: "light off".to_owned(),
        activity: Activity::Acting,
        paused,
        takes_driving: false,
    })
}

#[tokio::test]
async fn a_late_page_gets_the_whole_picture() {
    let studio = Studio::start(StudioConfig {
        events_max: 2,
        ..StudioConfig::default()
    })
    .unwrap();
    let map = OccupancyMap::from_cells(
        1,
        2,
        0.05,
        PosePlanar {
            x: 0.0,
            y: 0.0,
            yaw: 0.0,
        },
        &[0, -1],
    );
    let done = ServerMessage::Done(Done {
        achieved: false,
        summary: "the switch is out of reach".to_owned(),
    });
    let kept = [
        scene(SceneSource::Robot),
        scene(SceneSource::Home),
        ServerMessage::Map(map.unwrap()),
        ServerMessage::Aosm(Aosm::default()),
        event("two"),
        ServerMessage::Plan(Plan::default()),
        state(2.0, 3),
        event("three"),
        status(true),
        done,
    ];
    studio.publish(event("one"));
    studio.publish(state(1.0, 3));
    studio.publish(status(false));
    for message in &kept {
        studio.publish(message.clone());
    }
    for _ in 0..2 {
        let mut page = Page::open(&studio).await;
        assert!(matches!(page.next().await, ServerMessage::Hello(_)));
        for message in &kept {
            assert_eq!(&page.next().await, message);
        }
    }
}

#[tokio::test]
async fn a_returning_page_knows_the_session_and_a_new_studio_has_another() {
    async fn greeting(studio: &factotum_studio::StudioHandle) -> factotum_protocol::Hello {
        match Page::open(studio).await.next().await {
            ServerMessage::Hello(hello) => hello,
            other => panic!("greeted by {other:?}"),
        }
    }
    let studio = start();
    let first = greeting(&studio).await;
    let again = greeting(&studio).await;
    assert_eq!(first.session, again.session);
    assert_ne!(first.client, again.client, "each connection has its name");
    let elsewhere = start();
    assert_ne!(first.session, greeting(&elsewhere).await.session);
}

#[tokio::test]
async fn what_happens_is_shown_at_once() {
    let studio = start();
    let mut page = Page::open(&studio).await;
    assert!(matches!(page.next().await, ServerMessage::Hello(_)));
    for index in 0..20 {
        let message = event(&format!("event {index}"));
        let published_at = Instant::now();
        studio.publish(message.clone());
        assert_eq!(page.next().await, message);
        // Some milliseconds in truth; the bound only has to tell pushing from polling.
        assert!(published_at.elapsed() < Duration::from_secs(1));
    }
}

/// The slow page reads nothing while far more is published than its socket can hold.
#[tokio::test]
async fn a_slow_page_holds_up_nobody_and_gets_the_latest() {
    const N_STATES: u32 = 4000;
    let studio = start();
    let mut slow = Page::open(&studio).await;
    let mut quick = Page::open(&studio).await;
    assert!(matches!(quick.next().await, ServerMessage::Hello(_)));

    let started_at = Instant::now();
    let mut publishing = Duration::ZERO;
    let mut quick_seen = 0;
    for index in 1..=N_STATES {
        // 2000 bodies are some 250 kB: 1 GB in all.
        let message = state(f64::from(index), 2000);
        let publish_at = Instant::now();
        studio.publish(message);
        publishing += publish_at.elapsed();
        if index % 400 == 0 {
            assert!(matches!(quick.next().await, ServerMessage::State(_)));
            quick_seen += 1;
        }
    }
    studio.publish(event("end"));
    assert!(publishing < PATIENCE, "publishing took {publishing:?}");
    assert_eq!(quick_seen, 10);
    let received = slow.until_event("end").await;
    let states: Vec<f64> = received
        .iter()
        .filter_map(|message| match message {
            ServerMessage::State(state) => Some(state.time_secs),
            _ => None,
        })
        .collect();
    let elapsed = started_at.elapsed();
    assert_eq!(states.last(), Some(&f64::from(N_STATES)));
    assert!(states.is_sorted(), "never back in time: {states:?}");
    assert!(
        states.len() < 1000,
        "{} states in {elapsed:?}",
        states.len()
    );
}

#[tokio::test]
async fn a_state_that_is_not_finite_is_never_shown() {
    let studio = start();
    studio.publish(state(f64::NAN, 1));
    studio.publish(event("end"));
    let mut page = Page::open(&studio).await;
    let seen = page.until_event("end").await;
    assert_eq!(seen.len(), 1, "only the greeting: {seen:?}");
}
