//! What a person teaches of a class: grasps and actions, put and taken away one by one (thesis 6.2.2).
//!
//! Whether a class makes sense as a whole is [`ObjectClass::check`]'s to say.

use std::path::Path;

use crate::{
    ActionKind, ActionSpec, DescriptionError, Form, FormError, Grasp, ObjectClass, Provenance,
    StateInterval,
};

/// A state that is made for an action reaches so far to both sides of its termination, as a share of the joint's range:
/// a joint that stops a little short is there all the same.
const STATE_HALF_WIDTH: f64 = 0.15;

/// Name of the model of a class that is made of a shape.
const MODEL: &str = "model.xml";

impl ObjectClass {
    /// A class made of a shape, and the text of its model, which is to lie beside its `class.toml`.
    ///
    /// # Errors
    /// [`FormError`] if a size is none.
    pub fn of_form(name: &str, form: Form, movable: bool) -> Result<(Self, String), FormError> {
        let class = Self {
            name: name.to_owned(),
            description: String::new(),
            model: MODEL.into(),
            provenance: Provenance::Taught,
            form: Some(form),
            movable,
            yaw_symmetric: form.is_yaw_symmetric(),
            on_floor: false,
            joints: Vec::new(),
            states: Vec::new(),
            grasps: Vec::new(),
            actions: Vec::new(),
        };
        Ok((class, form.to_mjcf(name)?))
    }

    /// Teaches a grasp, or changes the one of that name.
    pub fn put_grasp(&mut self, grasp: Grasp) {
        put(&mut self.grasps, grasp, |grasp| &grasp.name);
    }

    /// Forgets a grasp. False if there is none of that name.
    pub fn remove_grasp(&mut self, name: &str) -> bool {
        remove(&mut self.grasps, |grasp| grasp.name == name)
    }

    /// Teaches an action, or changes the one of that name. Where the state that it brings about is not there, or was
    /// taught, it is made about the termination, as wide as other states of the joint leave room.
    ///
    /// # Errors
    /// [`DescriptionError::Value`] if the termination lies in another state than the action is to bring about. `file` is
    /// where the class lies, for the error.
    pub fn put_action(&mut self, action: ActionSpec, file: &Path) -> Result<(), DescriptionError> {
        let place = self.actions.iter().position(|a| a.name == action.name);
        self.remove_action(&action.name);
        if action.kind == ActionKind::Articulate {
            self.make_state_of(&action, file)?;
        }
        self.actions
            .insert(place.unwrap_or(self.actions.len()), action);
        Ok(())
    }

    /// Forgets an action, and the state that was made for it, if no other needs it. False if there is none of that name.
    pub fn remove_action(&mut self, name: &str) -> bool {
        let is_removed = remove(&mut self.actions, |action| action.name == name);
        let actions = &self.actions;
        self.states.retain(|state| {
            let is_needed = |action: &ActionSpec| action.effect.as_ref() == Some(&state.name);
            state.provenance != Provenance::Taught || actions.iter().any(is_needed)
        });
        is_removed
    }

    fn make_state_of(&mut self, action: &ActionSpec, file: &Path) -> Result<(), DescriptionError> {
        // What is missing here is named by the check of the whole class.
        let (Some(effect), Some(termination)) = (&action.effect, action.termination) else {
            return Ok(());
        };
        let name = action.joint.as_deref().unwrap_or_default();
        let Some(joint) = self.joint(name) else {
            return Ok(());
        };
        let [lower, upper] = joint.range;
        // Pushing goes a little beyond the stop: the joint does not.
        let at = termination.clamp(lower.min(upper), upper.max(lower));
        match self.state_at(name, at) {
            Some(state) if state.name == *effect => return Ok(()),
            Some(state) => {
                return Err(DescriptionError::Value {
                    path: file.to_owned(),
                    field: format!("actions.{}.effect", action.name),
                    found: format!("`{effect}`, with its termination at {termination}"),
                    wanted: format!("`{}`, the state of `{name}` there", state.name),
                });
            }
            None => {}
        }
        if let Some(state) = self.state(effect) {
            let [from, to] = state.range;
            return Err(DescriptionError::Value {
                path: file.to_owned(),
                field: format!("actions.{}.termination", action.name),
                found: termination.to_string(),
                wanted: format!("{from} to {to}, where `{name}` is `{effect}`"),
            });
        }
        let half_width = STATE_HALF_WIDTH * (upper - lower).abs();
        let mut range = [at - half_width, at + half_width];
        for other in self.states.iter().filter(|state| state.joint == name) {
            if other.range[1] < at {
                range[0] = range[0].max(other.range[1]);
            } else {
                range[1] = range[1].min(other.range[0]);
            }
        }
        let (name, joint) = (effect.clone(), name.to_owned());
        self.states.push(StateInterval {
            name,
            joint,
            range,
            provenance: Provenance::Taught,
        });
        Ok(())
    }
}

fn put<T>(list: &mut Vec<T>, value: T, name: impl Fn(&T) -> &String) {
    match list.iter_mut().find(|other| name(other) == name(&value)) {
        Some(place) => *place = value,
        None => list.push(value),
    }
}

fn remove<T>(list: &mut Vec<T>, is_it: impl Fn(&T) -> bool) -> bool {
    let n_before = list.len();
    list.retain(|value| !is_it(value));
    list.len() < n_before
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEVER: &str = r#"
name = "lever"
model = "model.xml"
joints = [{ name = "handle", kind = "revolute", axis = [0, 0, 1], range = [0, 1], link = "lever" }]
states = [{ name = "closed", joint = "handle", range = [-0.1, 0.1] }]
"#;

    fn lever() -> ObjectClass {
        ObjectClass::parse(LEVER, Path::new("class.toml")).unwrap()
    }

    fn action(name: &str, termination: f64, effect: &str) -> ActionSpec {
        let text = format!(
            r#"
            name = "{name}"
            kind = "articulate"
            joint = "handle"
            termination = {termination:?}
            effect = "{effect}"
            "#
        );
        crate::parse_toml(&text, Path::new("action.toml")).unwrap()
    }

    fn put(class: &mut ObjectClass, spec: ActionSpec) -> String {
        let put = class.put_action(spec, Path::new("class.toml"));
        put.map_or_else(|error| error.to_string(), |()| String::new())
    }

    #[test]
    fn a_state_is_made_where_the_action_ends_and_goes_with_it() {
        let mut class = lever();
        assert_eq!(put(&mut class, action("open", 0.9, "open")), "");
        let range = class.state("open").unwrap().range;
        assert!((range[0] - 0.75).abs() < 1e-12 && (range[1] - 1.05).abs() < 1e-12);
        class.check(Path::new("class.toml")).unwrap();

        // Changed, it moves; and it does not reach into what is another state.
        assert_eq!(put(&mut class, action("open", 0.2, "open")), "");
        assert_eq!(class.actions.len(), 1);
        let range = class.state("open").unwrap().range;
        assert!((range[0] - 0.1).abs() < 1e-12 && (range[1] - 0.35).abs() < 1e-12);

        assert!(class.remove_action("open"));
        assert!(!class.remove_action("open"));
        assert_eq!(class, lever());
    }

    #[test]
    fn an_action_that_ends_elsewhere_than_it_says_is_refused() {
        assert_eq!(
            put(&mut lever(), action("open", 0.05, "open")),
            "`class.toml`: `actions.open.effect` is `open`, with its termination at 0.05, expected `closed`, the state of \
             `handle` there"
        );
        assert_eq!(
            put(&mut lever(), action("shut", 0.5, "closed")),
            "`class.toml`: `actions.shut.termination` is 0.5, expected -0.1 to 0.1, where `handle` is `closed`"
        );
    }

    #[test]
    fn numbers_that_are_none_and_actions_that_nothing_can_do_are_refused() {
        let mut class = lever();
        class.put_grasp(
            crate::parse_toml("name = \"top\"\naperture_m = nan", Path::new("g.toml")).unwrap(),
        );
        let error = class.check(Path::new("class.toml")).unwrap_err();
        assert_eq!(
            error.to_string(),
            "`class.toml`: `grasps.top.aperture_m` is NaN, expected a finite number"
        );
        assert!(class.remove_grasp("top"));
        let text = "name = \"tidy\"\nkind = \"pick_place\"\ntarget_class = \"bin\"";
        let spec = crate::parse_toml(text, Path::new("a.toml")).unwrap();
        assert_eq!(put(&mut class, spec), "");
        let error = class.check(Path::new("class.toml")).unwrap_err();
        assert!(error.to_string().contains("not movable"), "{error}");
    }
}
