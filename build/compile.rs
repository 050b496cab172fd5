//! GLSL to SPIR-V, by shaderc.

use super::{INCLUDES, Module, Result, SHADERS, files, glsl, name};
use crate::hash::{FNV_START, fnv1a};
use shaderc::{
    CompileOptions, Compiler, EnvVersion, OptimizationLevel, ResolvedInclude, ShaderKind,
    SpirvVersion, TargetEnv,
};
use std::path::Path;
use std::process::Command;
use std::{env, fs};

/// A chain of includes longer than this is taken for a circle.
const MAX_INCLUDE_DEPTH: usize = 16;

/// Compiles every shader, and leaves in `spirv/` of `out_dir` what `src/gpu/spirv/` is to hold.
pub fn all(out_dir: &Path, constants: String, sources: u64) -> Result<Vec<Module>> {
    let compiler = Compiler::new()?;
    let options = options(constants)?;
    let mut modules = Vec::new();
    let mut errors = String::new();
    for path in files(SHADERS)? {
        match compile(&compiler, &options, &path) {
            Ok(words) => modules.push((name(&path), without_sources(&words))),
            Err(error) => errors += &format!("{error}\n"),
        }
    }
    if !errors.is_empty() {
        return Err(errors.into());
    }
    store(&out_dir.join("spirv"), &modules, sources)?;
    Ok(modules)
}

/// Writes the modules with a manifest into a folder of their own.
fn store(folder: &Path, modules: &[Module], sources: u64) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::create_dir_all(folder)?;
    let mut hash = FNV_START;
    for (file, words) in modules {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        hash = fnv1a(hash, &bytes);
        fs::write(folder.join(format!("{file}.spv")), bytes)?;
    }
    let manifest =
        format!("sources {sources:016x}\nmodules {hash:016x}\ncompiler {}\n", compiler_version());
    fs::write(folder.join("manifest"), manifest)?;
    Ok(())
}

/// The versions of the system's shaderc and optimiser, as far as they are known.
fn compiler_version() -> String {
    let elsewhere =
        ["SHADERC_LIB_DIR", "VULKAN_SDK"].iter().any(|name| env::var_os(name).is_some());
    let version = |library: &str| {
        let output = Command::new("pkg-config").args(["--modversion", library]).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
        (output.status.success() && !text.is_empty()).then_some(text)
    };
    match (elsewhere, version("shaderc"), version("SPIRV-Tools")) {
        (false, Some(shaderc), Some(tools)) => format!("shaderc {shaderc}, SPIRV-Tools {tools}"),
        _ => "unknown".to_owned(),
    }
}

/// Optimised for Vulkan 1.2, with the names of blocks and their members kept for reflection.
fn options(constants: String) -> Result<CompileOptions<'static>> {
    let mut options = CompileOptions::new()?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_2 as u32);
    options.set_target_spirv(SpirvVersion::V1_5);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(move |name, _, _, depth| {
        if depth > MAX_INCLUDE_DEPTH {
            return Err(format!("{name}: includes itself"));
        }
        if name == glsl::FILE {
            return Ok(ResolvedInclude { resolved_name: name.into(), content: constants.clone() });
        }
        let resolved_name = format!("{INCLUDES}/{name}");
        match fs::read_to_string(&resolved_name) {
            Ok(content) => Ok(ResolvedInclude { resolved_name, content }),
            Err(error) => Err(format!("{resolved_name}: {error}")),
        }
    });
    Ok(options)
}

/// The SPIR-V words of a shader.
fn compile(compiler: &Compiler, options: &CompileOptions, path: &Path) -> Result<Vec<u32>> {
    let shown = path.display().to_string();
    let kind = match path.extension().and_then(|extension| extension.to_str()) {
        Some("vert") => ShaderKind::Vertex,
        Some("frag") => ShaderKind::Fragment,
        Some("comp") => ShaderKind::Compute,
        _ => return Err(format!("{shown}: not a .vert, .frag or .comp file").into()),
    };
    let source = fs::read_to_string(path).map_err(|error| format!("{shown}: {error}"))?;
    let artifact = compiler.compile_into_spirv(&source, kind, &shown, "main", Some(options))?;
    Ok(artifact.as_binary().to_vec())
}

/// A module without the text of its sources and the lines that its instructions come from (SPIR-V
/// specification, sections 2.3 and 3.49.2).
fn without_sources(words: &[u32]) -> Vec<u32> {
    const HEADER: usize = 5;
    // OpSourceContinued, OpSource, OpSourceExtension, OpString, OpLine, OpNoLine, OpModuleProcessed.
    const SOURCES: [u32; 7] = [2, 3, 4, 7, 8, 317, 330];
    let (header, mut rest) = words.split_at(HEADER);
    let mut kept = header.to_vec();
    while let Some(&first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        if !SOURCES.contains(&(first & 0xffff)) {
            kept.extend(instruction);
        }
        rest = after;
    }
    kept
}
