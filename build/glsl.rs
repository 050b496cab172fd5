//! The constants of `src/constants.rs` in GLSL.

use std::fmt::Write as _;

/// The name by which shaders include them.
#[cfg(feature = "shaderc")]
pub const FILE: &str = "constants.glsl";

/// The text of that file.
pub fn constants() -> String {
    let mut text = "#ifndef KLIEG_CONSTANTS\n#define KLIEG_CONSTANTS\n".to_owned();
    shared::write(&mut text);
    text + "#endif\n"
}

/// A value that GLSL knows too.
trait Glsl {
    const TYPE: &str;
    fn value(&self) -> String;
}

impl Glsl for u32 {
    const TYPE: &str = "uint";
    fn value(&self) -> String {
        format!("{self}u")
    }
}

impl Glsl for f32 {
    const TYPE: &str = "float";
    fn value(&self) -> String {
        format!("{self:?}") // the shortest that gives the same bits, with a point or an exponent
    }
}

impl Glsl for [f32; 3] {
    const TYPE: &str = "vec3";
    fn value(&self) -> String {
        let [x, y, z] = self.map(|x| x.value());
        format!("vec3({x}, {y}, {z})")
    }
}

fn declare<T: Glsl>(text: &mut String, name: &str, value: &T) {
    let _ = writeln!(text, "const {} {name} = {};", T::TYPE, value.value()); // cannot fail
}

/// As in `src/lib.rs`, with a function that writes them all.
macro_rules! constants {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $value:expr;)*) => {
        $($(#[$doc])* const $name: $type = $value;)*

        pub fn write(text: &mut String) {
            $(super::declare(text, stringify!($name), &$name);)*
        }
    };
}

#[path = "../src/constants.rs"]
mod shared;
