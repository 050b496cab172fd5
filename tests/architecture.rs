//! The arrows between the rooms of `src/`: each room knows only those before it. Read from the paths in the
//! sources themselves; comments and test modules do not count.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::BTreeSet;
use std::iter::Peekable;
use std::path::Path;

/// Rooms of the crate in their order; those of one row do not know each other. `gpu` measures with the
/// references of `cpu`.
const ROOMS: [&[&str]; 17] = [
    &["error", "constants"],
    &["hash"],
    &["math"],
    &["lighting"],
    &["scene"],
    &["objective"],
    &["evaluate"],
    &["cpu"],
    &["render"],
    &["gpu"],
    &["optimize"],
    &["design"],
    &["study"],
    &["report"],
    &["session"],
    &["studio"],
    &["c", "cli"],
];

/// The only rooms that these know.
const ONLY: [(&str, &[&str]); 1] = [("optimize", &["error", "math"])];

/// Rooms of `gpu`, likewise.
const GPU_ROOMS: [&[&str]; 7] = [
    &["vulkan"],
    &["layout", "shaders"],
    &["scene"],
    &["view"],
    &["measure"],
    &["evaluator", "readback"],
    &["engine"],
];

/// A path of modules, without `crate`.
type Module = Vec<String>;

/// What a source refers to.
#[derive(Default)]
struct References {
    /// Absolute paths inside the crate.
    paths: BTreeSet<Module>,
    /// Test modules in files of their own.
    tests: Vec<Module>,
}

type Tokens = Peekable<proc_macro2::token_stream::IntoIter>;

fn is_punct(token: Option<&TokenTree>, mark: char) -> bool {
    matches!(token, Some(TokenTree::Punct(punct)) if punct.as_char() == mark)
}

/// Goes past `::`, if that is next.
fn colons(tokens: &mut Tokens) -> bool {
    if !is_punct(tokens.peek(), ':') {
        return false;
    }
    let mut ahead = tokens.clone();
    ahead.next();
    let double = is_punct(ahead.peek(), ':');
    if double {
        ahead.next();
        *tokens = ahead;
    }
    double
}

impl References {
    /// Those of a source that is the module `module`.
    fn of(source: &str, module: &[String]) -> Self {
        let tokens: TokenStream = source.parse().expect("Rust");
        let mut references = Self::default();
        references.read(tokens, module);
        references
    }

    fn read(&mut self, tokens: TokenStream, module: &[String]) {
        let mut tokens = tokens.into_iter().peekable();
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Punct(punct) if punct.as_char() == '#' => {
                    if is_punct(tokens.peek(), '!') {
                        tokens.next();
                    }
                    if let Some(TokenTree::Group(attribute)) = tokens.next()
                        && attribute.stream().to_string().replace(' ', "") == "cfg(test)"
                    {
                        self.skip(&mut tokens, module);
                    }
                }
                TokenTree::Ident(word) if word == "mod" => self.inner(&mut tokens, module),
                TokenTree::Ident(word) => {
                    let base = match word.to_string().as_str() {
                        "crate" => Some(Vec::new()),
                        "self" => Some(module.to_vec()),
                        "super" => Some(module[..module.len().saturating_sub(1)].to_vec()),
                        _ => None,
                    };
                    if let Some(base) = base
                        && colons(&mut tokens)
                    {
                        self.path(base, &mut tokens);
                    }
                }
                TokenTree::Group(group) => self.read(group.stream(), module),
                _ => {}
            }
        }
    }

    /// The body of a module inside the file.
    fn inner(&mut self, tokens: &mut Tokens, module: &[String]) {
        let Some(TokenTree::Ident(name)) = tokens.next() else { return };
        if let Some(TokenTree::Group(body)) = tokens.peek() {
            let (body, inner) = (body.stream(), [module, &[name.to_string()]].concat());
            tokens.next();
            self.read(body, &inner);
        }
    }

    /// Goes past an item for tests alone.
    fn skip(&mut self, tokens: &mut Tokens, module: &[String]) {
        let mut before = None;
        while let Some(token) = tokens.next() {
            match token {
                TokenTree::Punct(punct) if punct.as_char() == ';' => return,
                TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => return,
                TokenTree::Ident(word)
                    if before.as_deref() == Some("mod") && is_punct(tokens.peek(), ';') =>
                {
                    self.tests.push([module, &[word.to_string()]].concat());
                }
                TokenTree::Ident(word) => before = Some(word.to_string()),
                _ => {}
            }
        }
    }

    /// Notes a path that goes on from `base`, all branches of it.
    fn path(&mut self, mut base: Module, tokens: &mut Tokens) {
        loop {
            match tokens.peek() {
                Some(TokenTree::Ident(word)) if word == "super" => {
                    base.pop();
                }
                Some(TokenTree::Ident(word)) if word == "self" => {}
                Some(TokenTree::Ident(word)) => base.push(word.to_string()),
                Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                    let mut branches = group.stream().into_iter().peekable();
                    tokens.next();
                    while branches.peek().is_some() {
                        self.path(base.clone(), &mut branches);
                        // What is left of the branch: `as` another name.
                        while branches.next().is_some_and(|next| !is_punct(Some(&next), ',')) {}
                    }
                    return;
                }
                _ => break,
            }
            tokens.next();
            if !colons(tokens) {
                break;
            }
        }
        self.paths.insert(base);
    }
}

/// The row of a room.
fn row(rooms: &[&[&str]], name: &str) -> Option<usize> {
    rooms.iter().position(|row| row.contains(&name))
}

/// The arrows that run backwards from the room of `module` among `rooms`, whose names stand at `depth`.
fn backwards(
    rooms: &[&[&str]],
    module: &[String],
    depth: usize,
    paths: &BTreeSet<Module>,
) -> Vec<String> {
    let Some(from) = module.get(depth) else { return Vec::new() };
    // The crate's root and a room's own `mod.rs` name what is inside.
    let Some(own) = row(rooms, from) else { return vec![format!("{from} is no room of the list")] };
    let allowed = ONLY.iter().find(|(room, _)| depth == 0 && room == from).map(|(_, to)| to);
    let wrong = |path: &&Module| {
        let inside = path.len() > depth && path[..depth] == module[..depth];
        let Some(to) = path.get(depth).filter(|to| inside && *to != from) else { return false };
        // The root's own names are those of `error`, and of other crates.
        let Some(row) = row(rooms, to) else { return false };
        row >= own || allowed.is_some_and(|allowed| !allowed.contains(&to.as_str()))
    };
    let arrow = |path: &Module| format!("{} -> {}", module.join("::"), path.join("::"));
    paths.iter().filter(wrong).map(arrow).collect()
}

/// Everything wrong with a source that is the module `module`.
fn faults(source: &str, module: &[String]) -> Vec<String> {
    let References { paths, .. } = References::of(source, module);
    let mut faults = backwards(&ROOMS, module, 0, &paths);
    if module.first().is_some_and(|room| room == "gpu") {
        faults.extend(backwards(&GPU_ROOMS, module, 1, &paths));
    }
    faults
}

fn module(path: &Path) -> Module {
    let stem = path.with_extension("");
    let parts = stem.iter().map(|part| part.to_string_lossy().into_owned());
    parts.filter(|part| !["mod", "lib", "main"].contains(&part.as_str())).collect()
}

/// All sources below a folder of `src`, with their modules.
fn sources(folder: &Path, found: &mut Vec<(Module, String)>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let module = module(path.strip_prefix(&root).unwrap());
            found.push((module, std::fs::read_to_string(&path).unwrap()));
        }
    }
}

#[test]
fn no_arrow_runs_backwards() {
    let mut all = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut all);
    let tests: Vec<Module> =
        all.iter().flat_map(|(module, source)| References::of(source, module).tests).collect();
    let of_tests = |module: &Module| tests.iter().any(|test| module.starts_with(test));
    let faults: Vec<String> = all
        .iter()
        .filter(|(module, _)| !of_tests(module))
        .flat_map(|(module, source)| faults(source, module))
        .collect();
    assert!(faults.is_empty(), "arrows that run backwards:\n{}", faults.join("\n"));
    // What is judged is there: every room, and paths in it.
    for room in ROOMS.concat() {
        assert!(all.iter().any(|(module, _)| module.first().is_some_and(|first| first == room)));
    }
}

#[test]
fn planted_arrows_are_found() {
    let found = |module: &str, source: &str| {
        let module: Module = module.split("::").map(Into::into).collect();
        faults(source, &module)
    };
    for (module, source) in [
        ("lighting", "use crate::scene::Scene;"),
        ("lighting::genome", "use super::super::scene;"),
        ("lighting::genome", "use crate::{Error, math::range::Range, objective as terms};"),
        ("lighting::genome", "fn f() { let x = vec![crate::objective::maps::Maps::default()]; }"),
        ("scene::load", "mod inner { use super::super::super::cpu::maps; }"),
        ("cpu", "use crate::gpu::Context;"),
        ("optimize::genetic", "use crate::lighting::Light;"),
        ("optimize", "use crate::{error, design::run};"),
        ("design::race", "fn f(x: &crate::study::Subject<'_>) {}"),
        ("report::json", "use crate::{study, cli::config};"),
        ("cli::design", "use crate::c::error;"),
        ("c::error", "use crate::cli;"),
        ("gpu::vulkan::context", "use crate::gpu::layout;"),
        ("gpu::vulkan", "use super::view::maps;"),
        ("gpu::layout", "use super::shaders;"),
        ("gpu::view", "use crate::gpu::{scene, measure::tiles};"),
        ("gpu::measure::tiles", "use super::super::engine;"),
        ("gpu::scene", "use super::cellar;\nuse crate::gpu::evaluator;"),
        ("cellar", "use crate::error;"),
    ] {
        assert_eq!(found(module, source).len(), 1, "{module}: {source}");
    }
    for (module, source) in [
        ("lighting", "/// [`crate::scene`]\nuse crate::{Error, Result, math};"),
        ("lighting", "#[cfg(test)]\nmod tests { use crate::scene::Scene; }"),
        ("lighting", "#[cfg(test)]\nuse crate::scene;\n#[cfg(test)]\n#[path = \"x\"]\nmod tests;"),
        ("lighting", "// crate::scene\nconst X: &str = \"crate::scene::Scene\";"),
        ("optimize::genetic", "use super::{Best, descent};\nuse crate::math::range::Range;"),
        ("gpu", "mod engine;\npub use engine::surface::X;"),
        ("gpu::measure::tiles", "use super::pixels;\nuse crate::gpu::vulkan;\nuse crate::scene;"),
        ("cli::design", "pub(in crate::cli) fn f() -> crate::report::Staging {}"),
    ] {
        assert_eq!(found(module, source), Vec::<String>::new(), "{module}: {source}");
    }
    let file = References::of("#[cfg(test)]\nmod testing;", &["gpu".into()]);
    assert_eq!(file.tests, [["gpu", "testing"]]);
}
