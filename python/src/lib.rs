//! The native module of klieg's Python package, which `python/klieg/` wraps: it takes plain values and arrays, and
//! leaves names, defaults and documentation to Python. `python/klieg/_klieg.pyi` has its types.

mod design;
mod device;
mod error;
mod evaluator;
mod light;
mod log;
mod scene;
mod settings;
mod view;

/// klieg's native module.
#[pyo3::pymodule]
mod _klieg {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::design::{Design, Progress, design};
    #[pymodule_export]
    use super::device::{Device, devices};
    #[pymodule_export]
    use super::evaluator::Evaluator;
    #[pymodule_export]
    use super::light::Light;
    #[pymodule_export]
    use super::scene::{Scene, SceneBuilder};
    #[pymodule_export]
    use super::settings::{Settings, optimizers, profiles, terms};
    #[pymodule_export]
    use super::view::View;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::log::listen();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
