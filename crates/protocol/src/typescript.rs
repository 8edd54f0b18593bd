//! The page's TypeScript types, rendered from this crate's.

use ts_rs::{Config, TS as _};

use crate::{
    Action, ActionMotion, Activity, Aosm, AosmEdge, AosmObject, Approach, BasePath, Body, BodyPose,
    CatalogueClass, ClassJoint, ClassPart, ClassState, ClientMessage, Contact, Control, Done,
    Drive, Edit, EditAnswer, EditOutcome, EditRequest, Evaluation, Event, EventLevel, Form,
    Geometry, Grasp, Hello, HistoryEntry, JointKind, JointPosition, NavigationRegion, ObjectClass,
    OccupancyMap, Plan, PlanStep, Pose, PosePlanar, Provenance, Role, Scene, SceneSource,
    ServerMessage, Shape, State, Status, StepKind, StepState, TaughtClass, TaughtObject, Teaching,
    Training, Trainings,
};

/// Where the module is committed, from the repository's root.
pub const PATH: &str = "web/src/protocol.ts";

const HEAD: &str = "\
// Generated from crates/protocol; do not edit. To bring it up to date:
//   cargo run -p factotum-protocol --example codegen
";

/// The text of a TypeScript module with every type of the wire.
#[must_use]
pub fn module() -> String {
    let config = Config::new();
    let mut text = format!("{HEAD}\nexport const VERSION = {};\n", crate::VERSION);
    macro_rules! declare {
        ($($ty:ty),* $(,)?) => {$(
            text.push('\n');
            if let Some(docs) = <$ty>::docs() {
                text.push_str(&docs);
            }
            text.push_str("export ");
            text.push_str(&<$ty>::decl(&config));
            text.push('\n');
        )*};
    }
    declare!(
        ServerMessage,
        ClientMessage,
        Drive,
        Hello,
        Role,
        Control,
        Pose,
        PosePlanar,
        Scene,
        SceneSource,
        Body,
        Shape,
        Geometry,
        State,
        BodyPose,
        JointPosition,
        BasePath,
        OccupancyMap,
        Aosm,
        ObjectClass,
        Provenance,
        AosmObject,
        NavigationRegion,
        AosmEdge,
        Plan,
        PlanStep,
        StepKind,
        StepState,
        Status,
        Activity,
        Event,
        EventLevel,
        Done,
        Trainings,
        Training,
        Evaluation,
        Teaching,
        HistoryEntry,
        CatalogueClass,
        TaughtClass,
        ClassPart,
        ClassJoint,
        JointKind,
        ClassState,
        TaughtObject,
        Form,
        Grasp,
        Action,
        ActionMotion,
        Contact,
        Approach,
        EditRequest,
        Edit,
        EditAnswer,
        EditOutcome,
    );
    tidied(&text)
}

/// The text with lines indented by the braces they stand in, and links in comments that mean
/// something to rustdoc only reduced to their names.
fn tidied(text: &str) -> String {
    let mut tidy = String::with_capacity(text.len());
    let mut depth = 0_usize;
    for line in text.lines() {
        let line = line.trim_end();
        let closes = usize::from(line.starts_with(['}', ')']));
        tidy.push_str(&"  ".repeat(depth.saturating_sub(closes)));
        tidy.push_str(&without_links(line));
        tidy.push('\n');
        if !line.trim_start().starts_with(['*', '/']) {
            depth += line.matches('{').count();
            depth = depth.saturating_sub(line.matches('}').count());
        }
    }
    tidy
}

/// The line with each ``[`name`](crate::path)`` replaced by `` `name` ``.
fn without_links(line: &str) -> String {
    let mut plain = String::with_capacity(line.len());
    let mut rest = line;
    while let Some((before, link)) = rest.split_once("[`") {
        let Some((name, after)) = link.split_once("`]") else {
            break;
        };
        plain.push_str(before);
        plain.push('`');
        plain.push_str(name);
        plain.push('`');
        rest = match after
            .strip_prefix("(crate::")
            .and_then(|path| path.split_once(')'))
        {
            Some((_path, after)) => after,
            None => after,
        };
    }
    plain.push_str(rest);
    plain
}
