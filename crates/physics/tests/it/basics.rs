use factotum_physics::{Model, PhysicsError, State};

#[test]
fn a_starved_model_is_an_error_not_an_exit() -> Result<(), PhysicsError> {
    let xml = r#"<mujoco><size memory="3K"/><worldbody>
        <geom type="plane" size="1 1 1"/>
        <body pos="0 0 0.09"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
    </worldbody></mujoco>"#;
    let model = Model::from_mjcf_str(xml)?;
    let mut state = State::new(&model)?;
    let error = (0..10).find_map(|_| state.step().err());
    assert!(
        matches!(error, Some(PhysicsError::Engine { .. })),
        "{error:?}"
    );
    assert!(matches!(state.step(), Err(PhysicsError::Discarded { .. })));
    Ok(())
}
