//! Compiles every shader of `shaders/` to SPIR-V.
//!
//! Each becomes `$OUT_DIR/<stem>.<stage>.spv` and a constant of `$OUT_DIR/shaders.rs`, which also
//! lists them all. `shaders/include/` holds what `#include` finds. A shader's error or warning
//! fails the build with its file and line.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use shaderc::{
    CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, ShaderKind,
    SpirvVersion, TargetEnv,
};

const SHADERS: &str = "shaders";
const INCLUDES: &str = "shaders/include";
/// A chain of includes longer than this is taken for a circle.
const MAX_INCLUDE_DEPTH: usize = 16;

fn main() {
    // Cargo looks at everything below the folder, so that a file that comes or goes counts too.
    println!("cargo::rerun-if-changed={SHADERS}");
    println!("cargo::rerun-if-changed=build.rs");
    if let Err(error) = compile_all() {
        for line in error.to_string().lines().filter(|line| !line.is_empty()) {
            println!("cargo::error={line}");
        }
    }
}

fn compile_all() -> Result<(), Box<dyn Error>> {
    let out_dir = PathBuf::from(env::var("OUT_DIR")?);
    let compiler = Compiler::new()?;
    let options = options()?;
    let mut constants = String::new();
    let mut all = String::new();
    let mut errors = String::new();
    for path in shader_files()? {
        match compile(&compiler, &options, &path) {
            Ok((file, words)) => {
                let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
                fs::write(out_dir.join(format!("{file}.spv")), bytes)?;
                let name = file.replace(['.', '-'], "_").to_uppercase();
                writeln!(constants, "/// SPIR-V of `{SHADERS}/{file}`.")?;
                writeln!(constants, "pub const {name}: &[u32] = &{words:?};")?;
                write!(all, "(\"{file}\", {name}), ")?;
            }
            Err(error) => writeln!(errors, "{error}")?,
        }
    }
    if !errors.is_empty() {
        return Err(errors.into());
    }
    let all = format!(
        "/// Every shader: the name of its file and its SPIR-V.\n\
         pub const ALL: &[(&str, &[u32])] = &[{all}];\n"
    );
    fs::write(out_dir.join("shaders.rs"), constants + &all)?;
    Ok(())
}

/// The files of the shader folder itself, in the order of their names.
fn shader_files() -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let entries = fs::read_dir(SHADERS).map_err(|error| format!("{SHADERS}: {error}"))?;
    let mut files = Vec::new();
    for entry in entries {
        let entry = entry?;
        if entry.file_type()?.is_file() {
            files.push(entry.path());
        }
    }
    files.sort();
    Ok(files)
}

/// Optimised for Vulkan 1.2, with the names of blocks and their members kept for reflection.
fn options() -> Result<CompileOptions<'static>, Box<dyn Error>> {
    let mut options = CompileOptions::new()?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_target_spirv(SpirvVersion::V1_5);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(|name, _, _, depth| {
        if depth > MAX_INCLUDE_DEPTH {
            return Err(format!("{name}: includes itself"));
        }
        let resolved_name = format!("{INCLUDES}/{name}");
        match fs::read_to_string(&resolved_name) {
            Ok(content) => Ok(ResolvedInclude { resolved_name, content }),
            Err(error) => Err(format!("{resolved_name}: {error}")),
        }
    });
    Ok(options)
}

/// The name of the file and its SPIR-V words.
fn compile(
    compiler: &Compiler,
    options: &CompileOptions,
    path: &Path,
) -> Result<(String, Vec<u32>), Box<dyn Error>> {
    let shown = path.display().to_string();
    let kind = match path.extension().and_then(|extension| extension.to_str()) {
        Some("vert") => ShaderKind::Vertex,
        Some("frag") => ShaderKind::Fragment,
        Some("comp") => ShaderKind::Compute,
        _ => return Err(format!("{shown}: not a .vert, .frag or .comp file").into()),
    };
    let source = fs::read_to_string(path).map_err(|error| format!("{shown}: {error}"))?;
    let artifact = compiler.compile_into_spirv(&source, kind, &shown, "main", Some(options))?;
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok((file, artifact.as_binary().to_vec()))
}
