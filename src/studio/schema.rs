//! The page's types are made of the server's.

use super::answers::{
    Answer, Defaults, Device, Fineness, Judged, Mapped, Measured, NamedCamera, Opened, Progress,
    SceneInfo, TermInfo, Titled,
};
use super::messages::{
    Action, Alternatives, Camera, Document, Draw, Follow, Light, Look, Map, Open, Pick, Place,
    Preset, Request, Save, Search, Steer, Targets, What,
};
use crate::design::{Intent, Mood};
use std::path::Path;
use ts_rs::{Config, TS};

/// The declarations, in an order in which each knows those before it.
macro_rules! declarations {
    ($($name:ident),*) => {{
        let config = Config::default();
        let mut text = String::from(
            "// Made of src/studio/ by its tests (KLIEG_WRITE_MESSAGES=1 writes it anew).\n\n",
        );
        $(text += &format!("export {}\n", $name::decl(&config));)*
        text
    }};
}

#[test]
fn the_page_s_types_are_the_server_s() {
    let text = declarations!(
        Camera,
        Light,
        Targets,
        Mood,
        Intent,
        Look,
        Document,
        Save,
        Action,
        What,
        Open,
        Draw,
        Map,
        Place,
        Pick,
        Search,
        Alternatives,
        Preset,
        Follow,
        Steer,
        Request,
        Fineness,
        NamedCamera,
        SceneInfo,
        Defaults,
        Titled,
        TermInfo,
        Device,
        Opened,
        Measured,
        Judged,
        Mapped,
        Progress,
        Answer
    );
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("studio/src/messages.ts");
    if std::env::var_os("KLIEG_WRITE_MESSAGES").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let there = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(there == text, "{} is out of date: KLIEG_WRITE_MESSAGES=1 writes it", path.display());
}
