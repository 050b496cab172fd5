//! The terms, a file each. A new one joins them with its line in [`TERMS`], and with its formula for the
//! devices in `shaders/include/terms/`.

macro_rules! table {
    ($($name:ident),* $(,)?) => {
        $(pub mod $name;)*

        /// klieg's own terms, in the order of all lists. Those of the paper come first.
        pub static TERMS: &[&super::Term] = &[$(&$name::TERM),*];
    };
}

table!(
    edge, mean, grad, var, hist, detail, range, burnt, unlit, relief, direction, target, outline,
    spread, example, entropy
);
